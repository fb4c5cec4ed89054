"""Where a robot may be after it was lost."""

from types import SimpleNamespace

import networkx as nx
import numpy as np

from tutorial_lib.agents.navigator import Whereabouts
from tutorial_lib.interfaces import HERE

PLACE = np.array([3.0, -1.0, 0.7])


def chain(length=12):
    """Vertices 0 -> 1 -> 2 and so on."""
    graph = nx.path_graph(length, create_using=nx.DiGraph)
    return SimpleNamespace(graph=graph, alive=np.arange(length))


def allowed(where, robot, odometry):
    """The vertices at which a plan may begin."""
    forbidden = where.excluded(robot, odometry)
    assert all(source == HERE for source, _ in forbidden)
    return sorted(set(range(12)) - {vertex for _, vertex in forbidden})


def test_a_plan_begins_around_the_vertex_visited_last_either_way():
    where = Whereabouts(2, chain())
    assert allowed(where, 0, PLACE) == list(range(12))
    where.see(0, 6, PLACE)
    assert allowed(where, 0, PLACE) == list(range(2, 11))
    assert allowed(where, 1, PLACE) == list(range(12))
    where.see(0, 0, PLACE)
    assert allowed(where, 0, PLACE) == list(range(5))


def test_a_robot_that_has_moved_on_may_be_anywhere_and_one_that_turned_may_not():
    where = Whereabouts(1, chain())
    where.see(0, 6, PLACE)
    assert len(allowed(where, 0, PLACE + np.array([0.0, 4.9, 3.0]))) == 9
    assert len(allowed(where, 0, PLACE + np.array([0.0, 5.1, 0.0]))) == 12


def test_where_it_was_is_kept_though_odometry_is_one_array_that_changes():
    where, odometry = Whereabouts(1, chain()), PLACE.copy()
    where.see(0, 6, odometry)
    odometry += 100.0
    assert len(allowed(where, 0, PLACE)) == 9
