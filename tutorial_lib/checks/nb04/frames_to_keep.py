"""The check of the frames that anchors with their contexts need, in notebook 04."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import compare
from tutorial_lib.checks.nb04.forms import calling, frame_indices
from tutorial_lib.driving.data.recorded_world import frames_around
from tutorial_lib.viz.figures.follower_states import frames_kept
from tutorial_lib.viz.figures.panels import stacked


def frames_to_keep(anchors: ArrayLike, total: int, k: int) -> NDArray[np.intp]:
    """The frames, of a trajectory of `total`, that its anchors (A,) with their contexts need."""
    return np.unique(frames_around(np.asarray(anchors), k, 0, total - 1))


def _random(count: int) -> dict[str, tuple[NDArray[np.intp], int, int]]:
    """Trajectories of 2 to 60 frames with some anchors between the ends."""
    rng, cases = np.random.default_rng(6), {}
    for _ in range(count):
        total, k = int(rng.integers(2, 61)), int(rng.integers(0, 7))
        between = rng.choice(total, int(rng.integers(0, min(total, 7))), replace=False)
        anchors = np.unique([0, *between, total - 1])
        cases[f"anchors {anchors.tolist()} of {total} frames, k = {k}"] = anchors, total, k
    return cases


_CASES = {
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
_HINTS: dict[type[Exception], str] = {
    ValueError: "anchors[:, None] is a column, and with a row of offsets it makes a table",
    IndexError: "beyond an end of the trajectory there are no frames",
    TypeError: "anchors is an array of whole numbers, total and k are whole numbers",
    AttributeError: "anchors is an array; return an array or a list",
    NameError: "is it spelt right?",
}


@check(frames_to_keep, (np.arange(0, 400, 13), 400, 5))
def check_frames_to_keep(student: Callable[..., Any]) -> NDArray[np.uint8] | None:
    """Contexts that lie apart, that share frames, that reach beyond the ends, and 20 at random."""
    return compare(
        "frames_to_keep",
        student,
        _CASES,
        frames_to_keep,
        _FAULTS,
        invoke=calling(_HINTS),
        form=_form,
        difference=_difference,
        broken=_broken,
        draw=_drawn,
    )


def _form(what: str, got: Any, *_: object) -> NDArray[np.intp]:  # noqa: ANN401 - students'
    """Frames in rising order."""
    if isinstance(got, int | np.integer):
        raise WrongAnswer(f"{what}: return the indices of the frames, not how many there are")
    return np.sort(frame_indices(what, list(got) if isinstance(got, set) else got))


def _broken(
    got: NDArray[np.intp], want: NDArray[np.intp], anchors: NDArray[np.intp], total: int, k: int
) -> str:
    """Which part of the rule the wrong frames break."""
    if got.size and not (got.min() >= 0 and got.max() < total):
        return "the trajectory ends on both sides: a context that reaches beyond repeats the end"
    if np.setdiff1d(want, got).size:
        return "every anchor, also the first and the last, needs all frames of its context"
    return "only what a context holds is kept; the ends of the trajectory are no exception"


def _difference(
    got: NDArray[np.intp],
    want: NDArray[np.intp],
    anchors: NDArray[np.intp],
    total: int,
    k: int,
) -> str:
    """The first frame that is missing, or too many, and why."""
    if len(set(got.tolist())) < len(got):
        twice = got[np.flatnonzero(np.diff(got) == 0)[0]]
        return f"frame {twice} comes twice; each frame is kept once"
    for frame in np.setdiff1d(want, got).tolist():
        steps = range(-k, k + 1)
        found = (
            (a, s) for a in anchors for s in steps if np.clip(a + 3 * s, 0, total - 1) == frame
        )
        anchor, step = min(found, key=lambda pair: abs(pair[1]))
        return f"frame {frame} is missing: anchor {anchor} {3 * step:+d} needs it"
    extra = np.setdiff1d(got, want)[0]
    words = f"from {-k} to {k} times 3 frames away, and from 0 to {total - 1}"
    return f"frame {extra} is too many; no anchor needs it: the frames of a context are {words}"


def _drawn(want: NDArray[np.intp], got: NDArray[np.intp]) -> NDArray[np.uint8]:
    anchors, total, _ = next(iter(_CASES.values()))
    shown = [frame for frame in got.tolist() if 0 <= frame < total]
    return _rows(total, anchors.tolist(), want, np.array(shown, dtype=int))


def _rows(
    total: int, anchors: Sequence[int], want: NDArray[np.intp], got: NDArray[np.intp]
) -> NDArray[np.uint8]:
    rows = [frames_kept(total, frames.tolist(), anchors) for frames in (want, got)]
    return stacked(rows, ["target", "yours"], gap=4)


def _kept(offsets: Callable[[int], Iterable[int]]) -> Callable[..., NDArray[np.intp]]:
    """The rule with other frames in a context of k."""

    def fault(anchors: NDArray[np.intp], total: int, k: int) -> NDArray[np.intp]:
        return np.unique(np.clip(_around(anchors, offsets(k)), 0, total - 1))

    return fault


def _around(anchors: NDArray[np.intp], offsets: Iterable[int]) -> NDArray[np.intp]:
    return (anchors[:, None] + np.array(list(offsets), dtype=int)).ravel()


def _steps(k: int) -> range:
    return range(-3 * k, 3 * k + 1, 3)


_FAULTS: dict[str, Callable[..., NDArray[np.intp]]] = {
    "a frame that two contexts share is kept once: np.unique": lambda a, n, k: np.clip(
        _around(a, _steps(k)), 0, n - 1
    ),
    "there are no frames before 0 or after the last; there the context repeats the first or last "
    "frame": lambda a, n, k: np.unique(_around(a, _steps(k))),
    "a frame before 0 is no frame from the end; np.clip keeps it within the trajectory": (
        lambda a, n, k: np.unique(_around(a, _steps(k)) % n)
    ),
    "the last frame is total - 1, not total": lambda a, n, k: np.unique(
        np.clip(_around(a, _steps(k)), 0, n)
    ),
    "the frames of a context are 3 frames apart": _kept(lambda k: range(-k, k + 1)),
    "only every third frame of a context is needed": _kept(lambda k: range(-3 * k, 3 * k + 1)),
    "the context lies on both sides; the frames after the anchor are missing": _kept(
        lambda k: range(-3 * k, 1, 3)
    ),
    "the context lies on both sides; the frames before the anchor are missing": _kept(
        lambda k: range(0, 3 * k + 1, 3)
    ),
    "k frames on either side; one is missing at the end of each context": _kept(
        lambda k: range(-3 * k, 3 * k, 3)
    ),
    "k frames on either side, not k + 1": _kept(lambda k: range(-3 * k - 3, 3 * k + 4, 3)),
    "a context that reaches beyond an end needs the frame there, which need not be an anchor": (
        lambda a, n, k: np.unique([f for f in _around(a, _steps(k)) if 0 <= f < n])
    ),
    "the trajectory ends at total - 1, not at the last anchor": lambda a, n, k: np.unique(
        np.clip(_around(a, _steps(k)), 0, a[-1])
    ),
    "the trajectory runs from frame 0 to total - 1, not from the first anchor to the last": (
        lambda a, n, k: np.unique(np.clip(_around(a, _steps(k)), a[0], a[-1]))
    ),
    "the trajectory begins at frame 0, not at the first anchor": lambda a, n, k: np.unique(
        np.clip(_around(a, _steps(k)), a[0], n - 1)
    ),
    "the frames of a context are 3 apart, whatever k is": _kept(
        lambda k: [k * s for s in range(-k, k + 1)]
    ),
    "k may be 0; then the anchors themselves are kept": lambda a, n, k: frames_to_keep(a, n, k)[
        : None if k else 0
    ],
    "k is an argument; yours has k = 2 written into it": _kept(lambda k: _steps(2)),
    "that is the anchors alone; each needs its context, too": lambda a, n, k: a,
    "the anchors themselves are missing": _kept(lambda k: [s for s in _steps(k) if s]),
    "only the contexts' outermost frames; those between are needed, too": _kept(
        lambda k: [-3 * k, 0, 3 * k]
    ),
}
