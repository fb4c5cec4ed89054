"""A run along trails of anchors: the state machine of Meng 2020 (III-H), for a fleet.

*Search* finds the trail. *Follow* drives to the active anchor, by the waypoint that the network
tells, and moves on to the next one in time. *Dead reckoning* takes over while the active anchor
cannot be reached, as far as RE can tell: the robot drives on to the last waypoint by odometry, and
looks out for the trail. Who does not find back in time is lost, and stops.

Nothing here ever sees a pose.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array, to_local, to_world
from tutorial_lib.interfaces import Controller, Observation, Reachability, WaypointPredictor
from tutorial_lib.topology.following.anchor_paths import AnchorPaths
from tutorial_lib.topology.following.heading_search import HeadingSearch
from tutorial_lib.topology.following.log import FollowerLog
from tutorial_lib.topology.following.transitions import (
    FollowerSettings,
    State,
    found_again,
    last_visited,
    next_active,
)
from tutorial_lib.world.simulation import STEP

Robots = NDArray[np.intp]
"""(M,) numbers of robots."""


class Run:
    """N robots on their trails.

    Attributes:
        state: (N,) a `State` each.
        active: (N,) place along the trail of the anchor that is driven to; -1 while searching.
        visited: (N,) place of the anchor that was last visited, -1 for none.
    """

    def __init__(
        self,
        trails: AnchorPaths,
        starts: ArrayLike | None,
        predictor: WaypointPredictor,
        controller: Controller,
        reachability: Reachability,
        settings: FollowerSettings,
    ) -> None:
        """See `Follower`, which begins it."""
        self.trails, self.settings = trails, settings
        self.predictor, self.controller, self.reachability = predictor, controller, reachability
        count = len(trails)
        self.active = np.full(count, -1) if starts is None else np.array(starts)
        fits = self.active.shape == (count,) and self.active.dtype.kind in "iu"
        if not (fits and ((self.active >= -1) & (self.active < trails.lengths)).all()):
            raise InputError(f"starts: {starts}; give (N,) anchors of {count} trails, -1 to search")
        self.visited = np.maximum(self.active - 1, -1)
        self.state = np.where(self.active < 0, State.SEARCH, State.FOLLOW)
        # Waypoints in the odometer's frame; seconds of dead reckoning that are not yet forgotten,
        # and in Follow since; anchors that a lookout reaches; the one that was sighted, and steps
        # in a row with it or at the goal.
        self._waypoints = np.full((count, 2), np.nan)
        self._doubt, self._calm = np.zeros(count), np.zeros(count)
        self._width = np.zeros(count, dtype=int)
        self._sighted, self._streak = np.full(count, -1), np.zeros(count, dtype=int)
        self._turning = HeadingSearch(count)
        self._told = np.full((count, 2), np.nan)
        self._steps: list[tuple[NDArray, ...]] = []

    @property
    def done(self) -> NDArray[np.bool_]:
        """(N,) who says to have arrived."""
        return self.state == State.DONE

    @property
    def lost(self) -> NDArray[np.bool_]:
        """(N,) who gave up."""
        return self.state == State.LOST

    @property
    def over(self) -> NDArray[np.bool_]:
        """(N,) who stands still for good."""
        return self.done | self.lost

    def act(self, observations: Observation, robots: Robots) -> Array:
        """Look, decide and drive on.

        Args:
            observations: M robots.
            robots: (M,) their numbers, rising; the others keep their state.

        Returns:
            (M, 2) actions; who is lost or done stands still.

        Raises:
            InputError: when there are not as many numbers as observations, or what a network tells
                is wrong.
        """
        robots = np.asarray(robots)
        if robots.shape != (len(observations),):
            raise InputError(
                f"follower: {len(observations)} observations but robots {robots}; give as many"
            )
        self._told[:] = np.nan
        self._search(observations, robots)
        going = np.flatnonzero(~self.over[robots])
        seen, under_way = observations[going], robots[going]
        probabilities = self._look_out(seen, under_way)
        follow = self.state[under_way] == State.FOLLOW
        self._find_back(seen[~follow], under_way[~follow], probabilities[~follow])
        self._follow(seen[follow], under_way[follow], probabilities[follow])
        actions = np.zeros((len(robots), 2))
        actions[going] = self._drive(seen, under_way)
        state, active, visited = self.state.copy(), self.active.copy(), self.visited.copy()
        self._steps.append((state, active, visited, *self._told.T.copy(), self._waypoints.copy()))
        return actions

    def start(self, robot: int, path: ArrayLike) -> None:
        """Put a robot on another trail, from whose first anchor on it follows.

        Args:
            robot: its number.
            path: (L,) numbers of anchors, as for `AnchorPaths`.

        Raises:
            InputError: when the path leads beyond the anchors.
        """
        paths = list(self.trails.paths)
        paths[robot] = path
        self.trails = replace(self.trails, paths=paths)
        self._enter(np.array([robot]), State.FOLLOW)
        self.active[robot], self.visited[robot] = 0, -1
        self._doubt[robot], self._waypoints[robot] = 0.0, np.nan
        self._turning.begin(np.array([robot]))

    def record(self) -> FollowerLog:
        """All that went on until now."""
        return FollowerLog.of(self._steps, len(self.trails))

    def _search(self, observations: Observation, robots: Robots) -> None:
        """Take the anchor that can be reached most surely, or give up."""
        searching = np.flatnonzero(self.state[robots] == State.SEARCH)
        if not searching.size:
            return
        seen, robots = observations[searching], robots[searching]
        places = np.tile(np.arange(self.trails.lengths[robots].max()), (len(robots), 1))
        probabilities = self.trails.probabilities(
            self.reachability, seen, robots, places, np.ones(places.shape, dtype=bool)
        )
        best = np.nanargmax(probabilities, axis=1)
        sure = probabilities[np.arange(len(best)), best] > self.settings.p_search
        self.state[robots] = np.where(sure, State.FOLLOW, State.LOST)
        self.active[robots], self.visited[robots] = best, best - 1

    def _look_out(self, observations: Observation, robots: Robots) -> Array:
        """RE (M, 2W+1) of anchors from W before to W after the active one.

        Asked are the active anchor and the next one in Follow, all in a growing window otherwise.
        """
        widest, active = self.settings.widest, self.active[robots]
        offsets, width = np.arange(-widest, widest + 1), self._width[robots, None]
        places = active[:, None] + offsets
        asked = (offsets >= -width) & (offsets <= np.maximum(width, 1))
        # What was visited is never gone back to.
        asked &= (places > self.visited[robots, None]) | (offsets >= 0)
        probabilities = self.trails.probabilities(
            self.reachability, observations, robots, places, asked
        )
        self._told[robots, 0] = probabilities[:, widest]
        return probabilities

    def _find_back(self, observations: Observation, robots: Robots, probabilities: Array) -> None:
        """Dead reckoning: back to the trail once an anchor was sighted some steps in a row."""
        settings = self.settings
        self._try(observations, robots, probabilities[:, settings.widest] > settings.p_try)
        sighted = found_again(self.active[robots], probabilities, settings.p_follow)
        same = np.abs(sighted - self._sighted[robots]) <= 1
        streak = np.where(same, self._streak[robots], 0) + 1
        streak = np.where(sighted >= 0, streak, 0)
        self._sighted[robots], self._streak[robots] = sighted, streak
        self._doubt[robots] += STEP
        back = streak >= settings.confirm
        lost = ~back & (self._doubt[robots] > settings.patience - STEP / 2)
        self._width[robots] = np.minimum(self._width[robots] + 1, settings.widest)
        self.state[robots[lost]] = State.LOST
        self._enter(robots[back], State.FOLLOW)
        self._turning.begin(robots[back & (sighted != self.active[robots])])
        self.active[robots[back]] = sighted[back]
        self.visited[robots[back]] = np.maximum(self.visited[robots], sighted - 1)[back]

    def _try(self, observations: Observation, robots: Robots, worth: NDArray[np.bool_]) -> None:
        """Who has come to the last waypoint tries one to the active anchor, where that is worth it.

        The doubt remains: who does not get to see more that way is lost as soon as without it.
        """
        left = to_local(observations.odometry, self._waypoints[robots])
        stranded = np.flatnonzero(worth & (np.linalg.norm(left, axis=1) < 2 * self.settings.at))
        seen, robots = observations[stranded], robots[stranded]
        places = self.active[robots, None]
        ask = np.ones(places.shape, dtype=bool)
        waypoints, _ = self.trails.waypoints(self.predictor, seen, robots, places, ask)
        self._waypoints[robots] = to_world(seen.odometry, waypoints[:, 0])

    def _follow(self, observations: Observation, robots: Robots, probabilities: Array) -> None:
        """Follow: localize, choose the active anchor, and drive to its waypoint."""
        settings = self.settings
        active, visited = self.active[robots], self.visited[robots]
        now, after = probabilities[:, settings.widest : settings.widest + 2].T
        places = active[:, None] + [-1, 0, 1]
        asked = places >= np.minimum(visited, active)[:, None]
        waypoints, overlaps = self.trails.waypoints(
            self.predictor, observations, robots, places, asked
        )
        self._told[robots, 1] = overlaps[:, 1]
        done, goal = self._arrive(robots, now, after, waypoints, overlaps)
        visited = last_visited(visited, active, overlaps, done, settings.visited)
        chosen = next_active(active, visited, after, overlaps[:, 2], settings)
        self.active[robots], self.visited[robots] = chosen, visited
        moved = chosen > active
        self._turning.begin(robots[moved])
        sure = np.where(moved, after, now) > settings.p_lose
        # Who must get on takes what waypoint there is, and so does who never had one.
        fresh = sure | moved | np.isnan(self._waypoints[robots, 0])
        ahead = self._turning.waypoints(robots, waypoints[np.arange(len(robots)), 1 + moved])
        self._waypoints[robots[fresh]] = to_world(observations.odometry, ahead)[fresh]
        self._judge(robots, sure, goal)

    def _arrive(
        self, robots: Robots, now: Array, after: Array, waypoints: Array, overlaps: Array
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Who (M,) is done with the active anchor, and for whom (M,) it was the last."""
        settings, overlap = self.settings, overlaps[:, 1]
        last = self.active[robots] == self.trails.lengths[robots] - 1
        gap = np.linalg.norm(waypoints[:, 1], axis=1)
        # Where RE is low the waypoint means nothing, near as it may be.
        near = (gap < settings.at) & (now > settings.p_lose)
        tired = self._turning.tried[robots] > settings.effort
        faces = overlap > settings.facing
        wants = ~faces & ~tired & (now > settings.p_lose) & ~(after > settings.p_follow)
        # The trail goes on where the next anchor is, as far as can be told.
        first = np.where(np.where(last, waypoints[:, 1, 1], waypoints[:, 2, 1]) < 0, -1, 1)
        self._turning.judge(robots, wants, near, gap, overlap, first)
        done = (near & (self._turning.side[robots] == 0)) | tired
        return done, near & last & (faces | tired)

    def _judge(self, robots: Robots, sure: NDArray[np.bool_], goal: NDArray[np.bool_]) -> None:
        """Leave Follow: at the goal, for dead reckoning, or because nothing helps any more."""
        settings = self.settings
        progress = goal | (sure & (self._turning.tried[robots] <= settings.effort))
        self._calm[robots] = np.where(progress, self._calm[robots] + STEP, 0.0)
        self._doubt[robots[~progress]] += STEP
        self._doubt[robots[self._calm[robots] >= settings.calm]] = 0.0
        self._streak[robots] = np.where(goal, self._streak[robots] + 1, 0)
        lost = self._doubt[robots] > settings.patience - STEP / 2
        self._enter(robots[lost], State.LOST)
        self._enter(robots[~lost & (self._streak[robots] >= settings.confirm)], State.DONE)
        self._enter(robots[~lost & ~sure & ~goal], State.DEAD_RECKONING)

    def _enter(self, robots: Robots, state: State) -> None:
        """Change the state of robots; what was counted begins anew."""
        self.state[robots], self._calm[robots] = state, 0.0
        self._streak[robots], self._sighted[robots] = 0, -1
        self._width[robots] = 0
        self._turning.stop(robots)

    def _drive(self, observations: Observation, robots: Robots) -> Array:
        """Actions (M, 2) towards the last waypoint, which the odometer keeps track of."""
        actions = np.zeros((len(robots), 2))
        moving = np.flatnonzero(~self.over[robots])
        if moving.size:
            seen = observations[moving]
            waypoints = to_local(seen.odometry, self._waypoints[robots[moving]])
            actions[moving] = self.controller.act(seen, waypoints)
        return actions
