"""Tables of maps: Figs. 4, 8 and 13 of Meng 2020, and what a map costs as it grows."""

from itertools import groupby

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.meng2020.fig4 import FRAMES
from tutorial_lib.experiments.results_page.markdown import percent, table
from tutorial_lib.experiments.results_page.tables import (
    Best,
    asked,
    column,
    lines_of,
    matching,
    named,
    one,
    pivot,
    table_of,
)

STAGES = {
    FRAMES: "every frame a vertex, pruned",
    "dense": "dense: every pair",
    "pruned": "pruned: RE above p_edge",
    "reused": "vertices reused",
}
SIZES = (10_000, 20_000, 50_000, 100_000)
"""Of Fig. 13, at which the table shows the maps."""
METHODS = {"indexed": "indexed", "exhaustive": "all pairs"}

stages = table_of(
    ("map", "{name}"),
    ("vertices", "{vertices:,}"),
    ("edges", "{edges:,}"),
    names=("stage", STAGES),
)
"""Size of one map at the stages of its construction."""
whole_maps = table_of(
    ("world", lambda row: f"{row['family'].replace('_', ' ')} {row['world']}"),
    ("area", "{area} m²"),
    *((key, f"{{{key}:,}}") for key in ("images", "vertices", "edges")),
)
"""Size of the whole maps."""
COST = (
    ("map", "{map}"),
    ("vertices", "{vertices:,}"),
    ("method", "{name}"),
    ("s per trajectory", Best("{seconds_per_trajectory:,.2f}", "seconds_per_trajectory", True)),
    ("queries", "{queries:,}"),
    ("edges found", lambda row: percent(row["recall"], 2)),
    ("ms per plan", Best("{plan_ms:,.0f}", "plan_ms", least=True)),
)
"""Columns of the table of what a map costs."""


def growth(rows: Rows) -> str:
    """Vertices of the map of each world after so many frames."""
    worlds = dict.fromkeys(column(rows, "world"))
    cells = pivot(rows, asked(world=worlds), asked(frames=SIZES), "{vertices:,}")
    lines = [[str(world), *line] for world, line in zip(worlds, cells, strict=True)]
    return table(["world", *(f"{n:,} frames" for n in SIZES)], lines)


def growths(rows: Rows) -> list[float]:
    """By what share each world's map grows over the second half of the frames."""
    half, last = SIZES[-2:]
    return [
        row["vertices"] / one(rows, world=row["world"], frames=half)["vertices"] - 1
        for row in matching(rows, frames=last)
    ]


def cost(rows: Rows) -> str:
    """What a trajectory and a plan cost at every size, with the index and without it."""
    lines = [line for pair in pairs(rows) for line in lines_of(pair, *COST)]
    return table([head for head, _ in COST], lines)


def pairs(rows: Rows) -> list[Rows]:
    """The rows of each size: the indexed one, then the exhaustive one."""
    sizes = groupby(rows, lambda row: (row["map"], row["vertices"]))
    return [named(list(part), "method", METHODS) for _, part in sizes]
