"""One plain training loop: seeded, resumable, with a progress bar."""

import io
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import torch
from torch import Tensor
from tqdm.auto import tqdm

from tutorial_lib.errors import InputError
from tutorial_lib.files import make_folder, write_files
from tutorial_lib.learning.batches import Batch, Blocks, batches
from tutorial_lib.learning.losses import CONTEXT_WEIGHT, EVALUATION_LOSSES, LOSSES, context_loss
from tutorial_lib.learning.networks import Architecture, LocalNetwork
from tutorial_lib.learning.weights import digest_of
from tutorial_lib.reading.checksums import sealed, unsealed
from tutorial_lib.reading.limits import MAX_CHECKPOINT
from tutorial_lib.reading.regular import read_bytes


@dataclass(frozen=True)
class Settings:
    """Hyperparameters of a training.

    Attributes:
        max_steps: batches at most.
        targets: of a batch; each has `STARTS` pairs.
        learning_rate: the highest of Adam; it decays to zero along half a cosine.
        warmup_steps: batches until it is reached.
        eval_interval: batches between two evaluations on the validation worlds.
        patience: evaluations without a better result after which training ends.
        threads: of torch; the result depends on it in the last digits.
        seed: of the initial weights and of the batches.
    """

    max_steps: int = 20_000
    targets: int = 16
    learning_rate: float = 2e-3
    warmup_steps: int = 200
    eval_interval: int = 1_000
    patience: int = 6
    threads: int = 1
    seed: int = 0

    def learning_rate_at(self, step: int) -> float:
        """The learning rate of a step."""
        warmup = min(1.0, (step + 1) / self.warmup_steps)
        decay = 0.5 * (1.01 + math.cos(math.pi * step / self.max_steps))
        return self.learning_rate * warmup * decay


@dataclass
class Progress:
    """How far a training has got.

    Attributes:
        step: batches learnt from.
        history: for each evaluation the step, the mean training loss since the last one, and what
            was measured on the validation worlds.
        seconds: of training, summed over all interrupted runs.
    """

    step: int = 0
    history: list[dict[str, float]] = field(default_factory=list)
    seconds: float = field(default=0.0, compare=False)

    @property
    def best(self) -> int:
        """Index of the evaluation with the smallest validation loss."""
        losses = [evaluation["validation"] for evaluation in self.history]
        return losses.index(min(losses))

    def is_over(self, patience: int) -> bool:
        """Whether the last `patience` evaluations were no better than one before."""
        return bool(self.history) and len(self.history) - 1 - self.best >= patience


def train(
    architecture: Architecture,
    source: Blocks,
    validation: Sequence[Batch],
    settings: Settings,
    checkpoint: Path | None = None,
    on_evaluation: Callable[[LocalNetwork, Progress], None] | None = None,
    init_from: LocalNetwork | None = None,
) -> tuple[LocalNetwork, Progress]:
    """Train a network from scratch or resume from `checkpoint`, with the same resulting weights.

    Args:
        architecture: of the network.
        source: of its batches.
        validation: batches of worlds that it is not trained on.
        settings: all else.
        checkpoint: file to which the state is saved at every evaluation.
        on_evaluation: called with the network and the progress after every evaluation.
        init_from: trained network whose weights are copied where name and shape match.

    Returns:
        The network with the weights of the best evaluation, and the progress.

    Raises:
        InputError: when the checkpoint belongs to another training.
    """
    torch.set_num_threads(settings.threads)
    torch.manual_seed(settings.seed)
    fresh = LocalNetwork(architecture)
    if init_from is not None:
        copy_matching_weights(fresh, init_from)
    initial = "" if init_from is None else digest_of(init_from)
    state = _State(fresh, settings, source, initial)
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
            if on_evaluation is not None:
                on_evaluation(network, progress)
    bar.close()
    coming.close()
    network.load_state_dict(state.best)
    return network.eval(), progress


def copy_matching_weights(network: LocalNetwork, trained: LocalNetwork) -> None:
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
        self, network: LocalNetwork, settings: Settings, source: Blocks, initial: str
    ) -> None:
        self.network, self.settings, self.progress = network, settings, Progress()
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

    def learn(self, batch: Batch) -> None:
        """One gradient step."""
        for group in self.optimizer.param_groups:
            group["lr"] = self.settings.learning_rate_at(self.progress.step)
        loss = total_loss(self.network, batch)
        self.optimizer.zero_grad()
        loss.backward()
        self.optimizer.step()
        self.progress.step += 1
        self.losses.append(loss.item())

    def evaluate(self, validation: Sequence[Batch]) -> dict[str, float]:
        """Evaluate on the validation worlds, and keep the weights if they are the best so far."""
        evaluation = {"training": sum(self.losses) / len(self.losses)}
        evaluation |= validate(self.network, validation)
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
            InputError: when the file is damaged, has no checksum (as those of older versions), or
                belongs to another training.
        """
        advice = "delete it to begin again"
        data = read_bytes(path, MAX_CHECKPOINT, advice)
        try:
            state = torch.load(io.BytesIO(unsealed(data)), weights_only=True)
            if state["recipe"] == self.recipe:
                self.network.load_state_dict(state["network"])
                self.optimizer.load_state_dict(state["optimizer"])
                self.best = state["best"]
                self.progress = Progress(state["step"], state["history"], state["seconds"])
                return
        # torch, zipfile and pickle have a dozen errors for a damaged file, some many lines long.
        except Exception as error:
            why = error if isinstance(error, InputError) else type(error).__name__
            raise InputError(f"{path}: a damaged checkpoint ({why}); {advice}") from error
        raise InputError(f"{path}: a checkpoint of another training, {state['recipe']}; {advice}")


def _copy(network: LocalNetwork) -> dict[str, Tensor]:
    return {name: value.detach().clone() for name, value in network.state_dict().items()}


def outputs_of(network: LocalNetwork, batch: Batch) -> tuple[Tensor, Tensor]:
    """Outputs (N, O) and context poses (N, 2k+1, 4); each target is encoded once."""
    view = network.architecture.looks_at
    targets = network.encode_targets(view.numbers(batch.contexts))
    current = network.encode_current(view.numbers(batch.current))
    return network.compare(current, targets.repeat_interleave(len(current) // len(targets), dim=0))


def total_loss(network: LocalNetwork, batch: Batch) -> Tensor:
    """Training loss, averaged over the pairs by weight."""
    outputs, poses = outputs_of(network, batch)
    kind = network.architecture.outputs
    loss = LOSSES[kind](outputs, batch)
    if not network.stacked:
        loss = loss + CONTEXT_WEIGHT[kind] * batch.tensor("placed") * context_loss(poses, batch)
    weight = batch.tensor("weight")
    return (loss * weight).sum() / weight.sum().clamp(min=1.0)


@torch.inference_mode()
def validate(network: LocalNetwork, validation: Sequence[Batch]) -> dict[str, float]:
    """Mean loss on validation worlds, and median and mean error of waypoints in metres."""
    kind = network.architecture.outputs
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
