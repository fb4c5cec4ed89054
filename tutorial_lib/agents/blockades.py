"""What stands in a robot's way, and the stretches of a map that it could not pass."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import HERE, Edges
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.world.sensors import full_circle
from tutorial_lib.world.simulation import STEP

WAIT = 4.0
"""Seconds that a robot waits for what stands in its way to move on."""
MEMORY = 120.0
"""Seconds for which a stretch that could not be passed is excluded."""
_ROOM = 0.6  # metres that a robot moves at most while it waits
_LANE = 0.1  # metres on either side of the line to a waypoint
_SHORT = 0.3  # metres before the waypoint where the lane ends
_NEARBY = 2.5  # metres within which a robot is still where it could not pass


def in_the_way(lasers: NDArray[np.floating], waypoints: Array) -> NDArray[np.bool_]:
    """(N,) whether the laser sees something on the straight line to a waypoint.

    The network learned waypoints in line of sight (`learning.labels`): what stands before one was
    not there when it learned such places.

    Args:
        lasers: (N, B) metres, full circles.
        waypoints: (N, 2) metres, in the robots' frames.
    """
    far = np.linalg.norm(waypoints, axis=1)
    ahead = waypoints / np.maximum(far, 1e-6)[:, None]
    angles = full_circle(lasers.shape[1])
    along = lasers * (ahead[:, :1] * np.cos(angles) + ahead[:, 1:] * np.sin(angles))
    aside = lasers * (ahead[:, :1] * np.sin(angles) - ahead[:, 1:] * np.cos(angles))
    on_lane = (np.abs(aside) < _LANE) & (along > 0) & (along < far[:, None] - _SHORT)
    return np.any(on_lane, axis=1)


class Waiting:
    """How long each of N robots has waited for what stands in its way."""

    def __init__(self, robots: int) -> None:
        """Begin with robots that do not wait."""
        self._seconds, self._place = np.zeros(robots), np.zeros((robots, 2))

    def stop(self, robot: int) -> None:
        """Forget that a robot waits."""
        self._seconds[robot] = 0.0

    def step(
        self, robots: NDArray[np.intp], odometry: Array, blocked: NDArray[np.bool_]
    ) -> NDArray[np.bool_]:
        """Which robots (M,) have waited long enough.

        Args:
            robots: (M,) their indices.
            odometry: (M, 3).
            blocked: (M,) whether something is in the way now.
        """
        moved = np.linalg.norm(odometry[:, :2] - self._place[robots], axis=1) > _ROOM
        begins = moved | (self._seconds[robots] <= 0)
        self._place[robots[begins]] = odometry[begins, :2]
        seconds = np.where(moved, 0.0, self._seconds[robots])
        seconds = np.maximum(seconds + np.where(blocked, STEP, -STEP), 0.0)
        self._seconds[robots] = seconds
        return seconds > WAIT - STEP / 2


@dataclass(frozen=True)
class _Stretch:
    """Edges that could not be passed, and first steps from where that was; until when."""

    edges: frozenset[tuple[int, int]]
    steps: frozenset[int]
    place: Array
    until: float


class Blockades:
    """The stretches that each of N robots could not pass; it forgets them after a time."""

    def __init__(self, robots: int, topomap: TopoMap) -> None:
        """Begin with a map of which everything can be passed."""
        self._graph = topomap.graph
        self._stretches: list[list[_Stretch]] = [[] for _ in range(robots)]

    def add(
        self,
        robot: int,
        before: Iterable[int],
        ahead: Iterable[int],
        odometry: Array,
        now: float,
    ) -> Edges:
        """Exclude the edges from places before to places ahead, and all that run beside them.

        Args:
            robot: its index.
            before: vertices that it passed.
            ahead: vertices that it could not reach from there.
            odometry: (3,) of the robot.
            now: seconds.

        Returns:
            These edges.
        """
        before, ahead = set(before), set(ahead)
        # Where an edge leads back, each of the two is beside the other.
        sources = self._beside(before) - ahead
        targets = self._beside(ahead) - sources
        edges = frozenset(
            (source, target)
            for source in sources
            for target in targets & set(self._graph.successors(source))
        )
        stretch = _Stretch(edges, frozenset(targets), odometry[:2].copy(), now + MEMORY)
        self._stretches[robot].append(stretch)
        return set(edges)

    def excluded(self, robot: int, odometry: Array, now: float) -> Edges:
        """The edges that a robot with `odometry` (3,) does not plan over now."""
        kept = [stretch for stretch in self._stretches[robot] if stretch.until > now]
        self._stretches[robot] = kept
        found: Edges = set()
        for stretch in kept:
            found |= stretch.edges
            # From elsewhere the same vertices may well be reached.
            if np.linalg.norm(odometry[:2] - stretch.place) < _NEARBY:
                found |= {(HERE, vertex) for vertex in stretch.steps}
        return found

    def _beside(self, vertices: Iterable[int]) -> set[int]:
        """Vertices, and those with edges from and to them: they are at the same places."""
        found, edges = set[int](), self._graph.edges
        for vertex in vertices:
            found.add(vertex)
            for other in self._graph.successors(vertex):
                there = edges[vertex, other].get("turn") is None
                if there and self._graph.has_edge(other, vertex):
                    found.add(other)
        return found
