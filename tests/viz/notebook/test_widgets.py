import base64

import numpy as np
import pytest

from tests.conftest import make_box
from tests.viz.pictures import decoded
from tutorial_lib.errors import InputError
from tutorial_lib.viz.notebook.teleoperation import ACTIONS, TeleopController
from tutorial_lib.viz.notebook.widgets import KEYS, presses, sliders, teleop
from tutorial_lib.world.scene import Scene

POSE = [5.0, 5.0, 0.0]


@pytest.fixture
def controller():
    return TeleopController(Scene(make_box()), POSE)


def test_buttons_change_picture_and_text(controller):
    panel = teleop(controller)
    assert set(panel.buttons) == {*ACTIONS, "start again"}
    picture, line = panel.picture.value, panel.line.value
    panel.buttons["forward"].click()
    assert panel.picture.value != picture
    assert panel.line.value != line
    assert decoded(panel.picture.value).shape == controller.render().shape
    panel.buttons["start again"].click()
    assert panel.picture.value == picture
    assert panel.line.value == line


def test_arrow_keys_press_buttons(controller):
    panel = teleop(controller)
    before = controller.simulation.poses[0].copy()
    panel._typed({"key": "ArrowUp", "shiftKey": False})
    assert controller.simulation.poses[0, 0] > before[0]
    picture = panel.picture.value
    panel._typed({"key": "a", "shiftKey": False})
    assert panel.picture.value == picture
    assert set(KEYS.values()) == set(ACTIONS)
    assert panel.keyboard.source is panel.picture


def test_the_map_can_be_hidden(controller):
    panel = teleop(controller)
    shown = decoded(panel.picture.value)
    panel.hide_map.value = True
    hidden = decoded(panel.picture.value)
    assert (hidden[:, :500] == 255).mean() > 0.97 > (shown[:, :500] == 255).mean()
    apart = np.abs(hidden[:, 560:].astype(int) - shown[:, 560:])  # few colours are kept of each
    assert apart.mean() < 4


def grey(size, shade):
    return np.full((round(size), 40, 3), int(shade), np.uint8), f"{size:.1f} & {shade}"


def test_sliders_change_picture_and_text():
    panel = sliders(grey, size=(10, 60, 0.5, 20), shade=(0, 200, 10, 100))
    assert panel.values == {"size": 20, "shade": 100}
    assert decoded(panel.picture.value).shape == (20, 40, 3)
    assert "20.0 &amp; 100" in panel.line.value
    panel.controls["size"].value = 55.5
    panel.controls["shade"].value = 30
    assert decoded(panel.picture.value).shape == (56, 40, 3)
    assert (decoded(panel.picture.value) == 30).all()
    assert "55.5 &amp; 30" in panel.line.value


def test_a_slider_has_its_unit_and_as_many_digits_as_its_step():
    def render(push, weight, count):
        return np.zeros((8, 8, 3), np.uint8), f"{push} {weight} {count}"

    panel = sliders(
        render,
        labels={"push": "push, m/s²"},
        push=(0.0, 0.6, 0.06, 0.12),
        weight=(0.0, 3.0, 0.5, 1.0),
        count=(1, 5, 1, 2),
    )
    assert panel.controls["push"].description == "push, m/s²"
    assert panel.controls["weight"].description == "weight"
    assert panel.controls["push"].readout_format == ".2f"
    assert panel.controls["weight"].readout_format == ".1f"


def test_a_range_of_words_is_a_menu():
    seen = []

    def render(plan_family):
        seen.append(plan_family)
        return np.zeros((8, 8, 3), np.uint8), plan_family

    panel = sliders(render, plan_family=["office", "maze"])
    assert panel.controls["plan_family"].description == "plan family"
    panel.controls["plan_family"].value = "maze"
    assert seen == ["office", "maze"]


def test_an_error_while_moving_a_slider_is_shown_and_heals():
    def render(x):
        if x > 5:
            raise ValueError("x is <too> large")
        return np.zeros((8, 8, 3), np.uint8), f"x = {x}"

    panel = sliders(render, x=(0, 10, 1, 2))
    panel.controls["x"].value = 8
    assert "ValueError: x is &lt;too&gt; large" in panel.line.value
    panel.controls["x"].value = 3
    assert "x = 3" in panel.line.value


@pytest.mark.parametrize("span", [(0, 1), (0, 1, 0, 0.5), (0, 1, 0.1, 2), (), ("a", 1)])
def test_wrong_ranges_are_refused(span):
    with pytest.raises(InputError, match="size"):
        sliders(grey, size=span, shade=(0, 1, 1, 1))
    with pytest.raises(InputError, match="range"):
        sliders(grey)


def test_every_shell_leaves_a_static_picture_in_the_same_output(controller):
    for panel in (teleop(controller), sliders(grey, size=(10, 60, 1, 20), shade=(0, 9, 1, 1))):
        bundle = panel._repr_mimebundle_()
        assert "application/vnd.jupyter.widget-view+json" in bundle
        strip = decoded(base64.b64decode(bundle["image/png"]))
        assert strip.shape[1] > 100
        assert strip.shape[1] <= 960


def test_the_static_strip_shows_the_low_the_present_and_the_high_value():
    seen = []

    def render(x, y):
        seen.append((x, y))
        return np.zeros((8, 8, 3), np.uint8), ""

    panel = sliders(render, x=(0, 10, 1, 4), y=(0, 1, 1, 1))
    panel.controls["x"].value = 7
    seen.clear()
    panel._repr_mimebundle_()
    assert seen == [(0, 1), (7, 1), (10, 1)]


class Switch:
    actions = ("on", "off", "break")

    def __init__(self):
        self.text = "off"

    def press(self, name):
        if name == "break":
            raise InputError("switch: broken")
        self.text = name

    def render(self):
        return grey(8, 200 if self.text == "on" else 20)[0]


def test_buttons_of_a_controller_press_it_and_say_what_goes_wrong():
    panel = presses(Switch())
    off = panel.picture.value
    panel.buttons["on"].click()
    assert panel.picture.value != off
    assert ">on<" in panel.line.value
    still = base64.b64decode(panel._repr_mimebundle_()["image/png"])
    assert np.array_equal(decoded(still), decoded(panel.picture.value))
    panel.buttons["break"].click()
    assert "InputError: switch: broken" in panel.line.value
