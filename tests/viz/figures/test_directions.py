"""Directions under a panorama, and around a local map."""

import numpy as np
import pytest

from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.figures.directions import map_picture, panorama_picture, scored_panorama
from tutorial_lib.world.sensors import PanoramicCamera

WIDTH = 768
TALL = 96  # of the panorama


@pytest.fixture
def image():
    return np.random.default_rng(0).integers(0, 255, (16, 192, 3), dtype=np.uint8)


def bars(picture, colour):
    """Which columns have something of this colour under the panorama."""
    return (picture[TALL:] == np.array(colour)).all(axis=2).any(axis=0)


def test_a_panorama_keeps_its_columns(image):
    shown = panorama_picture(image, WIDTH)
    assert shown.shape == (TALL, WIDTH, 3)
    assert (shown[0, 2 :: WIDTH // 192] == image[0]).all()


def test_a_bar_stands_under_the_middle_of_its_patch(image):
    columns = np.arange(192, dtype=np.uint8)[None, None, :, None]
    middles = PanoramicCamera().split(columns.repeat(3, 3))[0]
    for k in range(12):
        picture = scored_panorama(image, np.full(12, 0.5), np.arange(12) == k)
        columns = np.flatnonzero(bars(picture, colours.ROBOT))
        middle = int(middles[k, 0, 24, 0]) * WIDTH // 192
        gaps = (columns - middle + WIDTH // 2) % WIDTH - WIDTH // 2
        assert len(columns) > 20
        assert abs(gaps.mean()) < 2, k


def test_bars_grow_with_the_score_and_the_chosen_one_is_green(image):
    scores = np.linspace(0.1, 0.9, 12)
    picture = scored_panorama(image, scores, chosen=4)
    green = bars(picture, colours.GOAL)
    assert green.any()
    blue = (picture[TALL:] == np.array(colours.ROBOT)).all(axis=2)
    heights = [blue[:, round(WIDTH * (0.5 - k / 12)) % WIDTH].sum() for k in range(12) if k != 4]
    assert (np.diff(heights) > 0).all()
    assert not bars(scored_panorama(image, scores), colours.GOAL).any()


def test_the_truth_is_a_line_where_a_true_bar_would_end(image):
    scores, truth = np.zeros(12), np.linspace(0, 1, 12)
    picture = scored_panorama(image, scores, truth=truth)
    line = (picture[TALL:] == np.array(colours.LASER)).all(axis=2)
    rows = [line[:, round(WIDTH * (0.5 - k / 12)) % WIDTH].nonzero()[0].mean() for k in range(12)]
    assert (np.diff(rows) < 0).all()
    assert not bars(scored_panorama(image, scores), colours.LASER).any()


def test_a_map_is_drawn_with_y_up_and_dots_where_directions_end():
    free = np.ones((71, 71), bool)
    free[60:] = False  # on the robot's left, which is up
    chosen = np.arange(12) == 3
    picture = map_picture(free, chosen, 30)
    assert picture.shape == (355, 355, 3)
    assert tuple(picture[5, 5]) == colours.SOLID
    assert tuple(picture[-5, 5]) == colours.PAPER
    for row, column, colour in ((27, 177, colours.GOAL), (177, 327, colours.LASER)):
        assert tuple(picture[row, column - 11]) == colour  # a disc...
        disc = picture[row - 6 : row + 7, column - 6 : column + 7].reshape(-1, 3)
        assert (disc == colours.PAPER).all(axis=1).any()  # ...with a number
    assert tuple(picture[177, 177]) == colours.ROBOT
