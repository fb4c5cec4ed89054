"""An agent that walks at random until it sees its goal: what exploration must be better than."""

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.exploration.bearings import DIRECTIONS, bearing_of
from tutorial_lib.exploration.goal_search import GoalSearch, SearchSettings, checked_model
from tutorial_lib.exploration.graph_update import free_metres
from tutorial_lib.interfaces import ExplorationModel
from tutorial_lib.observation import Observation
from tutorial_lib.se2 import to_world
from tutorial_lib.validation import instance

_ARRIVED = 0.4  # metres from a target at which the next is drawn
_LONGEST = 40  # steps towards one target


class RandomWalkAgent:
    """An `ExplorerAgent` that drives to random places in sight, one after another.

    Attributes:
        search: the robots' local maps and goals.
    """

    def __init__(
        self,
        model: ExplorationModel,
        rng: np.random.Generator,
        settings: SearchSettings | None = None,
    ) -> None:
        """Notice goals with `model`; `rng` draws directions, in a stream for each robot."""
        self._model = checked_model(model)
        self._rng = instance("rng", rng, np.random.Generator)
        settings = SearchSettings() if settings is None else settings
        self._settings = instance("settings", settings, SearchSettings)

    def start(self, goals: Observation) -> None:
        """Begin episodes towards `goals` (N,); forget all before."""
        instance("goals", goals, Observation)
        self.search = GoalSearch(self._model, goals, self._settings)
        self._targets, self._left = np.zeros((len(goals), 2)), np.zeros(len(goals))
        self._streams = self._rng.spawn(len(goals))

    def act(self, observations: Observation, running: NDArray[np.bool_]) -> NDArray:
        """Actions (N,) of all robots, waypoints (N, 2) of cars; those not `running` (N,) stop."""
        sensed = self.search.sense(observations, running)
        robots = sensed.robots
        over = (self._left[robots] <= 0) | (self.search.left[robots] < _ARRIVED)
        due = np.flatnonzero(over & ~self.search.found[robots])
        metres = free_metres(sensed.ranges[due])
        # The farther a direction is free, the likelier it is drawn.
        chance = metres + 0.01
        total = chance.cumsum(axis=1)
        luck = np.array([self._streams[robot].random() for robot in robots[due]])
        drawn = (total > luck.reshape(-1, 1) * total[:, -1:]).argmax(axis=1)
        bearing, far = bearing_of(drawn, DIRECTIONS), metres[np.arange(len(due)), drawn]
        local = far[:, None] * np.stack([np.cos(bearing), np.sin(bearing)], axis=1)
        self._targets[robots[due]] = to_world(sensed.odometry[due], local)
        self._left[robots] -= ~self.search.found[robots]
        self._left[robots[due]] = _LONGEST
        return self.search.drive(sensed, self._targets)
