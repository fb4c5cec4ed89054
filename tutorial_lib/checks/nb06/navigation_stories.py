"""A scripted robot for `navigate`, and what happens to it, for the check of notebook 06."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tutorial_lib.checks.engine import WrongAnswer
from tutorial_lib.checks.nb06.graphs import GOAL, HERE, Graph, random_graph
from tutorial_lib.topology.planner import DijkstraPlanner

Ends = tuple[Mapping[int, float], Sequence[Mapping[int, float]]]
"""RE from here to vertices, and for each goal image RE to it."""
Drive = tuple[int, str, int]
"""Steps of following, how they end ("arrived", "lost" or "going" for ever), and where."""


@dataclass(frozen=True)
class Limits:
    """What a navigation may take.

    Attributes:
        replans: how often a robot may be lost and plan again.
        interval: steps from one attempt to plan to the next, while the robot turns.
        search: steps of turning without a path after which the robot gives up.
        steps: of the whole navigation.
    """

    replans: int = 8
    interval: int = 10
    search: int = 195
    steps: int = 1000


@dataclass(frozen=True)
class Story:
    """What happens to a robot.

    Attributes:
        graph: of the map.
        looks: what each look finds; the last one again and again.
        drives: what becomes of each path; the last one again and again.
        rules: of `decide`.
        limits: of the navigation.
    """

    graph: Graph
    looks: Sequence[Ends]
    drives: Sequence[Drive]
    rules: DijkstraPlanner
    limits: Limits


class ScriptedRobot:
    """A robot that acts out a story.

    Attributes:
        active: place along the path to which it is driving.
        log: of its calls.
    """

    def __init__(self, story: Story) -> None:
        """Begin."""
        self._story, self.log = story, list[tuple[Any, ...]]()
        self.active = 1
        self._looked = self._driven = self._steps = 0

    def look(self) -> Ends:
        """What is seen from here."""
        self._note("look")
        self._looked += 1
        near, far = self._story.looks[min(self._looked, len(self._story.looks)) - 1]
        return dict(near), [dict(image) for image in far]

    def turn(self) -> None:
        """Turn for a step."""
        self._note("turn")

    def follow(self, path: Any) -> str:  # noqa: ANN401 - students'
        """Drive for a step."""
        if not isinstance(path, list | tuple) or len(path) < 2:
            raise WrongAnswer(f"follow got {path!r}; give it the path that decide returned")
        if path[0] != HERE or path[-1] != GOAL:
            raise WrongAnswer(f"follow got {list(path)}; a path leads from HERE to GOAL, whole")
        self._note("follow", *path)
        drives = self._story.drives
        steps, end, place = drives[min(self._driven, len(drives) - 1)]
        self._steps += 1
        self.active = 1 + (len(path) - 2) * self._steps // (steps + 1)
        if self._steps < steps or end == "going":
            return "going"
        self.active = min(place, len(path) - 1) if end == "lost" else len(path) - 1
        self._driven, self._steps = self._driven + 1, 0
        return end

    def _note(self, *call: Any) -> None:  # noqa: ANN401
        self.log.append(call)
        if len(self.log) > 4 * self._story.limits.steps + 40:
            raise WrongAnswer("your function never ends; count the steps: limits.steps at most")


_MAP: Graph = {
    0: {1: 0.99},
    1: {2: 0.99, 5: 0.98},
    2: {3: 0.99, 6: 0.995},
    3: {4: 0.99},
    4: {3: 0.5},
    5: {3: 0.97},
    6: {2: 0.995, 3: 0.99},
}
_SEEN: Ends = ({0: 0.95}, [{4: 0.99}])
_NOTHING: Ends = ({0: 0.1}, [{4: 0.99}])
_FAR: Ends = ({0: 0.6}, [{4: 0.99}])
_FOREIGN: Ends = ({0: 0.95}, [{4: 0.9}])
_BY_5: Ends = ({5: 0.9}, [{4: 0.99}])
_RULES = DijkstraPlanner(least=0.7, p_query=0.5, p_goal=0.985)
_LIMITS = Limits(replans=3, interval=3, search=10, steps=60)
_GOES: Drive = (4, "arrived", 0)
_STUCK: Drive = (1, "going", 0)


def _told(looks: list[Ends], drives: list[Drive], graph: Graph = _MAP, **limits: int) -> Story:
    """A story with the usual rules, and limits of which some may be others."""
    return Story(graph, looks, drives, _RULES, replace(_LIMITS, **limits))


_LANES: Graph = {}
for _v in range(0, 130, 10):
    _LANES |= {_v: {_v + 1: 0.99}, _v + 1: {_v + 2: 0.99}, _v + 2: {}}
    if _v % 20:
        _LANES[_v + 1][_v] = 0.9
"""Lanes, each of which leads to the goal; in every second one there is a way back."""


def _lost_in_lanes(looks: str, places: list[int], replans: int = 8) -> Story:
    """A robot that is lost in one lane after another, and then arrives.

    Args:
        looks: a letter for each: lanes are "s"een, too "f"ar away, or "n"ot seen.
        places: where along its paths it is lost.
        replans: how often it may be lost.
    """
    nearest = {"s": 0.98, "f": 0.7, "n": 0.3}
    near = {letter: {v: p - 0.002 * v for v in range(0, 130, 10)} for letter, p in nearest.items()}
    goals = [{v + 2: 0.99 for v in range(0, 130, 10)}]
    drives = [*((2, "lost", place) for place in places), _GOES]
    limits = Limits(replans, interval=3, search=10, steps=400)
    return Story(_LANES, [(near[letter], goals) for letter in looks], drives, _RULES, limits)


def _random_story(seed: int) -> Story:
    """A map, looks and drives at random."""
    rng = np.random.default_rng(seed)

    def look() -> Ends:
        near, far = rng.uniform(0.2, 1.0, (2, 9)).round(2).tolist()
        keep = float(rng.uniform(0.3, 1.0))
        return {v: p for v, p in enumerate(near) if p < keep}, [dict(enumerate(far))]

    drives = []
    for _ in range(6):
        end = str(rng.choice(["lost", "lost", "arrived"]))
        drives.append((int(rng.integers(1, 5)), end, int(rng.integers(1, 5))))
    limits = Limits(int(rng.integers(0, 4)), int(rng.integers(1, 4)), 7, int(rng.integers(20, 50)))
    rules = DijkstraPlanner(0.3, 0.4, float(rng.choice([0.5, 0.9])))
    graph = random_graph(9, 2, seed)
    for v in range(0, 8, 2):
        graph[v][v + 1], graph[v + 1][v] = 0.9, 0.95
    return Story(graph, [look() for _ in range(8)], drives, rules, limits)


STORIES: dict[str, Story] = {
    "it arrives at once": _told([_SEEN], [_GOES]),
    "lost at a vertex, then it arrives": _told([_SEEN], [(2, "lost", 3), _GOES]),
    "lost at a vertex without neighbours": _told([_SEEN], [(2, "lost", 2), _GOES]),
    "lost where an edge leads back, but a poor one": _told([_SEEN], [(3, "lost", 5), _GOES]),
    "nothing in sight at first": _told([_NOTHING, _NOTHING, _SEEN], [_GOES]),
    "nothing in sight for ever": _told([_NOTHING], [_GOES]),
    "too improbable at the start": _told([_FAR], [_GOES]),
    "not on the map": _told([_FOREIGN], [_GOES]),
    "turned, then too improbable": _told([_NOTHING, _FAR], [_GOES]),
    "lost, then only improbable": _told([_SEEN, _FAR], [(2, "lost", 3), _GOES]),
    "lost at the goal, then only improbable": _told([_SEEN, _FAR], [(2, "lost", 99), _GOES]),
    "nothing in sight until the search is over": _told(
        [_NOTHING, _NOTHING, _SEEN], [_GOES], interval=5, search=10
    ),
    "nothing in sight for ever, a last look": _told([_NOTHING], [_GOES], interval=5, search=10),
    "lost, then nothing in sight": _told([_SEEN, _NOTHING], [(2, "lost", 3), _GOES]),
    "lost, nothing in sight, then it arrives": _told(
        [_NOTHING, _NOTHING, _SEEN, _NOTHING, _NOTHING, _NOTHING, _SEEN], [(2, "lost", 3), _GOES]
    ),
    "the goal itself cannot be reached": _told([_SEEN], [(5, "lost", 99), _GOES]),
    "lost in different places": _told([_SEEN, _BY_5, _SEEN], [(2, "lost", 3), (1, "lost", 1)]),
    "lost again and again at the goal": _told([_SEEN], [(3, "lost", 99)]),
    "no replan allowed": _told([_SEEN], [(2, "lost", 3), _GOES], replans=0),
    "one replan": _told([_SEEN], [(2, "lost", 99), (2, "lost", 99), _GOES], replans=1),
    "it never comes anywhere": _told([_SEEN], [_STUCK]),
    "the time is up while it searches": _told([_NOTHING], [_GOES], steps=5),
    "the time is up after it was lost": _told([_SEEN], [(4, "lost", 3), _STUCK], steps=11),
    "it looks at each step": _told([_NOTHING] * 4 + [_SEEN], [_GOES], interval=1),
    "it arrives in the last step": _told([_SEEN], [_GOES], steps=4),
    "it would arrive one step later": _told([_SEEN], [_GOES], steps=3),
    "it is lost in the last step": _told([_SEEN], [(4, "lost", 3)], steps=4),
    "it is lost once too often in the last step": _told(
        [_SEEN], [(4, "lost", 3)], replans=0, steps=4
    ),
    "there is a path in the last step": _told([_NOTHING, _SEEN], [_GOES], steps=4),
    "a path to another building in the last step": _told([_NOTHING, _FOREIGN], [_GOES], steps=4),
    "the search is over in the last step": _told([_NOTHING], [_GOES], steps=11),
    "the time is up just before the search": _told([_NOTHING], [_GOES], steps=10),
    "lost at one vertex, then at another": _told(
        [_SEEN], [(2, "lost", 3), (2, "lost", 3)], replans=1
    ),
    "lost beside vertices that have others beside them": _told(
        [_SEEN],
        [(2, "lost", 3), _GOES],
        _MAP | {6: {2: 0.995, 3: 0.99, 7: 0.9}, 7: {6: 0.9, 3: 0.9}},
    ),
    "the goal again and again, then it arrives": _told(
        [_SEEN], [(2, "lost", 99), (3, "lost", 99), (1, "lost", 99), _GOES]
    ),
    "lost at vertex 0": _told([_SEEN, _BY_5], [(2, "lost", 1), _GOES]),
    "an empty map, the goal in sight": _told(
        [({}, [{HERE: 0.99}])], [(2, "lost", 1), _GOES], graph={}
    ),
    "lost three times, each time with an improbable path": _lost_in_lanes("sfff", [2, 3, 1]),
    "lost four times, then nothing in sight": _lost_in_lanes("ssnsnsn", [2, 3, 1, 2]),
    "lost six times, five of them allowed": _lost_in_lanes("s", [2, 2, 99, 2, 2, 3], replans=5),
    "lost twelve times, then it arrives": _lost_in_lanes(
        "ssnfnnnsfsnsfns", [2, 3, 2, 2, 1, 99, 2, 2, 3, 2, 2, 2], replans=12
    ),
} | {f"at random ({seed})": _random_story(seed) for seed in range(10)}
