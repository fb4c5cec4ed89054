"""The check of a ray against a wall, in notebook 01."""

from collections.abc import Callable

import numpy as np

from tutorial_lib.checks.framework.answers import call
from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.comparison import expect_close
from tutorial_lib.geometry import Array
from tutorial_lib.world.raycast import Fan, Raycaster


def ray_segment(origin: Array, direction: Array, start: Array, end: Array) -> float:
    """Metres from `origin` along `direction` to the wall, inf when it is missed."""
    heading = np.arctan2(direction[1], direction[0])
    caster = Raycaster([[*start, *end]])
    return float(caster.cast(np.array([[*origin, heading]]), Fan([0.0])).distance[0, 0])


@check(ray_segment, tuple(np.array(p) for p in ([0.0, 0.0], [1.0, 0.0], [2.0, -1.0], [2.0, 1.0])))
def check_ray_segment(student: Callable[..., Array]) -> None:
    """A ray against one wall: hits, misses, walls behind and parallel ones."""
    straight = np.array([1.0, 0.0])
    slanted = np.array([0.6, 0.8])
    origin = np.array([0.5, 0.2])
    cases = (
        ("ahead", straight, [2.0, -1.0], [2.0, 1.5], {}),
        ("slanting", slanted, [0.0, 2.0], [3.0, 1.4], {}),
        ("to the side", straight, [2.0, 1.0], [2.0, 3.0], {"the ray passes beyond its ends": 1.5}),
        ("behind", straight, [-1.0, -1.0], [-1.0, 1.0], {"it is behind the robot": 1.5}),
        ("parallel", straight, [1.0, 1.0], [3.0, 1.0], {"a parallel wall is missed": np.nan}),
    )
    for name, direction, start, end, mistakes in cases:
        start, end = np.array(start), np.array(end)
        want = ray_segment(origin, direction, start, end)
        if np.isfinite(want):
            place = np.linalg.norm(origin + want * direction - start)
            share = place / np.linalg.norm(end - start)
            along = "that is how far along the wall the ray hits, not how far away"
            mistakes = {f"{along} (a share)": share, f"{along} (metres)": place}
        with np.errstate(divide="ignore", invalid="ignore"):
            answer = call(student, origin, direction, start, end)
        expect_close(f"ray_segment, wall {name}", answer, want, 1e-6, mistakes)
