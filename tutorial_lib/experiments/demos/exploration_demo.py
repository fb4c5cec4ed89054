"""The demo of exploration: image-goal navigation in a place never seen, on film."""

import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tutorial_lib.agents.lifelong import LifelongAgent
from tutorial_lib.agents.nts import NTSAgent
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.explorers import check_shipped, shipped
from tutorial_lib.experiments.demos.ends import End
from tutorial_lib.experiments.demos.exploration_film import (
    SHARP,
    ExplorationFilm,
    ExplorationMoment,
)
from tutorial_lib.experiments.demos.outcome import FILM, STRIP, check_folder, rounded
from tutorial_lib.experiments.demos.recorder import FILM_RATE, demo_files
from tutorial_lib.experiments.demos.task import Say, silent
from tutorial_lib.experiments.protocols.ghost_moments import ghost_moment
from tutorial_lib.exploration.episodes import DIFFICULTIES, SUCCESS, Episodes, draw_episodes
from tutorial_lib.exploration.local_map import LocalMaps
from tutorial_lib.exploration.task import STEPS, ExplorationTask
from tutorial_lib.exploration.true_geometry import TrueGeometry
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import ExplorationModel
from tutorial_lib.observation import Observation
from tutorial_lib.se2 import wrap
from tutorial_lib.viz.figures.panels import evenly
from tutorial_lib.world.bodies import DifferentialDrive
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.scene import Scene

EVERY = 2
"""Actions for each frame of the film."""
_SIDE = 60.0  # metres of the map of all that was seen
_QUIET = 3.0  # seconds after which a word is said


@dataclass(frozen=True)
class Explored:
    """What `demo.json` holds of an exploration; lengths in metres.

    Attributes:
        reached: stopped within 1 m of the goal.
        ending: what happened, in words.
        start: x, y and heading.
        goal: x, y and heading at which its picture was taken.
        steps: actions, of 500 at most.
        travelled: by the robot.
        geodesic: of the shortest path.
        spl: success weighted by path length.
        collisions: actions that ended at a wall.
        nodes: of the graph.
        ghosts: that are left.
    """

    reached: bool
    ending: str
    name: str
    plan: str
    seed: int
    start: tuple[float, float, float]
    goal: tuple[float, float, float]
    difficulty: str
    steps: int
    travelled: float
    geodesic: float
    spl: float
    collisions: int
    nodes: int
    ghosts: int
    film: str = FILM
    strip: str = STRIP


class ExplorationRecorder:
    """Keeps a moment of every `EVERY`-th step of one robot.

    Attributes:
        moments: for the film.
    """

    def __init__(self, task: ExplorationTask, agent: NTSAgent, model: ExplorationModel) -> None:
        """Look at the only robot of `task`, which `agent` drives and `model` serves."""
        self.moments: list[ExplorationMoment] = []
        self._task, self._agent, self._model = task, agent, model
        self._seen = LocalMaps(1, _SIDE)

    def look(self, observation: Observation, *, last: bool = False, quiet: bool = False) -> None:
        """Note what is seen, and keep the moment if it is due and not `quiet`, or the last one."""
        robots, task = np.zeros(1, np.intp), self._task
        believed = self._believed(observation)
        self._seen.observe(robots, believed[None], self._model.ranges(observation))
        if quiet or (int(task.steps[0]) % EVERY and not last):
            return
        here = self._model.embed(observation)
        search = self._agent.search
        self.moments.append(
            ExplorationMoment(
                pose=task.poses[0],
                odometry=believed,
                image=SHARP.look(next(iter(task.scenes.values())), task.poses)[0][0],
                scores=self._model.scores(here, search.goals)[0],
                explorable=self._model.explorable(here)[0] >= 0.5,
                graph=ghost_moment(self._agent.robots[0], believed),
                grid=self._seen.grids[0].copy(),
                corner=self._seen.corners[0].copy(),
                track=np.array(task.path)[:, 0, :2],
                goal_seen=search.places[0].copy() if search.found[0] else None,
                lines=self._lines(last),
            )
        )

    def _believed(self, observation: Observation) -> Array:
        """(3,) where the robot takes itself to be since its start."""
        agent = self._agent
        if isinstance(agent, LifelongAgent):
            return agent.tracks[0].pose
        return observation.odometry[0]

    def _lines(self, last: bool) -> tuple[tuple[str, str], ...]:
        """What the robot does, in words."""
        robot, search = self._agent.robots[0], self._agent.search
        graph, going = robot.memory.graph, robot.destination
        if last:
            doing = exploration_ending(self._task)
        elif search.found[0]:
            doing = "sees the goal, and goes there"
        elif going is None or going.ghost is None:
            doing = "looks around at a node"
        else:
            score = robot.scores[going.node][going.ghost.direction]
            doing = f"goes to a ghost, score {score:.2f}"
        lines = (
            ("action", f"{int(self._task.steps[0])} of {STEPS}"),
            ("the robot", doing),
            ("graph", f"nodes {len(graph)}, ghosts {len(graph.ghosts)}"),
        )
        if not isinstance(self._agent, LifelongAgent):
            return lines
        drift, off = headings_off(self._task, self._agent)
        return (*lines, ("heading", f"odometry is off by {drift:.0f} degrees, it by {off:.0f}"))


def exploration_ending(task: ExplorationTask) -> str:
    """How the only episode of an exploration ended."""
    gap = float(np.linalg.norm(task.poses[0, :2] - task.goal_poses[0, :2]))
    if task.success[0]:
        return f"reached the goal, {gap:.2f} m from it"
    ended = "stopped" if task.steps[0] < STEPS else "no steps left,"
    return f"{ended} {gap:.1f} m from the goal"


def headings_off(task: ExplorationTask, agent: LifelongAgent) -> tuple[float, float]:
    """Degrees by which odometry is off, and the agent, whose odometry walls correct."""
    turned = task.poses[0, 2] - task.path[0][0, 2]
    headings = np.array([task.odometry[0, 2], agent.tracks[0].pose[2]])
    drift, off = np.rad2deg(np.abs(wrap(headings - turned))).round(1).tolist()
    return drift, off


def run_exploration_demo(
    plan: FloorPlan,
    seed: int,
    folder: Path,
    *,
    name: str = "",
    start: End | None = None,
    goal: End | None = None,
    geometry: bool = False,
    say: Say = silent,
) -> Explored:
    """Explore until a goal's picture is found; leave demo.webm, demo.png and demo.json.

    Args:
        plan: of the world.
        seed: of everything else that is random.
        folder: for the files.
        name: of the world; the plan's family and seed unless given.
        start: that was asked for.
        goal: that was asked for.
        geometry: the true geometry stands in for the network.
        say: is called with what is being done.

    Raises:
        InputError: when the network's weights are not there, the plan is too small, or a start or
            goal cannot be had.
    """
    check_folder(folder)
    if not geometry:
        check_shipped(("nts",), "rgbd")
    say("drawing an episode")
    scene, name = Scene(plan), name or f"{plan.family} {plan.seed}"
    if start is None and goal is None:
        episode = draw_episode(name, scene, seed)
    else:
        episode = episode_between(name, scene, start, goal, seed)
    task = ExplorationTask({name: scene}, episode, np.random.default_rng([seed, 1]))
    say("loading the network")
    model: ExplorationModel = TrueGeometry(task) if geometry else shipped("nts", "rgbd")
    agent = NTSAgent(model, np.random.default_rng([seed, 2]))
    recorder = ExplorationRecorder(task, agent, model)
    say("exploring")
    agent.start(task.goals())
    explore_recorded(task, agent, recorder, say)
    title = f"{name}, never seen before: find where this picture was taken"
    shown = ExplorationFilm(scene, recorder.moments, episode.starts[0], episode.goals[0], title)
    outcome = _outcome(name, seed, task, agent)
    say("writing the film")
    with demo_files(folder) as (write, finish):
        for picture in shown:
            write(picture)
        finish([shown[i] for i in evenly(len(shown), 3)], outcome)
    return outcome


def explore_recorded(
    task: ExplorationTask,
    agent: NTSAgent,
    recorder: ExplorationRecorder,
    say: Say = silent,
    *,
    quiet: bool = False,
) -> None:
    """Let an agent that was started act until the only episode is over, and record it.

    If `quiet`, only its last moment is kept for the film.
    """
    said = time.monotonic()
    while not task.done.all():
        observation = task.observe()
        actions = agent.act(observation, ~task.done)
        recorder.look(observation, quiet=quiet)
        task.step(actions)
        if not quiet and time.monotonic() - said > _QUIET:
            said = time.monotonic()
            say("exploring: " + ", ".join(" ".join(line) for line in recorder.moments[-1].lines))
    recorder.look(task.observe(), last=True)
    recorder.moments += recorder.moments[-1:] * round(FILM_RATE)  # stays on screen for a second


def _outcome(name: str, seed: int, task: ExplorationTask, agent: NTSAgent) -> Explored:
    graph = agent.robots[0].memory.graph
    return Explored(
        reached=bool(task.success[0]),
        ending=exploration_ending(task),
        name="demo --explore",
        plan=name,
        seed=seed,
        start=rounded(task.episodes.starts[0]),
        goal=rounded(task.goal_poses[0]),
        difficulty=task.episodes.difficulty[0],
        steps=int(task.steps[0]),
        travelled=_rounded(task.travelled),
        geodesic=_rounded(task.episodes.shortest),
        spl=_rounded(task.spl),
        collisions=int(task.collisions[0]),
        nodes=len(graph),
        ghosts=len(graph.ghosts),
    )


def _rounded(values: Array) -> float:
    return round(float(values[0]), 2)


def draw_episode(name: str, scene: Scene, seed: int) -> Episodes:
    """One episode, as difficult as the world allows.

    Raises:
        InputError: when not even an easy one fits.
    """
    words = ""
    for difficulty, (least, _) in reversed(DIFFICULTIES.items()):
        try:
            return draw_episodes(name, scene, {difficulty: 1}, np.random.default_rng(seed))
        except InputError as error:
            words = f"{name} has no two places {least:g} m apart ({error}); give a larger map"
    raise InputError(f"demo: {words}")


def episode_between(
    name: str, scene: Scene, start: End | None, goal: End | None, seed: int
) -> Episodes:
    """The episode from a start to a goal that were asked for; the other is drawn where one was.

    Raises:
        InputError: when one of them cannot be had, or they are too near each other.
    """
    rng, paths = np.random.default_rng(seed), GridPaths(scene.clearance)
    begin, end = (
        None if one is None else one.find(scene, paths, DifferentialDrive())
        for one in (start, goal)
    )
    if begin is None or end is None:
        given = end if begin is None else begin
        if given is None:
            raise InputError("demo: give a start or a goal")
        metres = paths.fields(given[None, :2], shortest=True).distance(paths.points)
        low, high = DIFFICULTIES["hard"]
        apart = np.linalg.norm(paths.points - given[:2], axis=1) >= SUCCESS
        reachable = np.where(apart & (metres < high), metres, -1.0)
        if reachable.max() < 0:
            words = f"no place {SUCCESS:.0f} to {high:.0f} m away can be reached"
            raise InputError(f"demo: {words}; choose another start or goal")
        far = np.flatnonzero(reachable >= min(low, reachable.max()))
        drawn = np.append(paths.points[rng.choice(far)], np.nan)
        begin, end = (drawn, end) if begin is None else (begin, drawn)
    starts, goals = (np.array([one]) for one in (begin, end))
    for poses in (starts, goals):
        poses[np.isnan(poses)] = rng.uniform(-np.pi, np.pi)
    shortest = paths.between(starts[:, :2], goals[:, :2])
    if np.linalg.norm(starts[0, :2] - goals[0, :2]) < SUCCESS:
        raise InputError(
            f"--goal: {shortest[0]:.1f} m from the start; choose places {SUCCESS:.0f} m apart"
        )
    fits = [word for word, (low, high) in DIFFICULTIES.items() if low <= shortest[0] < high]
    return Episodes((name,), starts, goals, shortest, (fits[0] if fits else "",))
