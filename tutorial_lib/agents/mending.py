"""Meng's map, kept up to date as LTVN keeps its own: what fails is believed less, and pruned."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np

from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.agents.navigator import MapNavigation, Setback
from tutorial_lib.interfaces import Goals, Observation, Plan, Robots
from tutorial_lib.se2 import Array
from tutorial_lib.topology.maintenance import CERTAIN, Maintenance, MaintenanceRules, Traversal
from tutorial_lib.topology.mapping.anchors import Anchors
from tutorial_lib.topology.mapping.edge_rules import weight
from tutorial_lib.validation import instance, number


@dataclass(kw_only=True)
class MendingMengAgent(MengAgent):
    """Meng's agent; what its robots experience changes the beliefs about the map's edges.

    Attributes:
        maintenance: what changes. Nothing is known of lengths; a map has no unused images.
        doubt: by how much a path over an edge that failed costs more: this times the fall of the
            log of the belief in it. At 1 an edge that failed once costs as much as two dozen that
            RE is sure of, and robots that go round it are late.
        upkeep: of a copy of the map's graph, whose probabilities are beliefs. The map's own stay
            RE's, by which plans are refused.
    """

    maintenance: MaintenanceRules = field(default_factory=MaintenanceRules)
    doubt: float = 0.2

    def __post_init__(self) -> None:
        instance("maintenance", self.maintenance, MaintenanceRules)
        number("doubt", self.doubt, least=0.0)
        super().__post_init__()
        self._keep_up()

    def _keep_up(self) -> None:
        graph = self.topomap.graph
        for *_, edge in graph.edges(data=True):
            edge["weight"] = float(weight(edge["probability"]))
        self.upkeep = Maintenance(graph.copy(), self.maintenance, price=1.0, noise=1.0)

    def insert(self, anchors: Anchors) -> None:
        """See `MengAgent`; upkeep begins anew, since edges that were there may have changed."""
        super().insert(anchors)
        self._keep_up()

    def start(self, goals: Sequence[Goals]) -> MendingNavigation:
        """Send robots to one goal each; all mend the same map. See `MapAgent`."""
        return MendingNavigation(self.upkeep, self.doubt, *self._parts(goals))


class MendingNavigation(MapNavigation):
    """A `MapNavigation` over Meng's map that tells its upkeep what robots experience.

    Attributes:
        traversals: all so far.
    """

    def __init__(self, upkeep: Maintenance, doubt: float, *parts: Any) -> None:  # noqa: ANN401
        """See `MapNavigation`, whose `parts` follow, and `MendingMengAgent`."""
        super().__init__(*parts)
        self._upkeep, self._doubt = upkeep, doubt
        self.traversals: list[Traversal] = []
        # Of each robot its plan, its place on it, and how many of its edges it has passed.
        count = len(self.plans)
        self._followed: list[Plan | None] = [None] * count
        self._visited, self._passed = np.full(count, -1), np.zeros(count, dtype=int)

    def act(self, observations: Observation, robots: Robots) -> Array:
        """See `MapNavigation`; what robots experienced changes the beliefs."""
        known = len(self.setbacks)
        actions = super().act(observations, robots)
        for setback in self.setbacks[known:]:
            self._set_back(setback)
        for robot in robots:
            self._follow(int(robot))
        return actions

    def _path(self, observation: Observation, robot: int) -> Plan:
        """A path over edges that are not pruned; or over those that failed, where no other is left.

        Those on it return: to try one again beats giving up.
        """
        excluded, goal = self._excluded(observation, robot), self._goals[robot]
        pruned, blocked = set(self._upkeep.pruned), self._upkeep.blocked
        plan = self._find_path(observation, goal, excluded | pruned)
        if plan.probability > 0 or pruned == blocked:
            return plan
        plan = self._find_path(observation, goal, excluded | blocked)
        for edge in pruned.intersection(pairwise(plan.vertices)):
            self._upkeep.bring_back(edge)
            self._weigh(edge)
        return plan

    def _follow(self, robot: int) -> None:
        """Note the edges that a robot has passed since the last step."""
        plan, visited = self.plans[robot], self.follower.memory.visited[robot]
        if plan is not self._followed[robot]:
            self._followed[robot], self._passed[robot] = plan, 0
        elif plan is not None and visited > self._visited[robot] >= 0:
            path = plan.vertices[self._visited[robot] : visited + 1]
            for edge in pairwise(path):
                self._passed[robot] += 1
                self._learn(Traversal(edge, "local", True))
        self._visited[robot] = visited

    def _set_back(self, setback: Setback) -> None:
        """What blocks is left out for a time; of a lost robot the edge is to blame.

        Blame is withheld where the robot has passed no edge of its plan: it may be elsewhere.
        """
        edge = setback.path[max(setback.ahead - 1, 0)], setback.path[setback.ahead]
        if setback.blocked:
            self._learn(Traversal(edge, "local", False, blocked=tuple(sorted(setback.edges))))
        elif self._passed[setback.robot] and setback.ahead > 0:
            self._learn(Traversal(edge, "local", False))

    def _learn(self, traversal: Traversal) -> None:
        self.traversals.append(traversal)
        self._upkeep.experienced(traversal)
        self._weigh(traversal.edge)

    def _weigh(self, edge: tuple[int, int]) -> None:
        """Let an edge cost what the belief in it says, unless it is pruned now."""
        if self._upkeep.graph.has_edge(*edge):
            belief = self._upkeep.graph.edges[edge]["probability"]
            known = self._topomap.graph.edges[edge]
            fall = max(float(np.log(min(known["probability"], CERTAIN) / belief)), 0.0)
            known["weight"] = float(weight(known["probability"])) + self._doubt * fall
