"""Tables of navigation: Table II of Meng 2020, also of a part of the drives, and Figs. 10, 11."""

from collections.abc import Collection, Mapping, Sequence
from itertools import groupby
from statistics import fmean

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.protocols.navigation import WORMHOLE
from tutorial_lib.experiments.results_page.markdown import Row, listed, percent, table
from tutorial_lib.experiments.results_page.sources import Results, goal_words
from tutorial_lib.experiments.results_page.tables import (
    Best,
    Text,
    asked,
    called,
    column,
    listing,
    matching,
    of,
    one,
    part,
    pivot,
    success,
    success_count,
    table_of,
    total,
    without,
)

METHODS = {"meng": "Meng", "sptm": "SPTM", "random": "random", "oracle": "oracle"}
BOUNDS = ("random", "oracle")
"""Those without a map: never the best."""
OVER = f"over {WORMHOLE:g} m"
ENDINGS = {
    "wrong_place": "arrived elsewhere",
    "gave_up": "gave up",
    "stuck": "stuck",
    "late": "out of time",
}
AGENT = ("agent", called("method", METHODS))
THRESHOLDS = (
    AGENT,
    ("threshold", "{threshold:g}"),
    ("replans", lambda row: "yes" if row["replans"] else "no"),
    ("vertices", "{vertices:,}"),
    ("edges", "{edges:,}"),
    (OVER, "{wormholes:,}"),
    ("success", success_count),
)
"""Columns of the tables of thresholds."""
thresholds = table_of(*THRESHOLDS)
"""Success and map size for every threshold."""
chosen = table_of(*THRESHOLDS, ("composed", "{success_composed:.1%}"))
"""The same, with success in composed trials behind it."""
fewer_trajectories = table_of(
    ("trajectories", "{share:.0%}"),
    ("success", success_count),
    ("repeating alone", part("no_generalisation", "trials")),
    ("vertices, mean", "{vertices:,.1f}"),
)
"""Success with a part of the trajectories."""


def success_by_world(rows: Rows) -> str:
    """Success of every method in each world, and in all together."""
    lines = _by_world(rows)
    if len(lines) > 1:
        totals = [total(rows, method) for method in METHODS]
        lines.append(["all together", *_of_methods(totals, [{}], success_count)[0]])
    return table(["world", *METHODS.values()], lines)


def table_of_maps(rows: Rows) -> str:
    """Success of every method on maps from files, each of which is a world by itself."""
    return table(["map", *METHODS.values()], _by_world(rows))


def sizes_by_world(rows: Rows) -> str:
    """Vertices, edges and wormholes of the maps in each world."""
    return listing(
        [
            row | {"sptm": one(rows, world=row["world"], method="sptm")}
            for row in matching(rows, method="meng")
        ],
        ("world", _world),
        ("images", "{images:,}"),
        ("Meng: vertices", "{vertices:,}"),
        ("edges", "{edges:,}"),
        (OVER, "{wormholes:,}"),
        ("SPTM: vertices", "{sptm[vertices]:,}"),
        ("edges", "{sptm[edges]:,}"),
        (OVER, "{sptm[wormholes]:,}"),
    )


def failures(rows: Rows) -> str:
    """How the trials ended that did not succeed, by place and method."""
    return listing(
        [row for row in rows if row["method"] not in BOUNDS],
        ("world", _world),
        AGENT,
        ("trials", "{trials}"),
        *((words, _ended(ending)) for ending, words in ENDINGS.items()),
    )


def goal_images(rows: Rows, others: Rows) -> str:
    """Success by what shows the goal and by p_goal; `others` are of the same after a tour."""
    composed = part("success_composed", "trials_composed")
    return listing(
        rows,
        ("goal", "{goal_images}"),
        ("p_goal", "{p_goal:g}"),
        ("success", success_count),
        ("composed, after a tour", of(others, composed, "goal_images", "p_goal")),
        ("refused", "{refused:.1%}"),
        ("goals elsewhere refused", "{refused_strange:.1%}"),
    )


def composed_trials(results: Results, names: Mapping[str, str]) -> str:
    """Success in composed trials, over all worlds of the reports that have `names` here."""
    lines = []
    for label, name in names.items():
        rows = results.rows(name, method="meng")
        known = [row for row in rows if row["success_driven"] is not None]
        trials = [row["trials"] - row["trials_composed"] for row in known]
        sure = sum(n * row["success_driven"] for n, row in zip(trials, known, strict=True))
        lines.append(
            [
                label,
                f"{sum(column(rows, 'trials_composed')):,}",
                *(str(results.finding(name, f"{method}, composed")) for method in METHODS),
                str(results.finding(name, "meng - sptm, composed")),
                percent(sure / sum(trials)) if sum(trials) else "",
                str(results.finding(name, "goals on a learned drive, composed")),
            ]
        )
    head = ["learned", "trials", *METHODS.values(), "Meng - SPTM", "Meng, driven", "goals passed"]
    return table(head, lines)


def map_sizes(results: Results, names: Mapping[str, str]) -> str:
    """Images and size of the maps, on average over the worlds of each report."""
    lines = []
    for label, name in names.items():
        lines.append([label, f"{fmean(column(results.rows(name, method='meng'), 'images')):,.0f}"])
        for method in ("meng", "sptm"):
            vertices, edges, wormholes = (
                column(results.rows(name, method=method), key)
                for key in ("vertices", "edges", "wormholes")
            )
            lines[-1] += [f"{fmean(vertices):,.0f}", f"{fmean(edges):,.0f}", f"{sum(wormholes):,}"]
    sizes = ["Meng: vertices", "edges", "wormholes in all"]
    return table(["learned", "images", *sizes, "SPTM: vertices", *sizes[1:]], lines)


def goals_of(results: Results, names: Mapping[str, str]) -> str:
    """What showed the goals, by what was learned."""
    said: dict[str, list[str]] = {}
    for label, name in names.items():
        said.setdefault(goal_words(results.rows(name)), []).append(label)
    if len(said) == 1:
        return next(iter(said))
    return " ".join(f"{listed(labels).capitalize()}: {words}" for words, labels in said.items())


def composed_of(rows: Rows) -> list[int]:
    """How many consecutive vertices a path has from each trajectory that it follows."""
    return [len(list(part)) for _, part in groupby(column(rows, "trajectory"))]


def gaps(rows: Rows, method: str, other: str) -> list[float]:
    """By how much a method's success is above the other's, in each world."""
    return [
        row["success"] - one(rows, world=row["world"], method=other)["success"]
        for row in matching(rows, method=method)
    ]


def total_vertices(rows: Rows, method: str = "meng", places: Collection[int] = ()) -> int:
    """Vertices of a method's maps together, in some places only if they are given."""
    found = matching(rows, method=method)
    return sum(row["vertices"] for row in found if not places or row["world"] in places)


def _by_world(rows: Rows) -> list[list[str]]:
    """A line for each world: its name, and the success of every method."""
    worlds = matching(rows, method="meng")
    cells = _of_methods(rows, asked(world=column(worlds, "world")), success)
    return [[_world(row), *line] for row, line in zip(worlds, cells, strict=True)]


def _of_methods(rows: Rows, lines: Sequence[Row], text: Text) -> list[list[str]]:
    """Success of every method, the best map's bold."""
    judged = without(BOUNDS, "method", "success")
    return pivot(rows, lines, asked(method=METHODS), Best(text, judged))


def _ended(ending: str) -> Text:
    return lambda row: str(round(row[ending] * row["trials"]))


def _world(row: Row) -> str:
    if isinstance(row["world"], int):
        return f"{row['family'].replace('_', ' ')} {row['world']}, {row['area']:,} m²"
    return f"{row['world'].removesuffix('.yaml')}, {row['area']:,} m²"
