"""An exploration from above, as an image: for people, never for agents."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.geometry import Array
from tutorial_lib.world.bodies import DifferentialDrive
from tutorial_lib.world.materials import Colour
from tutorial_lib.world.scene import Scene

SIDE = 480
"""Pixels of the image's longer side."""
SOLID: Colour = (88, 92, 102)
FLOOR: Colour = (240, 240, 238)
PATH: Colour = (230, 159, 0)
GOAL: Colour = (0, 158, 115)
ROBOT: Colour = (0, 114, 178)
_LINE = 0.04  # metres on either side of the path
_GOAL = 0.25  # metres, radius


def top_view(scene: Scene, path: Sequence[Array], goal: Array) -> NDArray[np.uint8]:
    """What a robot did on its way to a goal, from above; y is up.

    Args:
        scene: the world.
        path: poses (3,) of the robot, the last one where it is now.
        goal: (3,) where the goal's picture was taken.

    Returns:
        (H, W, 3) RGB, `SIDE` pixels wide or high.
    """
    grid = scene.clearance
    pixel = max(grid.clearance.shape) * grid.resolution / SIDE
    height, width = (round(cells * grid.resolution / pixel) for cells in grid.clearance.shape)
    columns, rows = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    floor = np.stack([columns, height - rows], axis=-1) * pixel + grid.origin
    image = np.where(grid.at(floor)[..., None] > 0, FLOOR, SOLID).astype(np.uint8)

    def stroke(start: Array, end: Array, metres: float, colour: Colour) -> None:
        """Draw a line with round ends between two points (2,), so many metres to either side."""
        ends = (np.stack([start[:2], end[:2]]) - grid.origin) / pixel
        ends[:, 1] = height - ends[:, 1]
        low = np.maximum(ends.min(axis=0) - metres / pixel, 0).astype(int)
        high = np.ceil(ends.max(axis=0) + metres / pixel).astype(int)
        window = slice(low[1], high[1]), slice(low[0], high[0])
        offset = np.stack([columns[window], rows[window]], axis=-1) - ends[0]
        along = ends[1] - ends[0]
        share = np.clip(offset @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
        gap = np.linalg.norm(offset - share[..., None] * along, axis=-1)
        image[window][gap * pixel < metres] = colour

    for start, end in pairwise(path):
        stroke(start, end, _LINE, PATH)
    stroke(goal, goal, _GOAL, GOAL)
    robot, radius = np.asarray(path[-1], dtype=float), DifferentialDrive.radius
    stroke(robot, robot, radius, ROBOT)
    ahead = radius * np.array([np.cos(robot[2]), np.sin(robot[2])])
    stroke(robot[:2], robot[:2] + ahead, _LINE, FLOOR)
    return image
