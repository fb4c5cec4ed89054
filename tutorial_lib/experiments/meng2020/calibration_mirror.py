"""Calibration with and without a mirror: is RE better when it looks at each pair twice?"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.protocols.estimators import CONTROLLERS, Estimator
from tutorial_lib.experiments.protocols.geometry_bound import FITTED, fitted
from tutorial_lib.experiments.protocols.local_control import WORLDS
from tutorial_lib.experiments.protocols.reachability import Sizes, examine_these
from tutorial_lib.experiments.protocols.reachability_rows import estimator_row
from tutorial_lib.learning.estimators import ReachabilityNetwork
from tutorial_lib.learning.networks import LocalNetwork
from tutorial_lib.learning.reach_recipes import (
    CALIBRATING,
    REACHABILITY,
    calibrate,
    labelled_worlds,
)
from tutorial_lib.learning.recipes import WORK
from tutorial_lib.learning.weights import load_network
from tutorial_lib.parallel import for_each
from tutorial_lib.world.worlds import validation_world


@dataclass(frozen=True)
class Settings:
    """Settings of the ablation.

    Attributes:
        names: of rows of the calibration table; each has one with one look, and one with two.
        sizes: of the samples in each world.
        calibrating: seeds of the validation worlds on which either is calibrated.
        fitting: seeds of the worlds on which the bound by geometry is fitted.
    """

    names: tuple[str, ...] = tuple(CONTROLLERS)
    sizes: Sizes = field(default_factory=lambda: Sizes(targets=160, edges=10, consecutive=20))
    calibrating: tuple[int, ...] = tuple(CALIBRATING)
    fitting: tuple[int, ...] = FITTED


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Query each network with one look and with two at the same pairs, and roll them out."""
    every: dict[tuple[str, int], Estimator] = {}
    for name in settings.names:
        every |= {(name, looks): found for looks, found in with_looks(name, settings).items()}
    bounds = {name: fitted(name, settings.fitting) for name in settings.names}
    given = (every, bounds, settings.sizes, options.seed, options.family)
    parts = for_each(examine_these, options.worlds, *given, label="mirror")
    rows = []
    for name, looks in every:
        row = estimator_row(name, [part[name, looks] for part in parts])
        rows.append({"looks": looks, **row})
    return rows, [f"each calibrated anew, in {len(settings.calibrating)} validation worlds"]


def with_looks(name: str, settings: Settings) -> dict[int, Estimator]:
    """The network of that row with one look at each pair and with two, either calibrated anew."""
    recipe = REACHABILITY[name.removeprefix("k")]
    validation = [validation_world(seed) for seed in settings.calibrating]
    worlds = labelled_worlds(recipe, validation, WORK, jobs=2)
    shipped, found = load_network(recipe.name), {}
    for looks in (1, 2):
        network = LocalNetwork(replace(shipped.architecture, mirror=looks == 2))
        network.load_state_dict(shipped.state_dict())
        calibration, _ = calibrate(ReachabilityNetwork(network.eval()), worlds)
        estimator = ReachabilityNetwork(network, calibration)
        found[looks] = Estimator(estimator, name, network.architecture.k)
    return found


EXPERIMENT = Experiment(
    "calibration_mirror",
    run,
    WORLDS,
    WORLDS[:10],
    Settings(),
    Settings(names=("k2",), sizes=Sizes(targets=80, far=300, anchors=60, edges=5, consecutive=10)),
    canary=Settings(
        fitting=FITTED[:1],
        sizes=Sizes(targets=16, far=40, anchors=20, edges=2, consecutive=4),
        calibrating=tuple(CALIBRATING)[:1],
    ),
    accepts=frozenset({"family"}),
)
