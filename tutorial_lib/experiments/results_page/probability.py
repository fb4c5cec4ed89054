"""The probability of a plan: Fig. 9 of Meng 2020, and goals and paths that fail."""

from __future__ import annotations

import math

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.protocols.navigation_tasks import ANYWHERE_PERTURBATION
from tutorial_lib.experiments.results_page.markdown import counted, interval, percent, table
from tutorial_lib.experiments.results_page.old_section import Section
from tutorial_lib.experiments.results_page.sources import Results, goal_words, matching, one
from tutorial_lib.experiments.robustness.faults import DETOUR
from tutorial_lib.topology.planner import DijkstraPlanner

FAULTS = {
    "none": "nobody there",
    "blocked": "path blocked for good",
    "own_goal": "goal in the building",
    "strange_goal": "goal in another building",
}


def plan_probabilities(rows: Rows) -> str:
    """Predicted and measured success of plans in bins of equal size."""
    lines = [
        [
            f"{row['bin'] + 1}",
            str(row["trials"]),
            percent(row["probability"]),
            percent(other["probability"]),
            interval(row, "success"),
        ]
        for row in matching(rows, calibrated=False)
        for other in [one(rows, calibrated=True, bin=row["bin"])]
    ]
    return table(["bin", "trials", "product of RE", "recalibrated", "arrive"], lines)


def outcomes_of_faults(rows: Rows) -> str:
    """How often a place is reached, or a goal refused."""
    lines = []
    for fault, label in FAULTS.items():
        row = one(rows, fault=fault)
        plans = "" if row["plans"] is None else f"{row['plans']:.1f}"
        probability = percent(row["probability"])
        shares = [counted(row[key], row["trials"]) for key in ("reached", "refused")]
        lines.append([label, *shares, plans, probability])
    return table(["fault", "reached", "refused", "plans, mean", "probability, mean"], lines)


def _probability_section(results: Results) -> list[str]:
    rows = results.rows("meng_fig9")
    raw = matching(rows, calibrated=False)
    product, again = (
        results.note("meng_fig9", f"{kind}: ") for kind in ("product of RE", "recalibrated")
    )
    return [
        f"Is the probability of a plan the share of such plans that succeed (Fig. 9 of Meng "
        f"2020)? {sum(row['trials'] for row in raw):,} trials in {results.worlds('meng_fig9')} "
        f"test worlds start anywhere on the recorded trajectories, many facing aside (σ = "
        f"{math.degrees(ANYWHERE_PERTURBATION.wide_turn):.0f}°), every plan is followed without "
        f"replanning, and none is refused. {goal_words(raw)} {len(raw)} bins of "
        f"{raw[0]['trials']} trials; intervals are Wilson's and treat trials of one world as "
        f"independent.",
        plan_probabilities(rows),
        f"The order is right, the size is not: the product of RE over a plan is overconfident "
        f"({product}): of plans with {percent(raw[0]['probability'])} on average "
        f"{percent(raw[0]['success'])} arrive. Recalibrated by isotonic regression on validation "
        f"worlds, which changes no order, it is nearly calibrated ({again}). A rank correlation "
        f"over so few bins says little.",
    ]


def _faults_section(results: Results) -> list[str]:
    rows = results.rows("faults")
    planner = DijkstraPlanner()
    free, blocked, own, strange = (one(rows, fault=fault) for fault in FAULTS)
    return [
        f"Faults (ours; the paper has none): people block the path for good where a detour of at "
        f"most {DETOUR:g} times its length exists and the agent's map has another path, too "
        f"({blocked['trials']} trials), and goal images from another building, of which none can "
        f"be reached. {results.worlds('faults')} test worlds, too few for an "
        f"interval. {goal_words(rows)}",
        outcomes_of_faults(rows),
        f"Blocked paths are the weak point: {percent(blocked['reached'])} reach the place, where "
        f"{percent(free['reached'])} do when nobody is there. Of the goals in another building "
        f"{percent(strange['refused'])} are refused, of the building's own "
        f"{percent(own['refused'])}. A plan is refused when its probability is below "
        f"{planner.least:g}, or when no vertex reaches the goal with RE above {planner.p_goal:g}. "
        f"The building's own goal images are taken centimetres from recorded frames, which makes "
        f"them easy to tell.",
    ]


SECTIONS = (
    Section("Fig. 9: probability of a plan", ("meng_fig9",), _probability_section),
    Section("Blocked paths and foreign goals", ("faults",), _faults_section),
)
