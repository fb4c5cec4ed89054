"""The check of the training loop, in notebook 02: what it does with a network."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.answers import beside
from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.topics import attempt
from tutorial_lib.checks.nb02.training_mistakes import mistake
from tutorial_lib.geometry import Array
from tutorial_lib.learning.small_training import TrainingPlan, train_network
from tutorial_lib.learning.training_probe import trace

Case = tuple[TrainingPlan, Array, list[float]]
"""The plan, the gradient of each step's batch, and the validation losses."""
_FALLING = [9.0, 8.0, 7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0]


def _plan(
    steps: int, interval: int, warmup: int = 1, norm: float = 1e9, patience: int = 99
) -> TrainingPlan:
    return TrainingPlan(steps, 0.1, warmup, norm, interval, patience)


def _cases() -> dict[str, Case]:
    rng = np.random.default_rng(11)
    gradients = rng.normal(size=(60, 3))
    strong = gradients * np.array([0.2, 5.0, 0.5] * 20)[:, None]
    rising = [5.0, 3.0, 4.0, 4.5, 4.0, 6.0]
    cases: dict[str, Case] = {
        "8 steps, evaluated every 4": (_plan(8, 4, warmup=2), gradients, _FALLING),
        "a warm-up of 4 steps": (_plan(8, 4, warmup=4), gradients, _FALLING),
        "gradients of which some are too long": (_plan(12, 4, norm=1.0), strong, _FALLING),
        "10 steps, evaluated every 4": (_plan(10, 4), gradients, _FALLING),
        "3 steps, evaluated every 4": (_plan(3, 4), gradients, _FALLING),
        "a validation loss that rises again": (_plan(12, 2), gradients, rising),
        "two evaluations that are equally good": (_plan(8, 2), gradients, [5, 3, 3, 4]),
        "losses in the hundreds, and one that is hardly better": (
            _plan(8, 2),
            gradients,
            [500.0, 300.0, 299.9995, 400.0],
        ),
        "a patience of 2": (_plan(20, 2, patience=2), gradients, [5, 3, 4, 4.5, 1, 1]),
        "a patience of 2, and now and then a new best": (
            _plan(20, 2, patience=2),
            gradients,
            [5, 6, 4, 4.5, 3, 3, 3.5, 1, 1],
        ),
        "a patience of 1": (_plan(12, 3, patience=1), gradients, [5, 4, 4, 1]),
        "a learning rate of 0.001": (
            TrainingPlan(8, 0.001, 2, 1e9, 4, 99),
            gradients,
            _FALLING,
        ),
        "a plan that ends before its warm-up": (_plan(6, 2, warmup=20), gradients, _FALLING),
    }
    for i in range(12):
        plan = TrainingPlan(
            int(rng.integers(1, 30)),
            float(rng.uniform(0.01, 1)),
            int(rng.integers(1, 12)),
            float(rng.uniform(0.3, 4)),
            int(rng.integers(1, 7)),
            int(rng.integers(1, 5)),
        )
        losses = rng.integers(1, 9, 30).astype(float).tolist()
        cases[f"random plan {i + 1}, {plan}"] = (plan, strong, losses)
    return cases


def _example() -> tuple:
    """A training to measure functions with, as the arguments of one call."""
    kept: list[tuple] = []
    plan, gradients, losses = _cases()["a warm-up of 4 steps"]
    trace(lambda *arguments: kept.append(arguments), plan, gradients, losses)
    return kept[0]


@check(
    train_network,
    _example(),
    calls=1,
    endless="Your training has not ended after {seconds:g} seconds. Does it stop at max_steps?",
)
def check_train_network(student: Callable[..., Any]) -> None:
    """Batches, learning rates, gradients, evaluations, the end, and the weights that are kept."""
    for about, case in _cases().items():
        what = f"train_network, {about}"
        words = "follow the seven rules above, one after the other"
        got = attempt(what, words, partial(beside(trace), student), *case)
        wrong = mistake(got, trace(train_network, *case), *case[:2])
        if wrong:
            raise WrongAnswer(f"{what}: {wrong}")
