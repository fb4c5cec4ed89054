"""Navigation over a map: plan, follow the plan by sight, and replan when lost.

A robot without a plan rotates in place and replans once a second.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import (
    Controller,
    Goals,
    Observation,
    Plan,
    Reachability,
    Robots,
    Targets,
    WaypointPredictor,
)
from tutorial_lib.topology.following.anchor_paths import AnchorPaths
from tutorial_lib.topology.following.follower import Follower
from tutorial_lib.topology.following.heading_search import ASIDE
from tutorial_lib.topology.following.transitions import FollowerSettings
from tutorial_lib.topology.mapping.growing_batch import GrowingBatch, joined
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.world.simulation import STEP

SEARCH_TIME = 20.0
"""Seconds of rotating after which a robot without a plan gives up."""
_REPLAN_STEPS = 10  # from one attempt to plan to the next, while rotating
FindPath = Callable[[Observation, Goals, set[int]], Plan]
"""Plans from what one robot observes to a goal, around some excluded vertices."""


class MapNavigation:
    """A `Navigation` of N robots over a map.

    Attributes:
        plans: the last plan of each robot; none while it searches.
        history: all plans of each robot.
        arrived: (N,) declares to have arrived.
        given_up: (N,) found no path, or was lost too often.
        follower: follows the plans.
    """

    def __init__(
        self,
        find_path: FindPath,
        make_follower: Callable[..., Follower],
        targets: MapTargets,
        goals: Sequence[Goals],
        replans: int,
    ) -> None:
        """Robots plan when they act for the first time.

        Args:
            find_path: plans.
            make_follower: makes a `Follower` of paths and `starts`.
            targets: the map, which must not grow meanwhile.
            goals: one for each robot.
            replans: how often a robot that is lost replans before it gives up.
        """
        self._find_path, self._topomap, self._replans = find_path, targets.topomap, replans
        count, self._goals = len(goals), list(goals)
        self.plans: list[Plan | None] = [None] * count
        self.history: list[list[Plan]] = [[] for _ in goals]
        self.arrived, self.given_up = np.zeros(count, bool), np.zeros(count, bool)
        self._excluded: list[set[int]] = [set() for _ in goals]
        # How often it was lost, and steps of searching since.
        self._lost, self._searched = np.zeros((2, count), dtype=int)
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
        for robot in robots[going][memory.lost[robots[going]]]:
            self._lose(int(robot))
        return actions

    def _search(self, observations: Observation, robots: Robots) -> Array:
        """Actions (M, 2) by which robots rotate."""
        self._searched[robots] += 1
        self.given_up[robots] |= self._searched[robots] > SEARCH_TIME / STEP
        beside = np.tile([0.0, ASIDE], (len(robots), 1))
        return self.follower.controller.act(observations, beside)

    def _plan(self, observation: Observation, robot: int) -> None:
        """Plan and start, or search, or give up."""
        plan = self._find_path(observation, self._goals[robot], self._excluded[robot])
        self.history[robot].append(plan)
        # A robot that was under way takes an improbable path rather than none.
        if not plan.refusal or (plan.probability > 0 and self._lost[robot]):
            self._searched[robot], self.plans[robot] = 0, plan
            path = [*plan.vertices, int(self._first[robot]) + plan.goal]
            self.follower.assign(robot, path, self._turns(plan))
        elif plan.probability > 0:
            # The best path is refused; to search elsewhere will not help.
            self.plans[robot], self.given_up[robot] = plan, True

    def _turns(self, plan: Plan) -> dict[int, float]:
        """The places of a plan before which the robot turns, and by how many rad."""
        edges = self._topomap.graph.edges
        steps = enumerate(pairwise(plan.vertices), start=1)
        found = {place: edges[step].get("turn") for place, step in steps}
        return {place: angle for place, angle in found.items() if angle is not None}

    def _lose(self, robot: int) -> None:
        """Replan in the next step; what could not be reached is excluded from now on."""
        plan, ahead = self.plans[robot], int(self.follower.memory.active[robot])
        if plan is not None and 0 <= ahead < len(plan.vertices):
            self._excluded[robot] |= self._around(plan.vertices[ahead])
        self._lost[robot] += 1
        if self._lost[robot] > self._replans:
            self.given_up[robot] = True
        else:
            self.plans[robot] = None

    def _around(self, vertex: int) -> set[int]:
        """A vertex, and those with edges from and to it: they are at the same place."""
        graph = self._topomap.graph
        return {vertex} | {
            other for other in graph.successors(vertex) if graph.has_edge(other, vertex)
        }


class MapTargets:
    """The vertices of a map as targets of C_WP and RE; each is encoded once.

    Attributes:
        topomap: the map, which may grow from one use to the next.
    """

    def __init__(
        self, topomap: TopoMap, predictor: WaypointPredictor, reachability: Reachability
    ) -> None:
        """Encode nothing yet."""
        self.topomap, self._encoders = topomap, (predictor, reachability)
        self._encoded = GrowingBatch(), GrowingBatch()

    def followed_by(self, contexts: NDArray) -> tuple[Targets, Any]:
        """The vertices and behind them other images (M, 2k+1, ...), for C_WP and for RE."""
        vertices, both = self.topomap.vertices, []
        for encoder, kept in zip(self._encoders, self._encoded, strict=True):
            fresh = np.arange(len(kept), len(vertices))
            if fresh.size:
                same = encoder is vertices.reachability
                kept.append(
                    vertices.prepared_targets(fresh)
                    if same
                    else encoder.prepare(vertices.contexts[fresh])
                )
            others = encoder.prepare(contexts)
            both.append(joined([kept[np.arange(len(kept))], others]) if len(kept) else others)
        return both[0], both[1]


@dataclass(kw_only=True)
class MapAgent(ABC):
    """An `Agent` that plans over a topological map and follows its plans by sight.

    Attributes:
        predictor: C_WP.
        controller: C_RMP.
        reachability: RE.
        follower: thresholds of the follower.
        replans: how often a robot that is lost replans before it gives up.
        topomap: what was learned.
    """

    predictor: WaypointPredictor
    controller: Controller
    reachability: Reachability
    follower: FollowerSettings = field(default_factory=FollowerSettings)
    replans: int = 8

    def __post_init__(self) -> None:
        self.topomap = self.empty_map()
        self._targets = MapTargets(self.topomap, self.predictor, self.reachability)

    @abstractmethod
    def empty_map(self) -> TopoMap:
        """A map to begin with."""

    @abstractmethod
    def find_path(self, observation: Observation, goals: Goals, excluded: set[int]) -> Plan:
        """Plan over the map from what one robot observes to a goal."""

    def start(self, goals: Sequence[Goals]) -> MapNavigation:
        """Send robots to one goal each."""
        make_follower = partial(
            Follower,
            predictor=self.predictor,
            controller=self.controller,
            reachability=self.reachability,
            settings=self.follower,
        )
        if self._targets.topomap is not self.topomap:
            self._targets = MapTargets(self.topomap, self.predictor, self.reachability)
        return MapNavigation(self.find_path, make_follower, self._targets, goals, self.replans)
