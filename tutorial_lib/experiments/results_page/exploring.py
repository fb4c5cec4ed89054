"""Tables of exploring a place never seen: Neural Topological SLAM and what it is compared with."""

from collections.abc import Callable
from itertools import product
from typing import Any

from tutorial_lib.experiments.common.report import Finding, Rows
from tutorial_lib.experiments.nts.scores import PAIRS
from tutorial_lib.experiments.nts.table1 import PAPER as TABLE1
from tutorial_lib.experiments.nts.table2 import CONDITIONS, PAPER, PAPER_STANDARD
from tutorial_lib.experiments.protocols.exploration import AT_STEPS
from tutorial_lib.experiments.results_page.markdown import (
    Row,
    interval,
    percent,
    percents,
    points,
    table,
)
from tutorial_lib.experiments.results_page.sources import Results
from tutorial_lib.experiments.results_page.tables import (
    Best,
    asked,
    called,
    column,
    listing,
    matching,
    of,
    one,
    pivot,
    success,
    success_and_spl,
    table_of,
    transposed,
    without,
)
from tutorial_lib.exploration.episodes import DIFFICULTIES
from tutorial_lib.world.generators import SIGNS

RL = {"target_rl": "target-driven RL", "map_rl": "metric map and RL"}
"""The paper's baselines that learn by reinforcement."""
NOT_HERE = "not trained here"
"""In place of what they reach here without depth."""
AGENTS = {
    "nts": "NTS",
    "nts_no_graph": "NTS without a graph",
    "nts_no_score": "NTS, random scores",
    "nts_blind": "NTS, scores blind to the goal",
    "fbe": "nearest frontier",
    "ans_like": "learned choice of frontier",
    "il": "imitation",
    **RL,
    "random": "random walk",
    "oracle": "oracle",
}
"""How agents are called on the page."""
AGENT = called("agent", AGENTS)
SENSORS = {"rgbd": "with depth", "rgb": "without depth"}

METHODS = {"both": "map and explorer", "memory": "map alone", "explorer": "explorer alone"}
"""How methods of the second visit are called on the page."""
RULES = {
    "nts": "the course's",
    "nts_masked": "F_S masked",
    "nts_all_nodes": "F_L over all nodes",
    "nts_by_odometry": "edges by odometry",
    "nts_no_ghost_nodes": "no node at a ghost",
    "nts_paper": "all four",
}
"""How the course's rules and those of the paper are called on the page."""
GOALS = {"passed": "passed on the first visit", "elsewhere": "elsewhere", "all": "all"}


def paired(key: str) -> Callable[[Row], str]:
    """A paired difference of shares and its interval.

    >>> paired("gain")({"gain": 0.1, "gain_low": 0.05, "gain_high": 0.2})
    '+10.0 points (+5.0 to +20.0)'
    """
    return lambda row: str(Finding(key, row[key], row[f"{key}_low"], row[f"{key}_high"]))


GAIN = paired("gain")


def choices(rows: Rows) -> str:
    """How often each score chooses the right direction, with depth; and F_S without."""
    scores = {"masked": "masked", "blind": "blind", "histogram": "colours"}
    rgbd, rgb = (matching(rows, sensor=sensor) for sensor in ("rgbd", "rgb"))
    return listing(
        asked(pairs=PAIRS, signs=SIGNS, difficulty=DIFFICULTIES),
        ("pairs", "{pairs}"),
        ("worlds", "{signs}"),
        ("goals", "{difficulty}"),
        ("decisions", of(rgb, "{decisions:,}", score="semantic")),
        ("F_S", of(rgbd, lambda row: interval(row, "top1"), score="semantic")),
        *((words, of(rgbd, "{top1:.1%}", score=score)) for score, words in scores.items()),
        ("random", of(rgbd, "{top1:.1%}", score="random")),
        *((f"F_S - {words}", of(rgbd, GAIN, score=score)) for score, words in scores.items()),
        ("F_S without depth", of(rgb, "{top1:.1%}", score="semantic")),
    )


def table_1(results: Results, signs: str) -> str:
    """Table 1 for one kind of worlds: success and SPL of every agent, the paper's beside them."""
    lines, rows = [], all_agents(results)
    for sensor, words in SENSORS.items():
        mine = matching(rows, signs=signs, sensor=sensor)
        agents = [name for name in AGENTS if matching(mine, agent=name)]
        # Nothing is best where there is nothing to compare it with.
        bounds = ("oracle", "random") if len(agents) > 1 else agents
        best = Best(success_and_spl, without(bounds, "agent", "spl"))
        columns = pivot(mine, asked(difficulty=DIFFICULTIES), asked(agent=agents), best)
        for name, *cells in transposed([agents, *columns]):
            lines.append([AGENTS[name], words, *cells, _reported(name, sensor)])
        for name in RL:
            if name not in agents and (name, sensor) in TABLE1:
                lines.append([AGENTS[name], words, NOT_HERE, "", "", _reported(name, sensor)])
    return table(["agent", "sensor", *DIFFICULTIES, "paper"], lines)


def learning(curves: dict[str, Rows]) -> str:
    """Success by difficulty on the way of the policies that learn by reinforcement.

    Args:
        curves: of each in `RL`, as on the cards of its weights, measured at the same steps.
    """
    lines = []
    for measured in zip(*curves.values(), strict=True):
        cells = [f"{measured[0]['steps']:,.0f}"]
        for row, part in product(measured, ("training_", "")):
            shares = [row[f"{part}success_{level}"] for level in DIFFICULTIES]
            cells.append(" / ".join(percents(shares, 0)))
        lines.append(cells)
    heads = [f"{RL[name]}, {of_what}" for name, of_what in product(curves, ("training", "unseen"))]
    return table(["frames", *heads], lines)


def all_agents(results: Results) -> Rows:
    """The rows of Table 1, with the policies that learnt by reinforcement, on the same episodes."""
    learned = results.rows("nts_table2_rl", condition="standard")
    return results.rows("nts_table1") + [row | {"sensor": "rgbd"} for row in learned]


def in_time(rows: Rows, signs: str) -> str:
    """Success within fewer steps."""
    keys = (*(f"success_{steps}" for steps in AT_STEPS), "success")
    shares = " / ".join(f"{{{key}:.1%}}" for key in keys)
    return listing(
        asked(agent=("nts", "fbe", "ans_like"), sensor=("rgbd",), signs=(signs,)),
        ("agent", AGENT),
        *((level, of(rows, shares, difficulty=level)) for level in DIFFICULTIES),
    )


def spl_gap(
    results: Results, agent: str, signs: str, difficulty: str, report: str = "nts_table1"
) -> str:
    """The paired difference in SPL of NTS to another agent with depth, as its report has it."""
    what = f"SPL, nts (rgbd) - {agent} (rgbd), {signs}, {difficulty}"
    return str(results.finding(report, what))


def spl_gaps(results: Results) -> str:
    """Those differences to the agents of Table 1."""
    return listing(
        asked(agent=("fbe", "ans_like", "nts_no_score", "nts_blind"), signs=SIGNS),
        ("NTS - other, SPL", AGENT),
        ("worlds", "{signs}"),
        *(
            (level, lambda row, level=level: spl_gap(results, **row, difficulty=level))
            for level in DIFFICULTIES
        ),
    )


def bodies(rows: Rows, cars: Rows) -> str:
    """Success and SPL of every agent with a car, and of the round robot beside it."""
    return listing(
        asked(signs=SIGNS, agent=dict.fromkeys(column(cars, "agent")), sensor=("rgbd",)),
        ("worlds", "{signs}"),
        ("agent", AGENT),
        *(
            (f"{level}, {body}", of(found, success_and_spl, difficulty=level))
            for level in DIFFICULTIES
            for body, found in {"car": cars, "round": rows}.items()
        ),
    )


def stop_and_noise(results: Results) -> str:
    """Table 2: the paper's agents and ours, and what each gains in either."""
    changed = list(CONDITIONS)[1:]
    both = results.rows("nts_table2") + results.rows("nts_table2_rl")
    overall = matching(both, difficulty="overall")
    lines = []
    for agent in ("nts", "ans_like", "fbe", *RL, "il"):
        usual, shares = PAPER_STANDARD[agent], [PAPER[agent, name][-1] for name in changed]
        cells = [*percents((usual, *shares), 0), *(points(share - usual) for share in shares)]
        lines.append([AGENTS[agent], "the paper", *cells])
        both = asked(signs=SIGNS), asked(condition=CONDITIONS)
        here = pivot(matching(overall, agent=agent), *both, "{success:.1%}")
        for signs, cells in zip(SIGNS, here, strict=True):
            gains = [gain_without(results, agent, signs, name) for name in changed]
            lines.append([AGENTS[agent], signs, *cells, *gains])
    head = ["agent", "worlds", "standard", "without stop", "without noise"]
    return table([*head, "gain without stop", "gain without noise"], lines)


def gain_without(results: Results, agent: str, signs: str, condition: str) -> str:
    """What an agent gains without stopping or noise, as the report on Table 2 has it."""
    report = "nts_table2_rl" if agent in RL else "nts_table2"
    return str(results.finding(report, f"{agent}, {signs}: {condition} - standard"))


def sequences(rows: Rows) -> str:
    """Success and SPL over goals one after another."""
    return listing(
        asked(signs=SIGNS, agent=("nts", "nts_no_graph", "nts_no_score")),
        ("agent", AGENT),
        ("worlds", "{signs}"),
        ("1 goal", of(rows, success_and_spl, goals=1)),
        *((f"{goals} goals", of(rows, success_and_spl, goals=goals)) for goals in (2, 5, 10)),
    )


def gaps(rows: Rows) -> str:
    """The gap of NTS to both ablations at one goal and at ten, beside what the paper's does."""
    paper = {"nts_no_graph": "grows", "nts_no_score": "shrinks"}
    return listing(
        asked(agent=paper, signs=SIGNS),
        ("NTS - this", AGENT),
        ("worlds", "{signs}"),
        ("in the paper", lambda row: paper[row["agent"]]),
        ("success, 1 goal", of(rows, paired("success_gap"), goals=1)),
        ("success, 10 goals", of(rows, paired("success_gap"), goals=10)),
        ("SPL, 1 goal", of(rows, "{spl_gap:+.3f}", goals=1)),
        ("SPL, 10 goals", of(rows, "{spl_gap:+.3f}", goals=10)),
    )


def rules(results: Results) -> str:
    """Rules of the paper: success / SPL on single goals, and what the course's gain over them."""
    name = "nts_table1_rules"

    def gap(row: Row, level: str) -> str:
        if row["agent"] == "nts":
            return ""
        return spl_gap(results, **row, difficulty=level, report=name)

    return listing(
        asked(agent=RULES, signs=SIGNS),
        ("rule", called("agent", RULES)),
        ("worlds", "{signs}"),
        *(
            (level, of(results.rows(name), success_and_spl, difficulty=level))
            for level in DIFFICULTIES
        ),
        *(
            (f"{level}: course's - this, SPL", lambda row, level=level: gap(row, level))
            for level in DIFFICULTIES
        ),
    )


def by_signs(rows: Rows, **values: Any) -> str:  # noqa: ANN401 - any value of a row
    """Success in plain worlds / with signs in the rows that have those values."""
    found = [one(rows, signs=signs, **values) for signs in SIGNS]
    return " / ".join(percents(column(found, "success"), 0))


def second_visit(rows: Rows) -> str:
    """What a map from the first visit is worth on the second one."""
    return listing(
        asked(signs=SIGNS, goals=GOALS, method=METHODS),
        ("worlds", "{signs}"),
        ("goals", called("goals", GOALS)),
        ("method", called("method", METHODS)),
        ("success", of(rows, success)),
        ("SPL", of(rows, "{spl:,.3f}")),
        ("along the map", of(rows, lambda row: percent(row["recalled"], 0))),
        ("both - this", of(rows, lambda row: "" if row["method"] == "both" else GAIN(row))),
    )


first_ghosts = table_of(
    ("place", lambda row: " ".join(row["world"].split("/")[:2])),
    ("goal in", "{what}"),
    ("ghost taken first", "{chosen}"),
    ("best direction", "{best}"),
    ("driven", lambda row: f"{row['travelled']:.1f} m" if row["success"] else "missed"),
    figure=10,
)
"""Which ghost a robot takes first for each of two goals, and what becomes of it."""


def ghosts(rows: Rows) -> list[int]:
    """How many different ghosts the goals of each place make a robot take first."""
    chosen: dict[str, set[int]] = {}
    for row in matching(rows, figure=10):
        chosen.setdefault(row["world"], set()).add(row["chosen"])
    return [len(different) for different in chosen.values()]


def _reported(agent: str, sensor: str) -> str:
    """Success and SPL by difficulty as the paper has them; nothing where it has not."""
    levels = TABLE1.get((agent, sensor), ())
    return ", ".join(f"{success:.2f} / {spl:.2f}" for success, spl in levels)
