"""The check of the waypoint label, in notebook 02."""

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import expect_close
from tutorial_lib.geometry import Array, arc_length, to_local
from tutorial_lib.learning.labels import in_clear_sight
from tutorial_lib.viz.canvas import colours
from tutorial_lib.world.raycast import Raycaster

Sees = Callable[[Array, Array], NDArray[np.bool_]]
"""Which of points (C, 2) are in clear sight of a place (2,)."""


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
    place = _chosen(start, track, source, target, sees)
    return None if place is None else to_local(start, place)


def clear_sight(caster: Raycaster) -> Sees:
    """The line-of-sight test of `waypoint_label` among the walls of a world."""

    def sees(origin: Array, points: Array) -> NDArray[np.bool_]:
        points = np.asarray(points, dtype=float)
        return in_clear_sight(caster, np.broadcast_to(origin[:2], points.shape), points)

    return sees


def _facing_ahead(points: list[tuple[float, float]], step: float = 0.1) -> Array:
    """A trajectory (T, 3) through corners, a frame every `step` metres."""
    corners = np.array(points, dtype=float)
    miles = arc_length(corners)
    places = np.arange(0.0, miles[-1] + step / 2, step)
    xy = [np.interp(places, miles, corners[:, axis]) for axis in (0, 1)]
    return np.stack([*xy, np.zeros(len(places))], axis=1)


_CORNER = _facing_ahead([(0, 0), (2, 0), (2, 2.4)])
_STRAIGHT = _facing_ahead([(0, 0), (4, 0)])
_ROUND = _facing_ahead([(0, 0), (3, 0), (3, 0.8), (1.5, 0.8)])
_FAR_WALL = [9.0, 9.0, 9.0, 10.0]
_CORNER_WALL = [-1, 0.5, 1.5, 0.5]
_CASES = (
    ("round a corner", [_CORNER_WALL], [1.0, -0.2, 0.3], _CORNER, 10, 40),
    ("past a post", [[1, -0.36, 1, -0.24]], [0.0, -0.6, 0.2], _STRAIGHT, 0, 40),
    ("out and back", [_FAR_WALL], [0.0, 0.3, 0.0], _ROUND, 0, len(_ROUND) - 1),
    ("a trajectory that goes on", [_FAR_WALL], [0.5, 0.2, 0.1], _STRAIGHT, 5, 20),
    ("target behind, in sight", [_CORNER_WALL], [2.1, 1.5, 1.6], _CORNER, 35, 25),
    ("target behind, hidden", [_CORNER_WALL], [2.1, 1.5, 1.6], _CORNER, 35, 5),
    ("target at the source", [_CORNER_WALL], [0.9, 0.2, -0.4], _CORNER, 10, 10),
    ("nothing in sight", [[0.25, -2, 0.25, 2]], [0.1, 0.0, 0.0], _STRAIGHT, 2, 30),
)


@check(
    waypoint_label,
    (np.zeros(3), _STRAIGHT, 0, 40, clear_sight(Raycaster([_FAR_WALL]))),
)
def check_waypoint_label(student: Callable[..., Any]) -> NDArray[np.uint8]:
    """Round a corner, past a post, out and back, targets ahead and behind, nothing in sight."""
    _, walls, start, track, *frames = _CASES[0]
    walls, start = np.array(walls, float), np.array(start)
    arguments = (start, track, *frames, clear_sight(Raycaster(walls)))
    picture = _labels_from_above(
        walls, start, track, waypoint_label(*arguments), student(*arguments)
    )
    for name, walls, start, track, *frames in _CASES:
        sees, start = clear_sight(Raycaster(np.array(walls, float))), np.array(start)
        arguments, kept = (start, track, *frames, sees), (start.copy(), track.copy())
        want, what = waypoint_label(*arguments), f"waypoint_label, {name}"
        try:
            got = student(*arguments)
        except (IndexError, ValueError):  # of an empty choice
            if want is not None and frames[1] > frames[0]:
                raise
            got = None
            if want is None:
                words = "nothing is in sight, so there is no last place; return None"
                raise WrongAnswer(f"{what}: {words}", picture) from None
        if not (np.array_equal(start, kept[0]) and np.array_equal(track, kept[1])):
            raise WrongAnswer("your function changes its arguments; make a new array")
        if want is None:
            _expect_none(what, got, to_local(start, track[frames[0], :2]), picture)
            continue
        if got is None and frames[1] <= frames[0]:
            raise WrongAnswer(f"{what}: {_BEHIND if frames[1] < frames[0] else _THERE}", picture)
        expect_close(what, got, want, 1e-6, _mistakes(*arguments), picture)
    return picture


_BEHIND = "a target behind is its own waypoint, in sight or not"
_THERE = "a target at the source's own frame is its own waypoint too: target <= source"


def _expect_none(what: str, got: object, own: Array, picture: NDArray[np.uint8]) -> None:
    """Demand that there is no waypoint; `own` is the source's place, seen from the start."""
    if got is None:
        return
    words = "there is no waypoint; return None"
    if np.shape(got) == (2,) and np.allclose(got, own, atol=1e-6):
        words = "the place of source itself is no candidate; the first one is source + 1"
    raise WrongAnswer(f"{what}: {words}", picture)


def _mistakes(start: Array, track: Array, source: int, target: int, sees: Sees) -> dict[str, Array]:
    """Known mistakes, and the answers they give."""
    right = _chosen(start, track, source, target, sees)
    mistakes = {
        "give it as seen from the start: to_local": right,
        "shifted, but not turned by the start's heading: to_local": right - start[:2],
    }
    if target <= source:
        places = track[target : source + 1, :2]
        seen = np.flatnonzero(sees(start[:2], places))
        wrong = {}
        if len(seen):
            wrong[f"{_BEHIND}; do not search the places in between"] = places[seen[0]]
            wrong[f"{_BEHIND}; do not take the nearest of the places in between"] = places[seen[-1]]
    else:
        wrong = _misplaced(start, track, source, target, sees)
    for words, place in wrong.items():
        mistakes[words] = to_local(start, place)
    for words, place in wrong.items():
        mistakes[f"{words}; and give it as seen from the start: to_local"] = place
    return mistakes


def _misplaced(
    start: Array, track: Array, source: int, target: int, sees: Sees
) -> dict[str, Array]:
    """Known mistakes with a target ahead, and the places (2,) that they choose."""
    places, after = track[source + 1 : target + 1, :2], track[source + 1 :, :2]
    seen = sees(start[:2], places)
    last = np.flatnonzero(seen)[-1]
    from_source = np.flatnonzero(sees(track[source, :2], places))
    first_hidden = len(seen) if seen.all() else int(seen.argmin())
    ranked = np.linalg.norm(places - start[:2], axis=1) * seen
    before = np.flatnonzero(seen[:-1])
    return {
        "that is the target itself, but it is not in sight": track[target, :2],
        "take the last place in sight up to the target, not beyond the target": after[
            np.flatnonzero(sees(start[:2], after))[-1]
        ],
        "that is the nearest place in sight; take the farthest": places[seen.argmax()],
        "a place farther on is in sight again; do not stop at the first hidden one": places[
            max(first_hidden - 1, 0)
        ],
        "the last place along the trajectory counts, not the one at the greatest distance": places[
            ranked.argmax()
        ],
        "look from the start, not from the place of source: sees(start[:2], places)": places[
            from_source[-1] if len(from_source) else 0
        ],
        "the target itself is a candidate too": places[before[-1] if len(before) else 0],
        "one frame too early: index 0 of the candidates is frame source + 1": track[
            source + last, :2
        ],
        "the indices of the places in sight count from the first candidate, not from the start of "
        "the track: places[seen[-1]]": track[last, :2],
        "that is the first place that is hidden; take the last one in sight": places[
            min(first_hidden, len(places) - 1)
        ],
    }


def _chosen(start: Array, track: Array, source: int, target: int, sees: Sees) -> Array | None:
    """The right place (2,), in the world."""
    if target <= source:
        return track[target, :2]
    places = track[source + 1 : target + 1, :2]
    seen = np.flatnonzero(sees(start[:2], places))
    return places[seen[-1]] if len(seen) else None


def _labels_from_above(
    walls: Array, start: Array, track: Array, want: Array | None, got: object
) -> NDArray[np.uint8]:
    """Wall, trajectory, start and label, target and yours beside each other."""
    blocks = []
    for name, label in (("target", want), ("yours", got)):
        block = np.full((300, 330, 3), 255, np.uint8)

        def at(point: Array) -> tuple[int, int]:
            return round(60 + 100 * point[0]), round(270 - 100 * point[1])

        for wall in walls:
            cv2.line(block, at(wall[:2]), at(wall[2:]), colours.SOLID, 6, cv2.LINE_AA)
        for place in track[::2]:
            cv2.circle(block, at(place), 3, colours.PATH, -1, cv2.LINE_AA)
        cv2.circle(block, at(start), 8, colours.ROBOT, -1, cv2.LINE_AA)
        point = np.asarray(label, dtype=float) if label is not None else np.full(2, np.nan)
        if point.shape == (2,) and np.isfinite(point).all() and np.abs(point).max() < 10:
            turn = start[2] + np.arctan2(point[1], point[0])
            end = start[:2] + np.hypot(*point) * np.array([np.cos(turn), np.sin(turn)])
            cv2.line(block, at(start), at(end), colours.GOAL, 2, cv2.LINE_AA)
            cv2.circle(block, at(end), 7, colours.GOAL, -1, cv2.LINE_AA)
        cv2.putText(block, name, (8, 20), cv2.FONT_HERSHEY_SIMPLEX, 0.55, colours.INK, 1, 16)
        blocks.append(block)
    return np.concatenate(blocks, axis=1)
