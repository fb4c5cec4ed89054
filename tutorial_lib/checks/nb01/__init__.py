"""Checks of notebook 01: frames, the car and its camera."""

from tutorial_lib.checks.nb01.bicycle_step import check_bicycle_step
from tutorial_lib.checks.nb01.compose import check_compose
from tutorial_lib.checks.nb01.ray_segment import check_ray_segment
from tutorial_lib.checks.nb01.to_local import check_to_local
from tutorial_lib.checks.nb01.wall_share import check_wall_share

__all__ = [
    "check_bicycle_step",
    "check_compose",
    "check_ray_segment",
    "check_to_local",
    "check_wall_share",
]
