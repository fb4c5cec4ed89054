import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.errors import InputError
from tutorial_lib.viz.figures.panels import TITLE
from tutorial_lib.viz.notebook.teleoperation import (
    ACTIONS,
    TeleopController,
    still_strip,
    teleop_picture,
)
from tutorial_lib.world.people import Person
from tutorial_lib.world.scene import Scene

POSE = [5.0, 5.0, 0.0]


@pytest.fixture
def controller():
    return TeleopController(Scene(make_box()), POSE)


def test_each_button_has_its_own_action(controller):
    ends = {}
    for name in ACTIONS:
        controller.reset()
        for _ in range(3):
            controller.press(name)
        ends[name] = controller.simulation.poses[0] - POSE
    assert ends["forward"][0] > 0.5
    assert ends["back"][0] < -0.25
    assert ends["left"][2] > 0.3
    assert ends["right"][2] == pytest.approx(-ends["left"][2])
    assert ends["back left"][1] == pytest.approx(-ends["back right"][1])
    assert ends["back left"][2] < 0 < ends["back right"][2]
    assert np.allclose(ends["stop"], 0)


def test_a_press_lasts_a_few_steps_and_leaves_a_track(controller):
    controller.press("forward")
    assert controller.simulation.seconds == pytest.approx(0.5)
    assert len(controller.track) == 6
    moment = controller.moment
    assert moment.track.shape == (6, 2)
    assert moment.goal is None
    assert dict(moment.lines)["speed"].startswith("+0.")
    controller.reset()
    assert len(controller.track) == 1
    assert np.allclose(controller.simulation.poses[0], POSE)


def test_a_wall_stops_the_car_and_the_text_says_what_to_do():
    controller = TeleopController(Scene(make_box()), [9.0, 5.0, 0.0])
    for _ in range(6):
        controller.press("forward")
    assert controller.simulation.poses[0, 0] < 9.7
    assert "go back" in controller.text
    for _ in range(4):
        controller.press("back")
    assert "go back" not in controller.text


def test_people_walk_while_the_car_waits():
    person = Person([[2.0, 2.0], [2.0, 8.0]], speed=0.5)
    controller = TeleopController(Scene(make_box()), POSE, [person])
    before = controller.render()
    controller.press("stop")
    assert (controller.render() != before).any()


def test_wrong_presses_and_starts_are_refused(controller):
    with pytest.raises(InputError, match="forward"):
        controller.press("fly")
    with pytest.raises(InputError, match="steps"):
        TeleopController(controller.scene, POSE, steps=0)
    with pytest.raises(InputError, match="start"):
        TeleopController(controller.scene, [20.0, 5.0, 0.0])


def test_the_picture_follows_the_state_and_changes_nothing(controller):
    first = controller.render()
    assert (first == teleop_picture(controller.view, controller.moment)).all()
    assert first.dtype == np.uint8
    controller.rehearse(["forward", "left"])
    assert (controller.render() == first).all()


@pytest.mark.parametrize(
    ("wide", "rows", "columns", "scale"),
    [(100, 1, 3, 1.0), (500, 1, 3, 304 / 500), (600, 2, 2, 464 / 600), (900, 3, 1, 720 / 900)],
)
def test_a_strip_has_as_many_rows_as_keep_its_words_readable(wide, rows, columns, scale):
    pictures = [np.full((200, wide, 3), 10 * number, np.uint8) for number in range(1, 4)]
    strip = still_strip(pictures, ["low", "now", "high"])
    high = round(200 * scale)
    assert strip.shape[0] == rows * (TITLE + high) + 16 * (rows - 1)
    assert strip.shape[1] == pytest.approx(columns * wide * scale + 16 * (columns - 1), abs=3)
    assert strip.shape[1] <= 960
    for number in range(3):
        row, column = divmod(number, columns)
        y = row * (TITLE + high + 16) + TITLE + high // 2
        assert (strip[y, round(column * (wide * scale + 16)) + 20] == 10 * (number + 1)).all()
