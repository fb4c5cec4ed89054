import base64
import re

import cv2
import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.errors import InputError
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.field_of_view import draw_field_of_view, ray_ends
from tutorial_lib.viz.canvas.plan_view import PlanView
from tutorial_lib.viz.figures.charts import chart, from_figure
from tutorial_lib.viz.figures.film import png
from tutorial_lib.viz.figures.panels import (
    TITLE,
    camera_picture,
    faded,
    film_strip,
    side_by_side,
    stacked,
)
from tutorial_lib.viz.notebook.display import play, show
from tutorial_lib.world.scene import Scene


def plain(height, width, shade=100):
    return np.full((height, width, 3), shade, np.uint8)


def decoded(data):
    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]


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
    whole = film_strip(frames, count=4, width=10_000, gap=8)
    assert whole.shape == (60, 4 * 80 + 3 * 8, 3)
    assert [int(whole[30, 88 * i + 40, 0]) for i in range(4)] == [0, 30, 60, 90]
    timed = film_strip(frames, np.arange(10) / 10, count=4, width=172, gap=4)
    assert timed.shape == (30 + TITLE, 172, 3)
    assert (timed[30:] != 255).any()
    assert film_strip(frames[:2], count=4).shape[1] == 168
    with pytest.raises(InputError, match="no frames"):
        film_strip([])
    with pytest.raises(InputError, match="times"):
        film_strip(frames, [1.0, 2.0])


def test_rays_end_at_the_walls_and_the_field_of_view_is_tinted():
    scene, pose = Scene(make_box()), np.array([2.0, 5.0, 0.0])
    ends = ray_ends(scene, pose, [0.0, np.pi / 2, np.pi])
    assert np.allclose(ends, [[10, 5], [2, 10], [0, 5]])
    view = PlanView(scene, 200, 200)
    picture = view.base.copy()
    draw_field_of_view(view, picture, scene, pose)

    def changed(point):
        column, row = np.floor(view.pixels(point)).astype(int)
        return (picture[row, column] != view.base[row, column]).any()

    assert changed([6.0, 5.0])
    assert not changed([1.0, 5.0])  # behind
    assert not changed([2.5, 9.0])  # 83 degrees to the left
    assert (faded(picture) >= picture).all()
    before = picture.copy()
    view.rays(picture, pose, ends)
    view.arrow(picture, pose)
    assert (picture != before).any()


def test_a_png_keeps_few_colours_and_nearly_keeps_many():
    few = plain(20, 30)
    few[5:9, 3:20] = colours.LASER
    assert (decoded(png(few)) == few).all()
    slope = np.stack([np.tile(np.arange(256), (40, 1))] * 3, axis=-1).astype(np.uint8)
    slope[..., 2] = np.arange(40)[:, None] * 6
    assert np.abs(decoded(png(slope)).astype(int) - slope).mean() < 8
    for k, colour in enumerate(colours.THINGS):  # which keep their colours beside many others
        slope[2 * k, :20] = colour
    back = decoded(png(slope))
    assert all((back[2 * k, :20] == colour).all() for k, colour in enumerate(colours.THINGS))
    with pytest.raises(InputError, match="uint8"):
        png(slope / 255)
    assert decoded(show(few)._repr_png_()).shape == few.shape


def test_a_figure_becomes_a_picture():
    figure, axes = chart(4, 3, columns=2)
    for axis in axes:
        axis.plot([0, 1], [0, 1], color=colours.unit(colours.ROBOT))
    picture = from_figure(figure)
    assert picture.shape == (288, 384, 3)
    assert picture.dtype == np.uint8
    near = np.abs(picture.astype(int) - colours.ROBOT).max(axis=-1) < 3
    assert near.sum() > 50


def test_a_film_is_one_of_its_own_kind_and_leaves_a_strip(tmp_path):
    frames = [plain(31, 45, shade) for shade in range(0, 200, 20)]  # odd sizes too
    film = play(frames, 5)
    page = film._repr_html_()
    assert all(word in page for word in ("<video", "controls", "loop", "muted"))
    assert re.findall(r"(?:https?:)?//[a-z]", page.split("base64")[0]) == []
    data = base64.b64decode(re.search(r"base64,([^\"]*)", page)[1])
    (tmp_path / "film.webm").write_bytes(data)
    capture = cv2.VideoCapture(str(tmp_path / "film.webm"))
    count = 0
    while capture.read()[0]:
        count += 1
    assert count == 10
    assert decoded(film._repr_png_()).shape[0] == 31 + 1 + TITLE


def test_a_film_shows_as_html_and_as_a_picture(monkeypatch):
    shown = []
    monkeypatch.setattr("IPython.display.publish_display_data", shown.append)
    play([plain(32, 32)] * 3, 5)._ipython_display_()
    assert [next(iter(data)) for data in shown] == ["text/html", "image/png"]
