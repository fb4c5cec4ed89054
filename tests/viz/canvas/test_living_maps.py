"""Maps that mend themselves, drawn."""

import networkx as nx
import numpy as np

from tutorial_lib.viz import PlanView, colours, draw_living_map

POSES = np.array([[0.5, 1.0, 0.0], [3.5, 1.0, 0.0]])


def drawn(box, probability=None, pruned=()):
    view = PlanView(box)
    picture, graph = np.full_like(view.base, 255), nx.DiGraph()
    if probability is not None:
        graph.add_edge(0, 1, probability=probability)
    draw_living_map(view, picture, POSES, graph, pruned)
    return picture


def redness(picture):
    """By how much more red than blue a line has, where it is darkest."""
    red, _, blue = picture[picture.sum(axis=2) == picture.sum(axis=2).min()][0].astype(int)
    return red - blue


def test_an_edge_turns_from_grey_to_vermilion_as_it_is_doubted(box):
    sure, half, doubted = (drawn(box, p) for p in (1.0, 0.5, 0.0))
    assert redness(sure) < 0 < redness(half) < redness(doubted)
    inked = [(picture != 255).any(axis=2).sum() for picture in (sure, doubted)]
    assert 100 < inked[0] < inked[1]  # what is doubted is wider


def test_a_pruned_edge_is_dashed(box):
    dashed, solid = drawn(box, pruned=[(0, 1)]), drawn(box, 0.0)
    rows = (dashed == colours.INK).all(axis=2).any(axis=0)
    changes = np.diff(rows.astype(int))
    assert (changes == 1).sum() >= 5  # dashes
    assert 0.3 < rows.sum() / (solid == colours.LASER).all(axis=2).any(axis=0).sum() < 0.7


def test_nothing_is_drawn_of_an_empty_map(box):
    assert (drawn(box) == 255).all()
