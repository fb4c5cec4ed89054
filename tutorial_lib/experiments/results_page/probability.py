"""Tables of the probability of a plan: Fig. 9 of Meng 2020, and goals and paths that fail."""

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.results_page.markdown import number, percent
from tutorial_lib.experiments.results_page.tables import listing, matching, part, success, table_of

FAULTS = {
    "none": "nobody there",
    "blocked": "path blocked for good",
    "own_goal": "goal in the building",
    "strange_goal": "goal in another building",
}


def plan_probabilities(rows: Rows) -> str:
    """Predicted and measured success of plans in bins of equal size."""
    calibrated = {row["bin"]: row["probability"] for row in matching(rows, calibrated=True)}
    return listing(
        matching(rows, calibrated=False),
        ("bin", lambda row: str(row["bin"] + 1)),
        ("trials", "{trials}"),
        ("product of RE", "{probability:.1%}"),
        ("recalibrated", lambda row: percent(calibrated[row["bin"]])),
        ("arrive", success),
    )


outcomes_of_faults = table_of(
    ("fault", "{name}"),
    ("reached", part("reached", "trials")),
    ("refused", part("refused", "trials")),
    ("plans, mean", lambda row: number(row["plans"], 1)),
    ("probability, mean", lambda row: percent(row["probability"])),
    names=("fault", FAULTS),
)
"""How often a place is reached, or a goal refused."""
