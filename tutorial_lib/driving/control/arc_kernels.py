"""The numba kernels behind `rmp_arcs`: discs of a body that moves on arcs, and points it meets.

`rmp_arcs` explains the arguments, and checks their shapes.
"""

import numpy as np
from numba import njit

from tutorial_lib.geometry import Array

HORIZON = 2.2
"""Metres within which the laser's points matter."""
STOP = 1.3
"""Metres within which they matter to a body that stops within half a metre."""
_SLACK = 0.001  # metres by which a body may swing closer while leaving
_STRAIGHT = 1e-3  # 1/m, the curvature of what is as good as straight
_LANES = 24  # how many lanes to either side are tried
_LANE_STEP = np.pi / 48


@njit(cache=True, nogil=True, error_model="numpy")
def free_travel(
    lasers: Array, angles: Array, arcs: Array, discs: Array, margin: float, horizon: float
) -> Array:
    """See `rmp_arcs.free_travel`."""
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


@njit(cache=True, nogil=True, error_model="numpy")
def clear_lanes(
    lasers: Array, angles: Array, waypoints: Array, swings: Array, half: float, reach: float
) -> Array:
    """See `rmp_arcs.clear_lanes`."""
    count, beams = lasers.shape
    turned = waypoints.copy()
    px, py, cos, sin = np.empty(beams), np.empty(beams), np.cos(angles), np.sin(angles)
    for robot in range(count):
        near = _see(lasers[robot], cos, sin, px, py, HORIZON)
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
    """See `rmp_arcs.choose_moves`."""
    radius, reverse_cost, turn_cost, go_on, begin, miss = limits
    count, beams = lasers.shape
    arcs = np.empty((count, 3))
    px, py, cos, sin = np.empty(beams), np.empty(beams), np.cos(angles), np.sin(angles)
    for robot in range(count):
        near = _see(lasers[robot], cos, sin, px, py, STOP)
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
