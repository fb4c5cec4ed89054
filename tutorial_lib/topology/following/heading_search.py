"""Turning in place to the heading of an anchor, since waypoints lead only to its position.

The next anchor was chosen for a robot with that heading. Where the path turns sharply, a robot that
only reaches the position may see nothing of the next anchor.
"""

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.geometry import Array
from tutorial_lib.world.simulation import STEP

ASIDE = 1.0
"""Metres to the side of a waypoint that makes a car turn as sharply as it can."""
_FAR = 0.8  # metres from the anchor; a car that turns drifts away and must come back
_WORSE = 0.08  # overlap lost since the best, from which on it turns to the other side
_NEARER = 0.02  # metres that count as progress


class HeadingSearch:
    """How N robots at their active anchors search for the anchors' headings.

    A robot at an anchor with a small overlap turns to one side as long as the overlap grows, and to
    the other side when it shrinks.

    Attributes:
        side: (N,) 1 to the left, -1 to the right, 0 while it does not turn.
        tried: (N,) seconds in which a robot came no nearer to its anchor.
    """

    def __init__(self, robots: int) -> None:
        """Begin with so many robots that do not turn."""
        self.side, self.tried = np.zeros(robots, dtype=int), np.zeros(robots)
        self._overlap, self._gap = np.zeros(robots), np.full(robots, np.inf)

    def begin(self, robots: NDArray[np.intp]) -> None:
        """Start again with another anchor."""
        self.side[robots], self.tried[robots], self._gap[robots] = 0, 0.0, np.inf

    def stop(self, robots: NDArray[np.intp]) -> None:
        """Stop turning for now."""
        self.side[robots] = 0

    def decide(
        self,
        robots: NDArray[np.intp],
        wants: NDArray[np.bool_],
        at: NDArray[np.bool_],
        gap: Array,
        overlap: Array,
        first: NDArray[np.intp],
    ) -> None:
        """Decide which robots turn, and to which side.

        Args:
            robots: (M,) their indices.
            wants: (M,) has another heading than its anchor, and should not.
            at: (M,) is at its anchor.
            gap: (M,) metres to the anchor.
            overlap: (M,) with it.
            first: (M,) the side to try first.
        """
        nearer = gap < self._gap[robots] - _NEARER
        self._gap[robots] = np.where(nearer, gap, self._gap[robots])
        self.tried[robots] = np.where(nearer, 0.0, self.tried[robots] + STEP)
        side, best = self.side[robots], self._overlap[robots]
        begins = wants & at & (side == 0)
        goes_on = wants & (gap < _FAR) & (side != 0)
        worse = goes_on & (overlap < best - _WORSE)
        side = np.where(worse, -side, side)
        self.side[robots] = np.where(begins, first, np.where(goes_on, side, 0))
        self._overlap[robots] = np.where(begins | worse, overlap, np.maximum(best, overlap))

    def waypoints(self, robots: NDArray[np.intp], waypoints: Array) -> Array:
        """Waypoints (M, 2); for robots that turn, a point to their side instead."""
        side = self.side[robots]
        beside = np.stack([np.zeros(len(robots)), ASIDE * side], axis=1)
        return np.where((side != 0)[:, None], beside, waypoints)
