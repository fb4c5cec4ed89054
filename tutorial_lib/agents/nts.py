"""Neural Topological SLAM (Chaplot et al. 2020): explores by a graph with ghost nodes."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.walls import match_walls
from tutorial_lib.errors import InputError
from tutorial_lib.exploration.bearings import DIRECTIONS, RADIUS, bearing_of
from tutorial_lib.exploration.exploring_robot import Destination, ExploringRobot
from tutorial_lib.exploration.ghost_graph import GhostGraph
from tutorial_lib.exploration.global_policy import choose_ghost, subgoal
from tutorial_lib.exploration.goal_search import GoalSearch, SearchSettings, Sensed, checked_model
from tutorial_lib.exploration.graph_update import GraphUpdate, Localisation, Memory, free_metres
from tutorial_lib.exploration.local_map import LocalMaps
from tutorial_lib.interfaces import ExplorationModel
from tutorial_lib.observation import Observation
from tutorial_lib.se2 import Array, to_world
from tutorial_lib.validation import flag, floats, instance, whole

_APART = 1.0  # metres between a node and a ghost that is explored by a node of its own


@dataclass(frozen=True)
class NTSSettings:
    """The course's agent, the paper's where nothing else is said, and what is changed in it.

    Attributes:
        use_graph: without it, the best direction of the present panorama is taken, and no graph
            is kept (the paper's ablation, section 6.1).
        use_score: without it, scores are random: a ghost is drawn (the other ablation).
        same_node: probability of F_L from which a robot is in a node.
        explorable: probability of F_G from which a direction gets a ghost.
        directions: of each node, as many as the model has; 12 in the paper.
        radius: metres from a node to its ghosts, as of the model's; 3 in the paper.
        localisation: how a robot finds itself in its graph.
        closes_loops: walls say where a robot is in its node, so that drift does not add up (beyond
            the paper).
        search: how the goal is noticed.
    """

    use_graph: bool = True
    use_score: bool = True
    same_node: float = 0.5
    explorable: float = 0.5
    directions: int = DIRECTIONS
    radius: float = RADIUS
    localisation: Localisation = field(default_factory=Localisation)
    closes_loops: bool = False
    search: SearchSettings = field(default_factory=SearchSettings)

    def __post_init__(self) -> None:
        flag("use_graph", self.use_graph)
        flag("use_score", self.use_score)
        flag("closes_loops", self.closes_loops)
        floats("same_node", self.same_node, (), least=0.0)
        floats("explorable", self.explorable, (), least=0.0)
        whole("directions", self.directions, least=1, most=10_000)
        floats("radius", self.radius, (), least=0.1, most=50.0)
        instance("localisation", self.localisation, Localisation)
        instance("search", self.search, SearchSettings)


class NTSAgent:
    """The `ExplorerAgent` after the paper, over any `ExplorationModel`.

    Attributes:
        robots: what each of the N robots remembers, and where it is going.
        search: their local maps and goals.
    """

    def __init__(
        self,
        model: ExplorationModel,
        rng: np.random.Generator,
        settings: NTSSettings | None = None,
    ) -> None:
        """Explore with `model`; `rng` breaks ties, from a stream of its own for each robot."""
        self._model = checked_model(model)
        self._rng = instance("rng", rng, np.random.Generator)
        settings = NTSSettings() if settings is None else settings
        self._settings = instance("settings", settings, NTSSettings)
        chosen = self._settings
        matcher = match_walls if chosen.closes_loops else None
        rules = chosen.radius, chosen.localisation, matcher
        self._update = GraphUpdate(model, chosen.same_node, chosen.explorable, *rules)

    def start(self, goals: Observation) -> None:
        """Begin episodes towards `goals` (N,); forget all before."""
        instance("goals", goals, Observation)
        chosen, count = self._settings, len(goals)
        self.robots = [
            ExploringRobot(rng, Memory(GhostGraph(chosen.directions, chosen.radius)))
            for rng in self._rng.spawn(count)
        ]
        self.search = GoalSearch(self._model, goals, self._settings.search, self._maps(count))
        self._targets, self._last = np.zeros((count, 2)), np.zeros(count, bool)
        self._reacting = np.zeros(count, bool)

    def _maps(self, count: int) -> LocalMaps | None:
        """The maps over which robots drive; small ones, unless a kind of agent has others."""
        del count

    def look_for(self, goals: Observation) -> None:
        """Go on to other goals (N,), and keep graphs and maps (section 6.1)."""
        self.search.look_for(goals)
        self._reacting[:] = False
        for number, robot in enumerate(self.robots):
            robot.go_to(None)
            if robot.memory.features and self._settings.use_graph:
                nodes = np.array(robot.memory.features)
                robot.scores = list(self._scores(nodes, np.full(len(nodes), number)))
                robot.go_to(self._recalled(number))

    def act(self, observations: Observation, running: NDArray[np.bool_]) -> NDArray:
        """Actions (N,) of all robots, waypoints (N, 2) of cars; those not `running` (N,) stop."""
        sensed = self.search.sense(observations, running)
        for number, odometry in zip(sensed.robots, sensed.odometry, strict=True):
            self.robots[number].memory.move(odometry)
        if self._settings.use_graph:
            self._remember(sensed)
            self._explore(sensed.robots)
        else:
            self._react(sensed)
        actions = self.search.drive(sensed, self._targets)
        self._watch(sensed)
        return actions

    def _remember(self, sensed: Sensed) -> None:
        """Update the graphs of the robots that look."""
        looking = sensed.robots[sensed.looking]
        if not len(looking):
            return
        robots, ranges = [self.robots[number] for number in looking], sensed.ranges[sensed.looking]
        made = self._update.update([r.memory for r in robots], sensed.features, ranges)
        there = [m for m in np.flatnonzero(~made) if robots[m].reached and self._resolve(robots[m])]
        self._update.add_nodes(
            [robots[m].memory for m in there], sensed.features[there], ranges[there]
        )
        made[there] = True
        new = np.flatnonzero(made)
        scores = self._scores(sensed.features[new], looking[new])
        for m, row in zip(new, scores, strict=True):
            robots[m].scores.append(row)
            if robots[m].destination is None or robots[m].destination.ghost is not None:
                robots[m].go_to(None)

    def _resolve(self, robot: ExploringRobot) -> bool:
        """A destination was reached; whether its place becomes a node."""
        memory, ghost = robot.memory, robot.destination.ghost if robot.destination else None
        robot.go_to(None)
        if ghost is None:
            return False
        memory.graph.remove(ghost)
        if not self._settings.localisation.nodes_at_ghosts:
            return False
        return bool(np.linalg.norm(memory.offset[:2]) >= _APART)

    def _explore(self, robots: NDArray[np.intp]) -> None:
        """Choose where to go for the robots that have to, and the next point on the path."""
        for number in robots:
            robot = self.robots[number]
            memory = robot.memory
            if not robot.is_valid():
                robot.go_to(self._choose(robot))
            node, place = robot.destination.node, robot.destination.place
            self._targets[number], self._last[number] = subgoal(memory, node, place)

    def _choose(self, robot: ExploringRobot) -> Destination:
        """The best ghost; where none is left, a node, from which the goal may be seen."""
        memory = robot.memory
        ghost = choose_ghost(memory, self._worth(robot), robot.rng)
        if ghost is None:
            return Destination(int(robot.rng.integers(len(memory.graph))), np.zeros(2))
        return Destination(ghost.node, memory.graph.place_of(ghost), ghost)

    def _worth(self, robot: ExploringRobot) -> Array:
        """What ghosts (V, K) are worth by which the best is chosen: their scores."""
        scores = np.array(robot.scores)
        if not self._settings.use_score:  # drawn anew, or all but the newest had lost before
            scores = robot.rng.random(scores.shape)
        return scores

    def _react(self, sensed: Sensed) -> None:
        """Without a graph: drive in the best direction of the present panorama."""
        looking = sensed.looking
        numbers = sensed.robots[looking]
        reached = np.array([self.robots[number].reached for number in numbers], dtype=bool)
        due = np.flatnonzero(~self._reacting[numbers] | reached)
        if not len(due):
            return
        numbers, ranges = numbers[due], sensed.ranges[looking[due]]
        explorable = self._model.explorable(sensed.features[due]) >= self._settings.explorable
        radius, directions = self._settings.radius, self._settings.directions
        if explorable.shape[1] != directions:
            words = f"the model has {explorable.shape[1]}, the settings {directions}"
            raise InputError(f"directions: {words}; give NTSSettings as many")
        free = free_metres(ranges, directions, radius)
        scores = self._scores(sensed.features[due], numbers) + explorable * 2.0 + (free > _APART)
        best = scores.argmax(axis=1)
        bearing = bearing_of(best, directions)
        ahead = radius * np.stack([np.cos(bearing), np.sin(bearing)], axis=1)
        self._targets[numbers] = to_world(sensed.odometry[looking[due]], ahead)
        self._last[numbers] = True
        self._reacting[numbers] = True
        for number in numbers:
            self.robots[number].go_to(None)

    def _watch(self, sensed: Sensed) -> None:
        """Look again where a destination is reached."""
        for number, odometry in zip(sensed.robots, sensed.odometry, strict=True):
            robot = self.robots[number]
            if self.search.found[number]:
                robot.interrupt()
                continue
            left, last = float(self.search.left[number]), bool(self._last[number])
            robot.watch(self._targets[number], odometry[:2], left, last)
            if robot.reached:
                self.search.look_again(np.array([number]))

    def _scores(self, features: NDArray[np.float32], robots: NDArray[np.intp]) -> Array:
        """F_S (M, K) towards the goals of these robots, or random scores."""
        if not self._settings.use_score:
            count = self._settings.directions
            drawn = [self.robots[number].rng.random(count) for number in robots]
            return np.array(drawn).reshape(len(robots), count)
        return self._model.scores(features, self.search.goals[robots])

    def _recalled(self, number: int) -> Destination | None:
        """Where a robot goes first for its new goal: to its place, if a node sees it."""
        nodes = np.array(self.robots[number].memory.features)
        goals = np.repeat(self.search.goals[number][None], len(nodes), axis=0)
        likely = self._model.same_node(nodes, goals)
        best = int(likely.argmax())
        if likely[best] < self._settings.search.visible:
            return None
        bearing, metres = self._model.relative(nodes[[best]], goals[[best]])[0]
        return Destination(best, metres * np.array([np.cos(bearing), np.sin(bearing)]))
