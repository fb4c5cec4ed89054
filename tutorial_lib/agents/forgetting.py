"""An explorer that forgets everything with each goal."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.interfaces import ExplorerAgent
from tutorial_lib.observation import Observation
from tutorial_lib.validation import with_methods


class Forgetting:
    """A `SequentialExplorer` that begins anew with each goal: the mark for every memory."""

    def __init__(self, explorer: ExplorerAgent) -> None:
        """Explore by `explorer`."""
        self._explorer = with_methods("explorer", explorer, "start", "act")

    def start(self, goals: Observation) -> None:
        """Begin episodes towards `goals` (N,)."""
        self._explorer.start(goals)

    def look_for(self, goals: Observation) -> None:
        """Begin anew, with other goals (N,)."""
        self._explorer.start(goals)

    def act(self, observations: Observation, running: NDArray[np.bool_]) -> NDArray:
        """What the explorer does (N,)."""
        return self._explorer.act(observations, running)
