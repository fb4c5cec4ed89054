"""Exploring a place never seen: Neural Topological SLAM and what it is compared with."""

from __future__ import annotations

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.nts.table2 import CONDITIONS, PAPER
from tutorial_lib.experiments.protocols.exploration import AT_STEPS
from tutorial_lib.experiments.results_page.markdown import (
    Row,
    interval,
    number,
    percent,
    points,
    table,
    with_best_bold,
)
from tutorial_lib.experiments.results_page.section import Section
from tutorial_lib.experiments.results_page.sources import Results, matching, one
from tutorial_lib.exploration.episodes import DIFFICULTIES
from tutorial_lib.learning.exploration_training import WITHIN
from tutorial_lib.world.generators import SIGNS

AGENTS = {
    "nts": "NTS",
    "nts_no_graph": "NTS without a graph",
    "nts_no_score": "NTS, random scores",
    "nts_blind": "NTS, scores blind to the goal",
    "fbe": "nearest frontier",
    "ans_like": "learned choice of frontier",
    "il": "imitation",
    "random": "random walk",
    "oracle": "oracle",
}
"""How agents are called on the page."""
SENSORS = {"rgbd": "with depth", "rgb": "without depth"}


def gap_of(row: Row, key: str) -> str:
    """A paired difference of shares and its interval.

    >>> gap_of({"gain": 0.1, "gain_low": 0.05, "gain_high": 0.2}, "gain")
    '+10.0 points (+5.0 to +20.0)'
    """
    low, high = (100 * row[f"{key}_{end}"] for end in ("low", "high"))
    return f"{points(row[key])} ({low:+.1f} to {high:+.1f})"


def choices(rows: Rows) -> str:
    """How often each score chooses the right direction, with depth; and F_S without."""
    lines = []
    for signs in SIGNS:
        for difficulty in DIFFICULTIES:
            found = {
                row["score"]: row
                for row in matching(rows, sensor="rgbd", signs=signs, difficulty=difficulty)
            }
            rgb = one(rows, sensor="rgb", signs=signs, difficulty=difficulty, score="semantic")
            lines.append(
                [
                    signs,
                    difficulty,
                    interval(found["semantic"], "top1"),
                    *(percent(found[name]["top1"]) for name in ("blind", "histogram", "random")),
                    gap_of(found["blind"], "gain"),
                    gap_of(found["histogram"], "gain"),
                    percent(rgb["top1"]),
                ]
            )
    head = ["worlds", "goals", "F_S", "blind", "colours", "random", "F_S - blind"]
    return table([*head, "F_S - colours", "F_S without depth"], lines)


def _score_section(results: Results) -> list[str]:
    rows = results.rows("nts_scores")
    decisions = sum(
        row["decisions"] for row in matching(rows, sensor="rgbd", signs="plain", score="semantic")
    )
    gains = {
        (signs, level): one(rows, sensor="rgbd", signs=signs, difficulty=level, score="blind")[
            "gain"
        ]
        for signs in SIGNS
        for level in DIFFICULTIES
    }
    return [
        f"F_S scores the directions of a panorama by how near they lead to the goal of another. Is "
        f"its first choice right: is the path to the goal from that direction's end at most "
        f"{WITHIN:g} m longer than from the best one's? {decisions:,} decisions in "
        f"{results.worlds('nts_scores')} test worlds, the same with and without signs. *Blind* is "
        f"a network whose scores were trained without the goal; *colours* compares histograms.",
        choices(rows),
        f"To see the goal is worth {points(gains['plain', 'easy'])} on easy decisions, where it is "
        f"mostly in sight. On hard ones it is worth {points(gains['plain', 'hard'])} in plain "
        f"worlds, and {points(gains['wayfinding', 'hard'])} where signs lead to it.",
    ]


def success_and_spl(rows: Rows, signs: str) -> str:
    """Table 1 for one kind of worlds: success and SPL of every agent, the paper's beside them."""
    lines = []
    for sensor, words in SENSORS.items():
        mine = matching(rows, signs=signs, sensor=sensor)
        agents = [name for name in AGENTS if matching(mine, agent=name)]
        columns = []
        for difficulty in DIFFICULTIES:
            found = [one(mine, agent=name, difficulty=difficulty) for name in agents]
            values = [
                None if r["agent"] in ("oracle", "random") or len(found) == 1 else r["spl"]
                for r in found
            ]
            cells = [f"{percent(row['success'])} / {number(row['spl'])}" for row in found]
            columns.append(with_best_bold(cells, values))
        for number_of, name in enumerate(agents):
            paper = [
                f"{number(row['paper_success'], 2)} / {number(row['paper_spl'], 2)}"
                for row in (one(mine, agent=name, difficulty=level) for level in DIFFICULTIES)
                if row["paper_success"] is not None
            ]
            cells = [column[number_of] for column in columns]
            lines.append([AGENTS[name], words, *cells, ", ".join(paper)])
    return table(["agent", "sensor", *DIFFICULTIES, "paper"], lines)


def in_time(rows: Rows, signs: str) -> str:
    """Success within fewer steps."""
    lines = []
    for name in ("nts", "fbe", "ans_like"):
        found = [
            one(rows, agent=name, sensor="rgbd", signs=signs, difficulty=level)
            for level in DIFFICULTIES
        ]
        keys = (*(f"success_{steps}" for steps in AT_STEPS), "success")
        cells = [" / ".join(percent(row[key]) for key in keys) for row in found]
        lines.append([AGENTS[name], *cells])
    return table(["agent", *DIFFICULTIES], lines)


def _gap(results: Results, agent: str, signs: str, difficulty: str) -> str:
    what = f"SPL, nts (rgbd) - {agent} (rgbd), {signs}, {difficulty}: "
    return results.note("nts_table1", what)


def _table1_section(results: Results) -> list[str]:
    rows = results.rows("nts_table1")
    episodes = rows[0]["episodes"]
    worlds = results.worlds("nts_table1")
    easy = one(rows, agent="fbe", sensor="rgbd", signs="plain", difficulty="easy")
    differences = table(
        ["NTS - other, SPL", "worlds", *DIFFICULTIES],
        [
            [AGENTS[agent], signs, *(_gap(results, agent, signs, level) for level in DIFFICULTIES)]
            for agent in ("fbe", "ans_like", "nts_no_score", "nts_blind")
            for signs in SIGNS
        ],
    )
    return [
        f"Image-goal navigation (Table 1 of Chaplot et al. 2020, *Neural Topological SLAM*): a "
        f"robot with a panorama in a place that it has never seen, the picture of a goal, 500 "
        f"actions with measured noise of motion and odometry; success is to stop within 1 m. "
        f"{episodes} episodes of each difficulty and kind of worlds in {worlds} test worlds, the "
        f"same for every agent. Cells are success / SPL. All agents but *imitation* and the "
        f"oracle have NTS's recognition of the goal and its local policy, as in the paper.",
        "Worlds with signs, whose accents follow the distance along the corridors:",
        success_and_spl(rows, "wayfinding"),
        "Plain worlds:",
        success_and_spl(rows, "plain"),
        f"In two dimensions a panorama shows much more of a place than a camera does in three: the "
        f"nearest frontier, which does not know the goal, finds {percent(easy['success'])} of the "
        f"easy ones. Paired differences on the same episodes, intervals over worlds:",
        differences,
        f"Success within {AT_STEPS[0]} / {AT_STEPS[1]} / 500 actions, with signs:",
        in_time(rows, "wayfinding"),
        "*Learned choice of frontier* stands for Active Neural SLAM, whose global policy is "
        "trained by reinforcement; ours is supervised with the true distances. *Imitation* is "
        "behaviour cloning with a recurrent network. Without depth NTS's learned one stands in; "
        "the nearest frontier has a row with measured depth only, as in the paper.",
    ]


def _table2_section(results: Results) -> list[str]:
    rows = results.rows("nts_table2")
    lines = []
    for agent in ("nts", "fbe", "ans_like", "il"):
        for signs in SIGNS:
            overall = matching(rows, agent=agent, signs=signs, difficulty="overall")
            found = {row["condition"]: row for row in overall}
            lines.append(
                [
                    AGENTS[agent],
                    signs,
                    *(percent(found[name]["success"]) for name in CONDITIONS),
                    *(
                        results.note("nts_table2", f"{agent}, {signs}: {name} - standard: ")
                        for name in list(CONDITIONS)[1:]
                    ),
                    " / ".join(percent(PAPER[agent, name][-1], 0) for name in list(CONDITIONS)[1:]),
                ]
            )
    head = ["agent", "worlds", "standard", "without stop", "without noise"]
    return [
        f"What stopping and what noise cost (Table 2 of Chaplot et al. 2020): success over all "
        f"difficulties where an episode ends near the goal by itself (a wrong stop still "
        f"ends it), and where motion and odometry are exact. {results.worlds('nts_table2')} test "
        f"worlds, {rows[0]['episodes']} episodes of each difficulty.",
        table([*head, "gain without stop", "gain without noise", "paper, without each"], lines),
        "A robot that stops only where it sees the goal seldom stops elsewhere. Noise costs no "
        "agent much; why exact motion does worse in places is not known.",
    ]


SECTIONS = (
    Section("Scores of directions", ("nts_scores",), _score_section),
    Section("Table 1: image-goal navigation", ("nts_table1",), _table1_section),
    Section("Table 2: stopping and noise", ("nts_table2",), _table2_section),
)
