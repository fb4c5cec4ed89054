"""LTVN's agent in the robot that explores, whose panorama holds what a camera ahead would see.

It needs no edges in reverse: the robot turns where it stands, and over its shoulder a panorama has
seen the path back.
"""

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.ltvn import LTVNAgent
from tutorial_lib.agents.ltvn_navigation import LTVNNavigation
from tutorial_lib.exploration.bearings import bearing_of
from tutorial_lib.exploration.goal_search import of_all
from tutorial_lib.exploration.local_map import LocalMaps
from tutorial_lib.exploration.local_policy import LocalPolicy
from tutorial_lib.exploration.turned_views import turned
from tutorial_lib.observation import Goals, Observation
from tutorial_lib.se2 import wrap
from tutorial_lib.validation import instance
from tutorial_lib.world.noise import LEFT, RIGHT, STOP

_HEADINGS = 6  # evenly spaced, in which a goal may be seen
_STEPS = 5  # of 0.1 s, that an action takes


class DiscreteLTVN:
    """An `ExplorerAgent` that navigates over a map, and stops where it finds no path.

    Attributes:
        navigation: over the map.
    """

    def __init__(self, memory: LTVNAgent) -> None:
        """Navigate with what `memory` learned from trajectories such as those of `visit`."""
        self._memory = instance("memory", memory, LTVNAgent)
        self._headings = bearing_of(np.arange(_HEADINGS), _HEADINGS)

    def start(self, goals: Observation) -> None:
        """Begin on the way to `goals` (N,), panoramas; see `ExplorerAgent`."""
        count = len(instance("goals", goals, Observation))
        seen = [self._goal(goals[np.full(_HEADINGS, n)]) for n in range(count)]
        self.navigation: LTVNNavigation = self._memory.start(seen)
        self._policy = LocalPolicy(LocalMaps(count))

    def act(self, observations: Observation, running: NDArray[np.bool_]) -> NDArray[np.intp]:
        """Actions (N,) of all robots; those not `running` (N,) stop."""
        navigation, actions = self.navigation, np.full(len(running), STOP)
        robots = np.flatnonzero(of_all(observations, running, len(navigation.states)))
        here = observations[robots]
        ahead = turned(here, 0.0, with_depth=True)  # checks that there is depth
        self._policy.maps.observe(robots, here.odometry, np.asarray(here.depth))
        for _ in range(_STEPS):
            navigation.act(ahead, robots)
        under_way = robots[~(navigation.arrived | navigation.given_up)[robots]]
        driving = []
        for robot in under_way.tolist():
            leg = navigation.states[robot].leg
            if leg is None:
                actions[robot] = LEFT
            elif leg.turn:
                aside = wrap(leg.aim[2] - observations.odometry[robot, 2])
                actions[robot] = LEFT if aside > 0 else RIGHT
            else:
                driving.append((robot, leg.aim[:2]))
        if driving:
            mine = np.array([robot for robot, _ in driving])
            aims = np.array([aim for _, aim in driving])
            actions[mine] = self._policy.act(mine, observations.odometry[mine], aims)[0]
        return actions

    def _goal(self, panoramas: Observation) -> Goals:
        """The view of a goal, of those in all directions, to which most surely an image leads."""
        sampled, model = self._memory.sampled, self._memory.model
        views = turned(panoramas, self._headings, with_depth=True)
        images = model.view.of(views)[:, None]
        sure = [
            sampled.pool.lead_to(sampled.vertices, model.prepare(images[[i]]))[0].max(initial=0.0)
            for i in range(len(images))
        ]
        best = [int(np.argmax(sure))]
        return Goals(views[best], images[best])
