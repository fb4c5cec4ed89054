"""Outcomes of errands in many worlds, one file each: the data that reachability is learnt from."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from zlib import crc32

import numpy as np

from tutorial_lib.driving.data.demonstrations import record_demonstrations
from tutorial_lib.driving.data.reachability_pairs import draw_reachability_pairs
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.rollout_outcomes import (
    RolloutOutcomes,
    load_outcomes,
    roll_out_pairs,
    save_outcomes,
)
from tutorial_lib.driving.data.trajectories import load_trajectories
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.learning.estimators import WaypointNetwork
from tutorial_lib.learning.policies import by_waypoints
from tutorial_lib.learning.weights import load_card
from tutorial_lib.parallel import for_each
from tutorial_lib.world.worlds import scene_of

SEED = 1
"""Of the errands."""


def record_outcomes(
    worlds: Sequence[str],
    controller: str,
    targets: int,
    cars: int,
    work: Path,
    jobs: int = 2,
) -> list[Path]:
    """Send a controller on errands in many worlds, one file each; files that are there are kept.

    So an interrupted recording goes on where it stopped and ends with the same files. A file that
    is damaged, or comes from other weights or sizes, is recorded again.

    Args:
        worlds: their names.
        controller: name of the weights of C_WP.
        targets: of each world, see `draw_reachability_pairs`.
        cars: whose demonstrations the targets lie on.
        work: folder for demonstrations and outcomes.
        jobs: processes.

    Returns:
        The files, in the order of `worlds`.
    """
    drives = record_demonstrations(worlds, cars, 0, work / "demonstrations", jobs)
    recipe = recipe_of(controller, targets, cars)
    folder = work / "outcomes" / controller
    folder.mkdir(parents=True, exist_ok=True)
    items = list(zip(worlds, drives, strict=True))
    label = f"outcomes of {controller}"
    return for_each(_record, items, controller, targets, recipe, folder, label=label, jobs=jobs)


def recipe_of(controller: str, targets: int, cars: int) -> str:
    """What outcomes depend on besides the world."""
    return f"{controller} {load_card(controller).sha256[:16]} {targets} {cars} {SEED}"


def _record(
    item: tuple[str, Path], controller: str, targets: int, recipe: str, folder: Path
) -> Path:
    """Record one world, unless its file is there."""
    world, drives = item
    path = folder / f"{world.replace('/', '-')}.npz"

    def send() -> RolloutOutcomes:
        recorded = RecordedWorld(scene_of(world), load_trajectories(drives))
        return outcomes_in(recorded, world, controller, targets)

    kept_outcomes(path, recipe, send)
    return path


def kept_outcomes(
    path: Path, recipe: str, record: Callable[[], RolloutOutcomes]
) -> RolloutOutcomes:
    """The outcomes in the file, or else those that `record` finds, which are kept there."""
    try:
        return load_outcomes(path, recipe)
    except InputError:
        outcomes = record()
        save_outcomes(path, outcomes, recipe)
        return outcomes


def outcomes_in(
    recorded: RecordedWorld, world: str, controller: str, targets: int
) -> RolloutOutcomes:
    """Draw errands in one world and send the controller on them."""
    rng = np.random.default_rng([SEED, crc32(world.encode())])
    errands = draw_reachability_pairs(recorded, GridPaths(recorded.scene.clearance), targets, rng)
    predictor = WaypointNetwork(controller)
    return roll_out_pairs(recorded, errands, by_waypoints(predictor), predictor.view.camera)
