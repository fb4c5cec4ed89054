"""Ablations of local control: encoders, worlds, rows of pixels; and smoothed waypoints."""

from __future__ import annotations

import math

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.results_page.local_control import CONTROLLERS
from tutorial_lib.experiments.results_page.markdown import (
    interval,
    listed,
    number,
    table,
    with_best_bold,
)
from tutorial_lib.experiments.results_page.section import Section
from tutorial_lib.experiments.results_page.sources import MAPS, Results, one

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


SMOOTHING = ("ablation_smoothing", *(f"ablation_smoothing_{name}" for name in ("hall", *MAPS)))
"""Reports of generated worlds, halls and maps."""


def variants(rows: Rows) -> str:
    """Success of each variant of an ablation, and the error of its waypoints."""
    success = [interval(row, "success") for row in rows]
    error = [f"{number(row['median_m'], 2)} m" for row in rows]
    columns = [
        [VARIANTS[row["variant"]] for row in rows],
        [f"{row['parameters']:,}" for row in rows],
        [f"{row['worlds']}" for row in rows],
        with_best_bold(error, [row["median_m"] for row in rows], least=True),
        with_best_bold(success, [row["success"] for row in rows]),
    ]
    head = ["variant", "parameters", "training worlds", "median error of a waypoint", "reached"]
    return table(head, [list(line) for line in zip(*columns, strict=True)])


def smoothing(worlds: dict[str, Rows]) -> str:
    """Success of each controller by the worlds, and by the share of the newest waypoint."""
    rows = next(iter(worlds.values()))
    shares = [row["share"] for row in rows if row["controller"] == rows[0]["controller"]]
    lines = []
    for controller in dict.fromkeys(row["controller"] for row in rows):
        line = [CONTROLLERS[controller]]
        for rows_there in worlds.values():
            found = [one(rows_there, controller=controller, share=share) for share in shares]
            success = [interval(row, "success") for row in found]
            line += with_best_bold(success, [row["success"] for row in found])
        lines.append(line)
    head = [f"{name}, share {share:g}" for name in worlds for share in shares]
    return table(["controller", *head], lines)


def _ablation_section(results: Results) -> list[str]:
    encoder, worlds, rows = (f"ablation_{name}" for name in ("encoder", "worlds", "rows"))
    first = results.rows(encoder)[0]
    minutes = [row["minutes"] for name in (encoder, worlds, rows) for row in results.rows(name)]
    return [
        f"Ablations of C with k = 2, not smoothed, on the clean episodes of Table I "
        f"({first['episodes']:,} in {results.worlds(encoder)} test worlds): how the two images "
        f"are compared, how many worlds are trained in, and how many rows of pixels the camera "
        f"has. Each variant is trained once for {math.floor(min(minutes))} to "
        f"{math.ceil(max(minutes))} minutes, less than the networks that are shipped; the times "
        f"below leave out what was trained before.",
        variants(results.rows(encoder)),
        f"Matched columns over the paper's pair encoder, at about the same size: "
        f"{results.note(encoder, 'matching - pair: ')}. It is the paper's in small, for images of "
        f"16 rows: Fig. 3 there has about 8.5 million parameters. Whether its full size or longer "
        f"training closes the gap is not measured.",
        variants(results.rows(worlds)),
        f"The number of worlds makes little difference, each trained once: 4 over 12 worlds "
        f"{results.note(worlds, 'worlds4 - worlds12: ')}, 4 over 48 "
        f"{results.note(worlds, 'worlds4 - worlds48: ')}.",
        variants(results.rows(rows)),
        f"With four times the rows of pixels: 16 over 64 rows "
        f"{results.note(rows, 'matching - rows64: ')}, each trained once.",
    ]


def _smoothing_section(results: Results) -> list[str]:
    generated = {"homes and offices": SMOOTHING[0], "halls": SMOOTHING[1]}
    maps = dict(zip(MAPS, SMOOTHING[2:], strict=True))
    rows = results.rows(SMOOTHING[0])
    usual, share = (choose(row["share"] for row in rows) for choose in (max, min))
    gains = [results.note(name, f"k5: {share:g} - {usual:g}: ") for name in SMOOTHING]
    return [
        f"C_WP predicts each waypoint from one image. C of Table I drives to a moving average of "
        f"these predictions (not in the paper), kept by the wheel odometry, which drifts. *Share* "
        f"is that of the newest one: {share:g} in Table I; with {usual:g}, as in the paper, "
        f"nothing is smoothed. Clean episodes in {results.worlds(SMOOTHING[0])} test worlds, "
        f"{results.worlds(SMOOTHING[1])} halls and the maps from Nav2; the share was chosen on "
        f"validation worlds.",
        smoothing({words: results.rows(name) for words, name in generated.items()}),
        smoothing({name: results.rows(stored) for name, stored in maps.items()}),
        f"With k = 5 smoothing makes little difference in homes and offices, {gains[0]}, but some "
        f"where space is open and a single image says least about what is a few decimetres away: "
        f"in halls {gains[1]}, and {listed(gains[2:])} on the maps. RE learned "
        f"from rollouts without it, and all that follows on this page is without it.",
    ]


SECTIONS = (
    Section(
        "Table I: ablations",
        ("ablation_encoder", "ablation_worlds", "ablation_rows"),
        _ablation_section,
    ),
    Section(
        "Table I: smoothed waypoints",
        SMOOTHING,
        _smoothing_section,
    ),
)
