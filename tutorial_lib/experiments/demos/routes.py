"""Which drives a demo learns: two that its trip is composed of, and some others.

No drive leads all along the trip: that a path is found over several drives is what a map is for.
One drive begins at the trip's start and leaves it after two thirds, another comes to it after one
third and ends at its goal.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.data.demonstrations import demonstrate_on
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.trajectories import Trajectory
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.protocols.navigation_tasks import (
    Building,
    Trials,
    facing,
    long_enough,
)
from tutorial_lib.experiments.protocols.odometry import RECORDING
from tutorial_lib.geometry import Array, arc_length

LEARNED = 160.0
"""Metres of drives that a demo learns at most, unless the two of its trip are longer."""
_JOINED, _LEFT = 1 / 3, 2 / 3  # of the trip
_ASIDE = 2.0  # metres at least from where a drive leaves the trip to where it ends
_EARLIER = 12  # frames before a drive's end, where it may turn to stop beside a wall
_BEHIND = (1.8, 1.4, 1.0)
"""Metres before a goal from which a car drives straight to it; the first that is free is taken."""


def learned(building: Building, number: int, goal: Array, sure: Array) -> Building:
    """The building with only those drives that the demo learns.

    Args:
        building: with all drives between its places.
        number: of the drive that is the trip; it is learned only if others cannot take its place.
        goal: (3,) pose in which the last drive arrives; its heading may be NaN.
        sure: (D,) probability along each drive; the surest are learned.
    """
    drives, pairs = building.recorded.trajectories, building.pairs
    composed = composing(building, number, goal) or [drives[number]]
    needed = [(one, pairs[number]) for one in composed]
    room = LEARNED - sum(one.arc_length[-1] for one, _ in needed)
    others = [i for i in range(len(drives)) if i != number]
    for i in sorted(others, key=lambda i: -sure[i]):
        if drives[i].arc_length[-1] <= room:
            room -= drives[i].arc_length[-1]
            needed.append((drives[i], pairs[i]))
    recorded = RecordedWorld(building.scene, [one for one, _ in needed])
    return replace(building, recorded=recorded, pairs=np.array([pair for _, pair in needed]))


def composing(building: Building, number: int, goal: Array) -> list[Trajectory]:
    """Two drives that lead along a trip together, see above; none where there are no such drives.

    Args:
        building: with all drives between its places.
        number: of the drive that is the trip.
        goal: (3,) pose in which the second arrives; its heading may be NaN.
    """
    path, (start, end) = building.recorded.trajectories[number].poses, building.pairs[number]
    miles = arc_length(path)
    joined, left = (path[np.searchsorted(miles, part * miles[-1]), :2] for part in (_JOINED, _LEFT))
    others = np.setdiff1d(np.arange(len(building.places)), (start, end))
    metres = building.paths.fields([joined, left], shortest=True)
    to_joined, to_left = (metres.distance(building.places[others], i) for i in (0, 1))
    between = float(metres.distance(joined[None], 1)[0])
    # Near the trip, and so that the car need not turn round where it comes to it or leaves it.
    coming = others[np.argsort(to_joined + 2 * (to_joined + between - to_left), kind="stable")]
    leaving = to_left + 2 * (between + to_left - to_joined)
    leaving = others[np.argsort(np.where(to_left < _ASIDE, np.inf, leaving), kind="stable")]
    first = _first(building, [(path[0], [joined, left, building.places[to]]) for to in leaving])
    before = _before(building, goal)
    starts = _facing(building, coming, joined)
    last = _first(building, [(one, [joined, left, *before, goal[:2]]) for one in starts])
    return [first, last] if first is not None and last is not None else []


def trial_to(building: Building, number: int, start: Array, goal: Array) -> Trials | None:
    """The trial of a drive from a pose (3,) to a goal (3,).

    Where the goal's heading is NaN, its image is taken on the way, a little before the car stops.
    There is no trial where no car arrives.
    """
    drive = _drive(building, start, [*_before(building, goal), goal[:2]])
    if drive is None or not long_enough(drive):
        return None
    recorded = RecordedWorld(building.scene, [drive])
    goals = recorded.last[:1] - (_EARLIER if np.isnan(goal[2]) else 0)
    seconds = drive.timestamps[goals]
    return Trials(building.pairs[[number]], start[None], recorded, goals, seconds)


def check_arrival(building: Building, goal: Array, option: str) -> None:
    """Check that a car can drive straight ahead to a goal (3,).

    Raises:
        InputError: when there is no room.
    """
    if np.isfinite(goal[2]) and not _before(building, goal):
        raise InputError(
            f"{option}: no room to arrive at ({goal[0]:.2f}, {goal[1]:.2f}) with heading "
            f"{goal[2]:.2f}; turn it, or choose another place"
        )


def _before(building: Building, goal: Array) -> list[Array]:
    """The place (2,) before a goal (3,), straight ahead of which it is; none if without heading."""
    if np.isnan(goal[2]):
        return []
    back = goal[:2] - np.array(_BEHIND)[:, None] * [np.cos(goal[2]), np.sin(goal[2])]
    seen = building.scene.caster.sees(np.tile(goal[:2], (len(back), 1)), back)
    return list(back[seen & (building.paths.nearest(back)[0] >= 0)][:1])


def _facing(building: Building, places: NDArray[np.intp], goal: Array) -> Array:
    """Poses (D, 3) at places that look along the path to a goal (2,)."""
    count = len(places)
    ends = np.concatenate([building.places[places], goal[None]])
    pairs = np.stack([np.arange(count), np.full(count, count)], axis=1)
    return facing(building.scene, building.paths, ends, pairs, building.body)


def _first(building: Building, tried: list[tuple[Array, list[Array]]]) -> Trajectory | None:
    """The first drive, of those from a pose over several places, on which the car arrives."""
    drives = (_drive(building, start, goals) for start, goals in tried)
    return next((one for one in drives if long_enough(one)), None)


def _drive(building: Building, start: Array, goals: list[Array]) -> Trajectory | None:
    """A recorded drive of one car from a pose (3,) over places; none if it does not arrive."""
    noise = building.odometry.noise(RECORDING)
    where = building.name, building.scene, building.paths
    return demonstrate_on(*where, start[None], np.array(goals), 0, noise, building.body)
