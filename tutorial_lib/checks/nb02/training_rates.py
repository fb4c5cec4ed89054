"""Where the learning rates of a training loop depart from the rules."""

import math

import numpy as np

from tutorial_lib.checks.engine import mistakes_of
from tutorial_lib.checks.nb02.training_arrays import close_arrays
from tutorial_lib.learning.small_training import TrainingPlan
from tutorial_lib.learning.training_probe import Trace


def _rate(step: int, plan: TrainingPlan) -> float:
    """The share of the highest learning rate: a warm-up, and half a cosine."""
    warmup = min(1.0, (step + 1) / plan.warmup_steps)
    return warmup * 0.5 * (1 + math.cos(math.pi * step / plan.max_steps))


MISTAKES = """
the learning rate never changes: set group['lr'] of every group before the step
    return -> return 1.0; return
the learning rate lacks the warm-up: min(1, (step + 1) / warmup_steps)
    return warmup * -> return
the learning rate does not decay: the half cosine is missing
    return warmup * -> return warmup; return
the warm-up is one step late: (step + 1) / warmup_steps; step 0 must learn, too
    (step + 1) -> step
the warm-up goes on beyond 1: min(1, (step + 1) / warmup_steps)
    min(1.0, (step + 1) / plan.warmup_steps) -> (step + 1) / plan.warmup_steps
the cosine is one step early: it takes step / max_steps, and begins with 1
    math.pi * step -> math.pi * (step + 1)
the cosine begins at step 0, not after the warm-up: step / max_steps
    * step / plan.max_steps -> * max(0, step - plan.warmup_steps) / after
    warmup = -> after = max(1, plan.max_steps - plan.warmup_steps); warmup =
the decay is half a cosine, from 1 to 0; a straight line came out
    0.5 * (1 + math.cos(math.pi * step / plan.max_steps)) -> (1 - step / plan.max_steps)
the decay is (1 + cos) / 2; the plain cosine falls to -1
    0.5 * (1 + math.cos -> (math.cos
np.cos takes radians: pi, not 180
    math.pi -> 180
the decay is (1 + cos) / 2; the half is missing
    0.5 * -> 1 *
the rate is set after the step, so that every step uses that of the step before it
    warmup = -> step, first = step - 1, step == 0; warmup =
    return warmup * -> return 1.0 if first else warmup *
"""
_RATES = mistakes_of(_rate, MISTAKES)


def rate_mistake(got: Trace, plan: TrainingPlan) -> str | None:
    """Whether every update has its learning rate."""
    steps = range(len(got.rates))
    right = [plan.learning_rate * _rate(step, plan) for step in steps]
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
