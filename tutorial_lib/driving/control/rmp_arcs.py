"""Free space for the policies of `rmp`: how far an arc is free, and which arc to take.

A body is covered by discs: one that moves on an arc meets a point where two circles cross.
"""

import numpy as np
from numba import njit

from tutorial_lib.driving.control.rmp_arithmetic import check_body
from tutorial_lib.geometry import Array
from tutorial_lib.world.bodies import BicycleCar, DifferentialDrive
from tutorial_lib.world.sensors import full_circle

_HORIZON = 2.2  # metres within which the laser's points matter
_STOP = 1.3  # metres within which they matter to a body that stops within half a metre
_SLACK = 0.001  # metres by which a body may swing closer while leaving
_STRAIGHT = 1e-3  # 1/m, the curvature of what is as good as straight
_LANES = 24  # how many lanes to either side are tried
_LANE_STEP = np.pi / 48
_DISCS = 4  # that cover a car


@njit(cache=True, nogil=True, error_model="numpy")
def free_travel(
    lasers: Array,
    angles: Array,
    arcs: Array,
    discs: Array,
    margin: float,
    horizon: float = _HORIZON,
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
    """
    count, beams = lasers.shape
    found = np.empty((count, 2))
    px, py, cos, sin = np.empty(beams), np.empty(beams), np.cos(angles), np.sin(angles)
    for robot in range(count):
        near = _see(lasers[robot], cos, sin, px, py, horizon)
        gap = _gap(px, py, near, discs)
        tight = min(margin, gap - _SLACK)
        free = _travel(px, py, near, arcs[robot, 0], arcs[robot, 1], discs, tight)
        found[robot] = free, gap
    return found


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
    """
    free, gap = free_travel(lasers, full_circle(lasers.shape[1]), arcs, discs, margin, _STOP).T
    stop = np.minimum(np.maximum(free - reserve, 0.0), left)
    return np.minimum(np.sqrt(2 * braking * stop), crawl + hurry * np.maximum(gap, 0.0))


@njit(cache=True, nogil=True, error_model="numpy")
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
    """
    count, beams = lasers.shape
    turned = waypoints.copy()
    px, py, cos, sin = np.empty(beams), np.empty(beams), np.cos(angles), np.sin(angles)
    for robot in range(count):
        near = _see(lasers[robot], cos, sin, px, py, _HORIZON)
        x, y = waypoints[robot]
        need = min(np.sqrt(x * x + y * y), reach)
        if need < 1e-6:
            continue
        lowest = np.inf
        for lane in range(2 * _LANES + 1):
            # Straight on, then ever farther to both sides, until no better one can come.
            turn = (lane + 1) // 2 * (_LANE_STEP if lane % 2 else -_LANE_STEP)
            if 0.5 * abs(turn) > lowest:
                break
            ux, uy = np.cos(turn) * x - np.sin(turn) * y, np.sin(turn) * x + np.cos(turn) * y
            free = _lane(px, py, near, ux, uy, half, need)
            cost = abs(turn) + 3.0 * (1.0 - free / need)
            if turn * swings[robot] > 0.0:
                cost -= min(abs(swings[robot]), 0.5 * abs(turn))
            if cost < lowest - 1e-9:
                lowest, turned[robot, 0], turned[robot, 1] = cost, ux, uy
    return turned


@njit(cache=True, nogil=True, error_model="numpy")
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
    """
    radius, reverse_cost, turn_cost, go_on, begin, miss = limits
    count, beams = lasers.shape
    arcs = np.empty((count, 3))
    px, py, cos, sin = np.empty(beams), np.empty(beams), np.cos(angles), np.sin(angles)
    for robot in range(count):
        near = _see(lasers[robot], cos, sin, px, py, _STOP)
        tight = min(margin, _gap(px, py, near, discs) - _SLACK)
        x, y = waypoints[robot]
        gear = _direct(x, y, radius, reverse_cost, turn_cost)
        curvature, length, off = _pursue(x, y, gear, radius)
        free = _travel(px, py, near, curvature, gear, discs, tight)
        leaving = speeds[robot] * gear < -0.02
        blocked = free < min(begin if leaving else go_on, length)
        if blocked or off > (0.5 * miss if leaving else miss):
            # Worth the change of direction only if there is room; once begun, to its end.
            least = go_on if blocked or leaving else begin
            lock, most = -np.sign(curvature) / radius, 0.0
            for part in range(4):
                other = lock * (1.0 - part / 3.0)
                room = _travel(px, py, near, other, -gear, discs, tight)
                gain = min(room, begin) * (1.5 - part / 3.0)
                if room > least and gain > most:
                    most, curvature, length = gain, other, begin
            gear = -gear if most > 0.0 else gear
        arcs[robot] = curvature, gear, length
    return arcs


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _direct(x: float, y: float, radius: float, reverse_cost: float, turn_cost: float) -> float:
    """Ahead (+1) or in reverse (-1) to a waypoint, by what the distance and the turn would cost."""
    distance, bearing = np.sqrt(x * x + y * y), abs(np.arctan2(y, x))
    # Very near, the bearing is uninformative.
    turn = radius * min(1.0, distance / 0.3)
    ahead = distance + turn * (bearing + turn_cost * max(0.0, bearing - np.pi / 2))
    back = reverse_cost * distance + turn * (np.pi - bearing)
    return 1.0 if ahead <= back else -1.0


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _pursue(x: float, y: float, gear: float, radius: float) -> tuple[float, float, float]:
    """Curvature and length of the arc to a waypoint, and how far the tightest arc misses it."""
    side, distance2 = (1.0 if y >= 0.0 else -1.0), max(x * x + y * y, 1e-9)
    off = max(0.0, radius - np.sqrt(x * x + (y - side * radius) ** 2))
    # The angle between chord and tangent is half the turn.
    half, distance = np.arctan2(abs(y), gear * x), np.sqrt(distance2)
    curvature = 2.0 * y / distance2
    if gear * x < 0.0 or abs(curvature) > 1.0 / radius:
        return side / radius, distance + radius * half, off
    length = distance if half < 1e-6 else distance * half / np.sin(half)
    return curvature, length, off


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _see(laser: Array, cos: Array, sin: Array, px: Array, py: Array, horizon: float) -> int:
    """Write the points within the horizon to `px` and `py`, and return how many there are."""
    near = 0
    for beam in range(len(laser)):
        if laser[beam] < horizon:
            px[near] = laser[beam] * cos[beam]
            py[near] = laser[beam] * sin[beam]
            near += 1
    return near


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _gap(px: Array, py: Array, near: int, discs: Array) -> float:
    """Metres from the body to the nearest of the points; negative if one is inside."""
    smallest = np.inf
    for i in range(near):
        for disc in range(len(discs)):
            dx = px[i] - discs[disc, 0]
            smallest = min(smallest, np.sqrt(dx * dx + py[i] * py[i]) - discs[disc, 1])
    return smallest


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _travel(
    px: Array, py: Array, near: int, curvature: float, gear: float, discs: Array, margin: float
) -> float:
    """Metres that the body can travel on an arc until a point is `margin` from one of its discs."""
    if abs(curvature) < _STRAIGHT:
        curvature = _STRAIGHT
    centre, spin = 1.0 / curvature, np.sign(curvature) * gear
    free = 2.0 * np.pi * abs(centre)
    for disc in range(len(discs)):
        place, size = discs[disc, 0], discs[disc, 1] + margin
        orbit2 = place * place + centre * centre
        orbit, start = np.sqrt(orbit2), np.arctan2(-centre, place)
        for i in range(near):
            dy = py[i] - centre
            far2 = px[i] * px[i] + dy * dy
            far = np.sqrt(far2)
            # Both are on circles about the turning centre; law of cosines where they touch.
            if abs(far - orbit) >= size:
                continue
            touch = np.arccos(min(1.0, (far2 + orbit2 - size * size) / (2.0 * far * orbit)))
            angle = (spin * (np.arctan2(dy, px[i]) - start)) % (2.0 * np.pi)
            free = min(free, max(angle - touch, 0.0) * abs(centre))
    return free


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _lane(px: Array, py: Array, near: int, ux: float, uy: float, half: float, need: float) -> float:
    """Metres, at most `need`, that a lane of half a width along (ux, uy) is free."""
    length = np.sqrt(ux * ux + uy * uy)
    ux, uy = ux / length, uy / length
    free = need
    for i in range(near):
        along, aside = px[i] * ux + py[i] * uy, py[i] * ux - px[i] * uy
        ahead = 0.0 < along < free and abs(aside) < half
        # What is almost beside the body, more than 76 degrees aside, does not block a lane.
        if ahead and aside * aside < 0.94 * (along * along + aside * aside):
            free = along
    return free


def cover(body: BicycleCar | DifferentialDrive) -> Array:
    """Discs (D, 2), place on the long axis and radius, that cover a body's footprint."""
    check_body(body)
    if isinstance(body, DifferentialDrive):
        return np.array([[0.0, float(np.linalg.norm(body.footprint[0]))]])
    (rear, side), (front, _) = body.footprint.min(axis=0), body.footprint.max(axis=0)
    part = (front - rear) / _DISCS
    places = rear + part * (np.arange(_DISCS) + 0.5)
    return np.column_stack([places, np.full(_DISCS, np.hypot(part / 2, abs(side)))])
