"""The worlds: are the generated plans sound?"""

from __future__ import annotations

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.results_page.markdown import counted, table
from tutorial_lib.experiments.results_page.section import Section
from tutorial_lib.experiments.results_page.sources import Results
from tutorial_lib.experiments.robustness.plans import Settings


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


SECTIONS = (Section("Generated floor plans", ("plans",), _section),)
