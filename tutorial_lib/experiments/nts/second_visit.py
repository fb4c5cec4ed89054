"""A second visit: what an exploration saw is a map, with the explorer behind it or without.

The first visit looks for goals one after another (Chaplot et al. 2020, 6.1). Of its run the agent
of Meng 2020 makes a map. On the second visit robots start where the first one passed and look for a
goal that it passed, or that it came nowhere near.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.agents.nts import NTSAgent
from tutorial_lib.agents.returning import ReturningAgent
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.explorers import check_shipped, make_explorer
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.common.statistics import difference, over_worlds
from tutorial_lib.experiments.protocols.exploration import WORLDS
from tutorial_lib.experiments.protocols.visits import GOALS, Recorder, draw_return, learned_from
from tutorial_lib.exploration.episodes import draw_episodes, draw_sequence, exploration_world
from tutorial_lib.exploration.task import ExplorationTask, explore, explore_on
from tutorial_lib.interfaces import ExplorerAgent
from tutorial_lib.parallel import for_each
from tutorial_lib.validation import instance
from tutorial_lib.world.generators import SIGNS
from tutorial_lib.world.worlds import scene_of

METHODS = ("both", "memory", "explorer")
"""The map with the explorer behind it; each of the two alone."""


@dataclass(frozen=True)
class Settings:
    """Settings of the experiment.

    Attributes:
        goals: of the first visit, one after another.
        trials: of the second, with each kind of goal.
        geometry: the true geometry stands in for the network that explores.
    """

    goals: int = 16
    trials: int = 12
    geometry: bool = False


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Run all methods on the same trials, with and without signs.

    Raises:
        InputError: where the explorer's weights are missing, before anything is run.
    """
    if not settings.geometry:
        check_shipped(("nts",), "rgbd")
    items = [(world, signs) for signs in SIGNS for world in options.worlds]
    found = for_each(run_world, items, options, settings, label="nts_second_visit")
    rows: Rows = []
    for signs in SIGNS:
        mine = [part for part, item in zip(found, items, strict=True) if item[1] == signs]
        columns = {name: np.concatenate([part[name] for part in mine]) for name in mine[0]}
        kinds = [kind for kind in GOALS if (columns["goals"] == kind).any()]
        rows += [
            _row(columns, method, signs, goals) for goals in (*kinds, "all") for method in METHODS
        ]
    visits = np.array([part["visit"][0] for part in found])
    vertices = np.array([part["vertices"][0] for part in found])
    notes = [
        f"first visits took {visits.mean():.0f} actions; maps have {vertices.mean():.0f} vertices",
        "gain: of both over this method on the same trials, 95% intervals over worlds",
    ]
    return rows, notes


def run_world(item: tuple[int, str], options: Options, settings: Settings) -> dict[str, NDArray]:
    """Explore a world, learn it, and come back: columns (N,) of the trials."""
    seed, signs = item
    name = exploration_world(seed, signs, options.palette)
    scene = scene_of(name)
    rng = np.random.default_rng([options.seed, seed, 3])
    first = draw_episodes(name, scene, {"medium": 1}, rng)
    goals = draw_sequence(scene, first.goals, settings.goals, rng)
    task = ExplorationTask({name: scene}, first, rng)
    recorder = Recorder(_nts(task, rng, settings.geometry))
    list(explore_on(task, recorder, goals))
    memory = learned_from(recorder.run)
    path = np.concatenate(task.path)
    counts = dict.fromkeys(GOALS, settings.trials)
    episodes, kinds = draw_return(name, scene, path, counts, rng)
    count = len(episodes)
    columns: dict[str, NDArray] = {
        "world": np.full(count, seed),
        "goals": kinds,
        "visit": np.full(count, len(recorder.run)),
        "vertices": np.full(count, len(memory.topomap)),
    }
    for method in METHODS:
        noise, own = (np.random.default_rng([options.seed, seed, i]) for i in (4, 5))
        task = ExplorationTask({name: scene}, episodes, noise)
        agent = make_method(method, memory, task, own, geometry=settings.geometry)
        explore(task, agent)
        columns |= {
            f"success_{method}": task.success.astype(float),
            f"spl_{method}": task.spl,
            f"steps_{method}": task.steps.astype(float),
        }
        if isinstance(agent, ReturningAgent):
            columns[f"recalled_{method}"] = agent.recalled / np.maximum(task.steps, 1)
    return columns


def make_method(
    method: str,
    memory: MengAgent,
    task: ExplorationTask,
    rng: np.random.Generator,
    *,
    geometry: bool = False,
) -> ExplorerAgent:
    """One of `METHODS` for a task of the second visit."""
    if method == "memory":
        return ReturningAgent(memory)
    explorer = _nts(task, rng, geometry)
    return explorer if method == "explorer" else ReturningAgent(memory, explorer)


def _nts(task: ExplorationTask, rng: np.random.Generator, geometry: bool) -> NTSAgent:
    explorer = make_explorer("nts", task, "rgbd", rng, geometry=geometry)
    return instance("explorer", explorer, NTSAgent)


def _row(columns: dict[str, NDArray], method: str, signs: str, goals: str) -> dict[str, Any]:
    """A method's trials with one kind of goal."""
    mine = np.ones(len(columns["world"]), bool) if goals == "all" else columns["goals"] == goals
    worlds = columns["world"][mine]
    success = columns[f"success_{method}"][mine]
    row: dict[str, Any] = {"method": method, "signs": signs, "goals": goals, "trials": len(worlds)}
    row |= dict(zip(("success", "low", "high"), over_worlds(success, worlds), strict=True))
    row["spl"] = float(columns[f"spl_{method}"][mine].mean())
    row["steps"] = float(columns[f"steps_{method}"][mine].mean())
    recalled = columns.get(f"recalled_{method}")
    row["recalled"] = None if recalled is None else float(recalled[mine].mean())
    gain: tuple[float | None, ...] = (None, None, None)
    if method != "both":
        gain = difference(columns["success_both"][mine], success, worlds)
    return row | dict(zip(("gain", "gain_low", "gain_high"), gain, strict=True))


_GEOMETRY = Experiment(
    "nts_second_visit_geometry",
    run,
    WORLDS,
    WORLDS[:6],
    Settings(geometry=True),
    quick_settings=Settings(8, 6, geometry=True),
    accepts=frozenset({"palette"}),
)
EXPERIMENT = Experiment(
    "nts_second_visit",
    run,
    WORLDS,
    WORLDS[:6],
    Settings(),
    quick_settings=Settings(8, 6),
    canary=Settings(3, 2),
    accepts=frozenset({"palette"}),
    ablations={"geometry": _GEOMETRY},
)
