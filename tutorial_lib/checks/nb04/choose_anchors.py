"""The check of sparsification, in notebook 04."""

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.engine import case, exercise
from tutorial_lib.checks.nb04.forms import calling, frame_indices
from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping.vertices import Indices
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


def choose_anchors(reach: Array, threshold: float) -> Indices:
    """The anchors (A,) that `sparsify` finds, from a table of RE (T, T); see the exercise."""
    anchors, last = [0], len(reach) - 1
    while anchors[-1] < last:
        i = j = anchors[-1]
        while j < last and reach[i, j + 1] > threshold:
            j += 1
        anchors.append(max(j, i + 1))
    return np.array(anchors)


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
CASES = {
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
MISTAKES = """
every k in (i, j] must be above the threshold, not only the last one: stop at the first frame that
fails
    max(j, i + 1)
        -> max((k for k in range(i + 1, last + 1) if reach[i, k] > threshold), default=i + 1)
that is the first frame that can no longer be reached; the anchor is the one before it, the last
that can
    max(j, i + 1) -> min(j + 1, last)
not even frame i + 1 can be reached, and yours goes on to a later frame; then i + 1 is the next
anchor
    i = j = anchors[-1]
        -> i = anchors[-1]; j = next((k for k in range(i, last) if reach[i, k + 1] > threshold), i)
yours stops where frame i + 1 cannot be reached; keep that frame, and go on from it
    while anchors[-1] < last:
        -> while anchors[-1] < last and reach[anchors[-1], anchors[-1] + 1] > threshold:
the last frame is always an anchor, since the path must end where the trajectory ends
    np.array(anchors) -> np.array(anchors)[:-1]
the first frame is an anchor, too
    np.array(anchors) -> np.array(anchors)[1:]
greater than the threshold, not equal to it
    > threshold -> >= threshold
take RE from the anchor i each time, reach[i, k], not from one frame to the next
    reach[i, j + 1] -> reach[j, j + 1]
row and column are exchanged: reach[i, k] leads from frame i ahead to frame k
    reach[i, j + 1] -> reach[j + 1, i]
each RE is compared for itself; do not multiply them
    reach[i, j + 1] -> np.prod(reach[i, i + 1 : j + 2])
RE from anchor i to frame k stands in row i; yours takes it from the first frame
    reach[i, j + 1] -> reach[0, j + 1]
one anchor after the other; yours keeps every frame that can be reached
    np.array(anchors) -> np.unique([0, *np.flatnonzero(reach[0] > threshold), last])
threshold is an argument; yours has 0.9 written into it
    > threshold -> > 0.9
threshold is an argument; yours has 0.95 written into it
    > threshold -> > 0.95
the last frame, T - 1, may be reached from afar like any other one
    j < last and -> j < last - 1 and
the last frame comes twice
    np.array(anchors) -> np.array([*anchors, last])
each RE is compared for itself; do not average them
    reach[i, j + 1] -> np.mean(reach[i, i + 1 : j + 2])
"""


def _agreeing(got: Indices, want: Indices) -> int:
    """How many anchors agree before the first that differs."""
    shorter = min(len(got), len(want))
    return int(np.append(got[:shorter] != want[:shorter], True).argmax())


def _broken(got: Indices, want: Indices, reach: Array, threshold: float) -> str:
    """Which part of the rule the first wrong anchor breaks."""
    same = _agreeing(got, want)
    if same == len(got) < len(want):
        return "the last frame is always an anchor, however it is reached"
    if same in (0, len(want)) or got[same] <= want[same - 1]:
        return "the anchors rise from 0 to T - 1, each once"
    if got[same] < want[same]:
        return "go on as long as the next frame is above the threshold, however many those are"
    i, words = want[same - 1], "frame i + 1 is above the threshold, it is the next anchor"
    if reach[i, i + 1] <= threshold:
        return f"where not even {words} all the same"
    return "stop before the first frame whose RE from i, as it is, is not above the threshold"


def _apart(got: Indices, want: Indices, reach: Array, threshold: float) -> str:
    """Where an answer first differs."""
    same = _agreeing(got, want)
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


def _tables(want: Indices, got: Indices) -> NDArray[np.uint8]:
    tables = [reach_table(BY_HAND, 0.9, chosen.tolist()) for chosen in (want, got)]
    return side_by_side(tables, ["expected", "yours"], gap=30)


_HINTS: dict[type[Exception], str] = {
    IndexError: "after the last frame, T - 1, comes none: look whether j + 1 is a frame first",
    ValueError: "there may be no frame above the threshold, and no frame below it",
    TypeError: "anchors are whole numbers, indices of frames",
    NameError: "is it spelt right?",
}
check_choose_anchors = exercise(
    choose_anchors,
    CASES,
    MISTAKES,
    about="The trajectory done by hand, ones where all or nothing can be reached, and longer ones.",
    example=case(_smooth(200, 3), 0.9),
    calls=50,
    endless="choose_anchors: your function has not ended after {seconds:g} seconds. Does every "
    "round add an anchor? Where not even frame i + 1 is above the threshold, it is the next anchor "
    "all the same: the path must go on",
    invoke=calling(_HINTS),
    form=frame_indices,
    difference=_apart,
    broken=_broken,
    draw=_tables,
)
