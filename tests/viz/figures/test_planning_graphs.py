import numpy as np
import pytest

from tutorial_lib.errors import InputError
from tutorial_lib.viz.figures import planning_graphs


def test_the_numbers_of_an_edge_and_of_the_one_back_stand_apart():
    there = planning_graphs._beside((0.2, 0.3), (0.8, 0.5), True)
    back = planning_graphs._beside((0.8, 0.5), (0.2, 0.3), True)
    assert np.linalg.norm(np.subtract(there, back)) > 0.1
    assert np.add(there, back) / 2 == pytest.approx([0.5, 0.4])
    assert planning_graphs._beside((0.2, 0.3), (0.8, 0.5), False) == pytest.approx((0.5, 0.4))


@pytest.mark.parametrize(("graph", "path"), [({"A": {"Z": 0.5}}, ()), ({"A": {}}, ("A", "Z"))])
def test_a_vertex_without_a_place_is_refused(graph, path):
    with pytest.raises(InputError, match="graph, path: no place for Z"):
        planning_graphs.graph_picture(graph, path)
