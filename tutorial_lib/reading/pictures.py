"""Pictures of the kinds in which maps are saved; each says its size before it is decoded."""

import io
import re
import struct
import warnings
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from tutorial_lib.errors import InputError
from tutorial_lib.reading.limits import MAX_PICTURE, MAX_PIXELS, MAX_PLAIN_PIXELS
from tutorial_lib.reading.regular import failure, read_bytes

_PNM = re.compile(rb"P[2356]" + 3 * rb"(?:\s|#[^\n]*\n)+(\d{1,9})" + rb"(?=\s)")
_LONGEST_HEADER = 10_000  # bytes of a PNM's, comments included
_NOT_WHOLE = (
    "this is no whole PGM, PPM, PNG, BMP, JPEG or TIFF picture; was it cut off, or is it of "
    "another kind?"
)
_AS_THEY_ARE = ("L", "LA", "RGB", "RGBA", "I;16", "I;16B")
"""Pillow's names of pixels whose numbers are taken; others are converted, or refused."""
_CONVERTED = {"1": "L", "P": "RGBA", "PA": "RGBA", "RGBa": "RGBA", "La": "LA"} | dict.fromkeys(
    ("CMYK", "YCbCr", "LAB", "RGBX"), "RGB"
)


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


def read_picture(path: str | Path) -> Picture:
    """A picture from a PGM, PPM, PNG, BMP, JPEG or TIFF file, whatever its name ends in.

    Raises:
        InputError: when the file cannot be read, was cut off, is of another kind, or larger than
            `MAX_PIXELS`.
    """
    data = read_bytes(path, MAX_PICTURE)
    try:
        return decode_picture(data)
    except InputError as error:
        raise failure(path, error, "") from error


def decode_picture(data: bytes) -> Picture:
    """A picture from the bytes of its file; see `read_picture`."""
    if data[:2] in (b"P2", b"P3", b"P5", b"P6"):
        return _decode_pnm(data)
    if data[:2] == b"\xff\xd8" or data[:4] in (b"II*\0", b"MM\0*"):
        return _decode_with_pillow(data)
    chunks = _chunks_of_png(data)
    size = struct.unpack_from(">II", chunks[b"IHDR"]) if chunks else _size_of_bmp(data)
    if size is None:
        raise InputError(_NOT_WHOLE)
    width, height = size
    _check_size(width, height, MAX_PIXELS)
    try:
        values = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    except cv2.error:
        values = None
    if values is None or values.dtype not in (np.uint8, np.uint16) or values.shape[1::-1] != size:
        raise InputError(_NOT_WHOLE)
    values = values.reshape(*values.shape[:2], -1)
    top = 255 if values.dtype == np.uint8 else 65_535
    if b"tRNS" in chunks and values.shape[2] in (1, 3):
        values = _with_transparency(values, top, chunks)
    return Picture(values, top)


def _chunks_of_png(data: bytes) -> dict[bytes, bytes]:
    """The chunks of a PNG by name; none for anything else, or for a damaged one."""
    if data[:8] != b"\x89PNG\r\n\x1a\n":
        return {}
    view, start, chunks = memoryview(data), 8, {}
    while b"IEND" not in chunks:
        if start + 12 > len(data):
            return {}
        (length,) = struct.unpack_from(">I", data, start)
        end, name = start + 8 + length, data[start + 4 : start + 8]
        # OpenCV decodes what stands before a wrong checksum, and says nothing.
        if data[end : end + 4] != struct.pack(">I", zlib.crc32(view[start + 4 : end])):
            return {}
        if (name == b"IHDR") == bool(chunks) or (name == b"IHDR" and length != 13):
            return {}  # it is the first one, and the only one of its name
        chunks[name] = b"" if name == b"IDAT" else data[start + 8 : end]
        start = end + 4
    return {} if b"acTL" in chunks else chunks


def _with_transparency(values: NDArray[Any], top: int, chunks: dict[bytes, bytes]) -> NDArray[Any]:
    """Grey or coloured pixels with their opacity: a PNG may name one colour that is transparent."""
    depth, named = chunks[b"IHDR"][8], chunks[b"tRNS"]
    if len(named) != 2 * values.shape[2]:
        raise InputError(_NOT_WHOLE)
    key = np.frombuffer(named, ">u2")[::-1] * (top // (2**depth - 1))
    clear = (values == key).all(axis=2, keepdims=True)
    return np.concatenate([values, np.where(clear, 0, top).astype(values.dtype)], axis=2)


def _decode_with_pillow(data: bytes) -> Picture:
    """A JPEG or TIFF; OpenCV would accept one that was cut off."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of what is said beside the pixels
            with Image.open(io.BytesIO(data), formats=("JPEG", "TIFF")) as picture:
                _check_size(*picture.size, MAX_PIXELS)
                if picture.mode not in (*_AS_THEY_ARE, *_CONVERTED):
                    raise InputError(
                        f"its pixels are of the kind {picture.mode}; save them as 8 or 16 bits"
                    )
                values = np.asarray(picture.convert(_CONVERTED.get(picture.mode, picture.mode)))
    except InputError:
        raise
    except Image.DecompressionBombError:
        raise InputError(
            f"it has more than the {MAX_PIXELS:,} pixels that are read; scale it down, with larger "
            "cells"
        ) from None
    # Pillow has a dozen errors for a damaged file.
    except Exception as error:
        raise InputError(_NOT_WHOLE) from error
    values = values.reshape(*values.shape[:2], -1)
    colours = values.shape[2] // 3 * 3  # Pillow has red before blue
    values = np.concatenate([values[..., :colours][..., ::-1], values[..., colours:]], axis=2)
    return Picture(values, int(np.iinfo(values.dtype).max))


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


def _decode_pnm(data: bytes) -> Picture:
    """A PGM or PPM in text (P2, P3) or bytes (P5, P6); OpenCV would accept one that was cut off."""
    header = _PNM.match(data[:_LONGEST_HEADER])
    if header is None:
        raise InputError("its PGM or PPM header is broken; give width, height and largest value")
    width, height, top = (int(group) for group in header.groups())
    if not 0 < top < 65536:
        raise InputError(f"its header says values up to {top}; give 1 to 65535")
    plain, channels = data[:2] in (b"P2", b"P3"), 3 if data[:2] in (b"P3", b"P6") else 1
    _check_size(width, height, MAX_PLAIN_PIXELS // channels if plain else MAX_PIXELS)
    count = width * height * channels
    if plain:
        values = _plain_values(data[header.end() :], count, top)
    else:
        kind = np.dtype(np.uint8 if top < 256 else ">u2")
        body = memoryview(data)[header.end() + 1 :]
        values = np.frombuffer(body, kind, min(count, len(body) // kind.itemsize))
    if len(values) < count:
        raise InputError(
            f"holds {len(values) // channels} of {width} x {height} pixels; it was cut off, save "
            "it again"
        )
    return Picture(np.minimum(values, top).reshape(height, width, channels)[..., ::-1], top)


def _plain_values(body: bytes, count: int, top: int) -> NDArray[np.int64]:
    """The first `count` numbers of text, or as many as there are."""
    words = re.sub(rb"#[^\n]*", b"", body).split(maxsplit=count)[:count]
    try:
        return np.array([max(0, min(int(word), top)) for word in words], dtype=np.int64)
    except ValueError:
        raise InputError("a pixel is no number; save the picture again") from None
