"""Fig. 6 of Meng 2020: one long trajectory, followed by its anchors."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from tutorial_lib.driving.data.demonstrations import demonstrate
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.trajectories import Trajectory
from tutorial_lib.experiments.common.report import Options, Report
from tutorial_lib.experiments.protocols.following import CARS, UNDER_WAY, Guide
from tutorial_lib.experiments.protocols.local_control import WORLDS
from tutorial_lib.learning.estimators import use_threads
from tutorial_lib.topology.following.transitions import State
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.simulation import STEP
from tutorial_lib.world.worlds import local_world, scene_of

LENGTH = 23.0
"""Metres of the paper's trajectory."""
CONTEXT, THRESHOLD = "k5", 0.99
PLACES = 9
"""Numbered places along the way, of which the figure shows the pictures."""


def run(options: Options) -> Report:
    """Follow the recorded trajectory that is nearest to 23 m long, in the first world."""
    begun = time.perf_counter()
    worlds = options.worlds[:1] or WORLDS[:1]
    use_threads(2)
    name = local_world(worlds[0])
    scene = scene_of(name)
    chosen = chosen_drive(name, scene, options.seed)
    guide = Guide(RecordedWorld(scene, [chosen]), CONTEXT)
    anchors = guide.anchors(0, THRESHOLD)
    metres, tracks, following = guide.follow([anchors])
    steps = np.flatnonzero(np.isfinite(following.probability[:, 0]))
    numbered = steps[np.linspace(0, len(steps) - 1, PLACES).astype(int)]
    rows: list[dict[str, Any]] = [
        {
            "place": number,
            "seconds": STEP * step,
            "x": tracks[step, 0, 0],
            "y": tracks[step, 0, 1],
            "heading": tracks[step, 0, 2],
            "state": State(following.state[step, 0]).name.lower(),
            "active": int(following.active[step, 0]),
            "anchors": len(anchors),
            "probability": following.probability[step, 0],
        }
        for number, step in enumerate(numbered, start=1)
    ]
    length = chosen.arc_length[-1]
    note = f"{metres[0]:.1f} of {length:.1f} m followed by {len(anchors)} of {len(chosen)} frames"
    took = time.perf_counter() - begun
    return Report("meng_fig6", options.seed, worlds, options.quick, took, rows, (note,))


def chosen_drive(world: str, scene: Scene, seed: int) -> Trajectory:
    """The drive that is followed: the one nearest to 23 m long, once it is under way."""
    drives = demonstrate(world, scene, CARS, seed)
    moved = [drive.since(UNDER_WAY) for drive in drives if drive.arc_length[-1] > 2 * UNDER_WAY]
    return min(moved, key=lambda drive: abs(drive.arc_length[-1] - LENGTH))
