"""Which part of a building's recorded drives all agents learn, and which trials that covers.

In the paper a drive joins every ordered pair of places, so that nearly every trial has a recorded
drive past its start and then its goal. Here a robot was shown less: a share of the drives, or a
tour from each place to the next and back.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tutorial_lib import validation
from tutorial_lib.driving.data.demonstrations import demonstrate_on
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.protocols.navigation import FACING, NEAR
from tutorial_lib.experiments.protocols.navigation_tasks import Building, Trials
from tutorial_lib.experiments.protocols.odometry import RECORDING
from tutorial_lib.se2 import Array, wrap

TOUR, CONTINUOUS = "tour", "continuous"
"""Separate drives from each place to the next and back; and the same as one continuous drive."""
PASSED = 1.0
"""Metres from a start within which a drive passes it."""


def parse_drives(text: str) -> str:
    """What `--drives` is given, checked: a share above 0 and up to 1, `tour` or `continuous`.

    All drives are the empty text.

    Raises:
        InputError: for anything else.

    >>> parse_drives("0.40")
    '0.4'
    """
    if validation.instance("drives", text, str) in ("", TOUR, CONTINUOUS):
        return text
    try:
        share = float(text)
    except ValueError:
        share = 0.0
    if not 0.0 < share <= 1.0:
        raise InputError(f"--drives {text}: give a share as 0.2, {TOUR} or {CONTINUOUS}")
    return f"{share:g}"


def part_of(building: Building, drives: str, seed: int) -> Building:
    """The building with only those drives recorded that agents learn.

    A part of the drives is that of Fig. 10, so that the two compare.

    Args:
        building: with all drives.
        drives: as from `parse_drives`; all of them if empty.
        seed: of the run; chooses which drives a share is.

    Raises:
        InputError: when none is left.
    """
    validation.instance("building", building, Building)
    drives, seed = parse_drives(drives), validation.whole("seed", seed, least=0)
    if not drives:
        return building
    if drives == CONTINUOUS:
        return toured(building)
    if drives == TOUR:
        wanted = [tuple(pair) for pair in tour(len(building.places))]
        known = {tuple(pair): i for i, pair in enumerate(building.pairs.tolist())}
        kept = [known[pair] for pair in wanted if pair in known]
    else:
        order = share_order(building, seed)
        kept = np.sort(order[: round(float(drives) * len(order))]).tolist()
    if not kept:
        raise InputError(f"--drives {drives}: none of {len(building.pairs)} is left; give more")
    recorded = RecordedWorld(building.scene, [building.recorded.trajectories[i] for i in kept])
    return replace(building, recorded=recorded, pairs=building.pairs[kept])


def share_order(building: Building, seed: int) -> NDArray[np.intp]:
    """The order in which drives are learned, the same for all methods."""
    seeds = [seed, building.odometry.seed[-1], 6]
    return np.random.default_rng(seeds).permutation(len(building.pairs))


def tour(places: int) -> NDArray[np.intp]:
    """(2P, 2) the drives of a tour through P places: around to the first, and all the way back.

    >>> tour(3).tolist()
    [[0, 1], [1, 2], [2, 0], [0, 2], [2, 1], [1, 0]]
    """
    around = [*range(places), 0]
    return np.array([*pairwise(around), *pairwise(around[::-1])])


def toured(building: Building) -> Building:
    """The building with one recorded drive: a tour, with the car's own turning manoeuvres.

    Raises:
        InputError: when the car did not come through.
    """
    order = tour(len(building.places))
    first = np.flatnonzero((building.pairs == order[0]).all(axis=1))
    start = building.recorded.poses[building.recorded.first_frames[first[:1]]]
    if not len(start):
        raise InputError(f"--drives {CONTINUOUS}: no drive leads from the first place to the next")
    goals, noise = building.places[order[:, 1]], building.odometry.noise(RECORDING)
    where = building.name, building.scene, building.paths
    drive = demonstrate_on(*where, start, goals, 0, noise, building.body)
    ends = np.zeros((1, 2), dtype=order.dtype)  # it comes back to the first place
    if drive is None:
        raise InputError(f"--drives {CONTINUOUS}: the car did not come through {building.name}")
    return replace(building, recorded=RecordedWorld(building.scene, [drive]), pairs=ends)


def driven_trials(whole: Building, trials: Trials, drives: str, seed: int) -> NDArray[np.bool_]:
    """Which trials (N,) some drive covers that agents learn; a continuous one is cut at the places.

    Args:
        whole: with all drives.
        trials: to be sorted.
        drives: as from `parse_drives`.
        seed: of the run.

    Raises:
        InputError: when an argument is of another kind.
    """
    validation.instance("whole", whole, Building)
    validation.instance("trials", trials, Trials)
    drives = parse_drives(drives)
    separate = TOUR if drives == CONTINUOUS else drives
    return driven(part_of(whole, separate, seed), trials, NEAR, FACING)


def driven(building: Building, trials: Trials, near: float, facing: float) -> NDArray[np.bool_]:
    """Which trials (N,) some recorded drive covers: it passes the start and later the goal.

    Args:
        building: with the drives that agents learn; a tour as separate drives.
        trials: to be sorted.
        near: metres from the goal, and `facing` rad from its heading, within which it is passed.
        facing: see `near`.
    """
    covered = np.zeros(len(trials), dtype=bool)
    for drive in building.recorded.trajectories:
        from_start = _gaps(drive.poses, trials.starts) < PASSED
        at_goal = _at_goals(drive.poses, trials, near, facing)
        first = np.where(from_start.any(axis=0), from_start.argmax(axis=0), len(drive))
        last = len(drive) - 1 - at_goal[::-1].argmax(axis=0)
        covered |= at_goal.any(axis=0) & (first <= last)
    return covered


def passed_goals(whole: Building, trials: Trials, drives: str, seed: int) -> NDArray[np.bool_]:
    """The goals (N,) that some drive passes that agents learn, facing as they do.

    No learned drive has an image of the others as they look there.

    Args:
        whole: with all drives.
        trials: with the goals.
        drives: as from `parse_drives`.
        seed: of the run.
    """
    learned = part_of(whole, drives, seed).recorded.poses
    return np.any(_at_goals(learned, trials, NEAR, FACING), axis=0)


def _at_goals(poses: Array, trials: Trials, near: float, facing: float) -> NDArray[np.bool_]:
    """Which poses (T, 3) are at which goals (T, N), facing as they do."""
    goals = trials.goal_poses
    faces = np.abs(wrap(poses[:, None, 2] - goals[:, 2])) < facing
    return (_gaps(poses, goals) < near) & faces


def _gaps(poses: Array, others: Array) -> Array:
    """Metres (T, N) from poses (T, 3) to others (N, 3)."""
    return np.linalg.norm(poses[:, None, :2] - others[None, :, :2], axis=2)
