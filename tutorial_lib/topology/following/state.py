"""What a follower remembers of its robots."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.geometry import Array
from tutorial_lib.topology.following.heading_search import HeadingSearch
from tutorial_lib.topology.following.transitions import FollowerSettings, State
from tutorial_lib.world.simulation import STEP


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
        trusted: (N,) RE of the active anchor in the last step; not a number if it was not queried.
        doubted: (N,) seconds since RE fell at once; 0 without a doubt.
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
    trusted: Array
    doubted: Array
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
            trusted=np.full(count, np.nan),
            doubted=np.zeros(count),
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

    def turn(self, robots: NDArray[np.intp], widest: int) -> None:
        """Let robots turn, and look for `widest` anchors ahead."""
        self.enter(robots, State.TURN)
        self.width[robots], self.doubted[robots] = widest, 0.0

    def sight(
        self, robots: NDArray[np.intp], sighted: NDArray[np.intp], confirm: int
    ) -> NDArray[np.bool_]:
        """Which robots (M,) have now sighted about the same anchor for `confirm` steps in a row.

        Args:
            robots: (M,) their indices.
            sighted: (M,) places of anchors, -1 for none.
            confirm: steps.
        """
        same = np.abs(sighted - self.sighted[robots]) <= 1
        streak = np.where(same, self.streak[robots], 0) + 1
        streak = np.where(sighted >= 0, streak, 0)
        self.sighted[robots], self.streak[robots] = sighted, streak
        return streak >= confirm

    def go_on(self, robots: NDArray[np.intp], sighted: NDArray[np.intp]) -> None:
        """Let robots follow their paths again, towards the anchors (M,) that they sighted."""
        self.enter(robots, State.FOLLOW)
        self.aim(robots[sighted != self.active[robots]])
        self.active[robots], self.doubted[robots] = sighted, 0.0
        self.visited[robots] = np.maximum(self.visited[robots], sighted - 1)

    def aim(self, robots: NDArray[np.intp], probability: ArrayLike = np.nan) -> None:
        """Begin with another active anchor, of which RE (M,) may be known. A doubt lasts."""
        self.heading.begin(robots)
        self.trusted[robots] = probability

    def doubt(
        self, robots: NDArray[np.intp], probability: Array, settings: FollowerSettings
    ) -> None:
        """Doubt where RE fell at once; a robot whose doubt does not end in time is lost.

        What a robot sees changes little by little, also behind a person who steps in. It changes at
        once where the robot is pushed, turned or carried away; but only one that was carried away
        does not soon see its anchors again.

        Args:
            robots: (M,) their indices.
            probability: (M,) RE of their active anchors.
            settings: the thresholds.
        """
        # While a robot turns, its anchors come into sight and leave it again.
        probability = np.where(self.state[robots] == State.TURN, np.nan, probability)
        before = self.trusted[robots]
        fell = (before > settings.p_follow) & (before - probability > settings.fall)
        doubts = (fell | (self.doubted[robots] > 0)) & ~(probability > settings.p_follow)
        self.trusted[robots] = probability
        self.doubted[robots] = np.where(doubts, self.doubted[robots] + STEP, 0.0)
        self.enter(robots[self.doubted[robots] > settings.timeout - STEP / 2], State.LOST)

    def leave(
        self,
        robots: NDArray[np.intp],
        sure: NDArray[np.bool_],
        goal: NDArray[np.bool_],
        settings: FollowerSettings,
    ) -> None:
        """Leave Follow: at the goal, for dead reckoning, or lost.

        Args:
            robots: (M,) their indices.
            sure: (M,) see their anchors.
            goal: (M,) are at their goals.
            settings: the thresholds.
        """
        progress = goal | (sure & (self.heading.tried[robots] <= settings.effort))
        self.calm[robots] = np.where(progress, self.calm[robots] + STEP, 0.0)
        self.stalled[robots[~progress]] += STEP
        self.stalled[robots[self.calm[robots] >= settings.calm]] = 0.0
        self.streak[robots] = np.where(goal, self.streak[robots] + 1, 0)
        lost = self.stalled[robots] > settings.timeout - STEP / 2
        self.enter(robots[lost], State.LOST)
        self.enter(robots[~lost & (self.streak[robots] >= settings.confirm)], State.DONE)
        self.enter(robots[~lost & ~sure & ~goal], State.DEAD_RECKONING)

    def faces_away(
        self,
        robots: NDArray[np.intp],
        waypoints: Array,
        overlaps: Array,
        settings: FollowerSettings,
    ) -> NDArray[np.bool_]:
        """Which robots (M,) are at their anchors but do not face them, whatever they tried.

        Those that turned all around before are not among them.

        Args:
            robots: (M,) their indices.
            waypoints: (M, 2) to their anchors.
            overlaps: (M,) with them.
            settings: the thresholds.
        """
        tired = self.heading.tried[robots] > settings.effort
        at = np.linalg.norm(waypoints, axis=1) < settings.at
        following = (self.state[robots] == State.FOLLOW) & ~self.looked[robots]
        return tired & at & (overlaps <= settings.facing) & following

    def follow_from_start(self, robot: int) -> None:
        """Let a robot follow a new path from its first anchor on."""
        one = np.array([robot])
        self.enter(one, State.FOLLOW)
        self.active[robot], self.visited[robot] = 0, -1
        self.stalled[robot], self.waypoints[robot] = 0.0, np.nan
        self.looked[robot], self.doubted[robot] = False, 0.0
        self.aim(one)
