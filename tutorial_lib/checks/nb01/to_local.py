"""The check of points in the robot's frame, in notebook 01."""

from collections.abc import Callable

import numpy as np

from tutorial_lib import geometry
from tutorial_lib.checks.framework.answers import call
from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.comparison import expect_close
from tutorial_lib.geometry import Array

_RNG_SEED = 1


@check(geometry.to_local, (np.array([1.0, 2.0, 0.5]), np.ones((100, 2))))
def check_to_local(student: Callable[..., Array]) -> None:
    """Points of the world in the robot's frame."""
    rng = np.random.default_rng(_RNG_SEED)
    for pose in ([0.0, 0.0, 0.0], [2.0, -1.0, 0.0], [1.0, 2.0, 0.7], [-3.0, 0.5, 2.5]):
        pose, points = np.array(pose), rng.uniform(-4, 4, (5, 2))
        turned = geometry.to_world([0, 0, pose[2]], points - pose[:2])
        mistakes = {
            "the robot's frame is turned the wrong way; use minus the heading": turned,
            "subtract the robot's position before you turn": geometry.to_local(
                [0, 0, pose[2]], points
            ),
            "in the wrong order: shift first, then turn": geometry.to_local([0, 0, pose[2]], points)
            - pose[:2],
            "headings are in radians, not degrees": geometry.to_local(
                [*pose[:2], np.deg2rad(pose[2])], points
            ),
        }
        want = geometry.to_local(pose, points)
        expect_close(
            f"to_local from {pose.tolist()}", call(student, pose, points), want, 1e-6, mistakes
        )
