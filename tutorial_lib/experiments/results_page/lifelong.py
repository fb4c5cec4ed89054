"""Tables of maps that mend themselves (LTVN): of the model, of many queries, of what changes."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from tutorial_lib.experiments.common.report import Finding, Rows
from tutorial_lib.experiments.ltvn.change import OPEN, PHASES
from tutorial_lib.experiments.results_page.markdown import Row, interval, number, percent, table
from tutorial_lib.experiments.results_page.tables import (
    Text,
    column,
    listing,
    matching,
    named,
    of,
    one,
    success,
)

FAMILIES = {"others": "apartments and offices", "loop_corridor": "loop corridors"}
"""How families are called on the page."""
AGENTS = {
    "ltvn": "LTVN",
    "frozen": "its map as it was built",
    "ving": "ViNG",
    "sptm": "SPTM",
    "meng": "Meng",
    "meng_mending": "Meng's map, kept up to date",
    "meng_frozen": "Meng's map as it was built",
    "oracle": "oracle",
    "lenient": "with the paper's test of success",
    "no_trust": "no arrival is trusted",
    "own_blame": "the edge before shares no blame",
    "no_return": "no pruned edge returns",
    "no_expansion": "no expansion",
    "no_reverse": "no edge in reverse",
}
"""How agents, and LTVN's without one of its parts, are called on the page."""
TERMS = {
    "all": "all pairs within 3 m",
    "overlap": "views overlap",
    "ratio": "path about straight",
    "sight": "target in sight",
    "bearing": "target ahead",
    "yaw": "turned by less than 60 degrees",
    "arc": "near one arc",
    "label": "all of these but the arc: the label",
    "label, arc": "the label, and near one arc",
}
LOOKS = {"usual": "as in training", "shifted": "other colours", "scanned": "real floor plans"}
"""How buildings are called on the page."""
SERIES = ("agent", "perception", "family")
"""What the blocks of one series of queries have in common."""


def label(rows: Rows) -> str:
    """How pairs of images end for which a condition holds, and for which it does not."""

    def otherwise(end: str) -> Callable[[Row], str]:
        def text(row: Row) -> str:
            return "".join(map(_share(end), matching(rows, term=row["term"], holds=False)))

        return text

    return listing(
        named(rows, "term", TERMS, holds=True),
        ("condition", "{name}"),
        ("pairs", "{pairs:,}"),
        ("holds: arrive", _share("arrives")),
        ("and face so", _share("faces")),
        ("else: arrive", otherwise("arrives")),
        ("and face so", otherwise("faces")),
    )


def model(rows: Rows) -> str:
    """Which pairs each gate calls reachable."""
    return listing(
        rows,
        ("gate", "{gate}"),
        ("worlds", _family),
        ("threshold", "{threshold:,.3f}"),
        ("reachable found", "{recall:.1%}"),
        ("far accepted", "{far_rate:.3%}"),
        ("precision", "{precision:.1%}"),
        ("far among accepted", "{far_share:.2%}"),
        ("waypoint, median error", "{waypoint_error:.3f} m, {yaw_error:.1f} degrees"),
        ("ECE", lambda row: number(row["ece"])),
    )


def finetune(rows: Rows) -> str:
    """The model, and navigation on its map, before and after it was tuned to the building."""
    return listing(
        rows,
        ("building", lambda row: LOOKS[row["look"]]),
        ("model", lambda row: "tuned" if row["tuned"] else "as it is shipped"),
        ("waypoint, median error", "{waypoint_error:.3f} m, {yaw_error:.1f} degrees"),
        ("reachable found", "{recall:.1%}"),
        ("far accepted", "{far_rate:.3%}"),
        ("found at a threshold of its own", "{recall_at:.1%}"),
        ("queries", success),
        ("vertices", "{vertices:.0f}"),
    )


def size(rows: Rows) -> str:
    """Success, vertices and edges of maps with other thresholds."""
    connect = sorted(set(column(rows, "connect")))

    def at(metres: float) -> Text:
        return of(rows, lambda row: f"{success(row)}, {row['edges']:,.0f} edges", connect=metres)

    return listing(
        [
            {"family": family, "merge": merge}
            for family in FAMILIES
            for merge in sorted(set(column(rows, "merge")))
        ],
        ("worlds", _family),
        ("D_m", "{merge} m"),
        ("vertices", of(rows, "{vertices:.0f}", connect=connect[-1])),
        *((f"D_c = {metres} m", at(metres)) for metres in connect),
    )


def differences(findings: Iterable[Finding], queries: str = "") -> str:
    """Paired differences of agents; of all queries, or of those that are named."""
    cells = []
    for found in findings:
        of_which, agents = found.what.split(": ")
        family, asked, perception = of_which.split(", ")
        if queries in ("", asked):
            more, less = (AGENTS[agent] for agent in agents.split(" - "))
            words = [FAMILIES[family], asked.removeprefix("queries "), perception]
            cells.append([*words, more, less, str(found)])
    return table(["worlds", "queries", "perception", "agent", "compared with", "success"], cells)


def queries(rows: Rows) -> str:
    """Success of the first and the last queries of each agent, and its map in the end."""
    count = count_of(rows[0])
    series = [_series(rows, row) for row in matching(rows, block=0)]
    return listing(
        [blocks[0] | {"queries": len(blocks) * count, "end": blocks[-1]} for blocks in series],
        ("agent", lambda row: AGENTS[row["agent"]]),
        ("perception", lambda row: "" if row["vertices"] is None else row["perception"]),
        ("worlds", _family),
        (f"first {count} queries", success),
        ("queries", "{queries}"),
        (f"the last {count} of them", lambda row: success(row["end"])),
        ("vertices", lambda row: number(row["end"]["vertices"], 0)),
        ("edges", lambda row: number(row["end"]["edges"], 0)),
        ("longer than 5 m", lambda row: number(row["end"]["wormholes"], 1)),
    )


def blocks(rows: Rows) -> str:
    """Success of the agents that run many queries, block by block."""
    count, last = count_of(rows[0]), max(column(rows, "block"))
    series = [_series(rows, row) for row in matching(rows, block=0)]
    lines = [
        [AGENTS[some[0]["agent"]], _family(some[0]), *(percent(row["success"], 0) for row in some)]
        for some in series
        if len(some) > 1
    ]
    head = [f"to {count * (block + 1)}" for block in range(last + 1)]
    return table(
        ["agent", "worlds", *head], [line + [""] * (last + 3 - len(line)) for line in lines]
    )


def spurious(rows: Rows) -> str:
    """Success by block, for each share, with and without updates."""
    numbers = sorted(set(column(rows, "block")))
    keys = ("share", "updates", "perception", "family")
    ends = matching(rows, block=numbers[-1])

    def in_block(number: int) -> Text:
        def text(row: Row) -> str:
            return percent(one(rows, block=number, **{key: row[key] for key in keys})["success"])

        return text

    return listing(
        ends,
        ("spoilt", "{share:.0%}"),
        ("updates", "{updates}"),
        ("worlds", _family),
        *((f"{50 * n + 1} to {50 * (n + 1)}", in_block(n)) for n in numbers),
        ("injected, gone", lambda row: percent(row["injected_gone"], 0)),
        ("true, pruned", lambda row: percent(row["true_pruned"])),
    )


def change(rows: Rows) -> str:
    """Success, and seconds of a drive, in the first and the last queries of each phase."""
    last = max(column(rows, "block"))

    def within(phase: str, block: int) -> Text:
        def text(row: Row) -> str:
            there = one(rows, agent=row["agent"], phase=phase, block=block)
            return f"{percent(there['success'], 0)}, {number(there['seconds'], 0)} s"

        return text

    count = count_of(rows[0])
    return listing(
        matching(rows, block=0, phase=OPEN),
        ("agent", lambda row: AGENTS[row["agent"]]),
        *(
            (f"{phase}, {which} {count}", within(phase, block))
            for phase in PHASES
            for which, block in (("first", 0), ("last", last))
        ),
    )


def count_of(row: Row) -> int:
    """Queries of one block in one world."""
    return row["queries"] // row["worlds"]


def _series(rows: Rows, row: Row) -> Rows:
    """The blocks of the series that a row belongs to."""
    return matching(rows, **{key: row[key] for key in SERIES})


def _family(row: Row) -> str:
    return FAMILIES[row["family"]]


def _share(key: str) -> Callable[[Row], str]:
    return lambda row: interval(row, key, f"{key}_low", f"{key}_high")
