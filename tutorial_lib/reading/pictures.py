"""Pictures: PNG, BMP and PGM, whose size is read from their header before they are decoded."""

import re
import struct
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.reading.limits import MAX_PICTURE, MAX_PIXELS, MAX_PLAIN_PIXELS
from tutorial_lib.reading.regular import failure, read_bytes

_PGM = re.compile(rb"P[25]" + 3 * rb"(?:\s|#[^\n]*\n)+(\d{1,9})" + rb"(?=\s)")
_LONGEST_HEADER = 10_000  # bytes of a PGM's, comments included


@dataclass(frozen=True)
class Picture:
    """A picture as it was saved.

    Attributes:
        values: (H, W, C) whole numbers, row 0 the highest; C is 1 (grey), 2 (grey, opacity), 3
            (blue, green, red) or 4 (the same and opacity).
        top: the number that stands for white, or for opaque.
    """

    values: NDArray[Any]
    top: int


def read_picture(path: str | Path, advice: str = "") -> Picture:
    """A picture from a PNG, BMP or PGM file.

    Raises:
        InputError: when the file cannot be read, was cut off, is of another kind, or larger than
            `MAX_PIXELS`; it ends with the advice.
    """
    data = read_bytes(path, MAX_PICTURE, advice)
    try:
        return decode_picture(data)
    except InputError as error:
        raise failure(path, error, advice) from error


def decode_picture(data: bytes) -> Picture:
    """A picture from the bytes of its file; see `read_picture`."""
    if data[:2] in (b"P2", b"P5"):
        return _decode_pgm(data)
    size = _size_of_png(data) or _size_of_bmp(data)
    if size is None:
        raise InputError("this is no whole PGM, PNG or BMP picture; was it cut off?")
    _check_size(*size, MAX_PIXELS)
    try:
        values = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:
        values = None
    if values is None or values.dtype not in (np.uint8, np.uint16) or values.shape[1::-1] != size:
        raise InputError("this is no whole PGM, PNG or BMP picture; was it cut off?")
    return Picture(values.reshape(*values.shape[:2], -1), int(np.iinfo(values.dtype).max))


def _size_of_png(data: bytes) -> tuple[int, int] | None:
    """Width and height that a PNG declares; None for anything else, or a damaged one."""
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        return None
    view, start, chunks = memoryview(data), 8, []
    while chunks[-1:] != [b"IEND"]:
        if start + 12 > len(data):
            return None
        (length,) = struct.unpack_from(">I", data, start)
        end = start + 8 + length
        chunks.append(data[start + 4 : start + 8])
        # OpenCV decodes what stands before a wrong checksum, and says nothing.
        if data[end : end + 4] != struct.pack(">I", zlib.crc32(view[start + 4 : end])):
            return None
        start = end + 4
    if chunks[0] != b"IHDR" or chunks.count(b"IHDR") > 1 or b"acTL" in chunks:
        return None
    width, height = struct.unpack_from(">II", data, 16)
    return width, height


def _size_of_bmp(data: bytes) -> tuple[int, int] | None:
    """Width and height that a BMP declares; None for anything else, or a part of one."""
    if data[:2] != b"BM" or len(data) < 54:
        return None
    whole, header = struct.unpack_from("<I8xI", data, 2)
    width, height = struct.unpack_from("<ii", data, 18)
    return (width, abs(height)) if whole <= len(data) and header >= 40 else None


def _check_size(width: int, height: int, most: int) -> None:
    if width <= 0 or height <= 0:
        raise InputError(f"its header says {width} x {height} pixels; give sizes above 0")
    if width * height > most:
        raise InputError(
            f"its header says {width:,} x {height:,} pixels, more than the {most:,} that are read; "
            "scale it down, with larger cells"
        )


def _decode_pgm(data: bytes) -> Picture:
    """A PGM in text (P2) or bytes (P5); OpenCV would accept one that was cut off."""
    header = _PGM.match(data[:_LONGEST_HEADER])
    if header is None:
        raise InputError("its PGM header is broken; give width, height and largest value")
    width, height, top = (int(group) for group in header.groups())
    if not 0 < top < 65536:
        raise InputError(f"its PGM header says values up to {top}; give 1 to 65535")
    plain = data[:2] == b"P2"
    _check_size(width, height, MAX_PLAIN_PIXELS if plain else MAX_PIXELS)
    count = width * height
    if plain:
        values = _plain_values(data[header.end() :], count, top)
    else:
        kind = np.dtype(np.uint8 if top < 256 else ">u2")
        body = memoryview(data)[header.end() + 1 :]
        values = np.frombuffer(body, kind, min(count, len(body) // kind.itemsize))
    if len(values) < count:
        raise InputError(
            f"holds {len(values)} of {width} x {height} pixels; it was cut off, save it again"
        )
    return Picture(np.minimum(values, top).reshape(height, width, 1), top)


def _plain_values(body: bytes, count: int, top: int) -> NDArray[np.int64]:
    """The first `count` numbers of text, or as many as there are."""
    words = re.sub(rb"#[^\n]*", b"", body).split(maxsplit=count)[:count]
    try:
        return np.array([max(0, min(int(word), top)) for word in words], dtype=np.int64)
    except ValueError:
        raise InputError("a pixel is no number; save the PGM again") from None
