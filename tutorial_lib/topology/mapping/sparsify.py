"""Which observations of a dense trajectory to keep (Meng 2020, III-D)."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.driving.data.recorded_world import frames_around
from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import Observation, Reachability
from tutorial_lib.topology.query import check_seen, query
from tutorial_lib.validation import batch, integers, number, whole, with_methods

_MOST_CONTEXT = 1_000  # images on either side, more than any network takes
_MOST_FRAMES = 10**9


def sparsify(
    reachability: Reachability,
    observations: Observation,
    prepared: Any,  # noqa: ANN401 - whatever the estimator made
    threshold: float,
    window: int = 32,
) -> NDArray[np.intp]:
    """Keep as few frames as the controller needs (Meng 2020, III-D).

    From anchor i the next one is the largest j such that RE(o_i, o_k) > `threshold` for every k in
    (i, j]. Where not even i + 1 is above the threshold, it is kept all the same.

    Args:
        reachability: RE.
        observations: T frames of the trajectory, in order.
        prepared: the same frames as targets, T of them, from `reachability.prepare`; anything that
            an array of indices selects from.
        threshold: p_sparsify; the higher it is, the more frames are kept.
        window: frames queried in one call, which changes only the running time.

    Returns:
        (A,) indices of the anchors, rising; the first frame and the last are always among them.

    Raises:
        InputError: when there are fewer than two frames, not as many targets, a threshold or window
            makes no sense, or `reachability` returns no probabilities.
    """
    with_methods("reachability", reachability, "probability")
    check_seen(observations)
    frames = len(observations)
    _check_frames(frames)
    if len(batch("prepared", prepared)) != frames:
        raise InputError(
            f"sparsify: {len(prepared)} prepared targets for {frames} observations; prepare every "
            "frame of this trajectory"
        )
    if not 0.0 < number("threshold", threshold) < 1.0:
        raise InputError(f"sparsify: threshold {threshold}; give a probability between 0 and 1")
    whole("window", window, least=1)
    anchors = [0]
    while anchors[-1] < frames - 1:
        here = farthest = anchors[-1]
        all_hold = True
        while all_hold and farthest < frames - 1:
            ahead = np.arange(farthest + 1, min(farthest + window, frames - 1) + 1)
            repeated = observations[np.full(len(ahead), here)]
            holds = query(reachability, repeated, prepared[ahead]) > threshold
            all_hold = bool(holds.all())
            farthest += len(ahead) if all_hold else int(holds.argmin())
        anchors.append(max(farthest, here + 1))
    return np.array(anchors)


def every_nth(frames: int, n: int) -> NDArray[np.intp]:
    """Keep every n-th of so many frames, as SPTM does, and the last one.

    Raises:
        InputError: when there are fewer than two frames, or n is not positive.

    >>> every_nth(8, 3).tolist()
    [0, 3, 6, 7]
    """
    _check_frames(whole("frames", frames, most=_MOST_FRAMES))
    whole("n", n, least=1)
    return np.append(np.arange(0, frames - 1, n), frames - 1)


def contextified(images: NDArray, k: int) -> NDArray:
    """Every frame of a trajectory with its context, as a target (Meng 2020, III-B).

    Args:
        images: (T, ...) of one trajectory.
        k: images on either side, `CONTEXT_INTERVAL` frames apart.

    Returns:
        (T, 2k+1, ...); beyond either end the first or last image is repeated.

    Raises:
        InputError: when there is no image, or k is negative.
    """
    images = np.asarray(images)
    if images.dtype.kind not in "biuf" or not images.ndim:
        raise InputError("images: not numbers (T, ...); give the images of a trajectory")
    if not len(images):
        raise InputError("images: there are none; give those of a trajectory (T, ...)")
    _check_context(k)
    last = len(images) - 1
    return images[frames_around(np.arange(len(images)), k, 0, last)]


def stored_frames(anchors: ArrayLike, frames: int, k: int) -> int:
    """How many frames of a trajectory must be kept for its anchors with their contexts.

    Args:
        anchors: (A,) frames.
        frames: T, of the whole trajectory.
        k: see `contextified`.

    Raises:
        InputError: when an anchor is no frame, or k is negative.

    >>> stored_frames([0, 10], 12, 2)  # 0, 3, 6 and 4, 7, 10, 11
    7
    """
    whole("frames", frames, least=1, most=_MOST_FRAMES)
    anchors = integers("anchors", anchors, ("A",), least=0, most=frames - 1)
    _check_context(k)
    return len(np.unique(frames_around(anchors, k, 0, frames - 1)))


def _check_frames(frames: int) -> None:
    if frames < 2:
        raise InputError(f"trajectory: {frames} frames; give two at least, a start and an end")


def _check_context(k: int) -> None:
    whole("k", k, least=0, most=_MOST_CONTEXT)
