import numpy as np

from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.plan_view import PlanView
from tutorial_lib.viz.figures.closeups import closeup, matches_picture


def test_a_closeup_is_cut_out_of_the_plan(box):
    view = PlanView(box, 532, 532)
    picture = view.base.copy()
    view.points(picture, [4.0, 6.0], colours.GOAL, 2)
    near = closeup(view, picture, [[4.0, 6.0]], 1.0)
    assert np.abs(np.array(near.shape[:2]) - 2 * view.scale).max() <= 1
    middle = np.array(near.shape[:2]) // 2
    assert (near[tuple(middle)] == colours.GOAL).all()
    square = closeup(view, picture, [[2.0, 2.0], [6.0, 3.0]], 0.5, square=True)
    assert square.shape[0] == square.shape[1]


def test_beyond_the_plan_a_closeup_is_white(box):
    view = PlanView(box, 332, 332)
    assert (closeup(view, view.base, [[40.0, 40.0]], 1.0) == 255).all()
    corner = closeup(view, view.base, [[0.0, 0.0]], 3.0)
    assert (corner[-1, 0] == 255).all()
    assert (corner[0, -1] != 255).any()


def test_matches_stand_where_row_and_column_meet():
    shares = np.zeros((32, 32))
    shares[0, 31] = 1.0  # the current image's left is the target's right
    image = np.full((16, 64, 3), 200, np.uint8)
    picture = matches_picture(image, image, shares, [[0.5, 0.25]], side=320)
    square = picture[-320:, -320:]
    assert (square[5, 314] == colours.ROBOT).all()
    assert (square[300, 10] == 255).all()
    assert (square[160, 80] == colours.LASER).all()
    assert (picture[: 320 // 3, -320:] == 200).all()
    assert (picture[-320:, : 320 // 3] == 200).all()
