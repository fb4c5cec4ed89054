"""Fig. 13 of Meng 2020: how maps grow with the number of observations."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tutorial_lib.driving.data.demonstrations import demonstrate_between
from tutorial_lib.driving.data.perturbation import PAPER_PERTURBATION, perturbed
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.protocols.navigation_tasks import (
    PLACES,
    WORLDS,
    Building,
    long_enough,
    make_building,
)
from tutorial_lib.experiments.protocols.odometry import RECORDING
from tutorial_lib.interfaces import Experience
from tutorial_lib.parallel import for_each

_BETWEEN = 60.0  # seconds from one recorded trajectory to the next


@dataclass(frozen=True)
class Settings:
    """Settings of Fig. 13.

    Attributes:
        places: of a building.
        frames: observed in each world.
        interval: frames from one row to the next.
        at_once: trajectories recorded at a time.
    """

    places: int = PLACES
    frames: int = 100_000
    interval: int = 10_000
    at_once: int = 45


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Record trajectories from place to place for hours, and count vertices."""
    parts = for_each(run_world, options.worlds, options, settings, label="meng_fig13")
    rows = [row for part in parts for row in part]
    if options.quick:
        return rows, []
    size = {(row["world"], row["frames"]): row["vertices"] for row in rows}
    most, half = settings.frames, settings.frames // 2
    added = [size[world, most] / size[world, half] - 1 for world in options.worlds]
    note = (
        f"from {half:,} to {most:,} frames {np.mean(added):.1%} more vertices "
        f"({min(added):.1%} to {max(added):.1%} by world)"
    )
    return rows, [note]


def run_world(world: int, options: Options, settings: Settings) -> Rows:
    """The rows of one world."""
    building = make_building(world, options.seed, settings.places, drifts=options.drifts)
    rng = np.random.default_rng([options.seed, world, 5])
    agent, before, rows = agents.meng(), 0, []
    for experience, frames in repeated_drives(building, settings.frames, settings.at_once, rng):
        agent.learn([experience])
        next_row = (before // settings.interval + 1) * settings.interval
        due = range(next_row, min(frames, settings.frames) + 1, settings.interval)
        rows += [_row(world, count, agent) for count in due]
        before = frames
    return rows


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
    where, noise = (building.name, building.scene, building.paths), odometry.noise(RECORDING)
    made = demonstrate_between(*where, starts, goals, 0, noise)
    return RecordedWorld(building.scene, [part for part in made if long_enough(part)])


def _row(world: int, frames: int, agent: Any) -> dict[str, Any]:  # noqa: ANN401
    return {
        "world": world,
        "frames": frames,
        "vertices": len(agent.topomap),
        "edges": agent.topomap.graph.number_of_edges(),
        "every_10th": frames // 10,
        "every_20th": frames // 20,
    }


EXPERIMENT = Experiment(
    "meng_fig13",
    run,
    WORLDS,
    WORLDS[:2],
    Settings(),
    quick_settings=Settings(frames=20_000),
    canary=Settings(places=5, frames=4_000, interval=2_000),
    accepts=frozenset({"odometry"}),
)
