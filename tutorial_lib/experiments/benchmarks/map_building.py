"""What a map costs as it grows: seconds for each trajectory and plan, asked by index or of all."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.report import Options, Report
from tutorial_lib.experiments.protocols.navigation import K, experiences, goals_of
from tutorial_lib.experiments.protocols.navigation_tasks import PLACES, Building, building, trials
from tutorial_lib.interfaces import Goals, Observation
from tutorial_lib.learning.estimators import use_threads
from tutorial_lib.learning.views import VIEWS
from tutorial_lib.topology.mapping.anchors import Anchors, anchors_of
from tutorial_lib.topology.mapping.edge_rules import MapSettings
from tutorial_lib.topology.mapping.insertion import Insertion, add_trajectory
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.topology.planner import DijkstraPlanner
from tutorial_lib.world.simulation import Simulation

WORLD = 20_000
SIZES, QUICK_SIZES = (100, 300, 1_000, 3_000, 10_000), (100, 300)
_EVERYONE = 10**9
_SOME = 4  # trajectories that are timed at each size
_PLANS = 12


def run(options: Options) -> Report:
    """Build one building's map both ways; then let a map without reuse grow over many worlds."""
    begun = time.perf_counter()
    use_threads(1)  # a few pictures at a time are too little work to be shared
    first = (options.worlds or (WORLD,))[0]
    house = building(first, options.seed, 5 if options.quick else PLACES)
    started = time.perf_counter()
    anchors = list(sparsified(house))
    drives = anchors, time.perf_counter() - started
    rows, notes = building_map(house, *drives, MapSettings(), "one building")
    more = building_map(house, *drives, MapSettings(p_reuse=1.0), "one building, no reuse")
    rows, notes = rows + more[0] + growing_map(first, options), notes + more[1]
    took = time.perf_counter() - begun
    return Report("map", options.seed, (first,), options.quick, took, rows, tuple(notes))


def building_map(
    house: Building, drives: list[Anchors], sparsifying: float, settings: MapSettings, name: str
) -> tuple[list[dict[str, Any]], list[str]]:
    """The map of one building by index, and by asking about every pair.

    Args:
        house: the building.
        drives: the anchors of each of its drives.
        sparsifying: seconds that it took to find them.
        settings: of the map.
        name: of the rows.
    """
    rows, edges, each = [], {}, {}
    for method, candidates in (("indexed", None), ("exhaustive", _EVERYONE)):
        topomap = TopoMap(agents.meng().reachability, settings)
        times = []
        for anchors in drives:
            begun = time.perf_counter()
            Insertion(topomap, anchors, candidates).insert()
            times.append(time.perf_counter() - begun)
        edges[method], each[method] = set(topomap.graph.edges), np.array(times)
        rows.append(
            {
                "method": method,
                "map": name,
                "vertices": len(topomap),
                "trajectories": len(drives),
                "seconds_per_trajectory": float(np.mean(times[-5:])),
                "queries": topomap.vertices.queries,
                "recall": 1.0,
                "plan_ms": planned(house, topomap, candidates),
            }
        )
    rows[0]["recall"] = len(edges["indexed"] & edges["exhaustive"]) / len(edges["exhaustive"])
    frames = len(house.recorded.poses)
    total = sparsifying + each["indexed"].sum()
    notes = [
        f"{name}: {frames:,} frames mapped in {total:.0f} s, of which sparsifying "
        f"{sparsifying:.0f} s",
        f"{name}, indexed: {rows[0]['queries'] / rows[1]['queries']:.1%} of the queries, "
        f"{rows[0]['recall']:.2%} of the edges",
    ]
    if len(drives) >= 90:
        late, early = (each["indexed"][at - 3 : at + 2].mean() for at in (88, 10))
        notes.append(f"{name}: the 90th trajectory takes {late / early:.2f} times the 10th's time")
    return rows, notes


def growing_map(first: int, options: Options) -> list[dict[str, Any]]:
    """Times at several sizes of a map without reuse, over one world after the other."""
    rows: list[dict[str, Any]] = []
    sizes = list(QUICK_SIZES if options.quick else SIZES)
    topomap = TopoMap(agents.meng().reachability, MapSettings(p_reuse=1.0))
    world = first
    while sizes:
        house = building(world, options.seed, PLACES)
        drives = sparsified(house)
        for anchors in drives:
            add_trajectory(topomap, anchors)
            if len(topomap) < sizes[0]:
                continue
            sizes.pop(0)
            some = [anchors for anchors, _ in zip(drives, range(_SOME), strict=False)]
            whole = exhaustively(topomap, some[-1])
            queries, begun = topomap.vertices.queries, time.perf_counter()
            for other in some:
                add_trajectory(topomap, other)
            seconds = (time.perf_counter() - begun) / len(some)
            asked = (topomap.vertices.queries - queries) / len(some)
            rows.append(_row("indexed", topomap, seconds, asked, planned(house, topomap, None)))
            rows.append(_row("exhaustive", topomap, *whole, planned(house, topomap, _EVERYONE)))
            if not sizes:
                break
        world += 1
    return rows


def exhaustively(topomap: TopoMap, anchors: Anchors) -> tuple[float, int]:
    """Seconds and queries of comparing a trajectory with every vertex; the map stays as it is."""
    queries, begun = topomap.vertices.queries, time.perf_counter()
    Insertion(topomap, anchors, _EVERYONE)
    return time.perf_counter() - begun, topomap.vertices.queries - queries


def sparsified(house: Building) -> Iterator[Anchors]:
    """The anchors of one recorded drive after the other."""
    agent = agents.meng()
    for experience in experiences(house):
        seen = experience.observations
        pictures = agent.predictor.view.of(seen)
        yield anchors_of(
            agent.reachability, seen, pictures, K, agent.p_sparsify, experience.timestamps
        )


def planned(house: Building, topomap: TopoMap, candidates: int | None) -> float:
    """Milliseconds of a plan, its questions to the network included."""
    asked = trials(house, _PLANS, np.random.default_rng(0))
    seen = Simulation(house.scene, asked.starts).observe()
    goals = goals_of(asked, VIEWS["camera16"], K)
    planner = DijkstraPlanner()
    planner = planner if candidates is None else replace(planner, candidates=candidates)
    times = [timed_plan(planner, seen[[i]], goals[i], topomap) for i in range(len(goals))]
    return 1000 * float(np.median(times))


def timed_plan(
    planner: DijkstraPlanner, seen: Observation, goals: Goals, topomap: TopoMap
) -> float:
    """Seconds of one plan."""
    begun = time.perf_counter()
    planner.plan(seen, goals, topomap)
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
