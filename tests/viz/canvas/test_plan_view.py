import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.geometry import to_world
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.plan_view import PlanView
from tutorial_lib.world.generators import FAMILIES, generate
from tutorial_lib.world.scene import Scene

CAR = np.array([[0.36, 0.12], [-0.06, 0.12], [-0.06, -0.12], [0.36, -0.12]])


def at(view, picture, point):
    """The colour of the pixel that holds a point in metres."""
    column, row = np.floor(view.pixels(point)).astype(int)
    return tuple(picture[row, column].tolist())


def metres_of_changes(view, before, after):
    """Points (K, 2) in metres of the pixels that differ."""
    rows, columns = np.nonzero((before != after).any(axis=-1))
    origin = view.pixels([0.0, 0.0])
    return (np.stack([columns, rows], axis=1) + 0.5 - origin) / [view.scale, -view.scale]


def test_the_view_fits_the_plan_and_y_goes_up():
    view = PlanView(Scene(make_box()))
    corners = [[0, 0], [10, 0], [0, 10], [10, 10], [5, 5]]
    expected = [[16, 704], [704, 704], [16, 16], [704, 16], [360, 360]]
    assert np.allclose(view.pixels(corners), expected)
    wide = PlanView(Scene(make_box(20.0, 5.0)), width=500, height=300, margin=10)
    assert wide.scale == pytest.approx(24.0)  # pixels per metre, the same for x and y
    assert np.allclose(wide.pixels([[0, 0], [20, 5]]), [[10, 210], [490, 90]])
    assert wide.base.shape == (300, 500, 3)
    assert wide.base.dtype == np.uint8


def test_floors_walls_and_pillars_are_where_they_belong():
    view = PlanView(Scene(make_box(pillars=[(3.0, 7.0, 0.8)])))
    assert at(view, view.base, [5, 5]) == colours.ROOMS["living"]
    assert at(view, view.base, [3, 3]) == colours.ROOMS["living"]
    assert at(view, view.base, [3.0, 7.0]) != colours.ROOMS["living"]
    assert tuple(view.base[1, 1].tolist()) == colours.PAPER
    # The lower wall's strip is one stripe of 0.4 m after another, from the left.
    for k in (2, 5, 8):
        seen = np.array(at(view, view.base, [k + 0.2, 0.0]))
        assert np.abs(seen - [k * 9, 255 - k * 9, 80]).max() < 3


def test_a_plain_plan_is_pale_and_grey_and_leaves_the_plan_as_it_is():
    view = PlanView(Scene(generate("apartment", 2)), 200, 260)
    base = view.base.copy()
    assert view.plain.shape == base.shape
    assert (view.plain == view.plain[..., :1]).all()
    assert view.plain.mean() > base.mean()
    assert (view.base == base).all()


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.few(2)
def test_every_room_of_a_plan_shows_its_tint(family):
    scene = Scene(generate(family, 81))
    view, grid = PlanView(scene), scene.clearance
    points = grid.centres(np.argwhere(grid.clearance > 0.25)[::23])
    for room in scene.plan.rooms:
        for point in points[room.contains(points)]:
            assert at(view, view.base, point) == colours.ROOMS[room.kind]


@pytest.mark.parametrize("heading", [0.0, np.pi / 2, -2.0])
def test_a_robot_changes_only_its_place_and_points_ahead(heading):
    view, pose = PlanView(Scene(make_box())), np.array([3.0, 6.0, heading])
    picture = view.base.copy()
    view.robot(picture, pose, CAR)
    changed = metres_of_changes(view, view.base, picture)
    local = changed - pose[:2]
    assert np.hypot(*local.T).max() < np.hypot(0.36, 0.12) + 2 / view.scale
    ahead = local @ [np.cos(heading), np.sin(heading)]
    assert (ahead.min(), ahead.max()) == pytest.approx((-0.06, 0.36), abs=2 / view.scale)
    assert at(view, picture, to_world(pose, [0.05, 0.0])) == colours.ROBOT
    assert at(view, picture, to_world(pose, [0.27, 0.0])) == colours.PAPER


def test_goals_discs_lines_and_dots_change_only_their_place():
    view, spot = PlanView(Scene(make_box())), np.array([7.0, 2.0])
    for draw, reach, colour in (
        (lambda p: view.goal(p, spot), 0.34, colours.GOAL),
        (lambda p: view.disc(p, spot, 0.5, colours.PERSON), 0.5, colours.PERSON),
        (lambda p: view.points(p, [spot], colours.LASER, 3.0), 3 / view.scale, colours.LASER),
        (lambda p: view.polyline(p, [spot, spot + 1], colours.PATH, 5), 1.5, colours.PATH),
    ):
        picture = view.base.copy()
        draw(picture)
        distance = np.hypot(*(metres_of_changes(view, view.base, picture) - spot).T)
        assert distance.max() == pytest.approx(reach, abs=2.5 / view.scale + 0.08 * (reach > 1))
        assert at(view, picture, spot) == colour
    untouched = view.base.copy()
    view.polyline(untouched, np.zeros((0, 2)), colours.PATH, 3)
    view.points(untouched, np.zeros((0, 2)), colours.LASER, 3)
    assert (untouched == view.base).all()


def test_walls_have_the_colours_of_their_place_on_the_strip():
    view = PlanView(Scene(make_box()), 1032, 1032)
    # Each wall begins 10 m on along the strip, which repeats after 25.6 m; stripe k lies from k to
    # k + 0.4 m.
    for point, stripe in (([4.2, 0.0], 4), ([10.0, 2.2], 12), ([5.8, 10.0], 24), ([0.0, 9.2], 5)):
        colour = np.array([stripe * 9, 255 - stripe * 9, 80])
        assert np.abs(at(view, view.base, point) - colour).max() <= 12
    assert np.abs(np.array(at(view, view.base, [10.0, 2.7])) - [200, 190, 160]).max() <= 3


@pytest.mark.parametrize("none", [[], np.array([]), np.empty((0, 2))])
def test_of_no_points_nothing_is_drawn(box, none):
    view = PlanView(box, 200, 200)
    picture = view.base.copy()
    view.polyline(picture, none, (1, 2, 3), 2.0)
    view.points(picture, none, (1, 2, 3), 2.0)
    assert (picture == view.base).all()
