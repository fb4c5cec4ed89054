"""Made-up worlds in which maps are made: RE is read from a table, or follows from poses."""

from itertools import pairwise

import numpy as np

from tutorial_lib.interfaces import Observation
from tutorial_lib.topology.mapping.anchors import Anchors
from tutorial_lib.topology.mapping.edge_rules import MapSettings
from tutorial_lib.topology.mapping.topomap import TopoMap


def sensed(odometry):
    """Observations that differ in their odometry (N, 3), which is what the image shows, too."""
    odometry = np.asarray(odometry, dtype=float).reshape(-1, 3)
    count = len(odometry)
    nothing = np.zeros(count)
    image = odometry[:, None, None]
    return Observation(image, None, np.ones((count, 4)), odometry, nothing, nothing)


def places_in(observations):
    """Poses (N, 3) that the images show."""
    return observations.image[:, 0, 0]


def numbered(numbers):
    """Observations whose odometry and image hold their index."""
    numbers = np.asarray(numbers, dtype=float)
    return sensed(np.column_stack([numbers, 0 * numbers, 0 * numbers]))


class Table:
    """RE from a table: from the index in the image to that in the context (2k+1,)."""

    def __init__(self, table):
        self.table, self.queried = np.asarray(table, dtype=float), []

    def prepare(self, contexts):
        contexts = np.asarray(contexts)
        return contexts[:, contexts.shape[1] // 2]

    def probability(self, observations, prepared):
        sources = places_in(observations)[:, 0].astype(int)
        self.queried += zip(sources.tolist(), prepared.tolist(), strict=True)
        return self.table[sources, prepared]


def anchors(numbers):
    """Anchors for a `Table`."""
    numbers = np.asarray(numbers)
    return Anchors(numbered(numbers), numbers[:, None], numbers * 1.0)


def table_map(table, count, paths=None, **settings):
    """A map of vertices 0 to `count` without an edge, on one path unless others are given."""
    topomap = TopoMap(Table(table), MapSettings(**settings))
    paths = [list(range(count))] if paths is None else paths
    owner = np.repeat(np.arange(len(paths)), [len(path) for path in paths])
    place = np.concatenate([np.arange(len(path)) for path in paths])
    numbers = np.concatenate(paths)
    assert numbers.tolist() == list(range(count))
    topomap.make_vertices(numbered(numbers), numbers[:, None], numbers * 1.0, owner, place)
    topomap.paths = [list(path) for path in paths]
    return topomap


class Streets:
    """RE among poses: sure of what lies up to 1.6 m ahead, to much the same side.

    The more surely, the nearer. Images and contexts (2k+1, 3) hold poses; `hidden` are poses that
    nobody can reach as targets.
    """

    def __init__(self, reach=1.6):
        self.reach, self.queries, self.hidden = reach, 0, []

    def prepare(self, contexts):
        contexts = np.asarray(contexts, dtype=float)
        return contexts[:, contexts.shape[1] // 2]

    def probability(self, observations, prepared):
        self.queries += len(prepared)
        here = places_in(observations)
        gap = prepared[:, :2] - here[:, :2]
        ahead = gap[:, 0] * np.cos(here[:, 2]) + gap[:, 1] * np.sin(here[:, 2])
        turned = np.abs(np.angle(np.exp(1j * (prepared[:, 2] - here[:, 2]))))
        far = np.hypot(*gap.T)
        good = (far <= self.reach) & (ahead >= -0.3) & (turned < 0.6)
        for pose in self.hidden:
            good &= ~np.isclose(prepared, pose).all(axis=1)
        return np.where(good, 1.0 - 0.003 * far - 0.001 * turned, 0.01)


class StreetsAlike(Streets):
    """The same, with embeddings: the nearer two poses are, the more alike."""

    size = 12.0

    def embed(self, observations):
        return self._directions(places_in(observations))[:, None]

    def embed_targets(self, prepared):
        return self._directions(prepared)[:, None, None]

    def _directions(self, poses):
        angles = np.column_stack([poses[:, :2] / self.size, poses[:, 2]])
        parts = [np.cos(angles), np.sin(angles)]
        return np.concatenate(parts, axis=1).astype(np.float32) / np.sqrt(3.0)


def street(*points, step=1.0, aside=0.0):
    """Poses (A, 3) every `step` metres along a broken line, at its corners too."""
    points = np.asarray(points, dtype=float)
    poses = []
    for start, end in pairwise(points):
        along = end - start
        length = np.hypot(*along)
        heading = np.arctan2(along[1], along[0])
        for far in np.arange(0.0, length, step):
            poses.append([*(start + along * far / length), heading])
    poses.append([*points[-1], heading])
    poses = np.array(poses)
    poses[:, 0] -= aside * np.sin(poses[:, 2])
    poses[:, 1] += aside * np.cos(poses[:, 2])
    return poses


def anchors_at(poses, begin=0.0):
    """Anchors for `Streets`, a second after each other."""
    poses = np.asarray(poses, dtype=float)
    return Anchors(sensed(poses), poses[:, None], begin + np.arange(len(poses)))


def edges_of(topomap):
    """Probability, and how often it was driven, of every edge."""
    edges = topomap.graph.edges(data=True)
    return {(a, b): (edge["probability"], edge["driven"]) for a, b, edge in edges}
