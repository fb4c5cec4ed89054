"""The check of the follower's loop, in notebook 04."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.answers import parts
from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.nb04.follower_answers import calling, whole
from tutorial_lib.checks.nb04.observations import RULES
from tutorial_lib.checks.nb04.toy_corridor import STEP, STORIES, Corridor, Memory
from tutorial_lib.checks.nb04.transition import transition
from tutorial_lib.geometry import Array, to_local, to_world
from tutorial_lib.topology.following.transitions import FollowerSettings, State

Answer = tuple[Memory, Array | None]
NEARER = 0.05
"""Metres that count as coming nearer."""


def follow_step(
    memory: Memory,
    reach: Array,
    overlap: Array,
    waypoints: Array,
    odometry: Array,
    rules: FollowerSettings,
) -> Answer:
    """What a follower remembers after a step, and the point (2,) that it drives to.

    Args:
        memory: until now.
        reach: (L,) RE of the path's anchors; 0 where not queried.
        overlap: (L,) with them.
        waypoints: (L, 2) of them, in the robot's frame; nan where not queried.
        odometry: (3,) the odometer's pose.
        rules: the thresholds.

    Returns:
        The memory, and the point in the robot's frame; None where the robot stops.
    """
    before = memory
    close = np.linalg.norm(waypoints[before.active]) < rules.at
    at = bool(close and reach[before.active] > rules.p_lose)
    state, active, visited = transition(
        before.state, before.active, before.visited, reach, overlap, at, before.waited, rules
    )
    if state in (State.LOST, State.DONE):
        return before._replace(state=state, active=active, visited=visited), None
    place = before.place
    if state == State.FOLLOW or active != before.active:
        place = to_world(odometry, waypoints[active])
    target = to_local(odometry, place)
    distance, waited, nearest = float(np.linalg.norm(target)), before.waited + STEP, before.nearest
    changed = (state, active) != (before.state, before.active)
    if changed or (state == State.FOLLOW and distance < nearest - NEARER):
        waited, nearest = 0.0, distance
    if state == State.FOLLOW and waited > rules.effort:
        return Memory(State.LOST, active, visited, place, waited, nearest), None
    return Memory(state, active, visited, place, waited, nearest), target


_HINTS: dict[type[Exception], str] = {
    IndexError: "reach, overlap and waypoints have a row for each anchor, 0 to L - 1",
    ValueError: "waypoints is (L, 2), odometry (3,), and the point to drive to (2,)",
    TypeError: "memory is a named tuple; make a new one, by Memory(...) or memory._replace(...)",
    AttributeError: "memory has state, active, visited, place, waited and nearest, and is not "
    "written to: make a new one",
    KeyError: "memory has state, active, visited, place, waited and nearest",
    NameError: "is it spelt right, and is its cell run?",
}


def _example() -> tuple[Any, ...]:
    corridor, memory = Corridor(STORIES["undisturbed"]), Memory(State.FOLLOW, 1, 0)
    return memory, *corridor.observe(memory), STORIES["undisturbed"].rules


def _exact(
    memory: Memory, ahead: float, reach: float, rules: FollowerSettings = RULES
) -> tuple[Any, ...]:
    """A step in which the only anchor of a path lies straight ahead."""
    seen = np.array([reach]), np.array([0.3]), np.array([[ahead, 0.0]]), np.zeros(3)
    return memory, *seen, rules


_ON_ITS_WAY = Memory(State.FOLLOW, 0, -1, np.array([2.0, 0.0]), 1.0, 1.05)
_EXACT = {
    "exactly rules.at from the waypoint": _exact(_ON_ITS_WAY, 0.25, 0.97),
    "at the waypoint, RE of exactly rules.p_lose": _exact(_ON_ITS_WAY, 0.1, 0.4),
    "exactly 0.05 m nearer": _exact(_ON_ITS_WAY, 1.0, 0.97),
    "without progress for exactly rules.effort": _exact(
        _ON_ITS_WAY._replace(waited=0.0), 1.5, 0.97, replace(RULES, effort=0.1)
    ),
}


@check(follow_step, _example(), calls=10_000)
def check_follow_step(student: Callable[..., Any]) -> None:
    """Seventeen drives along a corridor: left alone, blind, pushed, behind a chair, and lost."""
    invoke = calling(_HINTS)
    for name, story in STORIES.items():
        corridor, memory = Corridor(story), Memory()
        while corridor.seconds < story.seconds:
            seen = (*corridor.observe(memory), story.rules)
            what = f"follow_step, {name}, after {corridor.seconds:.1f} s in {memory.state.name}"
            want = follow_step(memory, *seen)
            arrays = {"memory.place": memory.place, "reach": seen[0], "overlap": seen[1]}
            arrays |= {"waypoints": seen[2], "odometry": seen[3]}
            copies = {key: array.copy() for key, array in arrays.items()}
            got = _form(what, invoke(what, partial(student, memory, *seen)))
            for key, array in arrays.items():
                if not np.array_equal(array, copies[key], equal_nan=True):
                    raise WrongAnswer(f"{what}: your function changes {key}; make a new array")
            _compare(what, memory, seen, got, want)
            memory, target = want
            if target is None:
                break
            corridor.drive(target)
    for name, (memory, *seen) in _EXACT.items():
        what = f"follow_step, {name}"
        got = _form(what, invoke(what, partial(student, memory, *seen)))
        want = follow_step(memory, *seen)
        if (got[0].state, got[1] is None) != (want[0].state, want[1] is None):
            words = f"{got[0].state.name} came back, {want[0].state.name} is right"
            raise WrongAnswer(f"{what}: {words}; exactly a threshold is neither above nor below it")
        _compare(what, memory, seen, got, want)


def _form(what: str, got: Any) -> Answer:  # noqa: ANN401 - students' answers
    """A memory and a point, of the right form."""
    memory, target = parts(what, got, 2, "return memory, target: a Memory, and a point or None")
    if not isinstance(memory, Memory):
        words = f"the first thing that came back is a {type(memory).__name__}; return a Memory"
        raise WrongAnswer(f"{what}: {words}, as Memory(...) or memory._replace(...) makes it")
    if not all(map(whole, memory[:3])) or int(memory.state) not in list(State):
        words = "memory.state is a State, memory.active and memory.visited are whole numbers"
        raise WrongAnswer(f"{what}: {words}; yours are {memory[:3]}")
    place = _point(f"{what}: memory.place", memory.place)
    for name in ("waited", "nearest"):
        value = getattr(memory, name)
        if not isinstance(value, int | float | np.number) or isinstance(value, bool):
            words = f"memory.{name} is a {type(value).__name__}; it is a number"
            raise WrongAnswer(f"{what}: {words}")
    if target is not None:
        target = _point(f"{what}: the point to drive to", target)
    return memory._replace(place=place, state=State(int(memory.state))), target


def _point(what: str, got: Any) -> Array:  # noqa: ANN401
    try:
        point = np.asarray(got, dtype=float)
    except (TypeError, ValueError):
        raise WrongAnswer(f"{what} is a {type(got).__name__}; it is an array (2,)") from None
    if point.shape != (2,) or not isinstance(got, np.ndarray | list | tuple):
        kind = f"shape {point.shape}" if isinstance(got, np.ndarray) else type(got).__name__
        raise WrongAnswer(f"{what} has {kind}; it is an array (2,)")
    return point


def _compare(what: str, memory: Memory, seen: tuple[Any, ...], got: Answer, want: Answer) -> None:
    """Demand the right memory and the right point, part by part."""
    mine, right = got[0], want[0]
    if mine[:3] != right[:3]:
        raise WrongAnswer(f"{what}: {_wrong_state(memory, seen, mine, right)}")
    if right.state == State.LOST or right.state == State.DONE:
        if got[1] is not None:
            words = f"a robot that is {right.state.name} stops: return None in place of a point"
            raise WrongAnswer(f"{what}: {words}")
        return
    if got[1] is None:
        words = f"the new state is {right.state.name}, so the robot drives on; return a point"
        raise WrongAnswer(f"{what}: {words}")
    if not np.allclose(mine.place, right.place, atol=1e-6):
        raise WrongAnswer(f"{what}: {_wrong_place(memory, seen, mine, right)}")
    if not np.allclose(got[1], want[1], atol=1e-6):
        raise WrongAnswer(f"{what}: {_wrong_target(seen, got[1], right)}")
    if not abs(mine.waited - right.waited) <= 1e-6:
        raise WrongAnswer(f"{what}: {_wrong_clock(memory, mine, right)}")
    if not np.isclose(mine.nearest, right.nearest, atol=1e-6):
        raise WrongAnswer(f"{what}: {_wrong_nearest(memory, mine, right)}")


def _wrong_state(memory: Memory, seen: tuple[Any, ...], mine: Memory, right: Memory) -> str:
    """Why state and anchors are others."""
    reach, waypoints, rules = seen[0], seen[2], seen[4]
    told = [f"{m.state.name}, active {m.active}, visited {m.visited}" for m in (mine, right)]
    words = f"{told[0]} came back, {told[1]} is right"
    gave_up = right.state == State.LOST and memory.state == State.FOLLOW
    if gave_up and mine.state != State.LOST:
        return f"{words}: no nearer for more than rules.effort = {rules.effort:g} s, so it gives up"
    if mine.state == State.LOST and memory.state == State.FOLLOW and not gave_up:
        effort = f"rules.effort = {rules.effort:g} s"
        return f"{words}: it came nearer, or changed its anchor, {right.waited:.1f} s ago; {effort}"
    if memory.state == State.SEARCH:
        return f"{words}: in Search transition decides, by RE alone; active is still -1"
    gap = float(np.linalg.norm(waypoints[memory.active]))
    facts = f"the waypoint of anchor {memory.active} is {gap:.2f} m away (rules.at = {rules.at:g})"
    facts += f", its RE {reach[memory.active]:.2f} (rules.p_lose = {rules.p_lose:g})"
    facts += f", waited is {memory.waited:.1f} s"
    return f"{words}: {facts}; with at, transition gives the new state"


def _wrong_place(memory: Memory, seen: tuple[Any, ...], mine: Memory, right: Memory) -> str:
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
        "to_world, not to_local: the waypoint is in the robot's frame and goes to the odometer's": (
            to_local(odometry, waypoints[right.active])
        ),
    }
    for words, place in candidates.items():
        if np.allclose(mine.place, place, atol=1e-6):
            return words
    return f"place is {_told(mine.place)}, {_told(right.place)} is right, in the odometer's frame"


def _wrong_target(seen: tuple[Any, ...], mine: Array, right: Memory) -> str:
    """Why the point to drive to is another."""
    odometry = seen[3]
    want = to_local(odometry, right.place)
    candidates = {
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


def _wrong_clock(memory: Memory, mine: Memory, right: Memory) -> str:
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


def _wrong_nearest(memory: Memory, mine: Memory, right: Memory) -> str:
    """Why the least distance is another."""
    told = f"nearest is {mine.nearest:.4g} m, {right.nearest:.4g} m is right"
    if right.waited == 0.0:
        return f"{told}: whenever the clock starts again, it is the distance to the waypoint"
    words = f"it changes only when the clock starts again, or many steps of less than {NEARER} m"
    return f"{told}: {words} would never count"


def _told(point: Array) -> str:
    return f"({point[0]:.3g}, {point[1]:.3g}) m"
