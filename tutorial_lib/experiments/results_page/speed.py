"""Speed: the closed loop, rollouts and queries, rays and images, fleets, exploration."""

from __future__ import annotations

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.results_page.exploring import AGENTS
from tutorial_lib.experiments.results_page.markdown import number, percent, table, with_best_bold
from tutorial_lib.experiments.results_page.old_section import Section
from tutorial_lib.experiments.results_page.sources import Results, matching, one

RAYS = {
    "numpy": "numpy, vectorised",
    "numba": "rays, batches of 256",
    "numba_single": "rays, one pose at a time",
    "image16": "images 64 × 16",
    "image64": "images 64 × 64",
}
STAGES = {
    "sense": "cameras and lasers",
    "network": "network",
    "rmp": "motion policy",
    "move": "physics",
}


def rays(rows: Rows) -> str:
    """Frames per second of pymunk, and the others as multiples of it."""
    walls = list(dict.fromkeys(row["walls"] for row in rows))
    speed = [one(rows, method="pymunk", walls=n)["frames_per_s"] for n in walls]
    lines = [["pymunk, frames/s", *(number(s, 0) for s in speed)]]
    columns = []
    for n in walls:
        ratios = [one(rows, method=method, walls=n)["ratio"] for method in RAYS]
        columns.append(with_best_bold([f"{number(ratio, 1)} ×" for ratio in ratios], ratios))
    lines += [[label, *cells] for label, *cells in zip(RAYS.values(), *columns, strict=True)]
    return table(["", *(f"{n:,} walls" for n in walls)], lines)


def closed_loop(rows: Rows) -> str:
    """Car-steps per second in closed loop, and the share of each stage."""
    lines = []
    for cars in dict.fromkeys(row["cars"] for row in rows):
        found = matching(rows, cars=cars)
        shares = [percent(one(found, stage=stage)["share"], 0) for stage in STAGES]
        steps = number(one(found, stage="all")["car_steps_per_s"], 0)
        cached = number(one(found, stage="network")["plain_over_cached"], 1)
        lines.append([str(cars), steps, *shares, f"{cached} ×"])
    head = ["cars", "car-steps/s", *STAGES.values(), "network, targets kept"]
    return table(head, lines)


def queries(rows: Rows) -> str:
    """Rollouts and queries of RE per second."""
    found = {
        "rollouts": "rollouts",
        "cached": "queries, images encoded before",
        "plain": "queries, nothing encoded before",
    }
    lines = [[label, number(one(rows, what=what)["per_s"], 0)] for what, label in found.items()]
    return table(["what", "per second"], lines)


def fleets(rows: Rows) -> str:
    """Car-steps per second in one space, and in one space for each car."""
    found = {"fleet": "one space", "separate": "a space for each car"}
    picked = [one(rows, method=method) for method in found]
    speed = [row["steps_per_s"] for row in picked]
    cells = with_best_bold([number(value, 0) for value in speed], speed)
    lines = [
        [label, str(row["cars"]), cell, f"{number(row['ratio'], 1)} ×"]
        for label, row, cell in zip(found.values(), picked, cells, strict=True)
    ]
    return table(["physics", "cars", "car-steps/s", "ratio"], lines)


def _loop_section(results: Results) -> list[str]:
    rows = results.rows("control")
    largest = max(row["cars"] for row in rows)
    steps = one(rows, cars=largest, stage="all")["car_steps_per_s"]
    return [
        "Cars under visual control (C, k = 2) in closed loop, cameras, lasers and physics "
        "included: two threads, medians. *Targets kept* is how many times as fast the network is "
        "when targets are encoded once, rather than every pair by itself.",
        closed_loop(rows),
        f"{largest} cars make {number(steps, 0)} car-steps a second; the network takes most of it.",
    ]


def _query_section(results: Results) -> list[str]:
    note = results.note("reachability")
    row = one(results.rows("reachability"), what="cached")
    return [
        f"Rollouts for the labels of RE, and queries of RE ({note}).",
        queries(results.rows("reachability")),
        f"Kept embeddings make a query {number(row['over_plain'], 1)} times as fast.",
    ]


def _ray_section(results: Results) -> list[str]:
    rows = results.rows("raycast")
    most = max(row["walls"] for row in rows)
    slow = one(rows, method="numpy", walls=most)["ratio"]
    return [
        "Rays and images on the same random walls and poses: one thread, 64 rays over 120°, as "
        "multiples of a loop over pymunk's `segment_query_first`.",
        rays(rows),
        f"Plain numpy, which tests every wall, is slower than pymunk among many walls "
        f"({number(slow, 1)} × at {most:,}). Images are more than rays: pymunk is measured on "
        f"bare rays, so their ratios are too low rather than too high.",
    ]


def _fleet_section(results: Results) -> list[str]:
    note = results.note("fleet")
    return [
        "Cars of a fleet do not collide with each other, so they share one pymunk space.",
        fleets(results.rows("fleet")),
        f"{note[0].upper()}{note[1:]}.",
    ]


def _exploration_section(results: Results) -> list[str]:
    rows = results.rows("explore")
    names = {"geometry": "true geometry", "rgbd": "network, with depth", "rgb": "network, without"}
    lines = [
        [AGENTS[row["agent"]], names[row["model"]], number(row["steps_per_s"], 0)] for row in rows
    ]
    return [
        f"Actions per second of all robots together, {rows[0]['episodes']} episodes in lock-step "
        f"in one process with two threads, cameras included.",
        table(["agent", "sees with", "actions/s"], lines),
    ]


SECTIONS = (
    Section("Closed loop", ("control",), _loop_section),
    Section("Rollouts and queries", ("reachability",), _query_section),
    Section("Rays and images", ("raycast",), _ray_section),
    Section("Fleets", ("fleet",), _fleet_section),
    Section("Exploration", ("explore",), _exploration_section),
)
