"""The local policy (Chaplot et al. 2020, 4.1): along the shortest path to a point nearby."""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tutorial_lib.exploration.grid_kernels import Bytes, costs_of, in_sight, spread
from tutorial_lib.exploration.local_map import RESOLUTION, LocalMaps
from tutorial_lib.se2 import Array, to_local
from tutorial_lib.validation import fit_together, floats
from tutorial_lib.world.noise import FORWARD, LEFT, RIGHT

BODY, COMFORT = 2.3, 3.7
"""Cells from the middle of an occupied one: no path comes nearer than the first, and none nearer
than the second where it can do otherwise."""
NEAR, UNSEEN = 3, 2
"""Times its length that a cell near a wall costs, and one that was not seen."""
_AHEAD = 15  # cells at which a path is followed, at most
_LEAST = 4  # cells, at least
_AIM = np.deg2rad(
    8.0
)  # off which a robot turns; more than half the angle of one action, or it would swing
_SWING = np.deg2rad(25.0)  # off which a robot that turned too far goes ahead nevertheless
_EVADE = 3  # turns after a step into a wall
_KEPT = 4  # steps forward for which a path is followed before it is planned again
_DONE = 0.2  # metres from the point ahead at which another one is needed
_MOVED = 0.2  # metres by which a target moves before that
_BLOCKED = 0.12  # metres that a forward step is long where nothing is in the way, at least
_AROUND = 8  # cells about a target in which another is taken for it, where it is blocked


def find_paths(
    maps: LocalMaps, robots: NDArray[np.intp], odometry: Array, targets: Array
) -> tuple[Array, Array]:
    """The shortest paths that keep off the walls where they can.

    Args:
        maps: of N robots.
        robots: (M,) indices.
        odometry: (M, 3) their poses.
        targets: (M, 2) in the frames of their odometry.

    Returns:
        In the frames of their odometry: a point (M, 2) of each path that can be driven to in a
        straight line, and its last point (M, 2), the target or what is nearest to it.

    Raises:
        InputError: when an argument is no such array, or one is shorter than another.
    """
    robots, odometry = maps.checked(robots, odometry)
    targets = floats("targets", targets, ("M", 2))
    fit_together(robots=(robots, ("M",)), targets=(targets, ("M", 2)))
    starts, ends = maps.cells(robots, odometry[:, :2]), maps.cells(robots, targets)
    ahead = starts.copy()
    _find(maps.grids, robots, starts, ends, ahead)
    last = maps.centres(robots, ends)
    near = np.linalg.norm(last - targets, axis=1) < RESOLUTION
    last[near] = targets[near]
    points = maps.centres(robots, ahead)
    straight = ahead == ends
    points[straight] = last[straight]
    return points, last


class LocalPolicy:
    """Leads N robots to points in the frames of their odometry, each over its own map.

    Attributes:
        maps: of the robots.
    """

    def __init__(self, maps: LocalMaps) -> None:
        """Drive over `maps`."""
        count = len(maps.grids)
        self.maps = maps
        self._targets, self._age = np.full((count, 2), np.nan), np.zeros(count, np.intp)
        self._ahead, self._ends = np.zeros((count, 2)), np.zeros((count, 2))
        self._before, self._action = np.zeros((count, 2)), np.zeros(count, np.intp)
        self._evade = np.zeros(count, np.intp)

    def act(
        self, robots: NDArray[np.intp], odometry: Array, targets: Array
    ) -> tuple[NDArray[np.intp], Array]:
        """The next actions.

        Args:
            robots: (M,) indices.
            odometry: (M, 3) their poses.
            targets: (M, 2) in the frames of their odometry.

        Returns:
            Actions (M,), of FORWARD, LEFT and RIGHT; and metres (M,) left in a straight line to the
            path's end, which is the target or what is nearest to it.
        """
        here = odometry[:, :2]
        moved = np.linalg.norm(here - self._before[robots], axis=1)
        blocked = (self._action[robots] == FORWARD) & (moved < _BLOCKED)
        # While it turns, a robot keeps its path, or it would waver between two of one length;
        # unless it slips past the point ahead.
        self._plan(robots, odometry, targets, self._action[robots] == FORWARD, blocked)
        local = to_local(odometry, self._ahead[robots])
        bearing = np.arctan2(local[:, 1], local[:, 0])
        turn = np.where(bearing > 0, LEFT, RIGHT)
        actions = np.where(np.abs(bearing) > _AIM, turn, FORWARD)
        # A turn slips aside as well, so one back and forth would not end.
        last = self._action[robots]
        back = np.isin(last, (LEFT, RIGHT)) & (turn != last) & (np.abs(bearing) < _SWING)
        actions = np.where(back, FORWARD, actions)
        # A robot at a wall that its map has elsewhere turns towards its path before it tries again.
        self._evade[robots] = np.where(blocked, _EVADE, np.maximum(self._evade[robots] - 1, 0))
        evading = self._evade[robots] > 0
        actions = np.where(evading & (actions == FORWARD), turn, actions)
        self._before[robots], self._action[robots] = here, actions
        return actions, np.linalg.norm(self._ends[robots] - here, axis=1)

    def waypoints(
        self, robots: NDArray[np.intp], odometry: Array, targets: Array
    ) -> tuple[Array, Array]:
        """The same for cars: the points ahead on their paths (M, 2), in their frames."""
        here = odometry[:, :2]
        moved = np.linalg.norm(here - self._before[robots], axis=1) >= _BLOCKED
        self._plan(robots, odometry, targets, moved, np.zeros(len(robots), bool))
        self._before[robots] = here
        points = to_local(odometry, self._ahead[robots])
        return points, np.linalg.norm(self._ends[robots] - here, axis=1)

    def _plan(
        self,
        robots: NDArray[np.intp],
        odometry: Array,
        targets: Array,
        moved: NDArray[np.bool_],
        blocked: NDArray[np.bool_],
    ) -> None:
        """Find new paths where the old one is old, done, or leads elsewhere."""
        gone = np.linalg.norm(targets - self._targets[robots], axis=1)
        left = np.linalg.norm(self._ahead[robots] - odometry[:, :2], axis=1)
        self._age[robots] += moved
        done = (left < _DONE) | (moved & (self._age[robots] >= _KEPT))
        stale = ~(gone < _MOVED) | done | blocked
        rows = np.flatnonzero(stale)
        if len(rows):
            mine = robots[rows]
            ahead, ends = find_paths(self.maps, mine, odometry[rows], targets[rows])
            self._ahead[mine], self._ends[mine] = ahead, ends
            self._targets[mine], self._age[mine] = targets[rows], 0


@njit(cache=True, nogil=True, error_model="numpy")
def _find(
    grids: Bytes,
    robots: NDArray[np.intp],
    starts: NDArray[np.intp],
    targets: NDArray[np.intp],
    ahead: NDArray[np.intp],
) -> None:
    """Write a cell ahead on each path, and over `targets` the cell where it ends."""
    side = grids.shape[1]
    cost, ends = np.empty((side, side), np.uint8), np.zeros((side, side), np.uint8)
    length, parent = np.empty(side * side, np.int32), np.empty(side * side, np.int32)
    for m in range(len(robots)):
        start = starts[m]
        costs_of(grids[robots[m]], BODY, COMFORT, NEAR, UNSEEN, start, cost)
        target = _passable(cost, targets[m])
        ends[target // side, target % side] = 1
        if spread(cost, start, ends, length, parent) < 0:
            ends[target // side, target % side] = 0
            target = _nearest(length, targets[m], side)
        ends[target // side, target % side] = 0
        targets[m], ahead[m] = target, _follow(cost, parent, start, target)


@njit(cache=True, nogil=True, error_model="numpy")
def _passable(cost: Bytes, target: int) -> int:
    """The passable cell nearest to a target, where there is one about it."""
    side = len(cost)
    row, column = target // side, target % side
    best, found = 4 * _AROUND * _AROUND, target
    for i in range(max(row - _AROUND, 0), min(row + _AROUND + 1, side)):
        for j in range(max(column - _AROUND, 0), min(column + _AROUND + 1, side)):
            far = (i - row) ** 2 + (j - column) ** 2
            if cost[i, j] and far < best:
                best, found = far, i * side + j
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def _nearest(length: NDArray[np.int32], target: int, side: int) -> int:
    """The cell nearest to a target among those that were reached."""
    row, column = target // side, target % side
    best, found = 4 * side * side, target
    for cell in range(len(length)):
        far = (cell // side - row) ** 2 + (cell % side - column) ** 2
        if length[cell] >= 0 and far < best:
            best, found = far, cell
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def _follow(cost: Bytes, parent: NDArray[np.int32], start: int, target: int) -> int:
    """The farthest cell of a path, up to `_AHEAD`, to which a straight line costs no more.

    Not nearer than `_LEAST`: the bearing of what is very near changes with every slip.
    """
    side = len(cost)
    path = [target]
    while path[-1] != start:
        path.append(parent[path[-1]])
    path.reverse()
    chosen, most = path[0], 0
    for cell in path[1:]:
        most = max(most, cost.ravel()[cell])
        far = max(abs(cell // side - start // side), abs(cell % side - start % side))
        if far > _AHEAD or (far > _LEAST and not in_sight(cost, start, cell, most)):
            break
        chosen = cell
    return chosen
