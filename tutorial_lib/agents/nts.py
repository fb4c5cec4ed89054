"""Neural Topological SLAM (Chaplot et al. 2020): explores by a graph with ghost nodes."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.exploration.bearings import DIRECTIONS, RADIUS, bearing_of
from tutorial_lib.exploration.ghost_graph import Ghost
from tutorial_lib.exploration.global_policy import GhostChoice, choose_ghost, subgoal
from tutorial_lib.exploration.goal_search import GoalSearch, SearchSettings, Sensed
from tutorial_lib.exploration.graph_update import GraphUpdate, Memory, free_metres
from tutorial_lib.geometry import Array, to_world
from tutorial_lib.interfaces import ExplorationModel
from tutorial_lib.observation import Observation

_ARRIVED = 0.4  # metres from where a robot is going, or from the end of the path to it
_PATIENCE = 50  # steps in which a robot must come nearer to where it is going
_NEARER = 0.1  # metres that count as nearer
_APART = 1.0  # metres between a node and a ghost that is explored by a node of its own


@dataclass(frozen=True)
class NTSSettings:
    """The paper's agent, and what is changed in it.

    Attributes:
        use_graph: without it, the best direction of the present panorama is taken, and nothing is
            remembered (the paper's ablation, section 6.1).
        use_score: without it, scores are random: a ghost is drawn (the other ablation).
        explored_by_sight: ghosts that another node sees well go to the reserve; in the paper they
            stay. It helps where scores are poor, and costs where they are good.
        same_node: probability of F_L from which a robot is in a node.
        explorable: probability of F_G from which a direction gets a ghost.
        choice: how ghosts are compared.
        search: how the goal is noticed.
    """

    use_graph: bool = True
    use_score: bool = True
    explored_by_sight: bool = False
    same_node: float = 0.5
    explorable: float = 0.5
    choice: GhostChoice = field(default_factory=GhostChoice)
    search: SearchSettings = field(default_factory=SearchSettings)


@dataclass(frozen=True, eq=False)
class Destination:
    """Where a robot is going over its graph.

    Attributes:
        node: of the graph.
        place: (2,) in that node's frame.
        ghost: that is there, if any.
    """

    node: int
    place: Array
    ghost: Ghost | None = None


@dataclass(eq=False)
class ExploringRobot:
    """One robot: what it remembers, and where it is going.

    Attributes:
        memory: its graph.
        scores: (K,) of each node's directions.
        destination: None where it has to choose.
        reached: whether it is there, or does not come nearer.
    """

    memory: Memory = field(default_factory=Memory)
    scores: list[Array] = field(default_factory=list)
    destination: Destination | None = None
    reached: bool = False
    _target: Array = field(default_factory=lambda: np.full(2, np.inf))
    _nearest: float = np.inf
    _waited: int = 0

    def go_to(self, destination: Destination | None) -> None:
        """Go there from now on."""
        self.destination, self.reached = destination, False
        self._nearest, self._waited = np.inf, 0

    def is_valid(self) -> bool:
        """Whether it is going anywhere, and the ghost there was not explored meanwhile."""
        if self.destination is None:
            return False
        ghost = self.destination.ghost
        return ghost is None or (ghost.node, ghost.direction) in self.memory.graph.ghosts

    def watch(self, target: Array, here: Array, left: float, last: bool) -> None:
        """Notice that the destination is reached, or that it cannot be.

        Args:
            target: (2,) the point that it drives to.
            here: (2,) where it is.
            left: metres to the end of the path.
            last: whether the target is the destination.
        """
        gap = float(np.linalg.norm(target - here))
        if np.linalg.norm(target - self._target) > 2 * _ARRIVED:
            self._nearest, self._waited, self._target = np.inf, 0, target
        if gap < self._nearest - _NEARER:
            self._nearest, self._waited = gap, 0
        self._waited += 1
        self.reached = self._waited > _PATIENCE or (last and min(gap, left) < _ARRIVED)


class NTSAgent:
    """The `ExplorerAgent` of the paper, over any `ExplorationModel`.

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
        """Explore with `model`; `rng` draws among equals."""
        self._model, self._rng = model, rng
        self._settings = NTSSettings() if settings is None else settings
        chosen = self._settings
        self._update = GraphUpdate(
            model, chosen.same_node, chosen.explorable, by_sight=chosen.explored_by_sight
        )

    def start(self, goals: Observation) -> None:
        """Begin episodes towards `goals` (N,); forget all before."""
        self.robots = [ExploringRobot() for _ in range(len(goals))]
        self.search = GoalSearch(self._model, goals, self._settings.search)
        self._targets, self._last = np.zeros((len(goals), 2)), np.zeros(len(goals), bool)

    def look_for(self, goals: Observation) -> None:
        """Go on to other goals (N,), and keep graphs and maps (section 6.1)."""
        self.search.look_for(goals)
        for number, robot in enumerate(self.robots):
            robot.go_to(None)
            if robot.memory.features and self._settings.use_graph:
                nodes = np.array(robot.memory.features)
                robot.scores = list(self._scores(nodes, np.full(len(nodes), number)))
                robot.go_to(self._remembered(nodes, self.search.goals[number]))

    def act(self, observations: Observation, running: NDArray[np.bool_]) -> NDArray[np.intp]:
        """Actions (N,) of all robots; those not `running` (N,) stop."""
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
        memory, choice = robot.memory, self._settings.choice
        ghost = choose_ghost(memory, np.array(robot.scores), choice, self._rng)
        if ghost is None:
            return Destination(int(self._rng.integers(len(memory.graph))), np.zeros(2))
        return Destination(ghost.node, memory.graph.place_of(ghost), ghost)

    def _react(self, sensed: Sensed) -> None:
        """Without a graph: drive in the best direction of the present panorama."""
        looking = sensed.looking
        due = [m for m, n in enumerate(sensed.robots[looking]) if not self._is_driving(n)]
        if not due:
            return
        numbers, ranges = sensed.robots[looking[due]], sensed.ranges[looking[due]]
        explorable = self._model.explorable(sensed.features[due]) >= self._settings.explorable
        free = free_metres(ranges, explorable.shape[1])
        scores = self._scores(sensed.features[due], numbers) + explorable * 2.0 + (free > _APART)
        best = scores.argmax(axis=1)
        bearing = bearing_of(best, explorable.shape[1])
        ahead = RADIUS * np.stack([np.cos(bearing), np.sin(bearing)], axis=1)
        self._targets[numbers] = to_world(sensed.odometry[looking[due]], ahead)
        self._last[numbers] = True
        for number in numbers:
            self.robots[number].go_to(Destination(0, np.zeros(2)))

    def _is_driving(self, number: int) -> bool:
        robot = self.robots[number]
        return robot.destination is not None and not robot.reached

    def _watch(self, sensed: Sensed) -> None:
        """Look again where a destination is reached."""
        for number, odometry in zip(sensed.robots, sensed.odometry, strict=True):
            robot = self.robots[number]
            if not self.search.found[number]:
                left, last = float(self.search.left[number]), bool(self._last[number])
                robot.watch(self._targets[number], odometry[:2], left, last)
                if robot.reached:
                    self.search.look_again(np.array([number]))

    def _scores(self, features: NDArray[np.float32], robots: NDArray[np.intp]) -> Array:
        """F_S (M, K) towards the goals of these robots, or random scores."""
        if not self._settings.use_score:
            return self._rng.random((len(features), DIRECTIONS))
        return self._model.scores(features, self.search.goals[robots])

    def _remembered(
        self, nodes: NDArray[np.float32], goal: NDArray[np.float32]
    ) -> Destination | None:
        """The place of a goal that is visible from a node of the graph; None if from no node."""
        goals = np.repeat(goal[None], len(nodes), axis=0)
        likely = self._model.same_node(nodes, goals)
        best = int(likely.argmax())
        if likely[best] < self._settings.search.visible:
            return None
        bearing, metres = self._model.relative(nodes[[best]], goals[[best]])[0]
        return Destination(best, metres * np.array([np.cos(bearing), np.sin(bearing)]))
