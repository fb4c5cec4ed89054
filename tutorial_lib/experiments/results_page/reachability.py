"""Tables of reachability: how well each estimator predicts the outcome of a rollout."""

from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.protocols.reachability import SURE
from tutorial_lib.experiments.results_page.markdown import number_interval
from tutorial_lib.experiments.results_page.tables import (
    Best,
    listing,
    named,
    part,
    table_of,
    without,
)

ESTIMATORS = {
    "k0": "RE, k = 0",
    "k2": "RE, k = 2",
    "k5": "RE, k = 5",
    "laser": "RE, laser, k = 2",
    "sptm": "SPTM's network",
    "image": "image similarity",
    "geometry": "true geometry",
}
FAR_ABOVE = part("far_above_09", "far", digits=2)
KNOWING = ("geometry",)
"""Bounds, never the best."""
PRECISION = {"mix": "mixed pairs", "consecutive": "consecutive anchors", "map": "map edges"}
"""Pairs about which an estimator is sure."""


def _best(key: str) -> Best:
    judged = without(KNOWING, "estimator", key)
    return Best(lambda row: number_interval(row, key), judged, least=key == "ece")


discrimination = table_of(
    ("estimator", "{name}"),
    ("AUC", _best("auc")),
    ("AUC of the true geometry", "{geometry_auc:.3f}"),
    ("ECE", _best("ece")),
    names=("estimator", ESTIMATORS),
)
"""AUC and calibration error of every estimator."""
precision = table_of(
    ("estimator", "{name}"),
    *((words, part(f"precision_{kind}", f"sure_{kind}")) for kind, words in PRECISION.items()),
    ("far pairs above 0.9", FAR_ABOVE),
    names=("estimator", ESTIMATORS),
)
"""Share of sure predictions that come true, and of far pairs that are predicted likely."""


def in_halls(everywhere: Rows, halls: Rows) -> str:
    """The figures of RE and of what it is compared with, in all families and in halls alone."""
    names = {key: ESTIMATORS[key] for key in ("k0", "k2", "k5", "laser", "sptm")}
    both = (
        [row | {"worlds": worlds} for row in named(rows, "estimator", names)]
        for worlds, rows in {"all families": everywhere, "halls": halls}.items()
    )
    return listing(
        [row for pair in zip(*both, strict=True) for row in pair],
        ("estimator", "{name}"),
        ("worlds", "{worlds}"),
        ("AUC", lambda row: number_interval(row, "auc")),
        ("of the true geometry", "{geometry_auc:.3f}"),
        ("ECE", lambda row: number_interval(row, "ece")),
        (f"right above {SURE:g}", part("precision_mix", "sure_mix")),
        ("far above 0.9", FAR_ABOVE),
    )
