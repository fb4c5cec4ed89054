"""Maps: Figs. 4, 8, 10, 11 and 13 of Meng 2020, and what a map costs as it grows."""

from __future__ import annotations

from itertools import groupby

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.meng2020.fig4 import FRAMES
from tutorial_lib.experiments.meng2020.fig4 import Settings as PairSettings
from tutorial_lib.experiments.protocols.navigation_tasks import PLACES
from tutorial_lib.experiments.results_page import reuse
from tutorial_lib.experiments.results_page.markdown import (
    counted,
    number,
    percent,
    span,
    table,
    with_best_bold,
)
from tutorial_lib.experiments.results_page.old_section import Section
from tutorial_lib.experiments.results_page.sources import Results, goal_words, matching, one

STAGES = {
    FRAMES: "every frame a vertex, pruned",
    "dense": "dense: every pair",
    "pruned": "pruned: RE above p_edge",
    "reused": "vertices reused",
}
SIZES = (10_000, 20_000, 50_000, 100_000)
"""Of Fig. 13, at which the table shows the maps."""
METHODS = {"indexed": "indexed", "exhaustive": "all pairs"}


def stages(rows: Rows) -> str:
    """Size of one map at the stages of its construction."""
    lines = [
        [label, f"{row['vertices']:,}", f"{row['edges']:,}"]
        for stage, label in STAGES.items()
        for row in [one(rows, stage=stage)]
    ]
    return table(["map", "vertices", "edges"], lines)


def whole_maps(rows: Rows) -> str:
    """Size of the whole maps."""
    lines = [
        [
            f"{row['family'].replace('_', ' ')} {row['world']}",
            f"{row['area']} m²",
            *(f"{row[key]:,}" for key in ("images", "vertices", "edges")),
        ]
        for row in rows
    ]
    return table(["world", "area", "images", "vertices", "edges"], lines)


def growth(rows: Rows) -> str:
    """Vertices of the map of each world after so many frames."""
    lines = [
        [str(world), *(f"{one(rows, world=world, frames=n)['vertices']:,}" for n in SIZES)]
        for world in dict.fromkeys(row["world"] for row in rows)
    ]
    return table(["world", *(f"{n:,} frames" for n in SIZES)], lines)


def growths(rows: Rows) -> list[float]:
    """By what share each world's map grows over the second half of the frames."""
    half, last = SIZES[-2:]
    return [
        row["vertices"] / one(rows, world=row["world"], frames=half)["vertices"] - 1
        for row in matching(rows, frames=last)
    ]


def fewer_trajectories(rows: Rows) -> str:
    """Success with a part of the trajectories."""
    lines = [
        [
            percent(row["share"], 0),
            counted(row["success"], row["trials"]),
            counted(row["no_generalisation"], row["trials"]),
            number(row["vertices"], 1),
        ]
        for row in rows
    ]
    return table(["trajectories", "success", "repeating alone", "vertices, mean"], lines)


def cost(rows: Rows) -> str:
    """What a trajectory and a plan cost at every size, with the index and without it."""
    lines = []
    for pair in _pairs(rows):
        seconds, plans = (
            with_best_bold([number(v, digits) for v in values], values, least=True)
            for values, digits in (
                ([row["seconds_per_trajectory"] for row in pair], 2),
                ([row["plan_ms"] for row in pair], 0),
            )
        )
        for row, took, plan in zip(pair, seconds, plans, strict=True):
            size = [row["map"], f"{row['vertices']:,}", METHODS[row["method"]]]
            found = percent(row["recall"], 2)
            lines.append([*size, took, f"{row['queries']:,}", found, plan])
    head = [
        "map",
        "vertices",
        "method",
        "s per trajectory",
        "queries",
        "edges found",
        "ms per plan",
    ]
    return table(head, lines)


def _pairs(rows: Rows) -> list[Rows]:
    """The rows of each size: the indexed one, then the exhaustive one."""
    found = [list(part) for _, part in groupby(rows, lambda r: (r["map"], r["vertices"]))]
    return [[one(part, method=method) for method in METHODS] for part in found]


def composed_of(rows: Rows) -> list[int]:
    """How many consecutive vertices a path has from each trajectory that it follows."""
    return [len(list(part)) for _, part in groupby(rows, lambda row: row["trajectory"])]


def _stages_section(results: Results) -> list[str]:
    rows = results.rows("meng_fig4")
    every, sparse = one(rows, stage=FRAMES), one(rows, stage="pruned")
    vertices, edges = (every[key] / sparse[key] for key in ("vertices", "edges"))
    return [
        f"A map at three stages (Fig. 4 of Meng 2020), of the two trajectories of one building "
        f"that run side by side (within {PairSettings().beside:g} m) the farthest: "
        f"{rows[0]['frames']:,} frames in all.",
        stages(rows),
        f"Above them stands the map of all frames, with no anchors chosen. Sparsified, it has "
        f"1/{vertices:.0f} of the vertices and 1/{edges:.0f} of the edges (the paper, III-E: less "
        f"than 1/10 and 1/100).",
        "Two trajectories are an example, not a measurement; sizes of whole maps are in Table II.",
    ]


def _whole_section(results: Results) -> list[str]:
    return [
        "Whole maps (Fig. 8 of Meng 2020): the poses at which vertices were recorded, and the "
        "edges, are in the JSON, to be drawn.",
        whole_maps(results.rows("meng_fig8")),
        "The maps are those of Table II.",
    ]


def _growth_section(results: Results) -> list[str]:
    rows = results.rows("meng_fig13")
    found = growths(rows)
    half, last = SIZES[-2:]
    return [
        f"How maps grow with the number of observations (Fig. 13 of Meng 2020): trajectories "
        f"between the {PLACES} places of a building are recorded again and again, "
        f"{results.worlds('meng_fig13')} test worlds.",
        growth(rows),
        f"Growth is sublinear, as in the paper, but it does not end: from {half:,} to {last:,} "
        f"frames the maps gain {percent(sum(found) / len(found))} vertices on average, "
        f"{span(found)} by world, although the places and the paths between them stay the same.",
    ]


def _fewer_section(results: Results) -> list[str]:
    rows = results.rows("meng_fig10")
    peak = max(row["success"] for row in rows)
    most = one(rows, share=0.6)
    return [
        f"Navigation with a part of the trajectories (Fig. 10 of Meng 2020): "
        f"{results.worlds('meng_fig10')} test worlds, the trials are the same for every part. "
        f"*Repeating alone* counts the trials whose own trajectory was learned: an agent that "
        f"repeats trajectories succeeds in these at most. {goal_words(rows)}",
        fewer_trajectories(rows),
        f"With {percent(most['share'], 0)} of the trajectories success is "
        f"{percent(most['success'] / peak)} of its peak (the paper: close to the peak). Each cell "
        f"pools {most['trials']} trials of {results.worlds('meng_fig10')} worlds, too few for an "
        f"interval over worlds.",
    ]


def _composed_section(results: Results) -> list[str]:
    rows = results.rows("meng_fig11")
    note = results.note("meng_fig11")
    parts = composed_of(rows)
    return [
        f"A path that was never recorded (Fig. 11 of Meng 2020; an example, chosen because it "
        f"succeeds and joins several trajectories). {goal_words(rows)}",
        f"{note[0].upper()}{note[1:]}. Its {len(rows)} vertices are from "
        f"{len({row['trajectory'] for row in rows})} trajectories, in pieces of "
        f"{', '.join(map(str, parts))}.",
    ]


def _cost_section(results: Results) -> list[str]:
    rows = results.rows("map")
    shipped, every = (one(rows, map="one building", method=method) for method in METHODS)
    plain, all_of_it = (
        one(rows, map="one building, no reuse", method=method) for method in METHODS
    )
    indexed, exhaustive = _pairs(rows)[-1]
    return [
        "What a map costs while it grows: an index over embeddings restricts RE to pairs that "
        "look alike, instead of all. First the map of one Table II building, as it is built in "
        "all the other sections (with vertex reuse) and without reuse; then one map without reuse "
        "over many buildings. *Queries* are those of the whole map for one building, and those of "
        "one more trajectory for many. Bold is the better of two at the same size.",
        cost(rows),
        f"*Edges found* is the share of the edges that querying all pairs finds which the index "
        f"finds, too: each trajectory is compared with the same map both ways, and driven edges do "
        f"not count. For the map that is used everywhere it is "
        f"{percent(shipped['recall'], 2)} with {percent(shipped['queries'] / every['queries'])} "
        f"of the queries, without reuse {percent(plain['recall'], 2)} with "
        f"{percent(plain['queries'] / all_of_it['queries'])}; in many buildings it "
        f"is not measured. At {indexed['vertices']:,} vertices a plan takes "
        f"{number(indexed['plan_ms'], 0)} ms, its RE queries included, instead of "
        f"{number(exhaustive['plan_ms'], 0)} ms (one thread, the median of few plans). One "
        f"building: {results.note('map', 'one building: ')}; the 90th trajectory takes "
        f"{results.note('map', 'one building: the 90th trajectory takes ')}, without reuse "
        f"{results.note('map', 'one building, no reuse: the 90th trajectory takes ')}.",
    ]


SECTIONS = (
    Section("Fig. 4: pruning and reuse", ("meng_fig4",), _stages_section),
    Section("Fig. 8: whole maps", ("meng_fig8",), _whole_section),
    Section("Fig. 13: growth of maps", ("meng_fig13",), _growth_section),
    *reuse.SECTIONS,
    Section("Cost of a growing map", ("map",), _cost_section),
)
PATHS = (
    Section("Fig. 10: fewer trajectories", ("meng_fig10",), _fewer_section),
    Section("Fig. 11: a composed path", ("meng_fig11",), _composed_section),
)
