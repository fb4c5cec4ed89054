"""Geodesics: shortest paths through the free space of a plan, on a grid."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, dijkstra

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.validation import alike, flag, floats, instance, integers, number, whole
from tutorial_lib.world.occupancy import ClearanceGrid
from tutorial_lib.world.raycast import Raycaster

CLEARANCE = 0.25
"""Metres between planned paths and the nearest wall."""

# Half of the 16 steps of a king and a knight; the others are their opposites.
_STEPS = [(0, 1), (1, 0), (1, 1), (1, -1), (1, 2), (2, 1), (2, -1), (1, -2)]
_NO_NODE = -9999
_NEAR = 0.45  # metres within which a point belongs to a node
_AT_ONCE = 256  # distance fields are held in memory
_BUCKETS, _WIDTH = 4, 0.9  # of distances, and each one's width in nodes: less than a step


@dataclass(frozen=True)
class DistanceFields:
    """How far every place is from each of G goals.

    Attributes:
        paths: the grid they belong to.
        goals: (G, 2) metres.
        gaps: (G,) metres from each goal to its node.
        cost: (G, K) for each node of the grid metres, or weighted metres; inf where no path leads.
        towards: (G, K) the next node on the path to the goal.
    """

    paths: "GridPaths"
    goals: Array
    gaps: Array
    cost: Array
    towards: NDArray[np.int32]

    def distance(self, points: ArrayLike, goals: NDArray[np.intp] | int = 0) -> Array:
        """Cost (N,) from points (N, 2), each to the goal of that index; inf without a path."""
        points = floats("points", points, ("N", 2))
        goals = integers("goals", goals, (...,), least=0, most=len(self.goals) - 1)
        if goals.ndim:
            alike(points=points, goals=goals)
        nodes, gap = self.paths.nearest(points)
        cost = np.where(nodes >= 0, self.cost[goals, nodes], np.inf)
        direct = np.linalg.norm(points - self.goals[goals], axis=-1)
        # At nodes that are the same or neighbours, the straight line is the better measure.
        beside = cost < 1.5 * self.paths.resolution
        return np.where(beside, direct, cost + gap + self.gaps[goals])

    def path(self, start: ArrayLike, goal: int = 0) -> Array:
        """The path from `start` (2,) to a goal as points (P, 2), start and goal included.

        Raises:
            InputError: when there is none.
        """
        start = floats("start", start, (2,))
        goal = whole("goal", goal, least=0, most=len(self.goals) - 1)
        node = int(self.paths.nearest(start)[0])
        if node < 0 or not np.isfinite(self.cost[goal, node]):
            raise InputError(
                f"start: no path from {start.round(2).tolist()} to "
                f"{self.goals[goal].round(2).tolist()}; choose both in one open space"
            )
        nodes = []
        while node != _NO_NODE:
            nodes.append(node)
            node = int(self.towards[goal, node])
        between = self.paths.points[nodes[1:-1]]
        return np.concatenate([start[None], between, self.goals[goal][None]])

    def waypoints(
        self, points: ArrayLike, goals: NDArray[np.intp], caster: Raycaster, reach: float
    ) -> Array:
        """The farthest point of each path that lies in line of sight, as in Meng 2020's code.

        Args:
            points: (N, 2) where the robots are.
            goals: (N,) index of each robot's goal.
            caster: the walls.
            reach: metres of the path that are considered.

        Returns:
            (N, 2) points of the world; the robot's own place where none is in sight.
        """
        points, reach = floats("points", points, ("N", 2)), number("reach", reach, least=0)
        goals = integers("goals", goals, ("N",), least=0, most=len(self.goals) - 1)
        alike(points=points, goals=goals)
        instance("caster", caster, Raycaster)
        nodes, _ = self.paths.nearest(points)
        places, near, gone = [points], [np.ones(len(points), bool)], np.zeros(len(points))
        going = near[0]
        while going.any():
            arrived = (nodes < 0) | (self.towards[goals, nodes] == _NO_NODE)
            place = np.where(arrived[:, None], self.goals[goals], self.paths.points[nodes])
            gone = gone + np.linalg.norm(place - places[-1], axis=1)
            near.append(going & (gone <= reach))
            places.append(place)
            going = near[-1] & ~arrived
            nodes = np.where(arrived, nodes, self.towards[goals, nodes])
        paths, near = np.stack(places), np.stack(near)
        # All in one call; a place beyond one that is hidden does not count.
        ahead = paths[1:].reshape(-1, 2)
        sight = caster.sees(np.broadcast_to(points, paths[1:].shape).reshape(-1, 2), ahead)
        seen = np.logical_and.accumulate(sight.reshape(near[1:].shape) & near[1:], axis=0)
        return paths[seen.sum(axis=0), np.arange(len(points))]


class GridPaths:
    """The free space as a graph: nodes where the robot fits, sixteen steps from each."""

    def __init__(
        self,
        grid: ClearanceGrid,
        clearance: float = CLEARANCE,
        comfort: float = 0.6,
        caution: float = 4.0,
    ) -> None:
        """Lay out the graph on every second cell of the grid.

        Args:
            grid: the free space.
            clearance: metres to the nearest wall that a node needs.
            comfort: metres from which on a wall has no influence.
            caution: factor by which a path at the wall counts as longer.
        """
        clearance = number("clearance", clearance, least=0)
        comfort, caution = number("comfort", comfort, above=0), number("caution", caution, least=0)
        cells = instance("grid", grid, ClearanceGrid).clearance[::2, ::2]
        self.resolution = 2 * grid.resolution
        self._grid = grid
        rows, columns = np.nonzero(cells >= clearance)
        if not len(rows):
            raise InputError(f"clearance: no place has {clearance} m; is this a floor plan?")
        self._number = np.full(cells.shape, -1, dtype=np.int32)
        self._number[rows, columns] = np.arange(len(rows))
        self.points = grid.centres(np.stack([2 * rows, 2 * columns], axis=1))
        self.clearance = cells[rows, columns].astype(float)
        self._dislike = 1 + caution * np.maximum(0, 1 - self.clearance / comfort) ** 2

    @cached_property
    def _edges(self) -> tuple[NDArray[np.int32], NDArray[np.int32], Array]:
        """First node, second node and length in metres of every edge, one direction."""
        heads, tails, lengths = [], [], []
        for down, right in _STEPS:
            start, end = _shifted(self._number, down, right)
            open_way = (start >= 0) & (end >= 0)
            # A knight passes between two cells, and both must be free.
            for half in _between(down, right):
                open_way &= _shifted(self._number, down, right, half)[1] >= 0
            heads.append(start[open_way])
            tails.append(end[open_way])
            lengths.append(np.full(open_way.sum(), np.hypot(down, right) * self.resolution))
        return np.concatenate(heads), np.concatenate(tails), np.concatenate(lengths)

    @cached_property
    def _geodesic(self) -> csr_array:
        """The graph weighted by length."""
        return self._graph(self._edges[2])

    @cached_property
    def _comfortable(self) -> csr_array:
        """The graph weighted by length and closeness to walls."""
        head, tail, length = self._edges
        return self._graph(length * (self._dislike[head] + self._dislike[tail]) / 2)

    def _graph(self, weights: Array) -> csr_array:
        head, tail, _ = self._edges
        shape = (len(self.points), len(self.points))
        both = (np.concatenate([head, tail]), np.concatenate([tail, head]))
        return csr_array((np.concatenate([weights, weights]), both), shape=shape)

    def nearest(self, points: ArrayLike) -> tuple[NDArray[np.int32], Array]:
        """The node nearest to each point (..., 2), -1 where none is near, and the gap in metres.

        Raises:
            InputError: when they are no points.
        """
        points = floats("points", points, (..., 2))
        cells = self._grid.cells(points).reshape(-1, 2) // 2
        nodes, gap = _nearest(points.reshape(-1, 2), cells, self._number, self.points)
        return nodes.reshape(points.shape[:-1]), gap.reshape(points.shape[:-1])

    def fields(self, goals: ArrayLike, *, shortest: bool = False) -> DistanceFields:
        """The distance of every place from each goal.

        Args:
            goals: (G, 2) metres.
            shortest: true geodesic length; otherwise paths that keep off the walls are preferred.

        Raises:
            InputError: when a goal is not in free space.
        """
        goals, nodes, gaps = self._placed(goals)
        graph = self._geodesic if flag("shortest", shortest) else self._comfortable
        cost, towards = dijkstra(graph, indices=nodes, return_predecessors=True)
        return DistanceFields(self, goals, gaps, cost, towards)

    def metres_to(self, goals: ArrayLike) -> Array:
        """True geodesic length (G, K) from each node to each goal; inf where no path leads.

        As `fields` has it, without the paths and ten times as fast.

        Args:
            goals: (G, 2) metres.

        Raises:
            InputError: when a goal is not in free space.
        """
        goals, nodes, gaps = self._placed(goals)
        graph, width = self._geodesic, _WIDTH * self.resolution
        found = np.empty((len(goals), len(self.points)))
        for goal, node, gap, metres in zip(goals, nodes, gaps, found, strict=True):
            # pyrefly: ignore[bad-argument-type]: scipy's indices are int32 here
            _spread(node, graph.indptr, graph.indices, graph.data, width, metres)
            beside = np.flatnonzero(metres < 1.5 * self.resolution)
            metres += gap
            metres[beside] = np.linalg.norm(self.points[beside] - goal, axis=1)
        return found

    def _placed(self, goals: ArrayLike) -> tuple[Array, NDArray[np.int32], Array]:
        """Goals (G, 2), checked; the node (G,) nearest to each, and the gap (G,) in metres."""
        goals = np.atleast_2d(floats("goals", goals, (..., 2)))
        if goals.ndim > 2:
            raise InputError(f"goals: shape {goals.shape}; give (G, 2) rows x, y")
        nodes, gaps = self.nearest(goals)
        for goal in goals[nodes < 0]:
            raise InputError(f"goals: {goal.tolist()} is not in free space; choose another place")
        return goals, nodes, gaps

    def between(self, starts: ArrayLike, goals: ArrayLike) -> Array:
        """Metres (N,) from each start (N, 2) to its own goal (N, 2); inf without a path.

        Goals are processed in chunks, since each needs a distance field of the whole world.
        """
        starts, goals = floats("starts", starts, ("N", 2)), floats("goals", goals, ("N", 2))
        alike(starts=starts, goals=goals)
        places, which = np.unique(goals, axis=0, return_inverse=True)
        found = np.empty(len(starts))
        for first in range(0, len(places), _AT_ONCE):
            field = self.fields(places[first : first + _AT_ONCE], shortest=True)
            some = np.flatnonzero((which >= first) & (which < first + _AT_ONCE))
            found[some] = field.distance(starts[some], which[some] - first)
        return found

    @cached_property
    def largest(self) -> NDArray[np.bool_]:
        """(K,) which nodes belong to the largest part that hangs together."""
        _, label = connected_components(self._geodesic, directed=False)
        return label == np.bincount(label).argmax()


def _between(down: int, right: int) -> list[tuple[int, int]]:
    """The cells that a step passes between; none for a straight one."""
    if abs(down) + abs(right) == 3:
        if abs(down) == 2:
            return [(1, 0), (1, right)]
        return [(0, int(np.sign(right))), (down, int(np.sign(right)))]
    return [(0, right), (down, 0)] if down and right else []


def _shifted(
    grid: NDArray[np.int32], down: int, right: int, middle: tuple[int, int] | None = None
) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """Views of the cells from which a step stays on the grid, and of the cells it leads to."""
    rows, columns = grid.shape
    first = slice(max(0, -down), rows - max(0, down))
    left = slice(max(0, -right), columns - max(0, right))
    down, right = middle or (down, right)
    moved = slice(first.start + down, first.stop + down)
    return grid[first, left], grid[moved, left.start + right : left.stop + right]


@njit(cache=True, nogil=True, error_model="numpy")
def _nearest(
    points: Array, cells: NDArray[np.intp], number: NDArray[np.int32], places: Array
) -> tuple[NDArray[np.int32], Array]:
    """For points (N, 2) in `cells` (N, 2) the node nearest within `_NEAR`, and the gap."""
    rows, columns = number.shape
    best, gap = np.full(len(points), -1, np.int32), np.full(len(points), np.inf)
    for n in range(len(points)):
        for row in range(max(cells[n, 0] - 3, 0), min(cells[n, 0] + 4, rows)):
            for column in range(max(cells[n, 1] - 3, 0), min(cells[n, 1] + 4, columns)):
                node = number[row, column]
                if node >= 0:
                    x, y = points[n, 0] - places[node, 0], points[n, 1] - places[node, 1]
                    far = np.sqrt(x * x + y * y)
                    if far <= _NEAR and far < gap[n]:
                        best[n], gap[n] = node, far
    return best, gap


@njit(cache=True, nogil=True, error_model="numpy")
def _spread(
    start: int,
    first: NDArray[np.int32],
    other: NDArray[np.int32],
    length: Array,
    width: float,
    metres: Array,
) -> None:
    """Write the metres (K,) from a node to all, over the edges of a graph (Dial's Dijkstra).

    The edges of node k are `first[k]` to `first[k + 1]`. Nodes in one bucket differ by less than
    `width`, which is less than any edge: none of them is on the shortest path to another.
    """
    metres[:] = np.inf
    settled, head = np.zeros(len(metres), np.bool_), np.full(_BUCKETS, -1, np.int32)
    later, which = np.empty(len(other) + 1, np.int32), np.empty(len(other) + 1, np.int32)
    metres[start], head[0], later[0], which[0] = 0.0, 0, -1, start
    used, waiting, now = 1, 1, 0
    while waiting:
        bucket = now % _BUCKETS
        while head[bucket] >= 0:
            entry = head[bucket]
            head[bucket] = later[entry]
            waiting -= 1
            node = which[entry]
            if settled[node]:
                continue
            settled[node] = True
            for edge in range(first[node], first[node + 1]):
                end, total = other[edge], metres[node] + length[edge]
                if total < metres[end]:
                    metres[end] = total
                    slot = int(total / width) % _BUCKETS
                    later[used], which[used], head[slot] = head[slot], end, used
                    used += 1
                    waiting += 1
        now += 1
