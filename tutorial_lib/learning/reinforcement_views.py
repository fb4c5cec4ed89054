"""What policies see that learn by reinforcement: the goal compared with what is around, and a map.

Pictures go through the multi-task network of Neural Topological SLAM, which stays as it is: a
policy learns where to drive, not to see.
"""

import numpy as np
import torch
from numpy.typing import NDArray

from tutorial_lib.exploration.bearings import DIRECTIONS, bearing_of
from tutorial_lib.exploration.grid_kernels import FREE, OCCUPIED
from tutorial_lib.exploration.local_map import LocalMaps
from tutorial_lib.exploration.motion import ACTIONS
from tutorial_lib.learning.panorama_encoder import FEATURES, Encoded
from tutorial_lib.learning.panorama_network import HIDDEN, PanoramaNetwork
from tutorial_lib.se2 import Array, to_world
from tutorial_lib.world.noise import STOP

RADII = (0.4, 0.8, 1.2, 1.7, 2.3, 3.0, 3.8)
"""Metres from the robot of the cells of its map."""
MAPPED = 2 * 3 * len(RADII)
"""Numbers of a direction of the map: of each cell, two side by side at a radius, whether it is
free, occupied, and visited."""
_CELL, _SIDE = 0.25, 160  # metres of a cell of the places visited, and their number along a side


class PolicyViews:
    """What N robots see on the way to their goals, as their policy takes it.

    Attributes:
        sizes: numbers of each part of what `see` returns: of the directions, of all together, of
            the action before, and of the map.
    """

    def __init__(self, robots: int, pairs: PanoramaNetwork, *, maps: bool) -> None:
        """Make room for N robots.

        Args:
            robots: N.
            pairs: the multi-task network.
            maps: whether they have maps.
        """
        self._pairs = pairs
        self.sizes = {"directions": DIRECTIONS * HIDDEN, "whole": HIDDEN, "before": len(ACTIONS)}
        self._goals, self._before = torch.zeros(robots, FEATURES), np.full(robots, STOP)
        self._maps = None
        if maps:
            self.sizes["map"], self._maps = DIRECTIONS * MAPPED, LocalMaps(robots)
            self._visited = np.zeros((robots, _SIDE, _SIDE), bool)

    def begin(
        self, robots: NDArray[np.intp], image: NDArray[np.uint8], depth: NDArray[np.floating]
    ) -> None:
        """Begin the episodes of robots; forget all before.

        Args:
            robots: (M,) indices.
            image: (M, 16, 192, 3) of their goals.
            depth: (M, 192) of the same.
        """
        self._goals[robots] = self._encoded(image, depth).flat()
        self._before[robots] = STOP
        if self._maps is not None:
            self._visited[robots] = False
            for robot in robots.tolist():
                self._maps.forget(robot)

    def acted(self, actions: NDArray[np.intp]) -> None:
        """Note the actions (N,) of all robots."""
        self._before = actions.copy()

    @torch.inference_mode()
    def see(
        self,
        robots: NDArray[np.intp],
        image: NDArray[np.uint8],
        depth: NDArray[np.floating],
        odometry: Array,
    ) -> dict[str, NDArray[np.float32]]:
        """What robots see now.

        Args:
            robots: (M,) indices.
            image: (M, 16, 192, 3).
            depth: (M, 192) metres.
            odometry: (M, 3).

        Returns:
            Parts (M, K) by the names of `sizes`.
        """
        seen, goals = self._encoded(image, depth), Encoded.of(self._goals[robots])
        directions, whole, _ = self._pairs.directions(seen, goals)
        before = np.eye(len(ACTIONS), dtype=np.float32)[self._before[robots]]
        parts = {"directions": directions.flatten(1).numpy(), "whole": whole.numpy()}
        parts["before"] = before
        if self._maps is not None:
            self._maps.observe(robots, odometry, depth)
            parts["map"] = self._around(self._maps, robots, odometry)
        return parts

    @torch.inference_mode()
    def _encoded(self, image: NDArray[np.uint8], depth: NDArray[np.floating]) -> Encoded:
        near = torch.from_numpy(np.asarray(depth, np.float32))
        return self._pairs.encode(torch.from_numpy(np.ascontiguousarray(image)), near)

    def _around(
        self, maps: LocalMaps, robots: NDArray[np.intp], odometry: Array
    ) -> NDArray[np.float32]:
        """The map about robots (M, DIRECTIONS * MAPPED), in their own frames."""
        count, side = len(odometry), maps.grids.shape[1]
        row, column = _places(odometry[:, None, :2])
        self._visited[robots[:, None], row, column] = True
        points = to_world(odometry[:, None], _CELLS[None])
        row, column = _places(points)
        visited = self._visited[robots[:, None], row, column]
        each = np.repeat(robots, len(_CELLS))
        cells = maps.cells(each, points.reshape(-1, 2))
        state = maps.grids.reshape(-1, side * side)[each, cells].reshape(visited.shape)
        parts = np.stack([state == FREE, state == OCCUPIED, visited], axis=-1)
        return parts.reshape(count, -1).astype(np.float32)


def _places(points: Array) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Row and column of points (..., 2) among the places visited, clipped to these."""
    cells = np.floor(points / _CELL).astype(np.intp) + _SIDE // 2
    cells = np.clip(cells, 0, _SIDE - 1)
    return cells[..., 1], cells[..., 0]


def _cells() -> Array:
    """The map's points (DIRECTIONS * 2 * len(RADII), 2) in the robot's frame."""
    aside = np.pi / DIRECTIONS / 2
    angles = bearing_of(np.arange(DIRECTIONS))[:, None, None] + [[aside], [-aside]]
    ahead = np.stack([np.cos(angles), np.sin(angles)], axis=-1)  # (DIRECTIONS, 2, 1, 2)
    return (ahead * np.array(RADII)[:, None]).reshape(-1, 2)


_CELLS = _cells()
