"""Frontier exploration on a metric map: the nearest frontier, or the one that a scorer prefers."""

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.looks import Looks, not_at
from tutorial_lib.exploration.frontier import (
    CROP,
    SIDE,
    Frontiers,
    all_frontiers,
    crops,
    is_frontier,
    nearest_frontiers,
)
from tutorial_lib.exploration.goal_search import GoalSearch, SearchSettings, Sensed, checked_model
from tutorial_lib.exploration.grid_kernels import FREE
from tutorial_lib.exploration.local_map import REACH, LocalMaps
from tutorial_lib.interfaces import ExplorationModel, FrontierScorer
from tutorial_lib.observation import Observation
from tutorial_lib.se2 import Array, to_local
from tutorial_lib.validation import flag, instance, number, with_methods

_ARRIVED = 0.4  # metres from a frontier, or from the end of the path to it
_TIMEOUT = (40, 12)  # steps towards a frontier, and the same for each metre


class FrontierAgent:
    """An `ExplorerAgent` that goes to frontiers of its metric map (section 5.1, "FBE + Local").

    As in the paper it notices goals and goes to them as the other agents do. The map is of the
    depth that the camera measures or the model predicts, by the robot's odometry, whose noise blurs
    it. As the agent with ghost nodes does, it looks again wherever it has arrived, and goes to
    random places that it has seen once there is nothing left to explore.

    Attributes:
        search: the robots' maps and goals.
        looks: of each robot, where it recalls goals from them.
    """

    def __init__(
        self,
        model: ExplorationModel,
        settings: SearchSettings | None = None,
        *,
        scorer: FrontierScorer | None = None,
        reach: float = REACH,
        recalls: bool = False,
        rng: np.random.Generator | None = None,
    ) -> None:
        """Explore.

        Args:
            model: notices goals.
            settings: when it does.
            scorer: prefers frontiers, as Active Neural SLAM's global policy does; without it the
                nearest one is taken.
            reach: metres of depth that are entered into the map.
            recalls: goes to where it saw a goal while it looked for others; without, only its map
                outlives a goal.
            rng: draws places once no frontier is left, from a stream of its own for each robot;
                of seed 0 unless given.
        """
        self._model, self._scorer = checked_model(model), scorer
        if scorer is not None:
            with_methods("scorer", scorer, "score")
        if rng is not None:
            instance("rng", rng, np.random.Generator)
        if settings is not None:
            instance("settings", settings, SearchSettings)
        self._reach, self._recalls = number("reach", reach, least=0.0), flag("recalls", recalls)
        self._settings = SearchSettings() if settings is None else settings
        self._rng = np.random.default_rng(0) if rng is None else rng

    def start(self, goals: Observation) -> None:
        """Begin episodes towards `goals` (N,); forget all before."""
        instance("goals", goals, Observation)
        count = len(goals)
        maps = LocalMaps(count, SIDE, self._reach)
        self.search = GoalSearch(self._model, goals, self._settings, maps)
        self._targets, self._left = np.full((count, 2), np.nan), np.zeros(count)
        self._returns, self._streams = np.zeros(count, bool), self._rng.spawn(count)
        self.looks = [Looks() for _ in range(count)]
        self._sights = [np.zeros((0, 2))] * count

    def look_for(self, goals: Observation) -> None:
        """Go on to other goals (N,), and keep the maps."""
        self.search.look_for(goals)
        self._targets[:] = np.nan
        if self._recalls:
            least = self._settings.visible
            rows = zip(self.looks, self.search.goals, strict=True)
            self._sights = [looks.places(self._model, goal, least) for looks, goal in rows]

    def act(self, observations: Observation, running: NDArray[np.bool_]) -> NDArray:
        """Actions (N,) of all robots, waypoints (N, 2) of cars; those not `running` (N,) stop."""
        sensed = self.search.sense(observations, running)
        if self._recalls:
            rows = zip(sensed.looking.tolist(), sensed.features, strict=True)
            for row, features in rows:
                self.looks[sensed.robots[row]].keep(sensed.odometry[row], features)
        due = self._due(sensed)
        if self._scorer is not None:  # it compares what is seen, so robots look first
            self.search.look_again(sensed.robots[due])
            due = np.intersect1d(due, sensed.looking)
        if len(due):
            self._choose(sensed, due)
        self._left[sensed.robots] -= ~self.search.found[sensed.robots]
        actions = self.search.drive(sensed, self._targets)
        if self._scorer is not None:  # one that missed its goal before it had any other target
            aimless = np.isnan(self._targets[:, 0]) & ~self.search.found
            self.search.look_again(np.flatnonzero(aimless))
        return actions

    def _due(self, sensed: Sensed) -> NDArray[np.intp]:
        """Rows of robots that need a target: theirs was seen, reached, or takes too long.

        One that goes to its goal does not: its way there says nothing of the frontier.
        """
        rows = np.flatnonzero(~self.search.found[sensed.robots])
        robots, targets = sensed.robots[rows], self._targets[sensed.robots[rows]]
        none = np.isnan(targets[:, 0])
        gap = np.linalg.norm(targets - sensed.odometry[rows, :2], axis=1)
        there = np.minimum(gap, self.search.left[robots]) < _ARRIVED
        over = ~none & (there | (self._left[robots] <= 0))
        is_open = is_frontier(self.search.maps, robots, np.where(none[:, None], 0.0, targets))
        closed = over & is_open & ~self._returns[robots]
        self.search.maps.close(robots[closed], targets[closed])
        self.search.look_again(robots[over])
        for robot in robots[over & self._returns[robots]]:
            self._sights[robot] = not_at(self._sights[robot], self._targets[robot])
        return rows[none | over | ~(is_open | self._returns[robots])]

    def _choose(self, sensed: Sensed, due: NDArray[np.intp]) -> None:
        """Choose frontiers for the robots in these rows; a place seen for one without any."""
        robots, odometry = sensed.robots[due], sensed.odometry[due]
        if self._scorer is None:
            found = nearest_frontiers(self.search.maps, robots, odometry)
            best = np.arange(len(found.robots))
        else:
            found = all_frontiers(self.search.maps, robots, odometry)
            scores = self._scores(self._scorer, sensed, due, found)
            order = np.lexsort((-scores, found.robots))
            best = order[np.unique(found.robots[order], return_index=True)[1]]
        chosen = robots[found.robots[best]]
        self._returns[robots], self._returns[chosen] = True, False
        self._targets[chosen] = found.places[best]
        self._left[chosen] = _TIMEOUT[0] + _TIMEOUT[1] * found.metres[best]
        for robot, here in zip(robots, odometry[:, :2], strict=True):
            sights = self._sights[robot]
            if len(sights) or self._returns[robot]:
                self._returns[robot] = True
                self._targets[robot] = sights[0] if len(sights) else self._seen_place(robot)
                metres = float(np.linalg.norm(self._targets[robot] - here))
                self._left[robot] = _TIMEOUT[0] + _TIMEOUT[1] * metres

    def _seen_place(self, robot: int) -> Array:
        """(2,) a random free place of a robot's map."""
        free = np.flatnonzero(self.search.maps.grids[robot].ravel() == FREE)
        cell = free[self._streams[robot].integers(len(free))]
        return self.search.maps.centres(np.array([robot]), np.array([cell]))[0]

    def _scores(
        self, scorer: FrontierScorer, sensed: Sensed, due: NDArray[np.intp], found: Frontiers
    ) -> Array:
        """Scores of frontiers (F,)."""
        robots, odometry = sensed.robots[due], sensed.odometry[due]
        here = sensed.features[np.searchsorted(sensed.looking, due)]
        local = to_local(odometry[found.robots], found.places)
        parts = np.column_stack([local, found.metres])
        around = crops(self.search.maps, robots, odometry, CROP)
        return scorer.score(around, here, self.search.goals[robots], parts, found.robots)
