"""What stands on a robot's path that was not there when an image of the map was taken (ours).

Where a prediction puts the robot half a metre off, each wall looks new. So the robot's laser scan
is aligned with the image's first; where the two do not fit, nothing is said. Nor is it where walls
are gone: what stands in a door hides some, but a place that looks alike lacks some.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.geometry import distance_to_segments
from tutorial_lib.se2 import Array, inverse, relative, to_world
from tutorial_lib.topology.mapping.scan_matching import match_scans
from tutorial_lib.validation import fit_together
from tutorial_lib.world.sensors import beams_of

_AGREE = 0.6  # of a scan's points, at least, that the other confirms
_MOVED, _TURNED = 0.8, 0.5  # metres and rad between the prediction and what fits, at most
_SIGHT = 6.0  # metres beyond which beams are too far apart
_BEYOND = 0.25  # metres that the image's laser saw beyond a new point, at least
_LANE = 0.2  # metres on either side of a path
_WIDE = 1.0  # metres around the first point on the path that belong to the same obstacle
_LEAST = 2  # points of an obstacle
_ELSEWHERE = 0.05  # of all other points that may be new, and of those that may be gone


@dataclass(frozen=True, eq=False)
class Changes:
    """What a robot sees anew, in its frame.

    Attributes:
        image: (3,) where the image was taken, as the scans say.
        points: (P, 2) all that the laser sees in sight.
        new: (P,) those that the image's laser saw through.
    """

    image: Array
    points: Array
    new: NDArray[np.bool_]

    @property
    def any(self) -> bool:
        """Whether something new is in sight."""
        return int(self.new.sum()) >= _LEAST


def changes(laser: Array, mapped: Array, image: Array) -> Changes | None:
    """Compare a scan with that of an image of the map; None where they do not fit.

    Args:
        laser: (B,) metres, a full circle.
        mapped: (B,) the same when the image was taken.
        image: (3,) where that was, as predicted, in the robot's frame.

    Raises:
        InputError: when an array has another shape.
    """
    fit_together(laser=(laser, ("B",)), mapped=(mapped, ("B",)), image=(image, (3,)))
    start = inverse(image)
    (robot,), (agrees,) = match_scans(mapped[None], laser[None], start[None, None])
    moved = relative(start, robot)
    fits = agrees >= _AGREE and np.hypot(*moved[:2]) <= _MOVED and abs(moved[2]) <= _TURNED
    if not fits:
        return None
    points, walls = _points(laser), _points(mapped)
    gone = _is_before(to_world(inverse(robot), walls), laser)
    if len(walls) and gone.mean() > _ELSEWHERE:
        return None
    return Changes(inverse(robot), points, _is_before(to_world(robot, points), mapped))


def _points(laser: Array) -> Array:
    """(P, 2) what a laser sees in sight."""
    return beams_of(laser)[laser < _SIGHT]


def _is_before(points: Array, laser: Array) -> NDArray[np.bool_]:
    """(P,) whether a laser sees farther where points (P, 2) in its frame are, and beside them."""
    x, y = points.T
    beam = np.floor((np.arctan2(y, x) + np.pi) / (2 * np.pi) * len(laser)).astype(int)
    beside = laser[(beam[:, None] + np.array([-1, 0, 1])) % len(laser)]
    return np.hypot(x, y) + _BEYOND < beside.min(axis=1)


def first_on_path(seen: Changes, path: Array) -> tuple[int, Array] | None:
    """The first part of a path on which something new stands, and the points (P, 2) of that.

    Where much else is new as well, the scans do not show the same place: then nothing is found.

    Args:
        seen: by the robot.
        path: (K, 3) in the robot's frame; part 0 leads from its first pose to its second.
    """
    parts = np.hstack([path[:-1, :2], path[1:, :2]])
    on = (distance_to_segments(seen.points, parts) < _LANE) & seen.new[:, None]
    if not on.any():
        return None
    part = int(on.any(axis=0).argmax())
    far = np.where(on[:, part], np.hypot(*seen.points.T), np.inf)
    around = np.hypot(*(seen.points - seen.points[far.argmin()]).T) < _WIDE
    obstacle, elsewhere = seen.points[seen.new & around], seen.new[~around]
    if len(obstacle) < _LEAST or (len(elsewhere) and elsewhere.mean() > _ELSEWHERE):
        return None
    return part, obstacle
