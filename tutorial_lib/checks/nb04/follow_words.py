"""What is wrong with a step of the follower's loop, in words, for notebook 04."""

from __future__ import annotations

from typing import Any

import numpy as np

from tutorial_lib.checks.nb04.toy_corridor import Memory
from tutorial_lib.se2 import Array, to_local, to_world
from tutorial_lib.topology.following.transitions import State

NEARER = 0.05
"""Metres that count as coming nearer."""
FAULTS = {
    "at needs RE of the active anchor above rules.p_lose, too; below it the waypoint means "
    "nothing": "no RE",
    "RE above rules.p_lose is enough for at; rules.p_follow is not needed": "p_follow",
    "at compares the distance to the waypoint as it is predicted now, not to the old place": (
        "old place"
    ),
    "at compares the distance to the waypoint, not only how far ahead it lies": "ahead only",
    "transition needs waited, or dead reckoning never ends": "no clock",
    "transition gets waited as it is in memory; it grows at the end of the step": "clock first",
    "a robot that stops remembers its new state as well: return a new Memory": "old memory",
    "in Follow a new waypoint is taken at every step, not only when something changes": (
        "changes only"
    ),
    "only nearer by more than 0.05 m is progress; any less may be noise": "any nearer",
    "progress is a point nearer than nearest by more than 0.05 m: distance < nearest - 0.05": (
        "sign"
    ),
    "progress is a change of the state or of the active anchor; the one visited does not count": (
        "visited"
    ),
    "nearest changes with progress alone, or many steps of less than 0.05 m would never count": (
        "nearest each time"
    ),
    "in a Memory waited comes before nearest": "exchanged",
    "waited is compared with rules.effort after this step has been added, not before": "old clock",
    "a robot in Follow gives up after rules.effort; rules.timeout is for dead reckoning": "timeout",
    "a robot in Follow that gets nowhere gives up: LOST, after rules.effort seconds": "never",
    "a robot that gives up is LOST; the new memory must hold that": "follows on",
    "rules.effort is for Follow alone; when dead reckoning ends, transition decides": "any state",
}
"""For known mistakes in a step, what to say and the name of the fault."""


def wrong_state(memory: Memory, seen: tuple[Any, ...], mine: Memory, right: Memory) -> str:
    """Why state and anchors are others."""
    reach, waypoints, rules = seen[0], seen[2], seen[4]
    told = [f"{m.state.name}, active {m.active}, visited {m.visited}" for m in (mine, right)]
    words = f"{told[0]} came back, {told[1]} is right"
    gave_up = right.state == State.LOST and memory.state == State.FOLLOW
    if gave_up and mine.state != State.LOST:
        return f"{words}: no nearer for more than rules.effort = {rules.effort:g} s, so it gives up"
    if mine.state == State.LOST and memory.state == State.FOLLOW and not gave_up:
        effort = f"rules.effort = {rules.effort:g} s"
        told = f"it came nearer, or changed its anchor, {right.waited:.1f} s ago; {effort}"
        return f"{words}: a robot in Follow gives up after more than rules.effort alone: {told}"
    if memory.state == State.SEARCH:
        new = "return what transition gives, in a new memory"
        return f"{words}: in Search transition decides, by RE alone; active is still -1; {new}"
    gap = float(np.linalg.norm(waypoints[memory.active]))
    facts = f"the waypoint of anchor {memory.active} is {gap:.2f} m away (rules.at = {rules.at:g})"
    facts += f", its RE {reach[memory.active]:.2f} (rules.p_lose = {rules.p_lose:g})"
    facts += f", waited is {memory.waited:.1f} s"
    at = "at is to be less than rules.at away from the active anchor, with RE above rules.p_lose"
    return f"{words}: {at}; state, active and visited are then what transition gives ({facts})"


def wrong_place(memory: Memory, seen: tuple[Any, ...], mine: Memory, right: Memory) -> str:
    """Why the place of the waypoint is another."""
    waypoints, odometry = seen[2], seen[3]
    new = not np.allclose(right.place, memory.place, atol=1e-9)
    if np.isnan(mine.place).any():
        return "place is not a number: the waypoint of an anchor that was not queried"
    if not new:
        return (
            "place changes, but no new waypoint is taken in dead reckoning, where the active "
            "anchor is the same: the old one stays where it is in the odometer's frame"
        )
    candidates = {
        "place is the waypoint in the robot's frame; keep it in the odometer's, to_world(odometry, "
        "...)": waypoints[right.active],
        "place is still that of the anchor that was active before, or the old one; a new waypoint "
        "is taken in Follow at every step, and whenever the active anchor has changed, that of the "
        "new one": to_world(odometry, waypoints[memory.active]),
        "a new waypoint is missing: in Follow at every step, and whenever the active anchor has "
        "changed": memory.place,
        "the odometer's pose turns the waypoint, it does not only shift it: to_world": (
            odometry[:2] + waypoints[right.active]
        ),
        "the heading turns the waypoint the other way: look at the signs of the sine": to_world(
            odometry * [1.0, 1.0, -1.0], waypoints[right.active]
        ),
        "the heading is in radians already": to_world(
            [*odometry[:2], np.deg2rad(odometry[2])], waypoints[right.active]
        ),
        "to_world, not to_local: the waypoint is in the robot's frame and goes to the odometer's": (
            to_local(odometry, waypoints[right.active])
        ),
    }
    for words, place in candidates.items():
        if np.allclose(mine.place, place, atol=1e-6):
            return words
    return f"place is {_told(mine.place)}, {_told(right.place)} is right, in the odometer's frame"


def wrong_target(seen: tuple[Any, ...], mine: Array, right: Memory) -> str:
    """Why the point to drive to is another."""
    odometry = seen[3]
    want = to_local(odometry, right.place)
    candidates = {
        "y is positive to the left, as everywhere": want * [1.0, -1.0],
        "the point is in the odometer's frame; the robot needs it in its own: to_local": (
            right.place
        ),
        "the point is shifted, but not turned into the robot's frame: to_local": (
            right.place - odometry[:2]
        ),
        "the point is the waypoint as it is predicted now; in dead reckoning it is the old one": (
            seen[2][right.active]
        ),
    }
    for words, point in candidates.items():
        if np.allclose(mine, point, atol=1e-6):
            return words
    words = f"the point to drive to is {_told(mine)}, {_told(want)} is right"
    return f"{words}: place, in the robot's present frame"


def wrong_clock(memory: Memory, mine: Memory, right: Memory) -> str:
    """Why the clock shows something else."""
    told = f"waited is {mine.waited:.3g} s, {right.waited:.3g} s is right"
    if right.state != memory.state:
        return f"{told}: the state has changed, so the clock starts again at 0"
    if right.active != memory.active:
        return f"{told}: the active anchor has changed, so the clock starts again at 0"
    if right.waited == 0.0:
        return f"{told}: it came nearer by more than {NEARER} m, so the clock starts again at 0"
    if abs(mine.waited - memory.waited - 1.0) < 1e-9:
        return f"{told}: a step lasts 0.1 s, not 1 s"
    if mine.waited == 0.0 and right.state == State.DEAD_RECKONING:
        return f"{told}: in dead reckoning the clock runs, however near the old waypoint is"
    if mine.waited == 0.0:
        gap = f"it is {right.nearest:.3f} m at best until now"
        return f"{told}: it came no nearer by more than {NEARER} m; {gap}"
    return f"{told}: a step without progress adds 0.1 s"


def wrong_nearest(memory: Memory, mine: Memory, right: Memory) -> str:
    """Why the least distance is another."""
    told = f"nearest is {mine.nearest:.4g} m, {right.nearest:.4g} m is right"
    if right.waited == 0.0:
        return f"{told}: whenever the clock starts again, it is the distance to the waypoint"
    words = f"it changes only when the clock starts again, or many steps of less than {NEARER} m"
    return f"{told}: {words} would never count"


def _told(point: Array) -> str:
    return f"({point[0]:.3g}, {point[1]:.3g}) m"
