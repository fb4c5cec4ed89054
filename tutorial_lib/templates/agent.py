"""A whole agent (`interfaces.Agent`): learns from drives, then sends robots to images."""

from tutorial_lib.agents import MengAgent
from tutorial_lib.learning import ReachabilityNetwork, WaypointNetwork
from tutorial_lib.topology import MapSettings


class Mine:
    """Meng's agent, whose map has edges of a lower probability, too."""

    def __init__(self):
        predictor, reachability = WaypointNetwork("waypoint_k5"), ReachabilityNetwork("reach_k5")
        settings = MapSettings(p_edge=0.95)
        self.usual = MengAgent(predictor=predictor, reachability=reachability, settings=settings)

    def learn(self, experiences):
        self.usual.learn(experiences)

    def start(self, goals):
        return self.usual.start(goals)
