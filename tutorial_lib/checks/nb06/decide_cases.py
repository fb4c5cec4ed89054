"""Maps, views and rules to decide about, for the check of notebook 06."""

from __future__ import annotations

from typing import Any

import numpy as np

from tutorial_lib.checks.nb06.graphs import HERE, SMALL_MAP, Graph, random_graph
from tutorial_lib.topology.planner import DijkstraPlanner


def _random_case(seed: int) -> tuple[Any, ...]:
    """A map of eight vertices, and rules of all kinds."""
    rng = np.random.default_rng(seed)
    seen, image = rng.uniform(0.2, 1.0, (2, 8)).round(2).tolist()
    least, query = rng.uniform(0.1, 0.7, 2).round(2).tolist()
    rules = DijkstraPlanner(least, query, round(float(rng.uniform(query, 1.0)), 2))
    return random_graph(8, 1, seed), dict(enumerate(seen[:3])), [dict(enumerate(image))], rules


RULES = DijkstraPlanner(least=0.5, p_query=0.5, p_goal=0.985)
_OTHER = DijkstraPlanner(least=0.8, p_query=0.6, p_goal=0.9)
_LONG: Graph = {v: {v + 1: 0.9} for v in range(8)} | {8: {}}
_APART: Graph = {0: {}, 1: {}}
_FORK: Graph = {0: {1: 0.99, 2: 0.9}, 1: {}, 2: {}}
_HALF: Graph = {0: {1: 0.5}, 1: {}}
CASES: dict[str, tuple[Any, ...]] = {
    "a goal of this map": (SMALL_MAP, {0: 0.95}, [{2: 0.99}], RULES),
    "a goal in another building": (SMALL_MAP, {0: 0.95}, [{2: 0.9, 3: 0.97}], RULES),
    "a long path": (_LONG, {0: 0.99}, [{8: 0.99}], RULES),
    "two ends of the path": (_FORK, {0: 0.99}, [{1: 0.98, 2: 0.99}], RULES),
    "exactly as probable as needed": (_HALF, {0: 1.0}, [{1: 1.0}], RULES),
    "the map is not reached from here": (SMALL_MAP, {0: 0.4}, [{2: 0.99}], RULES),
    "the goal is not reached from the map": (SMALL_MAP, {0: 0.95}, [{2: 0.3}], RULES),
    "a long path to a goal in another building": (_LONG, {0: 0.99}, [{8: 0.9}], RULES),
    "no path to where it is seen": (_APART, {0: 0.9}, [{0: 0.6, 1: 0.99}], RULES),
    "the goal is in sight": (SMALL_MAP, {0: 0.95}, [{HERE: 0.999, 2: 0.99}], RULES),
    "other rules": (SMALL_MAP, {0: 0.7}, [{0: 0.92, 2: 0.95}], _OTHER),
    "other rules, a goal in another building": (SMALL_MAP, {0: 0.7}, [{2: 0.8}], _OTHER),
    "too improbable by other rules": (SMALL_MAP, {0: 0.7}, [{2: 0.95}], _OTHER),
    "daring rules": (_LONG, {0: 0.6}, [{8: 0.9}], DijkstraPlanner(0.1, 0.3, 0.5)),
    "seen by two images": (SMALL_MAP, {0: 0.95}, [{2: 0.9}, {3: 0.99}], RULES),
    "RE to the goal equals p_goal": (SMALL_MAP, {0: 0.95}, [{2: 0.985}], RULES),
    "RE from here equals p_query": (SMALL_MAP, {0: 0.5}, [{2: 0.99}], RULES),
    "RE to the goal equals p_query": (SMALL_MAP, {0: 0.95}, [{2: 0.5}], RULES),
    "only in sight": ({}, {}, [{HERE: 0.99}], RULES),
    "doubtfully in sight": ({}, {}, [{HERE: 0.9}], RULES),
    "an empty map": ({}, {}, [{}], RULES),
    "nearly as probable as needed": ({0: {1: 0.4999}, 1: {}}, {0: 1.0}, [{1: 1.0}], RULES),
    "seen by the second image alone": (SMALL_MAP, {0: 0.95}, [{}, {2: 0.99}], RULES),
    "surely there, over a doubtful edge": (_HALF, {0: 0.9}, [{1: 0.99}], RULES),
} | {f"numbers drawn at random ({seed})": _random_case(seed) for seed in range(10)}
