"""Whether the state of a training, as a checkpoint holds it, fits the training that goes on."""

from __future__ import annotations

import math
from typing import Any

import torch
from torch import Tensor, nn

from tutorial_lib.errors import InputError
from tutorial_lib.learning.settings import Progress, Settings
from tutorial_lib.learning.weights import check_like

_MOMENTS = ("exp_avg", "exp_avg_sq")
"""What Adam keeps of each parameter, besides its number of steps."""


def progress_of(state: dict[str, Any], settings: Settings) -> Progress:
    """How far a training had got.

    Raises:
        InputError: when steps, seconds or evaluations make no sense.
    """
    step, history, seconds = state["step"], state["history"], state["seconds"]
    if type(step) is not int or not 0 <= step <= settings.max_steps:
        raise InputError(f"step: {step!r:.40} of {settings.max_steps}")
    if type(seconds) is not float or not 0 <= seconds < math.inf:
        raise InputError(f"seconds: {seconds!r:.40}")
    if type(history) is not list or not all(type(entry) is dict for entry in history):
        raise InputError("history: not a list of evaluations")
    for entry in history:
        numbers = all(type(value) in (int, float) for value in entry.values())
        if not numbers or not {"step", "training", "validation"} <= entry.keys():
            raise InputError(f"history: {entry!r:.80}")
        if not math.isfinite(entry["validation"]):
            raise InputError(f"history: validation {entry['validation']}")
    steps = [entry["step"] for entry in history]
    if steps != sorted(set(steps)) or (steps and not 0 < steps[0] <= steps[-1] <= step):
        raise InputError(f"history: evaluations at steps {steps!r:.80} of {step}")
    return Progress(step, history, seconds)


def check_weights(state: dict[str, Any], own: dict[str, Tensor]) -> None:
    """Check the weights that a training had, and the best ones, against the network's.

    Raises:
        InputError: naming the tensor that is missing, of another kind or shape, or not finite.
    """
    for part in ("network", "best"):
        found = state[part]
        if set(found) != set(own):
            raise InputError(f"{part}: other tensors than the network's")
        for name, value in found.items():
            if not isinstance(value, Tensor) or value.dtype != own[name].dtype:
                raise InputError(f"{part}: tensor {name} is of another kind")
        check_like(found, own)


def check_optimizer(state: dict[str, Any], own: torch.optim.Optimizer, network: nn.Module) -> None:
    """Check the state of Adam against a new one for the same network.

    Raises:
        InputError: when parts are missing, or have other kinds or shapes, or are not finite.
    """
    found, fresh = state["optimizer"], own.state_dict()
    known = [
        {key: value for key, value in group.items() if key != "lr"}  # it follows from the step
        for groups in (found["param_groups"], fresh["param_groups"])
        for group in groups
    ]
    if known[: len(known) // 2] != known[len(known) // 2 :]:
        raise InputError("optimizer: other settings than the training's")
    parameters = dict(enumerate(network.named_parameters()))
    moved = found["state"].keys()  # it keeps nothing of parameters that no loss depends on
    if not moved <= parameters.keys() or bool(moved) != bool(state["step"]):
        raise InputError("optimizer: other parameters than the network's")
    for number, moments in found["state"].items():
        name, parameter = parameters[number]
        if set(moments) != {"step", *_MOMENTS}:
            raise InputError(f"optimizer: {name} has {', '.join(map(str, moments))!s:.80}")
        if not all(isinstance(value, Tensor) for value in moments.values()):
            raise InputError(f"optimizer: {name} has what is no tensor")
        like = dict.fromkeys(_MOMENTS, parameter) | {"step": torch.zeros(())}
        check_like(moments, like)
        if any(moments[key].dtype != parameter.dtype for key in _MOMENTS):
            raise InputError(f"optimizer: {name} is of another kind")
        if not 0 < moments["step"] <= state["step"] or (moments["exp_avg_sq"] < 0).any():
            raise InputError(f"optimizer: {name} has another number of steps, or a negative square")
