"""Asking a `Reachability`: a network, an oracle or a student's function; the answer is checked."""

from typing import Any

import numpy as np

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Observation, Reachability


def ask(reachability: Reachability, observations: Observation, prepared: Any) -> Array:  # noqa: ANN401
    """How probable it is that each robot reaches its target: RE of Meng 2020 (III-C).

    Args:
        reachability: is asked.
        observations: N robots.
        prepared: N targets, as `reachability.prepare` made them.

    Returns:
        (N,) probabilities.

    Raises:
        InputError: when what is told is not N probabilities; it says what came instead.
    """
    count = len(observations)
    if not count:
        return np.empty(0)
    told = reachability.probability(observations, prepared)
    try:
        probabilities = np.asarray(told, dtype=float)
    except (TypeError, ValueError, RuntimeError) as error:
        raise InputError(
            f"reachability: told a {type(told).__name__}, no array of numbers; give ({count},)"
        ) from error
    if probabilities.shape != (count,):
        raise InputError(
            f"reachability: told shape {probabilities.shape} about {count} pairs; give ({count},), "
            "one probability for each"
        )
    wrong = np.flatnonzero(~((probabilities >= 0.0) & (probabilities <= 1.0)))
    if wrong.size:
        raise InputError(
            f"reachability: told {probabilities[wrong[0]]:g} about pair {wrong[0]}; give "
            "probabilities from 0 to 1, of a logit the sigmoid"
        )
    return probabilities
