"""Files are written whole or not at all; `reading` reads them."""

import os
import tempfile
from collections.abc import Iterator, Mapping
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
        version: of the file's layout, which `reading.arrays.load_arrays` compares.
        compressed: smaller, but slower to write.
    """
    stamp = {} if version is None else {"version": np.array(version)}
    write = np.savez_compressed if compressed else np.savez
    with atomic_path(path) as temporary, temporary.open("wb") as file:
        write(file, **stamp, **arrays)
