"""Every table and figure of Chaplot et al. 2020, beside what is measured here."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from tutorial_lib.experiments.nts.table1 import PAPER as TABLE1
from tutorial_lib.experiments.nts.table2 import PAPER as TABLE2
from tutorial_lib.experiments.nts.table2 import PAPER_STANDARD
from tutorial_lib.experiments.results_page.compared_meng import DIAGRAM, NOTHING
from tutorial_lib.experiments.results_page.exploring import AGENTS, LATER, RL
from tutorial_lib.experiments.results_page.markdown import link, percent, points
from tutorial_lib.experiments.results_page.sources import Results, matching, one
from tutorial_lib.exploration.episodes import DIFFICULTIES
from tutorial_lib.learning.weights import load_card
from tutorial_lib.world.generators import SIGNS

READS = ("nts_scores", "nts_table1", "nts_table2", "nts_fig8", "nts_figs")
"""Reports that the rows are made from."""
_DRAWN = "`experiment nts_figs` draws it"
_EXAMPLES = "Figs. 3, 4, 9 and 10: examples"


def lines(results: Results) -> list[list[str]]:
    """A line for each, in the paper's order: name, the paper, here, trend."""
    return [
        *_functions(results),
        *_table1(results),
        *_table2(results),
        *_sequences(results),
        *_examples(results),
        [
            "Figs. 11 to 14",
            "layers of encoder and heads",
            "another network (`learning/panorama_network.py`)",
            "no counterpart: the paper's network is not rebuilt",
        ],
    ]


def _examples(results: Results) -> list[list[str]]:
    ghosts: dict[str, set[int]] = {}
    for row in results.rows("nts_figs"):
        if row["figure"] == 10:
            ghosts.setdefault(row["world"], set()).add(row["chosen"])
    different = sum(len(chosen) == 2 for chosen in ghosts.values())
    return [
        [
            link(_EXAMPLES, "Fig. 9"),
            "an episode step by step",
            f"notebook 09, § 3; {_DRAWN}",
            "one example",
        ],
        [
            link(_EXAMPLES, "Fig. 10"),
            "from one start, two goals make the robot choose two ghosts",
            f"they do in {different} of {len(ghosts)} places",
            "as in the paper, but not everywhere",
        ],
    ]


def _functions(results: Results) -> list[list[str]]:
    card = load_card("nts_rgbd").validation
    blind = matching(results.rows("nts_scores"), pairs="unconnected", sensor="rgbd", score="blind")
    gains = [points(one(blind, signs=s, difficulty="medium")["gain"]) for s in SIGNS]
    return [
        ["Fig. 1", "an illustration of priors", "", NOTHING],
        ["Fig. 2", DIAGRAM, "notebook 09, § 7", NOTHING],
        [
            link(_EXAMPLES, "Fig. 3"),
            "F_G on an example",
            f"F1 {card['explorable_f1']:.2f} on validation worlds; {_DRAWN}",
            "the paper reports no number",
        ],
        [
            link("Scores of directions", "Fig. 4"),
            "F_S changes with the goal, on an example",
            f"to see the goal is worth {' / '.join(gains)} on medium decisions; {_DRAWN}",
            "as in the paper; on hard decisions only where signs lead",
        ],
        ["Fig. 5", DIAGRAM, "notebook 09, § 3 and 5", NOTHING],
        ["Fig. 6", DIAGRAM, "notebook 09, § 6", NOTHING],
        ["Fig. 7", DIAGRAM, "another network, the same tasks", NOTHING],
    ]


_TRENDS = {
    ("nts", "rgbd"): "**differs**: the paper's leads everywhere; here it is above the nearest "
    "frontier on medium and hard goals, and below the learned choice of frontier on all",
    ("ans_like", "rgbd"): "**differs**: the best one but for the oracle",
    ("fbe", "rgbd"): "falls with distance as in the paper, but far less",
    ("il", "rgbd"): "**differs**: near NTS; far below it in the paper",
    ("nts", "rgb"): "below its row with depth as in the paper, but by little, most on hard goals",
    ("ans_like", "rgb"): "**differs**: about level with NTS, by success below it on medium goals, "
    "by SPL above it on hard ones with signs",
    ("il", "rgb"): "**differs**: near NTS; far below it in the paper",
}
"""Of the agents of Table 1 that are measured here."""


def _table1(results: Results) -> list[list[str]]:
    found = []
    for (agent, sensor), levels in TABLE1.items():
        here, trend = LATER, ""
        if agent not in RL:
            rows = matching(results.rows("nts_table1"), agent=agent, sensor=sensor)
            shares = [
                _percents(one(rows, signs=s, difficulty=d)["success"] for d in DIFFICULTIES)
                for s in SIGNS
            ]
            here, trend = " / ".join(shares), _TRENDS[agent, sensor]
        name = f"Table 1, {(AGENTS | RL)[agent]}, {sensor.upper()}"
        name = link("Table 1: image-goal navigation", name)
        found.append([name, _percents(success for success, _ in levels), here, trend])
    return found


def _percents(shares: Iterable[float]) -> str:
    return ", ".join(percent(share, 0) for share in shares)


_WITHOUT = {
    "no_stop": (
        "stop",
        dict.fromkeys(PAPER_STANDARD, "**differs**: stopping costs next to nothing"),
    ),
    "no_noise": (
        "noise",
        {
            "nts": "no gain as in the paper; in plain worlds a loss",
            "il": "no gain as in the paper; with signs a loss",
            "fbe": "**differs**: noise costs nothing here",
            "ans_like": "**differs**: noise costs nothing here",
        },
    ),
}
"""What is taken away in Table 2, and how the agents' gains compare."""


def _table2(results: Results) -> list[list[str]]:
    found = []
    for condition, (what, trends) in _WITHOUT.items():
        for agent, usual in PAPER_STANDARD.items():
            here, trend = LATER, ""
            if agent not in RL:
                notes = [f"{agent}, {signs}: {condition} - standard: " for signs in SIGNS]
                gains = " / ".join(results.note("nts_table2", note) for note in notes)
                here, trend = gains, trends[agent]
            name = f"Table 2, without {what}, {(AGENTS | RL)[agent]}"
            name = link("Table 2: stopping and noise", name)
            gain = points(TABLE2[agent, condition][-1] - usual)
            found.append([name, gain, here, trend])
    return found


def _sequences(results: Results) -> list[list[str]]:
    rows = results.rows("nts_fig8")

    def from_one_to_ten(agent: str, key: str, form: Callable[[float], str]) -> str:
        ends = [
            [form(one(rows, agent=agent, signs=s, goals=count)[key]) for count in (1, 10)]
            for s in SIGNS
        ]
        return " / ".join(" to ".join(pair) for pair in ends)

    def gaps(agent: str) -> str:
        success = from_one_to_ten(agent, "success_gap", points)
        return f"{success}, in SPL {from_one_to_ten(agent, 'spl_gap', '{:+.3f}'.format)}"

    return [
        [
            link("Fig. 8: goals one after another", "Fig. 8, NTS"),
            "falls with the number of goals (curves; the text has no numbers)",
            f"{from_one_to_ten('nts', 'success', percent)} from one goal to ten",
            "as in the paper",
        ],
        [
            link("Fig. 8: goals one after another", "Fig. 8, without a graph"),
            "the gap to NTS grows",
            gaps("nts_no_graph"),
            "grows in plain worlds as in the paper; **differs** with signs",
        ],
        [
            link("Fig. 8: goals one after another", "Fig. 8, random scores"),
            "the gap to NTS shrinks",
            gaps("nts_no_score"),
            "**differs**: it grows",
        ],
    ]
