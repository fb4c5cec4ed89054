"""The check of sparsification, in notebook 04."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.comparison import compare
from tutorial_lib.checks.nb04.follower_answers import calling
from tutorial_lib.checks.nb04.frame_indices import frame_indices
from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping.sparsify import sparsify
from tutorial_lib.viz.figures.follower_states import reach_table
from tutorial_lib.viz.figures.panels import side_by_side

BY_HAND = np.array(
    [
        [1.00, 0.99, 0.97, 0.95, 0.80, 0.93, 0.40, 0.10],
        [0.97, 1.00, 0.99, 0.98, 0.90, 0.95, 0.50, 0.20],
        [0.95, 0.98, 1.00, 0.99, 0.93, 0.97, 0.55, 0.25],
        [0.88, 0.91, 0.96, 1.00, 0.98, 0.96, 0.62, 0.30],
        [0.60, 0.72, 0.85, 0.97, 1.00, 0.97, 0.66, 0.81],
        [0.55, 0.60, 0.71, 0.86, 0.95, 1.00, 0.70, 0.91],
        [0.20, 0.25, 0.31, 0.33, 0.42, 0.93, 1.00, 0.97],
        [0.10, 0.12, 0.15, 0.17, 0.22, 0.64, 0.95, 1.00],
    ]
)
"""A small trajectory of eight frames: RE from each (row) to each (column)."""


class _Table:
    """A `Reachability` that looks up a table; observations and targets are indices of frames."""

    def __init__(self, reach: Array) -> None:
        self.reach = reach

    def prepare(self, targets: NDArray[np.intp]) -> NDArray[np.intp]:
        """Prepare nothing."""
        return targets

    def probability(self, observations: NDArray[np.intp], prepared: NDArray[np.intp]) -> Array:
        """(N,) from the table."""
        return self.reach[observations, prepared]


def choose_anchors(reach: Array, threshold: float) -> NDArray[np.intp]:
    """The library's anchors for a table of RE.

    Args:
        reach: (T, T), RE from each frame, a row, to each other one.
        threshold: p_sparsify.
    """
    reach = np.asarray(reach)
    frames: Any = np.arange(len(reach))
    return sparsify(_Table(reach), frames, frames, threshold)


def _smooth(frames: int, seed: int) -> Array:
    """A random trajectory (T, T): RE falls with distance, not evenly."""
    rng = np.random.default_rng(seed)
    gap = np.abs(np.subtract.outer(np.arange(frames), np.arange(frames)))
    hard = rng.uniform(0.2, 1.0, frames)[:, None]
    noise = rng.normal(0.0, 0.6, (frames, frames))
    return np.round(1.0 / (1.0 + np.exp(-(5.5 - hard * gap + noise))), 3)


def _ahead_only(reach: Array) -> Array:
    """The same trajectory (T, T), of which only what lies ahead is known."""
    return np.where(np.triu(np.ones(reach.shape, dtype=bool), 1), reach, np.nan)


def _random(count: int) -> dict[str, tuple[Array, float]]:
    """Trajectories of 2 to 30 frames, with thresholds that some RE equals exactly."""
    rng, cases = np.random.default_rng(5), {}
    for seed in range(count):
        reach = _smooth(int(rng.integers(2, 31)), 10 + seed)
        threshold = float(rng.uniform(0.3, 0.98))
        if seed % 2:
            threshold = float(np.clip(rng.choice(reach[0, 1:]), 0.1, 0.99))
        cases[f"trajectory {seed}, p = {threshold:.3g}"] = _ahead_only(reach), threshold
    return cases


_EVEN = np.array([[1, 0.9, 0.8], [0.9, 1, 0.9], [0.8, 0.9, 1]])
_CASES = {
    "the trajectory above": (BY_HAND, 0.9),
    "every frame can be reached": (np.full((6, 6), 0.98), 0.9),
    "no frame can be reached": (np.full((5, 5), 0.3), 0.9),
    "RE equals the threshold": (_EVEN, 0.8),
    "40 frames": (_smooth(40, 1), 0.9),
    "40 frames, a low threshold": (_smooth(40, 2), 0.6),
    "two frames": (np.array([[1.0, 0.95], [0.95, 1.0]]), 0.9),
    "two frames, out of reach": (np.array([[1.0, 0.5], [0.5, 1.0]]), 0.9),
    "RE is known ahead only": (_ahead_only(_smooth(25, 4)), 0.8),
    **_random(24),
}
_ENDLESS = (
    "choose_anchors: your function has not ended after {seconds:g} seconds. Does every round add "
    "an anchor? Where not even frame i + 1 is above the threshold, it is the next anchor all the "
    "same: the path must go on"
)


def _greedy(
    reach: Array,
    threshold: float,
    reached: Callable[[Array, int, int, float], bool],
    gap: bool = False,
) -> list[int]:
    """Anchors by another rule; with `gap`, frames that fail may lie between."""
    anchors = [0]
    while anchors[-1] < len(reach) - 1:
        i = anchors[-1]
        ahead = range(i + 1, len(reach))
        holds = [reached(reach, i, k, threshold) for k in ahead]
        if gap:
            last = max((k for k, h in zip(ahead, holds, strict=True) if h), default=i + 1)
        else:
            last = max(i + (holds.index(False) if False in holds else len(holds)), i + 1)
        anchors.append(last)
    return anchors


def _holds(reach: Array, i: int, k: int, threshold: float) -> bool:
    return bool(reach[i, k] > threshold)


def _first_failing(reach: Array, threshold: float) -> list[int]:
    """The first frame that cannot be reached in place of the last that can."""
    anchors = [0]
    while anchors[-1] < len(reach) - 1:
        fails = np.flatnonzero(reach[anchors[-1], anchors[-1] + 1 :] <= threshold)
        anchors.append(anchors[-1] + 1 + int(fails[0]) if len(fails) else len(reach) - 1)
    return anchors


def _skips_ahead(reach: Array, threshold: float) -> list[int]:
    """Where the next frame fails, on to the next one that does not."""
    anchors = [0]
    while anchors[-1] < len(reach) - 1:
        i = anchors[-1]
        holds = reach[i, i + 1 :] > threshold
        start = int(holds.argmax()) if holds.any() else 0
        fails = np.flatnonzero(~holds[start:])
        run = int(fails[0]) if len(fails) else len(holds) - start
        anchors.append(i + max(start + run, 1))
    return anchors


def _gives_up(reach: Array, threshold: float) -> list[int]:
    """Anchors up to the first frame from which the next one cannot be reached."""
    anchors = choose_anchors(reach, threshold).tolist()
    stuck = [i for i, j in pairwise(anchors) if not reach[i, j] > threshold]
    return anchors[: anchors.index(stuck[0]) + 1] if stuck else anchors


_FAULTS: dict[str, Callable[[Array, float], ArrayLike]] = {
    "every k in (i, j] must be above the threshold, not only the last one: stop at the first frame "
    "that fails": lambda r, p: _greedy(r, p, _holds, gap=True),
    "that is the first frame that can no longer be reached; the anchor is the one before it, the "
    "last that can": _first_failing,
    "not even frame i + 1 can be reached, and yours goes on to a later frame; then i + 1 is the "
    "next anchor": _skips_ahead,
    "yours stops where frame i + 1 cannot be reached; keep that frame, and go on from it": (
        _gives_up
    ),
    "the last frame is always an anchor, since the path must end where the trajectory ends": (
        lambda r, p: choose_anchors(r, p)[:-1]
    ),
    "the first frame is an anchor, too": lambda r, p: choose_anchors(r, p)[1:],
    "greater than the threshold, not equal to it": lambda r, p: _greedy(
        r, p, lambda r, i, k, p: bool(r[i, k] >= p)
    ),
    "take RE from the anchor i each time, reach[i, k], not from one frame to the next": (
        lambda r, p: _greedy(r, p, lambda r, i, k, p: bool(r[k - 1, k] > p))
    ),
    "row and column are exchanged: reach[i, k] leads from frame i ahead to frame k": lambda r, p: (
        _greedy(r, p, lambda r, i, k, p: bool(r[k, i] > p))
    ),
    "each RE is compared for itself; do not multiply them": lambda r, p: _greedy(
        r, p, lambda r, i, k, p: bool(np.prod(r[i, i + 1 : k + 1]) > p)
    ),
    "RE from anchor i to frame k stands in row i; yours takes it from the first frame": (
        lambda r, p: _greedy(r, p, lambda r, i, k, p: bool(r[0, k] > p))
    ),
    "one anchor after the other; yours keeps every frame that can be reached": lambda r, p: sorted(
        {0, len(r) - 1, *np.flatnonzero(r[0] > p).tolist()}
    ),
    "threshold is an argument; yours has 0.9 written into it": lambda r, p: choose_anchors(r, 0.9),
    "threshold is an argument; yours has 0.95 written into it": lambda r, p: choose_anchors(
        r, 0.95
    ),
    "the last frame, T - 1, may be reached from afar like any other one": lambda r, p: _greedy(
        r, p, lambda r, i, k, p: bool(r[i, k] > p) and k < len(r) - 1
    ),
    "the last frame comes twice": lambda r, p: [*choose_anchors(r, p), len(r) - 1],
    "each RE is compared for itself; do not average them": lambda r, p: _greedy(
        r, p, lambda r, i, k, p: bool(np.mean(r[i, i + 1 : k + 1]) > p)
    ),
}


def _broken(got: NDArray[np.intp], want: NDArray[np.intp], reach: Array, threshold: float) -> str:
    """Which part of the rule the first wrong anchor breaks."""
    i, mine, right = next(
        (
            (int(want[k - 1]) if k else -1, mine, right)
            for k, (mine, right) in enumerate(zip(got, want, strict=False))
            if mine != right
        ),
        (-1, -1, -1),
    )
    if len(got) < len(want) and mine == right:
        return "the last frame is always an anchor, however it is reached"
    if not 0 <= i < mine:
        return "the anchors rise from 0 to T - 1, each once"
    if mine < right:
        return "go on as long as the next frame is above the threshold, however many those are"
    if reach[i, i + 1] <= threshold:
        return (
            "where not even frame i + 1 is above the threshold, it is the next anchor all the same"
        )
    return "stop before the first frame whose RE from i, as it is, is not above the threshold"


def _apart(got: NDArray[np.intp], want: NDArray[np.intp], reach: Array, threshold: float) -> str:
    """Where an answer first differs."""
    same = 0
    while same < min(len(got), len(want)) and got[same] == want[same]:
        same += 1
    if not len(got):
        return "no anchors; the first and the last frame always are"
    if same == 0:
        return f"the first frame is an anchor, index 0; yours begins with {got[0]}"
    after = f"after anchor {want[same - 1]}"
    if same == len(want):
        return f"{after}, the last frame, comes no other; yours goes on to {got[same]}"
    if same == len(got):
        return f"{after} comes {want[same]}; yours ends there, before the last frame"
    i, j, mine = int(want[same - 1]), int(want[same]), int(got[same])
    if not i < mine < len(reach):
        return f"{after} comes {j}; yours has {mine}, but indices rise, from 0 to {len(reach) - 1}"
    if mine < j:
        words = f"RE({i}, {mine + 1}) is {reach[i, mine + 1]:.3g}, above the threshold too"
        return f"{after} comes {j}, not {mine}: {words}, {threshold:.3g}"
    fails = f"RE({i}, {j + 1}) is {reach[i, j + 1]:.3g}, not above the threshold {threshold:.3g}"
    if reach[i, i + 1] <= threshold:
        fails = f"RE({i}, {j}) is not above the threshold; then the next frame is an anchor"
    return f"{after} comes {j}, not {mine}: {fails}"


def _tables(want: NDArray[np.intp], got: NDArray[np.intp]) -> NDArray[np.uint8]:
    tables = [reach_table(BY_HAND, 0.9, chosen.tolist()) for chosen in (want, got)]
    return side_by_side(tables, ["target", "yours"], gap=30)


_HINTS: dict[type[Exception], str] = {
    IndexError: "after the last frame, T - 1, comes none: look whether j + 1 is a frame first",
    ValueError: "there may be no frame above the threshold, and no frame below it",
    TypeError: "anchors are whole numbers, indices of frames",
    NameError: "is it spelt right?",
}


@check(choose_anchors, (_smooth(200, 3), 0.9), endless=_ENDLESS)
def check_choose_anchors(student: Callable[..., Any]) -> NDArray[np.uint8] | None:
    """The trajectory done by hand, ones where all or nothing can be reached, and longer ones."""
    return compare(
        "choose_anchors",
        student,
        _CASES,
        choose_anchors,
        _FAULTS,
        invoke=calling(_HINTS),
        form=frame_indices,
        difference=_apart,
        broken=_broken,
        draw=_tables,
    )
