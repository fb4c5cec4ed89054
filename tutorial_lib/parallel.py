"""The same work in many worlds, on all cores."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from joblib import Parallel, delayed
from tqdm.auto import tqdm

from tutorial_lib.learning.estimators import use_threads


def in_each_world(
    work: Callable[..., Any], places: Sequence[Any], *arguments: object, label: str
) -> list[Any]:
    """What `work(place, *arguments)` finds in each place, in their order.

    Networks use one thread in each worker, so that the workers do not wait for each other.

    Args:
        work: a function of a module; what it takes and gives can be pickled.
        places: worlds, or maps' files.
        arguments: the same for all.
        label: of the bar that tells how far it is.
    """
    run_all = Parallel(n_jobs=-1, return_as="generator")
    found = run_all(delayed(_alone)(work, place, *arguments) for place in places)
    return list(tqdm(found, total=len(places), desc=label, disable=None))


def _alone(work: Callable[..., Any], place: object, *arguments: object) -> Any:  # noqa: ANN401
    use_threads(1)
    return work(place, *arguments)
