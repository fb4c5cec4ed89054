"""Tables of speed: the closed loop, rollouts and queries, rays and images, fleets, exploration."""

from __future__ import annotations

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.results_page.exploring import AGENTS
from tutorial_lib.experiments.results_page.markdown import Row, table
from tutorial_lib.experiments.results_page.tables import (
    Best,
    Text,
    by,
    column,
    listing,
    matching,
    named,
    one,
    pivot,
    transposed,
)

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
QUERIES = {
    "rollouts": "rollouts",
    "cached": "queries, images encoded before",
    "plain": "queries, nothing encoded before",
}
SPACES = {"fleet": "one space", "separate": "a space for each car"}
MODELS = {"geometry": "true geometry", "rgbd": "network, with depth", "rgb": "network, without"}


def rays(rows: Rows) -> str:
    """Frames per second of pymunk, and the others as multiples of it."""
    walls = dict.fromkeys(column(rows, "walls"))
    (pymunk,) = pivot(rows, [{"method": "pymunk"}], by("walls", walls), "{frames_per_s:,.0f}")
    ratio = Best("{ratio:,.1f} ×", "ratio")
    ratios = pivot(rows, by("walls", walls), by("method", RAYS), ratio)
    lines = [["pymunk, frames/s", *pymunk], *transposed([RAYS.values(), *ratios])]
    return table(["", *(f"{n:,} walls" for n in walls)], lines)


def closed_loop(rows: Rows) -> str:
    """Car-steps per second in closed loop, and the share of each stage."""

    def share(stage: str) -> Text:
        return lambda row: f"{one(rows, cars=row['cars'], stage=stage)['share']:.0%}"

    def kept(row: Row) -> str:
        network = one(rows, cars=row["cars"], stage="network")
        return f"{network['plain_over_cached']:,.1f} ×"

    return listing(
        matching(rows, stage="all"),
        ("cars", "{cars}"),
        ("car-steps/s", "{car_steps_per_s:,.0f}"),
        *((words, share(stage)) for stage, words in STAGES.items()),
        ("network, targets kept", kept),
    )


def queries(rows: Rows) -> str:
    """Rollouts and queries of RE per second."""
    return listing(named(rows, "what", QUERIES), ("what", "{name}"), ("per second", "{per_s:,.0f}"))


def fleets(rows: Rows) -> str:
    """Car-steps per second in one space, and in one space for each car."""
    return listing(
        named(rows, "method", SPACES),
        ("physics", "{name}"),
        ("cars", "{cars}"),
        ("car-steps/s", Best("{steps_per_s:,.0f}", "steps_per_s")),
        ("ratio", "{ratio:,.1f} ×"),
    )


def exploration(rows: Rows) -> str:
    """Actions per second of exploring robots."""
    return listing(
        rows,
        ("agent", lambda row: AGENTS[row["agent"]]),
        ("sees with", lambda row: MODELS[row["model"]]),
        ("actions/s", "{steps_per_s:,.0f}"),
    )
