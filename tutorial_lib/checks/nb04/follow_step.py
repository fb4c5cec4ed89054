"""The check of the follower's loop, in notebook 04."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.answers import parts
from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import compare, with_faults
from tutorial_lib.checks.framework.wording import kind
from tutorial_lib.checks.nb04.follow_words import (
    FAULTS,
    NEARER,
    wrong_clock,
    wrong_nearest,
    wrong_place,
    wrong_state,
    wrong_target,
)
from tutorial_lib.checks.nb04.forms import calling, whole
from tutorial_lib.checks.nb04.observations import RULES
from tutorial_lib.checks.nb04.toy_corridor import STEP, STORIES, Corridor, Memory, Story
from tutorial_lib.checks.nb04.transition import transition
from tutorial_lib.se2 import Array, to_local, to_world
from tutorial_lib.topology.following.transitions import FollowerSettings, State

Answer = tuple[Memory, Array | None]


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
    return _stepped(memory, reach, overlap, waypoints, odometry, rules)


def _stepped(
    memory: Memory,
    reach: Array,
    overlap: Array,
    waypoints: Array,
    odometry: Array,
    rules: FollowerSettings,
    fault: str = "",
) -> Answer:
    """A step of the loop, with a `fault` if one is named."""
    before = memory
    at = _at(before, reach, waypoints, odometry, rules, fault)
    waited = {"no clock": 0.0, "clock first": before.waited + STEP}.get(fault, before.waited)
    state, active, visited = transition(
        before.state, before.active, before.visited, reach, overlap, at, waited, rules
    )
    if state in (State.LOST, State.DONE):
        over = before._replace(state=state, active=active, visited=visited)
        return (before if fault == "old memory" else over), None
    place = before.place
    new = state == State.FOLLOW or active != before.active
    if (state != before.state or active != before.active) if fault == "changes only" else new:
        place = to_world(odometry, waypoints[active])
    target = to_local(odometry, place)
    distance, waited, nearest = float(np.linalg.norm(target)), before.waited + STEP, before.nearest
    margin = {"any nearer": 0.0, "sign": -NEARER}.get(fault, NEARER)
    changed = (state, active) != (before.state, before.active)
    changed |= fault == "visited" and visited != before.visited
    if changed or (state == State.FOLLOW and distance < nearest - margin):
        waited, nearest = 0.0, distance
    elif fault == "nearest each time":
        nearest = min(nearest, distance)
    told = Memory(state, active, visited, place, waited, nearest)
    if fault == "exchanged":
        told = told._replace(waited=nearest, nearest=waited)
    late = {"old clock": before.waited > rules.effort, "timeout": waited > rules.timeout}
    if fault != "never" and late.get(fault, waited > rules.effort):
        if fault == "follows on":
            return told, None
        if state == State.FOLLOW or fault == "any state":
            return told._replace(state=State.LOST), None
    return told, target


def _at(
    memory: Memory,
    reach: Array,
    waypoints: Array,
    odometry: Array,
    rules: FollowerSettings,
    fault: str,
) -> bool:
    """Whether the robot is at the active anchor, with the `fault`."""
    waypoint = waypoints[memory.active]
    if fault == "old place":
        waypoint = memory.place - odometry[:2]
    gap = abs(waypoint[0]) if fault == "ahead only" else np.linalg.norm(waypoint)
    least = {"no RE": -1.0, "p_follow": rules.p_follow}.get(fault, rules.p_lose)
    return bool(gap < rules.at and reach[memory.active] > least)


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


_ARRAYS = ("memory.place", "reach", "overlap", "waypoints", "odometry")
_ON_ITS_WAY = Memory(State.FOLLOW, 0, -1, np.array([2.0, 0.0]), 1.0, 1.05)
_EXACT = {
    "exactly rules.at from the waypoint": _exact(_ON_ITS_WAY, 0.25, 0.97),
    "at the waypoint, whose old place is far ahead": _exact(_ON_ITS_WAY, 0.1, 0.97),
    "at the waypoint, RE of exactly rules.p_lose": _exact(_ON_ITS_WAY, 0.1, 0.4),
    # Of these numbers every way to write the difference makes exactly 0.05.
    "exactly 0.05 m nearer": _exact(
        _ON_ITS_WAY._replace(nearest=0.1), 0.05, 0.97, replace(RULES, at=0.01)
    ),
    "0.03 m farther than the nearest": _exact(_ON_ITS_WAY._replace(nearest=1.47), 1.5, 0.97),
    "without progress for exactly rules.effort": _exact(
        _ON_ITS_WAY._replace(waited=0.0), 1.5, 0.97, replace(RULES, effort=0.1)
    ),
    "without progress for a minute": _exact(_ON_ITS_WAY._replace(waited=60.0), 1.5, 0.97),
}


@cache  # the same objects each time, by which `compare` knows what it has answers to
def _moments(name: str, story: Story) -> dict[str, tuple[Any, ...]]:
    """Every step of a story."""
    cases, corridor, memory = {}, Corridor(story), Memory()
    while corridor.seconds < story.seconds:
        seen = (*corridor.observe(memory), story.rules)
        cases[f"{name}, after {corridor.seconds:.1f} s in {memory.state.name}"] = memory, *seen
        memory, target = follow_step(memory, *seen)
        if target is None:
            break
        corridor.drive(target)
    return cases


@check(follow_step, _example(), calls=10_000)
def check_follow_step(student: Callable[..., Any]) -> None:
    """Seventeen drives along a corridor: left alone, blind, pushed, behind a chair, and lost."""
    faults = with_faults(_stepped, FAULTS)
    for story in STORIES.items():
        compare(
            "follow_step",
            student,
            _moments(*story) | _EXACT,
            follow_step,
            faults,
            invoke=_invoke,
            form=_form,
            same=lambda got, want, *case: not _difference(got, want, *case),
            difference=_difference,
        )


def _invoke(what: str, student: Callable[..., Any], memory: Memory, *seen: Any) -> Any:  # noqa: ANN401
    """A student's answer, if the memory and what was seen stay as they are."""
    given = copy.deepcopy((memory, *seen))
    got = calling(_HINTS)(what, partial(student, *given))
    before, after = (memory.place, *seen[:4]), (given[0].place, *given[1:5])
    for key, old, new in zip(_ARRAYS, before, after, strict=True):
        if not np.array_equal(old, new, equal_nan=True):
            raise WrongAnswer(f"{what}: your function changes {key}; make a new array")
    return got


def _form(what: str, got: Any, *_: object) -> Answer:  # noqa: ANN401 - students' answers
    """A memory and a point, of the right form."""
    memory, target = parts(what, got, 2, "return memory, target: a Memory, and a point or None")
    if not isinstance(memory, Memory):
        words = f"the first thing that came back is {kind(memory)}; return a Memory"
        raise WrongAnswer(f"{what}: {words}, as Memory(...) or memory._replace(...) makes it")
    if not all(map(whole, memory[:3])) or int(memory.state) not in list(State):
        words = "memory.state is a State, memory.active and memory.visited are whole numbers"
        raise WrongAnswer(f"{what}: {words}; yours are {memory[:3]}")
    state = State(int(memory.state))
    if state in (State.LOST, State.DONE) and target is None:  # the rest no longer matters
        return memory._replace(state=state), None
    place = _point(f"{what}: memory.place", memory.place)
    for name in ("waited", "nearest"):
        value = getattr(memory, name)
        if not isinstance(value, int | float | np.number) or isinstance(value, bool):
            words = f"memory.{name} is {kind(value)}; it is a number"
            raise WrongAnswer(f"{what}: {words}")
    if target is not None:
        target = _point(f"{what}: the point to drive to", target)
    return memory._replace(place=place, state=state), target


def _point(what: str, got: Any) -> Array:  # noqa: ANN401
    try:
        point = np.asarray(got, dtype=float)
    except (TypeError, ValueError):
        raise WrongAnswer(f"{what} is {kind(got)}; it is an array (2,)") from None
    if point.shape != (2,) or not isinstance(got, np.ndarray | list | tuple):
        form = f"has shape {point.shape}" if isinstance(got, np.ndarray) else f"is {kind(got)}"
        raise WrongAnswer(f"{what} {form}; it is an array (2,)")
    return point


def _difference(got: Answer, want: Answer, memory: Memory, *seen: Any) -> str:  # noqa: ANN401
    """What is wrong with the memory or the point, part by part; empty if nothing is."""
    mine, right = got[0], want[0]
    if mine[:3] != right[:3]:
        return wrong_state(memory, seen, mine, right)
    if want[1] is None:
        words = f"a robot that is {right.state.name} stops: return None in place of a point"
        return "" if got[1] is None else words
    if got[1] is None:
        return f"the new state is {right.state.name}, so the robot drives on; return a point"
    if not np.allclose(mine.place, right.place, atol=1e-6):
        return wrong_place(memory, seen, mine, right)
    if not np.allclose(got[1], want[1], atol=1e-6):
        return wrong_target(seen, got[1], right)
    if not abs(mine.waited - right.waited) <= 1e-6:
        return wrong_clock(memory, mine, right)
    if not np.isclose(mine.nearest, right.nearest, atol=1e-6):
        return wrong_nearest(memory, mine, right)
    return ""
