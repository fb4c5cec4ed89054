"""Following trails of anchors by sight (Meng 2020, III-H), for a fleet."""

from __future__ import annotations

from dataclasses import dataclass, field

from numpy.typing import ArrayLike

from tutorial_lib.interfaces import Controller, Reachability, WaypointPredictor
from tutorial_lib.topology.following.anchor_paths import AnchorPaths
from tutorial_lib.topology.following.run import Run
from tutorial_lib.topology.following.transitions import FollowerSettings


@dataclass(frozen=True)
class Follower:
    """Follows trails; `begin` starts a run, which remembers.

    Attributes:
        predictor: C_WP, tells waypoints and overlaps.
        controller: C_RMP, drives to waypoints.
        reachability: RE.
        settings: when they are believed.
    """

    predictor: WaypointPredictor
    controller: Controller
    reachability: Reachability
    settings: FollowerSettings = field(default_factory=FollowerSettings)

    def begin(self, trails: AnchorPaths, starts: ArrayLike | None = None) -> Run:
        """Set out on trails.

        Args:
            trails: one for each of N robots.
            starts: (N,) the anchor to drive to first, where it is known; -1 where it must be
                searched for, as everywhere unless given.

        Raises:
            InputError: when a start is beyond its trail.
        """
        parts = (self.predictor, self.controller, self.reachability, self.settings)
        return Run(trails, starts, *parts)
