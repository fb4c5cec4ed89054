"""Hyperparameters of a training, and how far it has got."""

import math
from dataclasses import dataclass, field

from tutorial_lib.validation import number, whole


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

    def __post_init__(self) -> None:
        for name in vars(self).keys() - {"learning_rate"}:
            whole(name, getattr(self, name), least=0 if name in ("max_steps", "seed") else 1)
        number("learning_rate", self.learning_rate, least=0.0)

    def learning_rate_at(self, step: int) -> float:
        """The learning rate of a step."""
        whole("step", step, least=0, most=self.max_steps - 1)
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
