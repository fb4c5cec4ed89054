"""Tables of maps that mend themselves (LTVN): of the model, of many queries, of what changes."""

from collections.abc import Iterable

from tutorial_lib.experiments.common.report import Finding, Rows
from tutorial_lib.experiments.ltvn.change import OPEN, PHASES
from tutorial_lib.experiments.results_page.markdown import Row, number, percent, percents, table
from tutorial_lib.experiments.results_page.tables import (
    Text,
    asked,
    called,
    column,
    listing,
    matching,
    named,
    of,
    share,
    success,
    table_of,
)

FAMILIES = {"others": "apartments and offices", "loop_corridor": "loop corridors"}
"""How families are called on the page."""
IN_WORLDS = ("worlds", called("family", FAMILIES))
"""Their column."""
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

    def otherwise(end: str) -> Text:
        return lambda row: "".join(map(share(end), matching(rows, term=row["term"], holds=False)))

    return listing(
        named(rows, "term", TERMS, holds=True),
        ("condition", "{name}"),
        ("pairs", "{pairs:,}"),
        ("holds: arrive", share("arrives")),
        ("and face so", share("faces")),
        ("else: arrive", otherwise("arrives")),
        ("and face so", otherwise("faces")),
    )


model = table_of(
    ("gate", "{gate}"),
    IN_WORLDS,
    ("threshold", "{threshold:,.3f}"),
    ("reachable found", "{recall:.1%}"),
    ("far accepted", "{far_rate:.3%}"),
    ("precision", "{precision:.1%}"),
    ("far among accepted", "{far_share:.2%}"),
    ("waypoint, median error", "{waypoint_error:.3f} m, {yaw_error:.1f} degrees"),
    ("ECE", lambda row: number(row["ece"])),
)
"""Which pairs each gate calls reachable."""
finetune = table_of(
    ("building", called("look", LOOKS)),
    ("model", lambda row: "tuned" if row["tuned"] else "as it is shipped"),
    ("waypoint, median error", "{waypoint_error:.3f} m, {yaw_error:.1f} degrees"),
    ("reachable found", "{recall:.1%}"),
    ("far accepted", "{far_rate:.3%}"),
    ("found at a threshold of its own", "{recall_at:.1%}"),
    ("queries", success),
    ("vertices", "{vertices:.0f}"),
)
"""The model, and navigation on its map, before and after it was tuned to the building."""


def size(rows: Rows) -> str:
    """Success, vertices and edges of maps with other thresholds."""
    merge, connect = (sorted(set(column(rows, key))) for key in ("merge", "connect"))

    def joined(row: Row) -> str:
        return f"{success(row)}, {row['edges']:,.0f} edges"

    return listing(
        asked(family=FAMILIES, merge=merge),
        IN_WORLDS,
        ("D_m", "{merge} m"),
        ("vertices", of(rows, "{vertices:.0f}", connect=connect[-1])),
        *((f"D_c = {metres} m", of(rows, joined, connect=metres)) for metres in connect),
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
        ("agent", called("agent", AGENTS)),
        ("perception", lambda row: "" if row["vertices"] is None else row["perception"]),
        IN_WORLDS,
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

    def at(block: int) -> Text:
        return lambda row: "".join(percents(row["shares"][block : block + 1], 0))

    return listing(
        [some[0] | {"shares": column(some, "success")} for some in series if len(some) > 1],
        ("agent", called("agent", AGENTS)),
        IN_WORLDS,
        *((f"to {count * (block + 1)}", at(block)) for block in range(last + 1)),
    )


def spurious(rows: Rows) -> str:
    """Success by block, for each share, with and without updates."""
    numbers = sorted(set(column(rows, "block")))
    same = ("share", "updates", "perception", "family")
    in_block = {n: of(rows, "{success:.1%}", *same, block=n) for n in numbers}
    return listing(
        matching(rows, block=numbers[-1]),
        ("spoilt", "{share:.0%}"),
        ("updates", "{updates}"),
        IN_WORLDS,
        *((f"{50 * n + 1} to {50 * (n + 1)}", text) for n, text in in_block.items()),
        ("injected, gone", lambda row: percent(row["injected_gone"], 0)),
        ("true, pruned", lambda row: percent(row["true_pruned"])),
    )


def change(rows: Rows) -> str:
    """Success, and seconds of a drive, in the first and the last queries of each phase."""
    count, last = count_of(rows[0]), max(column(rows, "block"))

    def text(row: Row) -> str:
        return f"{percent(row['success'], 0)}, {number(row['seconds'], 0)} s"

    return listing(
        matching(rows, block=0, phase=OPEN),
        ("agent", called("agent", AGENTS)),
        *(
            (f"{phase}, {which} {count}", of(rows, text, "agent", phase=phase, block=block))
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
