"""Small graphs to plan on, for the checks of notebook 06."""

from typing import Any

import numpy as np

Vertex = Any
Graph = dict[Vertex, dict[Vertex, float]]
"""For each vertex, those that an edge leads to, with RE."""

HERE, GOAL = -1, -2
"""Vertices that are not on the map: the current observation, and the goal image."""

BY_HAND: Graph = {
    "here": {"A": 0.70, "B": 0.90, "D": 0.95, "E": 0.72},
    "A": {"goal": 0.80, "B": 0.99},
    "B": {"C": 0.90, "A": 0.75, "D": 0.85},
    "C": {"goal": 0.90},
    "D": {"C": 0.80, "B": 0.91},
    "E": {"goal": 0.995},
    "goal": {},
}
"""A small graph, to plan on with a pencil."""
SMALL_MAP: Graph = {0: {1: 0.99, 3: 0.995}, 1: {2: 0.99}, 2: {3: 0.992}, 3: {0: 0.993}, 4: {}}


def random_graph(count: int, degree: int, seed: int) -> Graph:
    """A graph of `count` numbered vertices, each with an edge to `degree` others."""
    rng = np.random.default_rng(seed)
    graph: Graph = {vertex: {} for vertex in range(count)}
    for vertex in graph:
        others = rng.choice(count - 1, degree, replace=False)
        for other in (int(o) + (o >= vertex) for o in others):
            graph[vertex][int(other)] = round(float(rng.uniform(0.4, 0.999)), 3)
    return graph
