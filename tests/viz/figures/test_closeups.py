import json

import numpy as np
import pytest

from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.results import FOLDER, load_result
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.motion_policies import draw_arrows, draw_metrics, ellipse
from tutorial_lib.viz.canvas.plan_view import PlanView
from tutorial_lib.viz.figures.closeups import closeup, matches_picture


def test_a_closer_look_is_cut_out_of_the_map(box):
    view = PlanView(box, 532, 532)
    picture = view.base.copy()
    view.points(picture, [4.0, 6.0], colours.GOAL, 2)
    near = closeup(view, picture, [[4.0, 6.0]], 1.0)
    assert np.abs(np.array(near.shape[:2]) - 2 * view.scale).max() <= 1
    middle = np.array(near.shape[:2]) // 2
    assert (near[tuple(middle)] == colours.GOAL).all()
    square = closeup(view, picture, [[2.0, 2.0], [6.0, 3.0]], 0.5, square=True)
    assert square.shape[0] == square.shape[1]


def test_beyond_the_map_a_closer_look_is_white(box):
    view = PlanView(box, 332, 332)
    assert (closeup(view, view.base, [[40.0, 40.0]], 1.0) == 255).all()
    corner = closeup(view, view.base, [[0.0, 0.0]], 3.0)
    assert (corner[-1, 0] == 255).all()
    assert (corner[0, -1] != 255).any()


def test_matches_stand_where_row_and_column_meet():
    shares = np.zeros((32, 32))
    shares[0, 31] = 1.0  # the current picture's left is the target's right
    image = np.full((16, 64, 3), 200, np.uint8)
    picture = matches_picture(image, image, shares, [[0.5, 0.25]], side=320)
    square = picture[-320:, -320:]
    assert (square[5, 314] == colours.ROBOT).all()
    assert (square[300, 10] == 255).all()
    assert (square[160, 80] == colours.LASER).all()
    assert (picture[: 320 // 3, -320:] == 200).all()
    assert (picture[-320:, : 320 // 3] == 200).all()


def test_ellipses_are_long_where_a_metric_weighs_most():
    reach = np.abs(ellipse([[9.0, 0.0], [0.0, 1.0]], 0.1, 2.0)).max(axis=0)
    assert reach == pytest.approx([0.2, 0.1], abs=1e-6)  # at most twice the size
    slanted = ellipse([[2.5, 1.5], [1.5, 2.5]], 0.1, 9.0)
    far = slanted[np.linalg.norm(slanted, axis=1).argmax()]
    assert abs(far[0] - far[1]) < 0.02


def test_policies_are_drawn_where_they_are(box):
    view = PlanView(box, 532, 532)
    picture = view.base.copy()
    draw_metrics(view, picture, [[5.0, 5.0]], [np.eye(2)], size=0.5)
    draw_arrows(view, picture, [[5.0, 5.0]], [[1.0, 0.0]])
    changed = np.argwhere((picture != view.base).any(axis=2))
    x, y = view.pixels([5.0, 5.0])
    assert changed[:, 1].max() == pytest.approx(x + view.scale, abs=3)
    assert changed[:, 1].min() == pytest.approx(x - 0.5 * view.scale, abs=3)
    assert changed[:, 0].min() == pytest.approx(y - 0.5 * view.scale, abs=3)


def test_stored_results_are_read_and_missing_or_damaged_ones_named(tmp_path):
    names = [file.stem for file in FOLDER.glob("*.json")]
    assert names
    for name in names:
        assert load_result(name).rows
    with pytest.raises(InputError, match="no 'nothing'"):
        load_result("nothing", tmp_path)
    for text in ("{", json.dumps({"name": "bad"}), json.dumps([1])):
        (tmp_path / "bad.json").write_text(text)
        with pytest.raises(InputError, match="restore the file"):
            load_result("bad", tmp_path)
