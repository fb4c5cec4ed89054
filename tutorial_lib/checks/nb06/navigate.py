"""The check of the navigator's loop, in notebook 06."""

from collections.abc import Callable
from functools import partial
from itertools import cycle
from types import SimpleNamespace
from typing import Any

from tutorial_lib.checks.engine import WrongAnswer, case, exercise, parts
from tutorial_lib.checks.framework.wording import number_of
from tutorial_lib.checks.nb06.decide import Decision, decide
from tutorial_lib.checks.nb06.forms import explaining, number
from tutorial_lib.checks.nb06.graphs import GOAL, HERE, Graph, Vertex
from tutorial_lib.checks.nb06.navigation_stories import STORIES, Limits, ScriptedRobot, Story
from tutorial_lib.topology.planner import DijkstraPlanner

ENDINGS = ("arrived", "refused", "gave up", "late")
Navigated = tuple[str, list[Decision], set[Vertex]]
"""How it ended, all decisions, and the vertices that are excluded."""


def navigate(
    robot: Any,  # noqa: ANN401
    graph: Graph,
    rules: DijkstraPlanner,
    limits: Limits,
    decide: Callable[..., Decision] = decide,
) -> Navigated:
    """Plan, follow, search and replan, step by step; `robot` is like a `ScriptedRobot`."""
    path, searched, lost = [], 0, 0
    plans, excluded = list[Decision](), set[Vertex]()
    for _ in range(limits.steps):
        if not path and searched % limits.interval == 0:
            left = without(graph, excluded)
            path, probability, reason = decide(left, *robot.look(), rules)
            plans.append((path, probability, reason))
            if path and reason and not lost:
                return "refused", plans, excluded
        if not path:
            if searched >= limits.search:
                return "gave up", plans, excluded
            robot.turn()
            searched += 1
            continue
        state = robot.follow(path)
        if state == "arrived":
            return "arrived", plans, excluded
        if state == "lost":
            lost += 1
            vertex = path[robot.active]
            if vertex not in (HERE, GOAL):
                there, back = set(graph[vertex]), {v for v, out in graph.items() if vertex in out}
                excluded |= {vertex} | (there & back)
            if lost > limits.replans:
                return "gave up", plans, excluded
            path, searched = [], 0
    return "late", plans, excluded


def without(graph: Graph, excluded: set[Vertex]) -> Graph:
    """A graph without some vertices."""
    return {
        v: {w: p for w, p in out.items() if w not in excluded}
        for v, out in graph.items()
        if v not in excluded
    }


MISTAKES = """
exclude the vertices beside it, too: those that it leads to and that lead back
    {vertex} | (there & back) -> {vertex}
beside it are those that it leads to and that lead back to it, not all that it leads to
    there & back -> there
beside it are those that it leads to and that lead back to it, not all that lead to it
    there & back -> back
beside it are those with edges in both directions; one direction is not enough
    there & back -> there | back
exclude the vertex that could not be reached, path[robot.active], not the one before it
    path[robot.active] -> path[robot.active - 1]
exclude every vertex that could not be reached so far, not only the last one
    vertex = path -> excluded = set(); vertex = path
plan on the graph without what is excluded: without(graph, excluded)
    without(graph, excluded) -> graph
a robot that was lost takes a refused path rather than none
    reason and not lost -> reason
before it was lost, the robot ends with a refused path; yours drives it
    path and reason and not lost -> False
where there is no path, turn and look again; yours gives up at once
    searched >= limits.search -> True
after limits.search steps of turning the robot gives up
    searched >= limits.search -> False
while it turns, the robot looks every limits.interval steps, not at each
    % limits.interval -> % 1
while there is a path, follow it; yours plans again and again
    not path and searched -> searched
a robot that was lost needs a new plan; yours follows the old one
    path, searched = [], 0 -> pass
path.clear() also empties the path in plans, which is the same list; path = [] makes a new one
    path, searched = [], 0 -> path.clear(); searched = 0
each search begins anew: the steps of turning are counted from 0
    path, searched = [], 0 -> path = []
it may be lost limits.replans times and plan again; yours allows one less
    lost > limits.replans -> lost >= limits.replans
it may be lost limits.replans times and plan again; yours allows one more
    lost > limits.replans -> lost > limits.replans + 1
after limits.steps steps the ending is late
    "late" -> "gave up"
it turns limits.search times in a search, not once less, before it gives up
    limits.search -> limits.search - 1
it turns limits.search times in a search, not once more, before it gives up
    limits.search -> limits.search + 1
each turn and each follow is a step; there are limits.steps of them, not one less
    limits.steps -> limits.steps - 1
each turn and each follow is a step; there are limits.steps of them, not one more
    limits.steps -> limits.steps + 1
while it turns, the robot looks again every limits.interval steps
    searched % limits.interval == 0 -> searched == 0
it looks at the steps 0, limits.interval, 2 limits.interval ... of a search
    searched % -> (searched and searched + 1) %
the steps of turning in this search count for the next look, not those of the whole navigation
    for _ in -> for step in
    searched % -> step %
where a look is due, it comes before giving up: there may be a path now
    searched % -> searched < limits.search and searched %
a path with a reason against it ends the navigation: refused; yours turns on
    return "refused", plans, excluded -> path = []
whether the robot was lost counts for a refusal, not whether anything is excluded
    not lost -> not excluded
as soon as there is a path, follow it in the same step
    path, searched, lost = [], 0, 0 -> path, searched, lost, follows = [], 0, 0, False
    robot.follow(path) -> robot.follow(path) if follows else robot.turn(); follows = True
    path, searched = [], 0 -> path, searched, follows = [], 0, False
a path with a reason ends the navigation only if the robot was never lost, not even once
    reason and not lost -> reason and lost != 1
every loss excludes what could not be reached, and it all stays excluded; yours keeps two
    excluded |= -> excluded |= set() if lost > 2 else
it may be lost limits.replans times, however many that are; yours stops at three
    lost > limits.replans -> lost > min(limits.replans, 3)
GOAL is no vertex of the map: it is never excluded
    vertex = path[robot.active] -> vertex = path[robot.active]; excluded |= {vertex} & {GOAL}
exclude the vertex that could not be reached, path[robot.active], not the one after it
    path[robot.active] -> path[min(robot.active + 1, len(path) - 1)]
ask robot.active after follow has returned lost; before, it was another one
    state = robot -> before = robot.active; state = robot
    path[robot.active] -> path[min(before, len(path) - 1)]
return all vertices that were excluded, also on arrival
    "arrived", plans, excluded -> "arrived", plans, set()
the first step of a search looks; yours turns before
    searched % -> (searched + 1) %
look again in each search: what was seen at first is of another place
    path, searched, lost = -> seen = robot.look(); path, searched, lost =
    *robot.look() -> *seen
not on the map is a reason, too: any reason refuses a robot that was never lost
    reason and not -> reason == "too improbable" and not
without a path there is nothing to refuse: turn, and look again
    path and reason and -> reason and
a robot that was lost takes an improbable path; yours turns on
    plans.append((path, probability, reason))
        -> plans.append((path, probability, reason)); path = [] if reason and lost else path
limits.search counts steps of turning, not looks
    searched >= limits.search -> len(plans) >= limits.search
exclude path[robot.active], not the first vertex of the path
    path[robot.active] -> path[1]
being lost before the goal counts as well: limits.replans is for the whole drive
    lost += 1 -> lost += path[robot.active] != GOAL
being lost at a vertex counts each time, not only before the goal
    lost += 1 -> lost += path[robot.active] == GOAL or not lost
lost before the goal is no end: nothing is excluded, and the robot searches again
    lost > limits.replans -> lost > limits.replans or vertex == GOAL
the vertex that could not be reached is excluded itself, not only those beside it
    {vertex} | (there & back) -> there & back
beside a vertex are those one edge away, there and back, not those beside them as well
    (there & back)
        -> {w for v in there & back for w in [v, *(w for w in graph[v] if v in graph[w])]}
"""


def _play(travels: Callable[..., Any], story: Story) -> tuple[Any, list[tuple[Any, ...]]]:
    """What a navigation returns, and the log of the robot."""
    robot, graph = ScriptedRobot(story), {v: dict(out) for v, out in story.graph.items()}
    answer = travels(robot, graph, story.rules, story.limits)
    if graph != story.graph:
        raise WrongAnswer("your function changes the map; plan on a copy, without(graph, excluded)")
    return answer, robot.log


def _invoke(what: str, student: Callable[..., Any], story: Story) -> Any:  # noqa: ANN401
    hints: dict[type[Exception], str] = {
        KeyError: "GOAL and HERE are no vertices of the map; graph[vertex] holds its edges",
        TypeError: "look() and turn() take nothing, follow(path) the path; active is a number",
    }
    return explaining(what, partial(_play, student, story), hints)


_STATES = cycle(["going"] * 9 + ["arrived"])
_EXAMPLE = SimpleNamespace(
    active=1,
    look=lambda: ({0: 0.9}, [{5: 0.99}]),
    turn=lambda: None,
    follow=lambda path: next(_STATES),
)
"""A robot that arrives after ten steps."""
_LINE: Graph = {v: {v + 1: 0.99} for v in range(5)} | {5: {}}


def _form(what: str, got: tuple[Any, list[Any]], *_: object) -> tuple[Any, ...]:
    """The outcome of a navigation in the right form, and the robot's log."""
    words = "return the ending, the list of plans, and the set of what is excluded"
    ending, plans, excluded = parts(what, got[0], 3, words)
    if not isinstance(ending, str) or ending not in ENDINGS:
        raise WrongAnswer(f"{what}: the ending {ending!r} came back; give one of {ENDINGS}")
    if not isinstance(plans, list | tuple) or any(
        not isinstance(plan, list | tuple)
        or len(plan) != 3
        or not isinstance(plan[0], list | tuple)
        for plan in plans
    ):
        raise WrongAnswer(f"{what}: plans is a list of what decide returned, a tuple of 3 each")
    if not isinstance(excluded, set | frozenset | list | tuple) or any(
        isinstance(vertex, list | set | dict) for vertex in excluded
    ):
        raise WrongAnswer(f"{what}: return the set of the vertices that are excluded")
    shown = [
        (list(path), round(number(what, probability, "as a probability"), 9), reason)
        for path, probability, reason in plans
    ]
    return ending, shown, set(excluded), got[1]


def _broken(got: tuple[Any, ...], want: tuple[Any, ...], *_: Any) -> str:  # noqa: ANN401
    """Which part of the rule is broken."""
    mine, right = got[3], want[3]
    common = next(
        (i for i, pair in enumerate(zip(mine, right, strict=False)) if len({*pair}) > 1), None
    )
    looks = sum(call[0] == "look" for call in right[:common])
    planned = common is not None and got[1][:looks] == want[1][:looks]
    if common is not None and (not planned or mine[common][0] == right[common][0]):
        return (
            "follow the path that decide returned in this search; it plans on the map without all "
            "that was excluded so far, after every loss"
        )
    if common is not None:
        return (
            "one step is one turn or one follow; a search looks, then turns until a path is found"
        )
    if len(mine) != len(right):
        return _ENDS[got[0] if len(mine) < len(right) else want[0]]
    if got[2] != want[2]:
        return "the vertex at robot.active is excluded, and those joined with it both ways"
    return "return the ending, everything that decide returned, and what is excluded"


_ENDS = {
    "arrived": "it goes on until the robot has arrived",
    "refused": "a path with a reason ends it, before it was ever lost",
    "gave up": "give up when lost once more than limits.replans, or after limits.search steps of "
    "turning in one search",
    "late": "each turn and each follow is a step; there are limits.steps of them",
}
"""For each ending, when it is right."""


def _differ(got: tuple[Any, ...], want: tuple[Any, ...], story: Story) -> str:
    """Where a navigation first goes another way."""
    for call, (mine, right) in enumerate(zip(got[3], want[3], strict=False)):
        if mine == right:
            continue
        when = f"in call {call + 1} of the robot"
        if mine[0] == right[0] == "follow":
            return f"{when} yours follows {list(mine[1:])}; {list(right[1:])} is right"
        before = want[3][call - 1][0] if call else ""
        why = _DUE[before == "follow"][right[0]]
        before = f", after {before}" if before else ""
        return f"{when} yours calls {mine[0]}, but {right[0]} is right{before}: {why}"
    if len(got[3]) != len(want[3]):
        longer = len(got[3]) > len(want[3])
        least = min(len(got[3]), len(want[3]))
        after, right = (f"after {number_of(count, 'call')}" for count in (least, len(want[3])))
        ends = f"goes on, and calls {got[3][least][0]}" if longer else f"ends with {got[0]!r}"
        due = "" if longer else f", but {want[3][least][0]} is due"
        return f"{after} yours {ends}{due}; the right end is {want[0]!r}, {right}"
    if got[0] != want[0]:
        return f"the ending is {want[0]!r}, not {got[0]!r}"
    if got[2] != want[2]:
        return f"excluded is {sorted(got[2])}, but {sorted(want[2])} is right"
    if len(got[1]) != len(want[1]):
        return f"plans has length {len(got[1])}; keep all {len(want[1])} that decide returned"
    number = next(
        i for i, pair in enumerate(zip(got[1], want[1], strict=True)) if pair[0] != pair[1]
    )
    return f"plan {number} of the list is {got[1][number]}, but decide returned {want[1][number]}"


_DUE = {
    False: {
        "look": "a look is due in the first step of a search, and every limits.interval steps of "
        "turning",
        "turn": "there is no path, and no other look is due yet",
        "follow": "there is a path that it may take",
    },
    True: {
        "look": "it was lost, and a search begins with a look: it stands elsewhere now",
        "turn": "it was lost",
        "follow": "it is on its way: nothing but follow until it arrives or is lost",
    },
}
"""Whether the call before was follow, and the right call: why it is due."""


check_navigate = exercise(
    navigate,
    {name: case(story) for name, story in STORIES.items()},
    MISTAKES,
    about="Robots that arrive, search, refuse, are lost here and there, and run out of time.",
    example=case(_EXAMPLE, _LINE, DijkstraPlanner(), Limits()),
    calls=10,
    endless="navigate: your function has not ended after {seconds:g} seconds. Count the steps in "
    "one place: each round of the loop is one step, and there are limits.steps at most",
    run=_play,
    invoke=_invoke,
    form=_form,
    difference=_differ,
    broken=_broken,
)
