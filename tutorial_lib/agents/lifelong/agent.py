"""A robot that lives in a building: explores with ghost nodes, remembers, and finds itself again.

Beyond the three papers. Neural Topological SLAM with what it lacks over a life of many goals: walls
correct its odometry, every look is remembered, drives lead over a metric map, a ghost far away must
be worth the drive, and a robot that was carried away notices, begins another graph, and joins both
where it recognises a place.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.lifelong.islands import Island, Islands, Recognised
from tutorial_lib.agents.looks import Looks, not_at
from tutorial_lib.agents.nts import NTSAgent, NTSSettings
from tutorial_lib.agents.track import Track
from tutorial_lib.errors import InputError
from tutorial_lib.exploration.exploring_robot import Destination, ExploringRobot
from tutorial_lib.exploration.frontier import SIDE
from tutorial_lib.exploration.ghost_graph import GhostGraph
from tutorial_lib.exploration.goal_search import Sensed, of_all
from tutorial_lib.exploration.graph_update import Memory
from tutorial_lib.exploration.local_map import LocalMaps
from tutorial_lib.interfaces import ExplorationModel
from tutorial_lib.observation import Observation
from tutorial_lib.se2 import Array, to_local, to_world
from tutorial_lib.validation import flag, floats, instance


@dataclass(frozen=True)
class LifelongSettings:
    """The ingredients, each of which can be left out.

    Attributes:
        exploring: of the explorer inside; where it closes loops, walls correct odometry along the
            whole path, too.
        recalls_looks: goals are looked for in all looks, not only in those of nodes.
        metric: drives lead over a map of what was seen around, not from node to node.
        travel: score that a ghost loses with every metre of the drive to it.
        relocates: a robot that was carried away notices, and finds its graph again.
    """

    exploring: NTSSettings = field(default_factory=lambda: NTSSettings(closes_loops=True))
    recalls_looks: bool = True
    metric: bool = True
    travel: float = 0.02
    relocates: bool = True

    def __post_init__(self) -> None:
        instance("exploring", self.exploring, NTSSettings)
        for name in ("recalls_looks", "metric", "relocates"):
            flag(name, getattr(self, name))
        floats("travel", self.travel, (), least=0.0)


class LifelongAgent(NTSAgent):
    """A `SequentialExplorer` that knows a building better with every goal.

    Attributes:
        tracks: of the N robots.
        looks: of each.
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
        self.tracks = [Track() for _ in range(count)]
        self.looks = [Looks() for _ in range(count)]
        self.islands = [Islands(self._model, self._settings.same_node) for _ in range(count)]
        self._sights = [np.zeros((0, 2))] * count
        self._recognised: list[Recognised | None] = [None] * count

    def _maps(self, count: int) -> LocalMaps | None:
        return LocalMaps(count, SIDE) if self._rules.metric else None

    def look_for(self, goals: Observation) -> None:
        """Go on to other goals (N,), and keep graphs, looks and maps."""
        self._sights = [np.zeros((0, 2))] * len(self.robots)
        for track in self.tracks:
            track.ask()  # whoever gives it a goal may have carried it
        super().look_for(goals)

    def act(self, observations: Observation, running: NDArray[np.bool_]) -> NDArray:
        """Actions (N,) of all robots; those not `running` (N,) stop."""
        running = of_all(observations, running, len(self.robots))
        if observations.depth is None:
            raise InputError("observations: panoramas without depth; use the rgbd sensor")
        poses = observations.odometry.copy()
        for number in range(len(self.robots)):
            self.tracks[number].move(observations.odometry[number])
            if running[number]:
                self._locate(number, np.asarray(observations.depth[number], float))
            poses[number] = self.tracks[number].pose
        return super().act(replace(observations, odometry=poses), running)

    def _locate(self, number: int, ranges: NDArray) -> None:
        """Where a robot is: in another graph, in one that it left, or a little beside its track."""
        track, found = self.tracks[number], self._recognised[number]
        self._recognised[number] = None
        due = track.is_due()
        if due and self._rules.relocates and not track.goes_on(ranges):
            self.islands[number].leave(self._island(number))
            graph = GhostGraph(self._settings.directions, self._settings.radius)
            self._go_on_in(number, Island(Memory(graph), Looks(), [], track.begun_anew()))
        elif found is not None:
            self._go_on_in(number, self.islands[number].join(found, self._island(number)))
            return
        if due and self._settings.closes_loops:
            self.tracks[number].correct(ranges)
        elif due:
            self.tracks[number].see(ranges)

    def _island(self, number: int) -> Island:
        """The graph that a robot is in, with all that belongs to it."""
        robot = self.robots[number]
        return Island(robot.memory, self.looks[number], robot.scores, self.tracks[number])

    def _go_on_in(self, number: int, island: Island) -> None:
        """A robot is in another graph from now on, whose frame is another one."""
        robot, track = self.robots[number], island.track
        robot.memory, self.looks[number], robot.scores = island.memory, island.looks, island.scores
        self.tracks[number] = track
        self.search.restart(number, np.array(track.places), np.array(track.ranges))
        nodes = np.array(robot.memory.features)
        if len(nodes):
            robot.scores = list(self._scores(nodes, np.full(len(nodes), number)))
        robot.go_to(self._recalled(number))

    def _recalled(self, number: int) -> Destination | None:
        """Where the goal was seen; where it was seen besides is kept for later."""
        if not self._rules.recalls_looks:
            nodes = self.robots[number].memory.features
            return super()._recalled(number) if nodes else None
        goal, least = self.search.goals[number], self._settings.search.visible
        self._sights[number] = self.looks[number].places(self._model, goal, least)
        return self._next_sight(self.robots[number])

    def _next_sight(self, robot: ExploringRobot) -> Destination | None:
        """The place of the most probable sight that is left."""
        places, memory = self._sights[self.robots.index(robot)], robot.memory
        if not len(places):
            return None
        return Destination(memory.node, to_local(memory.pose_of(memory.node), places[0]))

    def _remember(self, sensed: Sensed) -> None:
        """Update the graphs, and keep every look; a robot that was carried looks about."""
        super()._remember(sensed)
        looking, odometry = sensed.robots[sensed.looking], sensed.odometry[sensed.looking]
        for row, number in enumerate(looking.tolist()):
            pose, features = odometry[row], sensed.features[row]
            self.looks[number].keep(pose, features)
            if self.islands[number].left:
                seen = sensed.ranges[sensed.looking[row]]
                self._recognised[number] = self.islands[number].recognise(pose, seen, features)

    def _resolve(self, robot: ExploringRobot) -> bool:
        """A destination was reached; a sight whose goal was not there is forgotten."""
        destination, number = robot.destination, self.robots.index(robot)
        if destination is not None and destination.ghost is None:
            frame = robot.memory.pose_of(destination.node)
            place = to_world(frame, destination.place)
            self._sights[number] = not_at(self._sights[number], place)
        return super()._resolve(robot)

    def _explore(self, robots: NDArray[np.intp]) -> None:
        """Choose where to go for the robots that have to, and the next point on the path."""
        super()._explore(robots)
        if self._rules.metric:
            for number in robots:
                robot = self.robots[number]
                if robot.destination is not None:
                    frame = robot.memory.pose_of(robot.destination.node)
                    self._targets[number] = to_world(frame, robot.destination.place)
                    self._last[number] = True

    def _choose(self, robot: ExploringRobot) -> Destination:
        """The next sight of the goal; a ghost where there is none left."""
        return self._next_sight(robot) or super()._choose(robot)

    def _worth(self, robot: ExploringRobot) -> Array:
        """What ghosts are worth after the drive to them."""
        metres = robot.memory.graph.metres_from(robot.memory.node)
        return super()._worth(robot) - self._rules.travel * metres[:, None]
