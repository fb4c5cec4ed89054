"""Hundreds of queries in one building, with maps that mend themselves and maps that do not.

All agents learn one tour and get the first of the same queries, each as many as `Settings.agents`
says, in fleets that set off together and share a map. LTVN's map and the same as it was built also
run with true perception, so that errors of the model and of the maintenance can be told apart.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from tutorial_lib.agents.ltvn import LTVNAgent
from tutorial_lib.agents.ltvn_state import TravelSettings
from tutorial_lib.agents.mending import MendingMengAgent
from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.agents.oracle import OracleNavigation
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Finding, Options, Rows
from tutorial_lib.experiments.common.statistics import difference, over_worlds
from tutorial_lib.experiments.protocols.drives import TOUR, part_of
from tutorial_lib.experiments.protocols.lifelong import (
    TrueModel,
    deep_experiences,
    image_poses,
    run_queries,
)
from tutorial_lib.experiments.protocols.navigation import (
    attempt,
    experiences,
    measured,
    navigate,
    sizes_of,
    vertex_poses,
)
from tutorial_lib.experiments.protocols.navigation_tasks import (
    Building,
    Trials,
    draw_trials,
    make_building,
)
from tutorial_lib.experiments.protocols.thresholds import CHOSEN
from tutorial_lib.geometry import Array
from tutorial_lib.parallel import for_each
from tutorial_lib.topology.maintenance import MaintenanceRules
from tutorial_lib.topology.mapping.edge_rules import MapSettings
from tutorial_lib.topology.mapping.sampling_map import SamplingRules

NETWORK, ORACLE = PERCEPTIONS = ("network", "oracle")
WORLDS = tuple(range(20_000, 20_008))
"""Three of them are loop corridors, where places look alike."""
MAP = MapSettings(p_edge=CHOSEN[TOUR].p_edge)
"""Of Meng's map, for one tour."""
MENDING, FROZEN = "ltvn", "frozen"
MENDING_MENG, FROZEN_MENG, MENG = "meng_mending", "meng_frozen", "meng"
VARIANTS: dict[str, dict[str, Any]] = {
    MENDING: {},
    FROZEN: {"maintenance": None},
    "lenient": {"travel": TravelSettings(strict=False)},
    "no_trust": {"travel": TravelSettings(trust=False)},
    "own_blame": {"maintenance": MaintenanceRules(share_blame=False)},
    "no_return": {"maintenance": MaintenanceRules(returns=0, returns_blocked=0)},
    "no_expansion": {"maintenance": MaintenanceRules(expand=False)},
    "no_reverse": {"reverse": False},
}
"""LTVN's agent; one whose map stays as it was built; and ablations, of which "lenient" is the
paper's test of success."""


@dataclass(frozen=True)
class Settings:
    """Settings of the experiment.

    Attributes:
        agents: that are compared, each with its perception and the number of its queries in each
            building: the first of those that all are drawn from.
        block: queries of one row.
        fleet: robots that set off together.
    """

    agents: tuple[tuple[str, str, int], ...] = (
        *((MENDING, NETWORK, 500), (FROZEN, NETWORK, 200)),
        *((MENDING, ORACLE, 50), (FROZEN, ORACLE, 50)),
        *(("ving", NETWORK, 50), ("sptm", NETWORK, 50), (MENG, NETWORK, 50)),
        ("oracle", ORACLE, 50),
    )
    block: int = 50
    fleet: int = 25

    @property
    def queries(self) -> int:
        """That are drawn in each building."""
        return max(count for _, _, count in self.agents)


@dataclass(frozen=True, eq=False)
class Lived:
    """What one agent did in one building.

    Attributes:
        success: (Q,) of each query.
        sizes: vertices, edges and wormholes of the map after each block; None where there is none.
    """

    success: Array
    sizes: list[tuple[int, int, int]] | None = None


def run(options: Options, settings: Settings) -> tuple[Rows, list[Finding]]:
    """Let every agent live in every building."""
    items = [(world, *agent) for world in options.worlds for agent in settings.agents]
    lives = for_each(lived, items, options.seed, settings, label="ltvn_lifelong")
    found: dict[tuple[str, str], dict[int, Lived]] = {agent[:2]: {} for agent in settings.agents}
    for (world, name, perception, _), life in zip(items, lives, strict=True):
        found[name, perception][world] = life
    rows: Rows = []
    for (name, perception), by_world in found.items():
        for family, worlds in families(options.worlds).items():
            parts = [by_world[world] for world in worlds]
            key = {"agent": name, "perception": perception, "family": family}
            rows += _rows(key, parts, worlds, settings)
    return rows, _differences(found, options, settings)


def families(worlds: tuple[int, ...]) -> dict[str, list[int]]:
    """The worlds by whether they are loop corridors, as Table II's are by their seeds."""
    loops = [world for world in worlds if world % 3 == 2]
    others = [world for world in worlds if world % 3 != 2]
    return {name: some for name, some in (("others", others), ("loop_corridor", loops)) if some}


def lived(item: tuple[int, str, str, int], seed: int, settings: Settings) -> Lived:
    """One agent in one building."""
    world, name, perception, count = item
    whole, building, trials = drawn(world, seed, settings.queries)
    trials = trials.subset(np.arange(count))
    if name in VARIANTS:
        agent = prepared_agent(building, name, perception)
        return mended(building, trials, agent, settings)
    if name == "ving":
        agent = agents.ving()
        agent.learn(deep_experiences(building))
        return mended(building, trials, agent, settings)
    if name in (MENDING_MENG, FROZEN_MENG):
        return _in_fleets(building, trials, settings, mends=name == MENDING_MENG)
    if name == "oracle":
        goals = trials.goal_poses
        outcome = navigate(building, trials, lambda sim: OracleNavigation(sim, whole.paths, goals))
        return Lived(outcome.success.astype(float))
    shortcut = CHOSEN[TOUR].s_shortcut
    made = agents.sptm(s_shortcut=shortcut) if name == "sptm" else agents.meng(settings=MAP)
    result = attempt(building, trials, made)
    sizes = [result.size] * (len(trials) // settings.block) if result.size else None
    return Lived(result.outcome.success.astype(float), sizes)


@lru_cache(maxsize=1)
def drawn(world: int, seed: int, queries: int) -> tuple[Building, Building, Trials]:
    """A building, the same with the drives that are learned, and its queries.

    All are kept for the next call, since agents take turns in one building.

    Raises:
        InputError: when there is no room for so many queries.
    """
    whole = make_building(world, seed)
    trials = draw_trials(whole, queries, np.random.default_rng([seed, world, 1]))
    if len(trials) < queries:
        raise InputError(f"queries: world {world} has room for {len(trials)}; ask for no more")
    return whole, part_of(whole, TOUR, seed), trials


def _in_fleets(building: Building, trials: Trials, settings: Settings, *, mends: bool) -> Lived:
    """Meng's map in fleets as LTVN's, kept up to date or not.

    A robot's odometry drifts by its number in the fleet, so that both have fleets.
    """
    agent = learned_meng(building, mends=mends)
    success, sizes = [], []
    for first in range(0, len(trials), settings.fleet):
        some = trials.subset(np.arange(first, min(first + settings.fleet, len(trials))))
        if isinstance(agent, MendingMengAgent):
            agent.upkeep.begin(first)
        success.append(measured(building, some, agent).outcome.success.astype(float))
        if (first + len(some)) % settings.block == 0:
            kept = agent.upkeep if isinstance(agent, MendingMengAgent) else agent.topomap
            sizes.append(sizes_of(building, kept.graph, vertex_poses(building, agent.topomap)))
    return Lived(np.concatenate(success), sizes)


def learned_meng(building: Building, *, mends: bool = False) -> MengAgent:
    """Meng's agent that has learned a building, with upkeep or with a map that stays as it is."""
    agent = (agents.mending if mends else agents.meng)(settings=MAP)
    agent.learn(list(experiences(building)))
    return agent


def prepared_agent(building: Building, name: str, perception: str) -> LTVNAgent:
    """A variant of LTVN's agent that has learned a building."""
    changed = dict(VARIANTS[name])
    reverse = changed.pop("reverse", True)
    return _mapped(building, perception, reverse).twin(**changed)


@lru_cache(maxsize=2)
def _mapped(building: Building, perception: str, reverse: bool) -> LTVNAgent:
    """LTVN's agent that has learned a building; kept for the variants that share its map."""
    model = TrueModel(building.scene) if perception == ORACLE else None
    rules = SamplingRules() if model is None else SamplingRules(support=0.0)
    if not reverse:
        rules = replace(rules, reverse=None)
    agent = agents.ltvn(model=model, rules=rules)
    agent.learn(deep_experiences(building, model))
    return agent


def mended(
    building: Building,
    trials: Trials,
    agent: LTVNAgent,
    settings: Settings,
) -> Lived:
    """Run all queries, block by block."""
    success, sizes = [], []
    for first in range(0, len(trials), settings.block):
        some = trials.subset(np.arange(first, min(first + settings.block, len(trials))))
        outcome, _ = run_queries(building, some, agent, settings.fleet, first)
        success.append(outcome.success.astype(float))
        sizes.append(sizes_of(building, agent.sampled.graph, image_poses(building, agent)))
    return Lived(np.concatenate(success), sizes)


def _rows(key: dict[str, Any], parts: list[Lived], worlds: list[int], settings: Settings) -> Rows:
    rows: Rows = []
    for block, first in enumerate(range(0, len(parts[0].success), settings.block)):
        some = slice(first, first + settings.block)
        values = [part.success[some] for part in parts]
        units = np.repeat(worlds, [len(value) for value in values])
        success, low, high = over_worlds(np.concatenate(values), units)
        row = key | {"block": block, "worlds": len(worlds), "queries": len(units)}
        row |= {"success": success, "low": low, "high": high}
        for number, name in enumerate(("vertices", "edges", "wormholes")):
            sizes = [part.sizes[block][number] for part in parts if part.sizes]
            row[name] = float(np.mean(sizes)) if sizes else None
        rows.append(row)
    return rows


def _differences(
    found: dict[tuple[str, str], dict[int, Lived]], options: Options, settings: Settings
) -> list[Finding]:
    """Paired: of LTVN's agent from the others, and of Meng's mended map from Meng's."""
    pairs = [((MENDING, other[1]), other) for other in found if other[0] != MENDING]
    pairs.append(((MENDING_MENG, NETWORK), (FROZEN_MENG, NETWORK)))
    differences = []
    for family, worlds in families(options.worlds).items():
        for one, other in pairs:
            if not {one, other} <= set(found):
                continue
            mine, theirs = ([found[agent][w].success for w in worlds] for agent in (one, other))
            count = min(map(len, mine + theirs))
            block = min(settings.block, count)
            for first, last in dict.fromkeys(((0, block), (count - block, count), (0, count))):
                gap = difference(
                    np.concatenate([success[first:last] for success in mine]),
                    np.concatenate([success[first:last] for success in theirs]),
                    np.repeat(worlds, last - first),
                )
                what = f"{family}, queries {first + 1} to {last}, {other[1]}: {one[0]} - {other[0]}"
                differences.append(Finding(what, *gap))
    return differences


def _ablation(name: str, compared: Iterable[str], count: int) -> Experiment:
    """Agents with the networks, each with so many queries."""

    def of(queries: int, **more: int) -> Settings:
        return Settings(tuple((agent, NETWORK, queries) for agent in compared), **more)

    return Experiment(
        f"ltvn_lifelong_{name}",
        run,
        WORLDS,
        WORLDS[:2],
        settings=of(count),
        quick_settings=of(100, block=20, fleet=20),
        canary=of(2, block=2, fleet=2),
    )


QUICK = Settings(
    (
        *((name, perception, 100) for perception in PERCEPTIONS for name in (MENDING, FROZEN)),
        (MENG, NETWORK, 40),
    ),
    block=20,
    fleet=20,
)
EXPERIMENT = Experiment(
    "ltvn_lifelong",
    run,
    WORLDS,
    WORLDS[:2],
    settings=Settings(),
    quick_settings=QUICK,
    canary=Settings(
        tuple((name, NETWORK, 2) for name in (MENDING, FROZEN, MENG, "ving", "sptm")),
        block=2,
        fleet=2,
    ),
    ablations={
        "parts": _ablation("parts", VARIANTS, 100),
        "meng": _ablation("meng", (MENDING_MENG, FROZEN_MENG), 500),
    },
)
