"""What goes wrong in a building: a way is blocked for good, or the goal is not in it at all."""

from __future__ import annotations

import time
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.driving.geodesics import CLEARANCE, GridPaths
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.report import Options, Report
from tutorial_lib.experiments.common.statistics import measured_over_worlds
from tutorial_lib.experiments.meng2020.table2 import WORLDS
from tutorial_lib.experiments.protocols.navigation import K, experiences, goals_of, navigate
from tutorial_lib.experiments.protocols.navigation_tasks import (
    PLACES,
    Building,
    Trials,
    building,
    trials,
)
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Observation
from tutorial_lib.learning.views import VIEWS
from tutorial_lib.parallel import for_each
from tutorial_lib.world.people import Person
from tutorial_lib.world.simulation import Simulation

TRIALS, QUICK_TRIALS = 60, 20
DETOUR = 2.5
"""Times the way that another way around may be long."""
_APART = 0.34  # metres between people who stand in a row; no car fits through
_MIDDLE = (0.25, 0.75)  # shares of the way between which it is blocked
_WIDEST = 1.6  # metres to the wall on either side, where a way can be blocked
_ELSEWHERE = 10_000  # goal pictures are from a world whose seed is so much less


def run(options: Options) -> Report:
    """Send robots on ways that are blocked, and to goals in another building."""
    begun = time.perf_counter()
    worlds = options.worlds or (WORLDS[:3] if options.quick else WORLDS)
    parts = for_each(run_world, worlds, options, label="faults")
    rows = [_row(fault, [part[fault] for part in parts]) for fault in parts[0]]
    took = time.perf_counter() - begun
    return Report("faults", options.seed, worlds, options.quick, took, rows)


def run_world(world: int, options: Options) -> dict[str, dict[str, Array]]:
    """One world: for each fault, columns (N,) of what came of it."""
    count = QUICK_TRIALS if options.quick else TRIALS
    house, agent = building(world, options.seed, PLACES), agents.meng()
    agent.learn(list(experiences(house)))
    asked = trials(house, 3 * count, np.random.default_rng([options.seed, world, 2]))
    there = building(abs(world - _ELSEWHERE), options.seed, PLACES)
    strange = trials(there, count, np.random.default_rng([options.seed, world, 3]))
    own = asked.subset(np.arange(min(count, len(asked))))
    seen = Simulation(house.scene, own.starts).observe()
    return with_blocked_ways(house, agent, asked, count) | {
        "own_goal": answers(agent, seen, own),
        "strange_goal": answers(agent, seen, strange),
    }


def with_blocked_ways(
    house: Building, agent: MengAgent, asked: Trials, count: int
) -> dict[str, dict[str, Array]]:
    """The same trials with nobody in the way, and with people across it."""
    people, kept, detours = blockades(house, asked, count)
    if not len(kept):
        nothing = {"reached": np.empty(0), "plans": np.empty(0)}
        return {"none": nothing, "blocked": nothing}
    blocked = replace(asked.subset(kept), seconds=2 * detours)
    goals = goals_of(blocked, VIEWS["camera16"], K)
    free = navigate(house, blocked, lambda _: agent.start(goals))
    journey = agent.start(goals)
    outcome = navigate(house, blocked, lambda _: journey, people)
    made = [sum(plan.probability > 0 for plan in plans) for plans in journey.history]
    return {
        "none": {"reached": free.there, "plans": np.ones(len(kept))},
        "blocked": {"reached": outcome.there, "plans": np.array(made)},
    }


def answers(agent: MengAgent, seen: Observation, asked: Trials) -> dict[str, Array]:
    """Whether the way to each goal is refused, and how probable the best one is."""
    goals = goals_of(asked, VIEWS["camera16"], K)
    pairs = range(min(len(goals), len(seen)))
    plans = [agent.planner.plan(seen[[i]], goals[i], agent.topomap) for i in pairs]
    return {
        "refused": np.array([bool(plan.refusal) for plan in plans]),
        "probability": np.array([plan.probability for plan in plans]),
    }


def blockades(
    house: Building, asked: Trials, count: int
) -> tuple[list[Person], NDArray[np.intp], Array]:
    """People who stand across the oracle's ways, where another way leads around them.

    Returns:
        The people, each seen and felt by one robot alone; numbers (M,) of the trials, M <= count;
        and how many seconds (M,) the oracle would need at its speed, there and around.
    """
    people: list[Person] = []
    kept, seconds = [], []
    for trial in range(len(asked)):
        if len(kept) == count:
            break
        track = asked.recorded.trajectories[trial].poses
        row = _across(house, track)
        if row is None:
            continue
        clearance = house.scene.clearance
        cells = np.indices(clearance.clearance.shape).reshape(2, -1).T
        gap = np.linalg.norm(clearance.centres(cells)[:, None] - row, axis=-1).min(axis=1)
        gap = np.maximum(gap - Person.radius, 0.0).reshape(clearance.clearance.shape)
        left = replace(clearance, clearance=np.minimum(clearance.clearance, gap).astype(np.float32))
        ends = track[[0, -1], :2]
        around = GridPaths(left).between(ends[:1], ends[1:])[0]
        straight = house.paths.between(ends[:1], ends[1:])[0]
        if not straight + 2 * CLEARANCE < around <= DETOUR * straight:
            continue
        for place in row:
            people.append(Person(place[None], speed=0.0, owner=len(kept)))
        kept.append(trial)
        # To the blockade, and then all the way around.
        seconds.append(asked.seconds[trial] * (1.0 + around / straight))
    return people, np.array(kept, dtype=np.intp), np.array(seconds)


def _across(house: Building, track: Array) -> Array | None:
    """Where people (P, 2) stand across a way (T, 3), at its narrowest; None if it is too wide."""
    first, last = (round(share * len(track)) for share in _MIDDLE)
    middle = track[first:last]
    x, y, heading = middle[house.scene.clearance.at(middle[:, :2]).argmin()]
    side = np.array([-np.sin(heading), np.cos(heading)])
    steps = np.arange(0.0, _WIDEST, _APART / 2)
    places = [np.array([[x, y]])]
    for sign in (-1, 1):
        points = np.array([x, y]) + sign * steps[:, None] * side
        free = house.scene.clearance.at(points) > 0
        if free.all():
            return None
        places.append(points[1 : int(free.argmin())])
    row = np.concatenate(places)
    order = np.argsort((row - [x, y]) @ side)
    return row[order][::2] if len(row) > 2 else row


def _row(fault: str, parts: list[dict[str, Array]]) -> dict[str, Any]:
    columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    where = np.repeat(np.arange(len(parts)), [len(next(iter(p.values()))) for p in parts])
    row: dict[str, Any] = {"fault": fault, "trials": len(where)}
    for name in ("reached", "refused"):
        shares: tuple[float | None, ...] = (None, None, None)
        if name in columns and len(where):
            shares = measured_over_worlds(_mean, where, columns[name].astype(float))
        row |= dict(zip((name, f"{name}_low", f"{name}_high"), shares, strict=True))
    for name in ("plans", "probability"):
        row[name] = _mean(columns[name]) if name in columns and len(where) else None
    return row


def _mean(column: Array) -> float:
    return float(column.mean())
