"""What the tensors given to networks and losses must be: the counterpart of `validation`.

Numbers are not looked at: what is not finite spreads to the result, as everywhere in torch.
"""

from typing import Any

from torch import Tensor

from tutorial_lib.array_forms import fits
from tutorial_lib.errors import InputError


def tensor(name: str, value: Any, shape: tuple[Any, ...]) -> Tensor:  # noqa: ANN401 - to be checked
    """A tensor of floats of a shape, in which a name stands for any length, see `validation`.

    Raises:
        InputError: when the argument is anything else.

    >>> tensor("outputs", Tensor(5, 3), ("N", 6))
    Traceback (most recent call last):
    ...
    tutorial_lib.errors.InputError: outputs: shape (5, 3); give a tensor of floats (N, 6)
    """
    if not isinstance(value, Tensor):
        given = f"a {type(value).__name__}"
    elif not value.is_floating_point():
        given = str(value.dtype)
    elif not fits(tuple(value.shape), shape):
        given = f"shape {tuple(value.shape)}"
    else:
        return value
    lengths = ", ".join("..." if length is ... else str(length) for length in shape)
    raise InputError(f"{name}: {given}; give a tensor of floats ({lengths})")
