"""Recorded images with poses for programs that do not render: `.npz` or HDF5."""

import zipfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import DTypeLike, NDArray

from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.errors import InputError
from tutorial_lib.files import atomic_path
from tutorial_lib.validation import instance, path_of
from tutorial_lib.world.sensors import Camera

_AT_A_TIME = 1000
"""Frames that are rendered at a time: memory does not grow with the recording."""
_EACH_FRAME = ("poses", "odometry", "laser", "speed", "steering", "actions", "timestamps")

Images = Iterable[NDArray[np.uint8]]


def export_recording(
    path: str | Path, recorded: RecordedWorld, camera: Camera | None = None
) -> None:
    """Write all frames of a recording with their images into one file, whole or not at all.

    The file holds, for F frames of M trajectories, `images` (F, H, W, 3) uint8 RGB; `poses` and
    `odometry` (F, 3) in metres and rad; `laser` (F, B) metres; `speed` (F,) m/s; `steering` (F,)
    rad; `actions` (F, 2), commanded; `timestamps` (F,) seconds; `trajectory` (F,) from 0 to M - 1;
    and `world` and `seed` (M,).

    Args:
        path: ends in `.npz`, read by `numpy.load`, or in `.h5` or `.hdf5`, read by h5py, which
            gives single frames without reading the rest.
        recorded: trajectories in one world.
        camera: takes the images; the usual one unless given.

    Raises:
        InputError: when the name ends otherwise, h5py is missing, the trajectories have different
            lasers, or the file cannot be written.
    """
    path = path_of("path", path)
    frames = np.arange(len(instance("recorded", recorded, RecordedWorld).poses))
    write = {".npz": _write_npz, ".h5": _write_hdf5, ".hdf5": _write_hdf5}.get(path.suffix.lower())
    if write is None:
        raise InputError(
            f"path: {path} is an unknown kind of file; give a name that ends in .npz or .h5"
        )
    size = recorded.observe(frames[:0], camera).image.shape[1:]
    images = (
        recorded.observe(frames[first : first + _AT_A_TIME], camera).image
        for first in range(0, len(frames), _AT_A_TIME)
    )
    with atomic_path(path) as temporary:
        write(temporary, _columns(recorded), (len(frames), *size), images)


def _columns(recorded: RecordedWorld) -> dict[str, NDArray[Any]]:
    """All but the images."""
    drives = recorded.trajectories
    columns = {name: np.concatenate([getattr(d, name) for d in drives]) for name in _EACH_FRAME}
    return columns | {
        "trajectory": np.repeat(np.arange(len(drives)), [len(drive) for drive in drives]),
        "world": np.array([drive.world for drive in drives], dtype=np.str_),
        "seed": np.array([drive.seed for drive in drives], dtype=np.int64),
    }


def _write_npz(
    path: Path, columns: dict[str, NDArray[Any]], shape: tuple[int, ...], images: Images
) -> None:
    # `numpy.savez` wants whole arrays, and writes the time into the file.
    with zipfile.ZipFile(path, "w") as archive:
        for name, array in columns.items():
            _write_member(archive, name, array.shape, array.dtype, [array])
        _write_member(archive, "images", shape, np.uint8, images)


def _write_member(
    archive: zipfile.ZipFile,
    name: str,
    shape: tuple[int, ...],
    kind: DTypeLike,
    parts: Iterable[NDArray[Any]],
) -> None:
    """Write an array in parts, in their order."""
    header = {"descr": npy.dtype_to_descr(np.dtype(kind)), "fortran_order": False, "shape": shape}
    with archive.open(zipfile.ZipInfo(f"{name}.npy"), "w", force_zip64=True) as file:
        npy.write_array_header_1_0(file, header)
        for part in parts:
            file.write(part.tobytes())


def _write_hdf5(
    path: Path, columns: dict[str, NDArray[Any]], shape: tuple[int, ...], images: Images
) -> None:
    try:
        import h5py
    except ImportError as error:
        advice = 'install it by .venv/bin/python -m pip install ".[export]", or give a .npz'
        raise InputError(f"HDF5: its package h5py is missing; {advice}") from error
    with h5py.File(path, "w") as file:
        for name, array in columns.items():
            if array.dtype.kind == "U":
                file.create_dataset(name, data=array.astype(object), dtype=h5py.string_dtype())
            else:
                file.create_dataset(name, data=array)
        stored, first = file.create_dataset("images", shape, np.uint8, chunks=(1, *shape[1:])), 0
        for part in images:
            stored[first : first + len(part)] = part
            first += len(part)
