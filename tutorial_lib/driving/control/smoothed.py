"""C with smoothed waypoints: it averages what C_WP predicts over the last steps (not in the paper).

C_WP predicts each waypoint from one image, and errs a little differently each time. Kept in the
frame of the odometry, which drifts little within a second, the predictions can be averaged.
"""

import numpy as np

from tutorial_lib.driving.control.composed import checked_robots
from tutorial_lib.interfaces import Controller, Observation, Robots, Targets, WaypointPredictor
from tutorial_lib.se2 import Array, to_local, to_world
from tutorial_lib.validation import number, with_methods

SHARE = 0.3
"""Of the newest waypoint in the average, whose memory is about a third of a second."""


class SmoothedPolicy:
    """A `Policy` with memory: each robot drives to the moving average of its waypoints."""

    def __init__(
        self,
        predictor: WaypointPredictor,
        controller: Controller,
        targets: Targets,
        share: float = SHARE,
    ) -> None:
        """Set out, with nothing to average yet.

        Args:
            predictor: C_WP.
            controller: C_RMP.
            targets: N of them; an array of indices selects from them.
            share: of the newest prediction in the average, above 0; with 1 nothing is smoothed.

        Raises:
            InputError: when the share is not within 0 and 1.
        """
        self.predictor = with_methods("predictor", predictor, "predict")
        self.controller = with_methods("controller", controller, "act")
        self.targets, self.share = targets, number("share", share, above=0, most=1)
        self._averages = np.empty((0, 2))  # of each robot, in the frame of the odometry

    def act(self, observations: Observation, robots: Robots) -> Array:
        """Actions (M, 2) of the robots (M,)."""
        robots = checked_robots(observations, robots, self.targets)
        predicted, _ = self.predictor.predict(observations, self.targets[robots])
        newest = to_world(observations.odometry, predicted)
        missing = max(int(np.max(robots, initial=-1)) + 1 - len(self._averages), 0)
        self._averages = np.pad(self._averages, ((0, missing), (0, 0)), constant_values=np.nan)
        before = self._averages[robots]
        before = np.where(np.isnan(before), newest, before)
        average = before + self.share * (newest - before)
        self._averages[robots] = average
        return self.controller.act(observations, to_local(observations.odometry, average))
