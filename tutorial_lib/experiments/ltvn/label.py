"""LTVN's analytic label against rollouts: which of its conditions tell whether a car arrives.

The controller drives to the target's true position. It arrives where it gets within `REACHED`, and
arrives facing as the target does where the heading is within `FACING` besides.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.driving.data.perturbation import REACHABILITY_PERTURBATION
from tutorial_lib.driving.data.reachability_pairs import draw_reachability_pairs
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.driving.rollouts import ReachGoals, rollout
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.common.statistics import over_worlds
from tutorial_lib.experiments.protocols.navigation import FACING
from tutorial_lib.experiments.protocols.navigation_tasks import make_building
from tutorial_lib.interfaces import Observation, Robots
from tutorial_lib.learning.analytic_label import AnalyticLabel
from tutorial_lib.parallel import for_each
from tutorial_lib.se2 import Array, to_local, wrap
from tutorial_lib.world.simulation import Simulation

ARC = 0.7
"""rad off one arc in the stricter label, see `AnalyticLabel`."""
LABELS = {
    "label": AnalyticLabel(),
    "label, arc": AnalyticLabel(arc=ARC),
    "label, yaw 30": AnalyticLabel(yaw=float(np.deg2rad(30.0))),
}


@dataclass(frozen=True)
class Settings:
    """Settings of the experiment.

    Attributes:
        targets: in each world, with five starts each.
    """

    targets: int = 200


@dataclass(frozen=True)
class _Straight:
    """Drives to true positions."""

    simulation: Simulation
    goals: Array
    controller: RMPController

    def act(self, observations: Observation, robots: Robots) -> Array:
        """Actions (M, 2)."""
        poses = self.simulation.poses[robots]
        return self.controller.act(observations, to_local(poses, self.goals[robots, :2]))


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Drive the pairs that are near each other, and count by each condition."""
    parts = for_each(driven, options.worlds, options.seed, settings, label="ltvn_label")
    worlds = np.repeat(options.worlds, [len(part["arrives"]) for part in parts])
    columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    rows = []
    for name in columns:
        if name in ("arrives", "faces"):
            continue
        for holds in (True, False):
            some = columns[name] == holds
            if some.any():
                rows.append(_row(name, holds, columns, some, worlds))
    return rows, [
        f"pairs within {LABELS['label'].distance:g} m; arrives: within 0.3 m of the position",
        f"faces: arrives, and within {np.rad2deg(FACING):.0f} degrees of the heading",
    ]


def _row(
    name: str,
    holds: bool,
    columns: dict[str, NDArray[np.bool_]],
    some: NDArray[np.bool_],
    worlds: NDArray[np.intp],
) -> dict[str, Any]:
    row: dict[str, Any] = {"term": name, "holds": holds, "pairs": int(some.sum())}
    for end in ("arrives", "faces"):
        share, low, high = over_worlds(columns[end][some].astype(float), worlds[some])
        row |= {end: share, f"{end}_low": low, f"{end}_high": high}
    return row


def driven(world: int, seed: int, settings: Settings) -> dict[str, NDArray[np.bool_]]:
    """Of N pairs of one world whether each condition holds, and how the rollout ended."""
    recorded = make_building(world, seed).recorded
    paths, rng = GridPaths(recorded.scene.clearance), np.random.default_rng([seed, world, 8])
    pairs = draw_reachability_pairs(
        recorded, paths, settings.targets, rng, REACHABILITY_PERTURBATION
    )
    caster, label = recorded.scene.caster, LABELS["label, arc"]
    goals = recorded.poses[pairs.targets]
    near = np.flatnonzero(label.terms(caster, pairs, goals)["distance"])
    pairs, goals = pairs.subset(near), goals[near]
    simulation = Simulation(recorded.scene, pairs.starts)
    policy = _Straight(simulation, goals, RMPController())
    found = rollout(simulation, policy, ReachGoals(goals[:, :2], pairs.limit, settle=True))
    last = found.last_poses
    faces = found.reached & (np.abs(wrap(last[:, 2] - goals[:, 2])) <= FACING)
    columns = {"all": np.ones(len(near), bool), **label.terms(caster, pairs, goals)}
    columns |= {name: one(caster, pairs, goals) for name, one in LABELS.items()}
    return columns | {"arrives": found.reached, "faces": faces}


EXPERIMENT = Experiment(
    "ltvn_label",
    run,
    tuple(range(20_000, 20_010)),
    tuple(range(20_000, 20_004)),
    settings=Settings(),
    quick_settings=Settings(targets=60),
    canary=Settings(targets=12),
)
