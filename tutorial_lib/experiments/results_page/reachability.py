"""Reachability: how well each estimator predicts the outcome of a rollout."""

from __future__ import annotations

from statistics import fmean

from tutorial_lib.driving.data.reachability_pairs import FAR, SEEN
from tutorial_lib.experiments.common.report import Rows
from tutorial_lib.experiments.protocols.reachability import SURE
from tutorial_lib.experiments.results_page.markdown import (
    counted,
    number,
    number_interval,
    percent,
    table,
    with_best_bold,
)
from tutorial_lib.experiments.results_page.old_section import Section
from tutorial_lib.experiments.results_page.sources import RETIRED, Results, one

ESTIMATORS = {
    "k0": "RE, k = 0",
    "k2": "RE, k = 2",
    "k5": "RE, k = 5",
    "laser": "RE, laser, k = 2",
    "sptm": "SPTM's network",
    "image": "image similarity",
    "geometry": "true geometry",
}
KNOWING = ("geometry",)
"""Bounds, never the best."""


def discrimination(rows: Rows) -> str:
    """AUC and calibration error of every estimator."""
    found = [one(rows, estimator=name) for name in ESTIMATORS]
    auc, ece = (
        with_best_bold(
            [number_interval(row, key) for row in found],
            [None if row["estimator"] in KNOWING else row[key] for row in found],
            least=key == "ece",
        )
        for key in ("auc", "ece")
    )
    bound = [number(row["geometry_auc"]) for row in found]
    lines = zip(ESTIMATORS.values(), auc, bound, ece, strict=True)
    return table(
        ["estimator", "AUC", "AUC of the true geometry", "ECE"], [list(line) for line in lines]
    )


def precision(rows: Rows) -> str:
    """Share of sure predictions that come true, and of far pairs that are predicted likely."""
    lines = []
    for name, label in ESTIMATORS.items():
        row = one(rows, estimator=name)
        kinds = ("mix", "consecutive", "map")
        sure = [counted(row[f"precision_{kind}"], row[f"sure_{kind}"]) for kind in kinds]
        lines.append([label, *sure, counted(row["far_above_09"], row["far"], 2)])
    head = ["estimator", "mixed pairs", "consecutive anchors", "map edges", "far pairs above 0.9"]
    return table(head, lines)


def _section(results: Results) -> list[str]:
    rows = results.rows("calibration")
    best, laser, image, sptm = (one(rows, estimator=n) for n in ("k5", "laser", "image", "sptm"))
    return [
        f"Does RE predict whether C reaches a target (Sec. III-C of Meng 2020)? {best['pairs']:,} "
        f"pairs of start and target whose views overlap by {SEEN:g} or more, in "
        f"{results.worlds('calibration')} test worlds of all families by seed (apartments, "
        f"offices, halls, scans, mazes, loop corridors), each rolled out, without smoothing. "
        f"SPTM's network and image similarity are compared with the outcomes of C with k = 2, "
        f"each RE with those of its own C; *true geometry* is a model fitted to the true poses "
        f"and distances: about the most that can be known. The paper reports no such numbers.",
        discrimination(rows),
        f"RE is calibrated; SPTM's similarity is not a probability, and was not trained to be one "
        f"(ECE {number(sptm['ece'])}). Where RE with k = 5 is least sure, it predicts too much: "
        f"in the tenth of the pairs with the smallest predictions "
        f"{percent(best['predicted'][0])}, where {percent(best['measured'][0])} are reached.",
        f"How many of the predictions above {SURE:g} come true: on the same *mixed pairs*, from "
        f"an anchor to the next, and on random pairs of frames that a map would join. *Far pairs* "
        f"are more than {FAR:g} m apart without overlap; these should never be predicted likely.",
        precision(rows),
        f"A precision without its count misleads: above {SURE:g} image similarity is right in "
        f"{percent(image['precision_mix'])}, but it is that sure of {image['sure_mix']} pairs "
        f"only, RE with k = 5 of {best['sure_mix']:,}. Of RE's map edges the laser's are the worst "
        f"({percent(laser['precision_map'])}), and it predicts "
        f"{percent(laser['far_above_09'], 2)} of the far pairs likely: a scan without colours "
        f"looks alike in many places. How rollouts of far pairs end is measured by `experiment "
        f"calibration --ablation audit`.",
        _mirror(results),
    ]


def in_halls(everywhere: Rows, halls: Rows) -> str:
    """The figures of RE and of what it is compared with, in all families and in halls alone."""
    lines = []
    for estimator in ("k0", "k2", "k5", "laser", "sptm"):
        for worlds, rows in {"all families": everywhere, "halls": halls}.items():
            row = one(rows, estimator=estimator)
            lines.append(
                [
                    ESTIMATORS[estimator],
                    worlds,
                    number_interval(row, "auc"),
                    number(row["geometry_auc"]),
                    number_interval(row, "ece"),
                    counted(row["precision_mix"], row["sure_mix"]),
                    counted(row["far_above_09"], row["far"], 2),
                ]
            )
    sure = f"right above {SURE:g}"
    head = ["estimator", "worlds", "AUC", "of the true geometry", "ECE", sure, "far above 0.9"]
    return table(head, lines)


def _halls_section(results: Results) -> list[str]:
    laser = one(results.rows("calibration_hall"), estimator="laser")
    predicted, measured = (fmean(laser[name]) for name in ("predicted", "measured"))
    return [
        f"The same in {results.worlds('calibration_hall')} halls alone, where most of what is seen "
        f"is 5 to 20 m away.",
        in_halls(results.rows("calibration"), results.rows("calibration_hall")),
        f"Of all RE the laser's is calibrated worst there: on average it predicts "
        f"{percent(predicted)}, and {percent(measured)} are reached.",
    ]


def _mirror(results: Results) -> str:
    """What a second look would change, see `RETIRED`."""
    rows = results.rows("calibration_mirror")
    gains = [
        f"from {percent(one(rows, estimator=name, looks=1)['far_above_09'], 2)} to "
        f"{percent(one(rows, estimator=name, looks=2)['far_above_09'], 2)} with {words}"
        for name, words in {"k2": "k = 2", "k5": "k = 5"}.items()
    ]
    return (
        f"**Tried, and not kept:** a second look at each pair as in a mirror. For up to twice the "
        f"time, fewer far pairs are predicted likely: {gains[0]}, and {gains[1]} "
        f"(`calibration_mirror.json`; the code is gone)."
    )


SECTIONS = (
    Section("Calibration of reachability", ("calibration",), _section, RETIRED),
    Section("Calibration in halls", ("calibration_hall",), _halls_section),
)
