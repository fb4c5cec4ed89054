"""The share of edges that the index finds, in a made-up street."""

from types import SimpleNamespace

import numpy as np
import pytest

from tests.made_up_maps import StreetsAlike, anchors_at, street
from tutorial_lib.experiments.benchmarks import map_building
from tutorial_lib.topology.mapping.edge_rules import MapSettings

ROAD = street((0, 0), (8, 0))
BESIDE = street((0.5, 0), (8.5, 0), aside=0.3)
NO_REUSE = MapSettings(p_reuse=1.0, sequence=0, candidates=2)


@pytest.fixture(autouse=True)
def made_up(monkeypatch):
    agent = SimpleNamespace(reachability=StreetsAlike())
    monkeypatch.setattr(map_building.agents, "meng", lambda: agent)


def test_neither_driven_edges_nor_those_of_replaced_anchors_count():
    # The second time all anchors are replaced, and from each to the next is driven.
    twice = [anchors_at(ROAD), anchors_at(ROAD, 100.0)]
    assert np.isnan(map_building.recall(twice, MapSettings()))
    assert map_building.recall(twice, NO_REUSE) > 0


def test_an_index_that_searches_from_similar_vertices_finds_all_beside_it():
    both = [anchors_at(ROAD), anchors_at(BESIDE, 100.0)]
    assert map_building.recall(both, NO_REUSE) == 1.0


def test_what_is_not_found_is_missed_once(monkeypatch):
    """A seed that is left out, where the search has no other way to it."""
    seeds = map_building.Insertion._seeds

    def none_of_the_second(insertion, worth, back):
        first, second = seeds(insertion, worth, back)
        hidden = insertion.count > 0 and insertion.candidates < worth.shape[1]
        return (first & False, second & False) if hidden else (first, second)

    monkeypatch.setattr(map_building.Insertion, "_seeds", none_of_the_second)
    both = [anchors_at(ROAD), anchors_at(BESIDE, 100.0)]
    assert map_building.recall(both, NO_REUSE) == 0.0
