"""What a follower remembers of its robots."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.geometry import Array
from tutorial_lib.topology.following.heading_search import HeadingSearch
from tutorial_lib.topology.following.transitions import State


@dataclass(eq=False)
class FollowerState:
    """The memory of N robots that follow paths of anchors.

    Attributes:
        state: (N,) a `State` each.
        active: (N,) place along the path of the anchor that is driven to; -1 in Search.
        visited: (N,) place of the anchor last visited, -1 for none.
        waypoints: (N, 2) metres in the frame of the odometry; not a number before the first.
        stalled: (N,) seconds without progress that still count.
        calm: (N,) seconds of progress in a row, in Follow.
        width: (N,) anchors on either side of the active one that a lookout reaches.
        sighted: (N,) place of the anchor sighted in dead reckoning, -1 for none.
        streak: (N,) steps in a row with that anchor in sight, or at the goal.
        looked: (N,) has turned all around at the goal.
        heading: the search for the heading of an anchor.
    """

    state: NDArray[np.intp]
    active: NDArray[np.intp]
    visited: NDArray[np.intp]
    waypoints: Array
    stalled: Array
    calm: Array
    width: NDArray[np.intp]
    sighted: NDArray[np.intp]
    streak: NDArray[np.intp]
    looked: NDArray[np.bool_]
    heading: HeadingSearch

    @classmethod
    def at(cls, active: NDArray[np.intp]) -> FollowerState:
        """Robots that drive to the anchors `active` (N,), or search where that is -1."""
        count = len(active)
        return cls(
            state=np.where(active < 0, State.SEARCH, State.FOLLOW),
            active=active,
            visited=np.maximum(active - 1, -1),
            waypoints=np.full((count, 2), np.nan),
            stalled=np.zeros(count),
            calm=np.zeros(count),
            width=np.zeros(count, dtype=int),
            sighted=np.full(count, -1),
            streak=np.zeros(count, dtype=int),
            looked=np.zeros(count, dtype=bool),
            heading=HeadingSearch(count),
        )

    @property
    def done(self) -> NDArray[np.bool_]:
        """(N,) arrived."""
        return self.state == State.DONE

    @property
    def lost(self) -> NDArray[np.bool_]:
        """(N,) gave up."""
        return self.state == State.LOST

    @property
    def over(self) -> NDArray[np.bool_]:
        """(N,) stands still for good."""
        return self.done | self.lost

    def enter(self, robots: NDArray[np.intp], state: State) -> None:
        """Change the state of robots; what is counted within a state starts again."""
        self.state[robots], self.calm[robots] = state, 0.0
        self.streak[robots], self.sighted[robots] = 0, -1
        self.width[robots] = 0
        self.heading.stop(robots)

    def follow_from_start(self, robot: int) -> None:
        """Let a robot follow a new path from its first anchor on."""
        one = np.array([robot])
        self.enter(one, State.FOLLOW)
        self.active[robot], self.visited[robot] = 0, -1
        self.stalled[robot], self.waypoints[robot] = 0.0, np.nan
        self.looked[robot] = False
        self.heading.begin(one)
