"""How errands end under a controller: what reachability is learnt from (Meng 2020, III-C)."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.data.reachability_pairs import ReachabilityPairs
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.rollouts import Policy, drive
from tutorial_lib.errors import InputError
from tutorial_lib.files import load_arrays, save_arrays
from tutorial_lib.geometry import Array
from tutorial_lib.world.sensors import Camera
from tutorial_lib.world.simulation import Sensors, Simulation

FLEET = 1_024
"""Robots that are driven at once: few steps are made with only the last of them under way."""
VERSION = 1
"""Of the file's layout."""

PolicyFactory = Callable[[RecordedWorld, NDArray[np.intp]], Policy]
"""Gets ready to drive robots to frames (N,) of recorded drives, and drives them."""


@dataclass(frozen=True)
class RolloutOutcomes:
    """N errands in one world, and how each ended.

    Attributes:
        errands: where they led.
        driven: (N,) whether a robot was sent. Hopeless errands count as failed without that: who
            chances upon such a target (`experiment calibration --ablation audit` says how many do)
            could not have known.
        reached: (N,) whether the target was reached in time, and nothing was touched. Who touches
            something has not (the authors left such drives out; here there are 5 in 150,000).
        collided: (N,) whether something was touched.
        seconds: (N,) until it ended.
    """

    errands: ReachabilityPairs
    driven: NDArray[np.bool_]
    reached: NDArray[np.bool_]
    collided: NDArray[np.bool_]
    seconds: Array

    def __len__(self) -> int:
        return len(self.errands)

    def some(self, numbers: NDArray) -> "RolloutOutcomes":
        """Those of the given numbers, or under a mask."""
        rest = (getattr(self, field.name)[numbers] for field in fields(self)[1:])
        return RolloutOutcomes(self.errands.some(numbers), *rest)


def roll_out_pairs(
    recorded: RecordedWorld,
    errands: ReachabilityPairs,
    pilot: PolicyFactory,
    camera: Camera | None = None,
    all_of_them: bool = False,
) -> RolloutOutcomes:
    """Send a robot on each errand and see what becomes of it.

    Args:
        recorded: the world.
        errands: N of them.
        pilot: drives; it has no memory.
        camera: that the robots carry; the usual one unless given.
        all_of_them: whether robots are sent on hopeless errands, too.
    """
    count = len(errands)
    driven = np.ones(count, dtype=bool) if all_of_them else ~errands.hopeless
    reached, collided, seconds = np.zeros(count, bool), np.zeros(count, bool), np.zeros(count)
    # Those that take equally long are sent together.
    order = np.flatnonzero(driven)[np.argsort(errands.limit[driven], kind="stable")]
    sensors = None if camera is None else Sensors(camera=camera)
    for first in range(0, len(order), FLEET):
        some = order[first : first + FLEET]
        simulation = Simulation(recorded.scene, errands.starts[some], sensors=sensors)
        driver, goals = (
            pilot(recorded, errands.targets[some]),
            recorded.poses[errands.targets[some]],
        )
        drives = drive(simulation, driver, goals[:, :2], errands.limit[some], settle=True)
        reached[some], collided[some] = drives.reached, drives.collided
        seconds[some] = drives.seconds
    return RolloutOutcomes(errands, driven, reached, collided, seconds)


def save_outcomes(path: str | Path, outcomes: RolloutOutcomes, recipe: str) -> None:
    """Write outcomes into an `.npz` file, whole or not at all.

    Args:
        path: of the file.
        outcomes: of one world.
        recipe: what they came from, to know them again.
    """
    save_arrays(path, {"recipe": np.array(recipe), **_columns(outcomes)}, version=VERSION)


def load_outcomes(path: str | Path, recipe: str) -> RolloutOutcomes:
    """Read what `save_outcomes` wrote.

    Raises:
        InputError: when the file is missing, damaged or of another recipe; it says what to do.
    """
    pairs, ends = fields(ReachabilityPairs), fields(RolloutOutcomes)[1:]
    names = ["recipe", *(field.name for field in (*pairs, *ends))]
    arrays = load_arrays(path, names, version=VERSION, advice="record it again")
    if str(arrays.pop("recipe")) != recipe:
        raise InputError(f"{path}: outcomes of another recipe; delete the file and record it again")
    if not all(column.ndim for column in arrays.values()):
        raise InputError(f"{path}: damaged (a column without rows); record it again")
    if len({len(column) for column in arrays.values()}) > 1:
        raise InputError(f"{path}: its columns differ in length; record it again")
    return RolloutOutcomes(
        ReachabilityPairs(*(arrays[field.name] for field in pairs)),
        *(arrays[field.name] for field in ends),
    )


def _columns(outcomes: RolloutOutcomes) -> dict[str, NDArray[Any]]:
    """Every array of outcomes by name."""
    found = {
        field.name: getattr(outcomes.errands, field.name) for field in fields(ReachabilityPairs)
    }
    return found | {
        field.name: getattr(outcomes, field.name) for field in fields(RolloutOutcomes)[1:]
    }
