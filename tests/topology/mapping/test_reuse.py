"""An anchor on an edge of the map is replaced by the two vertices of the edge."""

import numpy as np
import pytest

from tests.made_up_maps import anchors, edges_of, table_map
from tutorial_lib.topology.mapping.edge_rules import MapSettings, reusable_edge
from tutorial_lib.topology.mapping.insertion import add_trajectory

SURE = 0.98
ALONG = [(5, 1), (1, 6), (6, 2), (2, 7)]
"""Anchor 6 lies between vertices 1 and 2: from anchor 5 to 1, over 6 to 2, and on to anchor 7."""


def inserted(pairs=ALONG, edges=((0, 1), (1, 2), (2, 3)), turn=False, **settings):
    """A map of vertices 0 to 3, and a trajectory of anchors 4 to 8 that is added to it."""
    table = np.full((9, 9), 0.2)
    for source, target in pairs:
        table[source, target] = SURE
    topomap = table_map(table, 4, p_outdated=0.0, **settings)
    for source, target in edges:
        if turn:
            topomap.connect_by_turn(source, target, SURE, np.pi)
        else:
            topomap.connect(source, target, SURE, driven=1)
    return topomap, add_trajectory(topomap, anchors(range(4, 9)))


def test_the_two_vertices_of_an_edge_stand_for_the_anchor_between_them():
    topomap, added = inserted()
    assert added.path.tolist() == [4, 5, 2, 6, 7]
    assert added.reused.tolist() == [False, False, True, False, False]
    assert topomap.paths[1] == [4, 5, 1, 2, 6, 7]
    # Each new vertex knows its place on the longer path.
    assert [topomap.paths[1][place] for place in topomap.place[4:]] == [4, 5, 6, 7]
    driven = {pair: times for pair, (_, times) in edges_of(topomap).items() if times}
    assert driven[5, 1] == driven[2, 6] == 1
    assert driven[1, 2] == 2
    assert (5, 2) not in driven


def test_in_the_paper_only_a_vertex_replaces_an_anchor():
    topomap, added = inserted(p_between=1.0)
    assert not added.reused.any()
    assert len(topomap) == 9


@pytest.mark.parametrize("missing", ALONG)
def test_each_of_the_four_steps_must_be_sure(missing):
    _, added = inserted([pair for pair in ALONG if pair != missing])
    assert not added.reused.any()


def test_the_two_steps_to_and_from_the_anchor_have_a_threshold_of_their_own():
    assert not inserted(p_between=0.985)[1].reused.any()
    beside = [pair for pair in ALONG if 6 not in pair]
    assert inserted(beside, p_between=0.1)[1].reused.any()


def test_an_edge_must_be_on_the_map_and_lead_onward():
    assert not inserted(edges=[(0, 1), (2, 3)])[1].reused.any()
    assert not inserted(edges=[(2, 1)])[1].reused.any()


def test_no_edge_on_which_a_robot_turns_stands_for_an_anchor():
    assert not inserted(turn=True)[1].reused.any()


def test_a_vertex_that_fits_by_itself_comes_first():
    topomap, added = inserted([*ALONG, (5, 3), (3, 7)])
    assert added.path.tolist()[2] == 3
    assert topomap.paths[1] == [4, 5, 3, 6, 7]


def test_no_edge_leads_back_along_its_trajectory():
    # On a path 2, 1 the vertices lie the other way round, though an edge leads from 1 to 2.
    table = np.full((9, 9), 0.2)
    for pair in ALONG:
        table[pair] = SURE
    topomap = table_map(table, 4, p_outdated=0.0)
    topomap.place = np.array([0, 2, 1, 3])
    topomap.paths = [[0, 2, 1, 3]]
    topomap.connect(1, 2, SURE)
    assert not add_trajectory(topomap, anchors(range(4, 9))).reused.any()


def test_the_edge_with_the_largest_product_is_taken():
    into, onward = [0.99, 0.96, 0.5, 0.2], [0.3, 0.3, 0.97, 0.98]
    edges = [[0, 2], [1, 3], [0, 3], [2, 3]]
    assert reusable_edge(into, onward, edges, [0.99, 0.99, 0.96, 1.0], 0.95) == (0, 2)
    assert reusable_edge(into, onward, edges, [0.99, 0.99, 0.99, 1.0], 0.95) == (0, 3)
    assert reusable_edge(into, onward, edges, [0.95] * 4, 0.95) is None
    assert reusable_edge(into, onward, [], [], 0.95) is None


def test_edges_are_reused_unless_it_is_said_otherwise():
    assert MapSettings().p_between == MapSettings().p_reuse == 0.94
