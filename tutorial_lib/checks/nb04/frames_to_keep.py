"""The check of the frames that anchors with their contexts need, in notebook 04."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.engine import WrongAnswer, case, exercise
from tutorial_lib.checks.nb04.forms import calling, frame_indices
from tutorial_lib.driving.data.recorded_world import frames_around
from tutorial_lib.topology.mapping.vertices import Indices
from tutorial_lib.viz.figures.follower_states import frames_kept
from tutorial_lib.viz.figures.panels import stacked


def frames_to_keep(anchors: Indices, total: int, k: int) -> Indices:
    """The frames, of a trajectory of `total`, that its anchors (A,) with their contexts need."""
    around = frames_around(anchors, k, 0, total - 1)
    return np.unique(around)


def _random(count: int) -> dict[str, tuple[Indices, int, int]]:
    """Trajectories of 2 to 60 frames with some anchors between the ends."""
    rng, cases = np.random.default_rng(6), {}
    for _ in range(count):
        total, k = int(rng.integers(2, 61)), int(rng.integers(0, 7))
        between = rng.choice(total, int(rng.integers(0, min(total, 7))), replace=False)
        anchors = np.unique([0, *between, total - 1])
        cases[f"anchors {anchors.tolist()} of {total} frames, k = {k}"] = anchors, total, k
    return cases


CASES = {
    "k = 2": (np.array([0, 18, 39]), 40, 2),
    "anchors close together, k = 2": (np.array([0, 6, 9, 20, 39]), 40, 2),
    "k = 0": (np.array([0, 5, 21, 29]), 30, 0),
    "anchors near the ends, k = 5": (np.array([0, 4, 30, 57, 59]), 60, 5),
    "one anchor in the middle": (np.array([30]), 60, 2),
    "one anchor near the start": (np.array([2]), 60, 2),
    "one anchor near the end": (np.array([57]), 60, 2),
    "a short trajectory, k = 5": (np.array([0, 4]), 5, 5),
    **_random(20),
}
MISTAKES = """
a frame that two contexts share is kept once: np.unique
    np.unique(around) -> around.ravel()
there are no frames before 0 or after the last; there the context repeats the first or last frame
    frames_around(anchors, k, 0, total - 1) -> anchors[:, None] + 3 * np.arange(-k, k + 1)
a frame before 0 is no frame from the end; np.clip keeps it within the trajectory
    frames_around(anchors, k, 0, total - 1) -> (anchors[:, None] + 3 * np.arange(-k, k + 1)) % total
the last frame is total - 1, not total
    total - 1 -> total
the frames of a context are 3 frames apart
    frames_around(anchors, k, 0, total - 1)
        -> np.clip(anchors[:, None] + np.arange(-k, k + 1), 0, total - 1)
only every third frame of a context is needed
    frames_around(anchors, k, 0, total - 1)
        -> np.clip(anchors[:, None] + np.arange(-3 * k, 3 * k + 1), 0, total - 1)
the context lies on both sides; the frames after the anchor are missing
    np.unique(around) -> np.unique(around[:, : k + 1])
the context lies on both sides; the frames before the anchor are missing
    np.unique(around) -> np.unique(around[:, k:])
k frames on either side; one is missing at the end of each context
    np.unique(around) -> np.unique(around[:, :-1])
k frames on either side, not k + 1
    (anchors, k, -> (anchors, k + 1,
a context that reaches beyond an end needs the frame there, which need not be an anchor
    frames_around(anchors, k, 0, total - 1) -> anchors[:, None] + 3 * np.arange(-k, k + 1)
    np.unique(around) -> np.unique(around[(0 <= around) & (around < total)])
the trajectory ends at total - 1, not at the last anchor
    total - 1 -> anchors[-1]
the trajectory runs from frame 0 to total - 1, not from the first anchor to the last
    0, total - 1 -> anchors[0], anchors[-1]
the trajectory begins at frame 0, not at the first anchor
    0, total - 1 -> anchors[0], total - 1
the frames of a context are 3 apart, whatever k is
    frames_around(anchors, k, 0, total - 1)
        -> np.clip(anchors[:, None] + k * np.arange(-k, k + 1), 0, total - 1)
k may be 0; then the anchors themselves are kept
    np.unique(around) -> np.unique(around)[: None if k else 0]
k is an argument; yours has k = 2 written into it
    (anchors, k, -> (anchors, 2,
that is the anchors alone; each needs its context, too
    np.unique(around) -> anchors
the anchors themselves are missing
    np.unique(around) -> np.unique(np.delete(around, k, axis=1))
only the contexts' outermost frames; those between are needed, too
    np.unique(around) -> np.unique(around[:, [0, k, -1]])
"""
_HINTS: dict[type[Exception], str] = {
    ValueError: "anchors[:, None] is a column, and with a row of offsets it makes a table",
    IndexError: "beyond an end of the trajectory there are no frames",
    TypeError: "anchors is an array of whole numbers, total and k are whole numbers",
    AttributeError: "anchors is an array; return an array or a list",
    NameError: "is it spelt right?",
}


def _form(what: str, got: Any, *_: object) -> Indices:  # noqa: ANN401 - students'
    """Frames in rising order."""
    if isinstance(got, int | np.integer):
        raise WrongAnswer(f"{what}: return the indices of the frames, not how many there are")
    return np.sort(frame_indices(what, list(got) if isinstance(got, set) else got))


def _broken(got: Indices, want: Indices, anchors: Indices, total: int, k: int) -> str:
    """Which part of the rule the wrong frames break."""
    if got.size and not (got.min() >= 0 and got.max() < total):
        return "the trajectory ends on both sides: a context that reaches beyond repeats the end"
    if np.setdiff1d(want, got).size:
        return "every anchor, also the first and the last, needs all frames of its context"
    if len(set(got.tolist())) < len(got):
        return "anchors close together share frames; each frame is kept once"
    return "only what a context holds is kept; the ends of the trajectory are no exception"


def _difference(got: Indices, want: Indices, anchors: Indices, total: int, k: int) -> str:
    """The first frame that is missing, or too many, and why."""
    twice, missing = got[1:][np.diff(got) == 0], np.setdiff1d(want, got)
    if twice.size:
        return f"frame {twice[0]} comes twice"
    if missing.size:
        steps, last = range(-k, k + 1), total - 1
        found = (
            (a, s) for a in anchors for s in steps if np.clip(a + 3 * s, 0, last) == missing[0]
        )
        anchor, step = min(found, key=lambda pair: abs(pair[1]))
        return f"frame {missing[0]} is missing: anchor {anchor} {3 * step:+d} needs it"
    extra = np.setdiff1d(got, want)[0]
    words = f"from {-k} to {k} times 3 frames away, and from 0 to {total - 1}"
    return f"frame {extra} is too many; no anchor needs it: the frames of a context are {words}"


def _drawn(want: Indices, got: Indices) -> NDArray[np.uint8]:
    anchors, total, _ = next(iter(CASES.values()))
    shown = [frame for frame in got.tolist() if 0 <= frame < total]
    rows = [frames_kept(total, frames, anchors.tolist()) for frames in (want.tolist(), shown)]
    return stacked(rows, ["expected", "yours"], gap=4)


check_frames_to_keep = exercise(
    frames_to_keep,
    CASES,
    MISTAKES,
    about="Contexts that lie apart, that share frames, that reach beyond the ends, and 20 at "
    "random.",
    example=case(np.arange(0, 400, 13), 400, 5),
    invoke=calling(_HINTS),
    form=_form,
    difference=_difference,
    broken=_broken,
    draw=_drawn,
)
