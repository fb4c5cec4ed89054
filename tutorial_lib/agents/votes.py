"""Where a robot that looks all around is on its map: all that it sees has to agree.

One picture looks like many places. Those ahead, aside and behind of one place look like the same
other place only seldom.
"""

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.observation import Observation
from tutorial_lib.se2 import Array, wrap
from tutorial_lib.topology.mapping.topomap import TopoMap

_CANDIDATES = 64  # vertices that RE is queried about in each view
_LEAST = 0.5  # RE from which a vertex votes
_NEAR, _ALONG = 1.5, float(np.deg2rad(45.0))  # metres and rad between votes that agree
_SHARE = 0.7  # of the best support that a vertex must have


def agreeing(topomap: TopoMap, views: Observation, headings: Array) -> list[set[int]]:
    """The vertices that can be reached in each view, as far as the other views agree.

    A vertex that RE says can be reached in one view votes for a pose of the robot, by the odometry
    of the trajectory that it is from. A vote is supported by the best one of each view that is near
    it and along it.

    Args:
        topomap: the map; all its trajectories were recorded with one odometry.
        views: (K,) of one robot.
        headings: (K,) of the views, in the robot's frame.

    Returns:
        For each view the vertices with at least `_SHARE` of the greatest support.
    """
    if not len(topomap):
        return [set() for _ in headings]
    near = topomap.nearby(views, _CANDIDATES)
    view = np.repeat(np.arange(len(near)), near.shape[1])
    vertices = near.ravel()
    reach = topomap.vertices.into(views, view, vertices)
    sure = reach > _LEAST
    if not sure.any():
        return [set() for _ in headings]
    view, vertices, reach = view[sure], vertices[sure], reach[sure]
    poses = topomap.vertices.observations[vertices].odometry
    support = supports(view, poses[:, :2], poses[:, 2] - headings[view], reach)
    kept = support >= _SHARE * support.max(initial=0.0)
    return [set(vertices[kept & (view == number)].tolist()) for number in range(len(near))]


def supports(view: NDArray[np.intp], places: Array, headings: Array, weights: Array) -> Array:
    """The support (V,) of votes: of each view the weight of the best vote that agrees.

    Args:
        view: (V,) of each vote.
        places: (V, 2) metres.
        headings: (V,) rad, of the robot there.
        weights: (V,).

    >>> places, headings = np.array([[0.0, 0.0], [0.5, 0.0], [9.0, 0.0]]), np.zeros(3)
    >>> supports(np.array([0, 1, 1]), places, headings, np.array([0.9, 0.8, 1.0])).tolist()
    [1.7000000000000002, 1.7000000000000002, 1.0]
    """
    gaps = np.linalg.norm(places[:, None] - places, axis=2)
    agree = (gaps < _NEAR) & (np.abs(wrap(headings[:, None] - headings)) < _ALONG)
    support = np.zeros(len(view))
    for number in np.unique(view):
        mine = view == number
        support += (agree[:, mine] * weights[mine]).max(axis=1)
    return support
