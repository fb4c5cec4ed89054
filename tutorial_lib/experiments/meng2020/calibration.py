"""Is reachability calibrated, and which estimator discriminates best (Meng 2020, III-C)?"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.common.statistics import measured_over_worlds, over_worlds
from tutorial_lib.experiments.meng2020 import calibration_audit
from tutorial_lib.experiments.protocols.estimators import CONTROLLERS
from tutorial_lib.experiments.protocols.geometry_bound import FITTED, fitted
from tutorial_lib.experiments.protocols.local_control import WORLDS
from tutorial_lib.experiments.protocols.reachability import SURE, Sizes, examine
from tutorial_lib.geometry import Array
from tutorial_lib.learning.calibration import auc, brier, reliability
from tutorial_lib.parallel import for_each

LIKELY = 0.9
"""Above this no far pair should be predicted."""
_BINS = 10


@dataclass(frozen=True)
class Settings:
    """Settings of the calibration table.

    Attributes:
        estimators: their rows; `k2` is among them, since that of geometry is compared with it.
        sizes: of the samples in each world.
        fitting: seeds of the worlds on which the bound by geometry is fitted.
    """

    estimators: tuple[str, ...] = ("k0", "k2", "k5", "laser", "sptm", "image")
    sizes: Sizes = field(default_factory=Sizes)
    fitting: tuple[int, ...] = FITTED


QUICK = Settings(
    estimators=("k2", "k5", "sptm", "image"),
    sizes=Sizes(targets=160, far=600, anchors=140, edges=50, consecutive=40),
)


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Query every estimator on the same pairs of each world, and roll them out."""
    names = settings.estimators
    controllers = tuple(dict.fromkeys(name for name in names if name in CONTROLLERS))
    bounds = {name: fitted(name, settings.fitting) for name in controllers}
    given = (names, bounds, settings.sizes, options.seed, options.family)
    found = for_each(examine, options.worlds, *given, label="calibration")
    rows = [estimator_row(name, [world[name] for world in found]) for name in names]
    rows.append(geometry_row([world["k2"] for world in found], rows[names.index("k2")]))
    note = (
        "auc, brier, ece, precision_mix: pairs with overlaps >= 0.1; geometry_auc: a model that is "
        "given the geometry, on the same pairs; precisions at RE > 0.99"
    )
    return rows, [note]


def estimator_row(name: str, parts: list[dict[str, Array]]) -> dict[str, Any]:
    """The row of an estimator, from what `examine` found of it in each world."""
    keys = ("predicted", "reached", "seen", "bound")
    predicted, reached, seen, bound = (_all(parts, key) for key in keys)
    worlds = np.repeat(np.arange(len(parts)), [len(part["predicted"]) for part in parts])
    predicted, reached, bound, worlds = (v[seen] for v in (predicted, reached, bound, worlds))
    diagram = reliability(predicted, reached, _BINS)
    row: dict[str, Any] = {"estimator": name, "pairs": int(seen.sum())}
    for key, measure in {"auc": auc, "ece": _ece}.items():
        row[key], row[f"{key}_low"], row[f"{key}_high"] = measured_over_worlds(
            measure, worlds, predicted, reached
        )
    row["brier"], row["geometry_auc"] = brier(predicted, reached), auc(bound, reached)
    sure = predicted > SURE
    precision = {
        "mix": (reached[sure], worlds[sure]),
        **{what: _gathered(parts, what) for what in ("consecutive", "edges")},
    }
    for what, (outcome, of_world) in precision.items():
        key = {"edges": "map"}.get(what, what)
        share = over_worlds(outcome, of_world) if len(outcome) else (None, None, None)
        row[f"precision_{key}"], row[f"precision_{key}_low"], row[f"precision_{key}_high"] = share
        row[f"sure_{key}"] = len(outcome)
    far = _all(parts, "far")
    row["far_above_09"], row["far"] = float((far > LIKELY).mean()), len(far)
    row["predicted"], row["measured"] = diagram.predicted.tolist(), diagram.measured.tolist()
    return row


def geometry_row(parts: list[dict[str, Array]], like: dict[str, Any]) -> dict[str, Any]:
    """The row of the model that is given the geometry, on the outcomes of k = 2."""
    seen = _all(parts, "seen")
    bound, reached = _all(parts, "bound")[seen], _all(parts, "reached")[seen]
    diagram = reliability(bound, reached, _BINS)
    row = dict.fromkeys(like) | {"estimator": "geometry", "pairs": int(seen.sum())}
    row |= {"auc": auc(bound, reached), "geometry_auc": auc(bound, reached)}
    row |= {"brier": brier(bound, reached), "ece": diagram.ece}
    sure = bound > SURE
    row |= {
        "precision_mix": reached[sure].mean() if sure.any() else None,
        "sure_mix": int(sure.sum()),
    }
    return row | {"predicted": diagram.predicted.tolist(), "measured": diagram.measured.tolist()}


def _ece(predicted: Array, reached: Array) -> float:
    return reliability(predicted, reached, _BINS).ece


def _all(parts: list[dict[str, Array]], key: str) -> NDArray[Any]:
    return np.concatenate([part[key] for part in parts])


def _gathered(parts: list[dict[str, Array]], key: str) -> tuple[Array, NDArray[np.intp]]:
    """The values of all worlds, and the world of each."""
    sizes = [len(part[key]) for part in parts]
    return _all(parts, key), np.repeat(np.arange(len(parts)), sizes)


EXPERIMENT = Experiment(
    "calibration",
    run,
    WORLDS,
    WORLDS[:10],
    Settings(),
    QUICK,
    canary=Settings(
        fitting=FITTED[:1], sizes=Sizes(targets=16, far=40, anchors=20, edges=4, consecutive=4)
    ),
    accepts=frozenset({"family"}),
    ablations={"audit": calibration_audit.EXPERIMENT},
)
