"""Is reachability right as a probability, and who is right more often (Meng 2020, III-C)?"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.experiments.common.report import Options, Report
from tutorial_lib.experiments.common.statistics import measured_over_worlds, over_worlds
from tutorial_lib.experiments.meng2020 import calibration_audit
from tutorial_lib.experiments.protocols.estimators import CONTROLLERS
from tutorial_lib.experiments.protocols.geometry_bound import fitted
from tutorial_lib.experiments.protocols.local_control import WORLDS
from tutorial_lib.experiments.protocols.reachability import SURE, Sizes, examine
from tutorial_lib.geometry import Array
from tutorial_lib.learning.calibration import auc, brier, reliability
from tutorial_lib.parallel import for_each

LIKELY = 0.9
"""What no far pair may reach."""
ALL = ("k0", "k2", "k5", "laser", "sptm", "image")
_QUICK = ("k2", "k5", "sptm", "image")
_BINS = 10


FULL, QUICK = Sizes(), Sizes(targets=160, far=600, anchors=140, edges=50, consecutive=40)


def run(options: Options) -> Report:
    """Ask every estimator about the same errands of each world, and drive them."""
    begun = time.perf_counter()
    if options.ablation:
        return calibration_audit.run(options)
    worlds = options.worlds or (WORLDS[:10] if options.quick else WORLDS)
    names, sizes = (_QUICK, QUICK) if options.quick else (ALL, FULL)
    controllers = tuple(dict.fromkeys(name for name in names if name in CONTROLLERS))
    bounds = {name: fitted(name) for name in controllers}
    found = for_each(examine, worlds, names, bounds, sizes, options.seed, label="calibration")
    rows = [_row(name, [world[name] for world in found]) for name in names]
    rows.append(_geometry_row([world["k2"] for world in found], rows[names.index("k2")]))
    notes = (
        "auc, brier, ece, precision_mix: pairs with overlaps >= 0.1; geometry_auc: a model that is "
        "given the geometry, on the same pairs; precisions at RE > 0.99",
    )
    took = time.perf_counter() - begun
    return Report("calibration", options.seed, worlds, options.quick, took, rows, notes)


def _row(name: str, parts: list[dict[str, Array]]) -> dict[str, Any]:
    """One line of the table, from all worlds."""
    told, reached, seen, bound = (
        _all(parts, key) for key in ("predicted", "reached", "seen", "bound")
    )
    worlds = np.repeat(np.arange(len(parts)), [len(part["predicted"]) for part in parts])
    told, reached, bound, worlds = (values[seen] for values in (told, reached, bound, worlds))
    diagram = reliability(told, reached, _BINS)
    row: dict[str, Any] = {"estimator": name, "pairs": int(seen.sum())}
    for key, measure in {"auc": auc, "ece": _ece}.items():
        row[key], row[f"{key}_low"], row[f"{key}_high"] = measured_over_worlds(
            measure, worlds, told, reached
        )
    row["brier"], row["geometry_auc"] = brier(told, reached), auc(bound, reached)
    sure = told > SURE
    precision = {
        "mix": (reached[sure], worlds[sure]),
        **{what: _gathered(parts, what) for what in ("consecutive", "edges")},
    }
    for what, (came_true, where) in precision.items():
        key = {"edges": "map"}.get(what, what)
        share = over_worlds(came_true, where) if len(came_true) else (None, None, None)
        row[f"precision_{key}"], row[f"precision_{key}_low"], row[f"precision_{key}_high"] = share
        row[f"sure_{key}"] = len(came_true)
    far = _all(parts, "far")
    row["far_above_09"], row["far"] = float((far > LIKELY).mean()), len(far)
    row["predicted"], row["measured"] = diagram.predicted.tolist(), diagram.measured.tolist()
    return row


def _geometry_row(parts: list[dict[str, Array]], like: dict[str, Any]) -> dict[str, Any]:
    """The line of the model that is given the geometry, on the outcomes of k = 2."""
    seen = _all(parts, "seen")
    told, reached = _all(parts, "bound")[seen], _all(parts, "reached")[seen]
    diagram = reliability(told, reached, _BINS)
    row = dict.fromkeys(like) | {"estimator": "geometry", "pairs": int(seen.sum())}
    row |= {"auc": auc(told, reached), "geometry_auc": auc(told, reached)}
    row |= {"brier": brier(told, reached), "ece": diagram.ece}
    sure = told > SURE
    row |= {
        "precision_mix": reached[sure].mean() if sure.any() else None,
        "sure_mix": int(sure.sum()),
    }
    return row | {"predicted": diagram.predicted.tolist(), "measured": diagram.measured.tolist()}


def _ece(told: Array, reached: Array) -> float:
    return reliability(told, reached, _BINS).ece


def _all(parts: list[dict[str, Array]], key: str) -> NDArray[Any]:
    return np.concatenate([part[key] for part in parts])


def _gathered(parts: list[dict[str, Array]], key: str) -> tuple[Array, NDArray[np.intp]]:
    """The values of all worlds, and which world each is from."""
    sizes = [len(part[key]) for part in parts]
    return _all(parts, key), np.repeat(np.arange(len(parts)), sizes)
