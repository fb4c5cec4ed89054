"""Trajectories, walls and what can be seen, for the check of the waypoint label."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.check import WrongAnswer
from tutorial_lib.learning.labels import in_clear_sight
from tutorial_lib.se2 import Array, arc_length
from tutorial_lib.world.raycast import Raycaster

Sees = Callable[[Array, Array], NDArray[np.bool_]]
"""Which of points (C, 2) are in clear sight of a place (2,)."""
Case = tuple[Array, Array, int, int, Sees]
"""Start, trajectory, source, target, and what can be seen."""


def clear_sight(caster: Raycaster) -> Sees:
    """The line-of-sight test of `waypoint_label` among the walls of a world."""

    def sees(origin: Array, points: Array) -> NDArray[np.bool_]:
        points = np.asarray(points, dtype=float)
        return in_clear_sight(caster, np.broadcast_to(origin[:2], points.shape), points)

    return sees


def _strict(sees: Sees) -> Sees:
    """A line-of-sight test that explains what it takes."""

    def explained(place: Array, points: Array) -> NDArray[np.bool_]:
        if np.shape(place) != (2,):
            words = f"takes a place (2,) first, not an array {np.shape(place)}: start[:2]"
            raise WrongAnswer(f"waypoint_label: sees(place, points) {words}")
        if np.ndim(points) != 2 or np.shape(points)[1] != 2:
            words = f"takes points (C, 2), not an array {np.shape(points)}: track[..., :2]"
            raise WrongAnswer(f"waypoint_label: sees(place, points) {words}")
        return sees(place, points)

    return explained


def among(walls: list[list[float]]) -> Sees:
    """What can be seen among walls."""
    return _strict(clear_sight(Raycaster(np.array(walls, float))))


def only(track: Array, frames: list[int]) -> Sees:
    """As if these frames of a trajectory alone were in sight."""
    places = track[frames, :2].reshape(-1, 2)

    def sees(place: Array, points: Array) -> NDArray[np.bool_]:
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


CORNER = _facing_ahead([(0, 0), (2, 0), (2, 2.4)])
STRAIGHT = _facing_ahead([(0, 0), (4, 0)])
ROUND = _facing_ahead([(0, 0), (3, 0), (3, 0.8), (1.5, 0.8)])
LONG = _facing_ahead([(0, 0), (12, 0)])
FAR_WALL = [9.0, 9.0, 9.0, 10.0]
CORNER_WALL = [-1, 0.5, 1.5, 0.5]
POST = [1, -0.36, 1, -0.24]


def case(start: list[float], track: Array, source: int, target: int, sees: Sees) -> Case:
    """The arguments of a call."""
    return np.array(start), track, source, target, sees


def random_case(rng: np.random.Generator) -> Case:
    """A random trajectory, any two frames of it, and any frames in sight."""
    count = int(rng.integers(3, 30))
    track = np.column_stack([rng.uniform(-4, 4, (count, 2)), rng.uniform(-3, 3, count)])
    source, target = (int(i) for i in rng.integers(0, count, 2))
    frames = np.flatnonzero(rng.random(count) < rng.choice([0.1, 0.6])).tolist()
    return rng.uniform(-3, 3, 3), track, source, target, only(track, frames)
