"""Frontier exploration on a metric map: the nearest frontier, or the one that a scorer prefers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.exploration.bearings import RADIUS
from tutorial_lib.exploration.frontier import (
    Frontiers,
    all_frontiers,
    crops,
    is_frontier,
    nearest_frontiers,
)
from tutorial_lib.exploration.goal_search import GoalSearch, SearchSettings, Sensed
from tutorial_lib.exploration.local_map import LocalMaps
from tutorial_lib.geometry import Array, to_local
from tutorial_lib.interfaces import ExplorationModel, FrontierScorer
from tutorial_lib.observation import Observation

SIDE = 24.0
"""Metres of the metric map; a robot that leaves its middle forgets what is far behind it."""
CROP = 96
"""Cells along a side of the part of the map that a scorer gets."""
_ARRIVED = 0.4  # metres from a frontier, or from the end of the path to it
_PATIENCE = (40, 12)  # steps towards a frontier, and the same for each metre


class FrontierAgent:
    """An `ExplorerAgent` that goes to frontiers of its metric map (section 5.1, "FBE + Local").

    As in the paper it notices goals and goes to them as the other agents do. The map is of what the
    depth camera saw, by the robot's odometry; noise of the odometry blurs it.

    Attributes:
        search: the robots' maps and goals.
    """

    def __init__(
        self,
        model: ExplorationModel,
        settings: SearchSettings | None = None,
        *,
        scorer: FrontierScorer | None = None,
        reach: float = RADIUS,
    ) -> None:
        """Explore.

        Args:
            model: notices goals.
            settings: when it does.
            scorer: prefers frontiers, as Active Neural SLAM's global policy does; without it the
                nearest one is taken.
            reach: metres of depth that are entered into the map.
        """
        self._model, self._scorer, self._reach = model, scorer, reach
        self._settings = SearchSettings() if settings is None else settings

    def start(self, goals: Observation) -> None:
        """Begin episodes towards `goals` (N,); forget all before."""
        count = len(goals)
        maps = LocalMaps(count, SIDE, self._reach)
        self.search = GoalSearch(self._model, goals, self._settings, maps)
        self._targets, self._left = np.full((count, 2), np.nan), np.zeros(count)

    def act(self, observations: Observation, running: NDArray[np.bool_]) -> NDArray[np.intp]:
        """Actions (N,) of all robots; those not `running` (N,) stop."""
        sensed = self.search.sense(observations, running)
        due = np.flatnonzero(self._is_due(sensed))
        if self._scorer is not None:  # it compares what is seen, so robots look first
            self.search.look_again(sensed.robots[due])
            due = np.intersect1d(due, sensed.looking)
        if len(due):
            self._choose(sensed, due)
        self._left -= 1
        return self.search.drive(sensed, self._targets)

    def _is_due(self, sensed: Sensed) -> NDArray[np.bool_]:
        """(M,) whether a robot needs a frontier: its own was seen, reached, or takes too long."""
        robots, targets = sensed.robots, self._targets[sensed.robots]
        none = np.isnan(targets[:, 0])
        gap = np.linalg.norm(targets - sensed.odometry[:, :2], axis=1)
        there = np.minimum(gap, self.search.left[robots]) < _ARRIVED
        open_yet = is_frontier(self.search.maps, robots, np.where(none[:, None], 0.0, targets))
        closed = ~none & open_yet & (there | (self._left[robots] <= 0))
        self.search.maps.close(robots[closed], targets[closed])
        return none | closed | ~open_yet

    def _choose(self, sensed: Sensed, due: NDArray[np.intp]) -> None:
        """Choose frontiers for the robots in these rows; one without any stays where it goes."""
        robots, odometry = sensed.robots[due], sensed.odometry[due]
        if self._scorer is None:
            found = nearest_frontiers(self.search.maps, robots, odometry)
            best = np.arange(len(found.robots))
        else:
            found = all_frontiers(self.search.maps, robots, odometry)
            scores = self._scores(sensed, due, found)
            order = np.lexsort((-scores, found.robots))
            best = order[np.unique(found.robots[order], return_index=True)[1]]
        chosen = robots[found.robots[best]]
        self._targets[robots] = odometry[:, :2]
        self._targets[chosen] = found.places[best]
        self._left[chosen] = _PATIENCE[0] + _PATIENCE[1] * found.metres[best]

    def _scores(self, sensed: Sensed, due: NDArray[np.intp], found: Frontiers) -> Array:
        """What the scorer thinks of frontiers (F,)."""
        robots, odometry = sensed.robots[due], sensed.odometry[due]
        here = sensed.features[np.searchsorted(sensed.looking, due)]
        local = to_local(odometry[found.robots], found.places)
        parts = np.column_stack([local, found.metres])
        around = crops(self.search.maps, robots, odometry, CROP)
        return self._scorer.score(around, here, self.search.goals[robots], parts, found.robots)
