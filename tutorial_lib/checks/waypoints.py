"""The check of the waypoint label in notebook 02."""

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.check import WrongAnswer, check, expect_close
from tutorial_lib.geometry import Array, to_local
from tutorial_lib.learning.labels import in_clear_sight
from tutorial_lib.viz import colours
from tutorial_lib.world.raycast import Raycaster

Sees = Callable[[Array, Array], NDArray[np.bool_]]
"""Which of points (C, 2) are in clear sight of a place (2,)."""


def waypoint_label(
    start: Array, track: Array, source: int, target: int, sees: Sees
) -> Array | None:
    """The farthest place of a drive in clear sight, seen from the start; None if there is none.

    Args:
        start: (3,) pose of the robot, beside frame `source`.
        track: (T, 3) poses of the drive.
        source: frame number.
        target: frame number; a target before the source is its own waypoint.
        sees: tells which points (C, 2) are in clear sight of a place (2,).
    """
    place = _chosen(start, track, source, target, sees)
    return None if place is None else to_local(start, place)


def clear_sight(caster: Raycaster) -> Sees:
    """What `waypoint_label` asks about the walls of a world."""

    def sees(origin: Array, points: Array) -> NDArray[np.bool_]:
        points = np.asarray(points, dtype=float)
        return in_clear_sight(caster, np.broadcast_to(origin[:2], points.shape), points)

    return sees


def _facing_ahead(points: list[tuple[float, float]], step: float = 0.1) -> Array:
    """A drive (T, 3) through corners, a frame every `step` metres."""
    corners = np.array(points, dtype=float)
    lengths = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    miles = np.concatenate([[0.0], np.cumsum(lengths)])
    places = np.arange(0.0, miles[-1] + step / 2, step)
    xy = [np.interp(places, miles, corners[:, axis]) for axis in (0, 1)]
    return np.stack([*xy, np.zeros(len(places))], axis=1)


_CORNER = _facing_ahead([(0, 0), (2, 0), (2, 2.4)])
_STRAIGHT = _facing_ahead([(0, 0), (4, 0)])
_ROUND = _facing_ahead([(0, 0), (3, 0), (3, 0.8), (1.5, 0.8)])
_FAR_WALL = [9.0, 9.0, 9.0, 10.0]
_LABEL_CASES = (
    ("round a corner", [[-1, 0.5, 1.5, 0.5]], [0.0, -0.1, 0.3], _CORNER, 0, 40),
    ("past a post", [[1, -0.36, 1, -0.24]], [0.0, -0.6, 0.2], _STRAIGHT, 0, 40),
    ("out and back", [_FAR_WALL], [0.0, 0.3, 0.0], _ROUND, 0, len(_ROUND) - 1),
    ("target behind", [[-1, 0.5, 1.5, 0.5]], [2.1, 1.5, 1.6], _CORNER, 35, 5),
    ("nothing in sight", [[0.25, -2, 0.25, 2]], [0.1, 0.0, 0.0], _STRAIGHT, 2, 30),
)


@check(
    waypoint_label,
    (np.zeros(3), _STRAIGHT, 0, 40, clear_sight(Raycaster([_FAR_WALL]))),
)
def check_waypoint_label(student: Callable[..., Any]) -> NDArray[np.uint8]:
    """Round a corner, past a post, out and back, a target behind, and nothing in sight."""
    walls, start, track = np.array(_LABEL_CASES[0][1], float), np.array(_LABEL_CASES[0][2]), _CORNER
    sees = clear_sight(Raycaster(walls))
    want, got = waypoint_label(start, track, 0, 40, sees), student(start, track, 0, 40, sees)
    picture = _labels_from_above(walls, start, track, want, got)
    for name, walls, start, track, source, target in _LABEL_CASES:
        sees, start = clear_sight(Raycaster(np.array(walls, float))), np.array(start)
        want = waypoint_label(start, track, source, target, sees)
        kept = start.copy(), track.copy()
        got = student(start, track, source, target, sees)
        if not (np.array_equal(start, kept[0]) and np.array_equal(track, kept[1])):
            raise WrongAnswer("your function changes its arguments; make a new array")
        what = f"waypoint_label, {name}"
        if want is None:
            if got is not None:
                raise WrongAnswer(f"{what}: there is no waypoint; return None", picture)
            continue
        mistakes = _mislabelled(start, track, source, target, sees)
        expect_close(what, got, want, 1e-6, mistakes, picture)
    return picture


def _mislabelled(
    start: Array, track: Array, source: int, target: int, sees: Sees
) -> dict[str, Array]:
    """Known mistakes, and the answers they give."""
    own, right = track[target, :2], _chosen(start, track, source, target, sees)
    mistakes = {
        "give it as seen from the start: to_local": right,
        "shifted, but not turned by the start's heading: to_local": right - start[:2],
    }
    if target <= source:
        places = track[target : source + 1, :2]
        seen = places[sees(start[:2], places)]
        return mistakes | {
            "a target behind is its own waypoint, in sight or not": to_local(start, seen[0]),
            "a target behind is its own waypoint; do not search the way back": to_local(
                start, seen[-1]
            ),
        }
    places = track[source + 1 : target + 1, :2]
    seen = sees(start[:2], places)
    first_hidden = len(seen) if seen.all() else int(seen.argmin())
    ranked = np.linalg.norm(places - start[:2], axis=1) * seen
    wrong = {
        "that is the target itself, but it is not in sight": own,
        "that is the nearest place in sight; take the farthest": places[seen.argmax()],
        "a place farther on is in sight again; do not stop at the first hidden one": places[
            max(first_hidden - 1, 0)
        ],
        "the last place along the drive counts, not the one at the greatest distance": places[
            ranked.argmax()
        ],
        "that is the first place that is hidden; take the last one in sight": places[
            min(first_hidden, len(places) - 1)
        ],
        "the target itself is a candidate too": places[
            np.flatnonzero(seen[:-1])[-1] if seen[:-1].any() else 0
        ],
    }
    local = {words: to_local(start, place) for words, place in wrong.items()}
    return mistakes | local


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
    """Wall, drive, start and label, target and yours beside each other."""
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
