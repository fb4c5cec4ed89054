"""Before every kernel shapes are compared: compiled code reads on beyond the end of an array."""

import re
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.checks.nb10 import fit
from tutorial_lib.driving.control import rmp_arcs
from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.exploration.explorable import explorable
from tutorial_lib.exploration.frontier import all_frontiers, is_frontier, nearest_frontiers
from tutorial_lib.exploration.local_map import LocalMaps
from tutorial_lib.exploration.local_policy import find_paths
from tutorial_lib.exploration.motion import move
from tutorial_lib.interfaces import Observation
from tutorial_lib.topology.mapping.scan_matching import agreement, match_scans
from tutorial_lib.validation import fit_together
from tutorial_lib.world.raycast import Discs, Fan, Raycaster
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera

LIBRARY = Path(__file__).parents[1] / "tutorial_lib"
SQUARE = make_box().segments
N, B = 3, 8


def zeros(*shape):
    return np.zeros(shape)


def some(*shape):
    return np.full(shape, 2.0)


def maps():
    found = LocalMaps(N)
    found.observe(np.arange(N), zeros(N, 3), some(N, 192))
    return found


def observe(robots, odometry, ranges):
    LocalMaps(N).observe(robots, odometry, ranges)


def draw(circles, owners, colours, viewers):
    discs, scene = Discs(circles, owners, colours), Scene(make_box())
    Camera().look(scene, some(N, 3), discs, viewers)


def act(laser, speed, steering, waypoints):
    seen = Observation(np.zeros((N, 4, 4, 3), np.uint8), None, laser, zeros(N, 3), speed, steering)
    RMPController().act(seen, waypoints)


ROBOTS = np.arange(N)
GOOD = np.array([0, 2, 2])
RMP = (some(N, B), zeros(B))
DISCS = some(4, 2) / 20
DOORS = {
    "LocalMaps.observe": (observe, [GOOD, zeros(N, 3), some(N, 192)]),
    "nearest_frontiers": (lambda *a: nearest_frontiers(maps(), *a), [GOOD, zeros(N, 3)]),
    "all_frontiers": (lambda *a: all_frontiers(maps(), *a), [GOOD, zeros(N, 3)]),
    "is_frontier": (lambda *a: is_frontier(maps(), *a), [GOOD, zeros(N, 2)]),
    "find_paths": (lambda *a: find_paths(maps(), *a), [GOOD, zeros(N, 3), some(N, 2)]),
    "explorable": (explorable, [some(N, B)]),
    "move": (lambda *a: move(*a, 0.2), [some(N, 3), some(N, 3), SQUARE]),
    "match_scans": (match_scans, [some(N, B), some(N, B), zeros(N, 2, 3)]),
    "agreement": (agreement, [some(N, B), some(N, B), zeros(N, 3)]),
    "fit": (fit, [some(B), some(B), zeros(N, 3)]),
    "free_travel": (lambda *a: rmp_arcs.free_travel(*a, 0.1), [*RMP, some(N, 2), DISCS]),
    "safe_speeds": (
        lambda lasers, arcs, discs, left: rmp_arcs.safe_speeds(
            lasers, arcs, discs, 0.1, left, 0.7, 0.0, 0.2, 3.0
        ),
        [some(N, B), some(N, 2), DISCS, some(N)],
    ),
    "clear_lanes": (
        lambda *a: rmp_arcs.clear_lanes(*a, 0.1, 2.0),
        [*RMP, some(N, 2), zeros(N)],
    ),
    "choose_moves": (
        lambda lasers, angles, waypoints, speeds, discs, limits: rmp_arcs.choose_moves(
            lasers, angles, waypoints, speeds, discs, 0.1, limits
        ),
        [*RMP, some(N, 2), zeros(N), DISCS, some(6)],
    ),
    "RMPController.act": (act, [some(N, B), zeros(N), zeros(N), some(N, 2)]),
    "Raycaster.cast": (lambda poses: Raycaster(SQUARE).cast(poses, Fan([0.0])), [some(N, 3)]),
    "Raycaster.sees": (lambda *a: Raycaster(SQUARE).sees(*a), [some(N, 2), some(N, 2)]),
    "Camera.look": (
        draw,
        [some(2, 3), np.full(2, -1, np.int32), np.zeros((2, 3), np.float32), ROBOTS],
    ),
    "GridPaths.nearest": (
        lambda points: GridPaths(Scene(make_box()).clearance).nearest(points),
        [some(N, 2)],
    ),
}
"""Every public function that calls a kernel, with arguments that fit."""
KERNELS = {
    "checks/nb10/fits.py": {"fit"},
    "driving/control/arc_kernels.py": {"free_travel", "clear_lanes", "choose_moves"},
    "driving/geodesics.py": {"GridPaths.nearest"},
    "exploration/explorable.py": {"explorable"},
    "exploration/frontier.py": {"nearest_frontiers", "all_frontiers", "is_frontier"},
    "exploration/grid_kernels.py": {"LocalMaps.observe", "find_paths", "explorable"},
    "exploration/local_policy.py": {"find_paths"},
    "exploration/motion.py": {"move"},
    "topology/mapping/scan_matching.py": {"match_scans", "agreement"},
    "world/grid_kernels.py": {"Raycaster.cast", "Raycaster.sees"},
    "world/paint.py": {"Camera.look"},
    "world/ray_kernels.py": {"Raycaster.cast", "Camera.look"},
}
"""The modules with kernels, and the functions through which they are reached."""


def test_every_module_with_kernels_has_doors_that_are_tried_here():
    found = {
        str(path.relative_to(LIBRARY)).replace("\\", "/")
        for path in LIBRARY.rglob("*.py")
        if re.search(r"^@(n?jit|(gu)?vectorize|stencil)\b", path.read_text("utf-8"), re.MULTILINE)
    }
    assert found == set(KERNELS)
    assert set().union(*KERNELS.values()) <= set(DOORS)


@pytest.mark.parametrize("name", DOORS)
def test_arguments_that_fit_are_taken(name):
    call, arguments = DOORS[name]
    call(*arguments)


SHORTER = {
    "shorter": lambda array: array[:-1],
    "longer": lambda array: np.concatenate([array, array]),
    "one": lambda array: array[:1],
    "none": lambda array: array[:0],
    "deeper": lambda array: array[..., None],
    "narrower": lambda array: array[..., :-1],
    "wider": lambda array: np.concatenate([array, array], axis=-1),
    "flat": lambda array: array.reshape(-1),
    "number": lambda array: array.flat[0],
}
ALONE = {  # changes after which they fit as well: nothing else has to be as long
    ("LocalMaps.observe", 2): {"narrower", "wider"},
    ("safe_speeds", 0): {"narrower", "wider"},
    ("RMPController.act", 0): {"narrower", "wider"},
    ("explorable", 0): {"shorter", "longer", "one", "none", "narrower", "wider"},
    ("Raycaster.cast", 0): {"shorter", "longer", "one", "none"},
    ("GridPaths.nearest", 0): {"shorter", "longer", "one", "none", "deeper", "number"},
    ("fit", 2): {"shorter", "longer", "one", "none"},
    ("move", 2): {"shorter", "longer", "one", "none"},
    ("free_travel", 3): {"shorter", "longer", "one", "none"},
    ("safe_speeds", 2): {"shorter", "longer", "one", "none"},
    ("choose_moves", 4): {"shorter", "longer", "one", "none"},
    ("Raycaster.sees", 0): {"one"},  # of one place to many
    ("Raycaster.sees", 1): {"one"},
}
CASES = [
    (name, place, change)
    for name, (_, arguments) in DOORS.items()
    for place in range(len(arguments))
    for change in SHORTER
    if change not in ALONE.get((name, place), ())
    and np.shape(SHORTER[change](np.asarray(arguments[place]))) != np.shape(arguments[place])
]


@pytest.mark.parametrize(("name", "place", "change"), CASES)
def test_an_array_that_is_shorter_longer_or_of_another_shape_is_refused(name, place, change):
    call, arguments = DOORS[name]
    changed = SHORTER[change](np.asarray(arguments[place]))
    with pytest.raises(InputError):
        call(*arguments[:place], changed, *arguments[place + 1 :])


@pytest.mark.parametrize("index", [-1, N, 10**6, 2**40])
@pytest.mark.parametrize("name", [name for name, (_, a) in DOORS.items() if a[0] is GOOD])
def test_a_robot_without_a_map_is_refused(name, index):
    call, arguments = DOORS[name]
    with pytest.raises(InputError, match=f"robots: {index}; give whole numbers from 0 to {N - 1}"):
        call(np.array([0, index, 1]), *arguments[1:])


def test_a_panorama_has_two_columns_at_least():
    with pytest.raises(InputError, match="ranges: 1 columns; give two at least"):
        LocalMaps(1).observe(np.array([0]), zeros(1, 3), some(1, 1))


def test_lengths_that_share_a_name_are_the_same():
    fit_together(a=(zeros(2, 5), ("N", "B")), b=(zeros(2), ("N",)), c=(zeros(5, 3), ("B", 3)))
    fit_together(a=(zeros(0, 5), ("N", "B")), b=(zeros(0), ("N",)), c=(1.0, ()))
    for shape, said in (((3,), r"\(3,\); give shape \(2,\)"), ((2, 1), r"\(2, 1\); give")):
        with pytest.raises(InputError, match=f"b: shape {said}"):
            fit_together(a=(zeros(2, 5), ("N", "B")), b=(zeros(*shape), ("N",)))
    with pytest.raises(InputError, match=r"c: shape \(2, 2\); give shape \(2, 3\)"):
        fit_together(a=(zeros(2, 5), ("N", "B")), c=(zeros(2, 2), ("N", 3)))
    with pytest.raises(InputError, match=r"c: shape \(2,\); give shape \(N, 3\)"):
        fit_together(c=(zeros(2), ("N", 3)))
