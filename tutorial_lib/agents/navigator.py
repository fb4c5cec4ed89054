"""A fleet that plans over a map, follows its plans by sight, and plans anew when it is lost.

Who knows no way from where it stands turns around to look for one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.agent import Robots
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Observation
from tutorial_lib.topology.following.anchor_paths import AnchorPaths
from tutorial_lib.topology.following.follower import Follower
from tutorial_lib.topology.following.heading_search import ASIDE
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.topology.planner import Goals, Plan
from tutorial_lib.world.simulation import STEP

LOOK_AROUND = 20.0
"""Seconds of turning around after which a robot that knows no way gives up."""
_GLANCE = 10  # steps from one attempt to plan to the next, while turning
FindWay = Callable[[Observation, Goals, set[int]], Plan]
"""Plans from what one robot sees to a goal, past some vertices."""


class MapNavigation:
    """N robots on their ways, each to its own goal.

    Attributes:
        plans: the last plan of each robot; none before it looked around for the first time.
        history: all plans of each robot.
        arrived: (N,) who declares to have arrived.
        given_up: (N,) who does not know a way, or lost it too often.
        run: how the plans are followed.
    """

    def __init__(
        self,
        find_way: FindWay,
        follower: Follower,
        topomap: TopoMap,
        goals: Sequence[Goals],
        replans: int,
    ) -> None:
        """Robots plan when they act for the first time.

        Args:
            find_way: plans.
            follower: drives.
            topomap: the map; it must not grow on the way.
            goals: one for each robot.
            replans: how often a robot that was lost plans anew before it gives up.
        """
        self._find_way, self._topomap, self._replans = find_way, topomap, replans
        count, self._goals = len(goals), list(goals)
        self.plans: list[Plan | None] = [None] * count
        self.history: list[list[Plan]] = [[] for _ in goals]
        self.arrived, self.given_up = np.zeros(count, bool), np.zeros(count, bool)
        self._shunned: list[set[int]] = [set() for _ in goals]
        # How often it was lost, and steps of looking around since.
        self._lost, self._looked = np.zeros((2, count), dtype=int)
        contexts = [goal.contexts for goal in goals]
        if len(topomap):
            contexts.insert(0, topomap.vertices.contexts[np.arange(len(topomap.vertices))])
        self._first = np.cumsum([len(topomap.vertices), *(len(goal) for goal in goals)])
        laid = np.concatenate(contexts)
        trails = AnchorPaths(
            follower.predictor.prepare(laid),
            follower.reachability.prepare(laid),
            [[first] for first in self._first[:-1]],
        )
        self.run = follower.begin(trails, np.zeros(count, dtype=int))

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
        """The same for robots that are neither there nor gave up."""
        for row, robot in enumerate(robots):
            if self.plans[robot] is None and self._looked[robot] % _GLANCE == 0:
                self._plan(observations[row], int(robot))
        actions = np.zeros((len(robots), 2))
        under_way = np.array([self.plans[robot] is not None for robot in robots], dtype=bool)
        going = np.flatnonzero(under_way & ~self._over[robots])
        actions[going] = self.run.act(observations[going], robots[going])
        self.arrived[robots[going]] = self.run.done[robots[going]]
        looking = np.flatnonzero(~under_way)
        if looking.size:
            actions[looking] = self._look_around(observations[looking], robots[looking])
        for robot in robots[going][self.run.lost[robots[going]]]:
            self._lose(int(robot))
        return actions

    def _look_around(self, observations: Observation, robots: Robots) -> Array:
        """Actions (M, 2) by which robots turn."""
        self._looked[robots] += 1
        self.given_up[robots] |= self._looked[robots] > LOOK_AROUND / STEP
        beside = np.tile([0.0, ASIDE], (len(robots), 1))
        return self.run.controller.act(observations, beside)

    def _plan(self, observation: Observation, robot: int) -> None:
        """Plan and set out, or look around for a way, or give up."""
        plan = self._find_way(observation, self._goals[robot], self._shunned[robot])
        self.history[robot].append(plan)
        # Who was under way takes any way rather than none.
        if not plan.refusal or (plan.probability > 0 and self._lost[robot]):
            self._looked[robot], self.plans[robot] = 0, plan
            self.run.start(robot, [*plan.vertices, int(self._first[robot]) + plan.goal])
        elif plan.probability > 0:
            # It knows a way, and does not trust it: to look elsewhere will not help.
            self.plans[robot], self.given_up[robot] = plan, True

    def _lose(self, robot: int) -> None:
        """Plan anew in the next step; what could not be reached is excluded from now on."""
        plan, ahead = self.plans[robot], int(self.run.active[robot])
        if plan is not None and 0 <= ahead < len(plan.vertices):
            self._shunned[robot] |= self._beside(plan.vertices[ahead])
        self._lost[robot] += 1
        if self._lost[robot] > self._replans:
            self.given_up[robot] = True
        else:
            self.plans[robot] = None

    def _beside(self, vertex: int) -> set[int]:
        """A vertex, and those from which one gets to it and back: they are where it is."""
        graph = self._topomap.graph
        return {vertex} | {
            other for other in graph.successors(vertex) if graph.has_edge(other, vertex)
        }
