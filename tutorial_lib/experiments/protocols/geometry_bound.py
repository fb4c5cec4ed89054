"""How well geometry predicts an outcome: an upper bound for what images can predict."""

from typing import Any

import numpy as np

from tutorial_lib.driving.data.reachability_pairs import ReachabilityPairs
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.rollout_outcomes import RolloutOutcomes, load_outcomes
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.protocols.estimators import CONTROLLERS
from tutorial_lib.learning.outcome_data import recipe_of, record_outcomes
from tutorial_lib.learning.recipes import WORK, recorded_worlds_of
from tutorial_lib.se2 import Array, relative
from tutorial_lib.world.worlds import training_world

FITTED = tuple(range(300, 320))
"""Training worlds whose outcomes the model is fitted on."""
_TARGETS, _CARS = 200, 16


def features(recorded: RecordedWorld, pairs: ReachabilityPairs) -> Array:
    """(N, 10) what is given: where the target is, what is seen of it, and how tight it is."""
    goals, starts = recorded.poses[pairs.targets], pairs.starts
    scene, seen = recorded.scene, relative(starts, goals)
    sight = scene.caster.sees(starts[:, :2], goals[:, :2])
    room = [scene.clearance.at(poses[:, :2]) for poses in (starts, goals)]
    distance, bearing = np.hypot(seen[:, 0], seen[:, 1]), np.arctan2(seen[:, 1], seen[:, 0])
    columns = [distance, np.abs(bearing), np.abs(seen[:, 2]), seen[:, 0], seen[:, 1], sight, *room]
    return np.column_stack([*columns, pairs.overlap]).astype(float)


def fitted(controller: str, seeds: tuple[int, ...] = FITTED) -> Any:  # noqa: ANN401 - scikit-learn's model
    """A gradient-boosted model of a controller's outcomes, fitted on training worlds.

    Raises:
        InputError: where scikit-learn is not installed.
    """
    try:
        from sklearn.ensemble import HistGradientBoostingClassifier
    except ImportError as error:
        raise InputError("geometry: needs scikit-learn; pip install -e '.[test]'") from error
    worlds, weights = [training_world(seed) for seed in seeds], CONTROLLERS[controller]
    files = record_outcomes(worlds, weights, _TARGETS, _CARS, WORK)
    known = recipe_of(weights, _TARGETS, _CARS)
    outcomes: list[RolloutOutcomes] = [load_outcomes(file, known) for file in files]
    recorded = recorded_worlds_of(worlds, _CARS, WORK)
    given = [features(world, o.pairs) for world, o in zip(recorded, outcomes, strict=True)]
    model = HistGradientBoostingClassifier(max_iter=300, learning_rate=0.06, random_state=0)
    seen = np.concatenate([o.pairs.seen for o in outcomes])
    reached = np.concatenate([o.reached for o in outcomes])
    return model.fit(np.concatenate(given)[seen], reached[seen])
