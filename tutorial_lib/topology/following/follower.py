"""Follows paths of anchors by sight: the state machine of Meng 2020 (III-H), for a fleet.

*Search* localizes the robot on its path. *Follow* drives to the active anchor by the predicted
waypoint and switches to the next anchor in time. *Dead reckoning* takes over while RE of the active
anchor is low: the robot drives to the last waypoint by odometry and looks for the anchors around.
*Turn*: where the path continues in another direction, the robot turns until it sees the next
anchors. A robot that does not find its path again in time is lost and stops; so is one whose view
changed at once and does not recover in time (ours). Nothing here ever sees a pose.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import Controller, Observation, Reachability, Robots, WaypointPredictor
from tutorial_lib.se2 import Array, to_local, to_world
from tutorial_lib.topology.following.anchor_paths import AnchorPaths
from tutorial_lib.topology.following.log import FollowerLog
from tutorial_lib.topology.following.state import FollowerState
from tutorial_lib.topology.following.transitions import (
    FollowerSettings,
    State,
    found_again,
    last_visited,
    next_active,
)
from tutorial_lib.topology.following.turns import TURN_TIME, PathTurns, checked_turns
from tutorial_lib.validation import floats, instance, integers, whole, with_methods
from tutorial_lib.world.simulation import STEP


class Follower:
    """A `Policy` of N robots, each on its own path of anchors.

    Attributes:
        paths: of the robots.
        memory: what it remembers of them.
    """

    def __init__(
        self,
        paths: AnchorPaths,
        predictor: WaypointPredictor,
        controller: Controller,
        reachability: Reachability,
        settings: FollowerSettings | None = None,
        starts: ArrayLike | None = None,
    ) -> None:
        """Start on paths.

        Args:
            paths: one for each of N robots.
            predictor: C_WP.
            controller: C_RMP.
            reachability: RE.
            settings: the thresholds.
            starts: (N,) the anchor to drive to first, where it is known; -1 where it must be
                searched for, as everywhere unless given.

        Raises:
            InputError: when a start is beyond its path.
        """
        self.paths = instance("paths", paths, AnchorPaths)
        settings = FollowerSettings() if settings is None else settings
        self.settings = instance("settings", settings, FollowerSettings)
        self.predictor = with_methods("predictor", predictor, "predict")
        self.controller = with_methods("controller", controller, "act")
        self.reachability = with_methods("reachability", reachability, "probability")
        count = len(paths)
        starts = np.full(count, -1) if starts is None else starts
        active = integers("starts", starts, ("N",)).copy()
        if active.shape != (count,) or not ((active >= -1) & (active < paths.lengths)).all():
            raise InputError(f"starts: {starts}; give (N,) anchors of {count} paths, -1 to search")
        self.memory = FollowerState.at(active)
        self._turns = PathTurns(count)
        self._predicted = np.full((count, 2), np.nan)  # RE of, and overlap with, the active anchor
        self._steps: list[tuple[NDArray, ...]] = []

    def act(self, observations: Observation, robots: Robots) -> Array:
        """Observe, decide and drive on.

        Args:
            observations: M robots.
            robots: (M,) their indices, rising; the others keep their state.

        Returns:
            (M, 2) actions; a robot that is lost or done stands still.

        Raises:
            InputError: when there are not as many indices as observations, or a network returns
                something of the wrong form.
        """
        instance("observations", observations, Observation)
        robots = integers("robots", robots, ("M",), least=0, most=len(self.paths) - 1)
        memory, count = self.memory, len(observations)
        if robots.shape != (count,):
            raise InputError(f"follower: {count} observations but robots {robots}; give as many")
        self._predicted[:] = np.nan
        self._search(observations, robots)
        going = np.flatnonzero(~memory.over[robots])
        seen, under_way = observations[going], robots[going]
        probabilities = self._look_out(seen, under_way)
        memory.doubt(under_way, self._predicted[under_way, 0], self.settings)
        states = memory.state[under_way]
        for state, step in (
            (State.DEAD_RECKONING, self._find_back),
            (State.TURN, self._turn),
            (State.FOLLOW, self._follow),
        ):
            rows = np.flatnonzero(states == state)
            step(seen[rows], under_way[rows], probabilities[rows])
        actions = np.zeros((len(robots), 2))
        actions[going] = self._drive(seen, under_way)
        before = memory.state.copy(), memory.active.copy(), memory.visited.copy()
        self._steps.append((*before, *self._predicted.T.copy(), memory.waypoints.copy()))
        return actions

    def assign(self, robot: int, path: ArrayLike, turns: Mapping[int, float] | None = None) -> None:
        """Put a robot on another path, which it follows from the first anchor on.

        Args:
            robot: its index.
            path: (L,) indices of anchors, as for `AnchorPaths`.
            turns: by how many rad it turns before each of these places on the path.

        Raises:
            InputError: when the path leads beyond the anchors.
        """
        paths, turns = list(self.paths.paths), checked_turns(turns)
        paths[whole("robot", robot, least=0, most=len(paths) - 1)] = path
        self.paths = replace(self.paths, paths=paths)
        self._turns.set(robot, turns)
        self.memory.follow_from_start(robot)

    def log(self) -> FollowerLog:
        """Every step until now."""
        return FollowerLog.of(self._steps, len(self.paths))

    def _search(self, observations: Observation, robots: Robots) -> None:
        """Search: drive to the anchor that is most probably reachable, or give up."""
        memory = self.memory
        searching = np.flatnonzero(memory.state[robots] == State.SEARCH)
        if not searching.size:
            return
        seen, robots = observations[searching], robots[searching]
        places = np.tile(np.arange(self.paths.lengths[robots].max()), (len(robots), 1))
        probabilities = self.paths.probabilities(
            self.reachability, seen, robots, places, np.ones(places.shape, dtype=bool)
        )
        best = np.nanargmax(probabilities, axis=1)
        sure = probabilities[np.arange(len(best)), best] > self.settings.p_search
        memory.state[robots] = np.where(sure, State.FOLLOW, State.LOST)
        memory.active[robots], memory.visited[robots] = best, best - 1

    def _look_out(self, observations: Observation, robots: Robots) -> Array:
        """RE (M, 2W+1) of anchors from W before to W after the active one.

        In Follow that of the active anchor and the next one, otherwise of a growing window.
        """
        widest, active = self.settings.widest, self.memory.active[robots]
        offsets, width = np.arange(-widest, widest + 1), self.memory.width[robots, None]
        places = active[:, None] + offsets
        queried = (offsets >= -width) & (offsets <= np.maximum(width, 1))
        # The robot never goes back to an anchor that it visited.
        queried &= (places > self.memory.visited[robots, None]) | (offsets >= 0)
        probabilities = self.paths.probabilities(
            self.reachability, observations, robots, places, queried
        )
        self._predicted[robots, 0] = probabilities[:, widest]
        return probabilities

    def _find_back(self, observations: Observation, robots: Robots, probabilities: Array) -> None:
        """Dead reckoning: back to Follow once an anchor was sighted some steps in a row."""
        settings, memory = self.settings, self.memory
        self._try(observations, robots, probabilities[:, settings.widest] > settings.p_try)
        sighted = found_again(memory.active[robots], probabilities, settings.p_follow)
        back = memory.sight(robots, sighted, settings.confirm)
        memory.stalled[robots] += STEP
        lost = ~back & (memory.stalled[robots] > settings.timeout - STEP / 2)
        memory.width[robots] = np.minimum(memory.width[robots] + 1, settings.widest)
        memory.state[robots[lost]] = State.LOST
        memory.go_on(robots[back], sighted[back])

    def _turn(self, observations: Observation, robots: Robots, probabilities: Array) -> None:
        """Turn: back to Follow once one of the next anchors, or how the goal looks, was sighted."""
        settings, memory = self.settings, self.memory
        active, last = memory.active[robots], np.flatnonzero(memory.looked[robots])
        there = observations[last], robots[last], active[last, None], np.ones((len(last), 1), bool)
        overlaps = self.paths.waypoints(self.predictor, *there)[1]
        sighted = found_again(active, probabilities, settings.p_follow)
        sighted[last] = np.where(overlaps[:, 0] > settings.facing, active[last], -1)
        back = memory.sight(robots, sighted, settings.confirm)
        late = ~back & (self._turns.seconds[robots] > TURN_TIME - STEP / 2)
        memory.go_on(robots[back], sighted[back])
        memory.state[robots[late]] = State.LOST
        ends = late & memory.looked[robots]
        memory.go_on(robots[ends], active[ends])

    def _try(self, observations: Observation, robots: Robots, worth: NDArray[np.bool_]) -> None:
        """At the end of dead reckoning, request a new waypoint to the active anchor if `worth`.

        Stalled time goes on counting: a robot that sees no more from there is lost as soon.
        """
        left = to_local(observations.odometry, self.memory.waypoints[robots])
        stranded = np.flatnonzero(worth & (np.linalg.norm(left, axis=1) < 2 * self.settings.at))
        seen, robots = observations[stranded], robots[stranded]
        places = self.memory.active[robots, None]
        every = np.ones(places.shape, dtype=bool)
        waypoints, _ = self.paths.waypoints(self.predictor, seen, robots, places, every)
        self.memory.waypoints[robots] = to_world(seen.odometry, waypoints[:, 0])

    def _follow(self, observations: Observation, robots: Robots, probabilities: Array) -> None:
        """Follow: localize, choose the active anchor, and drive to its waypoint."""
        settings, memory = self.settings, self.memory
        active, visited = memory.active[robots], memory.visited[robots]
        now, after = probabilities[:, settings.widest : settings.widest + 2].T
        places = active[:, None] + [-1, 0, 1]
        queried = places >= np.minimum(visited, active)[:, None]
        waypoints, overlaps = self.paths.waypoints(
            self.predictor, observations, robots, places, queried
        )
        self._predicted[robots, 1] = overlaps[:, 1]
        done, goal = self._arrive(robots, now, after, waypoints, overlaps)
        visited = last_visited(visited, active, overlaps, done, settings.visited)
        chosen = next_active(active, visited, after, overlaps[:, 2], settings)
        memory.active[robots], memory.visited[robots] = chosen, visited
        moved = chosen > active
        memory.aim(robots[moved], after[moved])
        sure = np.where(moved, after, now) > settings.p_lose
        # With a new active anchor, or before the first waypoint, any waypoint is taken.
        fresh = sure | moved | np.isnan(memory.waypoints[robots, 0])
        ahead = memory.heading.waypoints(robots, waypoints[np.arange(len(robots)), 1 + moved])
        memory.waypoints[robots[fresh]] = to_world(observations.odometry, ahead)[fresh]
        memory.leave(robots, sure, goal, settings)
        # A robot that sees the next anchor drives to it, whatever the map says about turning.
        blind = moved & ~(after > settings.p_follow) & self._turns.before(robots, chosen)
        blind &= memory.state[robots] != State.LOST
        memory.turn(robots[blind], settings.widest)
        self._turns.begin(robots[blind], observations.odometry[blind], chosen[blind])
        aside = memory.faces_away(robots, waypoints[:, 1], overlaps[:, 1], settings)
        aside &= memory.active[robots] == self.paths.lengths[robots] - 1
        memory.turn(robots[aside], settings.widest)
        memory.looked[robots[aside]] = True
        self._turns.look(robots[aside], observations.odometry[aside])

    def _arrive(
        self, robots: Robots, now: Array, after: Array, waypoints: Array, overlaps: Array
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Which robots (M,) are done with the active anchor, and for which (M,) it is the last."""
        settings, overlap, heading = self.settings, overlaps[:, 1], self.memory.heading
        last = self.memory.active[robots] == self.paths.lengths[robots] - 1
        gap = np.linalg.norm(waypoints[:, 1], axis=1)
        # Where RE is low the waypoint means nothing, near as it may be.
        near = (gap < settings.at) & (now > settings.p_lose)
        tired = heading.tried[robots] > settings.effort
        faces = overlap > settings.facing
        wants = ~faces & ~tired & (now > settings.p_lose) & ~(after > settings.p_follow)
        # The path goes on towards the next anchor, as far as can be predicted.
        first = np.where(np.where(last, waypoints[:, 1, 1], waypoints[:, 2, 1]) < 0, -1, 1)
        heading.decide(robots, wants, near, gap, overlap, first)
        done = (near & (heading.side[robots] == 0)) | tired
        return done, near & last & (faces | (tired & self.memory.looked[robots]))

    def _drive(self, observations: Observation, robots: Robots) -> Array:
        """Actions (M, 2) towards the last waypoint, which odometry keeps track of, or to turn."""
        actions, state = np.zeros((len(robots), 2)), self.memory.state[robots]
        if (turning := np.flatnonzero(state == State.TURN)).size:
            actions[turning] = self._turns.act(observations[turning], robots[turning])
        moving = np.flatnonzero(~self.memory.over[robots] & (state != State.TURN))
        if moving.size:
            seen = observations[moving]
            waypoints = to_local(seen.odometry, self.memory.waypoints[robots[moving]])
            chosen = self.controller.act(seen, waypoints)
            actions[moving] = floats("actions", chosen, (len(moving), 2))
        return actions
