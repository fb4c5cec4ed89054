"""Reachability by geometry instead of rollouts: the label of LTVN, for a car.

A pair of poses is reachable where a robot could judge it from its two images and a simple
controller could drive it (*Lifelong Topological Visual Navigation*, Reachability and Waypoint
Prediction). No robot drives, so that millions of pairs have labels in minutes.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.data.reachability_pairs import ReachabilityPairs
from tutorial_lib.geometry import Array
from tutorial_lib.learning.labels import in_clear_sight
from tutorial_lib.se2 import relative, wrap
from tutorial_lib.validation import alike, floats, instance, number
from tutorial_lib.world.raycast import Raycaster

HERE = 0.3
"""Metres within which a target is reached."""


@dataclass(frozen=True)
class AnalyticLabel:
    """Thresholds of the label; those of the paper are not published.

    Attributes:
        overlap: L_min, share of the first view that the second sees as well, at least.
        ratio: R_max, geodesic over straight metres, at most.
        distance: E_max, metres to the target, at most.
        yaw: Theta_max, radians between both headings, at most.
        bearing: radians off the robot's heading at which the target may be. In the paper the target
            must be visible; a car must be able to drive there forwards, too (ours). A target within
            `HERE` is reached already, wherever it is.
        arc: radians by which the heading may differ from that at the end of the one arc that leads
            to the target's position, ``|yaw - 2 bearing|``; infinite asks nothing (ours).
    """

    overlap: float = 0.2
    ratio: float = 1.3
    distance: float = 3.0
    yaw: float = float(np.deg2rad(60.0))
    bearing: float = float(np.deg2rad(60.0))
    arc: float = np.inf

    def __post_init__(self) -> None:
        number("overlap", self.overlap, least=0.0, most=1.0)
        number("ratio", self.ratio, least=1.0)
        number("distance", self.distance, above=0.0)
        for name in ("yaw", "bearing"):
            number(name, getattr(self, name), above=0.0, most=np.pi)
        if self.arc != np.inf:
            number("arc", self.arc, above=0.0)

    def terms(
        self, caster: Raycaster, pairs: ReachabilityPairs, goals: Array
    ) -> dict[str, NDArray[np.bool_]]:
        """Which of the label's conditions hold for N pairs.

        Args:
            caster: the walls.
            pairs: starts, overlaps and geodesics.
            goals: (N, 3) poses of the targets.

        Returns:
            (N,) of each condition, by its name: "overlap", "distance", "yaw", "bearing", "arc",
            "sight" (the target's position is in free sight) and "ratio".
        """
        instance("caster", caster, Raycaster)
        instance("pairs", pairs, ReachabilityPairs)
        goals = floats("goals", goals, ("N", 3))
        alike(goals=goals, starts=pairs.starts)
        seen = relative(pairs.starts, goals)
        metres = np.hypot(seen[:, 0], seen[:, 1])
        holds = {
            "overlap": pairs.overlap[:, 0] > self.overlap,
            "distance": metres < self.distance,
            "yaw": np.abs(seen[:, 2]) < self.yaw,
            "bearing": (metres < HERE) | (np.abs(np.arctan2(*seen[:, 1::-1].T)) < self.bearing),
            "arc": (metres < HERE) | (off_arc(seen) < self.arc),
            # The grid measures a path between cells: on short ones half a cell is no detour.
            "ratio": pairs.geodesic < self.ratio * metres + _GRID,
        }
        holds["sight"] = in_sight = holds["distance"].copy()
        near = np.flatnonzero(in_sight)
        in_sight[near] = in_clear_sight(caster, pairs.starts[near, :2], goals[near, :2])
        return holds

    def __call__(
        self, caster: Raycaster, pairs: ReachabilityPairs, goals: Array
    ) -> NDArray[np.bool_]:
        """(N,) whether all conditions hold; see `terms`."""
        return np.logical_and.reduce(list(self.terms(caster, pairs, goals).values()))


_GRID = 0.1  # metres


def off_arc(seen: Array) -> Array:
    """(N,) radians by which poses `seen` (N, 3) from a robot turn off the arc that leads to them.

    An arc from the robot's heading to a point at `bearing` ends with the heading 2 bearing; the
    nearer a pose is to the robot, the less is left to correct the rest.

    >>> off_arc(np.array([[1.0, 0.0, 0.0], [1.0, 1.0, np.pi / 2], [1.0, 0.0, 0.5]])).round(2)
    array([0. , 0. , 0.5])
    """
    seen = floats("seen", seen, ("N", 3))
    return np.abs(wrap(seen[:, 2] - 2.0 * np.arctan2(seen[:, 1], seen[:, 0])))
