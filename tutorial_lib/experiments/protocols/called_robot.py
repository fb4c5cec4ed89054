"""One robot of the exploration task that is driven by calls, for loops that people write."""

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.exploration.bearings import RADIUS, bearing_of
from tutorial_lib.exploration.ghost_graph import BESIDE
from tutorial_lib.exploration.goal_search import GoalSearch, SearchSettings, Sensed
from tutorial_lib.exploration.task import STEPS, ExplorationTask
from tutorial_lib.interfaces import ExplorationModel
from tutorial_lib.se2 import Array, relative, to_world
from tutorial_lib.world.noise import STOP

_SAME = 0.5  # probability of F_L
_EXPLORABLE = 0.5  # probability of F_G
_ARRIVED = 0.4  # metres from where a drive goes, or from the end of the path to it
_AWAY = 1.0  # metres from a node at which a ghost of it counts as reached
_PATIENCE, _NEARER = 50, 0.1  # steps in which a robot must come that many metres nearer
_ALONE = np.zeros(1, np.intp)


class CalledRobot:
    """The robot of `explore` in notebook 09, in the real task; it knows what its sensors show.

    Attributes:
        task: of one episode.
        nodes: (3,) pose of each node by odometry, in the frame of the start.
    """

    def __init__(self, task: ExplorationTask, model: ExplorationModel) -> None:
        """Stand at the start.

        Raises:
            InputError: when the task has several episodes.
        """
        if len(task) != 1:
            raise InputError(f"robot: a task of {len(task)} episodes; give it one")
        self.task, self._model = task, model
        self._search = GoalSearch(model, task.goals(), SearchSettings())
        self.nodes: dict[int, Array] = {}
        self._features: dict[int, NDArray[np.float32]] = {}
        self._last = self._from = self._new = -1  # its node; that of the last drive; a new one
        self._embedded: NDArray[np.float32] | None = None
        self._look()

    @property
    def steps(self) -> int:
        """Actions left; 0 once it has stopped."""
        return 0 if self.task.done[0] else STEPS - int(self.task.steps[0])

    def sees_goal(self) -> bool:
        """F_L: whether the goal was seen, on the way or from here."""
        return bool(self._search.found[0])

    def node(self) -> int | None:
        """F_L: the node in which the robot is, its own one first; None if it is in none."""
        near = self._near()
        likely = self._likely(near)
        if self._last in near and likely[near.index(self._last)] >= _SAME:
            return self._last
        best = int(likely.argmax()) if near else -1
        return near[best] if near and likely[best] >= _SAME else None

    def beside(self) -> dict[int, Array]:
        """Poses, in the robot's frame, of the last node and of those from which it is visible."""
        near = [node for node in self._near() if node not in (self._from, self._new)]
        likely = self._likely(near)
        chosen = [node for node, p in zip(near, likely, strict=True) if p >= _SAME]
        chosen += [self._from] if self._from >= 0 else []  # however far: the graph stays connected
        return {node: relative(self._here, self.nodes[node]) for node in sorted(chosen)}

    def explorable(self) -> NDArray[np.bool_]:
        """F_G: (12,) whether each direction leads to explorable area."""
        return self._model.explorable(self._seen)[0] >= _EXPLORABLE

    def scores(self) -> Array:
        """F_S: (12,) the higher the nearer a direction leads to the goal."""
        return self._model.scores(self._seen, self._search.goals)[0]

    def remember(self, node: int) -> None:
        """Keep what is seen here as a node."""
        self.nodes[node], self._features[node] = self._here.copy(), self._seen[0]
        self._last = self._new = node

    def to_node(self, node: int) -> None:
        """Drive to a node; a drive also ends where the goal is seen, or no steps are left."""
        self._drive(self.nodes[node][:2])
        self._last = self._from = node

    def to_ghost(self, ghost: tuple[int, int]) -> bool:
        """Drive to a ghost; whether it was reached, as far as walls permit."""
        node, direction = ghost
        bearing = float(bearing_of(direction))
        ahead = RADIUS * np.array([np.cos(bearing), np.sin(bearing)])
        self._drive(to_world(self.nodes[node], ahead))
        return bool(np.linalg.norm(self._here[:2] - self.nodes[node][:2]) >= _AWAY)

    def to_goal(self) -> bool:
        """Drive to the goal, by F_R, and stop; False where there is none after all."""
        stopped = False
        while self._search.found[0] and self.steps and not stopped:
            stopped = self._act(np.zeros(2)) == STOP
        return stopped

    def _drive(self, place: Array) -> None:
        """Drive to a place (2,) in the frame of the start, while it comes nearer."""
        self._from, self._new = self._last, -1
        nearest, waited = np.inf, 0
        while self.steps and not self._search.found[0]:
            self._act(place)
            gap = float(np.linalg.norm(place - self._here[:2]))
            if min(gap, float(self._search.left[0])) < _ARRIVED:
                break
            nearest, waited = (gap, 0) if gap < nearest - _NEARER else (nearest, waited + 1)
            if waited > _PATIENCE:
                break
        self._search.look_again(_ALONE)
        self._look()

    def _act(self, place: Array) -> int:
        """One action towards a place, or towards the goal where that was seen."""
        action = int(self._search.drive(self._sensed, place[None])[0])
        self.task.step(np.array([action]))
        if self.steps:
            self._look()
        return action

    def _look(self) -> None:
        """Sense: maps, odometry, and whether the goal is visible."""
        seen = self.task.observe()
        self._here = seen.odometry[0]
        if self.steps:
            self._sensed: Sensed = self._search.sense(seen, ~self.task.done)
        self._picture, self._embedded = seen, None

    @property
    def _seen(self) -> NDArray[np.float32]:
        """(1, D) features of what is seen here; a robot asks several times where it stands."""
        if self._embedded is None:
            self._embedded = self._model.embed(self._picture)
        return self._embedded

    def _near(self) -> list[int]:
        """The nodes near the robot, by odometry."""
        gaps = {n: np.linalg.norm(p[:2] - self._here[:2]) for n, p in self.nodes.items()}
        return [node for node, gap in gaps.items() if gap < BESIDE]

    def _likely(self, nodes: list[int]) -> Array:
        """(V,) probabilities of F_L that the robot is in these nodes."""
        if not nodes:
            return np.zeros(0)
        sources = np.array([self._features[node] for node in nodes])
        return self._model.same_node(sources, np.repeat(self._seen, len(nodes), axis=0))
