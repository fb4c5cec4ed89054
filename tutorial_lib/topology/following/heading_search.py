"""Turning to look the way an anchor does, since waypoints lead to its place and tell no heading.

The next anchor was chosen for a robot that looks that way. Where the trail turns sharply, or begins
with turning round, who only came to the place may see nothing of what comes next.
"""

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.geometry import Array
from tutorial_lib.world.simulation import STEP

ASIDE = 1.0
"""Metres of a waypoint to the side, for which a car turns as sharply as it can."""
_FAR = 0.8  # metres from the anchor; a car that turns drifts away and must come back
_WORSE = 0.08  # overlap lost since the best, from which on it turns to the other side
_NEARER = 0.02  # metres that count as progress


class HeadingSearch:
    """How N robots try to be where their active anchors are, and to look the same way.

    A robot at an anchor that sees little of what was seen there turns to one side for as long as
    the overlap grows, and to the other side when it shrinks.

    Attributes:
        side: (N,) 1 to the left, -1 to the right, 0 for who does not turn.
        tried: (N,) seconds in which a robot has not come nearer to its anchor.
    """

    def __init__(self, robots: int) -> None:
        """Begin with so many robots that do not turn."""
        self.side, self.tried = np.zeros(robots, dtype=int), np.zeros(robots)
        self._overlap, self._gap = np.zeros(robots), np.full(robots, np.inf)

    def begin(self, robots: NDArray[np.intp]) -> None:
        """Begin anew, with another anchor."""
        self.side[robots], self.tried[robots], self._gap[robots] = 0, 0.0, np.inf

    def stop(self, robots: NDArray[np.intp]) -> None:
        """Turn no more, for now."""
        self.side[robots] = 0

    def judge(
        self,
        robots: NDArray[np.intp],
        wants: NDArray[np.bool_],
        at: NDArray[np.bool_],
        gap: Array,
        overlap: Array,
        first: NDArray[np.intp],
    ) -> None:
        """Decide who turns, and to which side.

        Args:
            robots: (M,) their numbers.
            wants: (M,) who looks another way than its anchor, and should not.
            at: (M,) who is at its anchor.
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
        """Waypoints (M, 2), but beside them for robots that turn."""
        side = self.side[robots]
        beside = np.stack([np.zeros(len(robots)), ASIDE * side], axis=1)
        return np.where((side != 0)[:, None], beside, waypoints)
