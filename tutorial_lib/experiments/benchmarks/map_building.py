"""What a map costs as it grows: seconds per trajectory and plan, indexed or exhaustive."""

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import NUMBER, Finding, Options, Rows
from tutorial_lib.experiments.protocols.navigation import K, experiences, goals_of
from tutorial_lib.experiments.protocols.navigation_tasks import (
    PLACES,
    Building,
    draw_trials,
    make_building,
)
from tutorial_lib.interfaces import Goals, Observation
from tutorial_lib.learning.views import VIEWS
from tutorial_lib.topology.mapping.anchors import Anchors
from tutorial_lib.topology.mapping.edge_rules import MapSettings
from tutorial_lib.topology.mapping.insertion import Insertion, add_trajectory
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.topology.planner import DijkstraPlanner
from tutorial_lib.world.simulation import Simulation

_EVERY_VERTEX = 10**9
_TIMED = 4  # trajectories that are timed at each size
_PLANS = 12
_NO_REUSE = MapSettings(p_reuse=1.0)


@dataclass(frozen=True)
class Settings:
    """Settings of the benchmark.

    Attributes:
        places: of the one building.
        sizes: numbers of vertices at which the growing map is measured.
    """

    places: int = PLACES
    sizes: tuple[int, ...] = (100, 300, 1_000, 3_000, 10_000)


def run(options: Options, settings: Settings) -> tuple[Rows, list[str | Finding]]:
    """Build one building's map both ways; then grow a map without reuse over many worlds."""
    first = options.worlds[0]
    building = make_building(first, options.seed, settings.places)
    begun = time.perf_counter()
    anchors = list(sparsified(building))
    sparsifying = time.perf_counter() - begun
    rows: Rows = []
    notes: list[str | Finding] = []
    for name, reuse in (("one building", MapSettings()), ("one building, no reuse", _NO_REUSE)):
        more = building_map(building, anchors, sparsifying, reuse, name)
        rows, notes = rows + more[0], notes + more[1]
    return rows + growing_map(first, options.seed, settings.sizes), notes


def building_map(
    building: Building,
    trajectories: list[Anchors],
    sparsifying: float,
    settings: MapSettings,
    name: str,
) -> tuple[Rows, list[str | Finding]]:
    """The map of one building with the index, and by comparing every pair.

    Args:
        building: whose map is built.
        trajectories: the anchors of each.
        sparsifying: seconds that it took to find them.
        settings: of the map.
        name: of the rows.
    """
    rows, each = [], {}
    for method, candidates in (("indexed", None), ("exhaustive", _EVERY_VERTEX)):
        topomap = TopoMap(agents.meng().reachability, settings)
        times = []
        for anchors in trajectories:
            begun = time.perf_counter()
            Insertion(topomap, anchors, candidates).insert()
            times.append(time.perf_counter() - begun)
        each[method] = np.array(times)
        rows.append(
            {
                "method": method,
                "map": name,
                "vertices": len(topomap),
                "trajectories": len(trajectories),
                "seconds_per_trajectory": float(np.mean(times[-5:])),
                "queries": topomap.vertices.queries,
                "recall": 1.0,
                "plan_ms": planned(building, topomap, candidates),
            }
        )
    rows[0]["recall"] = recall(trajectories, settings)
    frames = len(building.recorded.poses)
    total = sparsifying + each["indexed"].sum()
    notes: list[str | Finding] = [
        f"{name}: {frames:,} frames mapped in {total:.0f} s, of which sparsifying "
        f"{sparsifying:.0f} s",
        f"{name}, indexed: {rows[0]['queries'] / rows[1]['queries']:.1%} of the queries, "
        f"{rows[0]['recall']:.2%} of the edges that were not driven",
    ]
    if len(trajectories) >= 90:
        late, early = (each["indexed"][at - 3 : at + 2].mean() for at in (88, 10))
        notes.append(Finding(f"{name}: 90th to 10th trajectory", float(late / early), form=NUMBER))
    return rows, notes


def recall(trajectories: list[Anchors], settings: MapSettings) -> float:
    """The share of the edges above `p_edge` that the index finds; not a number if there are none.

    Each trajectory is compared with the same map both ways, that of the index, so that what one
    trajectory lacks is not counted again in all that follow. Edges that were driven need no search
    and do not count, nor do those of anchors that were replaced.
    """
    topomap, found, wanted = TopoMap(agents.meng().reachability, settings), 0, 0
    for anchors in trajectories:
        indexed, whole = Insertion(topomap, anchors), Insertion(topomap, anchors, _EVERY_VERTEX)
        reused = indexed.insert().reused
        above = [np.stack(one.scores()) > settings.p_edge for one in (indexed, whole)]
        ends = np.ones(above[0].shape[2], dtype=bool)  # of (2, A, V + A)
        ends[-len(anchors) :] = ~reused
        theirs, all_of_them = (table[:, ~reused][:, :, ends] for table in above)
        found += int((theirs & all_of_them).sum())
        wanted += int(all_of_them.sum())
    return found / wanted if wanted else float("nan")


def growing_map(first: int, seed: int, sizes: tuple[int, ...]) -> Rows:
    """Times at several sizes of a map without reuse, from the `first` world on."""
    rows: Rows = []
    due = list(sizes)
    topomap = TopoMap(agents.meng().reachability, _NO_REUSE)
    world = first
    while due:
        building = make_building(world, seed, PLACES)
        trajectories = sparsified(building)
        for anchors in trajectories:
            add_trajectory(topomap, anchors)
            if len(topomap) < due[0]:
                continue
            due.pop(0)
            timed = [anchors for anchors, _ in zip(trajectories, range(_TIMED), strict=False)]
            whole = exhaustively(topomap, timed[-1])
            before, begun = topomap.vertices.queries, time.perf_counter()
            for other in timed:
                add_trajectory(topomap, other)
            seconds = (time.perf_counter() - begun) / len(timed)
            queries = (topomap.vertices.queries - before) / len(timed)
            plan = planned(building, topomap, None)
            rows.append(_row("indexed", topomap, seconds, queries, plan))
            plan = planned(building, topomap, _EVERY_VERTEX)
            rows.append(_row("exhaustive", topomap, *whole, plan))
            if not due:
                break
        world += 1
    return rows


def exhaustively(topomap: TopoMap, anchors: Anchors) -> tuple[float, int]:
    """Seconds and queries of comparing a trajectory with every vertex; the map stays as it is."""
    queries, begun = topomap.vertices.queries, time.perf_counter()
    Insertion(topomap, anchors, _EVERY_VERTEX)
    return time.perf_counter() - begun, topomap.vertices.queries - queries


def sparsified(building: Building) -> Iterator[Anchors]:
    """The anchors of one recorded trajectory after the other."""
    agent = agents.meng()
    for experience in experiences(building):
        yield agent.sparsified(experience)


def planned(building: Building, topomap: TopoMap, candidates: int | None) -> float:
    """Milliseconds of a plan, including its queries of the network."""
    trials = draw_trials(building, _PLANS, np.random.default_rng(0))
    observations = Simulation(building.scene, trials.starts).observe()
    goals = goals_of(trials, VIEWS["camera16"], K)
    planner = DijkstraPlanner()
    planner = planner if candidates is None else replace(planner, candidates=candidates)
    times = [timed_plan(planner, observations[[i]], goals[i], topomap) for i in range(len(goals))]
    return 1000 * float(np.median(times))


def timed_plan(
    planner: DijkstraPlanner, observation: Observation, goals: Goals, topomap: TopoMap
) -> float:
    """Seconds of one plan."""
    begun = time.perf_counter()
    planner.plan(observation, goals, topomap)
    return time.perf_counter() - begun


def _row(
    method: str, topomap: TopoMap, seconds: float, queries: float, plan: float
) -> dict[str, Any]:
    return {
        "method": method,
        "map": "many buildings, no reuse",
        "vertices": len(topomap),
        "trajectories": len(topomap.paths),
        "seconds_per_trajectory": float(seconds),
        "queries": round(queries),
        "recall": None,
        "plan_ms": plan,
    }


EXPERIMENT = Experiment(
    "map",
    run,
    (20_000,),
    settings=Settings(),
    quick_settings=Settings(places=5, sizes=(100, 300)),
)
