"""A graph with ghosts, drawn."""

import numpy as np

from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.ghosts import draw_ghost_graph, score_colours
from tutorial_lib.viz.canvas.plan_view import PlanView

NODES = np.array([[2.0, 2.0, 0.3], [5.0, 2.0, -1.0]])


def at(view, picture, point):
    column, row = view.pixels(point).round().astype(int)
    return tuple(picture[row, column].tolist())


def drawn(box, ghosts=(), chosen=None, edges=((0, 1),)):
    view = PlanView(box, 400, 400)
    picture = np.full_like(view.base, 255)
    draw_ghost_graph(view, picture, NODES, edges, ghosts, chosen)
    return view, picture


def test_nodes_and_edges_are_dark_and_the_rest_stays_white(box):
    view, picture = drawn(box)
    assert at(view, picture, [3.5, 2.0]) == colours.INK
    assert at(view, picture, [2.0, 2.15]) == colours.INK
    assert at(view, picture, [3.5, 4.0]) == colours.PAPER
    view, picture = drawn(box, edges=())
    assert at(view, picture, [3.5, 2.0]) == colours.PAPER


def test_the_ghost_with_the_higher_score_is_darker_and_hangs_on_its_node(box):
    ghosts = [(0, [2.0, 5.0], 0.4), (1, [5.0, 5.0], 0.9)]
    view, picture = drawn(box, ghosts)
    low, high = at(view, picture, [2.0, 5.0]), at(view, picture, [5.0, 5.0])
    assert high == colours.ROBOT
    assert sum(low) > sum(high) + 200
    assert at(view, picture, [5.0, 3.5]) != colours.PAPER  # the line from its node
    assert at(view, picture, [3.5, 5.0]) == colours.PAPER


def test_where_the_robot_goes_has_a_green_ring(box):
    view, picture = drawn(box, chosen=[7.0, 7.0])
    assert at(view, picture, [7.0, 7.0]) == colours.PAPER
    assert (picture == np.array(colours.GOAL)).all(axis=2).sum() > 30
    assert not (drawn(box)[1] == np.array(colours.GOAL)).all(axis=2).any()


def test_scores_that_are_all_alike_have_one_colour():
    assert score_colours([]) == []
    assert score_colours([0.5, 0.5]) == [colours.ROBOT] * 2
    low, middle, high = score_colours([0.2, 0.3, 0.4])
    assert sum(low) > sum(middle) > sum(high)
