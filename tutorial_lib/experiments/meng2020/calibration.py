"""Is reachability calibrated, and which estimator discriminates best (Meng 2020, III-C)?"""

from __future__ import annotations

from dataclasses import dataclass, field

from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.meng2020 import calibration_audit
from tutorial_lib.experiments.protocols.estimators import CONTROLLERS
from tutorial_lib.experiments.protocols.geometry_bound import FITTED, fitted
from tutorial_lib.experiments.protocols.local_control import WORLDS
from tutorial_lib.experiments.protocols.reachability import Sizes, examine
from tutorial_lib.experiments.protocols.reachability_rows import estimator_row, geometry_row
from tutorial_lib.parallel import for_each


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
