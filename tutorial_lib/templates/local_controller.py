"""A local controller, C (`interfaces.LocalController`): from image and target to an action."""

from tutorial_lib.driving import RMPController
from tutorial_lib.learning import WaypointNetwork


class Mine:
    """Drives to the waypoint that a network predicts, by the laser."""

    def __init__(self):
        self.predictor, self.controller = WaypointNetwork("waypoint_k2"), RMPController()
        self.view, self.k = self.predictor.view, self.predictor.k

    def prepare(self, contexts):
        return self.predictor.prepare(contexts)

    def act(self, observations, targets):
        waypoints, _ = self.predictor.predict(observations, targets)
        return self.controller.act(observations, waypoints)
