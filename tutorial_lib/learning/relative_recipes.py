"""How LTVN's model is trained: analytic labels, and false pairs mined in the same buildings."""

import time
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from zlib import crc32

import numpy as np
import torch

from tutorial_lib.driving.data.perturbation import REACHABILITY_PERTURBATION
from tutorial_lib.driving.data.reachability_pairs import ReachabilityPairs, draw_reachability_pairs
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.rollout_outcomes import RolloutOutcomes
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.learning.analytic_label import AnalyticLabel
from tutorial_lib.learning.estimators import RelativeNetwork
from tutorial_lib.learning.mining import HardNegativeMining
from tutorial_lib.learning.networks import Architecture, LocalNetwork
from tutorial_lib.learning.reach_batches import LabelledWorld, OutcomeSource
from tutorial_lib.learning.reach_recipes import CALIBRATING, STOPPING, calibrate
from tutorial_lib.learning.recipes import recorded_worlds_of
from tutorial_lib.learning.training import Settings, train
from tutorial_lib.learning.weights import Card, load_card, load_network
from tutorial_lib.parallel import for_each
from tutorial_lib.world.worlds import training_world, validation_world

FIRST_WORLD, WORLDS = 120, 120
CARS = 16
TARGETS, VALIDATION_TARGETS = 1_500, 200
"""Of the pairs in each world, with five starts each: no robot has to drive for them."""
MINING = HardNegativeMining(frames=220, pairs=60, far_occluded=600, threshold=0.05)


@dataclass(frozen=True)
class RelativeRecipe:
    """All that LTVN's model comes from.

    Attributes:
        name: of the weights.
        command: that trains them.
        start: weights of the C_WP whose encoder initializes it.
        architecture: of the network.
        stages: settings of its trainings; pairs are mined before each but the first.
        mined: share of the targets that are taken from mined pairs.
        alone: share of the targets that have no context but their own image.
        label: of the pairs.
    """

    name: str
    command: str
    start: str
    architecture: Architecture
    stages: tuple[Settings, ...]
    mined: float = 0.3
    alone: float = 0.2
    label: AnalyticLabel = field(default_factory=AnalyticLabel)

    def checkpoints(self, work: Path) -> list[Path]:
        """Files of the states of its trainings."""
        return [work / f"{self.name}_{stage}.pt" for stage in range(len(self.stages))]


def _recipe(which: str, k: int, view: str, start: str, steps: tuple[int, ...]) -> RelativeRecipe:
    stages = tuple(
        Settings(max_steps=count, learning_rate=7e-4 if i else 2e-3, seed=i, patience=count)
        for i, count in enumerate(steps)
    )
    architecture = Architecture(k, view=view, outputs="relative")
    return RelativeRecipe(
        f"relative_{which}", f"train relative --k {which}", start, architecture, stages
    )


RELATIVE = {
    "0": _recipe("0", 0, "rgbd16", "waypoint_k0", (14_000, 6_000)),
    "5": _recipe("5", 5, "rgbd16", "waypoint_k5", (9_000, 5_000)),
    "rgb": _recipe("rgb", 5, "camera16", "waypoint_k5", (9_000, 5_000)),
}
"""What `train relative --k` can train: the paper's single images, in context, and without depth."""


def train_relative(recipe: RelativeRecipe, work: Path, jobs: int = 2) -> tuple[LocalNetwork, Card]:
    """Train LTVN's model, including its labels and mined pairs.

    Args:
        recipe: what to train.
        work: folder for demonstrations and checkpoints.
        jobs: processes that label.

    Returns:
        The network and its card, which holds its calibration.
    """
    begun = time.monotonic()
    worlds = [training_world(FIRST_WORLD + i) for i in range(WORLDS)]
    training = labelled(recorded_worlds_of(worlds, CARS, work), recipe.label, TARGETS, jobs)
    stopping = _validation(STOPPING, recipe, work, jobs)
    source = OutcomeSource(training, recipe.architecture, recipe.mined, alone=recipe.alone)
    others = replace(source, labelled=stopping, vary=False, targets=48, alone=0.0)
    validation = [others.block([0, i]) for i in range(2)]
    network = with_depth_row(load_network(recipe.start), recipe.architecture)
    spent, stages = time.monotonic() - begun, []
    for stage, settings in enumerate(recipe.stages):
        if stage:
            begun = time.monotonic()
            model = RelativeNetwork(network)
            mined = for_each(mined_in, training, model, recipe.label, label="mined", jobs=jobs)
            training = [replace(w, mined=m) for w, m in zip(training, mined, strict=True)]
            source = replace(source, labelled=training)
            spent += time.monotonic() - begun
        checkpoint = recipe.checkpoints(work)[stage]
        network, progress = train(
            recipe.architecture, source, validation, settings, checkpoint, init_from=network
        )
        stages.append(progress)
    begun = time.monotonic()
    calibration, measured = calibrate(
        RelativeNetwork(network), _validation(CALIBRATING, recipe, work, jobs)
    )
    spent += time.monotonic() - begun
    card = Card(
        recipe.name,
        recipe.command,
        recipe.architecture,
        recipe={
            "stages": [asdict(settings) for settings in recipe.stages],
            "start": load_card(recipe.start).sha256,
            **source.recipe,
        },
        validation={**stages[-1].history[stages[-1].best], **measured},
        calibration=asdict(calibration),
        minutes=round((spent + sum(progress.seconds for progress in stages)) / 60, 1),
    )
    return network, card


def labelled(
    recorded_worlds: list[RecordedWorld], label: AnalyticLabel, targets: int, jobs: int = 2
) -> list[LabelledWorld]:
    """Pairs in each world with their analytic labels."""
    outcomes = for_each(_labelled, recorded_worlds, label, targets, label="labels", jobs=jobs)
    return [LabelledWorld(*both) for both in zip(recorded_worlds, outcomes, strict=True)]


def _labelled(recorded: RecordedWorld, label: AnalyticLabel, targets: int) -> RolloutOutcomes:
    name = recorded.trajectories[0].world.encode()
    paths, rng = GridPaths(recorded.scene.clearance), np.random.default_rng(crc32(name))
    pairs = draw_reachability_pairs(recorded, paths, targets, rng, REACHABILITY_PERTURBATION)
    return by_label(recorded, pairs, label)


def by_label(
    recorded: RecordedWorld, pairs: ReachabilityPairs, label: AnalyticLabel
) -> RolloutOutcomes:
    """Pairs whose label stands in the place of a rollout's end; nobody drove."""
    reached = label(recorded.scene.caster, pairs, recorded.poses[pairs.targets])
    nobody = np.zeros(len(pairs), bool)
    return RolloutOutcomes(pairs, nobody, reached, nobody, np.zeros(len(pairs)))


def mined_in(world: LabelledWorld, model: RelativeNetwork, label: AnalyticLabel) -> RolloutOutcomes:
    """Pairs of one world that the model calls reachable, with their labels."""
    recorded = world.recorded
    paths, rng = GridPaths(recorded.scene.clearance), np.random.default_rng(len(recorded.poses))
    pairs, _ = MINING.find(model, recorded, paths, rng)
    return by_label(recorded, pairs, label)


def _validation(seeds: range, recipe: RelativeRecipe, work: Path, jobs: int) -> list[LabelledWorld]:
    recorded = recorded_worlds_of([validation_world(seed) for seed in seeds], CARS, work)
    return labelled(recorded, recipe.label, VALIDATION_TARGETS, jobs)


def with_depth_row(trained: LocalNetwork, architecture: Architecture) -> LocalNetwork:
    """The network, its first layer widened by a row of zeros where `architecture` sees depth.

    It then makes the same of the image, and learns what the depth adds.
    """
    rows = architecture.looks_at.size[1]
    widened = LocalNetwork(replace(trained.architecture, view=architecture.view))
    state = trained.state_dict()
    name = "encoder.rows.weight"
    missing = rows - state[name].shape[2]
    if missing:
        state[name] = torch.nn.functional.pad(state[name], (0, 0, 0, missing))
    widened.load_state_dict(state)
    return widened
