"""Likelihoods of views, by predicted overlaps."""

import numpy as np

from tests.agents.line import LinePredictor, LineReachability, at_places, line_map
from tutorial_lib.topology.view_sensor import ViewSensor


def test_the_likelihood_of_a_view_is_its_overlap_with_each_vertex():
    topomap = line_map(range(6), LineReachability())
    sensor = ViewSensor(topomap, LinePredictor(), np.arange(6.0))
    found = sensor(at_places(0.0, 2.5))
    assert np.allclose(found[0], [1, 2 / 3, 1 / 3, 0, 0, 0])
    assert found[1].argmax() in (2, 3)
    assert found.shape == (2, 6)


def test_removed_vertices_have_no_column():
    topomap = line_map(range(6), LineReachability())
    topomap.remove([1, 3])
    found = ViewSensor(topomap, LinePredictor(), np.arange(6.0))(at_places(2.0))
    assert np.allclose(found, [[1 / 3, 1, 1 / 3, 0]])
