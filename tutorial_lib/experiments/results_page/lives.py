"""Tables of ten visits: what a memory is worth over the life of a robot in one building."""

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.race.ten_visits import CHANGED, PARTS, STAYS
from tutorial_lib.experiments.results_page.markdown import Row, percent
from tutorial_lib.experiments.results_page.tables import (
    called,
    listing,
    matching,
    of,
    share,
    success,
)

AGENTS = {
    "combined": "combined",
    "no_closing": "without closing loops",
    "no_looks": "recalls nodes only",
    "no_metric": "drives from node to node",
    "no_travel": "whatever the drive to a ghost costs",
    "no_relocating": "does not notice a carry",
    "nts": "NTS, graph kept",
    "nts_closing": "NTS, closing loops",
    "nts_forgets": "NTS, forgets with each goal",
    "fbe": "nearest frontier, grid kept",
    "fbe_recalls": "nearest frontier, grid and pictures kept",
    "ans_like": "learned choice of frontier, grid kept",
    "ans_recalls": "learned choice of frontier, grid and pictures kept",
    "ans_corrected": "learned choice of frontier, grid and pictures kept, odometry corrected",
    "il_forgets": "imitation",
    "random_forgets": "random walk",
    "oracle": "oracle",
    "meng_toured": "Meng, after a tour",
    "sptm_toured": "SPTM, after a tour",
    "ltvn_toured": "LTVN, after a tour",
    "meng_explores": "Meng, after a tour, with NTS where it has no path",
    "meng_explored": "Meng, after exploring",
    "sptm_explored": "SPTM, after exploring",
    "ltvn_explored": "LTVN, after exploring",
}
"""How agents are called on the page."""
FIRST, LAST, ALL = PARTS


def lives(rows: Rows) -> str:
    """Success and SPL of every agent by visits, and where the goal had been passed or not."""

    def gap(row: Row) -> str:
        return "" if row["agent"] == rows[0]["agent"] else share("gap")(row)

    return listing(
        matching(rows, visits=LAST),
        ("agent", lambda row: AGENTS.get(row["agent"], row["agent"])),
        (f"visits {FIRST}", of(rows, _success_and_spl, "agent", visits=FIRST)),
        (f"visits {LAST}", _success_and_spl),
        (f"combined - this, visits {LAST}", gap),
        (f"actions, visits {LAST}", "{steps:,.0f}"),
        ("goal passed before", lambda row: _where(row, "passed")),
        ("goal never passed", lambda row: _where(row, "missed")),
    )


def carried(rows: Rows) -> str:
    """Lives with a carry: success, and how soon a robot finds itself again."""
    return listing(
        matching(rows, visits=ALL),
        ("agent", called("agent", AGENTS)),
        ("all visits", _success_and_spl),
        (f"visits {LAST}", of(rows, _success_and_spl, "agent", visits=LAST)),
        ("found again", lambda row: _soon(row, "again")),
        ("the same, put down where it had been", lambda row: _soon(row, "again_known")),
        ("wrongly", lambda row: percent(row["again_wrong"])),
    )


def changed(rows: Rows) -> str:
    """Lives in a building that changes, beside the same lives where it stays."""
    later = matching(rows, visits=LAST)
    stays = of(later, _success_and_spl, "agent", building=STAYS)
    return listing(
        matching(later, building=CHANGED),
        ("agent", called("agent", AGENTS)),
        (f"the building stays, visits {LAST}", stays),
        (f"it changes, visits {LAST}", _success_and_spl),
        ("stays - changes", share("gap")),
    )


def _success_and_spl(row: Row) -> str:
    """Success with its interval, and SPL."""
    return f"{success(row)}, SPL {row['spl']:.2f}"


def _where(row: Row, name: str) -> str:
    """Success and SPL where a goal had been passed or not, and how many goals these are."""
    if row[name] is None:
        return ""
    return f"{row[name]:.0%}, SPL {row[f'{name}_spl']:.2f} ({row[f'{name}_goals']})"


def _soon(row: Row, name: str) -> str:
    return percent(row[name]) if row[name] else ""
