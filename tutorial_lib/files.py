"""Files are written whole or not at all, and read with every fault named."""

import os
import tempfile
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError


@contextmanager
def atomic_path(path: str | Path) -> Iterator[Path]:
    """Give a temporary path beside `path`; on success it takes the place of `path`.

    If the block raises or is interrupted, `path` stays as it was and the temporary file is removed.

    Args:
        path: where the finished file belongs; its folder must exist.

    Yields:
        A path with the same suffix to write to.
    """
    path = Path(path)
    handle, name = tempfile.mkstemp(suffix=path.suffix, prefix=f".{path.stem}-", dir=path.parent)
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        temporary.chmod(0o644)
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def check_writable(path: str | Path) -> None:
    """Check that a file can be put at `path`, before the work whose result it is to hold.

    Raises:
        InputError: when its folder is missing or read-only, or `path` is itself a folder.
    """
    path = Path(path)
    if path.is_dir() or not os.access(path.parent, os.W_OK):
        raise InputError(f"{path}: cannot be written; give a file's name in an existing folder")


def write_text(path: str | Path, text: str) -> None:
    """Write `text` to `path` atomically, in UTF-8."""
    with atomic_path(path) as temporary:
        temporary.write_text(text, encoding="utf-8")


def save_arrays(
    path: str | Path,
    arrays: Mapping[str, NDArray[Any]],
    *,
    version: int | None = None,
    compressed: bool = False,
) -> None:
    """Write arrays by name into an `.npz` file, whole or not at all.

    Args:
        path: of the file.
        arrays: by name.
        version: of the file's layout, which `load_arrays` compares.
        compressed: smaller, but slower to write.
    """
    stamp = {} if version is None else {"version": np.array(version)}
    write = np.savez_compressed if compressed else np.savez
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        write(file, **stamp, **arrays)


def load_arrays(
    path: str | Path, names: Collection[str], *, version: int | None = None, advice: str = ""
) -> dict[str, NDArray[Any]]:
    """Read the arrays that `save_arrays` wrote; nothing is ever unpickled.

    Args:
        path: of the file.
        names: of the arrays that it must hold.
        version: that it must have; not compared unless given.
        advice: what to do about a file that cannot be read.

    Raises:
        InputError: when the file is missing, damaged, of another version, or lacks an array; it
            names the file, says what is wrong, and ends with the advice.
    """
    path, ending = Path(path), f"; {advice}" if advice else ""
    try:
        arrays = _read_arrays(path)
        if version is not None:
            _check_version(arrays, version)
        for name in names:
            if name not in arrays:
                raise InputError(f"damaged ({name!r} is missing)")
    except InputError as error:
        raise InputError(f"{path}: {error}{ending}") from error
    return arrays


def _read_arrays(path: Path) -> dict[str, NDArray[Any]]:
    if not path.is_file():
        raise InputError("there is no such file")
    try:
        with np.load(path, allow_pickle=False) as file:
            return {name: file[name] for name in file.files}
    # zipfile, zlib and numpy's header reader have a dozen errors for a damaged file.
    except Exception as error:
        raise InputError(f"damaged, or not an .npz file ({error})") from error


def _check_version(arrays: dict[str, NDArray[Any]], version: int) -> None:
    found = arrays.pop("version", None)
    if found is None or found.shape or found.dtype.kind not in "iu":
        raise InputError(f"damaged, or not a file of version {version}")
    if found != version:
        raise InputError(f"of version {found}; this program reads version {version}")
