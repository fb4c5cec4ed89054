"""The worlds: are the generated plans sound?"""

from __future__ import annotations

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.results_page.markdown import counted, interval, points, table
from tutorial_lib.experiments.results_page.old_section import Section
from tutorial_lib.experiments.results_page.sources import Results, matching, one
from tutorial_lib.experiments.robustness.plans import Settings
from tutorial_lib.learning.exploration_training import WITHIN


def plans(rows: Rows) -> str:
    """Valid plans of each family, and how an oracle drives in them."""
    lines = [
        [
            row["family"].replace("_", " "),
            f"{row['valid']} of {row['plans']}",
            counted(row["success"], row["drives"]),
            str(row["walls_crossed"]),
        ]
        for row in rows
    ]
    return table(["family", "valid plans", "goals reached", "walls crossed"], lines)


def _section(results: Results) -> list[str]:
    rows, settings = results.rows("plans"), Settings()
    drives = sum(row["drives"] for row in rows)
    missed = sum(row["drives"] - round(row["success"] * row["drives"]) for row in rows)
    return [
        f"Are the generated floor plans sound? Each of {results.worlds('plans')} test seeds gives "
        f"a plan of every family: the same seed must give the same bytes, walls must be closed, "
        f"and every room must be within the car's reach. In the first {settings.driven} of each "
        f"family an oracle drives from random poses to {settings.goals} random places.",
        plans(rows),
        f"The oracle, which knows the geodesic, misses {missed} of {drives:,} goals; that bounds "
        f"what other agents can reach there.",
    ]


def signs(rows: Rows) -> str:
    """How often the best direction is chosen, with and without knowing the goal's picture."""
    lines = []
    for kind in ("plain", "wayfinding"):
        for row in matching(rows, signs=kind, model="goal"):
            blind = one(rows, signs=kind, model="blind", difficulty=row["difficulty"])
            gain = (
                f"{points(row['gain'])} ({points(row['gain_low'])} to {points(row['gain_high'])})"
            )
            lines.append(
                [kind, row["difficulty"], interval(blind, "top1"), interval(row, "top1"), gain]
            )
    return table(["worlds", "goals", "blind", "knows the goal's picture", "gain"], lines)


def _signs_section(results: Results) -> list[str]:
    rows = results.rows("nts_wayfinding")
    decisions = sum(row["decisions"] for row in matching(rows, model="goal", signs="plain"))
    return [
        f"Does a picture of the goal say where to look for it? Two gradient-boosted models with "
        f"perfect perception choose among the directions that a place offers, {decisions:,} times "
        f"in {results.worlds('nts_wayfinding')} test worlds. Both also know how each direction "
        f"differs from the mean of those to choose from. A choice is right if its end is "
        f'within {WITHIN:g} m of the best one\'s. With `signs="wayfinding"` accents on the walls '
        f"follow the distance along the corridors, in other hues in every world.",
        signs(rows),
        "In plain worlds room types hardly tell where a far goal lies; with signs its picture "
        "does.",
    ]


SECTIONS = (
    Section("Generated floor plans", ("plans",), _section),
    Section("Signs that lead", ("nts_wayfinding",), _signs_section),
)
