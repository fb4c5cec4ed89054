"""Where a robot is in a node of its graph, by the walls that both see around them.

Heading drifts with every turn, and neither F_L nor F_R says what it is. Two panoramas with depth
do: turned until their distances correlate, then moved until walls lie on walls.
"""

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.se2 import Array, relative, wrap
from tutorial_lib.topology.mapping.scan_matching import likely_rotations, match_scans

AGREE = 0.85
"""Share of the points that either panorama must confirm: such poses are right within 0.3 m and 10
degrees (`tests/agents/test_lifelong.py`)."""
_APART = 1.5  # metres from where the robot seems to be, at most
_STEP, _TURN = 0.4, 0.3  # metres and rad by which odometry is wrong from one look to the next
_ROTATIONS = 2  # that are tried beside the heading by odometry


def match_walls(nodes: Array, ranges: Array, guesses: Array) -> Array:
    """A `ScanMatcher`: poses (M, 3) of robots in the frames of nodes.

    The heading by odometry is tried first: a corridor looks the same both ways. A row is not a
    number where walls do not agree, or lie too far from the guess.
    """
    found = match_near(nodes, ranges, guesses)
    rest = np.flatnonzero(np.isnan(found[:, 0]))
    found[rest] = match_all_around(nodes[rest], ranges[rest], guesses[rest], AGREE)[0]
    return found


def match_all_around(
    nodes: Array, ranges: Array, guesses: Array, least: float
) -> tuple[Array, Array]:
    """The same, whatever a robot's heading, and the agreement (M,); `least` of it is accepted."""
    first, second = _scans(nodes), _scans(ranges)
    starts = np.repeat(guesses[:, None], 1 + _ROTATIONS, axis=1)
    for row, (one, other) in enumerate(zip(first, second, strict=True)):
        starts[row, 1:, 2] = likely_rotations(one[None], other[None], 0.0, _ROTATIONS)[1][0, 0]
    poses, shares = match_scans(first, second, starts)
    fits = (shares >= least) & _near(guesses, poses, _APART, np.inf)
    return np.where(fits[:, None], poses, np.nan), shares


def _near(guesses: Array, poses: Array, metres: float, turn: float) -> NDArray[np.bool_]:
    """(M,) whether poses are that near to what was guessed."""
    gaps = relative(guesses, poses)
    return (np.hypot(gaps[:, 0], gaps[:, 1]) < metres) & (np.abs(wrap(gaps[:, 2])) < turn)


def match_near(nodes: Array, ranges: Array, guesses: Array) -> Array:
    """Poses (M, 3) of robots that have hardly drifted; not a number where walls do not agree."""
    poses, shares = match_scans(_scans(nodes), _scans(ranges), guesses[:, None])
    fits = (shares >= AGREE) & _near(guesses, poses, _STEP, _TURN)
    return np.where(fits[:, None], poses, np.nan)


def goes_on(before: Array, ranges: Array, motions: Array) -> Array:
    """The share (M,) of what robots see that fits to what they saw before, near their odometry.

    It is near 1 from one look to the next, and low where a robot was carried elsewhere
    (`tests/agents/test_lifelong.py`).

    Args:
        before: (M, W) metres in each column, a moment ago.
        ranges: (M, W) now.
        motions: (M, 3) of the robots since then.
    """
    poses, shares = match_scans(_scans(before), _scans(ranges), motions[:, None])
    return np.where(_near(motions, poses, _STEP, _TURN), np.nan_to_num(shares), 0.0)


def _scans(ranges: Array) -> Array:
    """Panoramas (M, W) as laser scans, whose beams rise from -pi."""
    return np.ascontiguousarray(ranges[:, ::-1], dtype=float)
