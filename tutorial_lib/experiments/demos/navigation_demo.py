"""The demo: image-goal navigation over a map learned from recorded trajectories, on film."""

import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.agents.oracle import OracleNavigation
from tutorial_lib.driving.rollouts import STUCK
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.own import guarded, load_robot
from tutorial_lib.experiments.demos.ends import End
from tutorial_lib.experiments.demos.forecast import DrivesForecast
from tutorial_lib.experiments.demos.learned_map import keep_learned, load_learned
from tutorial_lib.experiments.demos.moments import ByOracle, BySight
from tutorial_lib.experiments.demos.outcome import Drive, Outcome, check_folder, rounded
from tutorial_lib.experiments.demos.recorder import FilmRecorder, Write, demo_files
from tutorial_lib.experiments.demos.sureness import sureness
from tutorial_lib.experiments.demos.task import Say, Task, choose_task, silent
from tutorial_lib.experiments.protocols.navigation import (
    K,
    experiences,
    goals_of,
    navigate,
    vertex_poses,
)
from tutorial_lib.experiments.protocols.navigation import Outcome as TrialOutcome
from tutorial_lib.experiments.protocols.navigation_tasks import Building
from tutorial_lib.interfaces import Navigation, Plan
from tutorial_lib.learning.views import view_of
from tutorial_lib.topology.mapping.scan_matching import match_scans
from tutorial_lib.validation import floats
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView
from tutorial_lib.viz.canvas.topomaps import hue
from tutorial_lib.viz.figures.dashboard import LEGEND, Moment, RolloutFilm
from tutorial_lib.viz.figures.maps import map_view
from tutorial_lib.viz.figures.panels import evenly, side_by_side
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera
from tutorial_lib.world.simulation import Sensors, Simulation

PLACES = 6
"""Places between which trajectories are recorded."""
_QUIET = 3.0  # seconds of driving after which a word is said
_BESIDE = 570  # pixels of height where agent and oracle are shown beside each other


class Frames(Protocol):
    """Pictures, perhaps each drawn on request."""

    def __len__(self) -> int: ...

    def __getitem__(self, index: int, /) -> Picture: ...


@dataclass(frozen=True)
class Beside:
    """The frames of a film, and beside each the frame of another; the shorter one waits.

    Attributes:
        first: grows while its robot drives.
        second: may be empty; then the first is shown alone.
    """

    first: Frames
    second: Frames

    def __len__(self) -> int:
        return max(len(self.first), len(self.second))

    def __getitem__(self, index: int) -> Picture:
        mine = self.first[min(index, len(self.first) - 1)]
        if not len(self.second):
            return mine
        other = self.second[min(index, len(self.second) - 1)]
        return side_by_side([mine, other], height=_BESIDE, gap=20)


def run_demo(
    plan: FloorPlan,
    seed: int,
    folder: Path,
    *,
    name: str = "",
    start: End | None = None,
    goal: End | None = None,
    oracle: bool = False,
    learn: bool = False,
    own: str = "",
    robot: str = "",
    say: Say = silent,
) -> Outcome:
    """Navigate to an image some rooms away; leave demo.webm, demo.png and demo.json.

    Args:
        plan: of the world.
        seed: of everything that is random.
        folder: for the files.
        name: of the world; the plan's family and seed unless given.
        start: that was asked for.
        goal: that was asked for.
        oracle: drive the same task by an oracle, too, and show both beside each other.
        learn: learn the map even if one was kept, and keep it for later demos.
        own: "FILE.py:CLASS", a component in the place of the agent's; the task is the same.
        robot: "FILE.py:NAME", what makes the body of the robots that record the drives and that
            navigates, or a pair of that and their camera; a `BicycleCar` and the usual camera
            unless given.
        say: is called with what is being done.

    Raises:
        InputError: when the plan is too small for `PLACES` places, or a start or goal cannot be
            had; naming the line, when the component fails; naming the command that trains it, when
            there is no network for the camera.
    """
    check_folder(folder)
    body, camera = load_robot(robot) if robot else (BicycleCar(), Camera())
    usual = agents.meng(camera)
    agent = _with_own(own, camera) if own else usual
    asked = {"name": name, "start": start, "goal": goal, "body": body, "camera": camera}
    try:
        task = choose_task(Scene(plan), seed, PLACES, usual, say, **asked)
    except InputError as error:
        if not robot or start or goal:
            raise
        raise InputError(f"{error}; or a smaller body in --robot {robot}") from error
    call = partial(guarded, own) if own else lambda run, *given: run(*given)
    file = call(partial(learn_map, recorded=task.recorded, again=learn), agent, task.building, say)
    beside = drive_oracle(task, say) if oracle else None
    with demo_files(folder) as (write, finish):
        shown, outcome = call(drive_by_sight, task, agent, seed, say, beside, write, file)
        say("writing the film")
        finish([shown[i] for i in evenly(len(shown), 3)], outcome)
    return outcome


def _with_own(where: str, camera: Camera) -> MengAgent:
    """The usual agent with a component of the user's own."""
    agent = agents.custom(where, camera)
    if not isinstance(agent, MengAgent):
        raise InputError(
            f"--agent {where}: a whole agent, whose plans the film cannot show; give one of its "
            "components, as a planner"
        )
    return agent


def navigate_once(
    scene: Scene, seed: int, places: int = PLACES, goal: ArrayLike | None = None
) -> tuple[Frames, Outcome]:
    """Record trajectories, learn a map, and navigate to an image: the film, and how it went.

    The car gets its camera and laser, what was observed on the trajectories, and the goal image; it
    gets neither the floor plan nor its pose.

    Args:
        scene: the world.
        seed: of everything that is random.
        places: between which trajectories are recorded.
        goal: (3,) pose to arrive in; the goal image is taken where a car arrives. It is chosen
            unless given.

    Raises:
        InputError: when the scene is too small, or the goal cannot be had.
    """
    agent, end = agents.meng(), None
    if goal is not None:
        x, y, heading = floats("goal", goal, (3,)).tolist()
        end = End("goal", pose=(x, y, heading))
    task = choose_task(scene, seed, places, agent, goal=end)
    learn_map(agent, task.building)
    return drive_by_sight(task, agent, seed)


def learn_map(
    agent: MengAgent,
    building: Building,
    say: Say = silent,
    *,
    recorded: int = 0,
    again: bool = False,
) -> Path | None:
    """Give an agent the map of a building: the one that was kept, or learn one; its file.

    Args:
        agent: with an empty map.
        building: with the drives that are learned.
        say: is called with what is being done.
        recorded: how many drives there are besides.
        again: learn the map even if one was kept, and keep it.
    """
    kept = None if again else load_learned(building, agent)
    if kept is not None:
        agent.topomap, file = kept
        say(f"loading the learned map {file.name}: {len(agent.topomap)} images")
        return file
    scans = building.recorded.observe(np.arange(2)).laser.astype(float)
    match_scans(scans, scans, np.zeros((2, 1, 3)))  # compiled before the first drive is timed
    drives = building.recorded.trajectories
    lengths = [one.arc_length[-1] for one in drives]
    begun = time.monotonic()
    forecast = DrivesForecast(lengths, sureness(building, agent), time.monotonic() - begun)
    some = f"{len(drives)} of {recorded}" if recorded > len(drives) else f"{len(drives)}"
    say(f"learning a map from {some} drives, {forecast.words()}")
    begun = time.monotonic()
    for experience in experiences(building):
        agent.learn([experience])
        if forecast.done(time.monotonic() - begun):
            say(f"learning a map: {forecast.words()}")
    say(f"learned {len(agent.topomap)} images in {time.monotonic() - begun:.0f} s")
    if not again:
        return None
    file = keep_learned(building, agent)
    say(f"kept as {file}")
    return file


def drive_by_sight(
    task: Task,
    agent: MengAgent,
    seed: int,
    say: Say = silent,
    oracle: tuple[Frames, Drive] | None = None,
    write: Write = lambda picture: None,
    file: Path | None = None,
) -> tuple[Frames, Outcome]:
    """Navigate with a map; the film, and how it went.

    Args:
        task: what to drive.
        agent: with its map.
        seed: that is reported.
        say: is called with what is being done.
        oracle: its film, which is shown beside, and how it went.
        write: is called with each picture of the film as soon as there is one.
        file: of the map, where it was kept.
    """
    building, trial = task.building, task.trial
    poses, goal = vertex_poses(building, agent.topomap), trial.goal_poses[0]
    navigation = agent.start(goals_of(trial, view_of(building.camera), K))
    title = f"{building.name}: from {task.rooms[0]} to {task.rooms[1]}"
    view = map_view(building.scene, agent.topomap, poses, task.bounds)
    said = time.monotonic()
    film: list[Moment] = []
    legend = (*LEGEND, ("vertex of the map", hue(0)))
    shown = Beside(RolloutFilm(view, film, title, legend), oracle[0] if oracle else ())

    def watch(moment: Moment) -> None:
        nonlocal said
        film.append(moment)
        write(shown[len(film) - 1])
        if time.monotonic() - said > _QUIET:
            said = time.monotonic()
            say("driving: " + ", ".join(f"{name} {value}" for name, value in moment.lines))

    say("driving by sight")
    name = file.name if file else "learned now"
    recorder = FilmRecorder(BySight(navigation, poses, goal, task.image, name), watch)
    went = drive(task, lambda _: navigation, recorder, navigation.history[0])
    for i in range(len(film), len(shown)):  # the oracle is still under way
        write(shown[i])
    plans, topomap = navigation.history[0], agent.topomap
    outcome = Outcome(
        **asdict(went),
        name="demo",
        plan=building.name,
        seed=seed,
        rooms=task.rooms,
        rooms_away=task.away,
        start=rounded(trial.starts[0]),
        goal=rounded(goal),
        geodesic=round(float(building.paths.between(trial.starts[:, :2], goal[None, :2])[0]), 2),
        body=repr(building.body),
        camera=repr(building.camera),
        people=len(task.people),
        probability=round(plans[0].probability, 3),
        plans=len(plans),
        drives=len(building.recorded.trajectories),
        composed_of=len({int(topomap.trajectory[vertex]) for vertex in plans[0].vertices}),
        map=file.name if file else None,
        vertices=len(topomap),
        edges=topomap.graph.number_of_edges(),
        oracle=oracle[1] if oracle else None,
    )
    return shown, outcome


def drive_oracle(task: Task, say: Say = silent) -> tuple[Frames, Drive]:
    """Drive the same task by an oracle: its film, and how it went."""
    say("driving by the oracle, which knows the floor plan and its pose")
    building, goals = task.building, task.trial.goal_poses
    recorder = FilmRecorder(ByOracle(building.paths.fields(goals[0, :2]), task.image))
    went = drive(task, lambda sim: OracleNavigation(sim, building.paths, goals), recorder)
    view = PlanView(building.scene, bounds=task.bounds)
    return RolloutFilm(view, recorder.moments, "oracle: knows plan and pose"), went


def drive(
    task: Task,
    start: Callable[[Simulation], Navigation],
    recorder: FilmRecorder,
    plans: Sequence[Plan] = (),
    sensors: Sensors | None = None,
) -> Drive:
    """Drive a task, and say how it went; the robot's plans are read when it is over."""
    found = navigate(task.building, task.trial, start, task.people, recorder, sensors)
    return recorder.finish(reached=bool(found.there[0]), ending=drive_ending(found, plans))


def drive_ending(found: TrialOutcome, plans: Sequence[Plan] = ()) -> str:
    """How the only drive of a navigation ended; when, is said beside it.

    Args:
        found: of one trial.
        plans: of the robot, where it plans.
    """
    gap = float(found.gap[0])
    off = f"{gap:.1f} m from the goal"
    ending = str(found.ending[0])
    if ending == "arrived" and found.there[0]:
        return f"reached the goal, {gap:.2f} m from it"
    if ending == "arrived":
        belief = f", believing {plans[-1].probability:.1%}" if plans else ""
        return f"stopped {off}{belief}"
    if ending == "stuck":
        return f"collided: touched something for {STUCK:.0f} s, {off}"
    if ending == "late":
        return f"out of time, {off}"
    refusal = plans[-1].refusal if plans else ""
    if refusal and len(plans) == 1:
        return f"refused: {refusal}"
    why = f": {refusal}" if refusal else ""
    return f"gave up, {off}{why}"
