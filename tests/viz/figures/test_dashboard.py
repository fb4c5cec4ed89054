import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.interfaces import Observation
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.plan_view import PlanView
from tutorial_lib.viz.figures import dashboard as module
from tutorial_lib.viz.figures.dashboard import Moment, RolloutFilm, dashboard, draw_laser
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera, Laser, beams_of

CAR = np.array([[0.36, 0.12], [-0.06, 0.12], [-0.06, -0.12], [0.36, -0.12]])


def test_a_part_of_a_film_is_a_film():
    film = RolloutFilm(PlanView(Scene(make_box())), ["one", "two", "three"], "a title")
    assert film[1:].moments == ["two", "three"]
    assert film[1:].view is film.view


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


def test_what_the_laser_meets_on_the_left_is_drawn_on_the_left():
    scene, pose = Scene(make_box()), np.array([[5.0, 8.5, 0.0]])  # a wall 1.5 m to the left
    scan = Laser().scan(scene, pose)
    image, nothing = np.zeros((1, 16, 64, 3), np.uint8), np.zeros(1)
    observation = Observation(image, None, scan, pose, nothing, nothing)
    moment = Moment(pose[0], CAR, observation, pose[:, :2], pose[:, :2], None, None, [])
    laser = draw_laser(moment, 320)  # 40 pixels a metre
    assert laser[160, 60].tolist() == list(colours.ROOMS["open"])
    assert laser[160, 260].tolist() == list(colours.PAPER)


def test_the_view_on_the_plan_is_as_wide_as_the_camera_s(monkeypatch):
    scene, pose, nothing = Scene(make_box()), np.array([[5.0, 5.0, 0.0]]), np.zeros(1)
    view, cones, captions = PlanView(scene), [], []
    monkeypatch.setattr(
        PlanView, "polygon", lambda self, picture, points, *_, **__: cones.append(points)
    )
    monkeypatch.setattr(module, "label", lambda picture, text, *_: captions.append(text))
    for camera in (None, Camera(), Camera(field_of_view=float(np.deg2rad(90.0)))):
        image, _ = (camera or Camera()).look(scene, pose)
        scan = Laser().scan(scene, pose)
        seen = Observation(image, None, scan, pose, nothing, nothing, camera=camera)
        moment = Moment(pose[0], CAR, seen, pose[:, :2], pose[:, :2], None, None, [])
        dashboard(view, moment, "a title")
    assert [len(cone) - 1 for cone in cones[::3]] == [32, 32, 24]  # beams, 3.75 degrees apart
    shown = [text for text in captions if text.startswith("camera")]
    assert shown == ["camera, 120 degrees", "camera, 120 degrees", "camera, 90 degrees"]
