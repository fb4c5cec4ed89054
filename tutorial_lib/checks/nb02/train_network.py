"""The check of the training loop, in notebook 02: what it does with a network."""

import math
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any

import numpy as np

from tutorial_lib.checks.engine import WrongAnswer, case, check, kind, mistakes_of
from tutorial_lib.checks.framework.answers import beside
from tutorial_lib.checks.framework.topics import attempt
from tutorial_lib.geometry import Array
from tutorial_lib.learning.small_training import TrainingPlan, train_network
from tutorial_lib.learning.training_probe import Trace, trace

Case = tuple[TrainingPlan, Array, list[float]]
"""The plan, the gradient of each step's batch, and the validation losses."""
_FALLING = [9.0, 8.0, 7.0, 6.0, 5.0, 4.0, 3.0, 2.0, 1.0]


def _plan(
    steps: int,
    interval: int,
    warmup: int = 1,
    norm: float = 1e9,
    patience: int = 99,
    rate: float = 0.1,
) -> TrainingPlan:
    return TrainingPlan(steps, rate, warmup, norm, interval, patience)


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
        "losses in the hundreds, and one that is hardly better": case(
            _plan(8, 2), gradients, [500.0, 300.0, 299.9995, 400.0]
        ),
        "a patience of 2": (_plan(20, 2, patience=2), gradients, [5, 3, 4, 4.5, 1, 1]),
        "a patience of 2, and now and then a new best": case(
            _plan(20, 2, patience=2), gradients, [5, 6, 4, 4.5, 3, 3, 3.5, 1, 1]
        ),
        "a patience of 1": (_plan(12, 3, patience=1), gradients, [5, 4, 4, 1]),
        "a learning rate of 0.001": (_plan(8, 4, warmup=2, rate=0.001), gradients, _FALLING),
        "a plan that ends before its warm-up": (_plan(6, 2, warmup=20), gradients, _FALLING),
    }
    for i in range(12):
        steps, rate = int(rng.integers(1, 30)), float(rng.uniform(0.01, 1))
        warmup, norm = int(rng.integers(1, 12)), float(rng.uniform(0.3, 4))
        interval, patience = int(rng.integers(1, 7)), int(rng.integers(1, 5))
        plan = _plan(steps, interval, warmup, norm, patience, rate)
        losses = rng.integers(1, 9, 30).astype(float).tolist()
        cases[f"random plan {i + 1}, {plan}"] = (plan, strong, losses)
    return cases


def _example() -> tuple:
    """A training to measure functions with, as the arguments of one call."""
    kept: list[tuple] = []
    plan, gradients, losses = _cases()["a warm-up of 4 steps"]
    trace(lambda *arguments: kept.append(arguments), plan, gradients, losses)
    return kept[0]


def _close(first: object, second: object) -> bool:
    """Whether two arrays have the same shape and nearly the same numbers."""
    first, second = np.asarray(first, float), np.asarray(second, float)
    return first.shape == second.shape and np.allclose(first, second, rtol=1e-4, atol=1e-7)


def _history_mistake(got: Trace, want: Trace) -> str | None:
    """Whether the history says what was measured."""
    words = "return the history, a list with (step, training loss, validation loss) for each"
    if got.history is None:
        return f"nothing came back; {words} evaluation"
    listed = isinstance(got.history, list | tuple)
    if not listed or len(got.history) != len(want.history):
        came = f"{kind(got.history)} of {len(got.history)}" if listed else kind(got.history)
        return f"{came} came back; {words} of the {len(want.history)} evaluations"
    rows = list(map(_row, got.history))
    for row in rows:
        if isinstance(row, str):
            return row
    mine, right = np.array(rows), np.array(want.history)
    if _close(mine, right):
        return None
    if _close(mine[:, [0, 2, 1]], right):
        return "in the history the training loss comes before the validation loss"
    (steps, losses, validated), (at, means, validation) = mine.T, right.T
    if not _close(steps, at):
        counted = "count the steps made, from 1" if _close(steps + 1, at) else "see"
        return f"the history's steps are {steps}, but {at} is right; {counted}"
    if not _close(validated, validation):
        return "the history's last number is what validate(network) returned"
    words = _training_loss(losses, means, at)
    return f"{words}: {losses.round(3)} came back, but {means.round(3)} is right"


def _training_loss(mine: Array, right: Array, steps: Array) -> str:
    """What is wrong with the training losses of a history."""
    counts = np.diff(steps, prepend=0)
    if _close(mine, right * counts):
        return "the training loss is the mean since the last evaluation, not the sum"
    if _close(mine, np.cumsum(right * counts) / steps):
        return "the training loss is the mean since the last evaluation; empty the list after it"
    return (
        "the training loss is the mean of all losses since the last evaluation, of a network whose "
        "best weights come back at the end only"
    )


def _row(entry: object) -> list[float] | str:
    """An entry of a history as numbers, or what is wrong with it."""
    values = list(entry) if isinstance(entry, tuple | list | np.ndarray) else []
    if any(getattr(value, "requires_grad", False) for value in values):
        return "the history holds a tensor with its gradients; keep the number, loss.item()"
    if len(values) == 3 and all(np.isscalar(value) or hasattr(value, "item") for value in values):
        with suppress(TypeError, ValueError):
            return [float(value) for value in values]
    return "the history's entries are three numbers: step, training loss, validation loss"


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
    if _close(got.rates, right):
        return None
    for words, rate in _RATES.items():
        if _close(got.rates, [plan.learning_rate * rate(step, plan) for step in steps]):
            return words
    if _close(np.array(got.rates) * plan.learning_rate, right):
        return "multiply by plan.learning_rate, the highest rate"
    step = int(np.argmax(np.abs(np.array(got.rates) - right) > 1e-7))
    mine = f"the learning rate of step {step} is {got.rates[step]:.4g}"
    return f"{mine}, but {right[step]:.4g} is right"


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
    made, words = len(got.rates), "one optimizer.step() after every batch"
    if made == len(drawn):
        return None
    if len(drawn) <= len(want.drawn) or not made:
        return f"{made} updates for {len(drawn)} batches: {words}"
    return words


def _updating(got: Trace, batches: Array, plan: TrainingPlan) -> str | None:
    """Whether every update uses the gradient of its batch, shortened if it is too long."""
    raw, mine = batches[np.arange(len(got.gradients)) % len(batches)], np.array(got.gradients)
    norm = plan.max_norm
    shortened = _cut(raw, norm)
    if _close(mine, shortened):
        return None
    if not mine.any():
        return "the gradients are all zero: loss.backward() comes after zero_grad(), before step()"
    first = 1.0 + raw[0]  # the network comes with gradients of 1
    begins_right = _close(mine[0], shortened[0])
    if not begins_right and _close(mine[0], _cut(first, norm)):
        return "old gradients are added to the new ones: optimizer.zero_grad() before backward()"
    if begins_right and len(mine) > 1 and _close(mine[1], _cut(raw[0] + raw[1], norm)):
        return "the gradients of all batches add up: optimizer.zero_grad() in every step"
    if _close(mine, raw):
        return (
            "a gradient that is too long stays so: torch.nn.utils.clip_grad_norm_ with max_norm, "
            "after backward() and before step()"
        )
    if _close(mine, raw / np.linalg.norm(raw, axis=1, keepdims=True) * norm):
        return "only gradients longer than max_norm are shortened; the others stay as they are"
    if _close(mine, np.clip(raw, -norm, norm)):
        return "shorten the whole gradient, do not cut each number: clip_grad_norm_, no value"
    if _close(mine, np.hstack([_cut(raw[:, :2], norm), _cut(raw[:, 2:], norm)])):
        return "max_norm limits the gradient of all parameters together, not of each tensor alone"
    other = np.linalg.norm(mine, axis=1).max()
    if _close(mine, _cut(raw, other)):
        words = f"gradients are shortened to {other:.4g}, but plan.max_norm is {norm:g}"
        return f"{words}; write no number in its place"
    step = int(np.argmax(np.abs(mine - shortened).max(axis=1) > 1e-4))
    now, right = mine[step].round(3), shortened[step].round(3)
    return f"the gradient of step {step} is {now}, but {right} is right; see rule 3, plan.max_norm"


def _cut(gradients: Array, norm: float) -> Array:
    return gradients / np.maximum(np.linalg.norm(gradients, axis=-1, keepdims=True) / norm, 1.0)


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
    if not _close(got.final, want.final):
        losses = [entry[2] for entry in want.history]
        words = (
            "the network must end with the weights of its best evaluation; the validation losses "
            f"were {losses}"
        )
        equals = [at for at, loss in enumerate(losses) if loss == min(losses)]
        if any(_close(got.final, got.weights[at]) for at in equals):
            return f"{words}. Of equals the first counts: < keeps it, <= the last"
        if not _close(got.final, got.weights[-1]):
            return f"{words}, and yours ends with others"
        return (
            f"{words}, and yours ends with those of the last. Keep a copy of network.state_dict(), "
            "as deepcopy makes it: the dict itself goes on changing. And give it back at the end: "
            "network.load_state_dict(...)"
        )
    if not got.ends_evaluating:
        return "in the end the network must be in evaluation mode: network.eval()"
    return None


@check(
    train_network,
    _example(),
    calls=1,
    endless="Your training has not ended after {seconds:g} seconds. Does it stop at max_steps?",
)
def check_train_network(student: Callable[..., Any]) -> None:
    """Batches, learning rates, gradients, evaluations, the end, and the weights that are kept."""
    for about, given in _cases().items():
        what = f"train_network, {about}"
        words = "follow the seven rules above, one after the other"
        got = attempt(what, words, partial(beside(trace), student), *given)
        wrong = mistake(got, trace(train_network, *given), *given[:2])
        if wrong:
            raise WrongAnswer(f"{what}: {wrong}")
