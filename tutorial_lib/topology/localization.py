"""Where on the map is the robot? Argmax, sequence matching, and a discrete Bayes filter.

A *belief* of a robot is a row of V + 1 probabilities that sum to one: a column for each of the V
vertices, and behind them one for *off the map*. The words are those of Thrun, Burgard and Fox
(Probabilistic Robotics, 2005, 2.4 and 4.1): `predict` turns a belief into the prior by how far the
robot has moved, `update` multiplies the prior by the likelihood of what it sees, and `normalize`
makes the product sum to one again.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import Observation, Robots
from tutorial_lib.se2 import Array, relative
from tutorial_lib.topology.motion_model import MotionModel, length_of
from tutorial_lib.validation import alike, floats, instance, integers, number, whole, with_methods

Belief = Array
"""(N, V + 1) probabilities; the last column is that of being off the map."""
Sensor = Callable[[Observation], Array]
"""Likelihoods (N, V), 0 to 1, of what N robots see, were they at each vertex."""
_MOST = 1_000_000  # robots
OFF_MAP = -1
"""The column of being off the map, and the vertex of a robot that is there."""


def normalize(weights: ArrayLike) -> Belief:
    """Rows that sum to one; a robot for which nothing is possible is off the map.

    Args:
        weights: (N, V + 1), not negative.

    >>> normalize([[1.0, 3.0, 0.0], [0.0, 0.0, 0.0]]).tolist()
    [[0.25, 0.75, 0.0], [0.0, 0.0, 1.0]]
    """
    weights = floats("weights", weights, ("N", "V+1"), least=0.0).copy()
    if not weights.shape[1]:
        raise InputError(f"weights: shape {weights.shape}; give (N, V + 1), a column at least")
    nowhere = weights.sum(axis=1) <= 0.0
    weights[nowhere, OFF_MAP] = 1.0
    return weights / weights.sum(axis=1, keepdims=True)


def predict(belief: Belief, motion: ArrayLike, model: MotionModel) -> Belief:
    """The prior: where a robot may be after it has moved.

    The further it went, the more of the belief leaves each vertex, and moves on along its edges.

    Args:
        belief: (N, V + 1).
        motion: (N,) how far each robot has moved, see `motion_model.moved`.
        model: lengths of the edges, and where they lead.

    >>> model = MotionModel(np.array([1.0, 1.0, 1.0]), np.eye(3)[[1, 2, 0]])
    >>> predict(np.array([[1.0, 0.0, 0.0]]), [0.0], model).tolist()
    [[1.0, 0.0, 0.0]]
    >>> predict(np.array([[1.0, 0.0, 0.0]]), [0.5], model).round(2).tolist()
    [[0.61, 0.39, 0.0]]
    """
    count = len(instance("model", model, MotionModel).lengths)
    belief = floats("belief", belief, ("N", count), least=0.0)
    motion = floats("motion", motion, ("N",), least=0.0)
    alike(belief=belief, motion=motion)
    leave = 1.0 - np.exp(-motion[:, None] / model.lengths)
    return belief * (1.0 - leave) + (belief * leave) @ model.onward


def update(prior: Belief, likelihood: ArrayLike) -> Belief:
    """The belief after a look (Bayes' rule).

    Args:
        prior: (N, V + 1).
        likelihood: (N, V + 1) of what is seen, were the robot there.

    >>> update(np.array([[0.5, 0.5, 0.0]]), [[0.9, 0.1, 0.2]]).round(2).tolist()
    [[0.9, 0.1, 0.0]]
    """
    prior = floats("prior", prior, ("N", "V+1"), least=0.0)
    likelihood = floats("likelihood", likelihood, ("N", "V+1"), least=0.0)
    alike(prior=prior, likelihood=likelihood)
    alike(prior=prior.T, likelihood=likelihood.T)
    return normalize(prior * likelihood)


def argmax(likelihood: ArrayLike) -> Belief:
    """(N, V + 1) all belief in the most likely vertex: localization by a single view.

    Args:
        likelihood: (N, V).

    >>> argmax([[0.2, 0.7, 0.1]]).tolist()
    [[0.0, 1.0, 0.0, 0.0]]
    """
    likelihood = floats("likelihood", likelihood, ("N", "V"), least=0.0)
    if not likelihood.shape[1]:
        raise InputError(f"likelihood: shape {likelihood.shape}; give (N, V), a vertex at least")
    belief = np.zeros((len(likelihood), likelihood.shape[1] + 1))
    belief[np.arange(len(belief)), likelihood.argmax(axis=1)] = 1.0
    return belief


def match_sequence(likelihoods: ArrayLike, before: NDArray[np.intp]) -> Array:
    """Likelihoods (V,) of a sequence of views that ends at each vertex (Meng 2020, III-G).

    From one view to the next the robot has stayed at its vertex or has come to the one after it;
    of all such alignments the best one counts.

    Args:
        likelihoods: (T, V) of the views, the latest last.
        before: (V,) the vertex before each on its trajectory, -1 for none.

    Returns:
        (V,) the mean likelihood along the best alignment (its geometric mean, since likelihoods
        multiply).

    >>> twins = [[0.9, 0.0, 0.1, 0.0], [0.1, 0.8, 0.1, 0.8]]
    >>> match_sequence(twins, np.array([-1, 0, -1, 2])).round(2).tolist()
    [0.3, 0.85, 0.1, 0.28]
    """
    likelihoods = floats("likelihoods", likelihoods, ("T", "V"), least=0.0, empty=False)
    most = likelihoods.shape[1] - 1
    before = integers("before", before, ("V",), least=-1, most=most)
    alike(likelihoods=likelihoods.T, before=before)
    with np.errstate(divide="ignore"):
        logs = np.log(likelihoods)
    total = logs[0]
    for look in logs[1:]:
        come = np.where(before >= 0, total[before], -np.inf)
        total = look + np.maximum(total, come)
    return np.exp(total / len(logs))


@dataclass(frozen=True)
class FilterSettings:
    """Settings of the Bayes filter.

    Attributes:
        stride: metres (see `motion_model.moved`) from one prediction to the next.
        interval: steps after which a robot looks again, though it has moved less.
        unknown: likelihood of any view off the map.
        least: likelihood of any view at any vertex; a picture may always deceive.
        sharpness: power of the likelihoods. Views a stride apart repeat part of their evidence:
            the smaller it is, the less they count.
        hysteresis: share of the new vertex's belief below which that of the old one must fall
            before the robot is localized at the new one.
    """

    stride: float = 0.3
    interval: int = 10
    unknown: float = 0.4
    least: float = 0.02
    sharpness: float = 3.0
    hysteresis: float = 0.5

    def __post_init__(self) -> None:
        for field in fields(self):
            value = number(f"filter: {field.name}", getattr(self, field.name))
            if field.name == "interval":
                whole(f"filter: {field.name}", self.interval)
            unit = field.name in ("unknown", "least", "hysteresis")
            if not 0.0 < value < (1.0 if unit else np.inf):
                wanted = "a number between 0 and 1" if unit else "a positive number"
                raise InputError(f"filter: {field.name} = {value}; give {wanted}")


class BayesFilter:
    """Beliefs of N robots over the vertices of a map.

    A robot that stands still sees the same again: its latest view replaces the one before, and
    does not count a second time. So nothing flickers, however long it stands.

    Attributes:
        belief: (N, V + 1); none has looked yet where a row is uniform.
        vertex: (N,) column at which each robot is localized, `OFF_MAP` for none.
    """

    def __init__(
        self,
        robots: int,
        model: MotionModel,
        sensor: Sensor,
        settings: FilterSettings | None = None,
    ) -> None:
        """Robots that may be anywhere, and have not moved."""
        whole("robots", robots, least=0, most=_MOST)
        self.model, self.sensor = instance("model", model, MotionModel), sensor
        with_methods("sensor", sensor, "__call__")
        settings = FilterSettings() if settings is None else settings
        self.settings = instance("settings", settings, FilterSettings)
        count = len(model.lengths)
        self.belief = np.full((robots, count), 1.0 / count)
        self.vertex = np.full(robots, OFF_MAP)
        self._prior = self.belief.copy()
        self._pose = np.full((robots, 3), np.nan)  # odometry at the last prediction
        self._waited = np.full(robots, np.inf)  # steps since the last look

    def observe(self, observations: Observation, robots: Robots) -> NDArray[np.bool_]:
        """Predict and update the beliefs of robots (M,) that moved far enough, or waited.

        Returns:
            (M,) for which robots the belief is new.
        """
        odometry = floats(
            "observations", instance("observations", observations, Observation).odometry, ("M", 3)
        )
        robots = integers("robots", robots, ("M",), least=0, most=len(self.vertex) - 1)
        alike(observations=odometry, robots=robots)
        fresh = np.isnan(self._pose[robots, 0])
        self._pose[robots[fresh]] = odometry[fresh]
        motion = length_of(relative(self._pose[robots], odometry))
        far = motion >= self.settings.stride
        self._prior[robots[far]] = predict(self.belief[robots[far]], motion[far], self.model)
        self._pose[robots[far]] = odometry[far]
        self._waited[robots] += 1
        due = far | (self._waited[robots] >= self.settings.interval)
        if due.any():
            self._look(observations[due], robots[due])
        return due

    def _look(self, observations: Observation, robots: Robots) -> None:
        settings = self.settings
        seen = np.maximum(self.sensor(observations), settings.least)
        unknown = np.full((len(robots), 1), settings.unknown)
        likelihood = np.hstack([seen, unknown]) ** settings.sharpness
        self.belief[robots] = update(self._prior[robots], likelihood)
        self._waited[robots] = 0
        self.vertex[robots] = localized(
            self.belief[robots], self.vertex[robots], settings.hysteresis
        )


def localized(belief: Belief, before: NDArray[np.intp], hysteresis: float) -> NDArray[np.intp]:
    """(N,) columns of the most probable vertices, `OFF_MAP` where that is more probable.

    A robot stays at the vertex `before` (N,) until its probability falls below the share
    `hysteresis` of the best one's.

    >>> localized(np.array([[0.40, 0.45, 0.15], [0.2, 0.65, 0.15]]), np.array([0, 0]), 0.8).tolist()
    [0, 1]
    """
    belief = floats("belief", belief, ("N", "V+1"), least=0.0)
    before = integers("before", before, ("N",), least=OFF_MAP, most=belief.shape[1] - 1)
    hysteresis = number("hysteresis", hysteresis, least=0.0, most=1.0)
    alike(belief=belief, before=before)
    best = belief.argmax(axis=1)
    rows = np.arange(len(belief))
    stays = belief[rows, before] >= hysteresis * belief[rows, best]
    best = np.where(best == belief.shape[1] - 1, OFF_MAP, best)
    return np.where(stays, before, best)
