"""Graphs that a robot cannot join yet, since somebody carried it from one to another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.looks import Looks
from tutorial_lib.agents.walls import goes_on, match_all_around
from tutorial_lib.exploration.graph_update import Memory
from tutorial_lib.interfaces import ExplorationModel
from tutorial_lib.se2 import Array, compose, inverse, relative, wrap

_GOES_ON = 0.75  # share of what is seen that must fit to what was seen before
_AGREE = 0.9  # share of the points that a panorama and a known node's must confirm
_TRIED = 6  # nodes of an island whose walls are compared with what is seen
_NEAR, _TURNED = 0.5, float(np.deg2rad(15.0))  # between what two looks say of one place


@dataclass(eq=False)
class Island:
    """A graph with all that belongs to it.

    Attributes:
        memory: the graph, and where in it the robot is or was.
        looks: taken there.
        scores: (K,) of each node's directions.
    """

    memory: Memory
    looks: Looks
    scores: list[Array]


@dataclass(frozen=True, eq=False)
class Recognised:
    """A place of an island.

    Attributes:
        island: its number.
        node: of the island.
        pose: (3,) of the robot in that node's frame.
        odometry: (3,) of the robot.
    """

    island: int
    node: int
    pose: Array
    odometry: Array


class Islands:
    """The islands of one robot that are not joined with the graph it is in."""

    def __init__(self, model: ExplorationModel, same: float) -> None:
        """A robot may be in a node from probability `same` of F_L on."""
        self._model, self._same = model, same
        self.left: list[Island] = []
        self._before: tuple[Array, Array] | None = None
        self._last: Recognised | None = None

    def was_carried(self, odometry: Array, ranges: Array) -> bool:
        """Whether what a robot sees does not go on from its last look."""
        before, self._before = self._before, (odometry, ranges)
        if before is None:
            return False
        motion = relative(before[0], odometry)
        return bool(goes_on(before[1][None], ranges[None], motion[None])[0] < _GOES_ON)

    def leave(self, island: Island) -> None:
        """The robot is somewhere else now."""
        self.left.append(island)
        self._last = None

    def recognise(
        self, odometry: Array, ranges: Array, features: NDArray[np.float32]
    ) -> Recognised | None:
        """A place of an island on which two looks agree; None where there is none: *lost*."""
        last, self._last = self._last, None
        for number in range(len(self.left)):
            found = self._find(number, odometry, ranges, features)
            if found is None:
                continue
            self._last = found
            if last is not None and last.island == number and self._agree(last, found):
                return found
        return None

    def _find(
        self, number: int, odometry: Array, ranges: Array, features: NDArray[np.float32]
    ) -> Recognised | None:
        """The node of an island whose picture and walls are those that the robot sees."""
        memory = self.left[number].memory
        nodes = np.array(memory.features)
        seen = np.repeat(features[None], len(nodes), axis=0)
        likely = self._model.same_node(nodes, seen)
        best = np.argsort(-likely, kind="stable")[:_TRIED]
        best = best[likely[best] >= self._same]
        if not len(best):
            return None
        bearing, metres = self._model.relative(nodes[best], seen[best]).T
        guesses = np.stack([metres * np.cos(bearing), metres * np.sin(bearing), 0 * metres], axis=1)
        walls = np.stack([memory.graph.ranges[node] for node in best.tolist()])
        around = np.repeat(ranges[None], len(best), axis=0)
        poses, shares = match_all_around(walls, around, guesses, _AGREE)
        shares = np.where(np.isfinite(poses[:, 0]), shares, -1.0)
        row = int(shares.argmax())
        if shares[row] < _AGREE:
            return None
        return Recognised(number, int(best[row]), poses[row], odometry)

    def _agree(self, last: Recognised, found: Recognised) -> bool:
        """Whether two looks mean the same place, by the odometry between them."""
        graph = self.left[found.island].memory.graph
        before = compose(graph.poses_from(found.node)[last.node], last.pose)
        gap = relative(compose(before, relative(last.odometry, found.odometry)), found.pose)
        return bool(np.hypot(gap[0], gap[1]) < _NEAR and abs(wrap(gap[2])) < _TURNED)

    def join(self, found: Recognised, here: Island) -> Island:
        """The island with all that the robot learned since it left it; it is no island any more."""
        island = self.left.pop(found.island)
        self._last = None
        memory, graph = island.memory, island.memory.graph
        memory.move(found.odometry)
        if not len(here.memory.graph):
            memory.stand(found.node, found.pose)
            return island
        theirs = here.memory.node
        pose = compose(found.pose, inverse(here.memory.offset))
        shift = graph.absorb(here.memory.graph, found.node, theirs, pose)
        memory.features += here.memory.features
        island.looks.absorb(here.looks, shift)
        memory.stand(found.node, found.pose)
        return Island(memory, island.looks, island.scores + here.scores)
