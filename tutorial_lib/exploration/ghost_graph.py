"""A graph of places with ghost nodes at its rim (Chaplot et al. 2020, 4.1, Graph Update)."""

from __future__ import annotations

import heapq
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.exploration.bearings import DIRECTIONS, RADIUS, bearing_of, bin_of, column_of
from tutorial_lib.se2 import Array, compose, inverse
from tutorial_lib.validation import flags, floats, instance, number, whole

BESIDE = 1.5 * RADIUS
"""Metres within which a node in sight stands in a direction of another one without an edge."""
EXPLORED = 1.0
"""Metres from a node within which a ghost is explored, in whatever direction."""
_MOST = 10_000  # directions
_AT = 0.05  # metres between two nodes that are at one place: neither is in a direction of the other


@dataclass(frozen=True)
class Ghost:
    """A place not explored yet; its picture is the patch of its node's panorama.

    Attributes:
        node: on which it hangs, the only one.
        direction: of the patch, a bin.
        metres: from the node.
    """

    node: int
    direction: int
    metres: float = RADIUS

    def __post_init__(self) -> None:
        whole("node", self.node, least=0)
        whole("direction", self.direction, least=0)
        number("metres", self.metres, least=0.0)


class GhostGraph:
    """Nodes, the edges between them, and ghosts.

    In the paper a ghost is removed when a node with an edge to its own stands in its direction.
    Departures, each measured with true geometry, noise and signs in 108 episodes of validation
    worlds 10,100 to 10,103: a ghost also goes when a node is within `EXPLORED` of it, and when one
    without an edge stands in its direction within `BESIDE` and in sight. These two change SPL by at
    most 0.02, with scores and without.

    A node's frame is the robot's pose when the node was made. An edge stores the pose of one node
    in the frame of the other by odometry; no pose is relative to anything farther away.

    Attributes:
        edges: for each node its neighbours' poses (3,) in its frame.
        ghosts: by node and direction.
        reserve: free directions that are no ghosts, for when these run out.
        directions: of each node.
        ranges: (W,) metres in each column of each node's panorama; empty where none were given.
    """

    def __init__(self, directions: int = DIRECTIONS, radius: float = RADIUS) -> None:
        """Start with an empty graph.

        Args:
            directions: of each node.
            radius: metres from a node to its ghosts.
        """
        self.directions = whole("directions", directions, least=1, most=_MOST)
        self._radius = number("radius", radius, least=0.0)
        self.edges: list[dict[int, Array]] = []
        self.ghosts: dict[tuple[int, int], Ghost] = {}
        self.reserve: dict[tuple[int, int], Ghost] = {}
        self.ranges: list[Array] = []
        self._paths: dict[int, tuple[NDArray[np.intp], list[int], Array]] = {}
        self._poses: dict[int, Array] = {}

    def __len__(self) -> int:
        return len(self.edges)

    def add_node(
        self,
        explorable: ArrayLike,
        free: ArrayLike | None = None,
        previous: int | None = None,
        pose: ArrayLike | None = None,
        ranges: ArrayLike | None = None,
    ) -> int:
        """Add a node with its ghosts, linked to the node before it.

        Args:
            explorable: (K,) whether each direction leads to explorable area (F_G).
            free: (K,) metres that each direction is free; those of the reserve have some.
            previous: the node where the robot was; none for the first one.
            pose: (3,) of the new node in the frame of `previous`.
            ranges: (W,) metres in each column of its panorama; without them it sees no other node.

        Returns:
            The new node.

        Raises:
            InputError: when there are not as many directions as the graph has; or there are nodes
                and `previous` is none of them, or it has no pose.
        """
        if len(self) and (previous is None or pose is None):
            raise InputError("node: link it to the one before; give previous and pose")
        explorable, node = flags("explorable", explorable, ("K",)), len(self)
        free = np.zeros(len(explorable)) if free is None else floats("free", free, ("K",))
        if previous is not None:
            whole("previous", previous, least=0, most=node - 1)
            pose = None if pose is None else floats("pose", pose, (3,))
        if ranges is not None:
            ranges = floats("ranges", ranges, ("W",), least=0.0, infinite=True)
        if not explorable.shape == free.shape == (self.directions,):
            raise InputError(
                f"directions: {explorable.shape} explorable, {free.shape} free; a node of this "
                f"graph has {self.directions}, as many as its model must have"
            )
        self.edges.append({})
        self._forget_paths()
        self.ranges.append(np.empty(0) if ranges is None else ranges)
        for direction in np.flatnonzero(explorable).tolist():
            self.ghosts[node, direction] = Ghost(node, direction, self._radius)
        for direction in np.flatnonzero(~explorable & (free > 0)).tolist():
            self.reserve[node, direction] = Ghost(node, direction, float(free[direction]))
        if previous is not None and pose is not None:
            self.connect(previous, node, pose)
        self._explore(node)
        return node

    def connect(self, first: int, second: int, pose: ArrayLike) -> None:
        """Link two nodes; no ghost of either stays in the direction of the other.

        Args:
            first: a node.
            second: another one.
            pose: (3,) of the second in the frame of the first.

        Raises:
            InputError: when they are one node, or one of them does not exist.
        """
        whole("first", first)
        whole("second", second)
        if first == second or not (0 <= first < len(self) and 0 <= second < len(self)):
            raise InputError(f"edge: first {first} to second {second}; give two of {len(self)}")
        pose = floats("pose", pose, (3,))
        self.edges[first][second], self.edges[second][first] = pose, inverse(pose)
        self._forget_paths()
        self._stands(first, pose)
        self._stands(second, inverse(pose))

    def absorb(self, other: GhostGraph, node: int, theirs: int, pose: ArrayLike) -> int:
        """Take over the nodes and ghosts of a graph of the same building.

        Args:
            other: the graph, of as many directions.
            node: of this graph.
            theirs: of the other.
            pose: (3,) of `theirs` in the frame of `node`.

        Returns:
            By how much the numbers of the other's nodes rose.

        Raises:
            InputError: when a graph has no such node, or they have not as many directions.
        """
        instance("other", other, GhostGraph)
        if other.directions != self.directions:
            raise InputError(f"other: {other.directions} directions; give {self.directions}")
        node = self._node("node", node)
        theirs = whole("theirs", theirs, least=0, most=len(other) - 1)
        pose, shift = floats("pose", pose, (3,)), len(self)
        self.edges += [{k + shift: v for k, v in edges.items()} for edges in other.edges]
        self.ranges += other.ranges
        for mine, more in ((self.ghosts, other.ghosts), (self.reserve, other.reserve)):
            moved = [replace(ghost, node=ghost.node + shift) for ghost in more.values()]
            mine.update({(ghost.node, ghost.direction): ghost for ghost in moved})
        self.connect(node, theirs + shift, pose)
        for new in range(shift, len(self)):
            self._explore(new)
        return shift

    def remove(self, ghost: Ghost) -> None:
        """Remove a ghost that was explored, or that cannot be reached."""
        instance("ghost", ghost, Ghost)
        self.ghosts.pop((ghost.node, ghost.direction), None)
        self.reserve.pop((ghost.node, ghost.direction), None)

    def use_reserve(self) -> None:
        """Make every direction of the reserve a ghost."""
        self.ghosts.update(self.reserve)
        self.reserve.clear()

    def _shortest(self, node: int) -> tuple[NDArray[np.intp], list[int], Array]:
        """Dijkstra's algorithm: the node before each (V,), -1 for none; nodes as they are reached.

        And the metres (V,) to each.

        Kept until the graph changes. scipy's takes a sparse matrix, which has no place for an edge
        of no length, and with it twice as long for fifteen nodes (1.3 times for forty).
        """
        if node in self._paths:
            return self._paths[node]
        metres, before = np.full(len(self), np.inf), np.full(len(self), -1)
        metres[node], waiting, order = 0.0, [(0.0, node)], []
        while waiting:
            far, here = heapq.heappop(waiting)
            if far > metres[here]:
                continue
            order.append(here)
            for other, pose in self.edges[here].items():
                total = far + float(np.hypot(pose[0], pose[1]))
                if total < metres[other]:
                    metres[other], before[other] = total, here
                    heapq.heappush(waiting, (total, other))
        self._paths[node] = before, order, metres
        return self._paths[node]

    def path(self, start: int, end: int) -> list[int]:
        """The nodes of the shortest path, both ends included."""
        before = self._shortest(self._node("end", end))[0]
        nodes = [self._node("start", start)]
        while nodes[-1] != end:
            nodes.append(int(before[nodes[-1]]))
        return nodes

    def metres_from(self, node: int) -> Array:
        """(V,) metres along the shortest paths from a node."""
        return self._shortest(self._node("node", node))[2]

    def poses_from(self, node: int) -> Array:
        """(V, 3) poses of all nodes in the frame of one, along shortest paths."""
        if self._node("node", node) not in self._poses:
            before, order, _ = self._shortest(node)
            poses = np.zeros((len(self), 3))
            for other in order[1:]:
                last = int(before[other])
                poses[other] = compose(poses[last], self.edges[last][other])
            self._poses[node] = poses
        return self._poses[node]

    def _node(self, name: str, node: int) -> int:
        return whole(name, node, least=0, most=len(self) - 1)

    def _forget_paths(self) -> None:
        self._paths.clear()
        self._poses.clear()

    def place_of(self, ghost: Ghost) -> Array:
        """(2,) where a ghost is in the frame of its node."""
        bearing = float(bearing_of(instance("ghost", ghost, Ghost).direction, self.directions))
        return ghost.metres * np.array([np.cos(bearing), np.sin(bearing)])

    def _stands(self, node: int, pose: Array) -> None:
        """Another node is at `pose` in the frame of this one: its ghosts there are explored."""
        direction = int(bin_of(np.arctan2(pose[1], pose[0]), self.directions))
        apart = np.hypot(pose[0], pose[1]) > _AT
        for table in (self.ghosts, self.reserve):
            if apart:
                table.pop((node, direction), None)
            for ghost in [g for g in table.values() if g.node == node]:
                if np.linalg.norm(self.place_of(ghost) - pose[:2]) < EXPLORED:
                    del table[node, ghost.direction]

    def _explore(self, node: int) -> None:
        """Remove the ghosts that a new node explores, its own and those of nodes beside it."""
        poses = self.poses_from(node)
        beside = np.flatnonzero(np.linalg.norm(poses[:, :2], axis=1) < BESIDE)
        beside = beside[beside != node].tolist()
        for other in beside:
            back = inverse(poses[other])
            if self._sees(node, poses[other, :2]) or self._sees(other, back[:2]):
                self._stands(node, poses[other])
                self._stands(other, back)

    def _sees(self, viewer: int, place: Array) -> bool:
        """Whether a node sees a place (2,) in its frame; one that was made without ranges does not.

        No column on either side may be nearer, since places are by odometry.
        """
        count = len(self.ranges[viewer])
        if not count:
            return False
        column = int(column_of(np.arctan2(place[1], place[0]), count))
        around = self.ranges[viewer][np.arange(column - 1, column + 2) % count]
        return bool(np.linalg.norm(place) < around.min())
