"""Odometry corrected by walls, around any agent that explores."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.track import Track
from tutorial_lib.errors import InputError
from tutorial_lib.exploration.goal_search import of_all
from tutorial_lib.interfaces import SequentialExplorer
from tutorial_lib.observation import Observation
from tutorial_lib.validation import with_methods


class ScanCorrected:
    """A `SequentialExplorer` whose explorer gets odometry that does not drift."""

    def __init__(self, explorer: SequentialExplorer) -> None:
        """Correct the odometry of `explorer`."""
        self._explorer = with_methods("explorer", explorer, "start", "look_for", "act")

    def start(self, goals: Observation) -> None:
        """Begin episodes towards `goals` (N,); forget all before."""
        self.tracks = [Track() for _ in range(len(goals))]
        self._explorer.start(goals)

    def look_for(self, goals: Observation) -> None:
        """Go on to other goals (N,)."""
        self._explorer.look_for(goals)

    def act(self, observations: Observation, running: NDArray[np.bool_]) -> NDArray:
        """Actions (N,) of all robots."""
        running = of_all(observations, running, len(self.tracks))
        if observations.depth is None:
            raise InputError("observations: panoramas without depth; use the rgbd sensor")
        poses = observations.odometry.copy()
        for number, track in enumerate(self.tracks):
            track.move(observations.odometry[number])
            if running[number] and track.is_due():
                track.correct(np.asarray(observations.depth[number], float))
            poses[number] = track.pose
        return self._explorer.act(replace(observations, odometry=poses), running)
