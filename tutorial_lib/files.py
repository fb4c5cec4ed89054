"""Files are written whole or not at all; `reading` reads them."""

import errno
import io
import os
import re
import secrets
import shutil
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.validation import flag, instance, path_of, whole

_TEMPORARY = re.compile(r"\..+-\w{8}\.tmp(\.\w+)?")
"""The names of temporary files, by which those that a killed run left are known."""
_KEPT = 24 * 3600.0
"""Seconds after which a temporary file is taken for one of a run that was killed."""
_DISK = {errno.ENOSPC, errno.EFBIG, errno.EIO, getattr(errno, "EDQUOT", errno.ENOSPC)}
"""What the system says of a disk that takes no more."""
_SOME = 1 << 16
"""Bytes that must fit on a disk before long work begins."""


@contextmanager
def atomic_paths(*paths: str | Path) -> Iterator[list[Path]]:
    """Give a temporary path beside each of `paths`; on success all take their places together.

    If the block raises or is interrupted, or the disk does not take what was written, all of
    `paths` stay as they were and the temporary files are removed. Where several processes write the
    same path, each reader finds one whole file or another, and the last one stays. A file keeps its
    rights, and a new one gets those that the umask leaves; where a path is a symbolic link, what it
    leads to is replaced.

    Only a killed process leaves temporary files behind: see `sweep`, which this calls.

    Args:
        paths: where the finished files belong; their folders must exist.

    Yields:
        Paths with the same suffixes to write to.

    Raises:
        InputError: when a file cannot be written.
    """
    places = [_destination(path_of("path", path)) for path in paths]
    with _temporaries(places) as temporaries:
        yield temporaries
        for temporary, path in zip(temporaries, places, strict=True):
            _settle(temporary)  # before it may get a mode by which it cannot be opened
            if path.exists():
                shutil.copymode(path, temporary)
        for temporary, path in zip(temporaries, places, strict=True):
            os.replace(temporary, path)


@contextmanager
def atomic_path(path: str | Path) -> Iterator[Path]:
    """Give a temporary path beside `path`; on success it takes its place: see `atomic_paths`."""
    with atomic_paths(path) as (temporary,):
        yield temporary


def sweep(folder: Path) -> None:
    """Remove the temporary files that killed runs left in a folder more than a day ago."""
    latest = time.time() - _KEPT
    with suppress(OSError), os.scandir(folder) as entries:
        for entry in entries:
            if _TEMPORARY.fullmatch(entry.name):
                with suppress(OSError):  # another process was faster
                    if entry.stat(follow_symlinks=False).st_mtime < latest:
                        os.unlink(entry)


def make_folder(folder: Path) -> None:
    """Make a folder for files, where it is missing, and sweep it."""
    folder.mkdir(parents=True, exist_ok=True)
    sweep(folder)


def check_writable(path: str | Path) -> None:
    """Check that a file can be put at `path`, before the work whose result it is to hold.

    Raises:
        InputError: when its folder is missing or read-only, its disk is full, or `path` is itself a
            folder, a device, or a file that is protected.
    """
    path = _destination(path_of("path", path))
    if path.exists() and not path.stat().st_mode & 0o222:
        raise InputError(f"{path}: is protected from being written; give another name")
    if not os.access(path.parent, os.W_OK):
        raise _not_writable(path)
    with _temporaries([path]) as (temporary,):
        temporary.write_bytes(bytes(_SOME))
        _settle(temporary)


def write_files(contents: Mapping[Path, bytes]) -> None:
    """Write files, all of them whole or none."""
    with atomic_paths(*contents) as temporaries:
        for temporary, data in zip(temporaries, contents.values(), strict=True):
            temporary.write_bytes(data)
            if temporary.stat().st_size != len(data):
                raise OSError(errno.EIO, "not all of it was written", str(temporary))


def write_text(path: str | Path, text: str) -> None:
    """Write `text` to `path` atomically, in UTF-8."""
    write_files({path_of("path", path): instance("text", text, str).encode()})


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
    path = path_of("path", path)
    for name in instance("arrays", arrays, Mapping):
        instance("arrays: a name", name, str)
    if version is not None:
        whole("version", version)
    compressed = flag("compressed", compressed)
    stamp = {} if version is None else {"version": np.array(version)}
    write: Callable[..., None] = np.savez_compressed if compressed else np.savez
    buffer = io.BytesIO()
    write(buffer, **stamp, **arrays)
    write_files({path: buffer.getvalue()})


def _destination(path: Path) -> Path:
    """The file that a path leads to, by links or not; it may be missing."""
    found = Path(os.path.realpath(path)) if path.is_symlink() else path
    if found.is_symlink() or (found.exists() and not found.is_file()):  # a circle; a folder, device
        raise _not_writable(path)
    return found


def _not_writable(path: Path) -> InputError:
    return InputError(f"{path}: cannot be written; give a file's name in an existing folder")


@contextmanager
def _temporaries(places: list[Path]) -> Iterator[list[Path]]:
    """Empty files beside `places`, of which none is left at the end."""
    made: list[Path] = []
    try:
        with _explained(places, made):
            for path in places:
                sweep(path.parent)
                made.append(_temporary(path))
            yield made
    finally:
        for temporary in made:
            temporary.unlink(missing_ok=True)


def _temporary(path: Path) -> Path:
    """An empty file beside `path`, with its suffix and a name of `_TEMPORARY`."""
    # Not by `tempfile`, whose files nobody else may read whatever the umask says.
    temporary = path.with_name(f".{path.stem}-{secrets.token_hex(4)}.tmp{path.suffix}")
    temporary.open("xb").close()
    return temporary


def _settle(temporary: Path) -> None:
    """Have the system put a file on its disk: some say only now that there is no room."""
    with temporary.open("r+b") as file:
        os.fsync(file.fileno())


@contextmanager
def _explained(places: list[Path], temporaries: list[Path]) -> Iterator[None]:
    """Say of files that cannot be written which ones, why, and what to do."""
    try:
        yield
    except OSError as error:
        own = len(temporaries) < len(places) or error.filename in map(str, temporaries)
        if not own and error.errno not in _DISK:
            raise
        names = ", ".join(map(str, places))
        advice = "give a file's name in an existing folder that you may write to"
        if error.errno in _DISK:
            free = shutil.disk_usage(places[0].parent).free / 1e6
            advice = f"its disk has {free:,.1f} MB free: make room there, and start again"
        raise InputError(f"{names}: cannot be written ({error.strerror}); {advice}") from error
