"""The check of starting or refusing, in notebook 06."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from tutorial_lib.checks.engine import WrongAnswer, case, exercise, parts
from tutorial_lib.checks.nb06.forms import number, untouched, vertices
from tutorial_lib.checks.nb06.graphs import GOAL, HERE, SMALL_MAP, Graph, Vertex, random_graph
from tutorial_lib.checks.nb06.join_ends import join_ends
from tutorial_lib.checks.nb06.most_probable_path import Found, most_probable_path
from tutorial_lib.topology.planner import DijkstraPlanner

Decision = tuple[list[Vertex], float, str]
"""A path, its probability, and the reason to refuse; empty to start."""
REASONS = ("", "too improbable", "not on the map", "no path")


def decide(
    graph: Graph,
    from_here: Mapping[Vertex, float],
    to_goals: Sequence[Mapping[Vertex, float]],
    rules: DijkstraPlanner,
    join_ends: Callable[..., Graph] = join_ends,
    most_probable_path: Callable[..., Found] = most_probable_path,
) -> Decision:
    """The best path, its probability, and the reason to refuse; see the exercise."""
    sure = join_ends(graph, from_here, to_goals, rules.p_query, rules.p_goal)
    path, p = most_probable_path(sure, HERE, GOAL)
    if path:
        return path, p, "" if p >= rules.least else "too improbable"
    doubtful = join_ends(graph, from_here, to_goals, rules.p_query, rules.p_query)
    path, p = most_probable_path(doubtful, HERE, GOAL)
    return path, p, "not on the map" if path else "no path"


def _random_case(seed: int) -> tuple[Any, ...]:
    """A map of eight vertices, and rules of all kinds."""
    rng = np.random.default_rng(seed)
    seen, image = rng.uniform(0.2, 1.0, (2, 8)).round(2).tolist()
    least, query = rng.uniform(0.1, 0.7, 2).round(2).tolist()
    rules = DijkstraPlanner(least, query, round(float(rng.uniform(query, 1.0)), 2))
    return random_graph(8, 1, seed), dict(enumerate(seen[:3])), [dict(enumerate(image))], rules


_RULES = DijkstraPlanner(least=0.5, p_query=0.5, p_goal=0.985)
_OTHER = DijkstraPlanner(least=0.8, p_query=0.6, p_goal=0.9)
_LONG: Graph = {v: {v + 1: 0.9} for v in range(8)} | {8: {}}
_APART: Graph = {0: {}, 1: {}}
_FORK: Graph = {0: {1: 0.99, 2: 0.9}, 1: {}, 2: {}}
_HALF: Graph = {0: {1: 0.5}, 1: {}}
CASES: dict[str, tuple[Any, ...]] = {
    "a goal of this map": (SMALL_MAP, {0: 0.95}, [{2: 0.99}], _RULES),
    "a goal in another building": (SMALL_MAP, {0: 0.95}, [{2: 0.9, 3: 0.97}], _RULES),
    "a long path": (_LONG, {0: 0.99}, [{8: 0.99}], _RULES),
    "two ends of the path": (_FORK, {0: 0.99}, [{1: 0.98, 2: 0.99}], _RULES),
    "exactly as probable as needed": (_HALF, {0: 1.0}, [{1: 1.0}], _RULES),
    "the map is not reached from here": (SMALL_MAP, {0: 0.4}, [{2: 0.99}], _RULES),
    "the goal is not reached from the map": (SMALL_MAP, {0: 0.95}, [{2: 0.3}], _RULES),
    "a long path to a goal in another building": (_LONG, {0: 0.99}, [{8: 0.9}], _RULES),
    "no path to where it is seen": (_APART, {0: 0.9}, [{0: 0.6, 1: 0.99}], _RULES),
    "the goal is in sight": (SMALL_MAP, {0: 0.95}, [{HERE: 0.999, 2: 0.99}], _RULES),
    "other rules": (SMALL_MAP, {0: 0.7}, [{0: 0.92, 2: 0.95}], _OTHER),
    "other rules, a goal in another building": (SMALL_MAP, {0: 0.7}, [{2: 0.8}], _OTHER),
    "too improbable by other rules": (SMALL_MAP, {0: 0.7}, [{2: 0.95}], _OTHER),
    "daring rules": (_LONG, {0: 0.6}, [{8: 0.9}], DijkstraPlanner(0.1, 0.3, 0.5)),
    "seen by two images": (SMALL_MAP, {0: 0.95}, [{2: 0.9}, {3: 0.99}], _RULES),
    "RE to the goal equals p_goal": (SMALL_MAP, {0: 0.95}, [{2: 0.985}], _RULES),
    "RE from here equals p_query": (SMALL_MAP, {0: 0.5}, [{2: 0.99}], _RULES),
    "RE to the goal equals p_query": (SMALL_MAP, {0: 0.95}, [{2: 0.5}], _RULES),
    "only in sight": ({}, {}, [{HERE: 0.99}], _RULES),
    "doubtfully in sight": ({}, {}, [{HERE: 0.9}], _RULES),
    "an empty map": ({}, {}, [{}], _RULES),
    "nearly as probable as needed": ({0: {1: 0.4999}, 1: {}}, {0: 1.0}, [{1: 1.0}], _RULES),
    "seen by the second image alone": (SMALL_MAP, {0: 0.95}, [{}, {2: 0.99}], _RULES),
    "seen better by the first image": ({0: {}}, {0: 0.95}, [{0: 0.99}, {0: 0.6}], _RULES),
    "a better path to the second image": (_HALF, {0: 0.95}, [{1: 0.99}, {0: 0.99}], _RULES),
    "surely there, over a doubtful edge": (_HALF, {0: 0.9}, [{1: 0.99}], _RULES),
} | {f"numbers drawn at random ({seed})": _random_case(seed) for seed in range(10)}
MISTAKES = """
yours starts towards a goal that no vertex reaches with more than rules.p_goal; compare the edges to
the goal with it, not the path
    rules.p_query, rules.p_goal) -> rules.p_query, rules.p_query)
plan with edges to the goal above rules.p_goal first. Yours plans with all of them, and refuses
where the best path ends with a doubtful one although a surer one leads there
    rules.p_query, rules.p_goal) -> rules.p_query, rules.p_query)
    path, p, "" if -> path, p, "not on the map" if sure[path[-2]][GOAL] <= rules.p_goal else "" if
p_goal is for the edges to the goal; from here rules.p_query is enough
    rules.p_query, rules.p_goal) -> rules.p_goal, rules.p_goal)
    rules.p_query, rules.p_query) -> rules.p_goal, rules.p_query)
from here rules.p_query is enough in the first plan, too; rules.p_goal is for the edges to the goal
    rules.p_query, rules.p_goal) -> rules.p_goal, rules.p_goal)
from here rules.p_query, to the goal rules.p_goal; yours exchanges them
    rules.p_query, rules.p_goal) -> rules.p_goal, rules.p_query)
a path that is too improbable is the end; plan again only where there is none
    if path: -> if path and p >= rules.least:
in the second plan RE to the goal must be above rules.p_query as well
    rules.p_query, rules.p_query) -> rules.p_query, 0.0)
in the second plan rules.p_query counts at both ends, from here as well
    rules.p_query, rules.p_query) -> rules.p_goal, rules.p_query)
return the path of the second plan and its probability, though the robot refuses
    path, p, "not -> [], 0.0, "not
return a path that is too improbable, and its probability, all the same
    path, p, "" if -> *((path, p) if p >= rules.least else ([], 0.0)), "" if
the path leads from HERE to GOAL; both belong to it
    path, p, "" if -> path[1:-1], p, "" if
    path, p, "not -> path[1:-1], p, "not
rules.least is not always 0.5
    p >= rules.least -> p >= 0.5
rules.p_query is not always 0.5
    sure = -> rules = DijkstraPlanner(rules.least, 0.5, rules.p_goal); sure =
rules.p_goal is not always 0.985
    rules.p_goal) -> 0.985)
return the path also where it is too improbable: the user may overrule it
    path, p, "" if -> path if p >= rules.least else [], p, "" if
return the probability also where it is too low: the user wants to see it
    path, p, "" if -> path, p if p >= rules.least else 0.0, "" if
where the first plan is too improbable, its own path and probability are returned
    sure, HERE, GOAL) -> sure, HERE, GOAL); first = path
    if path: -> if path and p >= rules.least:
    "not on the map" if path -> "too improbable" if first else "not on the map" if path
compare the probability as it is, not rounded, with rules.least
    p >= rules.least -> round(p, 2) >= rules.least
the probability of a path is the product of its edges, not the weakest of them
    sure, HERE, GOAL)
        -> sure, HERE, GOAL); p = min((sure[v][w] for v, w in zip(path, path[1:])), default=p)
all goal images count; yours looks at the first only
    sure = -> to_goals = to_goals[:1]; sure =
the goal may be in sight: the edge from HERE to GOAL is a path as well
    sure = -> to_goals = [{v: p for v, p in r.items() if v != HERE} for r in to_goals]; sure =
a path that is less probable than rules.least is too improbable
    p >= rules.least -> True
exactly rules.least is enough
    p >= rules.least -> p > rules.least
the thresholds stand in rules, and are not always the same: rules.p_query, rules.p_goal and
rules.least
    sure = -> rules = DijkstraPlanner(least=0.5, p_query=0.5, p_goal=0.985); sure =
plan again with rules.p_query at both ends; yours drops every threshold
    rules.p_query, rules.p_query) -> 0.0, 0.0)
the two reasons are exchanged: a path with rules.p_query means not on the map
    if path else -> if not path else
where the second plan finds a path, the reason is not on the map, however improbable it is
    "not on the map" if path
        -> "too improbable" if path and p < rules.least else "not on the map" if path
rules.least is for the whole path, not for each of its edges
    p >= rules.least -> min(sure[v][w] for v, w in zip(path, path[1:])) >= rules.least
no path at all is not too improbable: is there a path? That comes first
    if path: -> if True:
the second plan only gives the reason: with edges to the goal below rules.p_goal the robot does not
start, however probable the path is
    "not on the map" if path -> "" if p >= rules.least else "not on the map" if path
the whole path must have rules.least, not rules.p_goal; that is for the edges to the goal
    p >= rules.least -> p > rules.p_goal
return the probability of the whole path, not only that of its last step
    sure, HERE, GOAL) -> sure, HERE, GOAL); p = sure[path[-2]][GOAL] if path else p
    doubtful, HERE, GOAL) -> doubtful, HERE, GOAL); p = doubtful[path[-2]][GOAL] if path else p
there is a path to a vertex from which RE to the goal is doubtful; return the reason: not on the map
    path, p, "not on the map" if path else -> [], 0.0,
there is no path with rules.p_goal; the reason depends on whether there is one with rules.p_query,
wherever the goal is seen
    "not on the map" if path
        -> "not on the map" if path and max(p for r in to_goals for p in r.values()) <= rules.p_goal
where even with rules.p_query there is no path, the reason is no path
    "not on the map" if path else "no path" -> "not on the map"
return the path and its probability also when the robot refuses
    path, p, "" if -> *((path, p) if p >= rules.least else ([], 0.0)), "" if
    path, p, "not -> [], 0.0, "not
"""


def _decision(what: str, got: Any, graph: Graph, *_: object) -> Decision:  # noqa: ANN401
    """A decision of the right form, its probability rounded."""
    path, probability, reason = parts(
        what, got, 3, "return the path, its probability and the reason"
    )
    if not isinstance(reason, str) or reason not in REASONS:
        raise WrongAnswer(f"{what}: the reason {reason!r} came back; give one of {REASONS}")
    path = vertices(what, path, {*graph, HERE, GOAL}, "as the path")
    return path, round(number(what, probability, "as the probability"), 9), reason


def _unlike(got: Decision, want: Decision, *case: Any) -> str:  # noqa: ANN401
    """What is wrong with a decision, and what leads to the right one."""
    graph, from_here, to_goals, rules = case
    shown = [f"{d[2] or 'start'!r}, path {d[0]} with {d[1]:.3g}" for d in (got, want)]
    joined = join_ends(graph, from_here, to_goals, rules.p_query, rules.p_goal)
    if most_probable_path(joined, HERE, GOAL)[0]:
        why = f"with edges to GOAL above p_goal = {rules.p_goal:g} there is a path, and its "
        why += f"probability decides: least is {rules.least:g}"
    elif want[0]:
        why = f"with p_goal = {rules.p_goal:g} there is no path, but with p_query = "
        why += f"{rules.p_query:g} at both ends there is one"
    else:
        why = f"even with p_query = {rules.p_query:g} at both ends there is no path"
    if want[0] == [HERE, GOAL] != got[0]:
        why = "the goal is in sight, and the edge from HERE to GOAL alone is the best path"
    if got[0] == want[0][1:-1] and want[0]:
        why = "HERE and GOAL belong to the path"
    if got[2] == want[2] and got[0] == want[0]:
        why = "the probability is that of the whole path"
    return f"yours returns {shown[0]}; {shown[1]} is right: {why}"


check_decide = exercise(
    decide,
    CASES,
    MISTAKES,
    about="Goals near and far, here and elsewhere, starts from nowhere, and rules of all kinds.",
    example=case(random_graph(80, 4, 3), {0: 0.9, 1: 0.9}, [{5: 0.99}], _RULES),
    calls=10,  # as for most_probable_path, which it calls
    invoke=untouched(decide),
    form=_decision,
    difference=_unlike,
)
