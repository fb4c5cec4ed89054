"""Rollout outcomes in many worlds, one file each: the data that reachability is learnt from."""

from collections.abc import Callable, Sequence
from pathlib import Path
from zlib import crc32

import numpy as np

from tutorial_lib.driving.data.demonstrations import record_demonstrations
from tutorial_lib.driving.data.perturbation import REACHABILITY_PERTURBATION
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
from tutorial_lib.files import make_folder
from tutorial_lib.learning.estimators import WaypointNetwork
from tutorial_lib.learning.policies import by_waypoints
from tutorial_lib.learning.weights import load_card
from tutorial_lib.parallel import for_each
from tutorial_lib.world.worlds import scene_of

SEED = 2
"""Of the pairs."""


def record_outcomes(
    worlds: Sequence[str],
    controller: str,
    targets: int,
    cars: int,
    work: Path,
    jobs: int = 2,
) -> list[Path]:
    """Roll out a controller on pairs in many worlds, one file each; existing files are kept.

    So an interrupted recording resumes where it stopped and ends with the same files. A file that
    is damaged, or was made with other weights or sizes, is recorded again.

    Args:
        worlds: their names.
        controller: name of the weights of C_WP.
        targets: of each world, see `draw_reachability_pairs`.
        cars: per world, on whose demonstrations the targets lie.
        work: folder for demonstrations and outcomes.
        jobs: processes.

    Returns:
        The files, in the order of `worlds`.
    """
    demonstrations = record_demonstrations(worlds, cars, 0, work / "demonstrations", jobs)
    recipe = recipe_of(controller, targets, cars)
    folder = work / "outcomes" / controller
    make_folder(folder)
    items = list(zip(worlds, demonstrations, strict=True))
    label = f"outcomes of {controller}"
    return for_each(_record, items, controller, targets, recipe, folder, label=label, jobs=jobs)


def recipe_of(controller: str, targets: int, cars: int) -> str:
    """What outcomes depend on besides the world."""
    return f"{controller} {load_card(controller).sha256[:16]} {targets} {cars} {SEED}"


def _record(
    item: tuple[str, Path], controller: str, targets: int, recipe: str, folder: Path
) -> Path:
    """Record one world, unless its file is there."""
    world, demonstrations = item
    path = folder / f"{world.replace('/', '-')}.npz"

    def record() -> RolloutOutcomes:
        recorded = RecordedWorld(scene_of(world), load_trajectories(demonstrations))
        return outcomes_in(recorded, world, controller, targets)

    kept_outcomes(path, recipe, record)
    return path


def kept_outcomes(
    path: Path, recipe: str, record: Callable[[], RolloutOutcomes]
) -> RolloutOutcomes:
    """The outcomes in the file, or else those that `record` returns, which are saved there."""
    try:
        return load_outcomes(path, recipe)
    except InputError:
        outcomes = record()
        save_outcomes(path, outcomes, recipe)
        return outcomes


def outcomes_in(
    recorded: RecordedWorld, world: str, controller: str, targets: int
) -> RolloutOutcomes:
    """Draw pairs in one world and roll out the controller on them."""
    rng = np.random.default_rng([SEED, crc32(world.encode())])
    paths = GridPaths(recorded.scene.clearance)
    predictor = WaypointNetwork(controller)
    camera = predictor.view.camera
    pairs = draw_reachability_pairs(
        recorded, paths, targets, rng, REACHABILITY_PERTURBATION, camera.field_of_view
    )
    return roll_out_pairs(recorded, pairs, by_waypoints(predictor), camera)
