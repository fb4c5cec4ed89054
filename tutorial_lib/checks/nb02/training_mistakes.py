"""Where a training loop first departs from the rules, in the student's terms."""

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from tutorial_lib.checks.engine import mistakes_of
from tutorial_lib.checks.framework.wording import kind
from tutorial_lib.geometry import Array
from tutorial_lib.learning.small_training import TrainingPlan
from tutorial_lib.learning.training_probe import Trace


def _close_arrays(first: object, second: object) -> bool:
    """Whether two arrays have the same shape and nearly the same numbers."""
    first, second = np.asarray(first, float), np.asarray(second, float)
    return first.shape == second.shape and np.allclose(first, second, rtol=1e-4, atol=1e-7)


def _history_mistake(got: Trace, want: Trace) -> str | None:
    """Whether the history says what was measured."""
    words = "return the history, a list with (step, training loss, validation loss) for each"
    if got.history is None:
        return f"nothing came back; {words} evaluation"
    if not isinstance(got.history, list | tuple) or len(got.history) != len(want.history):
        count = f" of {len(got.history)}" if isinstance(got.history, list | tuple) else ""
        return (
            f"{kind(got.history)}{count} came back; {words} of the {len(want.history)} evaluations"
        )
    rows = list(_rows(got.history))
    if any(isinstance(row, str) for row in rows):
        return next(row for row in rows if isinstance(row, str))
    mine, right = np.array(rows), np.array(want.history)
    if _close_arrays(mine, right):
        return None
    if _close_arrays(mine[:, [0, 2, 1]], right):
        return "in the history the training loss comes before the validation loss"
    if not _close_arrays(mine[:, 0], right[:, 0]):
        counted = (
            "count the steps made, from 1" if _close_arrays(mine[:, 0] + 1, right[:, 0]) else "see"
        )
        return f"the history's steps are {mine[:, 0]}, but {right[:, 0]} is right; {counted}"
    if not _close_arrays(mine[:, 2], right[:, 2]):
        return "the history's last number is what validate(network) returned"
    words = _training_loss(mine[:, 1], right[:, 1], right[:, 0])
    return f"{words}: {mine[:, 1].round(3)} came back, but {right[:, 1].round(3)} is right"


def _training_loss(mine: Array, right: Array, steps: Array) -> str:
    """What is wrong with the training losses of a history."""
    counts = np.diff(steps, prepend=0)
    if _close_arrays(mine, right * counts):
        return "the training loss is the mean since the last evaluation, not the sum"
    if _close_arrays(mine, np.cumsum(right * counts) / steps):
        return "the training loss is the mean since the last evaluation; empty the list after it"
    return (
        "the training loss is the mean of all losses since the last evaluation, of a network whose "
        "best weights come back at the end only"
    )


def _rows(history: Sequence[Any]) -> Iterator[list[float] | str]:
    """The entries of a history as numbers, or what is wrong with one."""
    three = "the history's entries are three numbers: step, training loss, validation loss"
    for entry in history:
        values = list(entry) if isinstance(entry, tuple | list | np.ndarray) else []
        if any(getattr(value, "requires_grad", False) for value in values):
            yield "the history holds a tensor with its gradients; keep the number, loss.item()"
        elif len(values) != 3 or not all(
            np.isscalar(value) or hasattr(value, "item") for value in values
        ):
            yield three
        else:
            try:
                yield [float(value) for value in values]
            except (TypeError, ValueError):
                yield three


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
the cosine takes step / max_steps, not step / (max_steps - 1): at the last step it's nearly 0
    * step / plan.max_steps -> * step / max(1, plan.max_steps - 1)
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


def _rate_mistake(got: Trace, plan: TrainingPlan) -> str | None:
    """Whether every update has its learning rate."""
    steps = range(len(got.rates))
    right = [plan.learning_rate * _rate(step, plan) for step in steps]
    if _close_arrays(got.rates, right):
        return None
    for words, rate in _RATES.items():
        if _close_arrays(got.rates, [plan.learning_rate * rate(step, plan) for step in steps]):
            return words
    if _close_arrays(np.array(got.rates) * plan.learning_rate, right):
        return "multiply by plan.learning_rate, the highest rate"
    step = int(np.argmax(np.abs(np.array(got.rates) - right) > 1e-7))
    return (
        f"the learning rate of step {step} is {got.rates[step]:.4g}, but {right[step]:.4g} is right"
    )


def mistake(got: Trace, want: Trace, plan: TrainingPlan, gradients: Array) -> str | None:
    """What is wrong with the trace of a training loop; None if nothing is."""
    return (
        _drawing(got, want)
        or _updating(got, gradients, plan)
        or _rate_mistake(got, plan)
        or _evaluating(got, want, plan)
        or _modes(got)
        or _ending(got, want, plan)
        or _history_mistake(got, want)
        or _keeping(got, want)
    )


def _drawing(got: Trace, want: Trace) -> str | None:
    """Whether every step draws one batch, its own."""
    drawn = got.drawn
    if not drawn:
        return "no batch is drawn: call draw_batch(step) once in every step"
    right = list(range(len(drawn)))
    if drawn != right:
        if drawn == [i + 1 for i in right]:
            return "the first step is step 0: draw_batch(0)"
        if len(set(drawn)) == 1 and len(drawn) > 1:
            return f"every step draws the batch of step {drawn[0]}; draw_batch(step), step by step"
        if len(set(drawn)) < len(drawn):
            return f"each batch is drawn once, but the steps drawn were {drawn[:6]} and so on"
        return f"the steps of the batches drawn were {drawn[:6]}; they count 0, 1, 2, ..."
    if got.used != drawn:
        return "draw a batch in every step, and compute its loss once: loss_of(network, batch)"
    if len(got.rates) != len(drawn):
        made = len(got.rates)
        return (
            f"{made} updates for {len(drawn)} batches: one optimizer.step() after every batch"
            if len(drawn) <= len(want.drawn) or not made
            else "one optimizer.step() after every batch"
        )
    return None


def _updating(got: Trace, batches: Array, plan: TrainingPlan) -> str | None:
    """Whether every update uses the gradient of its batch, shortened if it is too long."""
    raw = np.array([batches[i % len(batches)] for i in range(len(got.gradients))])
    long = np.linalg.norm(raw, axis=1, keepdims=True) / plan.max_norm
    shortened = raw / np.maximum(long, 1.0)
    mine = np.array(got.gradients)
    if _close_arrays(mine, shortened):
        return None
    if not mine.any():
        return "the gradients are all zero: loss.backward() comes after zero_grad(), before step()"
    first = 1.0 + raw[0]  # the network comes with gradients of 1
    if not _close_arrays(mine[0], shortened[0]) and _close_arrays(
        mine[0], first / max(_length(first, plan), 1)
    ):
        return "old gradients are added to the new ones: optimizer.zero_grad() before backward()"
    if len(mine) > 1 and _close_arrays(mine[0], shortened[0]):
        total = raw[0] + raw[1]
        if _close_arrays(mine[1], total / max(_length(total, plan), 1)):
            return "the gradients of all batches add up: optimizer.zero_grad() in every step"
    if _close_arrays(mine, raw):
        return (
            "a gradient that is too long stays so: torch.nn.utils.clip_grad_norm_ with max_norm, "
            "after backward() and before step()"
        )
    if _close_arrays(mine, raw / long):
        return "only gradients longer than max_norm are shortened; the others stay as they are"
    if _close_arrays(mine, np.clip(raw, -plan.max_norm, plan.max_norm)):
        return "shorten the whole gradient, do not cut each number: clip_grad_norm_, no value"
    if _close_arrays(mine, _cut_parts(raw, plan)):
        return "max_norm limits the gradient of all parameters together, not of each tensor alone"
    other = np.linalg.norm(mine, axis=1).max()
    if _close_arrays(mine, _cut(raw, other)):
        return (
            f"gradients are shortened to {other:.4g}, but plan.max_norm is {plan.max_norm:g}; "
            "write no number in its place"
        )
    step = int(np.argmax(np.abs(mine - shortened).max(axis=1) > 1e-4))
    now, right = mine[step].round(3), shortened[step].round(3)
    return f"the gradient of step {step} is {now}, but {right} is right; see rule 3, plan.max_norm"


def _length(gradient: Array, plan: TrainingPlan) -> float:
    return float(np.linalg.norm(gradient)) / plan.max_norm


def _cut(gradients: Array, norm: float) -> Array:
    return gradients / np.maximum(np.linalg.norm(gradients, axis=1, keepdims=True) / norm, 1.0)


def _cut_parts(raw: Array, plan: TrainingPlan) -> Array:
    """Each of the two parameters by itself."""
    return np.concatenate(
        [_cut(raw[:, :2], plan.max_norm), _cut(raw[:, 2:], plan.max_norm)], axis=1
    )


def _modes(got: Trace) -> str | None:
    """Whether the network was in training mode while it learnt, and only then."""
    if not got.training[0]:
        return "the network learns in evaluation mode: network.train() before the first step"
    if not all(got.training):
        return "after an evaluation the network must go on in training mode: network.train()"
    if not all(got.evaluating):
        return "evaluate in evaluation mode: network.eval() before validate(network)"
    if any(got.tracked):
        return "an evaluation needs no gradients: validate within torch.no_grad()"
    return None


def _evaluating(got: Trace, want: Trace, plan: TrainingPlan) -> str | None:
    """Whether evaluations come when they should, as far as the training went."""
    mine, right = got.evaluated, want.evaluated
    if not mine:
        return "nothing is evaluated: validate(network) after every eval_interval steps"
    last = min(len(got.rates), len(want.rates))
    mine = [step for step in mine if step <= last]
    right = [step for step in right if step <= last]
    if mine == right or (got.rates and len(got.rates) < len(want.rates) and mine[:-1] == right):
        return None
    if 0 in mine:
        return "the first evaluation comes after eval_interval steps, not before the first step"
    if len(set(mine)) < len(mine):
        return "each evaluation happens once, also where the last step ends an interval"
    if mine == right[:-1] and right[-1] == plan.max_steps:
        return "evaluate after the last step, too, where it does not end an interval"
    if all((step - 1) % plan.eval_interval == 0 for step in mine) and plan.eval_interval > 1:
        return f"evaluations come one step early or late: after {right} steps, not after {mine}"
    if len(mine) > len(right):
        return f"evaluate only after every eval_interval steps: after {right}, not after {mine}"
    return f"evaluate after every plan.eval_interval steps: after {right}, not after {mine}"


def _ending(got: Trace, want: Trace, plan: TrainingPlan) -> str | None:
    """Whether the training ends when it should."""
    mine, right = len(got.rates), len(want.rates)
    if mine == right:
        return None
    losses = [entry[2] for entry in want.history]
    seen = f"the validation losses were {losses}, and patience is {plan.patience}"
    if mine > right:
        if right == plan.max_steps:
            return f"training ends after max_steps = {plan.max_steps} steps, not after {mine}"
        return f"training goes on, {mine} steps, where it should end after {right}: {seen}"
    if mine == plan.max_steps - 1:
        return f"the last step is missing: {mine} of {plan.max_steps}"
    return (
        f"training ends after {mine} steps, where it should make {right}: {seen}; count the "
        "evaluations in a row that are no better than the best; a new best starts the count again"
    )


def _keeping(got: Trace, want: Trace) -> str | None:
    """Whether the network ends with the weights of the best evaluation."""
    if not _close_arrays(got.final, want.final):
        copied = "a copy of network.state_dict(), as deepcopy makes it: the dict itself goes on"
        losses = [entry[2] for entry in want.history]
        return (
            f"the network must end with the weights of its best evaluation; the validation losses "
            f"were {losses}, and the first of equals counts. Keep {copied} changing. And give it "
            "back at the end: network.load_state_dict(...)"
        )
    if not got.ends_evaluating:
        return "in the end the network must be in evaluation mode: network.eval()"
    return None
