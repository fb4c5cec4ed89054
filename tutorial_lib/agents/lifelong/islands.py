"""Graphs that a robot cannot join yet, since somebody carried it from one to another."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.looks import Looks
from tutorial_lib.agents.track import Track
from tutorial_lib.agents.walls import match_all_around
from tutorial_lib.exploration.graph_update import Memory
from tutorial_lib.interfaces import ExplorationModel
from tutorial_lib.se2 import Array, compose, inverse, relative, wrap

_AGREE = 0.9  # share of the points that a panorama and a known node's must confirm
_TRIED = 6  # nodes of an island whose walls are compared with what is seen
_NEAR, _TURNED = 0.5, float(np.deg2rad(15.0))  # between what two looks say of one place


@dataclass(eq=False)
class Island:
    """A graph with all that belongs to it, in one frame.

    Attributes:
        memory: the graph, and where in it the robot is or was.
        looks: taken there.
        scores: (K,) of each node's directions.
        track: of the robot.
    """

    memory: Memory
    looks: Looks
    scores: list[Array]
    track: Track

    def absorb(self, other: Island, node: int, pose: Array) -> None:
        """Take over an island whose robot is at `pose` (3,) in one of this one's nodes."""
        memory = self.memory
        motion = compose(compose(memory.pose_of(node), pose), inverse(other.track.pose))
        if len(other.memory.graph):
            theirs = other.memory.node
            edge = compose(pose, inverse(other.memory.offset))
            memory.graph.absorb(other.memory.graph, node, theirs, edge)
            memory.features += other.memory.features
            self.scores += other.scores
        self.looks.absorb(other.looks, motion)
        self.track.absorb(other.track, motion)
        memory.move(self.track.pose)
        memory.stand(node, pose)


@dataclass(frozen=True, eq=False)
class Recognised:
    """A place of an island.

    Attributes:
        island: its number.
        node: of the island.
        pose: (3,) of the robot in that node's frame.
        seen: (3,) where the robot was by its own track.
    """

    island: int
    node: int
    pose: Array
    seen: Array


class Islands:
    """The islands of one robot that are not joined with the graph it is in."""

    def __init__(self, model: ExplorationModel, same: float) -> None:
        """A robot may be in a node from probability `same` of F_L on."""
        self._model, self._same = model, same
        self.left: list[Island] = []
        self._last: Recognised | None = None

    def leave(self, island: Island) -> None:
        """The robot is somewhere else now."""
        self.left.append(island)
        self._last = None

    def recognise(
        self, pose: Array, ranges: Array, features: NDArray[np.float32]
    ) -> Recognised | None:
        """A place of an island on which two looks agree; None where there is none: *lost*."""
        last, self._last = self._last, None
        for number in range(len(self.left)):
            found = self._find(number, pose, ranges, features)
            if found is None:
                continue
            self._last = found
            if last is not None and last.island == number and self._agree(last, found):
                return found
        return None

    def join(self, found: Recognised, here: Island) -> Island:
        """The island with all that the robot learned since it left it; it is no island any more."""
        island = self.left.pop(found.island)
        self._last = None
        pose = compose(found.pose, relative(found.seen, here.track.pose))
        island.absorb(here, found.node, pose)
        return island

    def _find(
        self, number: int, pose: Array, ranges: Array, features: NDArray[np.float32]
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
        return Recognised(number, int(best[row]), poses[row], pose)

    def _agree(self, last: Recognised, found: Recognised) -> bool:
        """Whether two looks mean the same place, by the track between them."""
        graph = self.left[found.island].memory.graph
        before = compose(graph.poses_from(found.node)[last.node], last.pose)
        gap = relative(compose(before, relative(last.seen, found.seen)), found.pose)
        return bool(np.hypot(gap[0], gap[1]) < _NEAR and abs(wrap(gap[2])) < _TURNED)
