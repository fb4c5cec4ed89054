import numpy as np
import pytest

from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.labels import label, text_size


def white(height=60, width=200):
    return np.full((height, width, 3), 255, np.uint8)


def test_a_label_stands_on_its_line_and_is_as_wide_as_it_says():
    picture = white()
    label(picture, "HH", 20, 40, 0.8)
    rows, columns = np.nonzero((picture < 128).all(axis=2))
    wide, high = text_size("HH", 0.8)
    assert rows.max() == 39
    assert rows.max() - rows.min() + 1 == pytest.approx(high, abs=1)
    assert 20 <= columns.min() < 25
    assert columns.max() < 20 + wide


def test_a_label_has_its_colour_and_letters_that_are_not_latin():
    picture = white()
    label(picture, "■", 20, 40, 1.0, colours.GOAL)
    assert (picture.reshape(-1, 3) == colours.GOAL).all(axis=1).any()
    theta, question = white(), white()
    label(theta, "θ", 20, 40)
    label(question, "?", 20, 40)
    assert (theta != question).any()


@pytest.mark.parametrize("place", [(-30, 40), (190, 40), (20, -50), (20, 200), (20, 5)])
def test_what_lies_outside_is_cut_off(place):
    picture = white()
    label(picture, "a long text", *place)
    whole = white(400, 600)
    label(whole, "a long text", place[0] + 200, place[1] + 150)
    assert (picture == whole[150:210, 200:400]).all()
