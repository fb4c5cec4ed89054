"""A first visit, on which a robot explores a building, and trials of a second one."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from tutorial_lib.agents.ltvn import LTVNAgent
from tutorial_lib.agents.ltvn_state import TravelSettings
from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.agents.returning import DISCRETE, visit
from tutorial_lib.agents.sptm import SPTMAgent
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.protocols.drives import TOUR
from tutorial_lib.experiments.protocols.thresholds import CHOSEN
from tutorial_lib.exploration.episodes import Episodes, draw_episodes, draw_sequence
from tutorial_lib.exploration.task import ExplorationTask, explore_on
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import SequentialExplorer
from tutorial_lib.learning.estimators import (
    ReachabilityNetwork,
    RelativeNetwork,
    WaypointNetwork,
)
from tutorial_lib.observation import Observation
from tutorial_lib.topology.mapping.sampling_map import SamplingRules
from tutorial_lib.world.scene import Scene

GOALS = ("passed", "elsewhere")
"""Where the goals of the second visit are: the first one passed there, or nowhere near."""
PASSED, MISSED = 0.5, 2.0
"""Metres from a run up to which a place was passed, and from which on it was not."""
CONTEXT = "k0"
"""Of the networks: nobody drove past a goal, so that its picture has no context."""
FAR = 3.0
"""Metres from a start to its goal, at least."""
_AROUND = 1.5  # times as long may the path to a place be that was passed: no wall is between
_DRAWN = 2_000  # places among which starts and goals are
_GOALS = 200  # of a guide: more than it comes to
_EVERY = 5  # frames, of an action each, between two images of SPTM


class Recorder:
    """An explorer that keeps what it observes.

    Attributes:
        run: what N robots observed before each action, since `start`.
    """

    def __init__(self, explorer: SequentialExplorer) -> None:
        """Record what `explorer` sees."""
        self._explorer = explorer
        self.run: list[Observation] = []

    def start(self, goals: Observation) -> None:
        """Begin a new run; see `ExplorerAgent`."""
        self.run = []
        self._explorer.start(goals)

    def look_for(self, goals: Observation) -> None:
        """Go on to other goals; see `SequentialExplorer`."""
        self._explorer.look_for(goals)

    def act(self, observations: Observation, running: NDArray[np.bool_]) -> NDArray[np.intp]:
        """Actions (N,)."""
        self.run.append(observations)
        return self._explorer.act(observations, running)


def shown(
    name: str,
    scene: Scene,
    guide: Callable[[ExplorationTask], SequentialExplorer],
    actions: int,
    rng: np.random.Generator,
) -> list[Observation]:
    """What a robot (1,) observes while a guide looks for one goal after another.

    Args:
        name: of the world.
        scene: the world.
        guide: makes what drives the robot.
        actions: that the run has, at most; fewer only where the guide stops at once.
        rng: draws the goals and the noise of motion.
    """
    first = draw_episodes(name, scene, {"medium": 1}, rng)
    goals = draw_sequence(scene, first.goals, _GOALS, rng)
    task = ExplorationTask({name: scene}, first, rng)
    recorder = Recorder(guide(task))
    for _ in explore_on(task, recorder, goals):
        if len(recorder.run) >= actions:
            break
    return recorder.run[:actions]


def remembering() -> MengAgent:
    """The agent of Meng 2020 in the robot that explores, of which it only plans and recalls."""
    return MengAgent(**_parts())


def remembering_sptm() -> SPTMAgent:
    """The same of SPTM; its images are as far apart as in the car, about 1.2 m."""
    return agents.sptm(every=_EVERY, s_shortcut=CHOSEN[TOUR].s_shortcut, **_parts())


def remembering_ltvn() -> LTVNAgent:
    """The same of LTVN: targets are single images, as goals are to it, and nothing is reversed."""
    model = RelativeNetwork("relative_5")
    model.k = 0
    parts = {"controller": StandStill(), "backing": StandStill()}
    rules, travel = SamplingRules(reverse=None), TravelSettings(slow=5.0, spare=6.0)
    return LTVNAgent(model=model, rules=rules, travel=travel, **parts)


def _parts() -> dict[str, Any]:
    return {
        "predictor": WaypointNetwork(f"waypoint_{CONTEXT}"),
        "controller": StandStill(),
        "reachability": ReachabilityNetwork(f"reach_{CONTEXT}"),
        "follower": DISCRETE,
    }


def learned_from(run: list[Observation]) -> MengAgent:
    """The agent of Meng 2020 with a map of what a robot (1,) saw on its run."""
    memory = remembering()
    memory.learn(visit(run, 0))
    return memory


def draw_return(
    name: str, scene: Scene, path: Array, counts: dict[str, int], rng: np.random.Generator
) -> tuple[Episodes, NDArray[np.str_]]:
    """Episodes of a second visit: all start at places that the first one passed.

    Args:
        name: of the world.
        scene: the world.
        path: (T, 3) true poses of the first visit.
        counts: how many of each of `GOALS`; fewer where the first visit went nearly everywhere.
        rng: draws them.

    Returns:
        The episodes, and (N,) which of `GOALS` each has.

    Raises:
        InputError: where the first visit passed too little.
    """
    paths, seen = GridPaths(scene.clearance), KDTree(path[:, :2])
    free = paths.points[paths.largest]
    points = free[rng.permutation(len(free))[:_DRAWN]]
    gaps, nearest = seen.query(points)
    near = np.flatnonzero(gaps <= PASSED)
    there = paths.between(points[near], path[nearest[near], :2]) <= _AROUND * PASSED
    known = {"passed": near[there], "elsewhere": np.flatnonzero(gaps >= MISSED)}
    kinds = [kind for kind in GOALS for _ in range(counts[kind]) if len(known[kind])]
    rows = []
    for kind in kinds:
        goal = points[rng.choice(known[kind])]
        metres = paths.fields(goal[None], shortest=True).distance(points[known["passed"]])
        starts = np.flatnonzero(np.isfinite(metres) & (metres >= FAR))
        if not len(starts):
            raise InputError(f"{name}: the first visit passed no place {FAR} m from a goal")
        start = rng.choice(starts)
        rows.append((points[known["passed"][start]], goal, float(metres[start])))
    if not rows:
        raise InputError(f"{name}: the first visit passed none of the goals asked for")
    starts, goals, shortest = (np.array(column) for column in zip(*rows, strict=True))
    headings = rng.uniform(-np.pi, np.pi, (2, len(rows), 1))
    starts = np.concatenate([starts, headings[0]], axis=1)
    goals = np.concatenate([goals, headings[1]], axis=1)
    blank = ("",) * len(rows)
    return Episodes((name,) * len(rows), starts, goals, shortest, blank), np.array(kinds)


class StandStill:
    """A `Controller` that leaves the driving to the local policy."""

    def act(self, observations: Observation, waypoints: Array) -> Array:
        """Actions (N, 2): none."""
        del observations
        return np.zeros_like(waypoints)
