"""Scanned worlds: another world as a robot's map would have it, imported again."""

import cv2
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.se2 import Array, to_local, to_world
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.generators.rectilinear import DoesNotFit
from tutorial_lib.world.importers.ros_map import large_regions, plan_of_cells
from tutorial_lib.world.occupancy import clearance_grid

USUAL = 0.05
"""Metres a cell of most maps that robots record."""
RESOLUTIONS = (0.025, 0.10)
"""Metres a cell of the others, at least and at most."""
THICKEST = 0.10
"""Metres by which a wall comes out too thick, at most, on either side."""
THINNEST = 0.71
"""Cells by which it does at least: with fewer, a thin wall could be crossed between two cells."""
WHOLE = 0.8
"""Share of the floor that hangs together in a scan, at least."""
_FINE = 0.025  # metres a cell of the grid that a scan samples
_MARGIN = 5  # cells around the map


def scanned(
    plan: FloorPlan, name: tuple[str, int], rng: np.random.Generator, palette: str
) -> FloorPlan:
    """A plan as a robot would have mapped it.

    The building lies at an angle in the map, whose cells measure 2.5 to 10 cm. Walls are ragged,
    single cells are taken for obstacles, and patches of floor stay unknown.

    Args:
        plan: of the building.
        name: family and seed of the new plan.
        rng: of resolution, angle, defects and colours.
        palette: of the new plan.

    Raises:
        DoesNotFit: if a scan falls apart; the next draw may not.
    """
    resolution = rng.uniform(*RESOLUTIONS) if rng.random() < 0.5 else USUAL
    clearance, origin = _turned(plan, rng.uniform(-np.pi, np.pi), resolution)
    free = clearance > _thickness(rng, clearance.shape, resolution)
    free &= ~_speckle(rng, clearance, resolution) & ~_unknown(rng, clearance, resolution)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(
        large_regions(free, resolution).astype(np.uint8), connectivity=4
    )
    largest = stats[1:, cv2.CC_STAT_AREA].max(initial=0)
    if count < 2 or largest < WHOLE * (clearance > 0).sum():
        raise DoesNotFit("a scan that falls apart")
    return plan_of_cells(labels > 0, resolution, origin, name, rng, palette)


def _turned(plan: FloorPlan, angle: float, resolution: float) -> tuple[NDArray[np.float32], Array]:
    """Metres (H, W) to the nearest wall from the cells of a map, and the pose of its corner."""
    grid = clearance_grid(plan, _FINE)
    frame = np.array([0.0, 0.0, -angle])
    corners = to_local(frame, plan.segments.reshape(-1, 2))
    low = corners.min(axis=0) - _MARGIN * resolution
    width, height = np.ceil((corners.max(axis=0) - low) / resolution).astype(int) + _MARGIN
    y, x = np.mgrid[:height, :width]
    centres = low + (np.stack([x, y], axis=-1) + 0.5) * resolution
    return grid.at(to_world(frame, centres)), np.array([*low, 0.0])


def _thickness(
    rng: np.random.Generator, shape: tuple[int, ...], resolution: float
) -> NDArray[np.float32]:
    """Metres (H, W) from a wall up to which cells are taken for occupied: smooth noise."""
    noise = _smooth(rng, shape, rng.uniform(0.7, 2.0))
    spread = resolution * rng.uniform(0.2, 0.8)
    least = THINNEST * resolution
    return np.clip(least + spread * noise, least, max(least, THICKEST)).astype(np.float32)


def _smooth(rng: np.random.Generator, shape: tuple[int, ...], cells: float) -> NDArray[np.float32]:
    """Normal noise (H, W), alike over some cells."""
    noise = cv2.GaussianBlur(rng.standard_normal(shape, dtype=np.float32), (0, 0), cells)
    return noise / noise.std()


def _speckle(
    rng: np.random.Generator, clearance: NDArray[np.float32], resolution: float
) -> NDArray[np.bool_]:
    """Single cells in the open, up to one in 20 square metres."""
    chance = rng.uniform(0.0, 0.05) * resolution**2
    return (rng.random(clearance.shape, dtype=np.float32) < chance) & (clearance > 0.4)


def _unknown(
    rng: np.random.Generator, clearance: NDArray[np.float32], resolution: float
) -> NDArray[np.bool_]:
    """Round patches at the walls, 0.3 to 1 m across, one in 15 square metres at most."""
    patches = np.zeros(clearance.shape, np.uint8)
    edge = np.argwhere((clearance > 0) & (clearance < 0.2))
    floor = (clearance > 0).sum() * resolution**2
    count = rng.integers(int(floor / 15.0) + 1)
    for row, column in edge[rng.integers(len(edge), size=count)].tolist():
        radius = max(round(rng.uniform(0.15, 0.5) / resolution), 1)
        cv2.circle(patches, (column, row), radius, 1, cv2.FILLED)
    return patches > 0
