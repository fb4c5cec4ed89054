"""Queries of a `Reachability`: a network, an oracle or a function. Its output is checked."""

from typing import Any

import numpy as np

from tutorial_lib.array_forms import as_array
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Observation, Reachability
from tutorial_lib.validation import instance, integers


def check_seen(observations: Observation) -> None:
    """What robots observe; indices will do for a reachability that knows the images itself.

    Raises:
        InputError: when it is something else.
    """
    if isinstance(observations, np.ndarray) and observations.dtype.kind in "iu":
        integers("observations", observations, ("N",))
    else:
        instance("observations", observations, Observation)


def query(reachability: Reachability, observations: Observation, prepared: Any) -> Array:  # noqa: ANN401
    """RE of Meng 2020 (III-C): the probability that each robot reaches its target.

    Args:
        reachability: RE.
        observations: N robots.
        prepared: N targets from `reachability.prepare`.

    Returns:
        (N,) probabilities.

    Raises:
        InputError: when RE does not return N probabilities; it says what came instead.
    """
    count = len(observations)
    if not count:
        return np.empty(0)
    output = as_array(
        "reachability",
        reachability.probability(observations, prepared),
        "biuf",
        "probabilities",
        (count,),
        True,
    )
    probabilities = output.astype(float, copy=False)
    wrong = np.flatnonzero(~((probabilities >= 0.0) & (probabilities <= 1.0)))
    if wrong.size:
        raise InputError(
            f"reachability: {probabilities[wrong[0]]:g} for pair {wrong[0]}; give "
            "probabilities from 0 to 1, of a logit the sigmoid"
        )
    return probabilities
