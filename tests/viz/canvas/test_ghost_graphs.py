"""A graph with ghosts, and what was seen, drawn."""

import numpy as np
import pytest

from tutorial_lib.geometry import to_world
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.ghost_graphs import (
    GHOST,
    UNSEEN,
    draw_ghost_graph,
    draw_seen,
    score_colours,
)
from tutorial_lib.viz.canvas.plan_view import PlanView

NODES = np.array([[2.0, 2.0, 0.3], [5.0, 2.0, -1.0]])


def at(view, picture, point):
    column, row = view.pixels(point).round().astype(int)
    return tuple(picture[row, column].tolist())


def drawn(box, ghosts=(), chosen=None, edges=((0, 1),), written=False):
    view = PlanView(box, 400, 400)
    picture = np.full_like(view.base, 255)
    draw_ghost_graph(view, picture, NODES, edges, ghosts, chosen, written)
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
    assert high == GHOST
    assert sum(low) > sum(high) + 200
    assert at(view, picture, [5.0, 3.5]) != colours.PAPER  # the line from its node
    assert at(view, picture, [3.5, 5.0]) == colours.PAPER


def test_where_the_robot_goes_has_an_amber_ring(box):
    view, picture = drawn(box, chosen=[7.0, 7.0])
    assert at(view, picture, [7.0, 7.0]) == colours.PAPER
    assert (picture == np.array(colours.PATH)).all(axis=2).sum() > 30
    assert not (drawn(box)[1] == np.array(colours.PATH)).all(axis=2).any()


def test_scores_that_are_all_alike_have_one_colour():
    assert score_colours([]) == []
    assert score_colours([0.5, 0.5]) == [GHOST] * 2
    low, middle, high = score_colours([0.2, 0.3, 0.4])
    assert sum(low) > sum(middle) > sum(high)


def test_scores_are_written_beside_their_ghosts(box):
    ghosts = [(0, [2.0, 5.0], 0.4), (1, [5.0, 5.0], 0.9)]
    (view, plain), (_, scored) = drawn(box, ghosts), drawn(box, ghosts, written=True)
    changed = np.argwhere((plain != scored).any(axis=2))
    for _, ghost, _ in ghosts:
        column, row = view.pixels(ghost)
        near = np.abs(changed - [row, column + 35]).max(axis=1) < 30
        assert near.any()
        changed = changed[~near]
    assert not len(changed)


def test_an_empty_graph_changes_nothing(box):
    view = PlanView(box, 400, 400)
    picture = view.base.copy()
    draw_ghost_graph(view, picture, [], [])
    assert np.array_equal(picture, view.base)


@pytest.mark.parametrize("frame", [(0.0, 0.0, 0.0), (4.0, 3.0, 0.7)])
def test_cells_are_drawn_in_the_frame_of_the_grid(box, frame):
    view = PlanView(box, 400, 400)
    grid = np.zeros((20, 20), np.uint8)
    grid[2:6, 8:12] = 1
    grid[2:6, 12:14] = 2
    corner = np.array([0.5, -0.4])
    picture = draw_seen(view, grid, corner, 0.25, np.array(frame))
    assert picture.shape == view.base.shape

    def shown(row, column):
        point = corner + (np.array([column, row]) + 0.5) * 0.25
        return at(view, picture, to_world(np.array(frame), point))

    assert shown(4, 10) == colours.PAPER
    assert shown(4, 12) == colours.SOLID
    assert shown(4, 6) == UNSEEN
    assert shown(8, 10) == UNSEEN
    assert at(view, picture, to_world(np.array(frame), [0.2, 0.1])) == UNSEEN  # off the grid
