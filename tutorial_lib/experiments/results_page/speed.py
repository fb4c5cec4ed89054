"""Tables of speed: the closed loop, rollouts and queries, rays and images, fleets, exploration."""

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.results_page.exploring import AGENTS
from tutorial_lib.experiments.results_page.markdown import table
from tutorial_lib.experiments.results_page.tables import (
    Best,
    asked,
    called,
    column,
    listing,
    matching,
    of,
    pivot,
    table_of,
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
    (pymunk,) = pivot(rows, asked(method=["pymunk"]), asked(walls=walls), "{frames_per_s:,.0f}")
    ratio = Best("{ratio:,.1f} ×", "ratio")
    ratios = pivot(rows, asked(walls=walls), asked(method=RAYS), ratio)
    lines = [["pymunk, frames/s", *pymunk], *transposed([RAYS.values(), *ratios])]
    return table(["", *(f"{n:,} walls" for n in walls)], lines)


def closed_loop(rows: Rows) -> str:
    """Car-steps per second in closed loop, and the share of each stage."""
    return listing(
        matching(rows, stage="all"),
        ("cars", "{cars}"),
        ("car-steps/s", "{car_steps_per_s:,.0f}"),
        *((words, of(rows, "{share:.0%}", "cars", stage=stage)) for stage, words in STAGES.items()),
        ("network, targets kept", of(rows, "{plain_over_cached:,.1f} ×", "cars", stage="network")),
    )


queries = table_of(("what", "{name}"), ("per second", "{per_s:,.0f}"), names=("what", QUERIES))
"""Rollouts and queries of RE per second."""
fleets = table_of(
    ("physics", "{name}"),
    ("cars", "{cars}"),
    ("car-steps/s", Best("{steps_per_s:,.0f}", "steps_per_s")),
    ("ratio", "{ratio:,.1f} ×"),
    names=("method", SPACES),
)
"""Car-steps per second in one space, and in one space for each car."""
exploration = table_of(
    ("agent", called("agent", AGENTS)),
    ("sees with", called("model", MODELS)),
    ("actions/s", "{steps_per_s:,.0f}"),
)
"""Actions per second of exploring robots."""
