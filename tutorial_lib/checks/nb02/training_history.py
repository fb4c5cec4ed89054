"""Where the history that a training loop returns departs from what was measured."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from tutorial_lib.checks.framework.wording import kind
from tutorial_lib.checks.nb02.training_arrays import close_arrays
from tutorial_lib.geometry import Array
from tutorial_lib.learning.training_probe import Trace


def history_mistake(got: Trace, want: Trace) -> str | None:
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
    if close_arrays(mine, right):
        return None
    if close_arrays(mine[:, [0, 2, 1]], right):
        return "in the history the training loss comes before the validation loss"
    if not close_arrays(mine[:, 0], right[:, 0]):
        counted = (
            "count the steps made, from 1" if close_arrays(mine[:, 0] + 1, right[:, 0]) else "see"
        )
        return f"the history's steps are {mine[:, 0]}, but {right[:, 0]} is right; {counted}"
    if not close_arrays(mine[:, 2], right[:, 2]):
        return "the history's last number is what validate(network) returned"
    words = _training_loss(mine[:, 1], right[:, 1], right[:, 0])
    return f"{words}: {mine[:, 1].round(3)} came back, but {right[:, 1].round(3)} is right"


def _training_loss(mine: Array, right: Array, steps: Array) -> str:
    """What is wrong with the training losses of a history."""
    counts = np.diff(steps, prepend=0)
    if close_arrays(mine, right * counts):
        return "the training loss is the mean since the last evaluation, not the sum"
    if close_arrays(mine, np.cumsum(right * counts) / steps):
        return "the training loss is the mean since the last evaluation; empty the list after it"
    return "the training loss is the mean of all losses since the last evaluation"


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
