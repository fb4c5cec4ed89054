"""Free space for the policies of `rmp`: how far an arc is free, and which arc to take.

A body is covered by discs: one that moves on an arc meets a point where two circles cross.
"""

import numpy as np

from tutorial_lib.array_forms import Shape
from tutorial_lib.driving.control import arc_kernels as kernels
from tutorial_lib.driving.control.rmp_arithmetic import check_body
from tutorial_lib.geometry import Array
from tutorial_lib.validation import fit_together
from tutorial_lib.world.bodies import BicycleCar, DifferentialDrive
from tutorial_lib.world.sensors import full_circle

_DISCS = 4  # that cover a car


def free_travel(
    lasers: Array,
    angles: Array,
    arcs: Array,
    discs: Array,
    margin: float,
    horizon: float = kernels.HORIZON,
) -> Array:
    """How far each body can travel on an arc before it comes too near to something.

    Args:
        lasers: (N, B) metres.
        angles: (B,) of the beams, rad.
        arcs: (N, 2) curvature in 1/m, and direction of travel, +1 or -1.
        discs: (D, 2) that cover the body: place on its long axis, and radius, metres.
        margin: metres that it keeps from everything; a body that is nearer may leave.
        horizon: metres; what is farther away is not looked at.

    Returns:
        (N, 2) metres that are free, and metres between the body and the nearest thing now.

    Raises:
        InputError: when an array has another shape.
    """
    _check_shapes(lasers, angles, arcs=(arcs, ("N", 2)), discs=(discs, ("D", 2)))
    return kernels.free_travel(lasers, angles, arcs, discs, margin, horizon)


def safe_speeds(
    lasers: Array,
    arcs: Array,
    discs: Array,
    margin: float,
    left: Array,
    braking: float,
    reserve: float,
    crawl: float,
    hurry: float,
) -> Array:
    """The safety layer: speeds (N,) in m/s from which each body can stop, slow where it is tight.

    Args:
        lasers: (N, B) metres.
        arcs: (N, 2) as in `free_travel`.
        discs: (D, 2) likewise.
        margin: metres that a body keeps from everything.
        left: (N,) metres to the waypoint.
        braking: m/s^2 that a body counts on.
        reserve: metres of an arc that it leaves.
        crawl: m/s where there is no room at all.
        hurry: m/s more for each metre of room.

    Raises:
        InputError: when an array has another shape.
    """
    fit_together(lasers=(lasers, ("N", "B")), left=(left, ("N",)))
    angles = full_circle(lasers.shape[1])
    free, gap = free_travel(lasers, angles, arcs, discs, margin, kernels.STOP).T
    stop = np.minimum(np.maximum(free - reserve, 0.0), left)
    return np.minimum(np.sqrt(2 * braking * stop), crawl + hurry * np.maximum(gap, 0.0))


def clear_lanes(
    lasers: Array, angles: Array, waypoints: Array, swings: Array, half: float, reach: float
) -> Array:
    """Waypoints (N, 2) turned aside until the body fits through the straight lane to them.

    Of lanes that are free over their whole length the least turned; without one, the best of both.

    Args:
        lasers: (N, B) metres.
        angles: (B,) rad.
        waypoints: (N, 2).
        swings: (N,) rad; lanes on the side to which the robot turns already are as much preferred.
        half: metres, half the width of the lane.
        reach: metres, the length of a lane at most.

    Raises:
        InputError: when an array has another shape.
    """
    _check_shapes(lasers, angles, waypoints=(waypoints, ("N", 2)), swings=(swings, ("N",)))
    return kernels.clear_lanes(lasers, angles, waypoints, swings, half, reach)


def choose_moves(
    lasers: Array,
    angles: Array,
    waypoints: Array,
    speeds: Array,
    discs: Array,
    margin: float,
    limits: Array,
) -> Array:
    """For each car the arc on which to drive now, as curvature, direction and length (N, 3).

    An arc leads from the rear axle to the waypoint, ahead or in reverse. Where it would be too
    tight or is blocked, the car first drives the other way with opposite lock, which turns it the
    same way, until enough of the arc is open. It prefers to continue what it does: its
    speed is the memory.

    Args:
        lasers: (N, B) metres.
        angles: (B,) rad.
        waypoints: (N, 2).
        speeds: (N,) m/s.
        discs: (D, 2) as in `free_travel`.
        margin: metres that the car keeps from everything.
        limits: tightest radius; what a metre in reverse costs; what it costs more to turn by a rad
            towards what is behind; metres of an arc that must be free to go on, and to begin with
            it; and the miss in metres that is near enough.

    Raises:
        InputError: when an array has another shape.
    """
    others = {"waypoints": (waypoints, ("N", 2)), "speeds": (speeds, ("N",))}
    _check_shapes(lasers, angles, **others, discs=(discs, ("D", 2)), limits=(limits, (6,)))
    return kernels.choose_moves(lasers, angles, waypoints, speeds, discs, margin, limits)


def _check_shapes(lasers: Array, angles: Array, **others: tuple[Array, Shape]) -> None:
    fit_together(lasers=(lasers, ("N", "B")), angles=(angles, ("B",)), **others)


def cover(body: BicycleCar | DifferentialDrive) -> Array:
    """Discs (D, 2), place on the long axis and radius, that cover a body's footprint."""
    check_body(body)
    if isinstance(body, DifferentialDrive):
        return np.array([[0.0, float(np.linalg.norm(body.footprint[0]))]])
    (rear, side), (front, _) = body.footprint.min(axis=0), body.footprint.max(axis=0)
    part = (front - rear) / _DISCS
    places = rear + part * (np.arange(_DISCS) + 0.5)
    return np.column_stack([places, np.full(_DISCS, np.hypot(part / 2, abs(side)))])
