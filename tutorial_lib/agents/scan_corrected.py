"""Odometry corrected by walls, around any agent that explores."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.walls import match_near
from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import SequentialExplorer
from tutorial_lib.observation import Observation
from tutorial_lib.se2 import Array, compose, relative, wrap
from tutorial_lib.validation import with_methods

_MOVED, _TURNED = 0.5, float(np.deg2rad(40.0))  # since the last match, from which walls are asked
_APART = 1.0  # metres from the nearest panorama that is kept, beyond which another one is
_ASKED, _SIGHT = 3, 2.5  # panoramas that are asked at most, and metres up to which they are


@dataclass(eq=False)
class _Track:
    """One robot: its corrected pose, and panoramas along its path."""

    pose: Array = field(default_factory=lambda: np.zeros(3))
    odometry: Array = field(default_factory=lambda: np.zeros(3))
    matched: Array = field(default_factory=lambda: np.full(3, np.inf))
    places: list[Array] = field(default_factory=list)
    ranges: list[Array] = field(default_factory=list)


class ScanCorrected:
    """A `SequentialExplorer` whose explorer gets odometry that does not drift.

    Panoramas are kept along the path. Wherever the robot comes back to one, its walls say where it
    is.
    """

    def __init__(self, explorer: SequentialExplorer) -> None:
        """Correct the odometry of `explorer`."""
        self._explorer = with_methods("explorer", explorer, "start", "look_for", "act")

    def start(self, goals: Observation) -> None:
        """Begin episodes towards `goals` (N,); forget all before."""
        self._tracks = [_Track() for _ in range(len(goals))]
        self._explorer.start(goals)

    def look_for(self, goals: Observation) -> None:
        """Go on to other goals (N,)."""
        self._explorer.look_for(goals)

    def act(self, observations: Observation, running: NDArray[np.bool_]) -> NDArray:
        """Actions (N,) of all robots."""
        if observations.depth is None:
            raise InputError("observations: panoramas without depth; use the rgbd sensor")
        poses = observations.odometry.copy()
        for number in np.flatnonzero(running):
            ranges = np.asarray(observations.depth[number], float)
            poses[number] = self._corrected(self._tracks[number], poses[number], ranges)
        return self._explorer.act(replace(observations, odometry=poses), running)

    def _corrected(self, track: _Track, odometry: Array, ranges: Array) -> Array:
        """The pose (3,) of a robot, by odometry since the last match."""
        track.pose = compose(track.pose, relative(track.odometry, odometry))
        track.odometry = odometry.copy()  # the caller writes into its rows
        gap = track.pose - track.matched
        if np.linalg.norm(gap[:2]) < _MOVED and abs(wrap(gap[2])) < _TURNED:
            return track.pose
        places = np.array(track.places).reshape(-1, 3)
        metres = np.linalg.norm(places[:, :2] - track.pose[:2], axis=1)
        near = np.argsort(metres, kind="stable")[:_ASKED]
        near = near[metres[near] < _SIGHT]
        if len(near):
            around = np.repeat(ranges[None], len(near), axis=0)
            kept = np.stack([track.ranges[place] for place in near.tolist()])
            poses = match_near(kept, around, relative(places[near], track.pose))
            found = np.flatnonzero(np.isfinite(poses[:, 0]))
            if len(found):
                track.pose = compose(places[near[found[0]]], poses[found[0]])
        track.matched = track.pose
        if not (metres < _APART).any():
            track.places.append(track.pose)
            track.ranges.append(ranges)
        return track.pose
