"""One plain training loop: seeded, resumable, with a progress bar."""

import io
import math
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, Protocol

import torch
from torch import Tensor, nn
from tqdm.auto import tqdm

from tutorial_lib.errors import InputError
from tutorial_lib.files import make_folder, write_files
from tutorial_lib.learning.batches import Batch, Blocks, batches
from tutorial_lib.learning.losses import CONTEXT_WEIGHT, EVALUATION_LOSSES, LOSSES, context_loss
from tutorial_lib.learning.networks import LocalNetwork
from tutorial_lib.learning.settings import Progress, Settings
from tutorial_lib.learning.threads import use_threads
from tutorial_lib.learning.weights import check_like, digest_of, untrained
from tutorial_lib.reading.checksums import sealed, unsealed
from tutorial_lib.reading.limits import MAX_CHECKPOINT
from tutorial_lib.reading.regular import read_bytes
from tutorial_lib.validation import instance, instances, path_of, with_methods


class Objective(Protocol):
    """What kind of network is trained, and for what."""

    def loss(self, network: Any, batch: Any) -> Tensor:  # noqa: ANN401 - of that kind
        """Training loss of a batch."""

    def measure(self, network: Any, validation: Sequence[Any]) -> dict[str, float]:  # noqa: ANN401
        """What is measured on validation worlds; "validation" selects the best evaluation."""


class _LocalObjective:
    """Networks of local control."""

    def loss(self, network: LocalNetwork, batch: Batch) -> Tensor:
        return total_loss(network, batch)

    def measure(self, network: LocalNetwork, validation: Sequence[Batch]) -> dict[str, float]:
        return validate(network, validation)


LOCAL = _LocalObjective()
"""Of the networks of local control."""
_MOMENTS = ("exp_avg", "exp_avg_sq")
"""What Adam keeps of each parameter, besides its number of steps."""


def train(
    architecture: Any,  # noqa: ANN401 - of the objective's kind of network
    source: Blocks,
    validation: Sequence[Any],
    settings: Settings,
    checkpoint: Path | None = None,
    init_from: nn.Module | None = None,
    objective: Objective = LOCAL,
) -> tuple[Any, Progress]:
    """Train a network from scratch or resume from `checkpoint`, with the same resulting weights.

    Args:
        architecture: of the network, one of `weights.KINDS`.
        source: of its batches.
        validation: batches of worlds that it is not trained on.
        settings: all else.
        checkpoint: file to which the state is saved at every evaluation.
        init_from: trained network whose weights are copied where name and shape match.
        objective: what kind of network it is, and its losses.

    Returns:
        The network with the weights of the best evaluation, and the progress.

    Raises:
        InputError: when the checkpoint belongs to another training.
    """
    with_methods("source", source, "block")
    with_methods("validation", validation, "__len__", "__getitem__")
    instance("settings", settings, Settings)
    with_methods("objective", objective, "loss", "measure")
    checkpoint = None if checkpoint is None else path_of("checkpoint", checkpoint)
    if init_from is not None:
        instance("init_from", init_from, nn.Module)
    use_threads(settings.threads)
    torch.manual_seed(settings.seed)
    fresh = untrained(architecture)
    if init_from is not None:
        copy_matching_weights(fresh, init_from)
    initial = "" if init_from is None else digest_of(init_from)
    state = _State(fresh, settings, source, initial, objective)
    if checkpoint is not None:
        make_folder(checkpoint.parent)
        if checkpoint.exists():
            state.load(checkpoint)
    network, progress = state.network, state.progress
    coming = batches(source, settings.seed, progress.step, settings.targets)
    bar = tqdm(total=settings.max_steps, initial=progress.step, disable=None, leave=False)
    while progress.step < settings.max_steps and not progress.is_over(settings.patience):
        state.learn(next(coming))
        bar.update()
        if progress.step % settings.eval_interval == 0 or progress.step == settings.max_steps:
            evaluation = state.evaluate(validation)
            bar.set_postfix({name: f"{value:.3f}" for name, value in evaluation.items()})
            if checkpoint is not None:
                state.save(checkpoint)
    bar.close()
    coming.close()
    network.load_state_dict(state.best)
    return network.eval(), progress


def copy_matching_weights(network: nn.Module, trained: nn.Module) -> None:
    """Copy every weight of `trained` that has a counterpart of the same shape in `network`."""
    own = network.state_dict()
    matching = {
        name: value
        for name, value in trained.state_dict().items()
        if name in own and own[name].shape == value.shape
    }
    network.load_state_dict({**own, **matching})


class _State:
    """All that changes while a network trains."""

    def __init__(
        self,
        network: Any,  # noqa: ANN401 - the objective's kind, with its architecture
        settings: Settings,
        source: Blocks,
        initial: str,
        objective: Objective = LOCAL,
    ) -> None:
        self.network, self.settings, self.progress = network, settings, Progress()
        self.objective = objective
        self.recipe = {
            **asdict(network.architecture),
            **asdict(settings),
            "init_from": initial,
            "source": source.recipe,
        }
        self.optimizer = torch.optim.Adam(network.parameters(), settings.learning_rate)
        self.best = _copy(network)
        self.losses: list[float] = []
        self.evaluated = time.monotonic()

    def learn(self, batch: Any) -> None:  # noqa: ANN401 - the source's
        """One gradient step."""
        for group in self.optimizer.param_groups:
            group["lr"] = self.settings.learning_rate_at(self.progress.step)
        loss = self.objective.loss(self.network, batch)
        self.optimizer.zero_grad()
        loss.backward()
        self.optimizer.step()
        self.progress.step += 1
        self.losses.append(loss.item())

    def evaluate(self, validation: Sequence[Any]) -> dict[str, float]:
        """Evaluate on the validation worlds, and keep the weights if they are the best so far."""
        evaluation = {"training": sum(self.losses) / len(self.losses)}
        evaluation |= self.objective.measure(self.network, validation)
        self.losses.clear()
        now = time.monotonic()
        self.progress.seconds += now - self.evaluated
        self.evaluated = now
        self.progress.history.append({"step": self.progress.step, **evaluation})
        if self.progress.best == len(self.progress.history) - 1:
            self.best = _copy(self.network)
        return evaluation

    def save(self, path: Path) -> None:
        """Write the state, whole or not at all."""
        state = {
            "recipe": self.recipe,
            "network": self.network.state_dict(),
            "optimizer": self.optimizer.state_dict(),
            "best": self.best,
            "step": self.progress.step,
            "history": self.progress.history,
            "seconds": self.progress.seconds,
        }
        buffer = io.BytesIO()
        torch.save(state, buffer)
        write_files({path: sealed(buffer.getvalue())})

    def load(self, path: Path) -> None:
        """Resume from what `save` wrote.

        Raises:
            InputError: when the file is damaged, has no checksum (as those of older versions), does
                not fit the network, or belongs to another training.
        """
        advice = "delete it to begin again"
        data = read_bytes(path, MAX_CHECKPOINT, advice)
        try:
            state = torch.load(io.BytesIO(unsealed(data)), weights_only=True)
            if state["recipe"] == self.recipe:
                # All of it is looked at before any of it is taken over.
                progress = _progress_of(state, self.settings)
                _check_weights(state, self.network.state_dict())
                _check_optimizer(state, self.optimizer, self.network)
                self.network.load_state_dict(state["network"])
                self.optimizer.load_state_dict(state["optimizer"])
                self.best, self.progress = state["best"], progress
                return
        # torch, zipfile and pickle have a dozen errors for a damaged file, some many lines long.
        except Exception as error:
            why = error if isinstance(error, InputError) else type(error).__name__
            raise InputError(f"{path}: a damaged checkpoint ({why}); {advice}") from error
        raise InputError(f"{path}: a checkpoint of another training, {state['recipe']}; {advice}")


def _progress_of(state: dict[str, Any], settings: Settings) -> Progress:
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


def _check_weights(state: dict[str, Any], own: dict[str, Tensor]) -> None:
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


def _check_optimizer(state: dict[str, Any], own: torch.optim.Optimizer, network: nn.Module) -> None:
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


def _copy(network: nn.Module) -> dict[str, Tensor]:
    return {name: value.detach().clone() for name, value in network.state_dict().items()}


def outputs_of(network: LocalNetwork, batch: Batch) -> tuple[Tensor, Tensor]:
    """Outputs (N, O) and context poses (N, 2k+1, 4); each target is encoded once."""
    view = network.architecture.looks_at
    targets = network.encode_targets(view.numbers(batch.contexts))
    current = network.encode_current(view.numbers(batch.current))
    return network.compare(current, targets.repeat_interleave(len(current) // len(targets), dim=0))


def total_loss(network: LocalNetwork, batch: Batch) -> Tensor:
    """Training loss, averaged over the pairs by weight."""
    instance("network", network, LocalNetwork)
    instance("batch", batch, Batch)
    outputs, poses = outputs_of(network, batch)
    kind = network.architecture.outputs
    loss = LOSSES[kind](outputs, batch)
    loss = loss + CONTEXT_WEIGHT[kind] * batch.tensor("placed") * context_loss(poses, batch)
    weight = batch.tensor("weight")
    return (loss * weight).sum() / weight.sum().clamp(min=1.0)


@torch.inference_mode()
def validate(network: LocalNetwork, validation: Sequence[Batch]) -> dict[str, float]:
    """Mean loss on validation worlds, and median and mean error of waypoints in metres."""
    kind = instance("network", network, LocalNetwork).architecture.outputs
    instances("validation", validation, Batch, empty=False)
    losses, errors = [], []
    for batch in validation:
        outputs, _ = outputs_of(network, batch)
        kept = batch.tensor("weight") > 0
        losses.append(EVALUATION_LOSSES[kind](outputs, batch)[kept])
        if kind == "waypoint":
            errors.append((outputs[:, :2] - batch.tensor("waypoint")).norm(dim=1)[kept])
    measured = {"validation": torch.cat(losses).mean().item()}
    if errors:
        error = torch.cat(errors)
        measured |= {"median": error.median().item(), "mean": error.mean().item()}
    return measured
