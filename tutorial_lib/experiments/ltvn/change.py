"""A door closes and opens again: which maps find the detour, and which use the door again?

In each building one door is closed for a while by people who stand in it. The recorded drives
between the queries' places lead through it. LTVN's map, as it was built, has a detour around it, on
which an oracle arrives facing as on the drive through the door, as the goal image asks. Maps that
mend themselves are LTVN's and Meng's; each is compared with the same map as it was built, and with
an oracle that knows of the door.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.ltvn import LTVNAgent
from tutorial_lib.agents.mending import MendingMengAgent
from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.agents.oracle import OracleNavigation
from tutorial_lib.driving.data.demonstrations import demonstrate_between
from tutorial_lib.driving.data.trajectories import Trajectory
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Finding, Notes, Options, Rows
from tutorial_lib.experiments.common.statistics import difference, over_worlds
from tutorial_lib.experiments.ltvn.lifelong import (
    FROZEN,
    MENDING,
    MENDING_MENG,
    MENG,
    NETWORK,
    ORACLE,
    learned_meng,
    prepared_agent,
)
from tutorial_lib.experiments.protocols.drives import part_of
from tutorial_lib.experiments.protocols.lifelong import image_poses, joined_outcomes, run_fleet
from tutorial_lib.experiments.protocols.navigation import (
    K,
    Outcome,
    goals_of,
    navigate,
)
from tutorial_lib.experiments.protocols.navigation_tasks import (
    Building,
    Trials,
    draw_trials,
    make_building,
)
from tutorial_lib.experiments.protocols.obstacles import across_door, path_left, paths_around
from tutorial_lib.geometry import Array, distance_to_segments
from tutorial_lib.learning.views import VIEWS
from tutorial_lib.parallel import for_each
from tutorial_lib.se2 import wrap
from tutorial_lib.world.floorplan import Door
from tutorial_lib.world.people import Person

DRIVES = "0.4"
"""Share of the drives between places that is learned: a tour seldom holds a detour."""
PHASES = OPEN, CLOSED, REOPENED = ("open", "closed", "open again")
LEAST = 4
"""Pairs of places whose path leads through a door, at least."""
DETOUR = 3.0
"""Times as long as the path through the door that the one around it is, at most."""
ALIKE = float(np.deg2rad(30.0))
"""Rad between headings that count as alike here; a goal counts as reached up to `FACING`."""
AGENTS = (MENDING, FROZEN, MENDING_MENG, MENG, ORACLE)
MENDED = ((MENDING, FROZEN), (MENDING_MENG, MENG))
"""Maps that mend themselves, each with the same as it was built."""


@dataclass(frozen=True)
class Settings:
    """Settings of the experiment.

    Attributes:
        agents: that are compared.
        queries: in each phase, the same in all.
        block: queries of one row.
        late: of the last queries of a phase, those that differences compare.
        fleet: robots that set off together.
    """

    agents: tuple[str, ...] = AGENTS
    queries: int = 50
    block: int = 10
    late: int = 30
    fleet: int = 5


@dataclass(frozen=True, eq=False)
class Doorway:
    """A door that closes.

    Attributes:
        people: who close it.
        pairs: (M,) numbers of the pairs of places between which the path leads through it, and one
            around it that ends facing alike.
        detour: by such a number, how many times as long the path around it is.
    """

    people: tuple[Person, ...]
    pairs: NDArray[np.intp]
    detour: dict[int, float]


def run(options: Options, settings: Settings) -> tuple[Rows, Notes]:
    """Let every agent live through all phases in every building that has such a door."""
    doors = for_each(doorway, options.worlds, options.seed, label="doors")
    known = {
        world: door for world, door in zip(options.worlds, doors, strict=True) if door is not None
    }
    notes: list[str | Finding] = [
        f"{len(known)} of {len(options.worlds)} worlds have a door with a detour"
    ]
    if not known:
        return [], notes
    items = [(world, door, name) for world, door in known.items() for name in settings.agents]
    lives = iter(for_each(lived, items, options.seed, settings, label="ltvn_change"))
    by_world = [{name: next(lives) for name in settings.agents} for _ in known]
    found = {name: [one[name] for one in by_world] for name in settings.agents}
    rows = [
        _row(name, phase, block, found[name], list(known), settings)
        for name in settings.agents
        for phase in PHASES
        for block in range(settings.queries // settings.block)
    ]
    return rows, notes + _differences(found, list(known), settings)


def _differences(
    found: dict[str, list[dict[str, Outcome]]], worlds: list[int], settings: Settings
) -> list[Finding]:
    """Paired, of the last queries of a phase: from those with the door open, and of two maps."""

    def of(name: str, phase: str) -> Array:
        last = [one[phase].success[-settings.late :].astype(float) for one in found[name]]
        return np.concatenate(last)

    some = next(iter(found.values()))
    units = np.repeat(worlds, [len(one[OPEN].success[-settings.late :]) for one in some])
    pairs = [((name, OPEN), (name, phase)) for name in found for phase in (CLOSED, REOPENED)]
    pairs += [((old, phase), (new, phase)) for new, old in MENDED for phase in PHASES]
    return [
        Finding(
            f"{' '.join(after)} - {' '.join(before)}", *difference(of(*after), of(*before), units)
        )
        for before, after in pairs
        if before[0] in found and after[0] in found
    ]


def _row(
    name: str,
    phase: str,
    block: int,
    parts: list[dict[str, Outcome]],
    worlds: list[int],
    settings: Settings,
) -> dict[str, Any]:
    some = slice(block * settings.block, (block + 1) * settings.block)
    success = [part[phase].success[some].astype(float) for part in parts]
    units = np.repeat(worlds, [len(one) for one in success])
    mean, low, high = over_worlds(np.concatenate(success), units)
    seconds = np.concatenate([part[phase].seconds[some] for part in parts])
    return {
        "agent": name,
        "phase": phase,
        "block": block,
        "worlds": len(worlds),
        "queries": len(units),
        "success": mean,
        "low": low,
        "high": high,
        "seconds": float(seconds.mean()),
    }


def lived(item: tuple[int, Doorway, str], seed: int, settings: Settings) -> dict[str, Outcome]:
    """One agent in one building, by phase."""
    world, door, name = item
    whole, building = _surveyed(world, seed)
    rng = np.random.default_rng([seed, world, 1])
    count = settings.queries
    trials = draw_trials(whole, count, rng, door.pairs)
    if len(trials) < count:
        raise InputError(f"queries: world {world} has room for {len(trials)}; ask for no more")
    longer = replace(trials, seconds=trials.seconds * _detours(whole, trials, door))
    agent = None if name == ORACLE else learned(building, name)
    found = {}
    for number, phase in enumerate(PHASES):
        some, people = (longer, door.people) if phase == CLOSED else (trials, ())
        if agent is None:
            found[phase] = _oracle(whole, some, people)
        else:
            found[phase] = _queries(building, some, agent, settings.fleet, number * count, people)
    return found


@lru_cache(maxsize=1)
def _surveyed(world: int, seed: int) -> tuple[Building, Building]:
    """A building, and the same with the drives that are learned; kept for the next agent."""
    whole = make_building(world, seed)
    return whole, part_of(whole, DRIVES, seed)


def _oracle(building: Building, trials: Trials, people: tuple[Person, ...]) -> Outcome:
    """Trials of robots that know where the people are."""
    paths = paths_around(building, _places(people)) if people else building.paths
    goals = trials.goal_poses
    return navigate(building, trials, lambda sim: OracleNavigation(sim, paths, goals), people)


def _places(people: Sequence[Person]) -> Array:
    """Where people stand, (P, 2)."""
    return np.concatenate([person.route for person in people])


def learned(building: Building, name: str) -> LTVNAgent | MengAgent:
    """An agent that has learned a building."""
    if name in (MENDING, FROZEN):
        return prepared_agent(building, name, NETWORK)
    return learned_meng(building, mends=name == MENDING_MENG)


def _queries(
    building: Building,
    trials: Trials,
    agent: LTVNAgent | MengAgent,
    fleet: int,
    first: int,
    people: tuple[Person, ...],
) -> Outcome:
    """Trials, one fleet after the other."""
    parts = []
    for begin in range(0, len(trials), fleet):
        some = trials.subset(np.arange(begin, min(begin + fleet, len(trials))))
        if isinstance(agent, LTVNAgent | MendingMengAgent):
            agent.upkeep.begin(first + begin)
        if isinstance(agent, LTVNAgent):
            outcome, _ = run_fleet(building, some, agent, people)
        else:
            goals = goals_of(some, VIEWS["camera16"], K)
            outcome = navigate(building, some, lambda _, g=goals: agent.start(g), people)
        parts.append(outcome)
    return joined_outcomes(parts)


def doorway(world: int, seed: int) -> Doorway | None:
    """The door that most drives lead through, of those with a detour that was learned."""
    whole, building = _surveyed(world, seed)
    agent = prepared_agent(building, FROZEN, NETWORK)
    poses = image_poses(building, agent)
    best: Doorway | None = None
    for door in whole.scene.plan.doors:
        people = across_door(door)
        places = _places(people)
        detours = {
            pair: longer
            for pair, longer in _around(whole, places, _through(whole, door)).items()
            if _is_learned(agent.sampled.graph, poses, places, whole.recorded.trajectories[pair])
        }
        if len(detours) >= LEAST and (best is None or len(detours) > len(best.pairs)):
            best = Doorway(tuple(people), np.array(sorted(detours)), detours)
    return best


def _through(whole: Building, door: Door) -> NDArray[np.intp]:
    """Numbers of the drives that lead through a door."""
    recorded, line = whole.recorded, np.array([[*door.start, *door.end]])
    gap = distance_to_segments(recorded.poses[:, :2], line)[:, 0]
    return np.array(
        [
            number
            for number in range(len(recorded.trajectories))
            if gap[recorded.frames_of(number)].min() < 0.1
        ],
        dtype=np.intp,
    )


def _around(whole: Building, places: Array, pairs: NDArray[np.intp]) -> dict[int, float]:
    """Of pairs with a path around people at places (P, 2) that ends facing alike: its detour."""
    around, recorded = paths_around(whole, places), whole.recorded
    starts = recorded.poses[recorded.first_frames[pairs]]
    goals = whole.places[whole.pairs[pairs, 1]]
    longer = around.between(starts[:, :2], goals) / whole.paths.between(starts[:, :2], goals)
    near = longer <= DETOUR
    if not near.any():
        return {}
    pairs, longer = pairs[near], longer[near]
    where = whole.name, whole.scene, around
    shown = demonstrate_between(*where, starts[near], goals[near], 0, body=whole.body)
    found = {}
    for pair, times, one in zip(pairs.tolist(), longer.tolist(), shown, strict=True):
        if one is not None and _alike(one.poses[-1], recorded.trajectories[pair].poses[-1]):
            found[pair] = times
    return found


def _is_learned(graph: nx.DiGraph, poses: Array, places: Array, drive: Trajectory) -> bool:
    """Whether a map has a path that leads through nobody and begins and ends as a drive does."""
    begins, ends = (
        (np.hypot(*(poses - pose)[:, :2].T) < 1.0) & _alike(poses, pose)
        for pose in drive.poses[[0, -1]]
    )
    return path_left(graph, poses, places, begins, ends)


def _alike(poses: Array, pose: Array) -> NDArray[np.bool_]:
    """Which poses (V, 3), or whether a single one (3,), face as another one does."""
    return np.abs(wrap(poses[..., 2] - pose[2])) <= ALIKE


def _detours(whole: Building, trials: Trials, door: Doorway) -> Array:
    """(N,) how many times as long each trial takes around the door."""
    number = {tuple(pair): i for i, pair in enumerate(whole.pairs.tolist())}
    return np.array([door.detour[number[tuple(pair)]] for pair in trials.pairs.tolist()])


QUICK = Settings(queries=20)
EXPERIMENT = Experiment(
    "ltvn_change",
    run,
    tuple(range(20_002, 20_041, 3)),
    tuple(range(20_002, 20_008, 3)),
    settings=Settings(),
    quick_settings=QUICK,
    canary=Settings((MENDING, MENDING_MENG), queries=1, block=1, fleet=1),
)
