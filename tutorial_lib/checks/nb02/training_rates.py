"""Where the learning rates of a training loop depart from the rules."""

import math
from collections.abc import Callable

import numpy as np

from tutorial_lib.checks.nb02.training_arrays import close_arrays
from tutorial_lib.learning.small_training import TrainingPlan
from tutorial_lib.learning.training_probe import Trace

Rate = Callable[[int, TrainingPlan], float]


def _cosine(share: float) -> float:
    return 0.5 * (1 + math.cos(math.pi * share))


def _warmup(step: float, plan: TrainingPlan) -> float:
    return min(1.0, step / plan.warmup_steps)


def _right_rate(step: int, plan: TrainingPlan) -> float:
    return _warmup(step + 1, plan) * _cosine(step / plan.max_steps)


_RATES: dict[str, Rate] = {
    "the learning rate never changes: set group['lr'] of every group before the step": (
        lambda step, plan: 1.0
    ),
    "the learning rate lacks the warm-up: min(1, (step + 1) / warmup_steps)": (
        lambda step, plan: _cosine(step / plan.max_steps)
    ),
    "the learning rate does not decay: the half cosine is missing": (
        lambda step, plan: _warmup(step + 1, plan)
    ),
    "the warm-up is one step late: (step + 1) / warmup_steps; step 0 must learn, too": (
        lambda step, plan: _warmup(step, plan) * _cosine(step / plan.max_steps)
    ),
    "the warm-up goes on beyond 1: min(1, (step + 1) / warmup_steps)": (
        lambda step, plan: (step + 1) / plan.warmup_steps * _cosine(step / plan.max_steps)
    ),
    "the cosine is one step early: it takes step / max_steps, and begins with 1": (
        lambda step, plan: _warmup(step + 1, plan) * _cosine((step + 1) / plan.max_steps)
    ),
    "the cosine begins at step 0, not after the warm-up: step / max_steps": (
        lambda step, plan: (
            _warmup(step + 1, plan)
            * _cosine(max(0, step - plan.warmup_steps) / max(1, plan.max_steps - plan.warmup_steps))
        )
    ),
    "the decay is half a cosine, from 1 to 0; a straight line came out": (
        lambda step, plan: _warmup(step + 1, plan) * (1 - step / plan.max_steps)
    ),
    "the decay is (1 + cos) / 2; the plain cosine falls to -1": (
        lambda step, plan: _warmup(step + 1, plan) * math.cos(math.pi * step / plan.max_steps)
    ),
    "np.cos takes radians: pi, not 180": (
        lambda step, plan: (
            _warmup(step + 1, plan) * 0.5 * (1 + math.cos(180 * step / plan.max_steps))
        )
    ),
    "the decay is (1 + cos) / 2; the half is missing": (
        lambda step, plan: 2 * _right_rate(step, plan)
    ),
    "the rate is set after the step, so that every step uses that of the step before it": (
        lambda step, plan: _right_rate(step - 1, plan) if step else 1.0
    ),
}


def rate_mistake(got: Trace, plan: TrainingPlan) -> str | None:
    """Whether every update has its learning rate."""
    steps = range(len(got.rates))
    right = [plan.learning_rate * _right_rate(step, plan) for step in steps]
    if close_arrays(got.rates, right):
        return None
    for words, rate in _RATES.items():
        if close_arrays(got.rates, [plan.learning_rate * rate(step, plan) for step in steps]):
            return words
    if close_arrays(np.array(got.rates) * plan.learning_rate, right):
        return "multiply by plan.learning_rate, the highest rate"
    step = int(np.argmax(np.abs(np.array(got.rates) - right) > 1e-7))
    return (
        f"the learning rate of step {step} is {got.rates[step]:.4g}, but {right[step]:.4g} is right"
    )
