"""Maps and plans drawn on a floor plan."""

from itertools import pairwise

import networkx as nx
import numpy as np
import pytest

from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.plan_view import PlanView
from tutorial_lib.viz.canvas.topomaps import draw_edges, draw_plan, draw_topomap, hue


class Drawn:
    """What is drawn of a map: two vertices of two trajectories, joined in one direction."""

    def __init__(self):
        self.graph = nx.DiGraph([(0, 1)])
        self.trajectory = np.array([0, 1, 1])
        self.alive = np.array([0, 1])


POSES = np.array([[1.0, 1.5, 0.0], [2.5, 1.5, 0.0], [2.5, 2.5, 0.0]])


@pytest.fixture
def view(box):
    return PlanView(box, 300, 300)


def changed(view, picture):
    return (picture != view.base).any(axis=-1)


def surroundings(view, point, picture, reach=6):
    column, row = view.pixels(point).round().astype(int)
    return picture[row - reach : row + reach + 1, column - reach : column + reach + 1]


def test_trajectories_have_colours_of_their_own():
    shades = [hue(number) for number in range(30)]
    assert len(set(shades)) == 30
    apart = [np.abs(np.subtract(*pair)).sum() for pair in pairwise(shades)]
    assert min(apart) > 100


def test_vertices_are_drawn_in_the_colours_of_their_trajectories(view):
    picture = view.base.copy()
    draw_topomap(view, picture, Drawn(), POSES)
    for vertex in (0, 1):
        near = surroundings(view, POSES[vertex, :2], picture).reshape(-1, 3)
        assert (np.abs(near.astype(int) - hue(vertex)).max(axis=1) < 20).any()


def test_a_vertex_that_was_removed_is_not_drawn(view):
    picture = view.base.copy()
    draw_topomap(view, picture, Drawn(), POSES)
    assert not surroundings(view, POSES[2, :2], changed(view, picture)).any()


def test_edges_there_and_back_lie_beside_each_other(view):
    there, back = view.base.copy(), view.base.copy()
    draw_edges(view, there, POSES, [(0, 1)], colours.INK)
    draw_edges(view, back, POSES, [(1, 0)], colours.INK)
    rows = [np.flatnonzero(changed(view, picture).any(axis=1)).mean() for picture in (there, back)]
    assert rows[0] > rows[1]  # one keeps to the right, and driving to the right that is below


def test_a_plan_leads_from_here_over_its_vertices_to_the_goal(view):
    picture = view.base.copy()
    draw_plan(view, picture, POSES, [0, 1], here=[0.6, 0.6, 0.0], goal=POSES[2])
    for first, last in (([0.6, 0.6], POSES[0]), (POSES[0], POSES[1]), (POSES[1], POSES[2])):
        middle = (np.asarray(first)[:2] + last[:2]) / 2
        assert (surroundings(view, middle, picture, 1) == colours.PATH).all(axis=-1).any()
    assert changed(view, picture).sum() < picture.shape[0] * picture.shape[1] / 4


def test_a_plan_without_vertices_goes_straight(view):
    picture = view.base.copy()
    draw_plan(view, picture, POSES, [], here=POSES[0], goal=POSES[1])
    middle = (POSES[0, :2] + POSES[1, :2]) / 2
    assert (surroundings(view, middle, picture, 1) == colours.PATH).all(axis=-1).any()
