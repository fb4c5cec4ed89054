"""Actuation noise and odometry noise."""

from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.geometry import Array
from tutorial_lib.validation import alike, floats, instance, number, whole

Rng = np.random.Generator
_STEPS_DRAWN = 100  # at a time, for each robot of a fleet
MOST_ROBOTS = 1_000_000
"""In one simulation; more are a mistake, and would fill the memory."""


class OdometryNoise(Protocol):
    """A model of odometry errors.

    Attributes:
        needs_rng: whether it draws from the simulation's `rng`.
    """

    needs_rng: bool

    def measure(self, motions: Array, rng: Rng | None) -> Array:
        """Measured motions (N, 3), given the true ones."""


def scale_controls(actions: Array, sigma: float, rng: Rng | None) -> Array:
    """Actuation noise of Meng 2020 (IV-B): each control times a factor drawn from N(1, sigma).

    Args:
        actions: (N, 2).
        sigma: 0.33 in the paper; 0 for none.
        rng: source of randomness; not needed where `sigma` is 0.

    Returns:
        (N, 2).
    """
    actions, sigma = floats("actions", actions, ("N", 2)), number("sigma", sigma, least=0)
    if not sigma:
        return actions
    return actions * instance("rng", rng, Rng).normal(1.0, sigma, np.shape(actions))


@dataclass(frozen=True)
class WheelOdometry:
    """Odometry of a car: relative errors of distance and turn, and a drift of the heading.

    The errors of one motion (a step of 0.1 s) do not depend on those of another. That of a length
    and that of a turn are proportional to it, as a_3 and a_1 in the odometry model of Thrun,
    Burgard and Fox (Probabilistic Robotics, 2005, 5.4); the variance of the heading grows with the
    distance (Chong and Kleeman, Accurate odometry and error modelling, ICRA 1997).

    The level: after L metres straight ahead at 0.5 m/s, standard deviations of 11 mm * sqrt(L)
    along the path, 20 mrad * sqrt(L) of heading and 12 mm * sqrt(L^3) across: after 10 m these are
    0.04 m, 3.6 degrees and 0.37 m. In 0.25 m that is 6 mm, where the robot of Active Neural SLAM
    has 2.5 mm and a bias of 1 to 4 mm (see `ODOMETRY`): cautious, but of the same order.

    Attributes:
        distance: standard deviation of the relative error of a motion's length.
        turn: the same for its angle.
        drift: rad of heading for a motion of one metre, standard deviation.
    """

    needs_rng: ClassVar[bool] = True
    distance: float = 0.05
    turn: float = 0.05
    drift: float = 0.02

    def __post_init__(self) -> None:
        for name in ("distance", "turn", "drift"):
            number(name, getattr(self, name), least=0)

    def measure(self, motions: Array, rng: Rng | None) -> Array:
        """What the wheels measure for true motions (N, 3) in the robot's frame."""
        motions = floats("motions", motions, ("N", 3))
        return self.read(motions, instance("rng", rng, Rng).normal(size=motions.shape))

    def read(self, motions: Array, noise: Array) -> Array:
        """The same with `noise` (N, 3) from the standard normal distribution, unchecked."""
        length = np.linalg.norm(motions[:, :2], axis=1)
        read = motions.copy()
        read[:, :2] *= 1 + self.distance * noise[:, :1]
        read[:, 2] *= 1 + self.turn * noise[:, 1]
        read[:, 2] += self.drift * np.sqrt(length) * noise[:, 2]
        return read


class DriftingOdometry:
    """`WheelOdometry` of a fleet whose robots drift each for itself.

    Each robot draws from a random stream of its own, so that its odometry follows from the seed,
    its number and its motions, whatever the other robots do and however many there are. The
    streams go on from step to step: one object is for one simulation.
    """

    needs_rng = False

    def __init__(self, *seed: int, wheels: WheelOdometry | None = None) -> None:
        """Set the seed, whole numbers from 0 on, and the level; the usual one unless given."""
        for one in seed:
            whole("seed", one, least=0)
        self._wheels = (
            WheelOdometry() if wheels is None else instance("wheels", wheels, WheelOdometry)
        )
        self._seed, self._streams = np.random.SeedSequence(seed), list[Rng]()
        self._noise, self._row = np.empty((0, 0, 3)), 0

    def measure(self, motions: Array, rng: Rng | None) -> Array:
        """What the wheels measure; nothing is drawn from `rng`."""
        del rng
        if self._row == len(self._noise):
            self._draw(len(motions))
        self._row += 1
        return self._wheels.read(motions, self._noise[self._row - 1])

    def _draw(self, count: int) -> None:
        """Draw the noise (S, N, 3) of the next S steps."""
        if not self._streams:
            self._streams = [np.random.default_rng(one) for one in self._seed.spawn(count)]
        drawn = [stream.normal(size=(_STEPS_DRAWN, 3)) for stream in self._streams]
        self._noise, self._row = np.stack(drawn, axis=1), 0


class NoNoise:
    """Odometry that is exact."""

    needs_rng = False

    def measure(self, motions: Array, rng: Rng | None) -> Array:
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

    def __post_init__(self) -> None:
        alike(
            weights=floats("weights", self.weights, ("M",), least=0),
            means=floats("means", self.means, ("M", 3)),
            deviations=floats("deviations", self.deviations, ("M", 3), least=0),
        )

    def motions(self, luck: Array, noise: Array) -> Array:
        """Motions (N, 3) from `luck` (N,) in [0, 1), uniform, and `noise` (N, 3), normal."""
        mode = np.searchsorted(np.cumsum(self.weights)[:-1], luck, side="right")
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


def _stacked(*tables: dict[int, Mixture]) -> tuple[Array, Array, Array]:
    """Mixtures of T tables and A actions as arrays, so that many are drawn from at once.

    Returns:
        From which luck on each next Gaussian is meant (T, A, M - 1), inf where there is none; and
        means and deviations (T, A, M, 3).
    """
    most = max(len(mixture.weights) for table in tables for mixture in table.values())
    shape = (len(tables), len(tables[0]), most)
    borders, means = np.full(shape, np.inf), np.zeros((*shape, 3))
    deviations = np.zeros_like(means)
    for t, table in enumerate(tables):
        for action, mixture in table.items():
            count = len(mixture.weights)
            borders[t, action, : count - 1] = np.cumsum(mixture.weights)[:-1]
            means[t, action, :count] = mixture.means
            deviations[t, action, :count] = mixture.deviations
    return borders[..., :-1], means, deviations


_BORDERS, _MEANS, _DEVIATIONS = _stacked(ACTUATION, ODOMETRY)


class DiscreteNoise:
    """`ACTUATION` and `ODOMETRY` of N robots, each with a random stream of its own.

    As much is drawn for each action, also for `STOP`: the noise of a robot follows from the
    generator, its number and its own actions, whatever the other robots do and however many there
    are.
    """

    def __init__(self, robots: int, rng: Rng) -> None:
        """Spawn a stream of `rng` for each of N robots."""
        robots = whole("robots", robots, least=0, most=MOST_ROBOTS)
        instance("rng", rng, Rng)
        self._streams = rng.spawn(robots)
        self._luck, self._noise = np.empty((0, robots, 2)), np.empty((0, robots, 2, 3))
        self._row = 0

    def draw(self, actions: NDArray[np.intp]) -> tuple[Array, Array]:
        """Motions (N, 3) of discrete actions (N,), and errors (N, 3) of the odometry's reading."""
        if self._row == len(self._luck):
            self._luck = np.stack([s.random((_STEPS_DRAWN, 2)) for s in self._streams], axis=1)
            normal = [s.normal(size=(_STEPS_DRAWN, 2, 3)) for s in self._streams]
            self._noise, self._row = np.stack(normal, axis=1), 0
        luck, noise = self._luck[self._row], self._noise[self._row]
        self._row += 1
        both, actions = np.arange(2), actions[:, None]
        mode = (luck[..., None] >= _BORDERS[both, actions]).sum(axis=-1)
        drawn = _MEANS[both, actions, mode] + _DEVIATIONS[both, actions, mode] * noise
        return drawn[:, 0], drawn[:, 1]
