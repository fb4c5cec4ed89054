"""Where a robot is in a node of its graph, by the walls that both see around them.

Heading drifts with every turn, and neither F_L nor F_R says what it is. Two panoramas with depth
do: turned until their distances correlate, then moved until walls lie on walls.
"""

from __future__ import annotations

import numpy as np

from tutorial_lib.se2 import Array
from tutorial_lib.topology.mapping.scan_matching import agreement, likely_rotations, match_scans

AGREE = 0.85
"""Share of the points that either panorama must confirm. On validation worlds three pairs of four
reach it, of which 97 to 100 % are within 0.3 m and 10 degrees."""
_APART = 1.5  # metres from where the robot seems to be, at most
_ROTATIONS = 2  # that are tried beside the heading by odometry


def match_walls(nodes: Array, ranges: Array, guesses: Array) -> Array:
    """A `ScanMatcher`: poses (M, 3) of robots in the frames of nodes.

    A row is not a number where walls do not agree, or lie too far from the guess.
    """
    return match_all_around(nodes, ranges, guesses, AGREE)[0]


def match_all_around(
    nodes: Array, ranges: Array, guesses: Array, least: float
) -> tuple[Array, Array]:
    """The same, whatever a robot's heading, and the agreement (M,); `least` of it is accepted."""
    first, second = _scans(nodes), _scans(ranges)
    starts = np.repeat(guesses[:, None], 1 + _ROTATIONS, axis=1)
    for row, (one, other) in enumerate(zip(first, second, strict=True)):
        starts[row, 1:, 2] = likely_rotations(one[None], other[None], 0.0, _ROTATIONS)[1][0, 0]
    poses, shares = match_scans(first, second, starts)
    off = np.linalg.norm(poses[:, :2] - guesses[:, :2], axis=1)
    fits = (shares >= least) & (off < _APART)
    return np.where(fits[:, None], poses, np.nan), shares


def goes_on(before: Array, ranges: Array, motions: Array) -> Array:
    """The share (M,) of what robots see that fits to what they saw before, by odometry.

    Args:
        before: (M, W) metres in each column, a moment ago.
        ranges: (M, W) now.
        motions: (M, 3) of the robots since then.

    Returns:
        0 to 1; 0 where nothing can be compared, as when somebody carried the robot away.
    """
    return np.nan_to_num(agreement(_scans(before), _scans(ranges), motions))


def _scans(ranges: Array) -> Array:
    """Panoramas (M, W) as laser scans, whose beams rise from -pi."""
    return np.ascontiguousarray(ranges[:, ::-1], dtype=float)
