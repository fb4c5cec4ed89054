"""How rollouts of a controller end: the labels of reachability (Meng 2020, III-C)."""

from collections.abc import Callable
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.data.reachability_pairs import ReachabilityPairs
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.rollouts import ReachGoals, rollout
from tutorial_lib.errors import InputError
from tutorial_lib.files import save_arrays
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Policy
from tutorial_lib.reading.arrays import load_arrays
from tutorial_lib.world.sensors import Camera
from tutorial_lib.world.simulation import Sensors, Simulation

FLEET = 1_024
"""Robots in one simulation; with fewer, more steps would move only the last stragglers."""
VERSION = 1
"""Of the file's layout."""

# Arrays of the file: the shape of a row, kinds of numbers, and the least and the largest.
_FORMS: dict[str, tuple[tuple[int, ...], str, float, float]] = {
    "starts": ((3,), "f", -1e6, 1e6),
    "targets": ((), "iu", 0, 1e9),
    "overlap": ((2,), "f", 0.0, 1.0 + 1e-6),
    "geodesic": ((), "f", 0.0, np.inf),
    "driven": ((), "b", 0, 1),
    "reached": ((), "b", 0, 1),
    "collided": ((), "b", 0, 1),
    "seconds": ((), "f", 0.0, 1e6),
}

PolicyFactory = Callable[[Simulation, RecordedWorld, NDArray[np.intp]], Policy]
"""Makes the policy that drives the N robots of a simulation to recorded frames (N,)."""


@dataclass(frozen=True)
class RolloutOutcomes:
    """N pairs in one world, and how the rollout of each ended.

    Attributes:
        pairs: starts and targets.
        driven: (N,) whether the pair was rolled out. Far, occluded pairs are labelled 0 without a
            rollout; `experiment calibration --ablation audit` measures the error.
        reached: (N,) whether the target was reached in time without a collision (the authors
            left out rollouts that collide; here there are 5 in 150,000).
        collided: (N,) whether the robot touched something.
        seconds: (N,) until the rollout ended.
    """

    pairs: ReachabilityPairs
    driven: NDArray[np.bool_]
    reached: NDArray[np.bool_]
    collided: NDArray[np.bool_]
    seconds: Array

    def __len__(self) -> int:
        return len(self.pairs)

    def subset(self, index: NDArray) -> "RolloutOutcomes":
        """Those that an array of indices or a mask selects."""
        rest = (getattr(self, field.name)[index] for field in fields(self)[1:])
        return RolloutOutcomes(self.pairs.subset(index), *rest)


def roll_out_pairs(
    recorded: RecordedWorld,
    pairs: ReachabilityPairs,
    make_policy: PolicyFactory,
    camera: Camera | None = None,
    all_of_them: bool = False,
) -> RolloutOutcomes:
    """Roll out a policy from the start of each pair to its target.

    Args:
        recorded: the world.
        pairs: N starts and targets.
        make_policy: of a policy without memory.
        camera: of the robots; the usual one unless given.
        all_of_them: whether far, occluded pairs are rolled out, too.
    """
    count = len(pairs)
    driven = np.ones(count, dtype=bool) if all_of_them else ~pairs.far_and_occluded
    reached, collided, seconds = np.zeros(count, bool), np.zeros(count, bool), np.zeros(count)
    # Those with similar time limits share a simulation.
    order = np.flatnonzero(driven)[np.argsort(pairs.limit[driven], kind="stable")]
    sensors = None if camera is None else Sensors(camera=camera)
    for first in range(0, len(order), FLEET):
        rows = order[first : first + FLEET]
        simulation = Simulation(recorded.scene, pairs.starts[rows], sensors=sensors)
        targets = pairs.targets[rows]
        ends = ReachGoals(recorded.poses[targets, :2], pairs.limit[rows], settle=True)
        rollouts = rollout(simulation, make_policy(simulation, recorded, targets), ends)
        reached[rows], collided[rows] = rollouts.reached, rollouts.collided
        seconds[rows] = rollouts.seconds
    return RolloutOutcomes(pairs, driven, reached, collided, seconds)


def save_outcomes(path: str | Path, outcomes: RolloutOutcomes, recipe: str) -> None:
    """Write outcomes into an `.npz` file, whole or not at all.

    Args:
        path: of the file.
        outcomes: of one world.
        recipe: what they were made with; `load_outcomes` compares it.
    """
    save_arrays(path, {"recipe": np.array(recipe), **_columns(outcomes)}, version=VERSION)


def load_outcomes(path: str | Path, recipe: str) -> RolloutOutcomes:
    """Read what `save_outcomes` wrote.

    Raises:
        InputError: when the file is missing, damaged or of another recipe; it says what to do.
    """
    inputs, ends = fields(ReachabilityPairs), fields(RolloutOutcomes)[1:]
    names = ["recipe", *(field.name for field in (*inputs, *ends))]
    arrays = load_arrays(path, names, version=VERSION, advice="record it again")
    if str(arrays.pop("recipe")) != recipe:
        raise InputError(f"{path}: outcomes of another recipe; delete the file and record it again")
    try:
        _check(arrays)
    except InputError as error:
        raise InputError(f"{path}: {error}; record it again") from error
    return RolloutOutcomes(
        ReachabilityPairs(*(arrays[field.name] for field in inputs)),
        *(arrays[field.name] for field in ends),
    )


def _check(arrays: dict[str, NDArray[Any]]) -> None:
    """Check each column's length, shape, type and range."""
    for name, column in arrays.items():
        if not column.ndim:
            raise InputError(f"damaged ({name}: a column without rows)")
        if len(column) != len(arrays["starts"]):
            raise InputError(f"{name}: its columns differ in length")
    for name, (row, kinds, least, most) in _FORMS.items():
        column = arrays[name]
        if column.shape[1:] != row or column.dtype.kind not in kinds:
            raise InputError(f"damaged ({name}: {column.dtype} of shape {column.shape})")
        # Of numbers that are none, neither comparison is true.
        if column.size and not (column.min() >= least and column.max() <= most):
            raise InputError(f"{name}: holds a number that is not within {least:g} to {most:g}")


def _columns(outcomes: RolloutOutcomes) -> dict[str, NDArray[Any]]:
    """Every array of outcomes by name."""
    found = {field.name: getattr(outcomes.pairs, field.name) for field in fields(ReachabilityPairs)}
    return found | {
        field.name: getattr(outcomes, field.name) for field in fields(RolloutOutcomes)[1:]
    }
