"""The check of the waypoint label, in notebook 02."""

from collections.abc import Callable, Sequence
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.engine import (
    Mask,
    WrongAnswer,
    close,
    exercise,
    farthest,
    hint,
    numbers,
    topics,
)
from tutorial_lib.learning.labels import in_clear_sight
from tutorial_lib.se2 import Array, arc_length, to_local
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.labels import label as label_on
from tutorial_lib.world.raycast import Raycaster

Sees = Callable[[Array, Array], Mask]
"""Which of points (C, 2) are in clear sight of a place (2,)."""


def waypoint_label(
    start: Array, track: Array, source: int, target: int, sees: Sees
) -> Array | None:
    """The farthest place in clear sight, in the frame of the start; None if there is none."""
    if target <= source:
        place = track[target, :2]
    else:
        frames = np.arange(source + 1, target + 1)
        seen = np.asarray(sees(start[:2], track[frames, :2]), bool)
        place = track[frames[seen][-1], :2] if seen.any() else None
    return None if place is None else to_local(start, place)


def clear_sight(caster: Raycaster) -> Sees:
    """The line-of-sight test of `waypoint_label` among the walls of a world."""

    def sees(origin: Array, points: Array) -> Mask:
        points = np.asarray(points, dtype=float)
        return in_clear_sight(caster, np.broadcast_to(origin[:2], points.shape), points)

    return sees


def _strict(sees: Sees) -> Sees:
    """A line-of-sight test that explains what it takes."""

    def explained(place: Array, points: Array) -> Mask:
        words = ""
        if np.shape(place) != (2,):
            words = f"takes a place (2,) first, not an array {np.shape(place)}: start[:2]"
        elif np.ndim(points) != 2 or np.shape(points)[1] != 2:
            words = f"takes points (C, 2), not an array {np.shape(points)}: track[..., :2]"
        if words:
            raise WrongAnswer(f"waypoint_label: sees(place, points) {words}")
        return sees(place, points)

    return explained


def _among(walls: list[list[float]]) -> Sees:
    """What can be seen among walls."""
    return _strict(clear_sight(Raycaster(np.array(walls, float))))


def _only(track: Array, frames: list[int]) -> Sees:
    """As if these frames of a trajectory alone were in sight."""
    places = track[frames, :2].reshape(-1, 2)

    def sees(place: Array, points: Array) -> Mask:
        gaps = np.linalg.norm(np.asarray(points)[:, None] - places, axis=2)
        return (gaps < 1e-9).any(axis=1)

    return _strict(sees)


def _facing_ahead(points: list[tuple[float, float]]) -> Array:
    """A trajectory (T, 3) through corners, a frame every 0.1 m."""
    corners = np.array(points, dtype=float)
    miles = arc_length(corners)
    places = np.arange(0.0, miles[-1] + 0.05, 0.1)
    xy = [np.interp(places, miles, corners[:, axis]) for axis in (0, 1)]
    return np.stack([*xy, np.zeros(len(places))], axis=1)


_CORNER = _facing_ahead([(0, 0), (2, 0), (2, 2.4)])
_STRAIGHT = _facing_ahead([(0, 0), (4, 0)])
_ROUND = _facing_ahead([(0, 0), (3, 0), (3, 0.8), (1.5, 0.8)])
_LONG = _facing_ahead([(0, 0), (12, 0)])
_FAR_WALL = [9.0, 9.0, 9.0, 10.0]
_CORNER_WALL = [-1, 0.5, 1.5, 0.5]
_POST = [1, -0.36, 1, -0.24]


def _case(start: list[float], *others: Any) -> tuple[Any, ...]:  # noqa: ANN401
    """The arguments of a call: start, trajectory, source, target, and what can be seen."""
    return np.array(start), *others


def _random(rng: np.random.Generator) -> tuple[Any, ...]:
    """A random trajectory, any two frames of it, and any frames in sight."""
    count = int(rng.integers(3, 30))
    track = np.column_stack([rng.uniform(-4, 4, (count, 2)), rng.uniform(-3, 3, count)])
    source, target = (int(i) for i in rng.integers(0, count, 2))
    frames = np.flatnonzero(rng.random(count) < rng.choice([0.1, 0.6])).tolist()
    return rng.uniform(-3, 3, 3), track, source, target, _only(track, frames)


_RNG = np.random.default_rng(9)
_NONE = "nothing is in sight, so there is no last place; return None"
_BEHIND = "a target behind is its own waypoint, in sight or not"
TOPICS = {
    "round a corner": hint(
        "of frames source + 1 to target, take the last that is in sight, as seen from start",
        _case([1.0, -0.2, 0.3], _CORNER, 10, 40, _among([_CORNER_WALL])),
    ),
    "a target in sight": hint(
        "the target itself is a candidate: here it is the waypoint",
        _case([0.2, 0.1, 0.3], _CORNER, 2, 15, _among([_FAR_WALL])),
    ),
    "past a post": hint(
        "the last place in sight counts, also if a post hides some places before it",
        _case([0.0, -0.6, 0.2], _STRAIGHT, 0, 40, _among([_POST])),
    ),
    "out and back": hint(
        "the last place along the trajectory counts, whatever its distance in metres",
        _case([0.0, 0.3, 0.0], _ROUND, 0, len(_ROUND) - 1, _among([_FAR_WALL])),
    ),
    "a trajectory that goes on": hint(
        "nothing beyond the target is a candidate",
        _case([0.5, 0.2, 0.1], _STRAIGHT, 5, 20, _among([_FAR_WALL])),
    ),
    "a waypoint 12 m away": hint(
        "there is no largest distance: the farthest place in sight counts",
        _case([0.0, 0.2, 0.1], _LONG, 0, 120, _among([_FAR_WALL])),
    ),
    "only the first candidate in sight": hint(
        "the first candidate is frame source + 1",
        _case([0.5, 0.2, 0.1], _STRAIGHT, 5, 20, _only(_STRAIGHT, [6])),
    ),
    "a waypoint 3 cm away": hint(
        "there is no smallest distance: a place beside the car counts",
        _case([0.6, 0.03, 0.1], _STRAIGHT, 5, 20, _only(_STRAIGHT, [6])),
    ),
    "target behind, in sight": hint(
        _BEHIND, _case([2.1, 1.5, 1.6], _CORNER, 35, 25, _among([_CORNER_WALL]))
    ),
    "target behind, hidden": hint(
        _BEHIND, _case([2.1, 1.5, 1.6], _CORNER, 35, 5, _among([_CORNER_WALL]))
    ),
    "target at the source": hint(
        "a target at the source's own frame is its own waypoint too: target <= source",
        _case([0.9, 0.2, -0.4], _CORNER, 10, 10, _among([_CORNER_WALL])),
        _case([0.9, 0.2, -0.4], _CORNER, 10, 10, _only(_CORNER, [])),
    ),
    "nothing in sight": hint(
        _NONE, _case([0.1, 0.0, 0.0], _STRAIGHT, 2, 30, _among([[0.25, -2, 0.25, 2]]))
    ),
    "nothing in sight but the place of source, and places before it or after the target": hint(
        f"these are no candidates; {_NONE}",
        _case([0.1, 0.3, 0.0], _STRAIGHT, 9, 30, _only(_STRAIGHT, [9])),
        _case([0.1, 0.3, 0.0], _STRAIGHT, 9, 30, _only(_STRAIGHT, [3, 35])),
    ),
    "40 random trajectories": hint(
        "take the last frame in sight from source + 1 to target, whatever the distances; a "
        "target at or before source is its own waypoint",
        *(_random(_RNG) for _ in range(40)),
    ),
}
MISTAKES = """
it is in world coordinates; give it as seen from the start: to_local
    to_local(start, place) -> place
shifted, but not turned by the start's heading: to_local
    to_local(start, place) -> place - start[:2]
turned the wrong way: to_local
    to_local(start, place) -> to_local(start * [1, 1, -1], place)
y points to the right here; it must be positive to the left: to_local
    to_local(start, place) -> to_local(start, place) * [1, -1]
as seen from the pose of frame `source`; it must be as seen from the start: to_local
    to_local(start, place) -> to_local(track[source], place)
that is the target itself, but it is not in sight
    track[frames[seen][-1], :2] if seen.any() else None -> track[target, :2]
with nothing in sight there is no waypoint: return None, not the target
    if seen.any() else None -> if seen.any() else track[target, :2]
take the last place in sight up to the target, not beyond the target
    target + 1) -> len(track))
that is the nearest place in sight; take the farthest
    frames[seen][-1] -> frames[seen][0]
that is the first place in sight, or the first of all; take the last in sight
    frames[seen][-1], :2] if seen.any() else None -> frames[seen.argmax()], :2]
a place farther on is in sight again; do not stop at the first hidden one
    frames[seen][-1] -> frames[max((len(seen) if seen.all() else seen.argmin()) - 1, 0)]
that is the last place in sight but one; take the last
    frames[seen][-1] -> frames[seen][-2 if seen.sum() > 1 else -1]
that is the last hidden place; take the last one in sight
    frames[seen][-1] -> (frames if seen.all() else frames[~seen])[-1]
the last place along the trajectory counts, not the one nearest to the target in metres
    frames[seen][-1] -> min(frames[seen], key=lambda i: np.hypot(*(track[i] - track[target])[:2]))
the number of places in sight is no index: some before the last one may be hidden
    frames[seen][-1] -> frames[seen.sum() - 1]
the last place along the trajectory counts, not the one at the greatest distance
    frames[seen][-1] -> max(frames[seen], key=lambda i: np.hypot(*(track[i] - start)[:2]))
look from the start, not from the place of source: sees(start[:2], places)
    sees(start[:2] -> sees(track[source, :2]
the target itself is a candidate too
    target + 1) -> target)
one frame too early: index 0 of the candidates is frame source + 1
    frames[seen][-1] -> frames[seen][-1] - 1
the indices of the places in sight count from the first candidate, not from the start of
the track: places[seen[-1]]
    frames[seen][-1] -> frames[seen][-1] - frames[0]
that is the first place that is hidden; take the last one in sight
    frames[seen][-1] -> frames[-1 if seen.all() else seen.argmin()]
the place of source itself is no candidate; the first one is source + 1
    source + 1 -> source
source + 1 is a candidate, too, even if no other is in sight: yours gives None then. It begins
with source + 2, or takes index 0 for False
    source + 1 -> source + 2
the place of source itself is no candidate, and a target at the source's own frame is its
own waypoint: target <= source
    source + 1 -> source
    target <= source -> target < source
a target at the source's own frame is its own waypoint too: target <= source
    target <= source -> target < source
a target behind is its own waypoint, in sight or not; do not search the places in between
    place = track[target, :2] -> between = track[target : source + 1, :2]; place = FIRST
    FIRST -> next((place for place in between if sees(start[:2], place[None])[0]), None)
a target behind is its own waypoint, in sight or not; do not take the nearest of the places
in between
    place = track[target, :2] -> between = track[target : source + 1, :2][::-1]; place = FIRST
    FIRST -> next((place for place in between if sees(start[:2], place[None])[0]), None)
a target behind is its own waypoint, in sight or not; yours gives None for it
    place = track[target, :2] -> place = None
a target behind is its own waypoint, in sight or not; yours looks whether it is in sight
    place = track[target, :2]
        -> place = track[target, :2] if sees(start[:2], track[[target], :2])[0] else None
a target behind is its own waypoint, in sight or not; yours gives the place of the source
    place = track[target, :2] -> place = track[source, :2]
"""


def _form(what: str, answer: Any, *arguments: Any) -> Array | None:  # noqa: ANN401
    if answer is None:
        return None
    if isinstance(answer, int | np.integer):
        raise WrongAnswer(f"{what}: a frame's index came back; return its place, an array (2,)")
    if waypoint_label(*arguments) is None and np.shape(answer) != (2,):
        raise WrongAnswer(f"{what}: there is no waypoint; return None, no {type(answer).__name__}")
    return numbers(what, answer, (2,))


def _same(got: Array | None, want: Array | None, *_: object) -> bool:
    if got is None or want is None:
        return got is want
    return close(got, want)


def _difference(got: Array | None, want: Array | None, *_: object) -> str:
    if want is None:
        return (
            f"{np.asarray(got).round(2).tolist()} came back, but there is no waypoint; return None"
        )
    if got is None:
        return f"None came back, but {want.round(2).tolist()} is right"
    return farthest(got, want)


def _picture(student: Callable[..., Any]) -> NDArray[np.uint8]:
    """Wall, trajectory, start and both labels, from above."""
    arguments = start, track, *_ = TOPICS["round a corner"][1][0]
    blocks = []
    for name, function in (("expected", waypoint_label), ("yours", student)):
        label, block = function(*arguments), np.full((300, 330, 3), 255, np.uint8)

        def at(point: Sequence[float] | Array) -> tuple[int, int]:
            return round(60 + 100 * point[0]), round(270 - 100 * point[1])

        ends = at(_CORNER_WALL[:2]), at(_CORNER_WALL[2:])
        cv2.line(block, *ends, colours.SOLID, 6, cv2.LINE_AA)
        for place in track[::2]:
            cv2.circle(block, at(place), 3, colours.PATH, -1, cv2.LINE_AA)
        cv2.circle(block, at(start), 8, colours.ROBOT, -1, cv2.LINE_AA)
        point = np.asarray(label, dtype=float) if label is not None else np.full(2, np.nan)
        if point.shape == (2,) and np.isfinite(point).all() and np.abs(point).max() < 10:
            turn = start[2] + np.arctan2(point[1], point[0])
            end = start[:2] + np.hypot(*point) * np.array([np.cos(turn), np.sin(turn)])
            cv2.line(block, at(start), at(end), colours.GOAL, 2, cv2.LINE_AA)
            cv2.circle(block, at(end), 7, colours.GOAL, -1, cv2.LINE_AA)
        label_on(block, name, 8, 20)
        blocks.append(block)
    return np.concatenate(blocks, axis=1)


check_waypoint_label = exercise(
    waypoint_label,
    topics(TOPICS),
    MISTAKES,
    about="Round a corner, past a post, out and back, targets ahead and behind, nothing in sight.",
    example=(np.zeros(3), _STRAIGHT, 0, 40, clear_sight(Raycaster([_FAR_WALL]))),
    form=_form,
    same=_same,
    difference=_difference,
    draw=_picture,
)
