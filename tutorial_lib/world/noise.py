"""Actuation noise and odometry noise."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.geometry import Array

Rng = np.random.Generator


class OdometryNoise(Protocol):
    """A model of odometry errors."""

    def measure(self, motions: Array, actions: NDArray[np.intp] | None, rng: Rng) -> Array:
        """Measured motions (N, 3), given the true ones; `actions` (N,) if discrete, else None."""


def scale_controls(actions: Array, sigma: float, rng: Rng) -> Array:
    """Actuation noise of Meng 2020 (IV-B): each control times a factor drawn from N(1, sigma).

    Args:
        actions: (N, 2).
        sigma: 0.33 in the paper; 0 for none.
        rng: source of randomness.

    Returns:
        (N, 2).
    """
    return actions * rng.normal(1.0, sigma, np.shape(actions)) if sigma else actions


@dataclass(frozen=True)
class WheelOdometry:
    """Odometry of a car: relative errors of distance and turn, and a drift of the heading.

    Attributes:
        distance: standard deviation of the relative error of a motion's length.
        turn: the same for its angle.
        drift: rad of heading for a motion of one metre, standard deviation.
    """

    distance: float = 0.05
    turn: float = 0.05
    drift: float = 0.02

    def measure(self, motions: Array, actions: NDArray[np.intp] | None, rng: Rng) -> Array:
        """What the wheels measure for true motions (N, 3) in the robot's frame."""
        noise = rng.normal(size=motions.shape)
        length = np.linalg.norm(motions[:, :2], axis=1)
        read = motions.copy()
        read[:, :2] *= 1 + self.distance * noise[:, :1]
        read[:, 2] *= 1 + self.turn * noise[:, 1]
        read[:, 2] += self.drift * np.sqrt(length) * noise[:, 2]
        return read


class NoNoise:
    """Odometry that is exact."""

    def measure(self, motions: Array, actions: NDArray[np.intp] | None, rng: Rng) -> Array:
        """The true motions."""
        return motions


STOP, FORWARD, LEFT, RIGHT = range(4)
"""The discrete actions of NTS (section 5): forward about 0.25 m, turns of about 10 degrees."""

_DEG = np.pi / 180


@dataclass(frozen=True)
class Mixture:
    """A mixture of Gaussians over motions: weights (M,), means and deviations (M, 3)."""

    weights: tuple[float, ...]
    means: tuple[tuple[float, float, float], ...]
    deviations: tuple[tuple[float, float, float], ...]

    def sample(self, count: int, rng: Rng) -> Array:
        """`count` motions (count, 3): metres ahead, metres to the left, rad."""
        mode = rng.choice(len(self.weights), size=count, p=self.weights)
        noise = rng.normal(size=(count, 3))
        return np.take(self.means, mode, axis=0) + np.take(self.deviations, mode, axis=0) * noise


ACTUATION = {
    STOP: Mixture((1.0,), ((0, 0, 0),), ((0, 0, 0),)),
    FORWARD: Mixture(
        (0.5, 0.5),
        ((0.245, 0, 0.0125), (0.245, 0, 0.0047)),
        ((0.004, 0.002, 0.004), (0.004, 0.002, 0.004)),
    ),
    LEFT: Mixture(
        (0.5, 0.5),
        ((0, 0.02, 11.5 * _DEG), (0, 0.02, 10.9 * _DEG)),
        ((0.002, 0.002, 0.3 * _DEG), (0.002, 0.002, 0.3 * _DEG)),
    ),
    RIGHT: Mixture((1.0,), ((0, -0.02, -11.1 * _DEG),), ((0.002, 0.002, 0.5 * _DEG),)),
}
"""Motion of each discrete action, after the mixtures measured for Active Neural SLAM."""

ODOMETRY = {
    STOP: Mixture((1.0,), ((0, 0, 0),), ((0, 0, 0),)),
    FORWARD: Mixture(
        (0.84, 0.16),
        ((0.0010, 0, 0), (0.0038, 0, 0)),
        ((0.0025, 0.0025, 0.05 * _DEG), (0.0025, 0.0025, 0.05 * _DEG)),
    ),
    LEFT: Mixture((1.0,), ((0, 0.02, 0.20 * _DEG),), ((0.0025, 0.0025, 0.05 * _DEG),)),
    RIGHT: Mixture(
        (0.5, 0.5),
        ((0, -0.02, -0.04 * _DEG), (0, -0.02, 0.07 * _DEG)),
        ((0.0025, 0.0025, 0.05 * _DEG), (0.0025, 0.0025, 0.05 * _DEG)),
    ),
}
"""Error of the odometry's reading of each discrete action, from the same source."""


def sample_motions(table: dict[int, Mixture], actions: NDArray[np.intp], rng: Rng) -> Array:
    """Motions (N, 3) of discrete actions (N,), in the robots' frames."""
    motions = np.zeros((len(actions), 3))
    for action, mixture in table.items():
        chosen = np.flatnonzero(actions == action)
        motions[chosen] = mixture.sample(len(chosen), rng)
    return motions


class DiscreteOdometry:
    """Odometry of the differential drive under discrete actions."""

    def measure(self, motions: Array, actions: NDArray[np.intp] | None, rng: Rng) -> Array:
        """The true motions plus the error measured for each action."""
        if actions is None:
            return motions
        return motions + sample_motions(ODOMETRY, actions, rng)
