"""A planner (`interfaces.Planner`): from what the robot sees to a goal, over the map."""

from dataclasses import replace

from tutorial_lib.topology import DijkstraPlanner


class Mine:
    """Takes the most probable path, but refuses one with a doubtful step."""

    def __init__(self):
        self.usual = DijkstraPlanner()

    def plan(self, observation, goals, topomap, excluded=()):
        found = self.usual.plan(observation, goals, topomap, excluded)
        if min(found.probabilities, default=1.0) < 0.6:
            return replace(found, refusal="one of its steps is below 0.6")
        return found
