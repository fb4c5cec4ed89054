"""The check of success weighted by path length, in notebook 09."""

from functools import partial

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.engine import calling, close, exercise, numbers
from tutorial_lib.geometry import Array


def spl(success: NDArray[np.bool_], shortest: Array, travelled: Array) -> float:
    """Mean success weighted by path length (Anderson et al. 2018); see the exercise."""
    longer = np.maximum(shortest, travelled)
    share = shortest / longer
    return float((success * share).mean())


def _episodes(*rows: tuple[bool, float, float]) -> tuple[NDArray[np.bool_], Array, Array]:
    """Whether each episode succeeded, its shortest path, and what was travelled, metres."""
    success, shortest, travelled = map(np.array, zip(*rows, strict=True))
    return success, shortest, travelled


def _random(seed: int) -> tuple[NDArray[np.bool_], Array, Array]:
    rng = np.random.default_rng([seed, 29])
    count = int(rng.integers(3, 12))
    shortest = rng.uniform(1.5, 10.0, count)
    travelled = shortest * rng.uniform(0.95, 3.0, count)
    return rng.random(count) < 0.6, shortest, travelled


CASES = {
    "one episode along the shortest path": _episodes((True, 4.0, 4.0)),
    "one with a detour": _episodes((True, 4.0, 5.0)),
    "two episodes, one of which failed": _episodes((True, 2.0, 4.0), (False, 8.0, 8.0)),
    "one that failed": _episodes((False, 4.0, 4.0)),
    "a stop within a metre of the goal, before the path's end": _episodes(
        (True, 5.0, 4.2), (True, 3.0, 6.0)
    ),
    "a robot that hardly moves and fails": _episodes((False, 3.0, 0.01), (True, 2.0, 2.5)),
    "a robot that does not move and fails": _episodes((False, 3.0, 0.0), (True, 2.0, 2.5)),
    "a robot that starts at the goal and stops at once": _episodes(
        (True, 0.4, 0.0), (True, 2.0, 2.5)
    ),
    "a short episode and a long one": _episodes((True, 1.5, 6.0), (True, 10.0, 11.0)),
    **{f"at random ({seed})": _random(seed) for seed in range(4)},
}
MISTAKES = """
an odometer may read a little less than the shortest path; divide by the greater of both, or one
episode counts more than 1
    shortest / longer -> shortest / travelled
shortest / travelled, not travelled / shortest: a detour must lower it
    shortest / longer -> longer / shortest
divide by the greater of the two, not by the smaller
    np.maximum -> np.minimum
a robot that has not moved and succeeds took no detour: it counts fully
    shortest / longer -> np.where(travelled == 0, 0.0, shortest / longer)
a detour is not cut off: the ratio may become very small
    shortest / longer -> shortest / np.minimum(longer, 2 * shortest)
divide with /; // drops the fraction
    shortest / longer -> shortest // longer
the ratio itself, not its square
    shortest / longer -> (shortest / longer) ** 2
weight by the ratio of lengths, not by their difference
    shortest / longer -> 1 - (longer - shortest)
an episode that travelled less than the shortest path and succeeded counts fully; yours counts it
less
    shortest / longer -> np.minimum(travelled, shortest) / longer
an episode that failed counts 0, however short its path
    success * share -> share
the mean is over all episodes; those that failed count 0, they are not left out
    (success * share).mean() -> share[success].mean() if success.any() else 0.0
the length of the path matters as well: yours is the success rate
    success * share -> success
the mean of products, not the product of means: weight each episode by itself
    (success * share).mean() -> success.mean() * share.mean()
the mean of ratios, not the ratio of sums: each episode counts the same
    (success * share).mean() -> (success * shortest).sum() / longer.sum()
take the mean over the episodes, not the sum
    .mean() -> .sum()
the ratio itself, not its square root
    success * share -> success * np.sqrt(share)
the shortest path over the greater of both; yours has the path travelled there
    shortest / longer -> travelled / longer
a share between 0 and 1, not percent
    (success * share).mean() -> 100 * (success * share).mean()
"""


def _broken(got: float, want: float, *case: Array) -> str:
    """Which part of the rule is broken."""
    success, shortest, travelled = case
    if abs(got - want) < 1e-3 * want:
        return "nearly right: the metres and their ratios keep all digits"
    if not success.all():
        return "every episode counts in the mean over all N, each one that failed with 0"
    if (travelled < shortest).any():
        return (
            "each episode counts 1 at most, by itself: shortest / max(shortest, travelled), and "
            "metres as they are"
        )
    return "the mean over all episodes of shortest / max(shortest, travelled)"


check_spl = exercise(
    spl,
    CASES,
    MISTAKES,
    about="Episodes with and without success, detours, and stops before the path's end.",
    example=_random(5),
    invoke=calling({ValueError: "the arguments are arrays, a number for each episode"}),
    form=lambda what, got, *_: numbers(what, got, ()),
    same=partial(close, tolerance=1e-6),
    difference=lambda got, want, *_: f"{float(got):.7g}, but {float(want):.7g} is right",
    broken=_broken,
)
