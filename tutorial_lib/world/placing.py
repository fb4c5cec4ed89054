"""Where a body can stand."""

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.se2 import Array, to_local, to_world
from tutorial_lib.validation import floats, instance, whole, with_methods
from tutorial_lib.world.bodies import Body
from tutorial_lib.world.noise import MOST_ROBOTS
from tutorial_lib.world.raycast import Discs
from tutorial_lib.world.scene import Scene

_ROUNDS = 100  # of drawing random poses, before giving up


def is_free(scene: Scene, body: Body, poses: Array) -> NDArray[np.bool_]:
    """(N,) whether a body at each pose (N, 3) is in a room and touches no wall or furniture."""
    instance("scene", scene, Scene)
    poses = floats("poses", poses, ("N", 3))
    footprint = checked_body(body).footprint
    corners = to_world(poses[:, None], footprint)
    starts, ends = corners.reshape(-1, 2), np.roll(corners, -1, axis=1).reshape(-1, 2)
    seen = scene.caster.sees(starts, ends).reshape(len(poses), len(footprint))
    free = np.all(seen, axis=1)
    free[free] = scene.clearance.at(poses[free, :2]) > 0
    # A thin post can stand inside the outline without crossing any of its sides.
    around = np.flatnonzero(free)
    reach = np.linalg.norm(footprint, axis=1).max()
    posts = scene.wall_ends.query_ball_point(poses[around, :2], reach)
    for number, near in zip(around, posts, strict=True):
        local = to_local(poses[number], scene.wall_ends.data[near])
        free[number] = not _inside(footprint, local).any()
    return free


def check_free(scene: Scene, body: Body, poses: Array, name: str = "poses") -> None:
    """Check that a body can stand at each pose (N, 3), an argument of that name.

    Raises:
        InputError: naming the first pose that is not free.
    """
    bad = np.flatnonzero(~is_free(scene, body, poses))
    if bad.size:
        x, y, heading = poses[bad[0]]
        raise InputError(
            f"{name}: at ({x:.2f}, {y:.2f}) heading {heading:.2f} the robot would be inside a "
            "wall, furniture or outside all rooms; choose another start"
        )


def checked_body(body: Body) -> Body:
    """What a simulation can drive.

    Raises:
        InputError: when it is no body.
    """
    return with_methods("body", body, "respond", "twist")


def check_apart(body: Body, poses: Array, discs: Discs) -> None:
    """Check that no robot at `poses` (N, 3) starts on a person or obstacle.

    Raises:
        InputError: naming the first that does.
    """
    footprint = checked_body(body).footprint
    instance("discs", discs, Discs)
    poses = floats("poses", poses, ("N", 3))
    low, high = footprint.min(axis=0), footprint.max(axis=0)
    for (x, y, radius), owner in zip(discs.circles, discs.owners, strict=True):
        mine = poses if owner < 0 else poses[[owner]]
        local = to_local(mine, [x, y])
        outside = np.maximum(0.0, np.maximum(low - local, local - high))
        if (np.linalg.norm(outside, axis=1) < radius).any():
            raise InputError(
                f"people: the one at ({x:.2f}, {y:.2f}) stands where a robot starts; move either"
            )


def random_free_poses(
    scene: Scene, body: Body, places: Array, count: int, rng: np.random.Generator
) -> Array:
    """`count` poses (count, 3) at some of the `places` (P, 2) where a body fits.

    Raises:
        InputError: when it fits nowhere, or hardly anywhere.
    """
    places = floats("places", places, ("P", 2), empty=False)
    count = whole("count", count, least=0, most=MOST_ROBOTS)
    instance("rng", rng, np.random.Generator)
    poses = np.empty((0, 3))
    for _ in range(_ROUNDS):
        tries = places[rng.integers(len(places), size=4 * count)]
        tries = np.column_stack([tries, rng.uniform(-np.pi, np.pi, len(tries))])
        poses = np.concatenate([poses, tries[is_free(scene, body, tries)]])
        if len(poses) >= count:
            return poses[:count]
    raise InputError("places: the robot fits at none of them; give others, or a larger plan")


def _inside(footprint: Array, points: Array) -> NDArray[np.bool_]:
    """(P,) whether points (P, 2) lie within a convex, counter-clockwise outline."""
    sides = np.roll(footprint, -1, axis=0) - footprint
    offset = points[:, None] - footprint
    return np.all(sides[:, 0] * offset[..., 1] - sides[:, 1] * offset[..., 0] > 0, axis=1)
