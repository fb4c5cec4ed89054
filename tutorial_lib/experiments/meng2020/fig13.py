"""Fig. 13 of Meng 2020: how maps grow with the number of observations."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.meng2020 import fig13_reuse
from tutorial_lib.experiments.protocols.navigation_tasks import PLACES, WORLDS, make_building
from tutorial_lib.experiments.protocols.repeated_drives import repeated_drives
from tutorial_lib.parallel import for_each


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
        due = _due(before, min(frames, settings.frames), settings.interval)
        rows += [_row(world, count, agent) for count in due]
        before = frames
    return rows


def _due(before: int, now: int, interval: int) -> range:
    """The numbers of frames at which a row is due."""
    return range((before // interval + 1) * interval, now + 1, interval)


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
    ablations={"reuse": fig13_reuse.EXPERIMENT},
)
