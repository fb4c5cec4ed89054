"""Recorded experience: what a robot sensed and did, ten times a second; on disk without images.

A million frames are 12 GB of pixels but seconds of rays, so images are rendered when needed.
"""

from dataclasses import dataclass, fields, replace
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.array_forms import LARGEST
from tutorial_lib.errors import InputError
from tutorial_lib.files import save_arrays
from tutorial_lib.reading.arrays import load_arrays
from tutorial_lib.reading.limits import MAX_TRAJECTORIES
from tutorial_lib.se2 import Array, arc_length
from tutorial_lib.validation import instance, instances, number, path_of, whole

CONTEXT_INTERVAL = 3
"""Frames between the images of a target's context (dT of Meng 2020, III-B)."""
VERSION = 1
"""Of the file's layout."""

# Array fields of a trajectory: the shape of a row (None: any length) and the type on disk.
_COLUMNS: dict[str, tuple[tuple[int | None, ...], type]] = {
    "poses": ((3,), np.float64),
    "odometry": ((3,), np.float64),
    "laser": ((None,), np.float32),
    "speed": ((), np.float64),
    "steering": ((), np.float64),
    "actions": ((2,), np.float64),
    "timestamps": ((), np.float64),
}


@dataclass(frozen=True, eq=False)
class Trajectory:
    """One trajectory at 10 Hz: row t is what was sensed at time t, and the action then taken.

    Attributes:
        world: its name, see `world.worlds`.
        seed: it was recorded with.
        poses: (T, 3) float64, where the robot really was.
        odometry: (T, 3) float64, pose since the start by wheel odometry.
        laser: (T, B) float32 metres, full circle.
        speed: (T,) float64 m/s.
        steering: (T,) float64 rad.
        actions: (T, 2) float64, commanded speed in m/s and steering in rad.
        timestamps: (T,) float64 seconds, rising.

    Raises:
        InputError: when an array has another shape or type, or is not finite.
    """

    world: str
    seed: int
    poses: Array
    odometry: Array
    laser: NDArray[np.float32]
    speed: Array
    steering: Array
    actions: Array
    timestamps: Array

    def __post_init__(self) -> None:
        instance("world", self.world, str)
        whole("seed", self.seed, least=0)
        for name, (row, kind) in _COLUMNS.items():
            array = instance(name, getattr(self, name), np.ndarray)
            _check_column(name, array, row, kind)
            if len(array) != len(self.poses):
                raise InputError(f"{name}: {len(array)} rows where poses has {len(self.poses)}")
        if not len(self.poses):
            raise InputError("poses: a trajectory without a frame")
        if not (np.diff(self.timestamps) > 0).all():
            raise InputError("timestamps: not increasing")

    def __len__(self) -> int:
        return len(self.poses)

    @cached_property
    def arc_length(self) -> Array:
        """(T,) metres driven until each frame, in reverse too."""
        return arc_length(self.poses)

    def since(self, metres: float) -> "Trajectory":
        """The rest of the trajectory, after so many metres.

        Raises:
            InputError: when it is not as long.
        """
        metres = number("metres", metres, least=0.0, most=self.arc_length[-1])
        first = int(np.searchsorted(self.arc_length, metres))
        return replace(self, **{name: getattr(self, name)[first:] for name in _COLUMNS})


def save_trajectories(path: str | Path, trajectories: list[Trajectory]) -> None:
    """Write many trajectories into one `.npz` file, whole or not at all.

    Raises:
        InputError: when their lasers have different numbers of beams.
    """
    trajectories = list(instances("trajectories", trajectories, Trajectory))
    path = path_of("path", path)
    if len({trajectory.laser.shape[1] for trajectory in trajectories}) > 1:
        raise InputError(f"{path}: lasers with different numbers of beams; save them apart")
    arrays: dict[str, NDArray[Any]] = {
        "world": np.array([trajectory.world for trajectory in trajectories], dtype=np.str_),
        "seed": np.array([trajectory.seed for trajectory in trajectories], dtype=np.int64),
        "offsets": np.cumsum([0, *map(len, trajectories)], dtype=np.int64),
    }
    for name, (row, kind) in _COLUMNS.items():
        none = np.empty((0, *(width or 0 for width in row)), kind)
        rows = [getattr(trajectory, name) for trajectory in trajectories]
        arrays[name] = np.concatenate(rows or [none])
    save_arrays(path, arrays, version=VERSION)


def load_trajectories(path: str | Path) -> list[Trajectory]:
    """Read what `save_trajectories` wrote; every array is checked.

    Raises:
        InputError: naming the file, what is wrong with it and what to do.
    """
    names, advice = ["world", "seed", "offsets", *_COLUMNS], "delete the file and record it again"
    arrays = load_arrays(path, names, version=VERSION, advice=advice)
    try:
        return _split(arrays)
    except InputError as error:
        raise InputError(f"{path}: {error}; {advice}") from error


def _split(arrays: dict[str, NDArray[Any]]) -> list[Trajectory]:
    """The trajectories from their arrays laid end to end."""
    offsets, world, seed = arrays["offsets"], arrays["world"], arrays["seed"]
    rows = len(np.atleast_1d(arrays["poses"]))
    if offsets.dtype.kind != "i" or offsets.ndim != 1 or not len(offsets):
        raise InputError("offsets: not a row of whole numbers")
    if offsets[0] != 0 or offsets[-1] != rows or not (np.diff(offsets) > 0).all():
        raise InputError(f"offsets: do not divide the {rows} rows of poses")
    if len(offsets) > MAX_TRAJECTORIES + 1:
        raise InputError(f"offsets: {len(offsets) - 1} trajectories; at most {MAX_TRAJECTORIES}")
    shape = (len(offsets) - 1,)
    if world.shape != shape or (world.dtype.kind != "U" and world.size):
        raise InputError(f"world: not {shape[0]} names")
    if seed.shape != shape or seed.dtype.kind != "i":
        raise InputError(f"seed: not {shape[0]} whole numbers")
    for name, (row, kind) in _COLUMNS.items():
        _check_column(name, arrays[name], row, kind)
        if len(arrays[name]) != rows:
            raise InputError(f"{name}: {len(arrays[name])} rows where poses has {rows}")
    names = [field.name for field in fields(Trajectory)][2:]
    return [
        Trajectory(str(world[i]), int(seed[i]), *(arrays[name][first:last] for name in names))
        for i, (first, last) in enumerate(pairwise(offsets))
    ]


def _check_column(name: str, array: NDArray[Any], row: tuple[int | None, ...], kind: type) -> None:
    """Check one array's shape, type and numbers."""
    fits = array.ndim == 1 + len(row)
    fits = fits and all(w in (None, n) for w, n in zip(row, array.shape[1:], strict=True))
    if not fits:
        wanted = ", ".join(["T", *("B" if width is None else str(width) for width in row)])
        raise InputError(f"{name}: shape {array.shape} where ({wanted}) belongs")
    if array.dtype != kind:
        raise InputError(f"{name}: type {array.dtype} where {np.dtype(kind)} belongs")
    if not (np.abs(array) <= LARGEST).all():
        raise InputError(f"{name}: holds numbers that are not finite, or beyond {LARGEST:g}")
