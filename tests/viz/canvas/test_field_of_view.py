import numpy as np

from tests.conftest import make_box
from tutorial_lib.viz.canvas.field_of_view import draw_field_of_view, ray_ends
from tutorial_lib.viz.canvas.plan_view import PlanView
from tutorial_lib.viz.figures.panels import (
    faded,
)
from tutorial_lib.world.scene import Scene


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


def test_rays_turn_with_the_robot():
    scene = Scene(make_box())
    ends = ray_ends(scene, [2.0, 5.0, np.pi / 2], [-np.pi / 2, 0.0, np.pi / 2])
    assert np.allclose(ends, [[10, 5], [2, 10], [0, 5]])
