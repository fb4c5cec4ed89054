import cv2
import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import to_world
from tutorial_lib.interfaces import Observation
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.plan_view import PlanView
from tutorial_lib.viz.figures.dashboard import Moment, beams_of, dashboard, draw_laser
from tutorial_lib.viz.figures.film import write_film, write_picture
from tutorial_lib.viz.figures.panels import evenly
from tutorial_lib.world.generators import FAMILIES, generate
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera, Laser

CAR = np.array([[0.36, 0.12], [-0.06, 0.12], [-0.06, -0.12], [0.36, -0.12]])


def frames(count, height=48, width=64):
    """Pictures of one colour each, getting redder."""
    shades = np.linspace(20, 220, count).astype(np.uint8)
    pictures = np.zeros((count, height, width, 3), np.uint8)
    pictures[..., 0] = shades[:, None, None]
    pictures[..., 2] = 40
    return list(pictures)


def read_film(path):
    film = cv2.VideoCapture(str(path))
    rate, pictures = film.get(cv2.CAP_PROP_FPS), []
    while True:
        more, picture = film.read()
        if not more:
            return rate, pictures
        pictures.append(picture[..., ::-1])


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


@pytest.mark.parametrize("family", FAMILIES)
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


def test_the_dashboard_shows_the_camera_and_the_laser_with_ahead_up():
    scene, pose = Scene(make_box()), np.array([[1.0, 5.0, 0.0]])  # a wall 1 m behind
    image, depth = Camera(64).look(scene, pose)
    scan = Laser().scan(scene, pose)
    observation = Observation(image, depth, scan, pose, np.zeros(1), np.zeros(1))
    moment = Moment(
        pose[0], CAR, observation, pose[:, :2], pose[:, :2], pose[0, :2] + 1, None, [("t", "0 s")]
    )
    assert beams_of(scan[0])[:, 0].min() == pytest.approx(-1.0, abs=0.01)
    assert dashboard(PlanView(scene), moment, "a title").shape == (760, 1260, 3)
    laser = draw_laser(moment, 320)
    assert laser[20, 160].tolist() == list(colours.PAPER)  # free ahead
    assert laser[300, 160].tolist() == list(colours.ROOMS["open"])  # behind the wall
    assert laser[160 + 40, 140:180].tolist().count(list(colours.LASER)) > 0  # the wall itself


def test_a_film_has_all_frames_in_order_at_its_size_and_rate(tmp_path):
    given = frames(12)
    write_film(tmp_path / "drive.webm", given, 10)
    rate, pictures = read_film(tmp_path / "drive.webm")
    assert rate == pytest.approx(10)
    assert [p.shape for p in pictures] == [(48, 64, 3)] * 12
    assert np.abs(np.array(pictures).astype(int) - given).mean() < 8
    assert [f.name for f in tmp_path.iterdir()] == ["drive.webm"]
    assert (tmp_path / "drive.webm").read_bytes()[:4] == b"\x1aE\xdf\xa3"  # EBML, so WebM


@pytest.mark.parametrize(
    ("name", "pictures", "words"),
    [
        ("a.webm", [], "no frames"),
        ("a.webm", [*frames(3), frames(1, 20)[0]], "size"),
        ("a.webm", frames(3, 47, 63), "even"),
        ("a.xyz", frames(3), "webm"),
    ],
    ids=["no frames", "two sizes", "odd size", "other suffix"],
)
@pytest.mark.filterwarnings("ignore")
def test_a_film_that_cannot_be_written_leaves_what_was_there(name, pictures, words, tmp_path):
    (tmp_path / name).write_text("an older film")
    with pytest.raises(InputError, match=words):
        write_film(tmp_path / name, pictures, 10)
    assert {f.name: f.read_text() for f in tmp_path.iterdir()} == {name: "an older film"}


def test_a_film_interrupted_midway_leaves_what_was_there(tmp_path):
    class Frames(list):
        def __iter__(self):
            yield from self[:3]
            raise KeyboardInterrupt

    (tmp_path / "a.webm").write_text("an older film")
    with pytest.raises(KeyboardInterrupt):
        write_film(tmp_path / "a.webm", Frames(frames(5)), 10)
    assert {f.name: f.read_text() for f in tmp_path.iterdir()} == {"a.webm": "an older film"}


def test_a_picture_comes_back_as_it_was(tmp_path):
    picture = np.random.default_rng(0).integers(0, 256, (13, 17, 3), np.uint8)
    write_picture(tmp_path / "view.png", picture)
    assert (cv2.imread(str(tmp_path / "view.png"))[..., ::-1] == picture).all()
    assert [f.name for f in tmp_path.iterdir()] == ["view.png"]


def test_a_picture_that_cannot_be_written_leaves_what_was_there(tmp_path, monkeypatch):
    (tmp_path / "view.png").write_text("an older picture")
    monkeypatch.setattr(cv2, "imwrite", lambda *_: False)  # so OpenCV says that the disk is full
    with pytest.raises(OSError, match=r"view\.png"):
        write_picture(tmp_path / "view.png", frames(1)[0])
    assert [f.read_text() for f in tmp_path.iterdir()] == ["an older picture"]


def test_frames_are_chosen_evenly_from_first_to_last():
    assert evenly(10, 4).tolist() == [0, 3, 6, 9]
    assert evenly(2, 4).tolist() == [0, 1]
    assert evenly(9, 1).tolist() == [0]
    for total, count in ((0, 3), (5, 0)):
        with pytest.raises(InputError, match="no frames"):
            evenly(total, count)
