"""A robot that lives in a building: explores with ghost nodes, remembers, and finds itself again.

Beyond the three papers. Neural Topological SLAM with what it lacks over a life of many goals: walls
correct its heading at every node, every look is remembered, a ghost far away must be worth the
drive, and a robot that was carried away notices, begins another graph, and joins both where it
recognises a place.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.lifelong.islands import Island, Islands
from tutorial_lib.agents.looks import Looks, Sight, not_at
from tutorial_lib.agents.nts import NTSAgent, NTSSettings
from tutorial_lib.exploration.exploring_robot import Destination, ExploringRobot
from tutorial_lib.exploration.goal_search import Sensed
from tutorial_lib.exploration.graph_update import Memory
from tutorial_lib.interfaces import ExplorationModel
from tutorial_lib.observation import Observation
from tutorial_lib.validation import flag, instance, number


@dataclass(frozen=True)
class LifelongSettings:
    """The ingredients, each of which can be left out.

    Attributes:
        exploring: of the explorer inside, which closes loops.
        recalls_looks: goals are looked for in all looks, not only in those of nodes.
        travel: score that a ghost loses with every metre of the drive to it.
        relocates: a robot that was carried away notices, and finds its graph again.
    """

    exploring: NTSSettings = field(default_factory=lambda: NTSSettings(closes_loops=True))
    recalls_looks: bool = True
    travel: float = 0.02
    relocates: bool = True

    def __post_init__(self) -> None:
        instance("exploring", self.exploring, NTSSettings)
        flag("recalls_looks", self.recalls_looks)
        number("travel", self.travel, least=0.0)
        flag("relocates", self.relocates)


class LifelongAgent(NTSAgent):
    """A `SequentialExplorer` that knows a building better with every goal.

    Attributes:
        looks: of each of the N robots.
        islands: graphs of each robot that are not joined with the one it is in.
    """

    def __init__(
        self,
        model: ExplorationModel,
        rng: np.random.Generator,
        settings: LifelongSettings | None = None,
    ) -> None:
        """Explore with `model`; `rng` breaks ties, from a stream of its own for each robot."""
        settings = LifelongSettings() if settings is None else settings
        self._rules = instance("settings", settings, LifelongSettings)
        super().__init__(model, rng, settings.exploring)

    def start(self, goals: Observation) -> None:
        """Begin lives with `goals` (N,); forget all before."""
        super().start(goals)
        count = len(goals)
        self.looks = [Looks() for _ in range(count)]
        self.islands = [Islands(self._model, self._settings.same_node) for _ in range(count)]
        self._sights: list[list[Sight]] = [[] for _ in range(count)]
        self._numbers = {id(robot): number for number, robot in enumerate(self.robots)}

    def look_for(self, goals: Observation) -> None:
        """Go on to other goals (N,), and keep graphs, looks and maps."""
        self._sights = [[] for _ in self.robots]
        super().look_for(goals)

    def _recalled(self, number: int) -> Destination | None:
        """Where the goal was seen; what was seen elsewhere of it is kept for later."""
        if not self._rules.recalls_looks:
            return super()._recalled(number)
        least = self._settings.search.visible
        self._sights[number] = self.looks[number].of(self._model, self.search.goals[number], least)
        return self._next_sight(number)

    def _next_sight(self, number: int) -> Destination | None:
        """The place of the most probable sight that is left."""
        sights = self._sights[number]
        return Destination(sights[0].node, sights[0].place) if sights else None

    def _remember(self, sensed: Sensed) -> None:
        """Update the graphs; before that, robots that were carried away notice it."""
        looking = sensed.robots[sensed.looking]
        odometry, ranges = sensed.odometry[sensed.looking], sensed.ranges[sensed.looking]
        if self._rules.relocates:
            for row, number in enumerate(looking.tolist()):
                self._relocate(number, odometry[row], ranges[row], sensed.features[row])
        super()._remember(sensed)
        for row, number in enumerate(looking.tolist()):
            memory = self.robots[number].memory
            self.looks[number].keep(memory.node, memory.offset, sensed.features[row])

    def _relocate(
        self, number: int, odometry: NDArray, ranges: NDArray, features: NDArray[np.float32]
    ) -> None:
        """Begin another graph where the walls do not go on; join graphs at a known place."""
        robot, islands = self.robots[number], self.islands[number]
        if islands.was_carried(odometry, ranges):
            islands.leave(Island(robot.memory, self.looks[number], robot.scores))
            graph = type(robot.memory.graph)(self._settings.directions, self._settings.radius)
            robot.memory, robot.scores, self.looks[number] = Memory(graph), [], Looks()
            robot.memory.move(odometry)
            self._sights[number] = []
            robot.go_to(None)
        found = islands.recognise(odometry, ranges, features)
        if found is not None:
            here = Island(robot.memory, self.looks[number], robot.scores)
            joined = islands.join(found, here)
            robot.memory, self.looks[number], robot.scores = (
                joined.memory,
                joined.looks,
                joined.scores,
            )
            self._rescore(number)
            robot.go_to(self._recalled(number))

    def _rescore(self, number: int) -> None:
        """Scores of all nodes towards the present goal."""
        robot = self.robots[number]
        nodes = np.array(robot.memory.features)
        robot.scores = list(self._scores(nodes, np.full(len(nodes), number)))

    def _resolve(self, robot: ExploringRobot) -> bool:
        """A destination was reached; a sight whose goal was not there is forgotten."""
        destination, number = robot.destination, self._numbers[id(robot)]
        if destination is not None and destination.ghost is None:
            poses = robot.memory.graph.poses_from(destination.node)
            self._sights[number] = not_at(self._sights[number], destination.place, poses)
        return super()._resolve(robot)

    def _choose(self, robot: ExploringRobot) -> Destination:
        """The next sight of the goal; then the ghost whose score is worth the drive."""
        sight = self._next_sight(self._numbers[id(robot)])
        if sight is not None:
            return sight
        if not self._rules.travel:
            return super()._choose(robot)
        metres = robot.memory.graph.metres_from(robot.memory.node)
        scores, kept = robot.scores, np.array(robot.scores)
        robot.scores = list(kept - self._rules.travel * metres[:, None])
        chosen = super()._choose(robot)
        robot.scores = scores
        return chosen
