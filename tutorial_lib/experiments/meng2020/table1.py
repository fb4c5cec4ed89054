"""Table I of Meng 2020: how often each local controller reaches a target near a trajectory."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.control.composed import ComposedController, RandomWaypoints, TargetPolicy
from tutorial_lib.driving.control.oracle import OraclePolicy
from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.rollout_outcomes import PolicyFactory
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.own import CUSTOM, load_own, or_fault
from tutorial_lib.experiments.common.report import Fault, Finding, Notes, Options, Rows
from tutorial_lib.experiments.common.statistics import difference, over_worlds
from tutorial_lib.experiments.meng2020 import table1_smoothing
from tutorial_lib.experiments.protocols.local_control import (
    WORLDS,
    attempt,
    conditions,
    seeds_of,
)
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Policy
from tutorial_lib.learning.estimators import DirectNetwork, WaypointNetwork
from tutorial_lib.learning.policies import by_smoothed_waypoints, directly
from tutorial_lib.parallel import for_each
from tutorial_lib.world.simulation import Simulation

PAPER = {"direct": 0.46, "k0": 0.88, "k2": 0.91, "k5": 0.95}
"""Table I of the paper, without disturbances. Its direct control has k = 0, ours k = 2."""
_BREAKDOWN = {
    "behind": ("ahead", -1.1, 0.0),
    "to_1m": ("ahead", 0.0, 1.0),
    "to_2m": ("ahead", 1.0, 2.0),
    "to_3m": ("ahead", 2.0, 3.1),
    "not_before_it": ("bearing", np.pi / 3, np.pi + 1e-9),
    "little_overlap": ("overlap", 0.0, 0.1),
    "tight": ("clearance", 0.0, 0.3),
}
"""Subsets of the episodes with a column each: the measure, and its least and greatest value."""

Results = dict[tuple[str, str], dict[str, Array]]
"""For each (controller, condition), columns over all episodes."""
SEAMS = ("predictor", "local controller", "controller")
"""What a class of one's own may be in Table I."""


@dataclass(frozen=True)
class Settings:
    """Settings of Table I.

    Attributes:
        episodes: in each generated world.
        map_episodes: in the world of a map's file.
        controllers: by the names of their rows; all of them if None.
    """

    episodes: int = 100
    map_episodes: int = 200
    controllers: tuple[str, ...] | None = None


def run(options: Options, settings: Settings) -> tuple[Rows, Notes]:
    """Run all controllers on the same episodes.

    With `options.map` the only world is that file's, and there is no shifted palette.
    """
    places: list[int | Path] = [*options.worlds]
    if options.map is not None:
        places = [options.map]
        settings = replace(settings, episodes=settings.map_episodes)
    if options.agent:  # a faulty one is refused before any rollout
        custom(options.agent)
    parts = for_each(run_world, places, options, settings, label="meng_table1")
    faults = [fault for _, fault in parts if fault]
    results = _joined([found for found, _ in parts])
    if faults:
        results = {key: found for key, found in results.items() if key[0] != CUSTOM}
    return [_row(results, *key) for key in results], (*_differences(results), *faults[:1])


def run_world(
    place: int | Path, options: Options, settings: Settings
) -> tuple[Results, Fault | None]:
    """Run every controller under every condition in one world; also how the user's own failed.

    Args:
        place: seed of a generated world, or a map's file.
        options: have the seed of trajectories, episodes and noise, and the family.
        settings: the controllers, and how many episodes.
    """
    found: Results = {}
    known = controllers(seeds_of(place, options.seed))
    names = known if settings.controllers is None else settings.controllers
    factories, fault = {name: known[name] for name in names}, None
    for name, condition in conditions(place, settings.episodes, options).items():
        if options.agent and fault is None:
            own = or_fault(options.agent, lambda c: attempt(c, custom(options.agent)), condition)
            if isinstance(own, Fault):
                fault = own
            else:
                found[CUSTOM, name] = own
        for controller, factory in factories.items():
            found[controller, name] = attempt(condition, factory)
    return found, fault


def _joined(parts: list[Results]) -> Results:
    """All worlds one after the other, with the number of each episode's world."""
    joined: Results = {}
    for key in dict.fromkeys(key for part in parts for key in part):
        found = {number: part[key] for number, part in enumerate(parts) if key in part}
        names = next(iter(found.values()))
        columns = {name: np.concatenate([part[name] for part in found.values()]) for name in names}
        sizes = [len(part["reached"]) for part in found.values()]
        joined[key] = columns | {"world": np.repeat(list(found), sizes)}
    return joined


def _row(results: Results, controller: str, condition: str) -> dict[str, Any]:
    found = results[controller, condition]
    reached = found["reached"]
    success, low, high = over_worlds(reached, found["world"])
    row: dict[str, Any] = {
        "controller": controller,
        "condition": condition,
        "episodes": len(reached),
        "success": success,
        "low": low,
        "high": high,
        "paper": PAPER.get(controller) if condition == "clean" else None,
        "collided": found["collided"].mean(),
        "success_or_overlap": found["matched"].mean(),
    }
    for part, (what, least, most) in _BREAKDOWN.items():
        inside = (found[what] >= least) & (found[what] < most)
        row[f"success_{part}"] = reached[inside].mean() if inside.any() else None
    return row


def _differences(results: Results) -> list[Finding]:
    """Paired, in points."""
    pairs = {
        "oracle - k5, clean": (("oracle", "clean"), ("k5", "clean")),
        "oracle - laser, clean": (("oracle", "clean"), ("laser", "clean")),
        "k5 - custom, clean": (("k5", "clean"), (CUSTOM, "clean")),
        "k5 - k0, clean": (("k5", "clean"), ("k0", "clean")),
        "k5: clean - noise": (("k5", "clean"), ("k5", "noise")),
        "k5: clean - shifted": (("k5", "clean"), ("k5", "shifted")),
    }
    found = []
    for what, (first, second) in pairs.items():
        if first in results and second in results:
            one, other = results[first], results[second]
            gap = difference(one["reached"], other["reached"], one["world"])
            found.append(Finding(what, *gap))
    return found


def custom(where: str) -> PolicyFactory:
    """C with a component of the user's own, from "FILE.py:CLASS", beside what `k5` has.

    A waypoint predictor is followed as the other predictors are, a controller drives to the
    waypoints of k = 5, and a local controller drives by itself.

    Raises:
        InputError: as `load_own` does.
    """
    seam, part = load_own(where, SEAMS)
    if seam == "local controller":
        return directly(part)
    if seam == "predictor":
        return by_smoothed_waypoints(part)
    return by_smoothed_waypoints(WaypointNetwork("waypoint_k5"), controller=part)


def controllers(seed: tuple[int, int]) -> dict[str, PolicyFactory]:
    """The rows of Table I by name, bracketed by a random one and an oracle.

    C smooths its waypoints (not in the paper); `--ablation smoothing` compares it with C that does
    not. `seed` is that of the random one.
    """
    rmp = RMPController()

    def at_random(
        simulation: Simulation, recorded: RecordedWorld, frames: NDArray[np.intp]
    ) -> Policy:
        del simulation, recorded
        predictor = RandomWaypoints(np.random.default_rng(seed))
        return TargetPolicy(ComposedController(predictor, rmp), frames)

    def oracle(simulation: Simulation, recorded: RecordedWorld, frames: NDArray[np.intp]) -> Policy:
        paths = GridPaths(recorded.scene.clearance)
        return OraclePolicy(simulation, paths, recorded.poses[frames, :2], rmp)

    return {
        "random": at_random,
        "direct": directly(DirectNetwork("direct_k2")),
        "k0": by_smoothed_waypoints(WaypointNetwork("waypoint_k0")),
        "k2": by_smoothed_waypoints(WaypointNetwork("waypoint_k2")),
        "k5": by_smoothed_waypoints(WaypointNetwork("waypoint_k5")),
        "laser": by_smoothed_waypoints(WaypointNetwork("laser_k2")),
        "oracle": oracle,
    }


EXPERIMENT = Experiment(
    "meng_table1",
    run,
    WORLDS,
    WORLDS[:10],
    Settings(),
    quick_settings=Settings(episodes=40, map_episodes=40),
    canary=Settings(episodes=3, map_episodes=3),
    accepts=frozenset({"map", "family", "agent"}),
    ablations={"smoothing": table1_smoothing.EXPERIMENT},
)
