"""Tables of local control: Table I of Meng 2020, other worlds, ablations."""

from collections.abc import Mapping

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.results_page.markdown import percent, table
from tutorial_lib.experiments.results_page.tables import (
    Best,
    asked,
    called,
    column,
    named,
    one,
    pivot,
    success,
    table_of,
    transposed,
    without,
)

CONTROLLERS = {
    "random": "random waypoints",
    "direct": "direct control, k = 2",
    "k0": "C, k = 0",
    "k2": "C, k = 2",
    "k5": "C, k = 5",
    "laser": "C, laser, k = 2",
    "oracle": "oracle",
}
BOUNDS = ("oracle",)
"""Never the best, since they know what is asked for."""
CONDITIONS = {
    "clean": "clean",
    "noise": "noise",
    "obstacles": "two obstacles",
    "shifted": "shifted colours",
}
BREAKDOWN = {
    "success_behind": "target behind",
    "success_to_1m": "0 to 1 m ahead",
    "success_to_2m": "1 to 2 m",
    "success_to_3m": "2 to 3 m",
    "success_not_before_it": "over 60° aside",
    "success_little_overlap": "overlap below 0.1",
    "success_tight": "clearance below 0.3 m",
    "success_or_overlap": "all, or overlap",
}
VARIANTS = {
    "matching": "columns matched (as shipped)",
    "pair": "the paper's pair encoder, in small",
    "separate": "each image encoded alone",
    "stacked": "all images in one stack",
    "worlds4": "4 training worlds",
    "worlds12": "12 training worlds",
    "worlds48": "48 training worlds",
    "rows64": "64 rows of pixels, not 16",
}
BEST_SUCCESS = Best(success, without(BOUNDS, "controller", "success"))


def table_1(rows: Rows) -> str:
    """Success of each controller under each condition, beside the paper's."""
    clean = named(rows, "controller", CONTROLLERS, condition="clean")
    reported = [percent(row["paper"], 0) for row in clean]
    here = pivot(rows, asked(condition=CONDITIONS), asked(controller=CONTROLLERS), BEST_SUCCESS)
    head = ["controller", "paper, clean", *CONDITIONS.values()]
    return table(head, transposed([CONTROLLERS.values(), reported, *here]))


breakdown = table_of(
    ("controller, clean", "{name}"),
    *(
        (words, Best(f"{{{key}:.1%}}", without(BOUNDS, "controller", key)))
        for key, words in BREAKDOWN.items()
    ),
    ("collided", "{collided:.1%}"),
    names=("controller", CONTROLLERS),
    condition="clean",
)
"""Success of each controller in the clean condition, by where the target is."""
variants = table_of(
    ("variant", called("variant", VARIANTS)),
    ("parameters", "{parameters:,}"),
    ("training worlds", "{worlds}"),
    ("median error of a waypoint", Best("{median_m:.2f} m", "median_m", least=True)),
    ("reached", Best(success, "success")),
)
"""Success of each variant of an ablation, and the error of its waypoints."""


def on_maps(maps: Mapping[str, Rows], condition: str) -> str:
    """Success of each controller in different worlds, under one condition."""
    head, columns = [f"controller, {CONDITIONS[condition]}"], [CONTROLLERS.values()]
    for name, rows in maps.items():
        episodes = one(rows, controller="oracle", condition=condition)["episodes"]
        head.append(f"{name}, {episodes} episodes")
        across = asked(controller=CONTROLLERS)
        columns += pivot(rows, asked(condition=[condition]), across, BEST_SUCCESS)
    return table(head, transposed(columns))


def smoothing(worlds: Mapping[str, Rows]) -> str:
    """Success of each controller by the worlds, and by the share of the newest waypoint."""
    rows = next(iter(worlds.values()))
    controllers, shares = (dict.fromkeys(column(rows, key)) for key in ("controller", "share"))
    lines = [[CONTROLLERS[name]] for name in controllers]
    for found in worlds.values():
        both = asked(controller=controllers), asked(share=shares)
        for line, cells in zip(lines, pivot(found, *both, Best(success, "success")), strict=True):
            line += cells
    head = [f"{name}, share {share:g}" for name in worlds for share in shares]
    return table(["controller", *head], lines)
