import numpy as np

from tests.conftest import make_box
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.outcomes import draw_outcome, outcome_legend
from tutorial_lib.viz.canvas.plan_view import PlanView
from tutorial_lib.world.scene import Scene


def test_reached_and_missed_targets_have_different_shapes():
    view = PlanView(Scene(make_box()), 400, 400)
    drawn = []
    for reached in (True, False):
        picture = view.base.copy()
        draw_outcome(view, picture, [5.0, 5.0], reached)
        drawn.append((picture != view.base).any(axis=2))
    disc, cross = drawn
    assert not (disc == cross).all()
    column, row = view.pixels([5.0, 5.0]).round().astype(int)
    beside = row, column + 5  # between two arms of the cross, within the disc
    assert disc[beside]
    assert not cross[beside]
    legend = outcome_legend()
    for colour in (colours.GOAL, colours.LASER):
        assert (legend == np.array(colour)).all(axis=2).any()
