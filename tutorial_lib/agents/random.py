"""An agent that learns nothing and drives at random until it sees the goal in front of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tutorial_lib.driving.control.composed import ComposedController, RandomWaypoints
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import (
    Controller,
    Experience,
    Goals,
    Observation,
    Robots,
    WaypointPredictor,
)
from tutorial_lib.topology.following.transitions import FollowerSettings
from tutorial_lib.validation import instance, instances, with_methods


@dataclass(frozen=True)
class RandomAgent:
    """The random `Agent` that brackets the others.

    Attributes:
        predictor: C_WP, by which it recognises the goal.
        controller: C_RMP.
        rng: draws waypoints.
    """

    predictor: WaypointPredictor
    controller: Controller
    rng: np.random.Generator

    def __post_init__(self) -> None:
        with_methods("predictor", self.predictor, "prepare", "predict")
        with_methods("controller", self.controller, "act")
        instance("rng", self.rng, np.random.Generator)

    def learn(self, experiences: Sequence[Experience]) -> None:
        """Nothing, of experiences."""
        instances("experiences", experiences, Experience)

    def start(self, goals: Sequence[Goals]) -> RandomNavigation:
        """Send robots to one goal each."""
        return RandomNavigation(self, goals)


class RandomNavigation:
    """A `Navigation` of robots that drive at random.

    Attributes:
        arrived: (N,) sees one of its goal images as from where it was taken.
        given_up: (N,) always false.
    """

    def __init__(self, agent: RandomAgent, goals: Sequence[Goals]) -> None:
        """See `RandomAgent.start`."""
        goals = instances("goals", goals, Goals, empty=False)
        self._agent = agent
        self._control = ComposedController(RandomWaypoints(agent.rng), agent.controller)
        self._robot = np.repeat(np.arange(len(goals)), [len(goal) for goal in goals])
        contexts = np.concatenate([goal.contexts for goal in goals])
        self._targets = agent.predictor.prepare(contexts)
        self._rules = FollowerSettings()
        self.arrived, self.given_up = np.zeros((2, len(goals)), dtype=bool)

    def act(self, observations: Observation, robots: Robots) -> Array:
        """Actions (M, 2); a robot that has arrived stands still."""
        goals = np.flatnonzero(np.isin(self._robot, robots))
        rows = np.searchsorted(robots, self._robot[goals])
        waypoints, overlaps = self._agent.predictor.predict(
            observations[rows], self._targets[goals]
        )
        near = np.linalg.norm(waypoints, axis=1) < self._rules.at
        there = near & (overlaps.mean(axis=1) > self._rules.visited)
        self.arrived[self._robot[goals[there]]] = True
        actions = self._control.act(observations, robots)
        return np.where(self.arrived[robots, None], 0.0, actions)
