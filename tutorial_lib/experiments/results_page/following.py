"""Tables of following a trajectory: Figs. 5, 6 and 7 of Meng 2020, and disturbances."""

from __future__ import annotations

import math

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.protocols.moves import ASIDE, TURNED
from tutorial_lib.experiments.results_page.markdown import Row, counted, interval
from tutorial_lib.experiments.results_page.tables import listing, matching, named
from tutorial_lib.experiments.robustness.disturbances import SOON

CONTEXTS = {"k0": "k = 0", "k2": "k = 2", "k5": "k = 5", "laser": "laser, k = 2"}
DISTURBANCES = {
    "none": "none",
    "pushed": f"pushed {ASIDE:g} m aside",
    "turned": f"turned by {math.degrees(TURNED):.0f}°",
    "person": "a person walks across",
    "carried": "kidnapped out of sight",
}
CORRELATIONS = {"with_clearance": "ρ with clearance", "with_turn": "ρ with turning"}


def anchors_by(row: Row) -> str:
    """How the anchors of a row were chosen.

    >>> anchors_by({"method": "sptm", "threshold": 20})
    'SPTM: every 20th frame'
    """
    if row["method"] == "sptm":
        return f"SPTM: every {row['threshold']}th frame"
    return f"RE above {row['threshold']:g}"


def cover_rates(rows: Rows) -> str:
    """Cover rate and sparsity for every choice of anchors, with actuation noise where driven."""

    def noisy(row: Row) -> str:
        same = {key: row[key] for key in ("method", "context", "threshold")}
        return "".join(
            interval(found, "cover_rate") for found in matching(rows, condition="noise", **same)
        )

    return listing(
        matching(rows, condition="clean"),
        ("context", _context),
        ("anchors by", anchors_by),
        ("sparsity", "{sparsity:.3f}"),
        ("stored", "{stored:.3f}"),
        ("cover rate", lambda row: interval(row, "cover_rate")),
        ("with noise", noisy),
    )


def placement(rows: Rows) -> str:
    """How densely anchors are kept, and where."""
    return listing(
        rows,
        ("context", _context),
        ("anchors", "{anchors:,}"),
        ("sparsity", "{sparsity:.3f}"),
        ("apart", "{metres:.2f} m"),
        *(
            (words, f"{{{key}:+.2f}} ({{{key}_low:+.2f}} to {{{key}_high:+.2f}})")
            for key, words in CORRELATIONS.items()
        ),
    )


def one_rollout(rows: Rows) -> str:
    """The numbered places of one rollout."""
    return listing(
        rows,
        ("place", "{place}"),
        ("time", "{seconds:.1f} s"),
        ("state", lambda row: row["state"].replace("_", " ")),
        ("active anchor", "{active} of {anchors}"),
        ("RE", "{probability:.3f}"),
    )


def recoveries(rows: Rows) -> str:
    """How rollouts go on after a disturbance; the kidnapped cannot finish."""
    return listing(
        named(rows, "disturbance", DISTURBANCES),
        ("disturbance", "{name}"),
        ("rollouts", "{trajectories}"),
        (
            "finished",
            lambda row: (
                ""
                if row["disturbance"] == "carried"
                else interval(row, "finished", "finished_low", "finished_high")
            ),
        ),
        (f"lost within {SOON:g} s", _soon),
        ("lost in the end", lambda row: counted(row["lost"], row["trajectories"])),
    )


def _context(row: Row) -> str:
    return CONTEXTS[row["context"]]


def _soon(row: Row) -> str:
    return interval(row, "soon", "soon_low", "soon_high")
