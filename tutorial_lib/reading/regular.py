"""Bytes and text of regular files of a sane size: no device, pipe or folder, nor a link to one."""

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

from tutorial_lib.errors import InputError
from tutorial_lib.reading.limits import MAX_TEXT, MEGABYTE

# A pipe that nobody writes to would keep `open` waiting for ever.
_FLAGS = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)


def failure(path: str | Path, reason: object, advice: str) -> InputError:
    """The error to raise about a file."""
    return InputError(f"{path}: {reason}{f'; {advice}' if advice else ''}")


@contextmanager
def open_regular(path: str | Path, limit: int, advice: str = "") -> Iterator[BinaryIO]:
    """Open a regular file of at most `limit` bytes.

    Args:
        path: of the file.
        limit: in bytes.
        advice: what to do about a file that cannot be read.

    Raises:
        InputError: when it is missing, larger, no regular file, or may not be read.
    """
    try:
        _check(os.stat(path), limit)  # before it is opened: to open a device may do something
        handle = os.open(path, _FLAGS)
    except FileNotFoundError:
        raise failure(path, "there is no such file", advice) from None
    except OSError as error:
        raise failure(path, f"cannot be read ({error.strerror or error})", advice) from error
    except ValueError as error:  # a null character in its name, or from `_check`
        raise failure(path, f"cannot be read ({error})", advice) from error
    with os.fdopen(handle, "rb") as file:
        try:
            _check(os.fstat(handle), limit)
        except ValueError as error:
            raise failure(path, f"cannot be read ({error})", advice) from error
        yield file


def read_bytes(path: str | Path, limit: int, advice: str = "") -> bytes:
    """All bytes of a regular file.

    Raises:
        InputError: as `open_regular`.
    """
    with open_regular(path, limit, advice) as file:
        try:
            data = file.read(limit + 1)  # it may have grown; those of /proc say that they are empty
        except OSError as error:
            raise failure(path, f"cannot be read ({error.strerror or error})", advice) from error
    if len(data) > limit:
        raise failure(path, f"cannot be read ({_too_large(limit)})", advice)
    return data


def read_text(path: str | Path, limit: int = MAX_TEXT, advice: str = "") -> str:
    """The text of a file in UTF-8, without the mark that editors of Windows put before it.

    Line ends of Windows become those of all others.

    Raises:
        InputError: as `open_regular`, and when it is no text.
    """
    try:
        text = read_bytes(path, limit, advice).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise failure(path, f"cannot be read (no UTF-8 text: {error})", advice) from None
    return text.replace("\r\n", "\n")


def _check(found: os.stat_result, limit: int) -> None:
    if stat.S_ISDIR(found.st_mode):
        raise InputError("it is a folder")
    if not stat.S_ISREG(found.st_mode):
        raise InputError("it is no regular file but a device or a pipe")
    if found.st_size > limit:
        raise InputError(f"it has {found.st_size / MEGABYTE:,.1f} MB, {_too_large(limit)}")


def _too_large(limit: int) -> str:
    return f"more than the {limit / MEGABYTE:g} MB that such a file may have"
