from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import make_box
from tutorial_lib.errors import InputError
from tutorial_lib.world.materials import Look, Material
from tutorial_lib.world.paint import HALF_LIGHT
from tutorial_lib.world.raycast import Discs
from tutorial_lib.world.scene import SHADE, Scene
from tutorial_lib.world.sensors import EYE, WALL_HEIGHT, Camera, PanoramicCamera

COLOURS = {"south": (0, 0, 200), "east": (200, 200, 200), "north": (200, 0, 0), "west": (0, 200, 0)}


def coloured_box(width=10.0, height=10.0):
    """A room with a colour for each wall."""
    materials = tuple(Material(name, colour) for name, colour in COLOURS.items())
    plan = make_box(width, height)
    return Scene(replace(plan, materials=materials, wall_materials=tuple(COLOURS)))


def free_poses(scene, count, seed=0, clearance=0.2):
    rng, grid = np.random.default_rng(seed), scene.clearance
    cells = np.argwhere(grid.clearance > clearance)
    places = grid.centres(cells[rng.integers(len(cells), size=count)])
    return np.column_stack([places, rng.uniform(-np.pi, np.pi, count)])


def light(distance):
    return 1 / (1 + distance / HALF_LIGHT)


def column_angles(camera):
    """Bearing of the middle of each column, positive to the left."""
    across = 1 - 2 * (np.arange(camera.columns) + 0.5) / camera.columns
    return np.arctan(np.tan(camera.field_of_view / 2) * across)


def disc(*circle, owner=-1, colour=(250, 10, 120)):
    return Discs(np.array([circle]), np.array([owner], np.int32), np.array([colour], np.float32))


@pytest.mark.parametrize("camera", [Camera(), Camera(64), Camera(5, 33, 1.0), PanoramicCamera()])
@pytest.mark.parametrize("count", [0, 1, 4])
def test_pictures_have_the_promised_shape(camera, count, pillars):
    image, depth = camera.look(pillars, free_poses(pillars, count))
    assert image.shape == (count, camera.rows, camera.columns, 3)
    assert image.dtype == np.uint8
    assert depth.shape == (count, camera.columns)
    assert depth.dtype == np.float64


def test_the_left_column_is_the_left_of_the_view():
    scene = coloured_box()
    poses = np.array([[5.0, 5.0, heading] for heading in (0, np.pi / 2, np.pi)])
    image, _ = Camera(16).look(scene, poses)
    walls = image[:, 7]
    assert walls[0, 0].argmax() == 0  # heading east: the red north on the left,
    assert walls[0, -1].argmax() == 2  # the blue south on the right,
    assert np.ptp(walls[0, 32].astype(int)) == 0  # and the grey east ahead
    assert walls[1, 0].argmax() == 1  # heading north: the green west on the left,
    assert walls[1, 32].argmax() == 0
    assert walls[2, 0].argmax() == 2
    assert walls[2, -1].argmax() == 0


@settings(max_examples=60, deadline=None)
@given(st.floats(0.1, 9.0), st.sampled_from([5, 16, 64]))
def test_a_wall_ahead_covers_exactly_the_rows_that_the_pinhole_formula_gives(distance, rows):
    scene, camera = coloured_box(10.0, 60.0), Camera(rows)
    image, _ = camera.look(scene, np.array([[10.0 - distance, 30.0, 0.0]]))
    borders = camera.slope * (1 - 2 * np.arange(rows + 1) / rows)  # slopes, from the top
    top, bottom = (WALL_HEIGHT - EYE) / distance, -EYE / distance
    height = 2 * camera.slope / rows
    ceiling = np.clip((borders[:-1] - top) / height, 0, 1)[:, None, None]
    floor = np.clip((bottom - borders[1:]) / height, 0, 1)[:, None, None]
    angles = column_angles(camera)
    ahead = np.abs(np.tan(angles) * distance) < 29.0
    wall = light(distance / np.cos(angles))[None, :, None] * np.array(COLOURS["east"])
    look = scene.plan.look
    expected = ceiling * look.ceiling + floor * look.floor + (1 - ceiling - floor) * wall
    assert np.abs(image[0] - expected)[:, ahead].max() <= 0.6
    assert ahead.sum() >= 32


@settings(max_examples=30, deadline=None)
@given(st.floats(0.5, 9.5), st.floats(0.5, 5.5), st.floats(-3.1, 3.1))
def test_depth_is_the_distance_along_the_ray_of_each_column(x, y, heading):
    scene = coloured_box(10.0, 6.0)
    for camera, bearing in (
        (Camera(), column_angles(Camera())),
        (PanoramicCamera(), np.pi - (np.arange(192) + 0.5) * 2 * np.pi / 192),
    ):
        cos, sin = np.cos(heading + bearing), np.sin(heading + bearing)
        with np.errstate(divide="ignore"):
            along_x = np.where(cos > 0, 10 - x, x) / np.abs(cos)
            along_y = np.where(sin > 0, 6 - y, y) / np.abs(sin)
        _, depth = camera.look(scene, np.array([[x, y, heading]]))
        assert depth[0] == pytest.approx(np.minimum(along_x, along_y), abs=1e-6)


def test_walls_darken_with_distance_to_half_at_half_light():
    scene = coloured_box(31.0, 200.0)
    distances = np.linspace(0.5, 30.0, 40)
    poses = np.column_stack([31 - distances, np.full(40, 100.0), np.zeros(40)])
    image, depth = Camera(64).look(scene, poses)
    middle = image[:, 31, 32, 0].astype(int)
    assert (np.diff(middle) < 0).all()
    assert middle == pytest.approx(200 * light(depth[:, 32]), abs=0.6)
    image, _ = Camera(64).look(scene, np.array([[31 - HALF_LIGHT, 100.0, 0.0]]))
    assert image[0, 31, 32].tolist() == pytest.approx([100] * 3, abs=1)


def test_a_wall_along_x_is_darker_than_one_along_y():
    image, _ = Camera(64).look(coloured_box(), np.array([[5, 5, np.pi / 2], [5, 5, np.pi]]))
    north, west = image[0, 31, 32, 0], image[1, 31, 32, 1]
    assert north == pytest.approx((1 - SHADE) * west, abs=1)


def test_discs_have_their_colour_and_only_their_owner_sees_them():
    scene, camera = coloured_box(), Camera(64)
    poses = np.tile([2.0, 5.0, 0.0], (3, 1))
    bare, far = camera.look(scene, poses)
    for owner, viewers, seen in (
        (-1, None, [True, True, True]),
        (1, None, [False, True, False]),
        (1, np.array([1, 0, 1], np.int32), [True, False, True]),
    ):
        image, depth = camera.look(scene, poses, disc(5.0, 5.0, 0.5, owner=owner), viewers)
        assert [not (a == b).all() for a, b in zip(image, bare, strict=True)] == seen
        assert (depth[:, 32] < 2.6).tolist() == seen
        assert (depth[~np.array(seen)] == far[0]).all()
        expected = np.array([250, 10, 120]) * light(2.5)
        assert np.abs(image[seen][:, 31, 32] - expected).max() <= 1
        # Columns that miss the disc are as they were, and it is as tall as a wall there.
        assert (image[:, :, :24] == bare[:, :, :24]).all()
    hidden, _ = camera.look(scene, poses, disc(12.0, 5.0, 0.5))
    assert (hidden == bare).all()


def test_a_disc_on_the_left_is_on_the_left():
    scene = coloured_box()
    image, depth = Camera().look(scene, np.array([[5.0, 5.0, 0.0]]), disc(7.0, 6.5, 0.3))
    columns = np.flatnonzero(depth[0] < 3.0)
    assert 0 < columns.min() < columns.max() < 32
    assert image[0, 7, columns].argmax(axis=1).tolist() == [0] * len(columns)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Camera(rows=0), "rows: 0"),
        (lambda: Camera(columns=1), "columns: 1"),
        (lambda: Camera(field_of_view=np.pi), "field_of_view: 3.14"),
        (lambda: Camera(field_of_view=0.0), "field_of_view: 0.0"),
        (lambda: Camera(field_of_view=np.nan), "field_of_view: nan"),
        (lambda: Camera(slope=0.0), "slope"),
        (lambda: Camera().look(coloured_box(), np.zeros(3)), r"poses: shape \(3,\)"),
    ],
)
def test_bad_input_is_named(make, words):
    with pytest.raises(InputError, match=words):
        make()


def test_poses_may_be_any_numbers_in_rows(box):
    image, _ = Camera().look(box, [[5, 5, 0]])
    assert (image == Camera().look(box, np.array([[5.0, 5.0, 0.0]]))[0]).all()


def test_gamma_is_an_exponent_of_every_colour():
    colours = np.array([0.0, 64.0, 128.0, 255.0], np.float32)
    assert Look(gamma=2.0).tone(colours) == pytest.approx([0.0, 16.06, 64.25, 255.0], abs=0.01)
    assert Look(gamma=0.5).tone(colours)[1] == pytest.approx(127.75, abs=0.01)
    dark = replace(make_box(), look=Look(gamma=2.0, floor=(100, 100, 100)))
    assert Scene(dark).backdrop[1] == pytest.approx(np.full(3, 255 * (100 / 255) ** 2))
