"""A network with known gradients that records what a training loop does with it."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import torch
from torch import Tensor, nn

from tutorial_lib.geometry import Array
from tutorial_lib.learning.small_training import TrainingPlan


@dataclass
class Trace:
    """What a training loop did.

    Attributes:
        drawn: the steps whose batches it drew.
        used: the steps whose batches it computed the loss of.
        training: whether the network was in training mode at each loss.
        gradients: (G,) of every update, all parameters in a row.
        rates: learning rate of every update.
        evaluated: updates before each evaluation.
        evaluating: whether the network was in evaluation mode at each.
        tracked: whether gradients were tracked at each.
        final: (G,) the weights in the end.
        weights: (G,) at each evaluation.
        ends_evaluating: whether the network is in evaluation mode in the end.
        history: what the loop returned.
    """

    drawn: list[int] = field(default_factory=list)
    used: list[int] = field(default_factory=list)
    training: list[bool] = field(default_factory=list)
    gradients: list[Array] = field(default_factory=list)
    rates: list[float] = field(default_factory=list)
    evaluated: list[int] = field(default_factory=list)
    evaluating: list[bool] = field(default_factory=list)
    tracked: list[bool] = field(default_factory=list)
    final: Array | None = None
    weights: list[Array] = field(default_factory=list)
    ends_evaluating: bool = False
    history: Any = None


class Network(nn.Module):
    """Two parameters, of two numbers and of one; the loss of a batch is their product with it."""

    def __init__(self) -> None:
        super().__init__()
        self.pair = nn.Parameter(torch.tensor([1.0, -1.0], dtype=torch.float64))
        self.single = nn.Parameter(torch.tensor([0.5], dtype=torch.float64))

    def weights(self) -> Array:
        """All parameters (3,) in a row."""
        return torch.cat([self.pair, self.single]).detach().numpy().copy()


def trace(
    loop: Callable[..., Any], plan: TrainingPlan, gradients: Array, validation: Sequence[float]
) -> Trace:
    """What a training loop does with a network whose every gradient is known.

    Args:
        loop: called as `small_training.train_network` is.
        plan: how long and how fast.
        gradients: (T, 3) of the batch of each step; they repeat after the last one.
        validation: losses that the evaluations return, one after the other; the last one repeats.
    """
    network, seen = Network(), Trace()
    network.eval()
    for parameter in network.parameters():  # of an earlier training
        parameter.grad = torch.ones_like(parameter)
    optimizer = torch.optim.SGD(network.parameters(), plan.learning_rate)

    def draw_batch(step: int) -> tuple[int, Tensor]:
        seen.drawn.append(int(step))
        return int(step), torch.as_tensor(gradients[int(step) % len(gradients)])

    def loss_of(module: Network, batch: tuple[int, Tensor]) -> Tensor:
        step, wanted = batch
        seen.used.append(step)
        seen.training.append(module.training)
        return (module.pair * wanted[:2]).sum() + (module.single * wanted[2:]).sum()

    def validate(module: Network) -> float:
        loss = validation[min(len(seen.evaluated), len(validation) - 1)]
        seen.evaluated.append(len(seen.rates))
        seen.evaluating.append(not module.training)
        seen.tracked.append(torch.is_grad_enabled())
        seen.weights.append(module.weights())
        return float(loss)

    def before_update(*_: object) -> None:
        seen.rates.append(float(optimizer.param_groups[0]["lr"]))
        grads = [parameter.grad for parameter in network.parameters()]
        missing = [torch.zeros_like(parameter) for parameter in network.parameters()]
        kept = [m if g is None else g for g, m in zip(grads, missing, strict=True)]
        seen.gradients.append(torch.cat(kept).detach().numpy().copy())

    optimizer.register_step_pre_hook(before_update)
    seen.history = loop(network, optimizer, draw_batch, loss_of, validate, plan)
    seen.final, seen.ends_evaluating = network.weights(), not network.training
    return seen
