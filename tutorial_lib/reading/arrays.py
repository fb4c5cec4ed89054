"""Arrays by name, from the `.npz` files that `files.save_arrays` writes."""

import struct
import zipfile
from collections.abc import Collection
from math import prod
from pathlib import Path
from typing import Any, BinaryIO

from numpy.lib import format as npy
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.reading.limits import MAX_ARRAYS, MAX_DIRECTORY, MAX_MEMBERS, MEGABYTE
from tutorial_lib.reading.regular import failure, open_regular

_END = struct.Struct("<4s4xHHIIH")  # of an archive: mark, arrays twice, its table, its comment
_ANOTHER_END = b"PK\x06\x07"  # stands before it in archives of more than 4 GB
_METHODS = zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED
"""How arrays are compressed: of these no more is unpacked than is asked for."""
_HEADERS = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}


def load_arrays(
    path: str | Path, names: Collection[str], *, version: int | None = None, advice: str = ""
) -> dict[str, NDArray[Any]]:
    """Read the arrays that `save_arrays` wrote; nothing is ever unpickled.

    The sizes that the file declares are checked before anything is unpacked, and each array has a
    checksum (CRC-32).

    Args:
        path: of the file.
        names: of the arrays that it must hold.
        version: that it must have; not compared unless given.
        advice: what to do about a file that cannot be read.

    Raises:
        InputError: when the file is missing, damaged, too large, of another version, or lacks an
            array; it names the file, says what is wrong, and ends with the advice.
    """
    with open_regular(path, MAX_ARRAYS, advice) as file:
        try:
            arrays = _read_arrays(file)
            if version is not None:
                _check_version(arrays, version)
            for name in names:
                if name not in arrays:
                    raise InputError(f"damaged ({name!r} is missing)")
        except InputError as error:
            raise failure(path, error, advice) from error
        # zipfile, zlib and numpy's header reader have a dozen errors for a damaged file.
        except Exception as error:
            raise failure(path, f"damaged, or not an .npz file ({error})", advice) from error
    return arrays


def _read_arrays(file: BinaryIO) -> dict[str, NDArray[Any]]:
    _check_end(file)
    with zipfile.ZipFile(file) as archive:
        members = archive.infolist()
        unpacked = sum(member.file_size for member in members)
        if unpacked > MAX_ARRAYS:
            raise InputError(
                f"its arrays would have {unpacked / MEGABYTE:,.0f} MB, more than the "
                f"{MAX_ARRAYS / MEGABYTE:g} MB that they may have"
            )
        for member in members:
            if member.compress_type not in _METHODS:
                raise InputError(
                    f"{member.filename!r} is compressed by method {member.compress_type}; only "
                    "stored and deflated arrays are read, as numpy writes them"
                )
        names = [member.filename.removesuffix(".npy") for member in members]
        if len(set(names)) < len(names):
            raise ValueError("two arrays of one name")
        return {name: _read(archive, of) for name, of in zip(names, members, strict=True)}


def _check_end(file: BinaryIO) -> None:
    """Check the size of the archive's table of contents, which `zipfile` reads as a whole."""
    ending = _END.size + 20
    file.seek(max(file.seek(0, 2) - ending, 0))
    tail = file.read(ending)
    if len(tail) < _END.size:
        raise ValueError("it is too short")
    mark, here, members, table, _, comment = _END.unpack(tail[-_END.size :])
    if mark != b"PK\x05\x06" or comment or here != members or tail.startswith(_ANOTHER_END):
        raise ValueError("its end is missing")
    if members > MAX_MEMBERS or table > MAX_DIRECTORY:
        raise ValueError(f"{members} arrays, more than the {MAX_MEMBERS} that it may have")


def _read(archive: zipfile.ZipFile, member: zipfile.ZipInfo) -> NDArray[Any]:
    """One array, if it is as large as its own header says."""
    with archive.open(member) as file:
        read_header = _HEADERS[npy.read_magic(file)]
        shape, _, kind = read_header(file)
        if kind.hasobject:
            raise ValueError(f"{member.filename} holds Python objects")
        if file.tell() + prod(shape) * kind.itemsize != member.file_size:
            raise ValueError(f"{member.filename} is not as large as its header says")
    with archive.open(member) as file:
        array = npy.read_array(file, allow_pickle=False)
        file.read(1)  # its end, where the checksum is compared
    return array


def _check_version(arrays: dict[str, NDArray[Any]], version: int) -> None:
    found = arrays.pop("version", None)
    if found is None or found.shape or found.dtype.kind not in "iu":
        raise InputError(f"damaged, or not a file of version {version}")
    if found != version:
        raise InputError(f"of version {found}; this program reads version {version}")
