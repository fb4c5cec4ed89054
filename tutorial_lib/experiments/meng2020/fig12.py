"""Fig. 12 of Meng 2020: starts that look alike, and what each remedy does for them.

Robots start in rooms that have an exact twin in the same office, and look for a room that has none.
All remedies run the same trials; those that match sequences share a map, and so do the others.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.remedies import REMEDIES, Remedies
from tutorial_lib.agents.remedy_agent import RemedyAgent
from tutorial_lib.agents.remedy_navigation import ENDLESS
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Finding, Options, Rows
from tutorial_lib.experiments.common.statistics import difference, over_worlds
from tutorial_lib.experiments.meng2020 import fig12_localization
from tutorial_lib.experiments.protocols.lookalikes import draw_ambiguous_trials, make_office
from tutorial_lib.experiments.protocols.navigation import (
    ENDINGS,
    ONE,
    K,
    Result,
    experiences,
    goals_of,
    navigate,
    sizes_of,
    total_size,
    vertex_poses,
)
from tutorial_lib.learning.views import VIEWS
from tutorial_lib.parallel import for_each

OFFICES = tuple(range(20_000, 20_010))
"""Test worlds."""


@dataclass(frozen=True)
class Settings:
    """Settings of Fig. 12.

    Attributes:
        trials: in each office.
        remedies: rows of the table, unless `--remedies` names one.
    """

    trials: int = 50
    remedies: tuple[str, ...] = REMEDIES


@dataclass(frozen=True, eq=False)
class Attempt:
    """How the trials of one office ended with some remedies.

    Attributes:
        result: of the trials.
        lost: (N,) which robots said that they were lost.
        circled: (N,) which robots came to some vertex more than `ENDLESS` times.
    """

    result: Result
    lost: NDArray[np.bool_]
    circled: NDArray[np.bool_]


def run(options: Options, settings: Settings) -> tuple[Rows, list[Finding]]:
    """Run the same trials with each choice of remedies, in every office."""
    names = (options.remedies,) if options.remedies else settings.remedies
    parts = for_each(run_world, options.worlds, options, settings, names, label="meng_fig12")
    world = np.repeat(np.arange(len(parts)), [len(part[names[0]].lost) for part in parts])
    rows = [_row(name, [part[name] for part in parts], world) for name in names]
    return rows, _differences(parts, names, world)


def run_world(
    world: int, options: Options, settings: Settings, names: tuple[str, ...]
) -> dict[str, Attempt]:
    """All choices of remedies in one office."""
    office = make_office(world, options.seed, drifts=options.drifts)
    building = office.building
    rng = np.random.default_rng([options.seed, world, 8])
    trials = draw_ambiguous_trials(office, settings.trials, rng)
    goals = goals_of(trials, VIEWS["camera16"], K)
    learned, found = dict[bool, RemedyAgent](), {}
    plain = agents.remedied("none")
    anchors = [plain.sparsified(one) for one in experiences(building)]  # the same for both maps
    for name in names:
        remedies = Remedies.named(name)
        if remedies.sequence not in learned:
            learned[remedies.sequence] = replace(plain, remedies=remedies)
            for one in anchors:
                learned[remedies.sequence].insert(one)
        agent = learned[remedies.sequence].with_remedies(remedies)
        navigation = agent.start(goals)
        outcome = navigate(building, trials, lambda _, started=navigation: started)
        size = sizes_of(building, agent.topomap.graph, vertex_poses(building, agent.topomap))
        circled = navigation.visits.max(axis=1) > ENDLESS
        found[name] = Attempt(Result(outcome, size), navigation.lost, circled)
    return found


def _row(name: str, parts: list[Attempt], world: NDArray[np.intp]) -> dict[str, Any]:
    success, low, high = over_worlds(_success(parts), world)
    vertices, edges, wormholes = total_size([part.result for part in parts])
    row: dict[str, Any] = {
        "remedy": name,
        "goal_images": ONE,
        "trials": len(world),
        "success": success,
        "low": low,
        "high": high,
        "wormholes": wormholes,
        "edges": edges,
        "vertices": vertices,
    }
    outcomes = [part.result.outcome for part in parts]
    columns = {
        "wrong_place": [one.wrong for one in outcomes],
        **{end: [one.ending == end for one in outcomes] for end in ENDINGS[1:]},
        "lost": [part.lost for part in parts],
        "circled": [part.circled for part in parts],
    }
    return row | {what: float(np.concatenate(values).mean()) for what, values in columns.items()}


def _success(parts: list[Attempt]) -> NDArray[np.float64]:
    return np.concatenate([part.result.outcome.success for part in parts]).astype(float)


def _differences(
    parts: list[Mapping[str, Attempt]], names: tuple[str, ...], world: NDArray[np.intp]
) -> list[Finding]:
    """What each remedy adds alone, and what is missing without it; paired differences."""
    success = {name: _success([part[name] for part in parts]) for name in names}
    found = []
    for name in names:
        whole = "all" if name.startswith("no_") else "none"
        if name != whole and whole in success:
            gap = difference(success[name], success[whole], world)
            found.append(Finding(f"{name} - {whole}", *gap))
    return found


EXPERIMENT = Experiment(
    "meng_fig12",
    run,
    OFFICES,
    OFFICES[:3],
    Settings(),
    quick_settings=Settings(trials=20, remedies=("none", "all")),
    canary=Settings(trials=2, remedies=("none", "all")),
    accepts=frozenset({"odometry", "remedies"}),
    ablations={"localization": fig12_localization.EXPERIMENT},
)
