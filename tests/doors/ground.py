"""Doors of the modules on the ground floor."""

import numpy as np

from tests.doors.arguments import floats
from tests.doors.walk import call
from tutorial_lib import geometry

POSES = np.array([[1.0, 2.0, 0.5], [2.0, 1.0, -0.5]])
POINTS = np.array([[1.0, 1.0], [3.0, 2.0]])

DOORS = {
    "wrap": lambda: call(geometry.wrap, angle=floats([1.0, 2.0])),
    "to_local": lambda: call(
        geometry.to_local, pose=floats(POSES, (..., 3)), points=floats(POINTS, (..., 2))
    ),
}
WITHOUT = {}
