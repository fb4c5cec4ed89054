"""Robots of one fleet that see and touch each other."""

import numpy as np
from scipy.spatial import KDTree

from tutorial_lib.errors import InputError
from tutorial_lib.se2 import Array, to_world
from tutorial_lib.world.bodies import Body
from tutorial_lib.world.materials import Colour
from tutorial_lib.world.raycast import Discs

ROBOTS: Colour = (31, 119, 180)
"""RGB of a robot that another one sees."""
_OVERLAP = 0.5  # radii from one disc of a robot to the next at most, or nearly


def robot_discs(body: Body, poses: Array) -> Discs:
    """Robots at `poses` (N, 3) as the rays of the others meet them.

    A robot is a row of discs along its longer side, each as wide as the shorter one: a round robot
    is one disc, a car one with rounded corners.
    """
    low, high = body.footprint.min(axis=0), body.footprint.max(axis=0)
    radius, length = (high - low).min() / 2, (high - low).max()
    count = 1 + int(np.ceil((length - 2 * radius) / (2 * _OVERLAP * radius) - 1e-9))
    rows = np.tile((low + high) / 2, (count, 1))
    along = int((high - low).argmax())
    rows[:, along] = np.linspace(low[along] + radius, high[along] - radius, count)
    centres = to_world(np.asarray(poses)[:, None], rows).reshape(-1, 2)
    circles = np.column_stack([centres, np.full(len(centres), radius)])
    owners = -2 - np.repeat(np.arange(len(poses), dtype=np.int32), count)  # not for itself
    return Discs(circles, owners, np.tile(np.array(ROBOTS, np.float32), (len(circles), 1)))


def check_distinct(body: Body, poses: Array) -> None:
    """Check that no two robots at `poses` (N, 3) overlap.

    Raises:
        InputError: naming two that do.
    """
    footprint = body.footprint
    corners = to_world(np.asarray(poses)[:, None], footprint)
    reach = 2 * np.linalg.norm(footprint, axis=1).max()
    for first, second in sorted(KDTree(poses[:, :2]).query_pairs(reach)):
        if not _separated(corners[first], corners[second]):
            raise InputError(
                f"start: robots {first} and {second} would stand in each other; move either"
            )


def _separated(first: Array, second: Array) -> bool:
    """Whether a line along one of the sides separates two convex outlines (K, 2)."""
    sides = np.concatenate([np.roll(o, -1, axis=0) - o for o in (first, second)])
    normals = np.column_stack([sides[:, 1], -sides[:, 0]])
    ours, theirs = first @ normals.T, second @ normals.T
    gaps = np.maximum(ours.min(axis=0) - theirs.max(axis=0), theirs.min(axis=0) - ours.max(axis=0))
    return bool((gaps >= 0).any())
