"""Drives between the places of a building, recorded again and again (Meng 2020, Fig. 13)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from tutorial_lib.driving.data.demonstrations import demonstrate_between
from tutorial_lib.driving.data.perturbation import PAPER_PERTURBATION, perturbed
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.experiments.protocols.navigation_tasks import Building, long_enough
from tutorial_lib.experiments.protocols.odometry import RECORDING
from tutorial_lib.interfaces import Experience

_BETWEEN = 60.0  # seconds from one recorded trajectory to the next


def repeated_drives(
    building: Building, frames: int, at_once: int, rng: np.random.Generator
) -> Iterator[tuple[Experience, int]]:
    """Trajectories one after the other, each with the number of frames so far.

    Args:
        building: with the places.
        frames: that are wanted in all; the last trajectory may go beyond.
        at_once: trajectories recorded at a time.
        rng: chooses pairs and starts.
    """
    known, clock = 0, 0.0
    while known < frames:
        recorded = more_trajectories(building, at_once, rng, known)
        for index, trajectory in enumerate(recorded.trajectories):
            observations = recorded.observe(recorded.frames_of(index))
            known += len(trajectory)
            yield Experience(observations, clock + trajectory.timestamps), known
            clock += float(trajectory.timestamps[-1]) + _BETWEEN
            if known >= frames:
                return


def more_trajectories(
    building: Building, count: int, rng: np.random.Generator, frames: int
) -> RecordedWorld:
    """Record up to `count` more trajectories between the places, from perturbed starts.

    Their odometry drifts differently after each number of `frames` recorded before.
    """
    chosen = rng.integers(len(building.pairs), size=count)
    first = building.recorded.first_frames[chosen]
    poses = building.recorded.poses[first]
    starts, _ = perturbed(building.scene, poses, PAPER_PERTURBATION, rng)
    goals = building.places[building.pairs[chosen, 1]]
    odometry = replace(building.odometry, seed=(*building.odometry.seed, frames))
    made = demonstrate_between(
        building.name,
        building.scene,
        building.paths,
        starts,
        goals,
        0,
        odometry.noise(RECORDING),
    )
    return RecordedWorld(building.scene, [part for part in made if long_enough(part)])
