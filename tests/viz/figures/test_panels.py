import numpy as np
import pytest

from tests.viz.pictures import plain
from tutorial_lib.errors import InputError
from tutorial_lib.viz.figures.panels import (
    STRIP,
    TITLE,
    camera_picture,
    evenly,
    film_strip,
    side_by_side,
    stacked,
)


def test_a_camera_picture_is_three_to_one_whatever_its_rows():
    image = np.zeros((16, 64, 3), np.uint8)
    image[:, 0] = 255  # left column = left of view
    for rows in (image, np.repeat(image, 4, axis=0)):
        shown = camera_picture(rows, 480)
        assert shown.shape == (160, 480, 3)
        assert (shown[:, :7] == 255).all()
        assert (shown[:, 9:] == 0).all()
    assert camera_picture(image, 480, smooth=True).shape == (160, 480, 3)


def test_pictures_stand_beside_each_other_under_their_titles():
    row = side_by_side([plain(50, 40), plain(20, 30, 9)], ["left", "right"], gap=6)
    assert row.shape == (TITLE + 50, 76, 3)
    assert (row[TITLE:, :40] == 100).all()
    assert (row[TITLE : TITLE + 20, 46:] == 9).all()  # level with its neighbour
    assert (row[TITLE + 20 :, 46:] == 255).all()
    assert (row[:TITLE, :40] != 255).any()
    bare = side_by_side([plain(50, 40), plain(20, 30, 9)], gap=6)
    assert bare.shape == (50, 76, 3)
    assert (bare[15:35, 46:] == 9).all()  # in the middle
    assert side_by_side([plain(50, 40), plain(20, 30)], height=100, gap=0).shape == (100, 230, 3)


def test_pictures_stand_under_each_other():
    column = stacked([plain(50, 40), plain(20, 30, 9)], gap=6)
    assert column.shape == (76, 40, 3)
    assert (column[56:, 5:35] == 9).all()
    assert stacked([plain(50, 40), plain(20, 40)], ["a", "b"], width=80, gap=0).shape == (
        140 + 2 * TITLE,
        80,
        3,
    )


@pytest.mark.parametrize(
    ("pictures", "titles"),
    [([], []), ([plain(4, 4)], ["a", "b"]), ([plain(4, 4)[..., 0]], []), ([plain(4, 4) / 2], [])],
    ids=["nothing", "two titles", "grey", "float"],
)
def test_panels_say_what_they_cannot_show(pictures, titles):
    with pytest.raises(InputError, match="give"):
        side_by_side(pictures, titles)


def test_a_long_title_stays_within_its_picture():
    line = side_by_side([plain(10, 60)], ["a title much longer than that"])
    assert line.shape[1] == 60
    assert (line[:TITLE, -1] == 255).all()


def test_a_film_strip_holds_frames_from_first_to_last_with_times():
    frames = [plain(60, 80, shade) for shade in range(0, 100, 10)]
    whole = film_strip(frames, count=4)
    assert whole.shape == (60, 4 * 80 + 3 * 8, 3)
    assert [int(whole[30, 88 * i + 40, 0]) for i in range(4)] == [0, 30, 60, 90]
    large = [plain(300, 468, shade) for shade in range(0, 100, 10)]
    timed = film_strip(large, np.arange(10) / 10, count=4)
    assert timed.shape == (150 + TITLE, STRIP, 3)
    assert (timed[150:] != 255).any()
    assert film_strip(frames[:2], count=4).shape[1] == 168
    with pytest.raises(InputError, match="no frames"):
        film_strip([])
    with pytest.raises(InputError, match="times"):
        film_strip(frames, [1.0, 2.0])


def test_frames_are_chosen_evenly_from_first_to_last():
    assert evenly(10, 4).tolist() == [0, 3, 6, 9]
    assert evenly(2, 4).tolist() == [0, 1]
    assert evenly(9, 1).tolist() == [0]
    for total, count in ((0, 3), (5, 0)):
        with pytest.raises(InputError, match="no frames"):
            evenly(total, count)
