"""Table 1 of Chaplot et al. 2020: success and SPL of all agents, and of ablations of the first."""

from dataclasses import dataclass, replace
from functools import partial

from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.explorers import (
    AGENTS,
    AS_IN_PAPER,
    WITH_GEOMETRY,
    check_shipped,
    own_explorer,
)
from tutorial_lib.experiments.common.own import CUSTOM, or_fault
from tutorial_lib.experiments.common.report import (
    CAR,
    CHANGE,
    Fault,
    Finding,
    Notes,
    Options,
    Rows,
)
from tutorial_lib.experiments.common.statistics import difference
from tutorial_lib.experiments.protocols.exploration import (
    VALIDATION,
    WORLDS,
    Key,
    in_all_worlds,
    make_world,
    measures,
    run_agent,
)
from tutorial_lib.exploration.episodes import DIFFICULTIES
from tutorial_lib.geometry import Array

PAPER = {
    ("il", "rgb"): ((0.57, 0.23), (0.14, 0.06), (0.04, 0.02)),
    ("ans_like", "rgb"): ((0.63, 0.45), (0.31, 0.18), (0.12, 0.07)),
    ("nts", "rgb"): ((0.80, 0.60), (0.47, 0.31), (0.37, 0.22)),
    ("target_rl", "rgb"): ((0.56, 0.22), (0.17, 0.06), (0.06, 0.02)),
    ("target_rl", "rgbd"): ((0.68, 0.28), (0.21, 0.08), (0.09, 0.03)),
    ("map_rl", "rgbd"): ((0.69, 0.27), (0.22, 0.07), (0.12, 0.04)),
    ("il", "rgbd"): ((0.72, 0.32), (0.16, 0.09), (0.05, 0.02)),
    ("fbe", "rgbd"): ((0.77, 0.56), (0.36, 0.18), (0.13, 0.05)),
    ("ans_like", "rgbd"): ((0.76, 0.55), (0.40, 0.24), (0.16, 0.09)),
    ("nts", "rgbd"): ((0.87, 0.65), (0.58, 0.38), (0.43, 0.26)),
}
"""Success and SPL in the paper by difficulty; its worlds are scans of homes, seen by a camera."""
_UNKNOWN = ((None, None),) * len(DIFFICULTIES)  # the paper has no car
DRIVE = ("nts", "fbe", "ans_like", "random", "oracle")
"""The agents that have rows with a car. Imitation knows discrete actions only."""


@dataclass(frozen=True)
class Settings:
    """Settings of the table.

    Attributes:
        episodes: of each difficulty, in each world and with each kind of signs.
        rgbd: agents with depth.
        rgb: agents without.
        geometry: the true geometry stands in for the networks.
    """

    episodes: int = 15
    rgbd: tuple[str, ...] = AGENTS["rgbd"]
    rgb: tuple[str, ...] = AGENTS["rgb"]
    geometry: bool = False


def run(options: Options, settings: Settings) -> tuple[Rows, Notes]:
    """Run all agents on the same episodes.

    Raises:
        InputError: where weights are missing, before anything is run.
    """
    if options.body == CAR:
        settings = replace(settings, rgbd=tuple(n for n in settings.rgbd if n in DRIVE), rgb=())
    agents = {"rgbd": settings.rgbd, "rgb": settings.rgb}
    for sensor, names in agents.items():
        if not settings.geometry:
            check_shipped(names, sensor)
    if options.agent:  # a faulty one is refused before any rollout
        own_explorer(options.agent)
    found = in_all_worlds(run_world, options, settings, label="nts_table1")
    faults = [part for part in found.values() if isinstance(part, Fault)]
    results = {key: part for key, part in found.items() if not isinstance(part, Fault)}
    rows = [row for key, part in results.items() for row in _rows(key, part, options.body)]
    return rows, [*_differences(results), *_turned(results), *faults[:1]]


def run_world(
    item: tuple[int, str], options: Options, settings: Settings
) -> dict[Key, dict[str, Array] | Fault]:
    """Every agent in one world with one kind of signs; or how the user's own failed."""
    seed, signs = item
    world = make_world(seed, signs, settings.episodes, options.seed, options.palette)
    own: dict[Key, dict[str, Array] | Fault] = {}
    if options.agent:
        run = partial(run_agent, world, CUSTOM, "rgbd", own=options.agent, body=options.body)
        own[CUSTOM, "rgbd", signs] = or_fault(options.agent, run)
    return own | {
        (agent, sensor, signs): run_agent(
            world, agent, sensor, geometry=settings.geometry, body=options.body
        )
        for sensor, agents in (("rgbd", settings.rgbd), ("rgb", settings.rgb))
        for agent in agents
    }


def _rows(key: Key, found: dict[str, Array], body: str) -> Rows:
    """A row for each difficulty."""
    agent, sensor, signs = key
    rows: Rows = []
    for number, difficulty in enumerate(DIFFICULTIES):
        mine = found["difficulty"] == number
        columns = {name: column[mine] for name, column in found.items()}
        paper = _UNKNOWN[number] if body == CAR else PAPER.get((agent, sensor), _UNKNOWN)[number]
        row = {"agent": agent, "sensor": sensor, "signs": signs, "difficulty": difficulty}
        row |= {"body": body} | measures(columns, columns["world"])
        rows.append(row | {"paper_success": paper[0], "paper_spl": paper[1]})
    return rows


def _differences(results: dict[Key, dict[str, Array]]) -> list[Finding]:
    """Paired, in SPL on the same episodes.

    The course's NTS minus others with its sensor, and minus itself without depth.
    """
    found = []
    for (agent, sensor, signs), other in results.items():
        own = "rgbd" if agent == "nts" else sensor
        mine = results.get(("nts", own, signs))
        if mine is None or (agent, sensor) == ("nts", "rgbd") or agent == "oracle":
            continue
        for number, difficulty in enumerate(DIFFICULTIES):
            rows = mine["difficulty"] == number
            gap = difference(mine["spl"][rows], other["spl"][rows], mine["world"][rows])
            what = f"SPL, nts ({own}) - {agent} ({sensor}), {signs}, {difficulty}"
            found.append(Finding(what, *gap, form=CHANGE))
    return found


def _turned(results: dict[Key, dict[str, Array]]) -> list[str]:
    """How many cars did not fit into their starts as they stood there."""
    found = [part["turned"] for part in results.values() if "turned" in part][:1]
    return [f"{int(one.sum())} of {len(one)} cars were turned at their starts" for one in found]


_RULES = Experiment(
    "nts_table1_rules",
    run,
    VALIDATION,
    VALIDATION[:4],
    Settings(rgbd=("nts", *AS_IN_PAPER), rgb=()),
    quick_settings=Settings(9, ("nts", *AS_IN_PAPER), ()),
    canary=Settings(3, ("nts", *AS_IN_PAPER), ()),
    accepts=frozenset({"palette"}),
)
_QUICK = ("nts", "fbe", "ans_like", "random", "oracle")
_GEOMETRY = Experiment(
    "nts_table1_geometry",
    run,
    WORLDS,
    WORLDS[:6],
    Settings(rgbd=WITH_GEOMETRY, rgb=(), geometry=True),
    quick_settings=Settings(9, WITH_GEOMETRY, (), geometry=True),
    accepts=frozenset({"palette"}),
)
EXPERIMENT = Experiment(
    "nts_table1",
    run,
    WORLDS,
    WORLDS[:6],
    Settings(),
    quick_settings=Settings(9, _QUICK, ()),
    canary=Settings(3),
    accepts=frozenset({"palette", "agent", "body"}),
    ablations={"geometry": _GEOMETRY, "rules": _RULES},
)
