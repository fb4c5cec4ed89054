"""Behaviour cloning (Chaplot et al. 2020, 5.1, "ResNet + GRU + IL"): a recurrent policy alone."""

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.interfaces import RecurrentPolicy
from tutorial_lib.observation import Observation
from tutorial_lib.validation import flags, instance, with_methods
from tutorial_lib.world.noise import STOP


class ImitationAgent:
    """An `ExplorerAgent` that follows a policy, `stop` included."""

    def __init__(self, policy: RecurrentPolicy) -> None:
        """Act by `policy`."""
        self._policy = with_methods("policy", policy, "start", "act")

    def start(self, goals: Observation) -> None:
        """Begin episodes towards `goals` (N,); forget all before."""
        instance("goals", goals, Observation)
        self._state = self._policy.start(goals)

    def act(self, observations: Observation, running: NDArray[np.bool_]) -> NDArray[np.intp]:
        """Actions (N,) of all robots; those not `running` (N,) stop."""
        instance("observations", observations, Observation)
        running = flags("running", running, (len(observations),))
        actions, self._state = self._policy.act(observations, self._state)
        return np.where(running, actions, STOP)
