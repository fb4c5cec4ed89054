"""Labels from a trajectory (Meng 2020, III-B, IV): waypoint, heading difference, overlap.

A pair is a start beside a recorded trajectory, and a frame of that trajectory as target.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.se2 import Array, relative, to_local
from tutorial_lib.validation import alike, floats, instance, integers
from tutorial_lib.world.raycast import Raycaster
from tutorial_lib.world.visibility import FIELD_OF_VIEW, mutual_overlap

CLEARANCE = 0.06
"""Metres that the line to a waypoint keeps from every wall."""
CANDIDATES = 16
"""Places on the trajectory that are tried as waypoints."""


def waypoint_labels(
    caster: Raycaster, starts: Array, track: Array, sources: NDArray, targets: NDArray
) -> tuple[Array, NDArray[np.bool_]]:
    """The farthest place on the trajectory that a free straight line leads to.

    The authors of Meng 2020 take the farthest such place on A*'s path.

    Args:
        caster: the walls.
        starts: (N, 3) where the robots are, beside frames `sources` of the trajectory.
        track: (T, 3) poses of the trajectory.
        sources: (N,) frames.
        targets: (N,) frames; a target before its source is its own waypoint.

    Returns:
        (N, 2) waypoints in the frames of `starts`, and (N,) whether there is one.
    """
    instance("caster", caster, Raycaster)
    starts, track = floats("starts", starts, ("N", 3)), floats("track", track, ("T", 3))
    sources = integers("sources", sources, ("N",), least=0, most=len(track) - 1)
    targets = integers("targets", targets, ("N",), least=0, most=len(track) - 1)
    alike(starts=starts, sources=sources, targets=targets)
    share = np.linspace(0.0, 1.0, CANDIDATES + 1)[1:]
    ahead = (targets > sources)[:, None]
    frames = np.rint(sources[:, None] + share * (targets - sources)[:, None]).astype(int)
    places = track[np.where(ahead, frames, targets[:, None]), :2]
    seen = in_clear_sight(caster, np.repeat(starts[:, None, :2], CANDIDATES, axis=1), places)
    seen |= ~ahead
    farthest = CANDIDATES - 1 - seen[:, ::-1].argmax(axis=1)
    chosen = places[np.arange(len(starts)), farthest]
    return to_local(starts, chosen), np.any(seen, axis=1)


def in_clear_sight(caster: Raycaster, origins: Array, points: Array) -> NDArray[np.bool_]:
    """Whether a robot at `origins` (..., 2) sees `points` (..., 2), `CLEARANCE` off the walls."""
    points = floats("points", points, (..., 2))
    origins = floats("origins", origins, (..., 2))
    instance("caster", caster, Raycaster)
    if origins.shape != points.shape:
        raise InputError(f"origins: {origins.shape}, points: {points.shape}; give as many of each")
    along = points - origins
    length = np.maximum(np.linalg.norm(along, axis=-1, keepdims=True), 1e-9)
    aside = CLEARANCE * np.stack([-along[..., 1], along[..., 0]], axis=-1) / length
    seen = np.ones(points.shape[:-1], dtype=bool)
    for side in (0.0, 1.0, -1.0):
        start, end = origins + side * aside, points + side * aside
        seen &= caster.sees(start.reshape(-1, 2), end.reshape(-1, 2)).reshape(seen.shape)
    return seen


@dataclass(frozen=True)
class Labels:
    """Labels of N pairs.

    Attributes:
        waypoint: (N, 2) metres, in the frame of the start.
        heading: (N,) rad, of the target as seen from the start.
        overlap: (N, 2) share of the current image in the target's, and vice versa.
    """

    waypoint: Array
    heading: Array
    overlap: Array


def label(
    caster: Raycaster,
    starts: Array,
    goals: Array,
    waypoints: Array,
    field_of_view: float = FIELD_OF_VIEW,
) -> Labels:
    """All labels of pairs: `starts` (N, 3), target poses `goals` (N, 3), `waypoints` (N, 2).

    Views overlap as those of a camera do whose `field_of_view` is so many radians.
    """
    starts, goals = floats("starts", starts, ("N", 3)), floats("goals", goals, ("N", 3))
    waypoints = floats("waypoints", waypoints, ("N", 2))
    alike(starts=starts, goals=goals, waypoints=waypoints)
    overlap = mutual_overlap(caster, starts, goals, field_of_view)
    return Labels(waypoints, relative(starts, goals)[:, 2], overlap)
