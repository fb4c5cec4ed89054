"""Small motion models, motions, and beliefs at random, for the checks of notebook 07."""

import math

import numpy as np

from tutorial_lib.geometry import Array
from tutorial_lib.topology.motion_model import TURN


def random_model(vertices: int, seed: int) -> tuple[Array, Array]:
    """Lengths (V + 1,) and `onward` (V + 1, V + 1) of a map with edges at random."""
    rng = np.random.default_rng([seed, 1])
    onward = rng.random((vertices + 1, vertices + 1)) * (rng.random((vertices + 1, 1)) + 0.2)
    onward *= rng.random(onward.shape) < 0.6
    onward += 0.01
    return rng.uniform(0.5, 3.0, vertices + 1), onward / onward.sum(axis=1, keepdims=True)


def random_beliefs(robots: int, vertices: int, seed: int) -> Array:
    """Beliefs (N, V + 1) at random."""
    belief = np.random.default_rng([seed, 2]).random((robots, vertices + 1)) ** 3
    return belief / belief.sum(axis=1, keepdims=True)


def row_of(vertices: int, length: float = 1.0) -> tuple[Array, Array]:
    """The motion model of vertices in a row, each joined to the next, and off the map."""
    onward = np.zeros((vertices + 1, vertices + 1))
    for v in range(vertices - 1):
        onward[v, v + 1] = 0.95
    onward[:vertices, vertices] = 1.0 - onward[:vertices].sum(axis=1)
    onward[vertices, :vertices] = 1.0 / vertices
    return np.full(vertices + 1, length), onward


def distance(first: Array, second: Array) -> float:
    """How far a robot has moved from one pose (3,) to another, metres; turning counts as well."""
    turn = (second[2] - first[2] + math.pi) % (2.0 * math.pi) - math.pi
    return math.hypot(second[0] - first[0], second[1] - first[1]) + TURN * abs(turn)
