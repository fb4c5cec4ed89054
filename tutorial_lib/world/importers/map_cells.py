"""Which cells of a ROS map are free: what its YAML file says of the pixels of its picture.

The meaning of every key is that of nav2's map_server.
"""

import os
import re
import unicodedata
import warnings
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError, Notice
from tutorial_lib.reading.documents import scalar_of
from tutorial_lib.reading.pictures import Picture, read_picture
from tutorial_lib.world.fields import Field

MODES = ("trinary", "scale", "raw")
_AT_ONCE = 1_000_000  # pixels
_PERCENT = 100  # of a raw map; a pixel above that is unknown
_YES, _NO = ("y", "yes", "true", "on"), ("n", "no", "false", "off")  # to yaml-cpp


def number_of(entry: Field) -> float:
    """A finite number; also one in quotes, which yaml-cpp does not mind."""
    quoted = isinstance(entry.value, str)
    return Field(scalar_of(entry.value) if quoted else entry.value, entry.where).number()


def free_cells(root: Field, folder: Path) -> NDArray[np.bool_]:
    """Which cells are known to be free (H, W), row 0 the lowest y.

    Args:
        root: of the YAML file.
        folder: that it lies in.

    Raises:
        InputError: naming the key that is missing, malformed or makes no sense.
    """
    low, high = _thresholds(root)
    mode = root["mode"].text() if "mode" in root else "trinary"
    if mode not in MODES:
        raise root["mode"].fail(f"give one of {', '.join(MODES)}")
    negate = _flag(root["negate"])
    picture = _picture(root["image"], folder)
    height, width, channels = picture.values.shape
    pixels = picture.values.reshape(-1, channels)
    # Some at a time: as numbers of 64 bits they need many times the room.
    free = [
        _free_pixels(pixels[first : first + _AT_ONCE] / picture.top, mode, negate, low, high)
        for first in range(0, len(pixels), _AT_ONCE)
    ]
    return np.concatenate(free).reshape(height, width)[::-1]


def _free_pixels(
    levels: NDArray[np.float64], mode: str, negate: bool, low: float, high: float
) -> NDArray[np.bool_]:
    """Which of N pixels (N, C), 0 to 1, are known to be free; what is transparent is unknown."""
    colours = 1 if levels.shape[1] < 3 else 3
    known = (levels[:, colours:] >= 1.0).all(axis=1)
    shade = levels[:, :colours].mean(axis=1)
    if mode == "raw":  # the pixel is the occupancy in per cent
        percent = np.floor(255.0 * shade + 0.5)
        known &= percent <= _PERCENT
        occupied = percent / _PERCENT
    else:
        occupied = shade if negate else 1.0 - shade
    return known & (occupied < low) & ~(occupied > high)


def _thresholds(root: Field) -> tuple[float, float]:
    """free_thresh and occupied_thresh."""
    low, high = number_of(root["free_thresh"]), number_of(root["occupied_thresh"])
    for key, value in (("free_thresh", low), ("occupied_thresh", high)):
        if not 0.0 <= value <= 1.0:
            raise root[key].fail("give a share from 0 to 1")
    if low > high:
        raise root["free_thresh"].fail(f"give at most occupied_thresh, {high:g}")
    return low, high


def _flag(entry: Field) -> bool:
    """A truth value or a whole number; also in quotes."""
    value = scalar_of(entry.value) if isinstance(entry.value, str) else entry.value
    if isinstance(value, str) and value.lower() in (*_YES, *_NO):
        return value.lower() in _YES
    if not isinstance(value, bool | int):
        raise entry.fail("give 0 or 1")
    return bool(value)


def _picture(entry: Field, folder: Path) -> Picture:
    """The picture that is named, or lies beside the YAML file."""
    named = entry.text()
    path = folder / os.path.expanduser(named)
    if not os.path.lexists(path):
        beside = _beside(named, folder)
        if beside is not None:
            warnings.warn(
                Notice(f"{entry.where}: {named!r} is not there; took {beside.name!r} beside it"),
                stacklevel=5,
            )
            path = beside
    try:
        return read_picture(path)
    except InputError as error:
        raise entry.fail(f"{error}; put a whole picture beside the YAML file") from None


def _beside(named: str, folder: Path) -> Path | None:
    """The picture that is meant by a path of another machine, if it can be known.

    That is the path with its separators turned; what bears its name beside the YAML file, however
    its letters are encoded; or, if the path cannot be one of this machine, the only picture there
    of its kind.
    """
    parts = re.split(r"[\\/]+", named)
    turned = folder.joinpath(*parts)
    if parts[0] and os.path.isfile(turned):
        return turned
    files = sorted(path for path in folder.iterdir() if os.path.isfile(path))
    same = [path for path in files if _plain(path.name) == _plain(parts[-1])]
    if "\\" in named or named[0] in "/~":
        suffix = Path(parts[-1]).suffix.lower()
        alike = [path for path in files if suffix and path.suffix.lower() == suffix]
        same = same or alike
    return same[0] if len(same) == 1 else None


def _plain(name: str) -> str:
    """A file's name as systems see it that take no notice of case, or store accents apart."""
    return unicodedata.normalize("NFC", name).casefold()
