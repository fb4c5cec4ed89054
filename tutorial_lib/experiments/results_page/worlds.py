"""Tables of the worlds: are the generated plans sound, and do signs lead?"""

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.results_page.markdown import Row, counted, interval, points
from tutorial_lib.experiments.results_page.tables import listing, matching, of, table_of

plans = table_of(
    ("family", lambda row: row["family"].replace("_", " ")),
    ("valid plans", "{valid} of {plans}"),
    ("goals reached", lambda row: counted(row["success"], row["drives"])),
    ("walls crossed", "{walls_crossed}"),
)
"""Valid plans of each family, and how an oracle drives in them."""


def missed(rows: Rows) -> int:
    """How many goals an oracle does not reach, in all families together."""
    return sum(row["drives"] - round(row["success"] * row["drives"]) for row in rows)


def signs(rows: Rows) -> str:
    """How often the best direction is chosen, with and without knowing the goal's picture."""

    def gain(row: Row) -> str:
        return f"{points(row['gain'])} ({points(row['gain_low'])} to {points(row['gain_high'])})"

    return listing(
        [
            row
            for kind in ("plain", "wayfinding")
            for row in matching(rows, signs=kind, model="goal")
        ],
        ("worlds", "{signs}"),
        ("goals", "{difficulty}"),
        ("blind", of(rows, _right, "signs", "difficulty", model="blind")),
        ("knows the goal's picture", _right),
        ("gain", gain),
    )


def _right(row: Row) -> str:
    return interval(row, "top1")
