"""Table II of Meng 2020: success of navigation from place to place, and size of the maps.

With every drive recorded, as in the paper, nearly every trial is *driven*: some drive passes its
start and later its goal, and an agent that only repeats drives succeeds. With `--drives` agents
learn a part of them; what was not driven must be *composed* of several.
"""

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.oracle import OracleNavigation
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.experiment import OPTIONAL, Experiment
from tutorial_lib.experiments.common.own import CUSTOM, load_robot, or_fault
from tutorial_lib.experiments.common.report import SHARE, Fault, Finding, Notes, Options, Rows
from tutorial_lib.experiments.common.statistics import difference, over_worlds, wilson
from tutorial_lib.experiments.meng2020 import table2_goal_images, table2_thresholds
from tutorial_lib.experiments.protocols.drives import (
    CONTINUOUS,
    TOUR,
    driven_trials,
    part_of,
    passed_goals,
)
from tutorial_lib.experiments.protocols.navigation import (
    ENDINGS,
    ONE,
    Result,
    attempt,
    navigate,
    total_size,
)
from tutorial_lib.experiments.protocols.navigation_tasks import (
    CAR,
    PLACES,
    WORLDS,
    Building,
    Trials,
    make_building,
)
from tutorial_lib.experiments.protocols.thresholds import CHOSEN, Thresholds
from tutorial_lib.experiments.protocols.trial_choices import chosen_trials
from tutorial_lib.parallel import for_each, lines_of_progress
from tutorial_lib.topology.mapping.edge_rules import MapSettings
from tutorial_lib.world.sensors import Camera

EVERY, COMPOSED = "all worlds", "composed"
"""Which trials a note is about."""
QUICK_DRIVES = "0.2"
"""Share that is learned in a quick run with a class of one's own; with all, every agent arrives."""
PAPER = {"meng": (0.846, 0.957), "sptm": (0.402, 0.513)}
"""Success in the least and the most successful of the paper's five worlds."""
METHODS = ("meng", "sptm", "random", "oracle")
"""In the order of the rows."""


@dataclass(frozen=True)
class Settings:
    """Settings of Table II.

    Attributes:
        places: of a building; each ordered pair is joined by a recorded trajectory.
        places_on_map: the same on a map's file, of which there is only one.
        trials: in each building.
        trials_of_part: in each building, where a part of the drives is learned.
        thresholds: by `--drives`, chosen on validation worlds; the usual ones for others.
        methods: of `METHODS`, beside the user's own.
    """

    places: int = PLACES
    places_on_map: int = PLACES
    trials: int = 200
    trials_of_part: int = 60
    thresholds: Mapping[str, Thresholds] = field(default_factory=lambda: CHOSEN)
    methods: tuple[str, ...] = METHODS


@dataclass(frozen=True, eq=False)
class InWorld:
    """What came out in one world.

    Attributes:
        columns: that describe the world.
        results: by method.
        fault: how the user's own agent failed, if it did.
        driven: (N,) which trials some drive that was learned covers.
        passed: (N,) which goals some drive that was learned passes, facing as they do.
    """

    columns: dict[str, Any]
    results: dict[str, Result]
    fault: Fault | None
    driven: NDArray[np.bool_]
    passed: NDArray[np.bool_]


def run(options: Options, settings: Settings) -> tuple[Rows, Notes]:
    """Let every agent learn every world, and run the same trials with each."""
    if options.agent and options.quick and not options.drives:
        options = replace(options, drives=QUICK_DRIVES)
    places: list[int | Path] = [*options.worlds] if options.map is None else [options.map]
    # What is faulty or missing is refused before any rollout.
    camera = load_robot(options.robot)[1] if options.robot else None
    if camera is not None:
        agents.check_trained(camera)
    if options.agent:
        agents.custom(options.agent, camera)
    if len(places) > 1:
        parts = for_each(run_world, places, options, settings, label="meng_table2")
    else:  # the agents share the cores instead; a class of the user's stays in this process
        each = _in_turn if options.robot else for_each
        parts = [_together(place, options, settings, each) for place in places]
    rows = [
        _row(place, options, part, method)
        for place, part in zip(places, parts, strict=True)
        for method in part.results
    ]
    faults = [part.fault for part in parts if part.fault is not None]
    return rows, [*_notes(parts, options.drives), *faults[:1]]


def run_world(place: int | Path, options: Options, settings: Settings) -> InWorld:
    """All agents in one world, one after the other."""
    return _together(place, options, settings, _in_turn)


def _together(
    place: int | Path,
    options: Options,
    settings: Settings,
    each: Callable[..., list[Any]],
) -> InWorld:
    """All agents in one world, which learn the same drives and run the same trials.

    Args:
        place: seed of a large generated world, or a map's file.
        options: of the run.
        settings: of the run.
        each: runs a method after the other, or on all cores.
    """
    building, whole, trials = task_of(place, options, settings)
    own = (CUSTOM,) if options.agent else ()  # a fault is said soon
    methods = (*own, *settings.methods)
    drives = TOUR if options.drives == CONTINUOUS else options.drives
    limits = settings.thresholds.get(drives, Thresholds())
    given = (
        *(building, whole, trials, limits.p_edge, limits.s_shortcut),
        *(options.agent, options.remedies, options.goal_images or ONE),
    )
    found = each(run_method, methods, *given, label=f"{building.name}, methods")
    plan = building.scene.plan
    columns = {
        "family": plan.family,
        "area": round(plan.area),
        "images": len(building.recorded.poses),
    }
    results = dict(zip(methods, found, strict=True))
    results |= {CUSTOM: results.pop(CUSTOM)} if options.agent else {}
    fault = results.pop(CUSTOM) if isinstance(results.get(CUSTOM), Fault) else None
    part = whole, trials, options.drives, options.seed
    return InWorld(columns, results, fault, driven_trials(*part), passed_goals(*part))


def task_of(
    place: int | Path, options: Options, settings: Settings
) -> tuple[Building, Building, Trials]:
    """One world: with the drives that agents learn, with all of them, and the trials."""
    body, camera = load_robot(options.robot) if options.robot else (CAR, Camera())
    whole = make_building(
        place,
        options.seed,
        settings.places if options.map is None else settings.places_on_map,
        options.palette,
        drifts=options.drifts,
        family=options.family,
        region=options.region,
        body=body,
    )
    whole = replace(whole, camera=camera)
    seeds = [options.seed, place if isinstance(place, int) else 0, 1]
    rng = np.random.default_rng(seeds)
    count = settings.trials_of_part if options.drives else settings.trials
    trials = chosen_trials(whole, count, rng, options.starts, options.goals)
    return part_of(whole, options.drives, options.seed), whole, trials


def _in_turn(work: Callable[..., Any], items: Sequence[Any], *given: Any, label: str) -> list[Any]:  # noqa: ANN401
    """`for_each` without other processes; a terminal has the bar of the worlds already."""
    found = (work(item, *given) for item in items)
    return list(found if sys.stderr.isatty() else lines_of_progress(found, len(items), label))


def _row(place: int | Path, options: Options, part: InWorld, method: str) -> dict[str, Any]:
    found = part.results[method]
    outcome = found.outcome
    success, low, high = wilson(outcome.success.astype(float))
    row: dict[str, Any] = {
        "world": place if isinstance(place, int) else place.name,
        **part.columns,
        "method": method,
        "goal_images": options.goal_images or ONE,
        **dict(zip(("vertices", "edges", "wormholes"), found.size or (None,) * 3, strict=True)),
        "trials": len(outcome.success),
        "success": success,
        "low": low,
        "high": high,
        "wrong_place": float(outcome.wrong.mean()),
    }
    row |= {name: float((outcome.ending == name).mean()) for name in ENDINGS[1:]}
    drives = options.drives
    if not drives:
        return row
    return row | {
        "drives": drives if drives in (TOUR, CONTINUOUS) else float(drives),
        "trials_composed": int((~part.driven).sum()),
        "success_composed": _share(outcome.success[~part.driven]),
        "success_driven": _share(outcome.success[part.driven]),
    }


def _share(success: NDArray[np.bool_]) -> float | None:
    """The share of trials that succeed; None of none."""
    return float(success.mean()) if len(success) else None


def _notes(parts: Sequence[InWorld], drives: str) -> list[str | Finding]:
    """Success in all worlds together, and paired differences; of composed trials apart."""
    world = np.repeat(np.arange(len(parts)), [len(part.driven) for part in parts])
    success = {
        name: np.concatenate([part.results[name].outcome.success for part in parts]).astype(float)
        for name in parts[0].results
        if all(name in part.results for part in parts)
    }
    every = np.ones(len(world), dtype=bool)
    composed = ~np.concatenate([part.driven for part in parts])
    notes: list[str | Finding] = [*_compared(success, world, every, EVERY)]
    if drives and composed.any():
        notes += _compared(success, world, composed, COMPOSED)
        passed = np.concatenate([part.passed for part in parts])[composed].mean()
        notes.append(Finding(f"goals on a learned drive, {COMPOSED}", float(passed), form=SHARE))
    elif not drives:
        driven = float(1 - composed.mean())
        notes.append(Finding("trials on a recorded drive past start and goal", driven, form=SHARE))
        notes.append("these trials hardly test composing drives (--drives)")
    for name in [one for one in ("meng", "sptm") if one in success]:
        _, edges, holes = total_size([part.results[name] for part in parts])
        notes.append(f"{name}: {1 - holes / max(edges, 1):.2%} of {edges} edges are no wormholes")
    return notes


def _compared(
    success: dict[str, Any], world: NDArray[np.intp], kept: NDArray[np.bool_], which: str
) -> list[Finding]:
    """Success of each method in the trials that are `kept`, and Meng's less each other's."""
    found, world = [], world[kept]
    part = "" if which == EVERY else f", {which}"
    for name, values in success.items():
        found.append(Finding(f"{name}, {which}", *over_worlds(values[kept], world), form=SHARE))
    for name in [other for other in success if other != "meng"] if "meng" in success else []:
        gap = difference(success["meng"][kept], success[name][kept], world)
        found.append(Finding(f"meng - {name}{part}", *gap))
    return found


def run_method(
    method: str,
    building: Building,
    whole: Building,
    trials: Trials,
    p_edge: float,
    s_shortcut: float,
    agent: str,
    remedies: str,
    images: str,
) -> Result | Fault:
    """One agent: what it learns of a building, and how its trials end; or how it failed.

    Args:
        method: name of the agent.
        building: with the drives that it learns.
        whole: with all drives; only the oracle sees it.
        trials: to be run.
        p_edge: of Meng's map.
        s_shortcut: of SPTM's.
        agent: FILE.py:CLASS of the custom one.
        remedies: of Meng's, for places that look alike; see `agents.remedies`.
        images: of the goals, one of `GOAL_IMAGES`.
    """
    camera = building.camera
    if method == "oracle":
        return Result(
            navigate(
                building, trials, lambda sim: OracleNavigation(sim, whole.paths, trials.goal_poses)
            )
        )
    if method == CUSTOM:
        return or_fault(
            agent, lambda: attempt(building, trials, agents.custom(agent, camera), images)
        )
    settings = MapSettings(p_edge=p_edge)
    if method == "random":
        made = agents.random_agent(np.random.default_rng([*building.odometry.seed, 1]), camera)
    elif method == "sptm":
        made = agents.sptm(camera, s_shortcut=s_shortcut)
    elif remedies:
        made = agents.remedied(remedies, camera, settings=settings)
    else:
        made = agents.meng(camera, settings=settings)
    return attempt(building, trials, made, images)


EXPERIMENT = Experiment(
    "meng_table2",
    run,
    WORLDS,
    WORLDS[:3],
    Settings(),
    quick_settings=Settings(places=6, trials=40, trials_of_part=20),
    canary=Settings(places=5, trials=6, trials_of_part=6),
    accepts=frozenset(OPTIONAL) - {"body"},
    ablations={
        "thresholds": table2_thresholds.EXPERIMENT,
        "goal_images": table2_goal_images.EXPERIMENT,
    },
)
