import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import make_box
from tests.world.test_sensors import coloured_box, disc, free_poses, light
from tutorial_lib.errors import InputError
from tutorial_lib.world.generators import FAMILIES, generate
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Laser, PanoramicCamera

PANORAMA = PanoramicCamera()
STEP = np.deg2rad(30.0)


def test_a_panorama_looks_ahead_in_the_middle_left_before_and_right_after_it():
    image, _ = PANORAMA.look(coloured_box(), np.array([[5.0, 5.0, 0.0]]))
    colours = image[0, 7]
    assert np.ptp(colours[[95, 96]].astype(int), axis=1).tolist() == [0, 0]  # the grey east
    assert colours[48].argmax() == 0  # the red north, left
    assert colours[144].argmax() == 2  # the blue south, right
    assert colours[0].argmax() == colours[-1].argmax() == 1  # the green west, behind


def test_patches_are_twelve_windows_of_the_panorama_around_their_middles():
    image, _ = PANORAMA.look(coloured_box(), np.array([[3.0, 6.0, 0.4], [5.0, 5.0, 1.0]]))
    patches = PANORAMA.split(image)
    assert patches.shape == (2, 12, 16, 48, 3)
    assert patches.dtype == np.uint8
    twice = np.concatenate([image, image, image], axis=2)
    for p in range(12):
        start = 192 + 96 - 16 * p - 24
        assert (patches[:, p] == twice[:, :, start : start + 48]).all()


@pytest.mark.parametrize("patch", range(12))
def test_a_disc_ahead_of_a_patch_is_in_its_middle(patch):
    pose, bearing = np.array([[5.0, 5.0, 0.3]]), 0.3 + STEP * patch
    circle = disc(5 + 2 * np.cos(bearing), 5 + 2 * np.sin(bearing), 0.2)
    image, depth = PANORAMA.look(coloured_box(), pose, circle)
    view = PANORAMA.split(image)[0, patch, 7]
    pink = np.flatnonzero(np.abs(view - np.array([250, 10, 120]) * light(1.8)).max(axis=1) < 4)
    assert pink.min() + pink.max() == 47  # as far from the left as from the right
    assert len(pink) == pytest.approx(2 * np.arcsin(0.1) / (2 * np.pi / 192), abs=2)
    assert (depth[0] < 2.05).sum() == len(pink)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000), st.integers(-11, 11))
def test_turning_by_patches_rolls_the_panorama_and_its_patches(seed, turns):
    scene = Scene(make_box(pillars=[(3.0, 3.0, 0.5)]))
    poses = free_poses(scene, 3, seed)
    turned = poses + np.array([0.0, 0.0, turns * STEP])
    (image, depth), (after, depth_after) = PANORAMA.look(scene, poses), PANORAMA.look(scene, turned)
    assert np.isclose(np.roll(depth, 16 * turns, axis=1), depth_after, atol=1e-6).mean() > 0.99
    near = np.abs(np.roll(image, 16 * turns, axis=2).astype(int) - after) <= 1
    assert near.mean() > 0.99
    patches, patches_after = PANORAMA.split(image), PANORAMA.split(after)
    rolled = np.roll(patches, -turns, axis=1).astype(int)
    assert (np.abs(rolled - patches_after) <= 1).mean() > 0.99


def walls_at(x, y, angles, width, height):
    """Distance from (x, y) to the walls of a room from (0, 0)."""
    cos, sin = np.cos(angles), np.sin(angles)
    along_x = np.where(cos > 0, width - x, x) / np.maximum(np.abs(cos), 1e-12)
    along_y = np.where(sin > 0, height - y, y) / np.maximum(np.abs(sin), 1e-12)
    return np.minimum(along_x, along_y)


@settings(max_examples=60, deadline=None)
@given(
    st.floats(0.5, 9.5), st.floats(0.5, 5.5), st.floats(-3.1, 3.1), st.sampled_from([1, 7, 64, 96])
)
def test_beams_run_counter_clockwise_and_end_at_the_walls_or_at_the_range(x, y, heading, beams):
    scene = Scene(make_box(10.0, 6.0))
    for field in (2 * np.pi, np.deg2rad(240.0), 0.5):
        angles = heading + field * ((np.arange(beams) + 0.5) / beams - 0.5)
        walls = walls_at(x, y, angles, 10.0, 6.0)
        for reach in (1.5, 50.0):
            scan = Laser(beams, field, reach).scan(scene, np.array([[x, y, heading]]))
            assert scan.shape == (1, beams)
            assert scan.dtype == np.float64
            assert scan[0] == pytest.approx(np.minimum(walls, reach), abs=1e-6)


def test_the_paper_s_scan_is_the_middle_of_the_full_circle():
    scene = Scene(generate("office", 75))
    poses = free_poses(scene, 200)
    full, paper = Laser(96), Laser(beams=64, field_of_view=4 * np.pi / 3)
    assert np.allclose(full.fan.angles[16:80], paper.fan.angles)
    same = np.isclose(full.scan(scene, poses)[:, 16:80], paper.scan(scene, poses), atol=1e-6)
    assert same.mean() > 0.999


def test_the_laser_meets_discs_of_its_own():
    scene, laser = Scene(make_box()), Laser(96, range=4.0)
    poses = np.array([[5.0, 5.0, 0.0], [5.0, 5.0, 0.0]])
    scan = laser.scan(scene, poses, disc(5.0, 7.0, 0.3, owner=1))  # on the left: beam 72
    assert (scan[0] >= 3.9).all()
    assert np.abs(np.flatnonzero(scan[1] < 2.1) - 71.5).max() < 6
    assert scan[1, 71:73] == pytest.approx(1.7, abs=0.01)
    swapped = laser.scan(
        scene, poses, disc(5.0, 7.0, 0.3, owner=1), viewers=np.array([1, 0], np.int32)
    )
    assert (swapped == scan[::-1]).all()


@pytest.mark.parametrize("family", FAMILIES)
def test_scans_and_panoramas_repeat_byte_for_byte(family):
    one, two = (Scene(generate(family, 76)) for _ in range(2))
    poses = free_poses(one, 10)
    assert Laser().scan(one, poses).tobytes() == Laser().scan(two, poses).tobytes()
    image, again = (PANORAMA.look(scene, poses)[0] for scene in (one, two))
    assert image.tobytes() == again.tobytes()


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: PanoramicCamera(columns=190), "columns: 190 in 12 patches"),
        (
            lambda: PanoramicCamera(patch_columns=193),
            "patch_columns: 193; give one whole number from 1 to 192",
        ),
        (lambda: PanoramicCamera(patch_columns=0), "patch_columns: 0"),
        (lambda: PanoramicCamera(patches=0), "patches: 0"),
        (lambda: PanoramicCamera(patches=-12), "patches: -12"),
        (lambda: PanoramicCamera(rows=0), "rows: 0"),
        (lambda: Laser(beams=0), "beams: 0"),
        (lambda: Laser(field_of_view=0.0), "field_of_view: 0.0"),
        (lambda: Laser(field_of_view=6.3), "field_of_view: 6.3; .* to 6.28"),
        (lambda: Laser(range=0.0), "range: 0.0; give one real number above 0"),
        (lambda: Laser(range=np.nan), "range: nan"),
        (lambda: Laser().scan(coloured_box(), np.zeros((2, 2))), r"poses: shape \(2, 2\)"),
    ],
)
def test_bad_input_is_named(make, words):
    with pytest.raises(InputError, match=words):
        make()
