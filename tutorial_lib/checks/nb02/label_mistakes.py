"""The rule of the waypoint label, and its known mistakes."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.nb02.label_cases import Sees
from tutorial_lib.se2 import Array, to_local

Choice = Callable[[Array, Array, NDArray[np.bool_]], Array | None]


def waypoint_label(
    start: Array, track: Array, source: int, target: int, sees: Sees
) -> Array | None:
    """The farthest place in clear sight, in the frame of the start; None if there is none.

    Args:
        start: (3,) pose of the robot, beside frame `source`.
        track: (T, 3) poses of the trajectory.
        source: index of a frame.
        target: index of a frame; a target at or before the source is its own waypoint.
        sees: returns which points (C, 2) are in clear sight of a place (2,).
    """
    return _of(_last, start, track, source, target, sees)


def _last(track: Array, frames: Array, seen: NDArray[np.bool_]) -> Array | None:
    return track[frames[seen][-1], :2] if seen.any() else None


def _of(
    choose: Choice,
    start: Array,
    track: Array,
    source: int,
    target: int,
    sees: Sees,
    *,
    first: int = 1,
    beyond: int = 1,
    own: Callable[[int, int], bool] = lambda source, target: target <= source,
    shown: Callable[[Array, Array], Array] = to_local,
    seen_from: Callable[[Array, Array], Array] = lambda start, pose: start,
) -> Array | None:
    """The rule with another choice, other candidates or another frame."""
    if own(source, target):
        return shown(start, track[target, :2])
    frames = np.arange(source + first, min(target + beyond, len(track)))
    seen = sees(seen_from(start, track[source])[:2], track[frames, :2])
    place = choose(track, frames, np.asarray(seen, bool))
    return None if place is None else shown(start, place)


def _fault(choose: Choice = _last, **other: Any) -> Callable[..., Array | None]:  # noqa: ANN401
    return lambda *arguments: _of(choose, *arguments, **other)


def _or_target(track: Array, frames: Array, seen: NDArray[np.bool_]) -> Array:
    return track[frames[seen][-1] if seen.any() else frames[-1], :2]


def _before_hidden(track: Array, frames: Array, seen: NDArray[np.bool_]) -> Array | None:
    count = len(seen) if seen.all() else int(seen.argmin())
    return track[frames[max(count - 1, 0)], :2] if seen.any() else None


def _in_metres(start: Array, track: Array, source: int, target: int, sees: Sees) -> Array | None:
    """The candidate in sight at the greatest distance from the start."""

    def farthest_off(track: Array, frames: Array, seen: NDArray[np.bool_]) -> Array | None:
        gaps = np.linalg.norm(track[frames, :2] - start[:2], axis=1)
        return track[frames[(gaps * seen).argmax()], :2] if seen.any() else None

    return _of(farthest_off, start, track, source, target, sees)


def _nearest_to_target(
    start: Array, track: Array, source: int, target: int, sees: Sees
) -> Array | None:
    """The candidate in sight at the smallest distance from the target."""

    def nearest(track: Array, frames: Array, seen: NDArray[np.bool_]) -> Array | None:
        gaps = np.linalg.norm(track[frames, :2] - track[target, :2], axis=1)
        return track[frames[np.where(seen, gaps, np.inf).argmin()], :2] if seen.any() else None

    return _of(nearest, start, track, source, target, sees)


def _picked(pick: Callable[[Array, NDArray[np.bool_]], int]) -> Choice:
    """The place of a frame picked from the candidates' frames, if any is in sight."""
    return lambda track, frames, seen: track[pick(frames, seen), :2] if seen.any() else None


def _between(last: bool) -> Callable[..., Array | None]:
    """As if a target behind were searched for like one ahead."""

    def rule(start: Array, track: Array, source: int, target: int, sees: Sees) -> Array | None:
        if target > source:
            return waypoint_label(start, track, source, target, sees)
        frames = np.arange(target, source + 1)
        found = frames[sees(start[:2], track[frames, :2])]
        return to_local(start, track[found[-1 if last else 0], :2]) if len(found) else None

    return rule


def _behind(place: Callable[..., Array | None]) -> Callable[..., Array | None]:
    """Another answer (start, track, source, target, sees) where the target is not ahead."""
    return lambda start, track, source, target, sees: (
        waypoint_label(start, track, source, target, sees)
        if target > source
        else place(start, track, source, target, sees)
    )


def _right_turned(start: Array, place: Array) -> Array:
    return to_local(start, place) * [1, -1]


_FRAMES = {
    "it is in world coordinates; give it as seen from the start: to_local": lambda start, p: p,
    "shifted, but not turned by the start's heading: to_local": lambda start, p: p - start[:2],
    "turned the wrong way: to_local": lambda start, p: to_local(start * [1, 1, -1], p),
    "y points to the right here; it must be positive to the left: to_local": _right_turned,
}
BEHIND = "a target behind is its own waypoint, in sight or not"
FAULTS = {
    **{words: _fault(shown=shown) for words, shown in _FRAMES.items()},
    "as seen from the pose of frame `source`; it must be as seen from the start: to_local": (
        lambda start, track, source, target, sees: _of(
            _last, start, track, source, target, sees, shown=lambda _, p: to_local(track[source], p)
        )
    ),
    "that is the target itself, but it is not in sight": _fault(
        lambda track, frames, seen: track[frames[-1], :2]
    ),
    "with nothing in sight there is no waypoint: return None, not the target": _fault(_or_target),
    "take the last place in sight up to the target, not beyond the target": _fault(
        beyond=1_000_000
    ),
    "that is the nearest place in sight; take the farthest": _fault(
        _picked(lambda frames, seen: frames[seen][0])
    ),
    "that is the first place in sight, or the first of all; take the last in sight": _fault(
        lambda track, frames, seen: track[frames[seen.argmax()], :2]
    ),
    "a place farther on is in sight again; do not stop at the first hidden one": _fault(
        _before_hidden
    ),
    "that is the last place in sight but one; take the last": _fault(
        _picked(lambda frames, seen: frames[seen][-2 if seen.sum() > 1 else -1])
    ),
    "that is the last hidden place; take the last one in sight": _fault(
        _picked(lambda frames, seen: frames[-1] if seen.all() else frames[~seen][-1])
    ),
    "the last place along the trajectory counts, not the one nearest to the target in metres": (
        _nearest_to_target
    ),
    "the number of places in sight is no index: some before the last one may be hidden": _fault(
        _picked(lambda frames, seen: frames[seen.sum() - 1])
    ),
    "the last place along the trajectory counts, not the one at the greatest distance": _in_metres,
    "look from the start, not from the place of source: sees(start[:2], places)": _fault(
        seen_from=lambda start, pose: pose
    ),
    "the target itself is a candidate too": _fault(beyond=0),
    "one frame too early: index 0 of the candidates is frame source + 1": _fault(
        _picked(lambda frames, seen: frames[seen][-1] - 1)
    ),
    "the indices of the places in sight count from the first candidate, not from the start of "
    "the track: places[seen[-1]]": _fault(
        _picked(lambda frames, seen: frames[seen][-1] - frames[0])
    ),
    "that is the first place that is hidden; take the last one in sight": _fault(
        _picked(lambda frames, seen: frames[-1] if seen.all() else frames[seen.argmin()])
    ),
    "the place of source itself is no candidate; the first one is source + 1": _fault(first=0),
    "the first candidate is source + 1, not source + 2": _fault(first=2),
    "the place of source itself is no candidate, and a target at the source's own frame is its "
    "own waypoint: target <= source": _fault(first=0, own=lambda s, t: t < s),
    "a target at the source's own frame is its own waypoint too: target <= source": _fault(
        own=lambda s, t: t < s
    ),
    f"{BEHIND}; do not search the places in between": _between(last=False),
    f"{BEHIND}; do not take the nearest of the places in between": _between(last=True),
    f"{BEHIND}; yours gives None for it": _behind(lambda *_: None),
    f"{BEHIND}; yours looks whether it is in sight": _behind(
        lambda start, track, source, target, sees: (
            to_local(start, track[target, :2]) if sees(start[:2], track[[target], :2])[0] else None
        )
    ),
    f"{BEHIND}; yours gives the place of the source": _behind(
        lambda start, track, source, target, sees: to_local(start, track[source, :2])
    ),
}
