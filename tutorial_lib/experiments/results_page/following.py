"""Tables of following a trajectory: Figs. 5, 6 and 7 of Meng 2020, and disturbances."""

import math

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.protocols.moves import ASIDE, TURNED
from tutorial_lib.experiments.results_page.markdown import Row, counted, interval
from tutorial_lib.experiments.results_page.tables import called, listing, matching, share, table_of
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
        return "".join(map(_cover_rate, matching(rows, condition="noise", **same)))

    return listing(
        matching(rows, condition="clean"),
        ("context", called("context", CONTEXTS)),
        ("anchors by", anchors_by),
        ("sparsity", "{sparsity:.3f}"),
        ("stored", "{stored:.3f}"),
        ("cover rate", _cover_rate),
        ("with noise", noisy),
    )


placement = table_of(
    ("context", called("context", CONTEXTS)),
    ("anchors", "{anchors:,}"),
    ("sparsity", "{sparsity:.3f}"),
    ("apart", "{metres:.2f} m"),
    *(
        (words, f"{{{key}:+.2f}} ({{{key}_low:+.2f}} to {{{key}_high:+.2f}})")
        for key, words in CORRELATIONS.items()
    ),
)
"""How densely anchors are kept, and where."""
one_rollout = table_of(
    ("place", "{place}"),
    ("time", "{seconds:.1f} s"),
    ("state", lambda row: row["state"].replace("_", " ")),
    ("active anchor", "{active} of {anchors}"),
    ("RE", "{probability:.3f}"),
)
"""The numbered places of one rollout."""
recoveries = table_of(
    ("disturbance", "{name}"),
    ("rollouts", "{trajectories}"),
    ("finished", lambda row: "" if row["disturbance"] == "carried" else share("finished")(row)),
    (f"lost within {SOON:g} s", share("soon")),
    ("lost in the end", lambda row: counted(row["lost"], row["trajectories"])),
    names=("disturbance", DISTURBANCES),
)
"""How rollouts go on after a disturbance; the kidnapped cannot finish."""


def _cover_rate(row: Row) -> str:
    return interval(row, "cover_rate")
