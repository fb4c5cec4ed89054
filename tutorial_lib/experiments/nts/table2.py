"""Table 2 of Chaplot et al. 2020: what the stop action and the noise of motion cost."""

from dataclasses import dataclass
from typing import Any

from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.explorers import BY_REINFORCEMENT, check_shipped
from tutorial_lib.experiments.common.report import Finding, Options, Rows
from tutorial_lib.experiments.common.statistics import difference
from tutorial_lib.experiments.protocols.exploration import (
    WORLDS,
    Key,
    in_all_worlds,
    make_world,
    measures,
    run_agent,
)
from tutorial_lib.exploration.episodes import DIFFICULTIES
from tutorial_lib.geometry import Array

CONDITIONS: dict[str, dict[str, Any]] = {
    "standard": {},
    "no_stop": {"stops_itself": True},
    "no_noise": {"noise": False},
}
"""What differs from Table 1: episodes that end near the goal by themselves; exact motion."""
PAPER = {
    ("target_rl", "no_stop"): (0.89, 0.45, 0.21, 0.52),
    ("map_rl", "no_stop"): (0.89, 0.45, 0.21, 0.52),
    ("target_rl", "no_noise"): (0.69, 0.22, 0.07, 0.33),
    ("map_rl", "no_noise"): (0.70, 0.24, 0.11, 0.35),
    ("il", "no_stop"): (0.76, 0.28, 0.10, 0.38),
    ("fbe", "no_stop"): (0.92, 0.46, 0.29, 0.56),
    ("ans_like", "no_stop"): (0.93, 0.50, 0.32, 0.58),
    ("nts", "no_stop"): (0.94, 0.70, 0.60, 0.75),
    ("il", "no_noise"): (0.71, 0.18, 0.06, 0.32),
    ("fbe", "no_noise"): (0.78, 0.46, 0.23, 0.49),
    ("ans_like", "no_noise"): (0.79, 0.53, 0.30, 0.54),
    ("nts", "no_noise"): (0.87, 0.60, 0.46, 0.64),
}
"""Success in the paper: easy, medium, hard, overall."""
PAPER_STANDARD = {
    "target_rl": 0.33,
    "map_rl": 0.34,
    "il": 0.31,
    "fbe": 0.42,
    "ans_like": 0.44,
    "nts": 0.63,
}
"""Success overall in the paper's Table 1, with depth."""
_LEVELS = (*DIFFICULTIES, "overall")


@dataclass(frozen=True)
class Settings:
    """Settings of the table.

    Attributes:
        episodes: of each difficulty, in each world and with each kind of signs.
        agents: with depth.
        geometry: the true geometry stands in for the networks.
    """

    episodes: int = 15
    agents: tuple[str, ...] = ("nts", "fbe", "ans_like", "il")
    geometry: bool = False


def run(options: Options, settings: Settings) -> tuple[Rows, list[Finding]]:
    """Run the agents under all conditions on the same episodes.

    Raises:
        InputError: where weights are missing, before anything is run.
    """
    if not settings.geometry:
        check_shipped(settings.agents, "rgbd")
    results = in_all_worlds(run_world, options, settings, label="nts_table2")
    rows = [row for key, found in results.items() for row in _rows(key, found)]
    return rows, _gains(results)


def run_world(
    item: tuple[int, str], options: Options, settings: Settings
) -> dict[Key, dict[str, Array]]:
    """Every agent under every condition in one world with one kind of signs."""
    seed, signs = item
    world = make_world(seed, signs, settings.episodes, options.seed, options.palette)
    return {
        (agent, signs, name): run_agent(world, agent, "rgbd", geometry=settings.geometry, **changed)
        for agent in settings.agents
        for name, changed in CONDITIONS.items()
    }


def _rows(key: Key, found: dict[str, Array]) -> Rows:
    """A row for each difficulty, and one for all."""
    agent, signs, condition = key
    rows: Rows = []
    for number, difficulty in enumerate(_LEVELS):
        mine = (found["difficulty"] == number) | (difficulty == "overall")
        columns = {name: column[mine] for name, column in found.items()}
        row = {"agent": agent, "signs": signs, "condition": condition, "difficulty": difficulty}
        row |= measures(columns, columns["world"])
        paper = PAPER.get((agent, condition), [None] * len(_LEVELS))[number]
        rows.append(row | {"paper_success": paper})
    return rows


def _gains(results: dict[Key, dict[str, Array]]) -> list[Finding]:
    """What an agent gains where a difficulty is taken away, on the same episodes."""
    gains = []
    for (agent, signs, condition), found in results.items():
        if condition != "standard":
            usual = results[agent, signs, "standard"]
            gain = difference(found["success"], usual["success"], usual["world"])
            gains.append(Finding(f"{agent}, {signs}: {condition} - standard", *gain))
    return gains


_GEOMETRY = Experiment(
    "nts_table2_geometry",
    run,
    WORLDS,
    WORLDS[:6],
    Settings(agents=("nts", "fbe"), geometry=True),
    quick_settings=Settings(9, ("nts", "fbe"), geometry=True),
    accepts=frozenset({"palette"}),
)
_RL = Experiment(
    "nts_table2_rl",
    run,
    WORLDS,
    WORLDS[:6],
    Settings(agents=BY_REINFORCEMENT),
    quick_settings=Settings(9, BY_REINFORCEMENT),
    canary=Settings(3, BY_REINFORCEMENT),
    accepts=frozenset({"palette"}),
)
EXPERIMENT = Experiment(
    "nts_table2",
    run,
    WORLDS,
    WORLDS[:6],
    Settings(),
    quick_settings=Settings(9, ("nts", "fbe")),
    canary=Settings(3),
    accepts=frozenset({"palette"}),
    ablations={"geometry": _GEOMETRY, "rl": _RL},
)
