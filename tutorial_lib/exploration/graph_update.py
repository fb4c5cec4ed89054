"""Localising robots in their graphs, and adding nodes (Chaplot et al. 2020, 4.1, Graph Update)."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.exploration.bearings import DIRECTIONS, RADIUS, column_bearings
from tutorial_lib.exploration.ghost_graph import BESIDE, GhostGraph
from tutorial_lib.interfaces import ExplorationModel
from tutorial_lib.se2 import Array, compose, inverse, relative, to_world
from tutorial_lib.validation import flag, instance

_TRIED = 4  # nodes besides its own in which a robot is looked for
_WIDE = 0.22  # metres to either side that a robot needs
_FREE = 1.0  # metres that a direction is free, at least, to be kept in reserve


@dataclass(frozen=True)
class Localisation:
    """How a robot finds itself in its graph, where the course's agent departs from the paper (4.1).

    Attributes:
        all_nodes: F_L compares a panorama with every node, as in the paper; else with the robot's
            own and at most four that are within `BESIDE` by odometry. Over 500 steps odometry
            drifts by less than that, and fewer comparisons make fewer mistakes between places that
            look alike.
        edges_by_odometry: a new edge to a known node has its pose by odometry along the graph, as
            in the paper; else the robot's place in that node is F_R's.
        nodes_at_ghosts: a ghost that is reached becomes a node though F_L still has the robot in
            the old one. In the paper there is a new node only where a robot is in none; what
            becomes of such a ghost it does not say: here it goes.
    """

    all_nodes: bool = False
    edges_by_odometry: bool = False
    nodes_at_ghosts: bool = True

    def __post_init__(self) -> None:
        for name in ("all_nodes", "edges_by_odometry", "nodes_at_ghosts"):
            flag(name, getattr(self, name))


PAPER = Localisation(all_nodes=True, edges_by_odometry=True, nodes_at_ghosts=False)
"""The paper's rules."""


class ScanMatcher(Protocol):
    """Finds robots in nodes by the walls that both see."""

    def __call__(self, nodes: Array, ranges: Array, guesses: Array) -> Array:
        """Poses (M, 3) of robots in the frames of nodes; not a number where walls don't agree.

        Args:
            nodes: (M, W) metres in each column of the nodes' panoramas.
            ranges: (M, W) of what the robots see.
            guesses: (M, 3) where they seem to be.
        """


class Memory:
    """What one robot remembers.

    Attributes:
        graph: its nodes and ghosts.
        features: (D,) of each node's panorama.
        node: in which it is.
    """

    def __init__(self, graph: GhostGraph | None = None) -> None:
        """Begin with a graph, an empty one unless given."""
        self.graph = GhostGraph() if graph is None else graph
        self.features: list[NDArray[np.float32]] = []
        self.node = -1
        self._odometry, self._origin = np.zeros(3), np.zeros(3)

    @property
    def offset(self) -> Array:
        """(3,) the robot's pose in the frame of its node, by odometry."""
        return relative(self._origin, self._odometry)

    def move(self, odometry: Array) -> None:
        """The robot is now at `odometry` (3,)."""
        self._odometry = odometry

    def in_odometry(self, points: Array) -> Array:
        """Points (..., 2) of the node's frame in the frame of the odometry."""
        return to_world(self._origin, points)

    def pose_of(self, node: int) -> Array:
        """(3,) of a node in the frame of the odometry, along the graph."""
        return compose(self._origin, self.graph.poses_from(self.node)[node])

    def stand(self, node: int, offset: ArrayLike) -> None:
        """Be in a node from now on, at the pose `offset` (3,) in its frame."""
        self.node, self._origin = node, compose(self._odometry, inverse(offset))

    def others(self, *, everywhere: bool) -> list[int]:
        """The nodes but its own, the nearest first: all, or at most four within `BESIDE`."""
        gaps = self.graph.poses_from(self.node)[:, :2] - self.offset[:2]
        far = np.linalg.norm(gaps, axis=1)
        order = [int(n) for n in np.argsort(far, kind="stable") if n != self.node]
        return order if everywhere else [n for n in order if far[n] < BESIDE][:_TRIED]

    def pose_in(self, node: int) -> Array:
        """(3,) of the robot in another node's frame, by odometry along the graph."""
        return relative(self.graph.poses_from(self.node)[node], self.offset)

    def enter(self, node: int, pose: Array | None = None, *, sure: bool = False) -> None:
        """Be in another node from now on.

        Args:
            node: the node.
            pose: (3,) of the robot in its frame; by odometry unless given.
            sure: the pose is so good that it also mends an edge that is there.
        """
        pose = self.pose_in(node) if pose is None else pose
        if sure or node not in self.graph.edges[self.node]:
            self.graph.connect(self.node, node, compose(self.offset, inverse(pose)))
        self.stand(node, pose)


def free_metres(
    ranges: NDArray[np.floating], directions: int = DIRECTIONS, radius: float = RADIUS
) -> Array:
    """Metres (N, K), `radius` at most, that a robot can drive in each direction.

    Args:
        ranges: (N, W) metres in each column of the panorama.
        directions: K.
        radius: metres.
    """
    centres = np.arange(directions) * 2 * np.pi / directions
    offset = column_bearings(ranges.shape[1]) - centres[:, None]
    ahead, aside = np.cos(offset) * ranges[:, None], np.sin(offset) * ranges[:, None]
    in_the_way = (ahead > 0) & (np.abs(aside) < _WIDE)
    return np.clip(np.where(in_the_way, ahead - _WIDE, radius).min(axis=2), 0.0, radius)


class GraphUpdate:
    """Keeps the graphs of many robots up to date, with few calls of the model for all of them."""

    def __init__(
        self,
        model: ExplorationModel,
        same: float,
        explorable: float,
        radius: float = RADIUS,
        localisation: Localisation | None = None,
        matcher: ScanMatcher | None = None,
    ) -> None:
        """Set when answers of the model count, and what is explored.

        Args:
            model: F_L and F_G.
            same: probability of F_L from which a robot is in a node.
            explorable: probability of F_G from which a direction gets a ghost.
            radius: metres from a node to its ghosts.
            localisation: by which rules robots find themselves; the course's unless given.
            matcher: closes loops: wherever a robot is in a node its walls say where, and what
                odometry and F_R said is corrected.
        """
        localisation = Localisation() if localisation is None else localisation
        self.localisation = instance("localisation", localisation, Localisation)
        self._model, self._same, self._explorable = model, same, explorable
        self._radius, self._matcher = radius, matcher

    def update(
        self, memories: Sequence[Memory], features: NDArray[np.float32], ranges: Array
    ) -> NDArray[np.bool_]:
        """Localise each robot in its node, or in another one, or make a new node.

        Args:
            memories: of M robots.
            features: (M, D) of what they see.
            ranges: (M, W) metres.

        Returns:
            (M,) whether a node was made.
        """
        outside = np.array([not len(memory.graph) for memory in memories], dtype=bool)
        inside = np.flatnonzero(~outside)
        if len(inside):
            here = [memories[m] for m in inside.tolist()]
            own = np.array([memory.features[memory.node] for memory in here])
            lost = inside[self._model.same_node(own, features[inside]) < self._same]
            strays = [memories[m] for m in lost.tolist()]
            outside[lost[~self._elsewhere(strays, features[lost], ranges[lost])]] = True
            staying = np.setdiff1d(inside, lost)
            self._correct([memories[m] for m in staying.tolist()], ranges[staying])
        new = np.flatnonzero(outside)
        self.add_nodes([memories[m] for m in new.tolist()], features[new], ranges[new])
        return outside

    def add_nodes(
        self, memories: Sequence[Memory], features: NDArray[np.float32], ranges: Array
    ) -> None:
        """Make a node where each of these robots is; arguments as for `update`."""
        if not len(memories):
            return
        explorable = self._model.explorable(features) >= self._explorable
        free = free_metres(ranges, explorable.shape[1], self._radius)
        free[free < _FREE] = 0.0
        rows = zip(memories, features, explorable, free, ranges, strict=True)
        for memory, row, likely, metres, seen in rows:
            previous = memory.node if len(memory.graph) else None
            node = memory.graph.add_node(likely, metres, previous, memory.offset, seen)
            memory.stand(node, np.zeros(3))
            memory.features.append(row)

    def _correct(self, memories: Sequence[Memory], ranges: Array) -> None:
        """Robots that are in their nodes still: where exactly, by the walls."""
        if self._matcher is None or not len(memories):
            return
        nodes = np.stack([memory.graph.ranges[memory.node] for memory in memories])
        guesses = np.stack([memory.offset for memory in memories])
        poses = self._matcher(nodes, ranges, guesses)
        for memory, pose in zip(memories, poses, strict=True):
            if np.isfinite(pose).all():
                memory.stand(memory.node, pose)

    def _elsewhere(
        self, memories: Sequence[Memory], features: NDArray[np.float32], ranges: Array
    ) -> NDArray[np.bool_]:
        """(M,) whether a robot is in another node than its own; if so, it enters that."""
        rules = self.localisation
        nodes = [memory.others(everywhere=rules.all_nodes) for memory in memories]
        rows = np.repeat(np.arange(len(memories)), [len(near) for near in nodes])
        entered = np.zeros(len(memories), bool)
        if not len(rows):
            return entered
        pairs = [
            (memory, node) for memory, near in zip(memories, nodes, strict=True) for node in near
        ]
        sources = np.array([memory.features[node] for memory, node in pairs])
        likely = self._model.same_node(sources, features[rows])
        bearing, metres = self._model.relative(sources, features[rows]).T
        for row in np.unique(rows):
            mine = np.flatnonzero(rows == row)
            best = mine[likely[mine].argmax()]
            if likely[best] >= self._same:
                place = metres[best] * np.array([np.cos(bearing[best]), np.sin(bearing[best])])
                memory, node = pairs[best]
                self._enter(memory, node, place, ranges[row])
                entered[row] = True
        return entered

    def _enter(self, memory: Memory, node: int, place: Array, ranges: Array) -> None:
        """A robot is in another node: at a `place` (2,) by F_R; the walls know better."""
        guess = np.array([*place, memory.pose_in(node)[2]])
        if self._matcher is not None:
            (pose,) = self._matcher(memory.graph.ranges[node][None], ranges[None], guess[None])
            if np.isfinite(pose).all():
                memory.enter(node, pose, sure=True)
                return
        known = node in memory.graph.edges[memory.node] or self.localisation.edges_by_odometry
        memory.enter(node, None if known else guess)
