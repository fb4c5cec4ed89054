"""What a camera sees of the floor, drawn on the plan."""

import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.validation import floats, instance
from tutorial_lib.viz.canvas.given import places_of
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView
from tutorial_lib.world.raycast import Discs, Fan
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera, PanoramicCamera


def draw_field_of_view(
    view: PlanView,
    picture: Picture,
    scene: Scene,
    pose: ArrayLike,
    camera: Camera | PanoramicCamera | None = None,
    discs: Discs | None = None,
) -> None:
    """Tint on a map what a camera at `pose` (3,) sees of the floor, up to the walls."""
    camera = Camera() if camera is None else camera
    pose = places_of("pose", pose, (3,))
    if not hasattr(camera, "fan"):
        raise InputError(f"camera: {camera!r}; give a Camera or a PanoramicCamera")
    ends = ray_ends(scene, pose, camera.fan.angles, discs)
    if not np.isfinite(ends).all():
        raise InputError(f"pose: {pose.tolist()}; give one within the walls")
    instance("view", view, PlanView).seen(picture, pose, ends)


def ray_ends(scene: Scene, pose: ArrayLike, angles: ArrayLike, discs: Discs | None = None) -> Array:
    """Points (B, 2) of the world that rays from `pose` (3,) meet; angles (B,) rad, 0 is ahead."""
    pose, angles = places_of("pose", pose, (3,)), floats("angles", angles, ("B",))
    distance = (
        instance("scene", scene, Scene).caster.cast(pose[None], Fan(angles), discs).distance[0]
    )
    turned = pose[2] + angles
    return pose[:2] + distance[:, None] * np.stack([np.cos(turned), np.sin(turned)], axis=1)
