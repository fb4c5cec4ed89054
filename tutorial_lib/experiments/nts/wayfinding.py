"""What knowing the goal is worth: models with perfect perception, in plain worlds and with signs.

Two gradient-boosted models choose among the directions of a place; one of them knows the goal's
picture. Where places mean nothing, it gains nothing by it.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.common.statistics import difference, over_worlds
from tutorial_lib.experiments.protocols.directions import (
    DIFFICULTIES,
    Decisions,
    decisions,
    regret_in,
)
from tutorial_lib.exploration.episodes import exploration_world
from tutorial_lib.geometry import Array
from tutorial_lib.learning.exploration_losses import WITHIN
from tutorial_lib.parallel import for_each
from tutorial_lib.world.generators import SIGNS
from tutorial_lib.world.worlds import scene_of


@dataclass(frozen=True)
class Settings:
    """Settings of the experiment.

    Attributes:
        fitted: training worlds, seeds 0 and up, on which the models are fitted.
    """

    fitted: int = 60


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Fit both models for each kind of signs, and let them choose in worlds not seen before."""
    rows: Rows = []
    for signs in SIGNS:
        seeds = [*range(settings.fitted), *options.worlds]
        found = for_each(_decisions, seeds, signs, options.seed, label=f"{signs} worlds")
        training, test = found[: settings.fitted], found[settings.fitted :]
        right = {}
        for model in ("blind", "goal"):
            scores = _scores(model, training, test)
            chosen = [regret_in(world, row) for world, row in zip(test, scores, strict=True)]
            regret = np.concatenate([metres for _, metres in chosen])
            right[model] = (regret <= WITHIN).astype(float)
        levels = np.concatenate([level for level, _ in chosen])  # the same for both
        worlds = np.repeat(options.worlds, [len(level) for level, _ in chosen])
        for number, difficulty in enumerate(DIFFICULTIES):
            mine = levels == number
            gained = difference(right["goal"][mine], right["blind"][mine], worlds[mine])
            for model, ok in right.items():
                top1, low, high = over_worlds(ok[mine], worlds[mine])
                gain = dict(zip(("gain", "gain_low", "gain_high"), gained, strict=True))
                rows.append(
                    {
                        "signs": signs,
                        "difficulty": difficulty,
                        "model": model,
                        "decisions": int(mine.sum()),
                        "top1": top1,
                        "low": low,
                        "high": high,
                    }
                    | (gain if model == "goal" else dict.fromkeys(gain))
                )
    return rows, [f"top1: the chosen direction's end is within {WITHIN} m of the best one's"]


def _decisions(seed: int, signs: str, drawn: int) -> Decisions:
    """The decisions of one world."""
    scene = scene_of(exploration_world(seed, signs))
    return decisions(scene, np.random.default_rng([drawn, seed]), signs=signs == "wayfinding")


def _scores(model: str, training: list[Decisions], test: list[Decisions]) -> list[Array]:
    """A fitted model's scores of the directions in each test world: metres that they gain."""
    given = _goal_too if model == "goal" else _here
    gained = np.concatenate([_gain(world) for world in training])
    fitted = _regressor().fit(np.concatenate([given(world) for world in training]), gained)
    return [fitted.predict(given(world)) for world in test]


def _gain(found: Decisions) -> Array:
    """(D,) by how many metres each direction is better than its decision's mean."""
    counts = np.bincount(found.number)
    return (np.bincount(found.number, found.metres) / counts)[found.number] - found.metres


def _here(found: Decisions) -> Array:
    return found.here


def _goal_too(found: Decisions) -> Array:
    return np.column_stack([found.here, found.goal])


def _regressor() -> Any:  # noqa: ANN401 - scikit-learn's model
    """A gradient-boosted model.

    Raises:
        InputError: where scikit-learn is not installed.
    """
    try:
        from sklearn.ensemble import HistGradientBoostingRegressor
    except ImportError as error:
        raise InputError("wayfinding: needs scikit-learn; pip install -e '.[test]'") from error
    return HistGradientBoostingRegressor(max_iter=200, learning_rate=0.06, random_state=0)


EXPERIMENT = Experiment(
    "nts_wayfinding",
    run,
    tuple(range(20_000, 20_020)),
    tuple(range(20_000, 20_006)),
    settings=Settings(),
    quick_settings=Settings(fitted=16),
    canary=Settings(fitted=2),
)
