"""How sure RE is along recorded drives: on open floor, where it hardly is, a trip shows little."""

from __future__ import annotations

import numpy as np

from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.experiments.protocols.navigation_tasks import Building
from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping.sparsify import contextified
from tutorial_lib.topology.query import query

STEP = 5
"""Frames from one place on a drive to the next: about half a metre."""


def sureness(building: Building, agent: MengAgent) -> list[Array]:
    """RE (S,) from each place on a drive to the next, for all drives of a building."""
    return [_along(building, number, agent) for number in range(len(building.pairs))]


def _along(building: Building, number: int, agent: MengAgent) -> Array:
    seen = building.recorded.observe(building.recorded.frames_of(number))
    images = agent.predictor.view.of(seen)
    targets = contextified(images, agent.predictor.k)[STEP::STEP]
    prepared = agent.reachability.prepare(targets)
    return query(agent.reachability, seen[np.arange(len(targets)) * STEP], prepared)
