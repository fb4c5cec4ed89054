"""Where a robot is, by odometry that walls correct: panoramas are kept along its path."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from tutorial_lib.agents.walls import goes_on, match_near
from tutorial_lib.se2 import Array, compose, relative, wrap

_MOVED, _TURNED = 0.5, float(np.deg2rad(40.0))  # since the last match, from which walls are asked
_APART = 1.0  # metres from the nearest panorama that is kept, beyond which another one is
_ASKED, _SIGHT = 3, 2.5  # panoramas that are asked at most, and metres up to which they are
_GOES_ON = 0.75  # share of what is seen that must fit to what was seen before


@dataclass(eq=False)
class Track:
    """One robot's corrected pose, and the panoramas that correct it.

    Attributes:
        pose: (3,) of the robot, in the frame in which it began.
        places: (3,) of the panoramas, in that frame.
        ranges: (W,) metres in each of their columns.
    """

    pose: Array = field(default_factory=lambda: np.zeros(3))
    places: list[Array] = field(default_factory=list)
    ranges: list[Array] = field(default_factory=list)
    _odometry: Array | None = None
    _due: bool = True
    _asked: tuple[Array, Array] | None = None  # pose and ranges at the last match

    def move(self, odometry: Array) -> None:
        """The robot is now at `odometry` (3,)."""
        before = odometry if self._odometry is None else self._odometry
        self.pose = compose(self.pose, relative(before, odometry))
        self._odometry = odometry.copy()

    def ask(self) -> None:
        """The walls should be asked now, however little the robot has moved."""
        self._due = True

    def is_due(self) -> bool:
        """Whether the robot has moved so far that its walls should be asked."""
        if self._due or self._asked is None:
            return True
        gap = relative(self._asked[0], self.pose)
        return bool(np.hypot(gap[0], gap[1]) >= _MOVED or abs(wrap(gap[2])) >= _TURNED)

    def goes_on(self, ranges: Array) -> bool:
        """Whether the walls are those of the last match; not, where the robot was carried away."""
        if self._asked is None:
            return True
        motion = relative(self._asked[0], self.pose)
        share = goes_on(self._asked[1][None], ranges[None], motion[None])[0]
        return bool(share >= _GOES_ON)

    def correct(self, ranges: Array) -> None:
        """Correct the pose by what the robot sees, and keep its panorama where none is near."""
        places = np.array(self.places).reshape(-1, 3)
        metres = np.linalg.norm(places[:, :2] - self.pose[:2], axis=1)
        near = np.argsort(metres, kind="stable")[:_ASKED]
        near = near[metres[near] < _SIGHT]
        if len(near):
            around = np.repeat(ranges[None], len(near), axis=0)
            kept = np.stack([self.ranges[place] for place in near.tolist()])
            poses = match_near(kept, around, relative(places[near], self.pose))
            found = np.flatnonzero(np.isfinite(poses[:, 0]))
            if len(found):
                self.pose = compose(places[near[found[0]]], poses[found[0]])
        if not (metres < _APART).any():
            self.places.append(self.pose)
            self.ranges.append(ranges)
        self.see(ranges)

    def see(self, ranges: Array) -> None:
        """What a robot sees now is what the next sight must go on from."""
        self._asked, self._due = (self.pose, ranges), False

    def begun_anew(self) -> Track:
        """A track of the same robot that knows no panoramas."""
        return Track(self.pose, _odometry=self._odometry)

    def absorb(self, other: Track, motion: Array) -> None:
        """Go on where another track is, whose frame is at `motion` (3,) in this one."""
        self.pose = compose(motion, other.pose)
        self.places += [compose(motion, place) for place in other.places]
        self.ranges += other.ranges
        self._odometry = other._odometry
        self._asked = other._asked and (compose(motion, other._asked[0]), other._asked[1])
