"""Places that look alike: remedies in navigation (Fig. 12 of Meng 2020), and the filter alone."""

from __future__ import annotations

from tutorial_lib.agents.remedies import REMEDIES
from tutorial_lib.agents.remedy_navigation import CYCLE, ENDLESS
from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.common.statistics import difference, in_points
from tutorial_lib.experiments.meng2020.fig12_localization import CASES, FOUND, NOTICED, RIGHT, SURE
from tutorial_lib.experiments.protocols.navigation import WORMHOLE
from tutorial_lib.experiments.results_page.markdown import (
    Row,
    interval,
    percent,
    points,
    table,
    with_best_bold,
)
from tutorial_lib.experiments.results_page.old_section import Section
from tutorial_lib.experiments.results_page.sources import Results, goal_words, matching, one

NAMES = {
    "none": "none",
    **{name: f"{name} alone" for name in ("sequence", "replan", "cycles", "filter")},
    **{f"no_{name}": f"all but {name}" for name in ("sequence", "replan", "cycles", "filter")},
    "all": "all",
}
"""How the choices of remedies are called."""
SHOWN_CASES = {
    "driven": "driven",
    "doors": "driven, in a corridor with a twin",
    "standstill": "standing still",
    "kidnapped": "carried to another room",
}
"""How the cases of the filter are called."""
SHARES = {
    "right": f"within {RIGHT:g} m",
    "sure": f"sure (belief ≥ {SURE:g})",
    "right_if_sure": "right where sure",
    "changes_at_most_once": "vertex changes at most once",
    "noticed": f"noticed within {NOTICED:g} s",
    "found": f"localized again within {FOUND:g} s",
}
"""Columns of the table of the filter."""
NAVIGATION, LOCALIZATION = "meng_fig12", "meng_fig12_localization"
"""Names of the reports."""
ELSEWHERE = {
    "all drives": ("meng_table2", "meng_table2_remedies"),
    "20% of the drives": ("meng_table2_drives_02", "meng_table2_remedies_02"),
}
"""Reports on Table II, without the remedies and with them, by what was learned."""


def success_by_remedy(results: Results) -> str:
    """Success, the map, and how the other trials ended, for every choice of remedies."""
    rows = [one(results.rows(NAVIGATION), remedy=name) for name in REMEDIES]
    shares = [interval(row, "success") for row in rows]
    best = with_best_bold(shares, [row["success"] for row in rows])
    lines = []
    for row, cell in zip(rows, best, strict=True):
        name = row["remedy"]
        whole = "all" if name.startswith("no_") else "none"
        gap = "" if name == whole else results.note(NAVIGATION, f"{name} - {whole}: ")
        compared = f"{gap.replace(' points', '')} against *{whole}*" if gap else ""
        ends = [percent(row[end]) for end in ("wrong_place", "gave_up", "stuck", "late")]
        size = [f"{row['vertices']:,}", f"{row['wormholes']:,} of {row['edges']:,}"]
        lines.append([NAMES[name], cell, compared, *size, *ends, percent(row["circled"])])
    head = ["remedies", "success", "points", "vertices", f"edges over {WORMHOLE:g} m"]
    ends = ["arrived elsewhere", "gave up", "stuck", "out of time", "in circles"]
    return table([*head, *ends], lines)


def filter_by_case(rows: Rows) -> str:
    """What the filter believed, a line for each case."""
    lines = []
    for case in CASES:
        row = one(rows, case=case)
        lines.append([SHOWN_CASES[case], f"{row['count']:,}", *_shares(row)])
    return table(["case", "count", *SHARES.values()], lines)


def _shares(row: Row) -> list[str]:
    """The shares of a case; nothing where it has none."""
    keys = [(name, f"{name}_low", f"{name}_high") for name in SHARES]
    return ["" if row[keys_of[0]] is None else interval(row, *keys_of) for keys_of in keys]


def _remedies_section(results: Results) -> list[str]:
    rows = results.rows(NAVIGATION)
    every, none = (one(rows, remedy=name) for name in ("all", "none"))
    circles = round(every["circled"] * every["trials"])
    return [
        f"Starts that look alike (Fig. 12 and Sec. III-G of Meng 2020): in "
        f"{results.worlds(NAVIGATION)} offices most rooms have an exact twin. A trial starts in "
        f"such a room; its goal is a picture of a room that has none. {every['trials']:,} trials, "
        f"the same for every choice of remedies. *none*: edges and vertices by single views, the "
        f"start at the most similar vertex, no replanning. *sequence*: edges, reused vertices "
        f"and the start by sequences of views, turns only where no other path leads to the goal; "
        f"*replan*: a lost robot plans again; *cycles*: from the {CYCLE}rd visit of a vertex on a "
        f"robot plans around what it visited, and gives up at the {ENDLESS}th; *filter*: a Bayes "
        f"filter over the vertices and *off the map* says where plans begin and when they are "
        f"void. The paper shows one example and has no table. {goal_words(rows)}",
        success_by_remedy(results),
        f"With all remedies {percent(every['success'])} of the trials succeed, with none "
        f"{percent(none['success'])}; differences are paired, their intervals over worlds. *In "
        f"circles* came to some vertex more than {ENDLESS} times: {circles} of "
        f"{every['trials']:,} trials with all remedies. Vertices and edges are those of all "
        f"offices together.",
    ]


def _filter_section(results: Results) -> list[str]:
    rows = results.rows(LOCALIZATION)
    driven, doors, carried = (one(rows, case=case) for case in ("driven", "doors", "kidnapped"))
    return [
        f"The Bayes filter by itself in the same offices: an oracle drives, and the filter follows "
        f"what the robot sees and what its drifting wheels measure. *Count* is that of control "
        f"steps for driven robots, of robots otherwise. A robot is localized rightly within "
        f"{RIGHT:g} m of driving from its vertex; the filter is sure where its belief of being "
        f"near that vertex is at least {SURE:g}. Every other robot is carried to another kind of "
        f"room after some seconds; it has noticed when it calls itself off the map or is "
        f"localized rightly.",
        filter_by_case(rows),
        f"Where it is sure it is right in {percent(driven['right_if_sure'])} of the steps, but in "
        f"a corridor with a twin only in {percent(doors['right_if_sure'])}: nothing that is seen "
        f"there counts the doors, and the wheels drift. Of the "
        f"carried robots {percent(carried['noticed'])} notice within {NOTICED:g} s, and "
        f"{percent(carried['found'])} are localized again within {FOUND:g} s of driving.",
    ]


def success_elsewhere(results: Results) -> str:
    """Success in Table II without the remedies and with all, of the same trials."""
    lines = []
    for learned, names in ELSEWHERE.items():
        without, remedied = (matching(results.rows(name), method="meng") for name in names)
        before = [row["success"] for row in without]
        after = [one(remedied, world=row["world"])["success"] for row in without]
        gaps = [late - early for early, late in zip(before, after, strict=True)]
        cells = [results.note(name, "meng, all worlds: ") for name in names]
        found = difference(after, before, range(len(gaps)))
        range_of = " to ".join(_points(end) for end in (min(gaps), max(gaps)))
        worlds = str(results.worlds(names[0]))
        lines.append([learned, worlds, *cells, in_points(found).replace(" points", ""), range_of])
    head = ["learned", "worlds", "without", "with all", "points", "by world"]
    return table(head, lines)


def _late(results: Results, name: str) -> float:
    """The share of Meng's trials that ran out of time."""
    rows = matching(results.rows(name), method="meng")
    return sum(row["late"] for row in rows) / len(rows)


def _points(share: float) -> str:
    return points(share).removesuffix(" points")


def _elsewhere_section(results: Results) -> list[str]:
    late = [percent(_late(results, name)) for name in ELSEWHERE["20% of the drives"]]
    return [
        "Do the remedies cost anything where few places look alike? The trials of Table II again, "
        "with all remedies: the paper's protocol, and a part of the drives.",
        success_elsewhere(results),
        *(
            f"{learned.capitalize()}, {which} the remedies: {goal_words(results.rows(name))}"
            for learned, names in ELSEWHERE.items()
            for which, name in zip(("without", "with"), names, strict=True)
        ),
        f"With all drives one loop corridor loses, no other building more than 2 points. With a "
        f"fifth of them {late[1]} of the trials run out of time with the remedies, "
        f"{late[0]} without. No single remedy is to blame: on validation worlds none that is left "
        f"out brings the loss back, nor do short detours in place of turns, looking around "
        f"before a plan from off the map, or a belief that must be half with a plan before it can "
        f"leave it, though four in five of the plans that a belief drops were right. The remedies "
        f"are for places that look alike, and off unless asked for.",
    ]


SECTIONS = (
    Section("Fig. 12: starts that look alike", (NAVIGATION,), _remedies_section),
    Section("A belief over vertices", (LOCALIZATION,), _filter_section),
    Section(
        "Table II with the remedies",
        tuple(remedied for _, remedied in ELSEWHERE.values()),
        _elsewhere_section,
    ),
)
