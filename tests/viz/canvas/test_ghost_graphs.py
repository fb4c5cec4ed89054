import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.geometry import to_world
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.ghost_graphs import GHOST, UNSEEN, draw_ghost_graph, draw_seen
from tutorial_lib.viz.canvas.plan_view import PlanView
from tutorial_lib.world.scene import Scene

NODES, GHOSTS = np.array([[2.0, 2.0], [5.0, 2.0]]), np.array([[5.0, 5.0], [8.0, 2.0]])


@pytest.fixture(scope="module")
def view():
    return PlanView(Scene(make_box()), 400, 300)


def at(view, picture, point):
    column, row = np.floor(view.pixels(point)).astype(int)
    return tuple(picture[row, column].tolist())


def test_nodes_edges_and_ghosts_are_where_they_belong(view):
    picture = view.base.copy()
    draw_ghost_graph(view, picture, NODES, [(0, 1)], GHOSTS, [1, 1])
    assert [at(view, picture, node) for node in NODES] == [colours.INK] * 2
    assert at(view, picture, [3.5, 2.0]) == colours.INK
    assert [at(view, picture, ghost) for ghost in GHOSTS] == [colours.PAPER] * 2  # rings
    ring = 5.8 / view.scale
    for place in (GHOSTS[0] + [0.0, ring], (NODES[1] + GHOSTS[0]) / 2):  # on its own node
        assert np.abs(np.subtract(at(view, picture, place), GHOST)).max() < 40
    between = (NODES[0] + GHOSTS[0]) / 2
    assert at(view, picture, between) == at(view, view.base, between)


def test_scores_are_written_beside_the_ghosts(view):
    plain, scored = view.base.copy(), view.base.copy()
    draw_ghost_graph(view, plain, NODES, [], GHOSTS, [1, 1])
    draw_ghost_graph(view, scored, NODES, [], GHOSTS, [1, 1], [0.82, 1.0])
    changed = np.argwhere((plain != scored).any(axis=2))
    for ghost in GHOSTS:
        column, row = view.pixels(ghost)
        near = np.abs(changed - [row, column + 25]).max(axis=1) < 25
        assert near.any()
        changed = changed[~near]
    assert not len(changed)


def test_an_empty_graph_changes_nothing(view):
    picture = view.base.copy()
    draw_ghost_graph(view, picture, [], [], [], [])
    assert np.array_equal(picture, view.base)


@pytest.mark.parametrize("frame", [(0.0, 0.0, 0.0), (4.0, 3.0, 0.7)])
def test_cells_are_drawn_in_the_frame_of_the_grid(view, frame):
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
