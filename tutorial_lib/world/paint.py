"""The numba kernels that turn what rays met into pixels."""

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from tutorial_lib.world.materials import TEXEL, TEXELS

Singles = NDArray[np.float32]

HALF_LIGHT = 12.0
"""Metres at which a wall looks half as bright."""
_DARKENING = np.float32(1.0 / HALF_LIGHT)
_PER_TEXEL = np.float32(1.0 / TEXEL)
_LONGEST = np.float32(2.0)  # metres of wall that one column averages at most, to either side
_GRAZING = np.float32(0.02)  # sine of the flattest angle at which a wall is viewed
_NEAREST = np.float32(1e-3)  # metres
_ZERO_WIDTH = np.float32(1e-2)  # texels
_ZERO, _HALF, _ONE = np.float32(0), np.float32(0.5), np.float32(1)


@njit(cache=True, nogil=True, error_model="numpy")
def paint_columns(
    distance: NDArray[np.float64],
    wall: NDArray[np.int32],
    along: NDArray[np.float64],
    rays: NDArray[np.float64],
    poses: NDArray[np.float64],
    surfaces: Singles,
    strips: Singles,
    discs: Singles,
    spread: Singles,
    flatten: Singles,
    colours: Singles,
    nearness: Singles,
) -> None:
    """Write each column's colour (N, W, 3) and 1 / depth (N, W); column 0 is the last ray.

    `distance`, `wall` and `along` are those of `raycast.Hits`; `rays` (2, W) are directions in the
    robot's frame; `surfaces` and `strips` are those of
    `Scene`; `discs` (K, 3) are colours; `spread` (W,) is the angle in rad that a column covers,
    and `flatten` (W,) the ratio of its depth in the image to the ray's length.
    """
    many, walls = rays.shape[1], len(surfaces)
    for pose in range(len(poses)):
        cos, sin = np.float32(math.cos(poses[pose, 2])), np.float32(math.sin(poses[pose, 2]))
        for ray in range(many):
            s, t = wall[pose, ray], np.float32(distance[pose, ray])
            light = _ONE / (_ONE + t * _DARKENING)
            column = many - 1 - ray
            nearness[pose, column] = _ONE / max(t * flatten[ray], _NEAREST)
            if s < 0:
                colours[pose, column, 0] = colours[pose, column, 1] = colours[pose, column, 2] = 0
            elif s >= walls:
                for channel in range(3):
                    colours[pose, column, channel] = light * discs[s - walls, channel]
            else:
                ex = cos * np.float32(rays[0, ray]) - sin * np.float32(rays[1, ray])
                ey = sin * np.float32(rays[0, ray]) + cos * np.float32(rays[1, ray])
                strip, offset = int(surfaces[s, 0]), surfaces[s, 1]
                length, shade = surfaces[s, 2], surfaces[s, 3]
                facing = abs(ex * surfaces[s, 5] - ey * surfaces[s, 4])
                reach = min(_HALF * t * spread[ray] / max(facing, _GRAZING), _LONGEST)
                u = np.float32(along[pose, ray])
                first = (max(u - reach, _ZERO) + offset) * _PER_TEXEL
                last = max((min(u + reach, length) + offset) * _PER_TEXEL, first + _ZERO_WIDTH)
                # The stretch from first to last, in texels, of a strip that repeats.
                i, j = int(first), int(last)
                head, tail = first - np.float32(i), last - np.float32(j)
                rounds = np.float32(j // TEXELS - i // TEXELS)
                i, j = i % TEXELS, j % TEXELS
                scale = light * shade / (last - first)
                for channel in range(3):
                    a, b = strips[strip, i, channel], strips[strip, j, channel]
                    a += head * (strips[strip, i + 1, channel] - a)
                    b += tail * (strips[strip, j + 1, channel] - b)
                    total = rounds * strips[strip, TEXELS, channel] + b - a
                    colours[pose, column, channel] = scale * total


@njit(cache=True, nogil=True, error_model="numpy")
def paint_rows(
    colours: Singles,
    nearness: Singles,
    heights: Singles,
    slope: float,
    backdrop: Singles,
    image: NDArray[np.uint8],
) -> None:
    """Fill images (N, H, 3 W): in each pixel the exact shares of ceiling, wall and floor.

    `colours` (N, 3 W) are the walls'; `nearness` (N, W) is 1 / their depth; `heights` (2,) are
    the metres from the eye up to a wall's upper and to its lower end; `slope` is that of the
    image's upper edge, and its lower edge is at minus that; `backdrop` (2, 3) are the colours of
    ceiling and floor. `image` is written.
    """
    rows, width = image.shape[1], image.shape[2]
    upper, lower = np.empty(width, np.float32), np.empty(width, np.float32)
    to_ceiling, to_floor = np.empty(width, np.float32), np.empty(width, np.float32)
    colour = np.empty(width, np.float32)
    per_row = np.float32(rows / (2.0 * slope))
    horizon = np.float32(rows / 2.0)
    for n in range(len(image)):
        for column in range(width // 3):
            # The wall's ends, in rows from the image's upper edge, downwards.
            scale = nearness[n, column] * per_row
            a, b = horizon - heights[0] * scale, horizon - heights[1] * scale
            for channel in range(3):
                i = 3 * column + channel
                upper[i], lower[i] = a, b
                to_ceiling[i] = backdrop[0, channel] - colours[n, i]
                to_floor[i] = backdrop[1, channel] - colours[n, i]
                colour[i] = colours[n, i] + _HALF  # so that truncation rounds
        for row in range(rows):
            line = image[n, row]
            first, end = np.float32(row), np.float32(row + 1)
            for i in range(width):
                above = min(max(upper[i] - first, _ZERO), _ONE)
                below = min(max(end - lower[i], _ZERO), _ONE)
                line[i] = np.uint8(colour[i] + above * to_ceiling[i] + below * to_floor[i])
