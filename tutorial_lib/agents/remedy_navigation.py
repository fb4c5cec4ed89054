"""Navigation that does not rely on a single view: replanning, visit counts, a belief, recovery."""

import copy
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.navigator import MapNavigation
from tutorial_lib.agents.place_guess import PlaceGuess, Weighted
from tutorial_lib.agents.remedies import Tools
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Edges, Observation, Plan, Robots
from tutorial_lib.topology.following.transitions import State
from tutorial_lib.topology.mapping.edge_rules import weight
from tutorial_lib.topology.mapping.topomap import TopoMap

CYCLE, ENDLESS = 3, 6
"""Visits of one vertex that make a cycle, and those after which a robot gives up."""
BIAS = 0.5
"""Factor on the probability of edges to a vertex for each visit but the first."""
_DOUBT = 10  # steps of dead reckoning from one attempt to find another plan to the next
_FADES = 0.99  # for each step of dead reckoning, what the old plan is worth
_ELSEWHERE = 0.9  # see `PlaceGuess.far_from`: so far from its plan a robot is elsewhere
_AGREE = 3  # looks in a row that must say so
_TURNING, _PERIOD = 40, 55  # steps of a search: turning, and backing up until its period is over
_BACK = 0.6  # metres to a waypoint behind


class RemedyNavigation(MapNavigation):
    """A `MapNavigation` of N robots with remedies for places that look alike.

    Attributes:
        guess: where the robots may be.
        visits: (N, V) how often each robot came to each vertex, by its number.
        lost: (N,) gave up since no vertex was plausible, after turning and backing up.
    """

    def __init__(self, tools: Tools, *parts: Any) -> None:  # noqa: ANN401
        """See `MapNavigation`, whose `parts` follow."""
        super().__init__(*parts)
        self._tools, self._on, count = tools, tools.remedies, len(self.plans)
        vertices = len(self._topomap.vertices)
        self.guess = PlaceGuess(count, self._topomap, tools, self.follower.paths.targets)
        self.visits = np.zeros((count, vertices), dtype=int)
        self.lost = np.zeros(count, dtype=bool)
        self._last = np.full(count, -1)  # vertex that was last visited
        self._ready: dict[int, Plan] = {}
        self._reckoned, self._disagreed = np.zeros((2, count), dtype=int)
        self._agreed = np.zeros(count, dtype=bool)  # was believed to be on its plan once
        edges = self._topomap.graph.edges(data="turn")
        self._turns_at: Edges = {(v, w) for v, w, turn in edges if turn is not None}

    def _act(self, observations: Observation, robots: Robots) -> Array:
        looked = self.guess.observe(observations, robots)
        actions = super()._act(observations, robots)
        for row, robot in enumerate(robots.tolist()):
            if self.plans[robot] is None or self._over[robot]:
                self._reckoned[robot] = self._disagreed[robot] = 0
                continue
            self._count_visit(robot)
            if self._on.replan:
                self._doubt(observations[row], robot)
            if self._on.filter and looked[row]:
                self._compare(robot)
        return actions

    # Localization and planning.

    def _plan(self, observation: Observation, robot: int) -> None:
        """Plan and start, or search; with the filter, a refusal is not the end.

        From elsewhere the robot may know better where it is.
        """
        super()._plan(observation, robot)
        self._agreed[robot] = False
        if self._on.filter and self.given_up[robot]:
            self.given_up[robot], self.plans[robot] = False, None

    def _path(self, observation: Observation, robot: int) -> Plan:
        """The plan that is ready, or a new one from where the robot may be.

        No sequence confirms an edge on which a robot turns: it rests on a single place, whose twin
        would look the same. Where sequences count, turns are for goals that no other path leads to.
        """
        if robot in self._ready:
            return self._ready.pop(robot)
        topomap, likely = self._topomap, self.guess.weights(observation, robot)
        if self._on.cycles:
            topomap = self._biased(robot)
            likely = likely * self._worth(robot)[topomap.alive]
        planner = self._tools.planner
        # The threshold is on RE; what an unlikely start is worth may be less.
        localizer = Weighted(likely, planner.p_query, planner.candidates)
        planner = replace(planner, localizer=localizer, p_query=0.0)
        excluded, goals = self._excluded(observation, robot), self._goals[robot]
        if self._on.sequence and self._turns_at:
            plan = planner.plan(observation, goals, topomap, excluded | self._turns_at)
            if not plan.refusal:
                return plan
        return planner.plan(observation, goals, topomap, excluded)

    def _excluded(self, observation: Observation, robot: int) -> Edges:
        """With the filter the belief says where a plan may begin."""
        if not self._on.filter:
            return super()._excluded(observation, robot)
        return self._blockades.excluded(robot, observation.odometry[0], self._now[robot])

    def _lose(self, robot: int, odometry: Array) -> None:
        """Replan; if the robot is not where its plan has it, no edge is to blame."""
        plan = self.plans[robot]
        blameless = self._on.filter and plan is not None and self._elsewhere(robot, plan) > 0.5
        if blameless:
            self.plans[robot] = None
        super()._lose(robot, odometry)

    # Replanning on a discrepancy.

    def _doubt(self, observation: Observation, robot: int) -> None:
        """In dead reckoning, take another plan if it is better than what is left of this one."""
        reckons = self.follower.memory.state[robot] == State.DEAD_RECKONING
        self._reckoned[robot] = self._reckoned[robot] + 1 if reckons else 0
        steps, plan = int(self._reckoned[robot]), self.plans[robot]
        if plan is None or not steps or steps % _DOUBT:
            return
        left = float(np.prod(plan.probabilities[self.follower.memory.active[robot] :]))
        other = self._path(observation, robot)
        if not other.refusal and other.probability > left * _FADES**steps:
            self._ready[robot], self.plans[robot] = other, None

    # Cycles.

    def _count_visit(self, robot: int) -> None:
        """Count visits of vertices; in a cycle, plan around what was visited, or give up."""
        plan, place = self.plans[robot], int(self.follower.memory.visited[robot])
        if plan is None or not 0 <= place < len(plan.vertices):
            return
        vertex = plan.vertices[place]
        if vertex == self._last[robot]:
            return
        self._last[robot] = vertex
        self.visits[robot, vertex] += 1
        if self._on.cycles and self.visits[robot, vertex] >= CYCLE:
            self.given_up[robot] |= self.visits[robot, vertex] >= ENDLESS
            self.plans[robot] = None

    def _worth(self, robot: int) -> Array:
        """(V,) factors on the probability of edges to each vertex."""
        return BIAS ** np.maximum(self.visits[robot] - 1, 0)

    def _biased(self, robot: int) -> TopoMap:
        """The map, with edges to vertices that were visited twice or more less probable."""
        biased = copy.copy(self._topomap)
        biased.graph = self._topomap.graph.copy()
        factor = self._worth(robot)
        visited = np.flatnonzero(factor < 1).tolist()
        for _, target, edge in biased.graph.in_edges(visited, data=True):
            edge["probability"] *= factor[target]
            edge["weight"] = float(weight(edge["probability"]))
        return biased

    # The belief, and recovery off the map.

    def _compare(self, robot: int) -> None:
        """Drop the plan of a robot that is believed to have left it, several looks in a row.

        A plan that begins where the robot hardly can be was a guess from the start: it is dropped
        only after the belief has been with it.
        """
        plan = self.plans[robot]
        if plan is None:
            return
        elsewhere = self._elsewhere(robot, plan) > _ELSEWHERE
        off_map = self.guess.off_map(robot) > 0.5
        follows = self.follower.memory.state[robot] == State.FOLLOW
        self._agreed[robot] |= not elsewhere
        # Between vertices a robot may seem to be off the map; while it follows all is well.
        void = elsewhere and self._agreed[robot] and not (off_map and follows)
        self._disagreed[robot] = self._disagreed[robot] + 1 if void else 0
        if self._disagreed[robot] >= _AGREE:
            self._disagreed[robot] = 0
            self.plans[robot] = None

    def _elsewhere(self, robot: int, plan: Plan) -> float:
        """How far a robot is from the vertices of its plan between which it drives."""
        active = int(self.follower.memory.active[robot])
        around = [*plan.vertices[max(active - 2, 0) : active + 2], *plan.vertices[-1:]]
        return self.guess.far_from(robot, around) if around else 0.0

    def _search(self, observations: Observation, robots: Robots) -> Array:
        """Actions (M, 2) by which robots turn and, with the filter, back up now and then."""
        actions = super()._search(observations, robots)
        self.lost[robots] |= self.given_up[robots]
        back: NDArray[np.intp] = np.flatnonzero(self._searched[robots] % _PERIOD >= _TURNING)
        if self._on.filter and back.size:
            behind = np.tile([-_BACK, 0.0], (len(back), 1))
            actions[back] = self.follower.controller.act(observations[back], behind)
        return actions
