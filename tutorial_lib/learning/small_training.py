"""The training loop of notebook 02: `training.train` in small, for any network."""

import math
from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

import torch
from torch import Tensor, nn

from tutorial_lib.validation import instance, number, whole

Evaluation = tuple[int, float, float]
"""Steps made, mean training loss since the last evaluation, validation loss."""


@dataclass(frozen=True)
class TrainingPlan:
    """How long and how fast a network learns.

    Attributes:
        max_steps: batches at most.
        learning_rate: the highest; it decays to zero along half a cosine.
        warmup_steps: batches until it is reached.
        max_norm: longest gradient of all parameters together; a longer one is shortened to it.
        eval_interval: batches between two evaluations.
        patience: evaluations in a row without a new best one after which training ends.
    """

    max_steps: int
    learning_rate: float
    warmup_steps: int
    max_norm: float
    eval_interval: int
    patience: int

    def __post_init__(self) -> None:
        for name in ("max_steps", "warmup_steps", "eval_interval", "patience"):
            whole(name, getattr(self, name), least=1)
        number("learning_rate", self.learning_rate, least=0.0)
        number("max_norm", self.max_norm, least=0.0, infinite=True)


def train_network(
    network: nn.Module,
    optimizer: torch.optim.Optimizer,
    draw_batch: Callable[[int], Any],
    loss_of: Callable[[nn.Module, Any], Tensor],
    validate: Callable[[nn.Module], float],
    plan: TrainingPlan,
) -> list[Evaluation]:
    """Train a network, and leave it with the weights of its best evaluation.

    Args:
        network: changed in place.
        optimizer: of its parameters; its learning rate is set before every step.
        draw_batch: (step) draws the batch of a step, from 0 on.
        loss_of: (network, batch) computes the loss of a batch.
        validate: (network) computes the loss on pairs that are not trained on.
        plan: how long and how fast.

    Returns:
        The history, an entry for each evaluation.
    """
    instance("plan", plan, TrainingPlan)
    history: list[Evaluation] = []
    losses: list[float] = []
    weights, best = network.state_dict(), 0
    network.train()
    for step in range(plan.max_steps):
        for group in optimizer.param_groups:
            group["lr"] = learning_rate_at(step, plan)
        optimizer.zero_grad()
        loss = loss_of(network, draw_batch(step))
        loss.backward()
        nn.utils.clip_grad_norm_(network.parameters(), plan.max_norm)
        optimizer.step()
        losses.append(loss.item())
        done = step + 1
        if done % plan.eval_interval == 0 or done == plan.max_steps:
            network.eval()
            with torch.no_grad():
                validation = validate(network)
            network.train()
            history.append((done, sum(losses) / len(losses), validation))
            losses = []
            if validation < min((entry[2] for entry in history[:-1]), default=math.inf):
                weights, best = deepcopy(network.state_dict()), len(history)
            if len(history) - best >= plan.patience:
                break
    network.load_state_dict(weights)
    network.eval()
    return history


def learning_rate_at(step: int, plan: TrainingPlan) -> float:
    """The learning rate of a step: a linear warm-up times half a cosine."""
    whole("step", step, least=0, most=instance("plan", plan, TrainingPlan).max_steps)
    warmup = min(1.0, (step + 1) / plan.warmup_steps)
    return plan.learning_rate * warmup * 0.5 * (1 + math.cos(math.pi * step / plan.max_steps))
