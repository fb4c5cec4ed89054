"""Scores to compare F_S with: of another model, by colour, and by chance."""

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.exploration.bearings import DIRECTIONS
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import ExplorationModel
from tutorial_lib.observation import Observation
from tutorial_lib.world.sensors import PanoramicCamera

_LEVELS = 4  # of each colour
_BINS = _LEVELS**3


class OtherScores:
    """An `ExplorationModel` that is another one, but for its scores."""

    def __init__(self, model: ExplorationModel) -> None:
        """Take all but the scores from `model`."""
        self._model = model
        self._width = 0

    def embed(self, observations: Observation) -> NDArray[np.float32]:
        """Features (N, D) of the other model, with what these scores need behind them."""
        features = self._model.embed(observations)
        self._width = features.shape[1]
        return np.concatenate([features, self._described(observations)], axis=1)

    def explorable(self, features: NDArray[np.float32]) -> Array:
        """F_G of the other model, (N, 12)."""
        return self._model.explorable(features[:, : self._width])

    def same_node(self, sources: NDArray[np.float32], goals: NDArray[np.float32]) -> Array:
        """F_L of the other model, (P,)."""
        return self._model.same_node(sources[:, : self._width], goals[:, : self._width])

    def relative(self, sources: NDArray[np.float32], goals: NDArray[np.float32]) -> Array:
        """F_R of the other model, (P, 2)."""
        return self._model.relative(sources[:, : self._width], goals[:, : self._width])

    def ranges(self, observations: Observation) -> Array:
        """Ranges of the other model, (N, W)."""
        return self._model.ranges(observations)

    def _described(self, observations: Observation) -> NDArray[np.float32]:
        """(N, E) what these scores need of a panorama."""
        return np.zeros((len(observations), 0), np.float32)


class RandomScores(OtherScores):
    """Scores that are drawn."""

    def __init__(self, model: ExplorationModel, rng: np.random.Generator) -> None:
        """Take all but the scores from `model`; `rng` draws these."""
        super().__init__(model)
        self._rng = rng

    def scores(self, sources: NDArray[np.float32], goals: NDArray[np.float32]) -> Array:
        """(P, 12) uniform in [0, 1)."""
        return self._rng.random((len(sources), DIRECTIONS))


class ScoresOf(OtherScores):
    """The scores of one more model, such as one that does not see the goal."""

    def __init__(self, model: ExplorationModel, other: ExplorationModel) -> None:
        """Take all but the scores from `model`, and these from `other`."""
        super().__init__(model)
        self._other = other

    def scores(self, sources: NDArray[np.float32], goals: NDArray[np.float32]) -> Array:
        """F_S of the other model, (P, 12)."""
        return self._other.scores(sources[:, self._width :], goals[:, self._width :])

    def _described(self, observations: Observation) -> NDArray[np.float32]:
        """What the other model makes of the panorama."""
        return self._other.embed(observations)


class HistogramScores(OtherScores):
    """Scores by colour: a direction is as good as its patch resembles some patch of the goal."""

    def scores(self, sources: NDArray[np.float32], goals: NDArray[np.float32]) -> Array:
        """(P, 12) the largest intersection of histograms, in [0, 1]."""
        mine = sources[:, self._width :].reshape(len(sources), DIRECTIONS, 1, _BINS)
        theirs = goals[:, self._width :].reshape(len(goals), 1, DIRECTIONS, _BINS)
        return np.minimum(mine, theirs).sum(axis=-1).max(axis=-1).astype(float)

    def _described(self, observations: Observation) -> NDArray[np.float32]:
        """A histogram of colours of each patch, (N, 12 * 64)."""
        patches = PanoramicCamera().split(observations.image)
        level = (patches // (256 // _LEVELS)).astype(np.intp)
        bins = (level[..., 0] * _LEVELS + level[..., 1]) * _LEVELS + level[..., 2]
        count = len(patches) * DIRECTIONS
        bins = bins.reshape(count, int(np.prod(patches.shape[2:4])))
        found = np.zeros((count, _BINS), np.float32)
        np.add.at(found, (np.arange(count)[:, None], bins), 1.0 / bins.shape[1])
        return found.reshape(len(patches), DIRECTIONS * _BINS)
