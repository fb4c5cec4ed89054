"""Fig. 8 of Chaplot et al. 2020: up to ten goals one after another, with and without a memory."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.explorers import check_shipped, make_explorer
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.common.statistics import difference, over_worlds
from tutorial_lib.experiments.protocols.exploration import VALIDATION, WORLDS
from tutorial_lib.exploration.episodes import draw_episodes, draw_sequence, exploration_world
from tutorial_lib.exploration.task import ExplorationTask, explore_on
from tutorial_lib.geometry import Array
from tutorial_lib.parallel import for_each
from tutorial_lib.world.generators import SIGNS
from tutorial_lib.world.worlds import scene_of

AGENTS = ("nts", "nts_no_graph", "nts_no_score")


@dataclass(frozen=True)
class Settings:
    """Settings of the figure.

    Attributes:
        episodes: in each world and with each kind of signs.
        goals: of each episode.
        agents: "nts" first, to which gaps are.
        geometry: the true geometry stands in for the network.
        noise: of motion and odometry.
    """

    episodes: int = 16
    goals: int = 10
    agents: tuple[str, ...] = AGENTS
    geometry: bool = False
    noise: bool = True


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Run NTS and its two ablations on the same goals.

    Raises:
        InputError: where weights are missing, before anything is run.
    """
    if not settings.geometry:
        check_shipped(settings.agents, "rgbd")
    items = [(world, signs) for signs in SIGNS for world in options.worlds]
    found = for_each(run_world, items, options, settings, label="nts_fig8")
    rows: Rows = []
    for signs in SIGNS:
        mine = [part for part, (_, kind) in zip(found, items, strict=True) if kind == signs]
        worlds = np.repeat(options.worlds, settings.episodes)
        columns = {
            agent: {
                name: np.concatenate([part[agent][name] for part in mine], axis=1)
                for name in ("success", "spl")
            }
            for agent in settings.agents
        }
        rows += [
            _row(columns, agent, signs, count, worlds)
            for agent in settings.agents
            for count in range(1, settings.goals + 1)
        ]
    return rows, ["success and spl: of all goals up to that number; gap: of nts to the agent"]


def run_world(
    item: tuple[int, str], options: Options, settings: Settings
) -> dict[str, dict[str, Array]]:
    """Every agent in one world: "success" and "spl" (goals, episodes)."""
    seed, signs = item
    name = exploration_world(seed, signs, options.palette)
    scene = scene_of(name)
    rng = np.random.default_rng([options.seed, seed])
    half = settings.episodes // 2
    counts = {"easy": half, "medium": settings.episodes - half}
    episodes = draw_episodes(name, scene, counts, rng)
    goals = draw_sequence(scene, episodes.goals, settings.goals, rng)
    found = {}
    for agent in settings.agents:
        noise, own = (np.random.default_rng([options.seed, seed, i]) for i in (1, 2))
        task = ExplorationTask({name: scene}, episodes, noise, noise=settings.noise)
        explorer = make_explorer(agent, task, "rgbd", own, geometry=settings.geometry)
        columns = list(explore_on(task, explorer, goals))
        success, spl = (np.array(column, float) for column in zip(*columns, strict=True))
        found[agent] = {"success": success, "spl": spl}
    return found


def _row(
    columns: dict[str, dict[str, Array]], agent: str, signs: str, count: int, worlds: Array
) -> dict[str, Any]:
    """An agent's goals up to a number."""
    row: dict[str, Any] = {"agent": agent, "signs": signs, "goals": count, "episodes": len(worlds)}
    repeated = np.tile(worlds, count)
    for name in ("success", "spl"):
        values = columns[agent][name][:count].ravel()
        row[name] = float(values.mean())
        gap = difference(columns["nts"][name][:count].ravel(), values, repeated)
        row |= dict(zip((f"{name}_gap", f"{name}_gap_low", f"{name}_gap_high"), gap, strict=True))
    reached = columns[agent]["success"][:count].ravel()
    row |= dict(zip(("low", "high"), over_worlds(reached, repeated)[1:], strict=True))
    return row | {"success_this": float(columns[agent]["success"][count - 1].mean())}


_GEOMETRY = Experiment(
    "nts_fig8_geometry",
    run,
    WORLDS,
    WORLDS[:6],
    Settings(geometry=True),
    quick_settings=Settings(6, geometry=True),
    accepts=frozenset({"palette"}),
)
_EXACT = Experiment(
    "nts_fig8_exact",
    run,
    VALIDATION,
    VALIDATION[:3],
    Settings(8, noise=False),
    quick_settings=Settings(4, noise=False),
    accepts=frozenset({"palette"}),
)
EXPERIMENT = Experiment(
    "nts_fig8",
    run,
    WORLDS,
    WORLDS[:6],
    Settings(),
    quick_settings=Settings(6),
    canary=Settings(2, 2),
    accepts=frozenset({"palette"}),
    ablations={"geometry": _GEOMETRY, "exact": _EXACT},
)
