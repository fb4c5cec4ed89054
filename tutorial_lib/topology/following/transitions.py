"""The rules of path following, as functions of arrays (Meng 2020, III-H).

Each takes M robots at once and has no state; `follower` keeps that.
"""

from dataclasses import dataclass, fields
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.validation import alike, flags, floats, instance, integers, number, whole

Places = NDArray[np.intp]
"""Of anchors along a path, from 0; -1 where none was visited yet."""


class State(IntEnum):
    """What a robot is doing."""

    SEARCH = 0
    FOLLOW = 1
    DEAD_RECKONING = 2
    LOST = 3
    DONE = 4
    TURN = 5


@dataclass(frozen=True)
class FollowerSettings:
    """Thresholds of the follower.

    Overlaps are means of the two that are predicted. Straight ahead, 0.8 is about 0.4 m away, 0.65
    about 0.9 m and 0.5 about 1.5 m.

    Attributes:
        p_search: RE of the best anchor above which the robot is localized on its path.
        p_follow: RE of an anchor above which the robot drives to it.
        p_lose: RE of the active anchor below which dead reckoning takes over.
        p_try: RE of the active anchor above which a new waypoint is requested at the end of dead
            reckoning.
        fall: a doubt begins where RE of the active anchor falls by more than this within a step,
            from above `p_follow`. It ends once RE of the anchor that is active then is above
            `p_follow`; a robot that doubts for `timeout` is lost. 1 for no doubts.
        near: overlap above which an anchor is within proximity.
        visited: overlap above which the closest anchor counts as visited.
        at: metres to the predicted waypoint below which the robot is at the anchor.
        facing: overlap above which a robot at an anchor has its heading.
        effort: seconds without coming nearer after which an anchor is given up.
        confirm: steps in a row that confirm arrival, or being back on the path.
        timeout: seconds without progress after which a robot is lost.
        calm: seconds of progress in a row after which the time without progress is forgotten.
        widest: anchors before and after the active one that dead reckoning looks for.
    """

    p_search: float = 0.92
    p_follow: float = 0.92
    p_lose: float = 0.4
    p_try: float = 0.2
    fall: float = 0.2
    near: float = 0.6
    visited: float = 0.8
    at: float = 0.25
    facing: float = 0.65
    effort: float = 5.0
    confirm: int = 5
    timeout: float = 4.0
    calm: float = 1.0
    widest: int = 4

    def __post_init__(self) -> None:
        for field in fields(self):
            name, value = f"follower: {field.name}", getattr(self, field.name)
            if field.name in ("confirm", "widest"):
                whole(name, value, least=1)
                continue
            number(name, value)
            if field.name in ("at", "effort", "timeout", "calm"):
                fits, wanted = 0.0 <= value < np.inf, "a finite number, 0 or greater"
            elif field.name == "fall":
                fits, wanted = 0.0 < value <= 1.0, "a number above 0, at most 1"
            else:
                fits, wanted = 0.0 < value < 1.0, "a number between 0 and 1"
            if not fits:
                raise InputError(f"follower: {field.name} = {value}; give {wanted}")
        if self.p_lose > self.p_follow:
            raise InputError(
                f"follower: p_lose = {self.p_lose}, p_follow = {self.p_follow}; give p_lose that "
                "is not greater"
            )


def last_visited(
    visited: Places, active: Places, overlaps: Array, at: NDArray[np.bool_], least: float
) -> Places:
    """The anchor last visited: the closest around the active one, and never an earlier one.

    Args:
        visited: (M,) until now.
        active: (M,) that the robots drive to.
        overlaps: (M, 3) with the anchors before, at and after the active one; not a number where
            not predicted.
        at: (M,) whether the robot is at the active anchor, whatever its heading.
        least: overlap that the closest must have to count as visited.

    >>> overlaps = [[0.7, 0.9, 0.8], [0.7, 0.7, 0.6], [0.3, 0.3, 0.2]]
    >>> last_visited([4, 4, 4], [5, 5, 5], overlaps, [False, False, True], 0.75).tolist()
    [5, 4, 5]
    """
    visited, active = integers("visited", visited, ("M",)), integers("active", active, ("M",))
    overlaps = floats("overlaps", overlaps, ("M", 3), nan=True)
    at, least = flags("at", at, ("M",)), number("least", least)
    alike(visited=visited, active=active, overlaps=overlaps, at=at)
    overlaps = np.nan_to_num(overlaps, nan=-1.0)
    closest = active - 1 + overlaps.argmax(axis=1)
    found = np.where(overlaps.max(axis=1) > least, closest, -1)
    return np.maximum.reduce([visited, found, np.where(at, active, -1)])


def next_active(
    active: Places,
    visited: Places,
    probability: ArrayLike,
    overlap: ArrayLike,
    settings: FollowerSettings,
) -> Places:
    """The anchor to drive to, neither too close nor too far away.

    It is the next one, once that can be reached and is within proximity, or the active one was
    visited. (The paper lets it fall back to the one after the last visited; here it stays.)

    Args:
        active: (M,) until now.
        visited: (M,) as it is now.
        probability: (M,) RE of the anchor after the active one; not a number after the last.
        overlap: (M,) with that anchor.
        settings: the thresholds.

    >>> reach, overlap = [1.0, 1.0, 0.0, 0.0], [0.7, 0.5, 0.7, 0.1]
    >>> next_active([5, 5, 5, 5], [4, 4, 4, 5], reach, overlap, FollowerSettings()).tolist()
    [6, 5, 5, 6]
    """
    active, visited = integers("active", active, ("M",)), integers("visited", visited, ("M",))
    probability = floats("probability", probability, ("M",), nan=True)
    overlap = floats("overlap", overlap, ("M",), nan=True)
    alike(active=active, visited=visited, probability=probability, overlap=overlap)
    instance("settings", settings, FollowerSettings)
    ready = (probability > settings.p_follow) & (overlap > settings.near)
    passed = ~np.isnan(probability) & (visited >= active)
    return active + (ready | passed)


def found_again(active: Places, probabilities: ArrayLike, least: float) -> Places:
    """The anchor by which a robot may be back on its path: the nearest of those reachable.

    Args:
        active: (M,) place along the path.
        probabilities: (M, 2W+1) RE of anchors from W before to W after the active one; not a
            number where not queried.
        least: p_follow.

    Returns:
        (M,) places along the path, -1 where no anchor will do.

    >>> found_again([5, 5, 5], [[0.9, 0.1, 0.9], [0.9, 0.1, 0.1], [0.1, 0.1, 0.1]], 0.5).tolist()
    [6, 4, -1]
    """
    active = integers("active", active, ("M",))
    probabilities = floats("probabilities", probabilities, ("M", "2W+1"), nan=True)
    least = number("least", least)
    alike(active=active, probabilities=probabilities)
    if not probabilities.shape[1] % 2:
        raise InputError(f"probabilities: {probabilities.shape}; give (M, 2W+1), an odd number")
    count = probabilities.shape[1] // 2
    offsets = np.arange(-count, count + 1)
    # Of two that are equally near, the one ahead.
    order = np.argsort(np.abs(offsets) - 0.5 * (offsets > 0), kind="stable")
    good = probabilities[:, order] > least
    return np.where(good.any(axis=1), active + offsets[order][good.argmax(axis=1)], -1)
