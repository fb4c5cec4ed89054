"""Navigation over a map: plan, follow the plan by sight, and replan when lost or blocked.

A robot without a plan turns in place and replans once a second. One with something in its way waits
for a moment; then the stretch before it is excluded for a time, and it replans. One that followed
its path knows about where it is: its next plan begins around there. Else, with the path ahead
excluded, plans would begin at places that only look like here.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.blockades import Blockades, Waiting, in_the_way
from tutorial_lib.agents.map_targets import MapTargets
from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.driving.control.three_point import ThreePointTurn
from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import (
    HERE,
    Controller,
    Edges,
    Goals,
    Observation,
    Plan,
    Reachability,
    Robots,
    WaypointPredictor,
)
from tutorial_lib.se2 import Array, to_local
from tutorial_lib.topology.following.anchor_paths import AnchorPaths
from tutorial_lib.topology.following.follower import Follower
from tutorial_lib.topology.following.transitions import FollowerSettings, State
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.validation import instance, instances, number, with_methods
from tutorial_lib.world.simulation import STEP

SEARCH_TIME = 20.0
"""Seconds of rotating after which a robot without a plan gives up."""
LOOK_TIME = 10.0
"""Seconds of rotating after which a plan may begin anywhere."""
_ALL = 4 * np.pi  # rad; it turns on until it has a plan
_REPLAN_STEPS = 10  # from one attempt to plan to the next, while rotating
_MOVED = 5.0  # metres from the vertex visited last after which a robot may be anywhere
_STEPS = 4  # edges from that vertex, either way
RULES = FollowerSettings(timeout=2.0, fall=1.0)
"""Rules of a robot that can replan: it gives up a path sooner, and never because of a doubt."""
FindPath = Callable[[Observation, Goals, Edges], Plan]
"""Plans from what one robot observes to a goal, around some excluded edges."""


@dataclass(frozen=True)
class Setback:
    """Where a robot lost its path, or could not go on.

    Attributes:
        robot: its index.
        path: vertices of its plan.
        visited: place on the path of the vertex that it visited last, -1 for none.
        ahead: that of the vertex to which it drove.
        blocked: whether something stood in its way.
        edges: that are excluded for a time.
    """

    robot: int
    path: tuple[int, ...]
    visited: int
    ahead: int
    blocked: bool
    edges: Edges


class MapNavigation:
    """A `Navigation` of N robots over a map.

    Attributes:
        plans: the last plan of each robot; none while it searches.
        history: all plans of each robot.
        arrived: (N,) declares to have arrived.
        given_up: (N,) found no path, or was lost too often.
        setbacks: of all robots, in their order.
        follower: follows the plans.
    """

    def __init__(
        self,
        find_path: FindPath,
        make_follower: Callable[..., Follower],
        targets: MapTargets,
        goals: Iterable[Goals],
        replan_time: float,
    ) -> None:
        """Robots plan when they act for the first time.

        Args:
            find_path: plans.
            make_follower: makes a `Follower` of paths and `starts`.
            targets: the map, which must not grow meanwhile.
            goals: one for each robot.
            replan_time: seconds since it was first lost for which a robot replans.

        Raises:
            InputError: when they are no list of `Goals`, or there are none.
        """
        goals = instances("goals", goals, Goals, empty=False)
        self._find_path, self._topomap = find_path, targets.topomap
        self._replan_time = replan_time
        count, self._goals = len(goals), goals
        self.plans: list[Plan | None] = [None] * count
        self.history: list[list[Plan]] = [[] for _ in goals]
        self.setbacks: list[Setback] = []
        self.arrived, self.given_up = np.zeros(count, bool), np.zeros(count, bool)
        self._whereabouts = Whereabouts(count, self._topomap)
        self._blockades, self._waiting = Blockades(count, self._topomap), Waiting(count)
        self._rotation = ThreePointTurn(count)
        self._searched = np.zeros(count, dtype=int)  # steps since it had a plan
        # Seconds under way, and those at which it was first lost.
        self._now, self._lost_at = np.zeros(count), np.full(count, np.inf)
        vertices = len(self._topomap.vertices)
        self._first = np.cumsum([vertices, *(len(goal) for goal in goals)])
        contexts = np.concatenate([goal.contexts for goal in goals])
        paths = AnchorPaths(*targets.followed_by(contexts), [[goal] for goal in self._first[:-1]])
        self.follower = make_follower(paths, starts=np.zeros(count, dtype=int))

    def act(self, observations: Observation, robots: Robots) -> Array:
        """Plan where there is no plan, and follow: actions (M, 2)."""
        robots = np.asarray(robots)
        actions, rows = np.zeros((len(robots), 2)), np.flatnonzero(~self._over[robots])
        actions[rows] = self._act(observations[rows], robots[rows])
        return actions

    @property
    def _over(self) -> NDArray[np.bool_]:
        return self.arrived | self.given_up

    def _act(self, observations: Observation, robots: Robots) -> Array:
        """The same for robots that have neither arrived nor given up."""
        self._now[robots] += STEP
        for row, robot in enumerate(robots):
            if self.plans[robot] is None and self._searched[robot] % _REPLAN_STEPS == 0:
                self._plan(observations[row], int(robot))
        actions = np.zeros((len(robots), 2))
        under_way = np.array([self.plans[robot] is not None for robot in robots], dtype=bool)
        going = np.flatnonzero(under_way & ~self._over[robots])
        actions[going] = self.follower.act(observations[going], robots[going])
        memory = self.follower.memory
        self.arrived[robots[going]] = memory.done[robots[going]]
        searching = np.flatnonzero(~under_way)
        if searching.size:
            actions[searching] = self._search(observations[searching], robots[searching])
        lost = memory.lost[robots[going]] | self._blocked(observations[going], robots[going])
        for row in going[lost & ~self.arrived[robots[going]]]:
            self._lose(int(robots[row]), observations.odometry[row])
        return actions

    def _blocked(self, observations: Observation, robots: Robots) -> NDArray[np.bool_]:
        """(M,) which robots have waited in vain for what stands in their way."""
        memory = self.follower.memory
        waypoints = to_local(observations.odometry, memory.waypoints[robots])
        driving = np.isin(memory.state[robots], (State.FOLLOW, State.DEAD_RECKONING))
        # A robot that looks for the heading of an anchor drives to no waypoint.
        driving &= (memory.heading.side[robots] == 0) & np.isfinite(waypoints).all(axis=1)
        blocked = driving.copy()
        lasers = np.asarray(observations.laser, dtype=float)
        blocked[driving] = in_the_way(lasers[driving], waypoints[driving])
        return self._waiting.step(robots, observations.odometry, blocked)

    def _search(self, observations: Observation, robots: Robots) -> Array:
        """Actions (M, 2) by which robots turn in place."""
        begin = np.flatnonzero(self._searched[robots] == 0)
        self._rotation.begin(robots[begin], observations.odometry[begin], np.full(len(begin), _ALL))
        self._searched[robots] += 1
        self.given_up[robots] |= self._searched[robots] > SEARCH_TIME / STEP
        return self._rotation.act(observations, robots)

    def _plan(self, observation: Observation, robot: int) -> None:
        """Plan and start, or search, or give up."""
        plan = instance("planner", self._path(observation, robot), Plan)
        self.history[robot].append(plan)
        # A robot that was under way takes an improbable path rather than none.
        if not plan.refusal or (plan.probability > 0 and np.isfinite(self._lost_at[robot])):
            self._searched[robot], self.plans[robot] = 0, plan
            path = [*plan.vertices, int(self._first[robot]) + plan.goal]
            self.follower.assign(robot, path, self._topomap.turns_on(plan.vertices))
        elif plan.probability > 0:
            # The best path is refused; to search elsewhere will not help.
            self.plans[robot], self.given_up[robot] = plan, True

    def _path(self, observation: Observation, robot: int) -> Plan:
        """A path from what one robot observes to its goal."""
        return self._find_path(observation, self._goals[robot], self._excluded(observation, robot))

    def _excluded(self, observation: Observation, robot: int) -> Edges:
        """The edges that one robot does not plan over now."""
        odometry = observation.odometry[0]
        excluded = self._blockades.excluded(robot, odometry, self._now[robot])
        if self._searched[robot] < LOOK_TIME / STEP:
            excluded |= self._whereabouts.excluded(robot, odometry)
        return excluded

    def _lose(self, robot: int, odometry: Array) -> None:
        """Replan in the next step; what could not be passed is excluded for a time."""
        plan, memory, now = self.plans[robot], self.follower.memory, float(self._now[robot])
        ahead, visited = int(memory.active[robot]), int(memory.visited[robot])
        if plan is not None and 0 <= visited < len(plan.vertices):
            self._whereabouts.see(robot, plan.vertices[visited], odometry)
        if plan is not None and 0 <= ahead < len(plan.vertices):
            before = plan.vertices[max(min(visited, ahead - 1), 0) : ahead]
            after = plan.vertices[ahead : ahead + 2]
            edges = self._blockades.add(robot, before, after, odometry, now)
            blocked = not memory.lost[robot]
            self.setbacks.append(Setback(robot, plan.vertices, visited, ahead, blocked, edges))
        self._waiting.stop(robot)
        self._lost_at[robot] = min(self._lost_at[robot], now)
        if now - self._lost_at[robot] >= self._replan_time:
            self.given_up[robot] = True
        else:
            self.plans[robot] = None


@dataclass(kw_only=True)
class MapAgent(ABC):
    """An `Agent` that plans over a topological map and follows its plans by sight.

    Attributes:
        predictor: C_WP.
        controller: C_RMP, the library's unless given.
        reachability: RE.
        follower: thresholds of the follower.
        replan_time: seconds since it was first lost for which a robot replans; 0 for never.
        topomap: what was learned.
    """

    predictor: WaypointPredictor
    controller: Controller = field(default_factory=RMPController)
    reachability: Reachability
    follower: FollowerSettings = RULES
    replan_time: float = 240.0

    def __post_init__(self) -> None:
        with_methods("predictor", self.predictor, "prepare", "predict")
        with_methods("controller", self.controller, "act")
        with_methods("reachability", self.reachability, "prepare", "probability")
        instance("follower", self.follower, FollowerSettings)
        number("replan_time", self.replan_time, least=0.0, infinite=True)
        self.topomap = self.empty_map()
        self._targets = MapTargets(self.topomap, self.predictor, self.reachability)

    @abstractmethod
    def empty_map(self) -> TopoMap:
        """A map to begin with."""

    @abstractmethod
    def find_path(self, observation: Observation, goals: Goals, excluded: Edges) -> Plan:
        """Plan over the map from what one robot observes to a goal."""

    def start(self, goals: Sequence[Goals]) -> MapNavigation:
        """Send robots to one goal each.

        Raises:
            InputError: when nothing was learned.
        """
        return MapNavigation(*self._parts(goals))

    def _parts(self, goals: Sequence[Goals]) -> tuple[Any, ...]:
        """What a `MapNavigation` is made of; see `start`."""
        self._check_map()
        return self.find_path, self.make_follower(), self.targets(), goals, self.replan_time

    def _check_map(self) -> None:
        if not len(self.topomap):
            raise InputError("map: none; let the agent learn first")

    def targets(self) -> MapTargets:
        """The vertices of the map as it is now, encoded once for all robots and goals."""
        if self._targets.topomap is not self.topomap:
            self._targets = MapTargets(self.topomap, self.predictor, self.reachability)
        return self._targets

    def make_follower(self) -> Callable[..., Follower]:
        """Makes a `Follower` of paths and `starts`, with the agent's parts."""
        return partial(
            Follower,
            predictor=self.predictor,
            controller=self.controller,
            reachability=self.reachability,
            settings=self.follower,
        )


class Whereabouts:
    """The vertices that each of N robots visited last; it forgets them when it has moved on."""

    def __init__(self, robots: int, topomap: TopoMap) -> None:
        """Begin with robots that may be anywhere."""
        self._topomap = topomap
        self._seen: list[tuple[int, Array] | None] = [None] * robots

    def see(self, robot: int, vertex: int, odometry: Array) -> None:
        """A robot with `odometry` (3,) visited a vertex last."""
        self._seen[robot] = vertex, odometry[:2].copy()

    def excluded(self, robot: int, odometry: Array) -> Edges:
        """The first steps by which no plan begins for a robot with `odometry` (3,) now."""
        seen = self._seen[robot]
        if seen is None or np.linalg.norm(odometry[:2] - seen[1]) > _MOVED:
            return set()
        both_ways = self._topomap.graph.to_undirected(as_view=True)
        around = nx.single_source_shortest_path_length(both_ways, seen[0], cutoff=_STEPS)
        return {(HERE, int(vertex)) for vertex in self._topomap.alive if vertex not in around}
