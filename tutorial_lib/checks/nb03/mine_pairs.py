"""The check of mining hard pairs, in notebook 03."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.engine import Mask, WrongAnswer, check, parts
from tutorial_lib.checks.framework.wording import both, times
from tutorial_lib.checks.nb03.forms import calling, vector
from tutorial_lib.geometry import Array


@dataclass(frozen=True)
class Pool:
    """P pairs, what a rollout returns of each, `outcomes`, and other arguments of `mine_pairs`."""

    probability: Array
    starts: NDArray[np.intp]
    occluded: Mask
    labels: Array
    outcomes: Array
    sure: float = 0.5
    most: int = 30
    each: int = 2
    share: float = 0.3

    @property
    def new(self) -> Mask:
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
    "no hard negative": replace(_pool(12), most=0),
    "a single hard negative": replace(_pool(8, occluded=1.1), most=1),
    "a pair at exactly the threshold": _at_threshold(_pool(10)),
    "hardly any label that is known": _pool(11, known=0.02),
    "12 pairs": replace(_pool(9, 12, known=0.3), sure=0.2, share=0.1),
}


class Rollouts:
    """Rolls pairs out for a student's function, and keeps which."""

    def __init__(self, what: str, pool: Pool) -> None:
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
            words = "is occluded: it is labelled 0 without a rollout, or left out"
        elif not pool.probability[pair] > pool.sure:
            words = f"has RE {pool.probability[pair]:.4g}; only those above sure, {pool.sure}, are "
            words += "rolled out"
        elif pair in self.made:
            words = "is rolled out a second time"
        if words:
            raise WrongAnswer(f"{self.what}: pair {pair} {words}")


Pairs = NDArray[np.intp]


def mine_pairs(
    probability: Array,
    starts: Pairs,
    occluded: Mask,
    labels: Array,
    roll_out: Callable[[Pairs], Array],
    sure: float,
    most: int,
    each: int,
    share: float,
    rng: np.random.Generator,
) -> tuple[Pairs, Array, Array]:
    """Pairs (M,) whose labels are known, and mined ones, with labels and weights; see the exercise.

    Pairs begin at frames `starts` (P,); of `most` hard negatives `each` may begin at one frame.
    """
    unknown = np.isnan(labels)
    easy, new = np.flatnonzero(~unknown), unknown & (probability > sure)
    negatives, counts = [], {}
    for pair in np.argsort(-probability):
        start = starts[pair]
        if len(negatives) < most and new[pair] and occluded[pair] and counts.get(start, 0) < each:
            negatives.append(pair)
            counts[start] = counts.get(start, 0) + 1
    candidates = np.flatnonzero(new & ~occluded)
    drawn = rng.permutation(candidates)[: len(negatives)]
    outcomes = roll_out(drawn) if len(drawn) else np.zeros(0)
    mined = np.append(np.array(negatives, dtype=int), drawn)
    weight = share / (1 - share) * len(easy) / max(len(mined), 1)
    return (
        np.append(easy, mined),
        np.concatenate([labels[easy], np.zeros(len(negatives)), outcomes]),
        np.append(np.ones(len(easy)), np.full(len(mined), weight)),
    )


_HINTS: dict[type[Exception], str] = {
    IndexError: "pairs are 0 to P - 1; there may be no hard negative, and no pair to roll out",
    ValueError: "there may be fewer candidates than you draw, or none at all",
    ZeroDivisionError: "there may be no mined pair at all",
    TypeError: "pairs are whole numbers; roll_out wants an array of them",
    KeyError: "a start may come for the first time",
}


def _arguments(pool: Pool, roll_out: Callable[[Pairs], Array], seed: int) -> tuple[Any, ...]:
    masks = pool.probability, pool.starts, pool.occluded, pool.labels
    rules = pool.sure, pool.most, pool.each, pool.share
    return *masks, roll_out, *rules, np.random.default_rng(seed)


@check(mine_pairs, _arguments(_USUAL, lambda pairs: _USUAL.outcomes[pairs], 0), calls=10)
def check_mine_pairs(student: Callable[..., Any]) -> None:
    """Twelve pools: which pairs are kept, rolled out and drawn, with which labels and weights."""
    for name, pool in POOLS.items():
        what = f"mine_pairs, {name}"
        rollouts, (pairs, labels, weights) = _answer(what, student, pool, 0)
        _demand_pairs(what, pool, rollouts, pairs)
        _demand_labels(what, pool, pairs, labels)
        _demand_weights(what, pool, pairs, weights)
    _demand_chance(student, _USUAL)


def _answer(
    what: str, student: Callable[..., Any], pool: Pool, seed: int
) -> tuple[Rollouts, tuple[Pairs, Array, Array]]:
    """A student's pairs, labels and weights, of the right form."""
    rollouts = Rollouts(what, pool)
    arguments = _arguments(pool, rollouts, seed)
    before = [array.copy() for array in arguments[:4]]
    got = calling(_HINTS)(what, lambda: student(*arguments))
    names = ("probability", "starts", "occluded", "labels")
    for name, old, new in zip(names, before, arguments, strict=False):
        if not np.array_equal(old, new, equal_nan=name == "labels"):
            new[:] = old
            raise WrongAnswer(f"{what}: your function changes {name}; make a new array")
    words = "return three arrays of one length: pairs, labels, weights"
    first, second, third = parts(what, got, 3, words)
    count = len(first) if isinstance(first, np.ndarray | list | tuple) else 0
    pairs = vector(f"{what}, pairs", first, count, "the indices of the pairs")
    if (pairs != pairs.round()).any() or not ((pairs >= 0) & (pairs < len(pool.labels))).all():
        raise WrongAnswer(f"{what}, pairs: return indices of pairs, from 0 to P - 1")
    if first.dtype.kind not in "iu":
        words = "return whole numbers, so that they can be used as indices"
        raise WrongAnswer(f"{what}, pairs: the pairs are {first.dtype}; {words}")
    second = vector(f"{what}, labels", second, count, "a label for each pair")
    third = vector(f"{what}, weights", third, count, "a weight for each pair")
    return rollouts, (pairs.astype(np.intp), second, third)


def _demand_pairs(what: str, pool: Pool, rollouts: Rollouts, pairs: Pairs) -> None:
    """Demand the right pairs, each once."""
    values, counts = np.unique(pairs, return_counts=True)
    known, hidden = ~np.isnan(pool.labels), pool.occluded
    right = mine_pairs(*_arguments(pool, lambda rows: pool.outcomes[rows], 0))[0]
    hard = right[~known[right] & hidden[right]]
    candidates = np.flatnonzero(pool.new & ~hidden)
    drawn = values[~known[values] & ~hidden[values]]
    missing = np.setdiff1d(np.flatnonzero(known), values)
    low = values[~known[values] & ~pool.new[values]]
    unused, made = np.setdiff1d(rollouts.made, drawn), np.setdiff1d(drawn, rollouts.made)
    if (counts > 1).any():
        words = f"pair {values[counts > 1][0]} comes {times(counts.max())}; each comes once"
    elif missing.size:
        words = f"pair {missing[0]} has a label, {pool.labels[missing[0]]:.0f}, and is missing; "
        words += "all pairs whose label is known belong to the training set"
    elif low.size:
        words = f"pair {low[0]} has RE {pool.probability[low[0]]:.4g}, and sure is {pool.sure}; "
        words += "only pairs above it are mined"
    elif wrong := _wrong_negatives(pool, values[~known[values] & hidden[values]], hard):
        words = wrong
    elif len(drawn) != min(len(hard), len(candidates)):
        words = f"{len(drawn)} pairs that are not occluded, but there are {len(hard)} hard"
        words += f" negatives and {len(candidates)} candidates; draw as many as hard negatives"
        words += ", or all candidates if there are fewer"
    elif unused.size:
        words = f"pair {unused[0]} was rolled out, and its outcome is not used; draw first"
    elif made.size:
        words = f"pair {made[0]} is not occluded and was not rolled out; its label is unknown"
    else:
        words = ""
    if words:
        raise WrongAnswer(f"{what}: {words}")


def _wrong_negatives(pool: Pool, got: Pairs, want: Pairs) -> str:
    """What is wrong with the hard negatives; empty if nothing is."""
    number, counts = len(got), np.bincount(pool.starts[got], minlength=1)
    if not number and len(want):
        return f"no hard negative among yours, but {len(want)} occluded pairs are above sure"
    if counts.max() > pool.each:
        words = f"{counts.max()} hard negatives begin at frame {counts.argmax()}"
        return f"{words}; at most {pool.each} of each start"
    if number > pool.most:
        return f"{number} hard negatives; at most {pool.most} in all"
    missing, extra = np.setdiff1d(want, got), np.setdiff1d(got, want)
    if not missing.size:
        return ""
    best = int(missing[np.argmax(pool.probability[missing])])
    words = f"pair {best} is occluded with RE {pool.probability[best]:.4g} and is missing"
    used = int((pool.starts[got] == pool.starts[best]).sum())
    if extra.size:
        worst = int(extra[np.argmin(pool.probability[extra])])
        other = f"pair {worst} with RE {pool.probability[worst]:.4g} is there"
        words = f"{words}, and {other}; begin with the highest"
        return f"{words}; of the start of pair {best} {used} of at most {pool.each} are chosen"
    words = f"{words}; {number} of at most {pool.most} are chosen, {used} of at most {pool.each}"
    return f"{words} of its start: a pair that is left out must not count"


def _demand_labels(what: str, pool: Pool, pairs: Pairs, labels: Array) -> None:
    """Demand the right label of each pair."""
    known = ~np.isnan(pool.labels[pairs])
    rolled = np.where(pool.occluded[pairs], 0.0, pool.outcomes[pairs])
    wrong = np.flatnonzero(~np.isclose(labels, np.where(known, pool.labels[pairs], rolled)))
    if wrong.size:
        i = int(wrong[0])
        kind = "occluded and is labelled 0" if pool.occluded[pairs[i]] else "rolled out"
        kind = "known" if known[i] else kind
        right = pool.labels[pairs[i]] if known[i] else rolled[i]
        words = f"pair {pairs[i]} is {kind}: its label is {right:.0f}, not {labels[i]:.3g}"
        raise WrongAnswer(f"{what}: {words}; pairs and labels must stand in the same order")


def _demand_weights(what: str, pool: Pool, pairs: Pairs, weights: Array) -> None:
    """Demand weights of 1, and the share of the mined pairs."""
    mined = np.isnan(pool.labels[pairs])
    own = weights[mined]
    if not np.allclose(weights[~mined], 1.0):
        raise WrongAnswer(f"{what}: a pair whose label was known before has the weight 1")
    if not np.allclose(own, own[:1]):
        raise WrongAnswer(f"{what}: all mined pairs have the same weight")
    found = own.sum() / weights.sum()
    if len(own) and not np.isclose(found, pool.share, atol=1e-6):
        words = f"mined pairs together have {found:.1%} of the weight of all"
        right = pool.share / (1 - pool.share) * (~mined).sum() / mined.sum()
        each = "so each weighs {1}, not {0}".format(*both(own[0], right))
        raise WrongAnswer(f"{what}: {words}; share is {pool.share:.0%}, {each}")


def _demand_chance(student: Callable[..., Any], pool: Pool) -> None:
    """Demand that the pairs that are rolled out are drawn by rng, and at random."""
    what, draws = "mine_pairs", []
    for seed in (0, *range(40)):
        pairs = _answer(what, student, pool, seed)[1][0]
        draws.append(set(pairs[np.isnan(pool.labels[pairs]) & ~pool.occluded[pairs]].tolist()))
    never = set(np.flatnonzero(pool.new & ~pool.occluded).tolist()) - set().union(*draws)
    if draws[0] != draws[1]:
        words = "the same seed draws other pairs; draw by rng, not by np.random"
    elif all(draw == draws[0] for draw in draws):
        words = "every seed gives the same pairs to roll out; draw them at random, by rng"
    elif never:
        words = f"pair {min(never)}, RE {pool.probability[min(never)]:.4g}, is never drawn in 40 "
        words += "attempts; draw among all candidates alike"
    else:
        return
    raise WrongAnswer(f"{what}: {words}")
