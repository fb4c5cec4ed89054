"""The check of the follower's loop, in notebook 04."""

import copy
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np

from tutorial_lib.checks.engine import WrongAnswer, exercise, kind, parts
from tutorial_lib.checks.framework.answers import as_floats
from tutorial_lib.checks.nb04.forms import calling, whole
from tutorial_lib.checks.nb04.observations import RULES
from tutorial_lib.checks.nb04.toy_corridor import STEP, STORIES, Corridor, Memory, Story
from tutorial_lib.checks.nb04.transition import transition
from tutorial_lib.se2 import Array, to_local, to_world
from tutorial_lib.topology.following.transitions import FollowerSettings, State

Answer = tuple[Memory, Array | None]
_NEARER = 0.05  # metres that count as coming nearer


def follow_step(
    memory: Memory,
    reach: Array,
    overlap: Array,
    waypoints: Array,
    odometry: Array,
    rules: FollowerSettings,
) -> Answer:
    """What a follower remembers after a step, and the point (2,) to drive to; see the exercise."""
    before, old, place = memory.state, memory.active, memory.place
    at = bool(np.linalg.norm(waypoints[old]) < rules.at and reach[old] > rules.p_lose)
    state, active, visited = transition(
        before, old, memory.visited, reach, overlap, at, memory.waited, rules
    )
    if state in (State.LOST, State.DONE):
        return memory._replace(state=state, active=active, visited=visited), None
    if state == State.FOLLOW or active != old:
        place = to_world(odometry, waypoints[active])
    target = to_local(odometry, place)
    distance = float(np.linalg.norm(target))
    waited, nearest = memory.waited + STEP, memory.nearest
    changed = state != before or active != old
    if changed or (state == State.FOLLOW and distance < memory.nearest - _NEARER):
        waited, nearest = 0.0, distance
    new = Memory(state, active, visited, place, waited, nearest)
    if state == State.FOLLOW and waited > rules.effort:
        return new._replace(state=State.LOST), None
    return new, target


def _exact(
    ahead: float,
    reach: float = 0.97,
    waited: float = 1.0,
    nearest: float = 1.05,
    **rules: Any,  # noqa: ANN401
) -> tuple[Any, ...]:
    """A step in which the only anchor of a path lies straight ahead."""
    memory = Memory(State.FOLLOW, 0, -1, np.array([2.0, 0.0]), waited, nearest)
    seen = np.array([reach]), np.array([0.3]), np.array([[ahead, 0.0]]), np.zeros(3)
    return memory, *seen, replace(RULES, **rules)


_EXACT = {
    "exactly rules.at from the waypoint": _exact(0.25),
    "at the waypoint, whose old place is far ahead": _exact(0.1),
    "at the waypoint, RE of exactly rules.p_lose": _exact(0.1, reach=0.4),
    # Of these numbers every way to write the difference makes exactly 0.05.
    "exactly 0.05 m nearer": _exact(0.05, nearest=0.1, at=0.01),
    "0.03 m farther than the nearest": _exact(1.5, nearest=1.47),
    "without progress for exactly rules.effort": _exact(1.5, waited=0.0, effort=0.1),
    "without progress for a minute": _exact(1.5, waited=60.0),
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


def _drives() -> Iterator[dict[str, tuple[Any, ...]]]:
    """Of each story the moments, and the exact ones with them."""
    for story in STORIES.items():
        yield _moments(*story) | _EXACT


MISTAKES = """
at needs RE of the active anchor above rules.p_lose, too; below it the waypoint means nothing
    reach[old] > rules.p_lose -> True
RE above rules.p_lose is enough for at; rules.p_follow is not needed
    rules.p_lose -> rules.p_follow
at compares the distance to the waypoint as it is predicted now, not to the old place
    norm(waypoints[old]) -> norm(place - odometry[:2])
at compares the distance to the waypoint, not only how far ahead it lies
    np.linalg.norm(waypoints[old]) -> abs(waypoints[old, 0])
transition needs waited, or dead reckoning never ends
    at, memory.waited, rules -> at, 0.0, rules
transition gets waited as it is in memory; it grows at the end of the step
    at, memory.waited, rules -> at, memory.waited + STEP, rules
a robot that stops remembers its new state as well: return a new Memory
    memory._replace(state=state, active=active, visited=visited), None -> memory, None
in Follow a new waypoint is taken at every step, not only when something changes
    state == State.FOLLOW or -> state != before or
only nearer by more than 0.05 m is progress; any less may be noise
    memory.nearest - _NEARER -> memory.nearest
progress is a point nearer than nearest by more than 0.05 m: distance < nearest - 0.05
    - _NEARER -> + _NEARER
progress is a change of the state or of the active anchor; the one visited does not count
    changed = -> changed = visited != memory.visited or
nearest changes with progress alone, or many steps of less than 0.05 m would never count
    + STEP, memory.nearest -> + STEP, min(memory.nearest, distance)
in a Memory waited comes before nearest
    place, waited, nearest -> place, nearest, waited
waited is compared with rules.effort after this step has been added, not before
    waited > rules.effort -> memory.waited > rules.effort
a robot in Follow gives up after rules.effort; rules.timeout is for dead reckoning
    rules.effort -> rules.timeout
a robot in Follow that gets nowhere gives up: LOST, after rules.effort seconds
    waited > rules.effort -> False
a robot that gives up is LOST; the new memory must hold that
    state == State.FOLLOW and waited > -> waited >
    new._replace(state=State.LOST), None -> new, None
rules.effort is for Follow alone; when dead reckoning ends, transition decides
    state == State.FOLLOW and waited > -> waited >
"""
_HINTS: dict[type[Exception], str] = {
    IndexError: "reach, overlap and waypoints have a row for each anchor, 0 to L - 1",
    ValueError: "waypoints is (L, 2), odometry (3,), and the point to drive to (2,)",
    TypeError: "memory is a named tuple; make a new one, by Memory(...) or memory._replace(...)",
    AttributeError: "memory has state, active, visited, place, waited and nearest, and is not "
    "written to: make a new one",
    KeyError: "memory has state, active, visited, place, waited and nearest",
    NameError: "is it spelt right, and is its cell run?",
}
_ARRAYS = ("memory.place", "reach", "overlap", "waypoints", "odometry")


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
            raise WrongAnswer(f"{what}: memory.{name} is {kind(value)}; it is a number")
    if target is not None:
        target = _point(f"{what}: the point to drive to", target)
    return memory._replace(place=place, state=state), target


def _point(what: str, got: Any) -> Array:  # noqa: ANN401
    try:
        point = as_floats(got)
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
        return _wrong_state(memory, seen, mine, right)
    if want[1] is None:
        words = f"a robot that is {right.state.name} stops: return None in place of a point"
        return "" if got[1] is None else words
    if got[1] is None:
        return f"the new state is {right.state.name}, so the robot drives on; return a point"
    if not np.allclose(mine.place, right.place, atol=1e-6):
        return _wrong_place(memory, seen, mine, right)
    if not np.allclose(got[1], want[1], atol=1e-6):
        return _wrong_target(seen, got[1], right)
    if not abs(mine.waited - right.waited) <= 1e-6:
        return _wrong_clock(memory, mine, right)
    if not np.isclose(mine.nearest, right.nearest, atol=1e-6):
        return _wrong_nearest(memory, mine, right)
    return ""


def _wrong_state(memory: Memory, seen: tuple[Any, ...], mine: Memory, right: Memory) -> str:
    """Why state and anchors are others."""
    reach, waypoints, rules = seen[0], seen[2], seen[4]
    told = [f"{m.state.name}, active {m.active}, visited {m.visited}" for m in (mine, right)]
    words = f"{told[0]} came back, {told[1]} is right"
    followed, effort = memory.state == State.FOLLOW, f"rules.effort = {rules.effort:g} s"
    if followed and mine.state == right.state == State.LOST:
        kept = "its active and its visited anchor stay as they are"
        return f"{words}: a robot that gives up is LOST, and {kept}"
    if followed and right.state == State.LOST:
        return f"{words}: no nearer for more than {effort}, so it gives up"
    if followed and mine.state == State.LOST:
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


def _wrong_place(memory: Memory, seen: tuple[Any, ...], mine: Memory, right: Memory) -> str:
    """Why the place of the waypoint is another."""
    waypoints, odometry = seen[2], seen[3]
    if np.isnan(mine.place).any():
        return "place is not a number: the waypoint of an anchor that was not queried"
    if np.allclose(right.place, memory.place, atol=1e-9):
        return (
            "place changes, but no new waypoint is taken in dead reckoning, where the active "
            "anchor is the same: the old one stays where it is in the odometer's frame"
        )
    waypoint = waypoints[right.active]
    mirrored = to_world(odometry * [1.0, 1.0, -1.0], waypoint)
    degrees = to_world([*odometry[:2], np.deg2rad(odometry[2])], waypoint)
    candidates = {
        "place is the waypoint in the robot's frame; keep it in the odometer's, to_world(odometry, "
        "...)": waypoint,
        "place is still that of the anchor that was active before, or the old one; a new waypoint "
        "is taken in Follow at every step, and whenever the active anchor has changed, that of the "
        "new one": to_world(odometry, waypoints[memory.active]),
        "a new waypoint is missing: in Follow at every step, and whenever the active anchor has "
        "changed": memory.place,
        "the odometer's pose turns the waypoint, it does not only shift it: to_world": (
            odometry[:2] + waypoint
        ),
        "the heading turns the waypoint the other way: look at the signs of the sine": mirrored,
        "the heading is in radians already": degrees,
        "to_world, not to_local: the waypoint is in the robot's frame and goes to the odometer's": (
            to_local(odometry, waypoint)
        ),
    }
    told = f"place is {_told(mine.place)}, {_told(right.place)} is right, in the odometer's frame"
    return _first_near(mine.place, candidates) or told


def _wrong_target(seen: tuple[Any, ...], mine: Array, right: Memory) -> str:
    """Why the point to drive to is another."""
    odometry, place, waypoint = seen[3], right.place, seen[2][right.active]
    want, shifted = to_local(odometry, place), place - odometry[:2]
    candidates = {
        "y is positive to the left, as everywhere": want * [1.0, -1.0],
        "the point is in the odometer's frame; the robot needs it in its own: to_local": place,
        "the point is shifted, but not turned into the robot's frame: to_local": shifted,
        "the point is the waypoint as it is predicted now; in dead reckoning it is the old one": (
            waypoint
        ),
    }
    words = f"the point to drive to is {_told(mine)}, {_told(want)} is right"
    return _first_near(mine, candidates) or f"{words}: place, in the robot's present frame"


def _first_near(point: Array, candidates: dict[str, Array]) -> str | None:
    """What to say of the first candidate that is this point."""
    near = (words for words, other in candidates.items() if np.allclose(point, other, atol=1e-6))
    return next(near, None)


def _wrong_clock(memory: Memory, mine: Memory, right: Memory) -> str:
    """Why the clock shows something else."""
    told = f"waited is {mine.waited:.3g} s, {right.waited:.3g} s is right"
    if right.state != memory.state:
        return f"{told}: the state has changed, so the clock starts again at 0"
    if right.active != memory.active:
        return f"{told}: the active anchor has changed, so the clock starts again at 0"
    if right.waited == 0.0:
        return f"{told}: it came nearer by more than {_NEARER} m, so the clock starts again at 0"
    if abs(mine.waited - memory.waited - 1.0) < 1e-9:
        return f"{told}: a step lasts 0.1 s, not 1 s"
    if mine.waited == 0.0 and right.state == State.DEAD_RECKONING:
        return f"{told}: in dead reckoning the clock runs, however near the old waypoint is"
    if mine.waited == 0.0:
        gap = f"it is {right.nearest:.3f} m at best until now"
        return f"{told}: it came no nearer by more than {_NEARER} m; {gap}"
    return f"{told}: a step without progress adds 0.1 s"


def _wrong_nearest(memory: Memory, mine: Memory, right: Memory) -> str:
    """Why the least distance is another."""
    told = f"nearest is {mine.nearest:.4g} m, {right.nearest:.4g} m is right"
    if right.waited == 0.0:
        return f"{told}: whenever the clock starts again, it is the distance to the point"
    words = f"it changes only when the clock starts again, or many steps of less than {_NEARER} m"
    return f"{told}: {words} would never count"


def _told(point: Array) -> str:
    return f"({point[0]:.3g}, {point[1]:.3g}) m"


def _example() -> tuple[Any, ...]:
    corridor, memory = Corridor(STORIES["undisturbed"]), Memory(State.FOLLOW, 1, 0)
    return memory, *corridor.observe(memory), STORIES["undisturbed"].rules


check_follow_step = exercise(
    follow_step,
    _drives,
    MISTAKES,
    about="Seventeen drives along a corridor: left alone, blind, pushed, behind a chair, and lost.",
    example=_example(),
    calls=10_000,
    invoke=_invoke,
    form=_form,
    same=lambda got, want, *case: not _difference(got, want, *case),
    difference=_difference,
)
