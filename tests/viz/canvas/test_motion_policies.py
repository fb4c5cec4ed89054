import numpy as np
import pytest

from tutorial_lib.viz.canvas.motion_policies import draw_arrows, draw_metrics, ellipse
from tutorial_lib.viz.canvas.plan_view import PlanView


def test_ellipses_are_long_where_a_metric_weighs_most():
    reach = np.abs(ellipse([[9.0, 0.0], [0.0, 1.0]], 0.1, 2.0)).max(axis=0)
    assert reach == pytest.approx([0.2, 0.1], abs=1e-6)  # at most twice the size
    slanted = ellipse([[2.5, 1.5], [1.5, 2.5]], 0.1, 9.0)
    far = slanted[np.linalg.norm(slanted, axis=1).argmax()]
    assert abs(far[0] - far[1]) < 0.02


def test_policies_are_drawn_where_they_are(box):
    view = PlanView(box, 532, 532)
    picture = view.base.copy()
    draw_metrics(view, picture, [[5.0, 5.0]], [100 * np.eye(2)])
    draw_arrows(view, picture, [[5.0, 5.0]], [[1.0, 0.0]])
    changed = np.argwhere((picture != view.base).any(axis=2))
    x, y = view.pixels([5.0, 5.0])
    assert changed[:, 1].max() == pytest.approx(x + view.scale, abs=3)
    assert changed[:, 1].min() == pytest.approx(x - 0.18 * view.scale, abs=3)
    assert changed[:, 0].min() == pytest.approx(y - 0.18 * view.scale, abs=3)


@pytest.mark.parametrize("angle", [0.4, -1.0, 1.3])
def test_ellipses_lie_along_the_axis_on_which_a_metric_weighs_most(angle):
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    outline = ellipse(turn @ np.diag([9.0, 1.0]) @ turn.T, 0.1, 9.0)
    assert np.abs(outline @ turn).max(axis=0) == pytest.approx([0.3, 0.1], abs=0.002)
