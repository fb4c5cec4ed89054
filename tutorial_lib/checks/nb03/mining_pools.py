"""Pools of pairs for the check of mining, in notebook 03."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.check import WrongAnswer
from tutorial_lib.geometry import Array


@dataclass(frozen=True)
class Pool:
    """P pairs, what would come of each, and how many are to be mined.

    Attributes:
        probability: (P,) predicted.
        starts: (P,) the frame at which each begins.
        occluded: (P,) far and occluded.
        labels: (P,) 1, 0, or nan where nobody has rolled the pair out.
        outcomes: (P,) what a rollout returns.
        sure: probability above which a pair is mined.
        most: hard negatives at most.
        each: of them from one start at most.
        share: of the weight that mined pairs have.
    """

    probability: Array
    starts: NDArray[np.intp]
    occluded: NDArray[np.bool_]
    labels: Array
    outcomes: Array
    sure: float = 0.5
    most: int = 30
    each: int = 2
    share: float = 0.3

    @property
    def new(self) -> NDArray[np.bool_]:
        """(P,) not rolled out, and predicted with more than `sure`."""
        return np.isnan(self.labels) & (self.probability > self.sure)


def _pool(seed: int, count: int = 400, known: float = 0.2, occluded: float = 0.6) -> Pool:
    rng = np.random.default_rng(seed)
    outcomes = rng.integers(2, size=count).astype(float)
    return Pool(
        rng.permutation(count) / count,
        rng.integers(max(count // 10, 1), size=count),
        rng.random(count) < occluded,
        np.where(rng.random(count) < known, outcomes, np.nan),
        outcomes,
    )


def _at_threshold(pool: Pool) -> Pool:
    """A pool in which an occluded pair is predicted with exactly `sure`, and nothing is full."""
    fits = np.isnan(pool.labels) & pool.occluded
    return replace(pool, sure=float(np.sort(pool.probability[fits])[-20]), most=400, each=400)


_USUAL = _pool(1)
POOLS: dict[str, Pool] = {
    "400 pairs": _USUAL,
    "one of each start": replace(_pool(2), each=1, most=100),
    "many of each start, but few in all": replace(_pool(3), each=9, most=7),
    "a threshold of 0.8": replace(_pool(4), sure=0.8, share=0.5),
    "hardly any that are not occluded": replace(_pool(5, occluded=0.97), each=3, most=60),
    "nothing that is sure": replace(_pool(6), sure=0.9995),
    "nothing occluded": replace(_pool(7), occluded=np.zeros(400, dtype=bool)),
    "a single hard negative": replace(_pool(8, occluded=1.1), most=1),
    "a pair at exactly the threshold": _at_threshold(_pool(10)),
    "hardly any label that is known": _pool(11, known=0.02),
    "12 pairs": replace(_pool(9, 12, known=0.3), sure=0.2, share=0.1),
}


class Rollouts:
    """Rolls pairs out for a student's function, and keeps which."""

    def __init__(self, what: str, pool: Pool) -> None:
        """See `Pool`."""
        self.what, self.pool, self.made = what, pool, np.zeros(0, dtype=np.intp)

    def __call__(self, pairs: object) -> Array:
        """Labels (M,) of pairs (M,)."""
        try:
            rows = np.asarray(pairs)
        except ValueError:
            rows = np.zeros((1, 1))
        fits = rows.ndim == 1 and (rows.dtype.kind in "iu" or not rows.size)
        if not fits or (rows.size and not 0 <= rows.min() <= rows.max() < len(self.pool.labels)):
            words = "roll_out takes an array of indices (M,) of pairs, 0 to P - 1"
            raise WrongAnswer(f"{self.what}: {words}")
        rows = rows.astype(np.intp)
        for pair in rows:
            self._judge(int(pair))
        self.made = np.append(self.made, rows)
        return self.pool.outcomes[rows]

    def _judge(self, pair: int) -> None:
        """Demand that a rollout is worth its time."""
        pool, words = self.pool, ""
        if not np.isnan(pool.labels[pair]):
            words = "has been rolled out already; its label is known"
        elif pool.occluded[pair]:
            words = "is occluded: it is labelled 0 without a rollout"
        elif not pool.probability[pair] > pool.sure:
            words = f"has RE {pool.probability[pair]:.4g}; only those above sure, {pool.sure}, are"
            words = f"{words} rolled out"
        elif pair in self.made:
            words = "is rolled out a second time"
        if words:
            raise WrongAnswer(f"{self.what}: pair {pair} {words}")
