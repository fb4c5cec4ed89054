"""Navigation: Table II of Meng 2020, other maps and colours, thresholds."""

from __future__ import annotations

import math
from collections.abc import Collection

from tutorial_lib.driving.data.perturbation import PAPER_PERTURBATION
from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.protocols.navigation import FACING, GOAL_IMAGES, NEAR, WORMHOLE
from tutorial_lib.experiments.protocols.navigation_tasks import PLACES
from tutorial_lib.experiments.results_page import paper
from tutorial_lib.experiments.results_page.markdown import (
    Row,
    counted,
    interval,
    percent,
    points,
    span,
    table,
    with_best_bold,
)
from tutorial_lib.experiments.results_page.old_section import Section
from tutorial_lib.experiments.results_page.sources import (
    MAPS,
    Results,
    goal_words,
    matching,
    one,
)
from tutorial_lib.topology.mapping.edge_rules import MapSettings
from tutorial_lib.topology.planner import DijkstraPlanner

METHODS = {"meng": "Meng", "sptm": "SPTM", "random": "random", "oracle": "oracle"}
MAPPING = ("meng", "sptm")
"""Those with a map, one of which is the best."""
ENDINGS = {
    "wrong_place": "arrived elsewhere",
    "gave_up": "gave up",
    "stuck": "stuck",
    "late": "out of time",
}


def success_by_world(rows: Rows) -> str:
    """Success of every method in each world, and in all together."""
    lines = []
    for place in dict.fromkeys(row["world"] for row in rows):
        found = [one(rows, world=place, method=method) for method in METHODS]
        cells = [interval(row, "success") for row in found]
        lines.append([_world(found[0]), *_best_of_maps(cells, found)])
    if len(lines) > 1:
        totals = [total(rows, method) for method in METHODS]
        cells = [counted(row["success"], row["trials"]) for row in totals]
        lines.append(["all together", *_best_of_maps(cells, totals)])
    return table(["world", *METHODS.values()], lines)


def sizes_by_world(rows: Rows) -> str:
    """Vertices, edges and wormholes of the maps in each world."""
    lines = []
    for row in matching(rows, method="meng"):
        other = one(rows, world=row["world"], method="sptm")
        cells = [cell for found in (row, other) for cell in _size(found)]
        lines.append([_world(row), f"{row['images']:,}", *cells])
    head = ["world", "images"]
    for method in MAPPING:
        name = METHODS[method]
        head += [f"{name}: vertices", "edges", f"over {WORMHOLE:g} m"]
    return table(head, lines)


def papers_table() -> str:
    """Table II as the paper reports it."""
    lines = []
    for world in range(len(paper.AREAS)):
        line = [f"{paper.AREAS[world]} m²", f"{paper.IMAGES[world]:,}"]
        for method in MAPPING:
            size = f"{paper.VERTICES[method][world]:,} / {paper.EDGES[method][world]:,}"
            line += [percent(paper.SUCCESS[method][world]), size]
        lines.append(line)
    return table(["paper's world", "images", "Meng", "map", "SPTM", "map"], lines)


def failures(rows: Rows) -> str:
    """How the trials ended that did not succeed, by place and method."""
    lines = []
    for row in rows:
        if row["method"] in MAPPING:
            ends = [str(round(row[ending] * row["trials"])) for ending in ENDINGS]
            lines.append([_world(row), METHODS[row["method"]], f"{row['trials']}", *ends])
    return table(["world", "agent", "trials", *ENDINGS.values()], lines)


def thresholds(rows: Rows) -> str:
    """Success and map size for every threshold."""
    lines = [
        [
            METHODS[row["method"]],
            f"{row['threshold']:g}",
            "yes" if row["replans"] else "no",
            f"{row['vertices']:,}",
            f"{row['edges']:,}",
            f"{row['wormholes']:,}",
            counted(row["success"], row["trials"]),
        ]
        for row in rows
    ]
    head = ["agent", "threshold", "replans", "vertices", "edges", f"over {WORMHOLE:g} m", "success"]
    return table(head, lines)


def total(rows: Rows, method: str) -> Row:
    """Trials and success of a method in all worlds together."""
    found = matching(rows, method=method)
    trials = sum(row["trials"] for row in found)
    succeeded = sum(round(row["success"] * row["trials"]) for row in found)
    return {"method": method, "trials": trials, "success": succeeded / trials}


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


def _best_of_maps(cells: list[str], found: Rows) -> list[str]:
    judged = [row["success"] if row["method"] in MAPPING else None for row in found]
    return with_best_bold(cells, judged)


def _world(row: Row) -> str:
    if isinstance(row["world"], int):
        return f"{row['family'].replace('_', ' ')} {row['world']}, {row['area']:,} m²"
    return f"{row['world'].removesuffix('.yaml')}, {row['area']:,} m²"


def _size(row: Row) -> list[str]:
    return [f"{row[key]:,}" for key in ("vertices", "edges", "wormholes")]


def _table_2_section(results: Results) -> list[str]:
    rows = results.rows("meng_table2")
    meng, sptm = (total(rows, method) for method in MAPPING)
    times = total_vertices(rows, "sptm") / total_vertices(rows, "meng")
    by_world = gaps(rows, "meng", "sptm")
    return [
        f"Image-goal navigation between places (Table II of Meng 2020, Sec. IV-C.1): "
        f"{PLACES * (PLACES - 1)} recorded trajectories join {PLACES} places of a building "
        f"pairwise; then {rows[0]['trials']} trials in each building (the paper: "
        f"{paper.TRIALS:,}), from a start that is perturbed and unknown to a goal image that is "
        f"on no recorded trajectory. A trial succeeds when the agent declares arrival within "
        f"{NEAR:g} m and {math.degrees(FACING):.0f}° of the goal's pose. Both maps get the same "
        f"controller, follower and replanning; *random* drives at random until it recognises the "
        f"goal, the *oracle* knows everything. {goal_words(rows)} A start faces along the recorded "
        f"drive to this very goal; trials that start anywhere are under *a part of the drives*.",
        success_by_world(rows),
        sizes_by_world(rows),
        papers_table(),
        f"SPTM does as well here as Meng: {percent(sptm['success'])} for SPTM and "
        f"{percent(meng['success'])} for Meng, by world between {points(min(by_world))} and "
        f"{points(max(by_world))} for Meng; five worlds are too few for an interval. The paper's "
        f"SPTM has {span(paper.SUCCESS['sptm'])}. Three things favour ours. The protocol does: it "
        f"always keeps the first and the last frame of a recorded trajectory, a trial starts "
        f"beside such a first frame (σ = {PAPER_PERTURBATION.aside:g} m to the side), and its "
        f"goal image is taken some centimetres from such a last one, so that both ends of a trial "
        f"are almost on its map. Few views of this world look alike, so that its threshold leaves "
        f"hardly a wormhole (an edge over {WORMHOLE:g} m). And it has a controller that nearly "
        f"always arrives. What remains is the size: its map has {times:.1f} times as many "
        f"vertices as Meng's.",
        f"The sizes are not quite the paper's protocol: vertices, and edges, too, are reused above "
        f"p_reuse = {MapSettings().p_reuse:g}, where the paper has {paper.P_REUSE:g} and reuses "
        f"vertices alone, so that Meng's map is smaller; and it has edges by turning. How the "
        f"other trials ended:",
        failures(rows),
    ]


def _colours_section(results: Results) -> list[str]:
    shifted = results.rows("meng_table2_shifted")
    both = [percent(total(shifted, method)["success"]) for method in MAPPING]
    standard = total_vertices(results.rows("meng_table2"), places=[r["world"] for r in shifted])
    return [
        f"The same in {results.worlds('meng_table2_shifted')} of the buildings in colours that no "
        f"network was trained on. {goal_words(shifted)}",
        success_by_world(shifted),
        sizes_by_world(shifted),
        f"Success hardly changes ({both[0]} for Meng, {both[1]} for SPTM). Meng's maps have "
        f"{total_vertices(shifted):,} vertices in those buildings together; in the usual colours "
        f"{standard:,}.",
    ]


def _maps_section(results: Results) -> list[str]:
    maps = [row for name in MAPS for row in results.rows(f"meng_table2_{name}")]
    small = one(maps, world="tb3_sandbox.yaml", method="random")
    names = [
        f"{percent(row['success'])} on {name}, "
        f"{results.note(f'meng_table2_{name}', 'meng - sptm: ')} beside SPTM"
        for name, row in zip(MAPS, matching(maps, method="meng"), strict=True)
    ]
    return [
        f"The same on the three occupancy grids that come with Nav2, where nothing was tuned (one "
        f"world each; {small['trials']} trials; the intervals are Wilson's). {goal_words(maps)}",
        table_of_maps(maps),
        sizes_by_world(maps),
        failures(maps),
        f"Meng has {'; '.join(names)}. In the depot and the warehouse its maps are larger than "
        f"SPTM's: in the open RE is seldom as sure as between walls, so that anchors stand close. "
        f"Thinner maps were tried (thresholds that fall, fixed spacing, lower thresholds of "
        f"reuse): in the depot they had 540 to 1,835 vertices, and eight to nine points less. On "
        f"tb3_sandbox, which has only {small['area']} m², driving at random already succeeds in "
        f"{percent(small['success'])}, so that success there means less.",
    ]


def table_of_maps(rows: Rows) -> str:
    """Success of every method on maps from files, each of which is a world by itself."""
    lines = []
    for row in matching(rows, method="meng"):
        found = [one(rows, world=row["world"], method=method) for method in METHODS]
        cells = [interval(other, "success") for other in found]
        lines.append([_world(row), *_best_of_maps(cells, found)])
    return table(["map", *METHODS.values()], lines)


def _threshold_section(results: Results) -> list[str]:
    rows = results.rows("meng_table2_thresholds")
    ranges = {
        method: span([row["success"] for row in matching(rows, method=method)])
        for method in MAPPING
    }
    return [
        f"How much depends on the threshold above which two images are joined: p_edge of RE for "
        f"Meng, similarity for SPTM. {results.worlds('meng_table2_thresholds')} validation worlds "
        f"together, {rows[0]['trials']} trials; SPTM's threshold was chosen here. The paper has "
        f"{paper.P_REUSE:g} for both. {goal_words(rows)}",
        thresholds(rows),
        f"Success is {ranges['meng']} over RE's thresholds and {ranges['sptm']} over SPTM's, "
        f"which cover another range: a similarity is no probability, and the right threshold has "
        f"to be searched for.",
    ]


def goal_images(rows: Rows, others: Rows) -> str:
    """Success by what shows the goal and by p_goal, and what is refused.

    Args:
        rows: of trials in buildings whose drives were all learned.
        others: of the same after a tour.
    """
    lines = [
        [
            row["goal_images"],
            f"{row['p_goal']:g}",
            counted(row["success"], row["trials"]),
            counted(other["success_composed"], other["trials_composed"]),
            percent(row["refused"]),
            percent(row["refused_strange"]),
        ]
        for row in rows
        for other in [one(others, goal_images=row["goal_images"], p_goal=row["p_goal"])]
    ]
    success = ["success", "composed, after a tour"]
    return table(["goal", "p_goal", *success, "refused", "goals elsewhere refused"], lines)


def _goal_images_section(results: Results) -> list[str]:
    rows = results.rows("meng_table2_goal_images")
    used, clip = (one(rows, goal_images=i, p_goal=DijkstraPlanner().p_goal) for i in GOAL_IMAGES)
    return [
        f"One image of the goal, as in the paper (o_G, Sec. III-F), or a clip: the images of the "
        f"last 1.5 s of an oracle's drive to it, as the contexts of anchors are. One image is "
        f"repeated in place of its context. p_goal is RE from some vertex above which the goal "
        f"counts as on the map; {results.worlds('meng_table2_goal_images')} validation worlds, "
        f"goals of as many other buildings beside.",
        goal_images(rows, results.rows("meng_table2_goal_images_tour")),
        f"The planner has p_goal = {used['p_goal']:g}, the highest of those with the most "
        f"success to one image: {percent(used['success'])}, and {percent(clip['success'])} to a "
        f"clip.",
    ]


SECTIONS = (
    Section("Table II: navigation", ("meng_table2",), _table_2_section),
    Section("Table II in other colours", ("meng_table2_shifted",), _colours_section),
    Section(
        "Table II on maps from Nav2",
        tuple(f"meng_table2_{name}" for name in MAPS),
        _maps_section,
    ),
    Section(
        "Table II: one image, or a clip",
        ("meng_table2_goal_images", "meng_table2_goal_images_tour"),
        _goal_images_section,
    ),
    Section("Table II: thresholds", ("meng_table2_thresholds",), _threshold_section),
)
