"""Noticing a goal and going to it: what all agents share (Chaplot et al. 2020, 4.1 and 5.1)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.exploration.local_map import LocalMaps
from tutorial_lib.exploration.local_policy import LocalPolicy
from tutorial_lib.interfaces import ExplorationModel
from tutorial_lib.observation import Observation
from tutorial_lib.se2 import Array, to_world
from tutorial_lib.validation import flags, instance, number, with_methods
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.noise import STOP

_SAME = 1.5  # metres between two estimates of one goal, at most
_SPREAD = (0.1, 0.15)  # metres of an estimate's error, and the same for each metre to the goal
_SHIFT = 0.05  # metres from which on a map is drawn anew
_NEAR = 1.0  # metres from which a goal counts where one was missed before
_REFUSED = 4  # places of missed goals that a robot remembers
_BESIDE = 0.4  # metres beyond those at which it stops, from which it looks at every step
_AT_END = 0.15  # metres from the end of a path at which a robot has come to it: half an action


@dataclass(frozen=True)
class SearchSettings:
    """When a goal is noticed and reached.

    Attributes:
        visible: probability of F_L from which a goal is taken to be visible.
        stop_within: estimated metres from the goal at which a robot stops; success needs 1 m.
        look_every: metres between two places at which a robot compares what it sees.
    """

    visible: float = 0.5
    stop_within: float = 0.6
    look_every: float = 0.5

    def __post_init__(self) -> None:
        for name in ("visible", "stop_within", "look_every"):
            number(name, getattr(self, name), least=0.0)


def checked_model(model: ExplorationModel) -> ExplorationModel:
    """A model with all functions that exploration asks."""
    functions = ("embed", "explorable", "same_node", "scores", "relative", "ranges")
    return with_methods("model", model, *functions)


@dataclass(frozen=True, eq=False)
class Sensed:
    """What the robots that are under way sense in one step.

    Attributes:
        robots: (M,) indices.
        odometry: (M, 3).
        ranges: (M, W) metres.
        looking: (L,) which of the M compare what they see with goal and nodes.
        features: (L, D) of what these see.
        cars: whether the robots are cars, which drive to waypoints.
    """

    robots: NDArray[np.intp]
    odometry: Array
    ranges: Array
    looking: NDArray[np.intp]
    features: NDArray[np.float32]
    cars: bool


def of_all(observations: Observation, running: NDArray[np.bool_], count: int) -> NDArray[np.bool_]:
    """Which of so many robots are under way (N,), if all of them are observed."""
    if len(instance("observations", observations, Observation)) != count:
        raise InputError(f"observations: {len(observations)}; give {count}, of all robots")
    return flags("running", running, (count,))


class GoalSearch:
    """N robots with a local map each that go to their goal once they see it, and stop there.

    Beyond the paper: estimates of a goal's place from several panoramas are averaged, and a robot
    that comes to that place and does not see the goal refuses it: there it believes in a goal again
    only from within a metre.

    Attributes:
        maps: the local maps.
        goals: (N, D) features of the goals.
        found: (N,) whether a robot knows where its goal is.
        places: (N, 2) where, in the frame of its odometry.
        left: (N,) metres in a straight line to the end of its path; infinite where that path led to
            a goal that was missed.
    """

    def __init__(
        self,
        model: ExplorationModel,
        goals: Observation,
        settings: SearchSettings,
        maps: LocalMaps | None = None,
    ) -> None:
        """Look for `goals` (N,), and drive over `maps`; over small ones unless given."""
        count = len(goals)
        self._model, self._settings = model, settings
        self.maps = LocalMaps(count) if maps is None else maps
        self.left = np.full(count, np.inf)
        self._policy = LocalPolicy(self.maps)
        self._looked, self._mapped = np.full((2, count, 2), np.nan)
        self.look_for(goals)

    def look_for(self, goals: Observation) -> None:
        """Look for other goals (N,), and keep the maps."""
        instance("goals", goals, Observation)
        if len(goals) != len(self.left):
            raise InputError(f"goals: {len(goals)}; give {len(self.left)}, one a robot")
        count = len(goals)
        self.goals = self._model.embed(goals)
        self.found, self.places = np.zeros(count, bool), np.zeros((count, 2))
        self._weight, self._sure = np.zeros(count), np.zeros(count, bool)
        self._refused = np.full((count, _REFUSED, 2), np.inf)
        self._looked[:] = np.nan

    def restart(self, robot: int, poses: Array, ranges: Array) -> None:
        """Go on in another frame of odometry: the goal is not found, the map is drawn anew.

        Args:
            robot: its number.
            poses: (K, 3) from where it has seen something in that frame.
            ranges: (K, W) metres in each column of what it saw.
        """
        self.found[robot], self.left[robot] = False, np.inf
        self._weight[robot], self._refused[robot] = 0.0, np.inf
        self._looked[robot] = self._mapped[robot] = np.nan
        self.maps.forget(robot)
        for pose, seen in zip(poses, ranges, strict=True):
            self.maps.observe(np.array([robot]), pose[None], seen[None])

    def look_again(self, robots: NDArray[np.intp]) -> None:
        """Let these robots look in the next step, wherever they are."""
        self._looked[robots] = np.nan

    def sense(self, observations: Observation, running: NDArray[np.bool_]) -> Sensed:
        """Enter what the running robots see into their maps, and look for the goals.

        Args:
            observations: of all N robots.
            running: (N,) which of them are under way.
        """
        running = of_all(observations, running, len(self.found))
        robots = np.flatnonzero(running)
        here = observations[robots]
        ranges = self._model.ranges(here)
        # Turning in place shows nothing new.
        gone = np.linalg.norm(here.odometry[:, :2] - self._mapped[robots], axis=1)
        new = np.flatnonzero(~(gone < _SHIFT))
        self.maps.observe(robots[new], here.odometry[new], ranges[new])
        self._mapped[robots[new]] = here.odometry[new, :2]
        moved = np.linalg.norm(here.odometry[:, :2] - self._looked[robots], axis=1)
        near = self.found[robots] & (self._gap(robots, here.odometry) < self._near)
        looking = np.flatnonzero(~(moved < self._settings.look_every) | (near & (moved > 0.1)))
        features = self._model.embed(here[looking])
        self._looked[robots[looking]] = here.odometry[looking, :2]
        self._look(robots[looking], here.odometry[looking], features)
        cars = isinstance(here.body, BicycleCar)
        return Sensed(robots, here.odometry, ranges, looking, features, cars)

    def drive(self, sensed: Sensed, targets: Array) -> NDArray:
        """Actions of all robots: to the goals that were found, else to `targets` (N, 2).

        Discrete ones (N,); or waypoints (N, 2) of cars, see `interfaces.ExplorerAgent`.
        """
        robots = sensed.robots
        targets = np.where(self.found[:, None], self.places, targets)[robots]
        policy, stop = (self._policy.waypoints, np.nan) if sensed.cars else (self._policy.act, STOP)
        moves, self.left[robots] = policy(robots, sensed.odometry, targets)
        moves[self._arrived(robots, sensed.odometry)] = stop
        actions = np.full((len(self.found), *moves.shape[1:]), stop)
        actions[robots] = moves
        return actions

    @property
    def _near(self) -> float:
        return self._settings.stop_within + _BESIDE

    def _gap(self, robots: NDArray[np.intp], odometry: Array) -> Array:
        """Metres from robots to where their goals seem to be."""
        return np.linalg.norm(self.places[robots] - odometry[:, :2], axis=1)

    def _look(
        self, robots: NDArray[np.intp], odometry: Array, features: NDArray[np.float32]
    ) -> None:
        """Where goals are visible, estimate their places, the mean of what is seen of them."""
        goals = self.goals[robots]
        self._sure[robots] = self._model.same_node(features, goals) >= self._settings.visible
        seen = np.flatnonzero(self._sure[robots])
        if not len(seen):
            return
        bearing, metres = self._model.relative(features[seen], goals[seen]).T
        local = metres[:, None] * np.stack([np.cos(bearing), np.sin(bearing)], axis=1)
        places = to_world(odometry[seen], local)
        gaps = np.linalg.norm(places[:, None] - self._refused[robots[seen]], axis=2)
        refused = (gaps < _SAME).any(axis=1) & (metres > _NEAR)
        self._sure[robots[seen[refused]]] = False
        seen, places, metres = seen[~refused], places[~refused], metres[~refused]
        mine = robots[seen]
        weight = 1.0 / (_SPREAD[0] + _SPREAD[1] * metres) ** 2
        apart = np.linalg.norm(places - self.places[mine], axis=1) > _SAME
        known = np.where(self.found[mine] & ~apart, self._weight[mine], 0.0)
        share = (weight / (weight + known))[:, None]
        self.places[mine] = share * places + (1 - share) * self.places[mine]
        self._weight[mine], self.found[mine] = weight + known, True

    def _arrived(self, robots: NDArray[np.intp], odometry: Array) -> NDArray[np.bool_]:
        """(M,) whether to stop; a goal that is not where it seemed is looked for elsewhere."""
        gap, found = self._gap(robots, odometry), self.found[robots]
        there = found & (gap < self._settings.stop_within)
        stop = there & self._sure[robots]
        stuck = found & (self.left[robots] < _AT_END) & ~stop
        lost = robots[(there & ~self._sure[robots]) | stuck]
        self._refused[lost] = np.roll(self._refused[lost], 1, axis=1)
        self._refused[lost, 0] = self.places[lost]
        # What is left of the path to a goal says nothing of that to an agent's own target.
        self.found[lost], self.left[lost] = False, np.inf
        return stop
