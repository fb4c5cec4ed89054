"""Fig. 13 of Meng 2020: how maps run_world with what was observed."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from tutorial_lib.driving.data.demonstrations import demonstrate_between
from tutorial_lib.driving.data.perturbation import PAPER_PERTURBATION, perturbed
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.report import Options, Report
from tutorial_lib.experiments.meng2020.table2 import WORLDS
from tutorial_lib.experiments.protocols.navigation_tasks import (
    PLACES,
    Building,
    building,
    long_enough,
)
from tutorial_lib.interfaces import Experience
from tutorial_lib.parallel import for_each

FRAMES, QUICK_FRAMES = 100_000, 20_000
EVERY = 10_000
"""Frames from one row to the next."""
_DRIVES = 45  # recorded at a time


def run(options: Options) -> Report:
    """Drive from place to place for hours, and count vertices."""
    begun = time.perf_counter()
    worlds = options.worlds or (WORLDS[:2] if options.quick else WORLDS)
    parts = for_each(run_world, worlds, options, label="meng_fig13")
    rows = [row for part in parts for row in part]
    notes = []
    if not options.quick:
        size = {(row["world"], row["frames"]): row["vertices"] for row in rows}
        added = [size[world, FRAMES] / size[world, FRAMES // 2] - 1 for world in worlds]
        notes.append(
            f"from {FRAMES // 2:,} to {FRAMES:,} frames {np.mean(added):.1%} more vertices "
            f"({min(added):.1%} to {max(added):.1%} by world)"
        )
    took = time.perf_counter() - begun
    return Report("meng_fig13", options.seed, worlds, options.quick, took, rows, tuple(notes))


def run_world(world: int, options: Options) -> list[dict[str, Any]]:
    """The rows of one world."""
    house = building(world, options.seed, PLACES)
    rng = np.random.default_rng([options.seed, world, 5])
    agent, frames, rows, clock = agents.meng(), 0, [], 0.0
    most = QUICK_FRAMES if options.quick else FRAMES
    while frames < most:
        recorded = more_drives(house, rng)
        for number, drive in enumerate(recorded.trajectories):
            seen = recorded.observe(recorded.frames_of(number))
            agent.learn([Experience(seen, clock + drive.timestamps)])
            clock += float(drive.timestamps[-1]) + 60.0
            before, frames = frames, frames + len(drive)
            rows += [_row(world, at, agent) for at in _passed(before, min(frames, most))]
            if frames >= most:
                break
    return rows


def more_drives(house: Building, rng: np.random.Generator) -> RecordedWorld:
    """Some more drives between the places, from perturbed starts."""
    drives = rng.integers(len(house.pairs), size=_DRIVES)
    first = house.recorded.first_frames[drives]
    starts, _ = perturbed(house.scene, house.recorded.poses[first], PAPER_PERTURBATION, rng)
    places = house.places[house.pairs[drives, 1]]
    made = demonstrate_between(house.name, house.scene, house.paths, starts, places, 0)
    return RecordedWorld(house.scene, [drive for drive in made if long_enough(drive)])


def _passed(before: int, now: int) -> range:
    """The numbers of frames at which a row is due."""
    return range((before // EVERY + 1) * EVERY, now + 1, EVERY)


def _row(world: int, frames: int, agent: Any) -> dict[str, Any]:  # noqa: ANN401
    return {
        "world": world,
        "frames": frames,
        "vertices": len(agent.topomap),
        "edges": agent.topomap.graph.number_of_edges(),
        "every_10th": frames // 10,
        "every_20th": frames // 20,
    }
