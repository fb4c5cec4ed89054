"""The demo: image-goal navigation over a map learned from recorded trajectories, on film."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from tqdm import tqdm

from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.agents.oracle import OracleNavigation
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.demos.learned_map import keep_learned, load_learned
from tutorial_lib.experiments.demos.moments import SHARP, ByOracle, BySight
from tutorial_lib.experiments.demos.outcome import (
    FIGURES,
    FILM,
    STRIP,
    Drive,
    Outcome,
    check_folder,
)
from tutorial_lib.experiments.demos.places import ROOMS_AWAY, doors_between, place_people
from tutorial_lib.experiments.demos.recorder import FILM_RATE, FilmRecorder
from tutorial_lib.experiments.protocols.navigation import (
    K,
    experiences,
    goals_of,
    navigate,
    vertex_poses,
)
from tutorial_lib.experiments.protocols.navigation_tasks import (
    Building,
    Trials,
    draw_trials,
    explored,
)
from tutorial_lib.files import write_text
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Navigation
from tutorial_lib.learning.estimators import use_threads
from tutorial_lib.learning.views import VIEWS
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView
from tutorial_lib.viz.canvas.topomaps import draw_topomap, hue
from tutorial_lib.viz.figures.dashboard import LEGEND, Moment, RolloutFilm
from tutorial_lib.viz.figures.film import film_writer, write_picture
from tutorial_lib.viz.figures.panels import evenly, faded, side_by_side, stacked
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.people import Person
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.simulation import Simulation

PLACES = 6
"""Places between which trajectories are recorded."""
_TRIALS = 40  # of which the one that leads most rooms away is run
_FADED = 0.6  # of the plan, under the map
_BESIDE = 570  # pixels of height where agent and oracle are shown beside each other
_QUIET = 3.0  # seconds of driving after which a word is said

Say = Callable[[str], None]


def _silent(text: str) -> None:
    """Say nothing."""


@dataclass(frozen=True, eq=False)
class Task:
    """From which room to which an agent navigates, past whom.

    Attributes:
        building: explored before.
        trial: the only one.
        rooms: their kinds.
        away: doors between them.
        people: who walk beside the path.
        image: (H, W, 3) of the goal.
    """

    building: Building
    trial: Trials
    rooms: tuple[str, str]
    away: int
    people: list[Person]
    image: Picture


def run_demo(
    plan: FloorPlan,
    seed: int,
    folder: Path,
    *,
    oracle: bool = False,
    learn: bool = False,
    say: Say = _silent,
) -> Outcome:
    """Navigate to an image some rooms away; leave demo.webm, demo.png and demo.json.

    Args:
        plan: of the world.
        seed: of everything that is random.
        folder: for the files.
        oracle: drive the same task by an oracle, too, and show both beside each other.
        learn: learn the map even if one comes with the demo, and keep it in its place.
        say: is called with what is being done.

    Raises:
        InputError: when the plan is too small for `PLACES` places.
    """
    check_folder(folder)
    use_threads(1)  # for one robot, a second thread would mostly wait
    task = choose_task(Scene(plan), seed, PLACES, say)
    agent = agents.meng()
    learn_map(agent, task.building, say, again=learn)
    beside = drive_oracle(task, say) if oracle else None
    with film_writer(folder / FILM, FILM_RATE) as write:
        shown, outcome = drive_by_sight(task, agent, seed, say, beside, write)
        say("writing the film")
    strip = [shown[i] for i in evenly(len(shown), 3)]
    write_picture(folder / STRIP, stacked(strip))
    write_text(folder / FIGURES, json.dumps(asdict(outcome), indent=1) + "\n")
    return outcome


def navigate_once(
    scene: Scene, seed: int, places: int = PLACES
) -> tuple[Sequence[Picture], Outcome]:
    """Record trajectories, learn a map, and navigate to an image: the film, and how it went.

    The car gets its camera and laser, what was observed on the trajectories, and the goal image; it
    gets neither the floor plan nor its pose.
    """
    task, agent = choose_task(scene, seed, places), agents.meng()
    learn_map(agent, task.building)
    return drive_by_sight(task, agent, seed)


def choose_task(scene: Scene, seed: int, places: int, say: Say = _silent) -> Task:
    """Explore a scene, and choose the trial that leads `ROOMS_AWAY` rooms away, or as nearly."""
    name = f"{scene.plan.family} {scene.plan.seed}"
    say("recording trajectories between the places of the building")
    building = explored(name, scene, np.random.default_rng(seed), places)
    say("choosing a start and a goal image")
    drawn = draw_trials(building, _TRIALS, np.random.default_rng(seed))
    trial, rooms, away = farthest(building, drawn)
    first = trial.recorded.first[trial.goals[0]]
    people = place_people(trial.recorded.poses[first : trial.goals[0] + 1, :2], scene)
    image = SHARP.look(scene, trial.goal_poses[:1])[0][0]
    return Task(building, trial, rooms, away, people, image)


def farthest(building: Building, trials: Trials) -> tuple[Trials, tuple[str, str], int]:
    """The trial that leads `ROOMS_AWAY` rooms away, or as nearly; the rooms' kinds; the doors."""
    plan = building.scene.plan
    ends = np.stack([trials.starts[:, :2], trials.goal_poses[:, :2]])
    inside = np.stack([room.contains(ends.reshape(-1, 2)) for room in plan.rooms])
    room = inside.argmax(axis=0).reshape(2, -1)
    doors = doors_between(plan)[room[0], room[1]]
    doors = np.where(np.isfinite(doors), doors, 0).astype(int)
    if not len(trials):
        raise InputError(f"demo: no path between places of {plan.family}; give a larger map")
    best = int(np.lexsort((-trials.seconds, np.abs(doors - ROOMS_AWAY)))[0])
    kinds = tuple(plan.rooms[int(number)].kind for number in room[:, best])
    return trials.subset(np.array([best])), (kinds[0], kinds[1]), int(doors[best])


def learn_map(
    agent: MengAgent, building: Building, say: Say = _silent, *, again: bool = False
) -> None:
    """Give an agent the map of a building: the one that was kept, or learn one."""
    kept = None if again else load_learned(building, agent)
    if kept is not None:
        say(f"loading the learned map: {len(kept)} images")
        agent.topomap = kept
        return
    seen = list(experiences(building))
    say(f"learning a map from {len(seen)} trajectories (about {len(seen) / 3:.0f} s)")
    for one in tqdm(seen, desc="trajectories", leave=False):
        agent.learn([one])
    if again:
        say(f"kept as {keep_learned(building, agent)}")


def drive_by_sight(
    task: Task,
    agent: MengAgent,
    seed: int,
    say: Say = _silent,
    oracle: tuple[Sequence[Picture], Drive] | None = None,
    write: Callable[[Picture], None] = lambda picture: None,
) -> tuple[Sequence[Picture], Outcome]:
    """Navigate with a map; the film, and how it went.

    Args:
        task: what to drive.
        agent: with its map.
        seed: that is reported.
        say: is called with what is being done.
        oracle: its film, which is shown beside, and how it went.
        write: is called with each picture of the film as soon as there is one.
    """
    building, trial = task.building, task.trial
    poses, goal = vertex_poses(building, agent.topomap), trial.goal_poses[0]
    navigation = agent.start(goals_of(trial, VIEWS["camera16"], K))
    title = f"{building.name}: from {task.rooms[0]} to {task.rooms[1]}"
    view = view_of(building, agent.topomap, poses)
    said = time.monotonic()
    film: list[Moment] = []
    legend = (*LEGEND, ("map image", hue(0)))
    shown = Beside(RolloutFilm(view, film, title, legend), oracle[0] if oracle else ())

    def watch(moment: Moment) -> None:
        nonlocal said
        film.append(moment)
        write(shown[len(film) - 1])
        if time.monotonic() - said > _QUIET:
            said = time.monotonic()
            say("driving: " + ", ".join(f"{name} {value}" for name, value in moment.lines))

    say("driving by sight")
    recorder = FilmRecorder(BySight(navigation, poses, goal, task.image), watch)
    found, simulation = drive(task, lambda _: navigation, recorder)
    for i in range(len(film), len(shown)):  # the oracle is still under way
        write(shown[i])
    went = recorder.drive(simulation, reached=found)
    plans = navigation.history[0]
    outcome = Outcome(
        **asdict(went),
        name="demo",
        plan=building.name,
        seed=seed,
        rooms=task.rooms,
        rooms_away=task.away,
        geodesic=round(float(building.paths.between(trial.starts[:, :2], goal[None, :2])[0]), 2),
        people=len(task.people),
        probability=round(plans[0].probability, 3),
        plans=len(plans),
        vertices=len(agent.topomap),
        edges=agent.topomap.graph.number_of_edges(),
        oracle=oracle[1] if oracle else None,
    )
    return shown, outcome


def drive_oracle(task: Task, say: Say = _silent) -> tuple[Sequence[Picture], Drive]:
    """Drive the same task by an oracle: its film, and how it went."""
    say("driving by the oracle, which knows the floor plan and its pose")
    building, goals = task.building, task.trial.goal_poses
    recorder = FilmRecorder(ByOracle(building.paths.fields(goals[0, :2]), task.image))
    found, simulation = drive(
        task, lambda sim: OracleNavigation(sim, building.paths, goals), recorder
    )
    film = RolloutFilm(PlanView(building.scene), recorder.moments, "oracle: knows plan and pose")
    return film, recorder.drive(simulation, reached=found)


def drive(
    task: Task, start: Callable[[Simulation], Navigation], recorder: FilmRecorder
) -> tuple[bool, Simulation]:
    """Drive a task; whether the robot says it is at the goal, and is, and the simulation."""
    started: list[Simulation] = []

    def begin(simulation: Simulation) -> Navigation:
        started.append(simulation)
        return start(simulation)

    found = navigate(task.building, task.trial, begin, task.people, recorder)
    recorder.finish(started[0])
    return bool(found.there[0]), started[0]


def view_of(building: Building, topomap: TopoMap, poses: Array) -> PlanView:
    """The plan with the map on it; its walls stay dark."""
    view = PlanView(building.scene)
    view.base = faded(view.base, _FADED)
    for wall in building.scene.plan.walls:
        view.polyline(view.base, wall.reshape(2, 2), colours.SOLID, 1)
    draw_topomap(view, view.base, topomap, poses)
    return view


@dataclass(frozen=True)
class Beside(Sequence[Picture]):
    """The frames of a film, and beside each the frame of another; the shorter one waits.

    Attributes:
        first: grows while its robot drives.
        second: may be empty; then the first is shown alone.
    """

    first: Sequence[Picture]
    second: Sequence[Picture]

    def __len__(self) -> int:
        return max(len(self.first), len(self.second))

    def __getitem__(self, index: int) -> Picture:
        mine = self.first[min(index, len(self.first) - 1)]
        if not len(self.second):
            return mine
        other = self.second[min(index, len(self.second) - 1)]
        return side_by_side([mine, other], height=_BESIDE, gap=20)
