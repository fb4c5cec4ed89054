"""The check of the frames that anchors with their contexts need, in notebook 04."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.checks.framework.answers import call
from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import expect
from tutorial_lib.checks.nb04.frame_indices import frame_indices
from tutorial_lib.driving.data.recorded_world import frames_around
from tutorial_lib.viz.figures.follower_states import frames_kept
from tutorial_lib.viz.figures.panels import stacked


def frames_to_keep(anchors: ArrayLike, total: int, k: int) -> NDArray[np.intp]:
    """The frames, of a trajectory of `total`, that its anchors (A,) with their contexts need."""
    return np.unique(frames_around(np.asarray(anchors), k, 0, total - 1))


_CASES = (
    ("k = 2", [0, 18, 39], 40, 2),
    ("anchors close together, k = 2", [0, 6, 9, 20, 39], 40, 2),
    ("k = 0", [0, 5, 21, 29], 30, 0),
    ("anchors near the ends, k = 5", [0, 4, 30, 57, 59], 60, 5),
)


@check(frames_to_keep, (np.arange(0, 400, 13), 400, 5))
def check_frames_to_keep(student: Callable[..., Any]) -> NDArray[np.uint8] | None:
    """Contexts that lie apart, that share frames, and that reach beyond the trajectory's ends."""
    picture = None
    for name, anchors, total, k in _CASES:
        got, what = call(student, np.array(anchors), total, k), f"frames_to_keep, {name}"
        if isinstance(got, int | np.integer):
            raise WrongAnswer(f"{what}: return the indices of the frames, not how many there are")
        got, want = np.sort(frame_indices(what, got)), frames_to_keep(anchors, total, k)
        picture = _rows(total, anchors, want, got) if picture is None else picture
        mistakes = _mistakes(np.array(anchors), total, k).items()
        expect(what, got, want, mistakes, _same, _difference, picture)
    return picture


def _same(got: NDArray[np.intp], want: NDArray[np.intp]) -> bool:
    return np.array_equal(got, np.sort(want))


def _difference(got: NDArray[np.intp], want: NDArray[np.intp]) -> str:
    missing, extra = np.setdiff1d(want, got).tolist(), np.setdiff1d(got, want).tolist()
    return f"frames {missing} are missing, {extra} are too many"


def _rows(
    total: int, anchors: Sequence[int], want: NDArray[np.intp], got: NDArray[np.intp]
) -> NDArray[np.uint8]:
    rows = [frames_kept(total, frames.tolist(), anchors) for frames in (want, got)]
    return stacked(rows, ["target", "yours"], gap=4)


def _mistakes(anchors: NDArray[np.intp], total: int, k: int) -> dict[str, NDArray[np.intp]]:
    """Known mistakes, and the frames they give."""

    def around(offsets: Iterable[int]) -> NDArray[np.intp]:
        return (anchors[:, None] + np.array(list(offsets), dtype=int)).ravel()

    def kept(offsets: Iterable[int]) -> NDArray[np.intp]:
        return np.unique(np.clip(around(offsets), 0, total - 1))

    steps = range(-3 * k, 3 * k + 1, 3)
    return {
        "a frame that two contexts share is kept once: np.unique": np.clip(
            around(steps), 0, total - 1
        ),
        "there are no frames before 0 or after the last; there the context repeats the first or "
        "last frame": np.unique(around(steps)),
        "a frame before 0 is no frame from the end; np.clip keeps it within the trajectory": (
            np.unique(around(steps) % total)
        ),
        "the frames of a context are 3 frames apart": kept(range(-k, k + 1)),
        "only every third frame of a context is needed": kept(range(-3 * k, 3 * k + 1)),
        "the context lies on both sides; the frames after the anchor are missing": kept(
            range(-3 * k, 1, 3)
        ),
        "the context lies on both sides; the frames before the anchor are missing": kept(
            range(0, 3 * k + 1, 3)
        ),
        "k frames on either side; one is missing at the end of each context": kept(
            range(-3 * k, 3 * k, 3)
        ),
        "that is the anchors alone; each needs its context, too": anchors,
        "the anchors themselves are missing": kept(s for s in steps if s),
    }
