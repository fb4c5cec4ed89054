"""The demo: image-goal navigation over a map learned from recorded trajectories, on film."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from tutorial_lib.agents.navigator import MapNavigation
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.demos.oracle_demo import (
    ROOMS_AWAY,
    FilmRecorder,
    Outcome,
    check_folder,
    doors_between,
    leave,
    place_people,
)
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
from tutorial_lib.geometry import Array, arc_length
from tutorial_lib.learning.estimators import use_threads
from tutorial_lib.learning.views import VIEWS
from tutorial_lib.topology.following.transitions import State
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView
from tutorial_lib.viz.canvas.topomaps import draw_topomap
from tutorial_lib.viz.figures.dashboard import Moment, RolloutFilm
from tutorial_lib.viz.figures.panels import faded
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.people import Person
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera
from tutorial_lib.world.simulation import Simulation

PLACES = 6
"""Places between which trajectories are recorded."""
_TRIALS = 40  # of which the one that leads most rooms away is run
_SHARP = Camera(rows=64, columns=192)  # for the film; the network looks at 16 x 64
_FADED = 0.6  # of the plan, under the map


def run_map_demo(plan: FloorPlan, seed: int, folder: Path) -> Outcome:
    """Learn a map, navigate to an image some rooms away; leave demo.webm, demo.png and demo.json.

    Raises:
        InputError: when the plan is too small for `PLACES` places.
    """
    check_folder(folder)
    use_threads(1)  # for one robot, a second thread would mostly wait
    film, outcome = navigate_once(Scene(plan), seed)
    leave(folder, film, outcome)
    return outcome


def navigate_once(scene: Scene, seed: int, places: int = PLACES) -> tuple[RolloutFilm, Outcome]:
    """Record trajectories, learn a map, and navigate to an image: the film, and how it went.

    The car gets its camera and laser, what was observed on the trajectories, and the goal image; it
    gets neither the floor plan nor its pose.
    """
    name = f"{scene.plan.family} {scene.plan.seed}"
    building = explored(name, scene, np.random.default_rng(seed), places)
    agent = agents.meng()
    agent.learn(list(experiences(building)))
    drawn = draw_trials(building, _TRIALS, np.random.default_rng(seed))
    trial, rooms, away = farthest(building, drawn)
    people = people_beside(trial, scene)
    navigation = agent.start(goals_of(trial, VIEWS["camera16"], K))
    poses, goal = vertex_poses(building, agent.topomap), trial.goal_poses[0]
    image = _SHARP.look(scene, goal[None])[0][0]
    recorder = FilmRecorder(
        lambda simulation, track: moment(simulation, navigation, track, poses, goal, image)
    )
    started: list[Simulation] = []

    def start(simulation: Simulation) -> MapNavigation:
        started.append(simulation)
        return navigation

    found = navigate(building, trial, start, people, recorder)
    recorder.finish(started[0])
    ends, plans = (trial.starts[:, :2], goal[None, :2]), navigation.history[0]
    outcome = Outcome(
        name="demo",
        plan=name,
        seed=seed,
        rooms=rooms,
        rooms_away=away,
        reached=bool(found.there[0]),
        collided=bool(started[0].collided[0]),
        seconds=round(float(found.seconds[0]), 1),
        driven=round(float(arc_length(recorder.track)[-1]), 2),
        geodesic=round(float(building.paths.between(*ends)[0]), 2),
        people=len(people),
        probability=round(plans[0].probability, 3),
        plans=len(plans),
        vertices=len(agent.topomap),
        edges=agent.topomap.graph.number_of_edges(),
    )
    title = f"{name}: from {rooms[0]} to {rooms[1]}"
    return RolloutFilm(view_of(building, agent.topomap, poses), recorder.moments, title), outcome


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


def view_of(building: Building, topomap: TopoMap, poses: Array) -> PlanView:
    """The plan with the map on it."""
    view = PlanView(building.scene)
    view.base = faded(view.base, _FADED)
    draw_topomap(view, view.base, topomap, poses)
    return view


def moment(
    simulation: Simulation,
    navigation: MapNavigation,
    track: Array,
    poses: Array,
    goal: Array,
    picture: Picture,
) -> Moment:
    """What the film shows: the plan over its anchors to the goal, and its probability."""
    pose, plans = simulation.poses[0], navigation.history[0]
    memory = navigation.follower.memory
    sharp = _SHARP.look(simulation.scene, pose[None], simulation.discs)[0]
    here, count = max(int(memory.active[0]), 0), len(plans[-1].vertices)
    ahead = [poses[vertex, :2] for vertex in plans[-1].vertices[here:]]
    path = np.stack([pose[:2], *ahead, goal[:2]])
    doing = "searches" if navigation.plans[0] is None else State(memory.state[0]).name
    lines = (
        ("time", f"{simulation.seconds:.1f} s"),
        ("probability of the plan", f"{plans[-1].probability:.1%}"),
        ("anchor", f"{min(here + 1, count)} of {count}" if here < count else "the goal"),
        ("state", doing.replace("_", " ").lower()),
    )
    return Moment(
        pose,
        simulation.body.footprint,
        replace(simulation.observe(), image=sharp),
        track,
        path,
        goal[:2],
        simulation.discs,
        lines,
        picture,
    )


def people_beside(trial: Trials, scene: Scene) -> list[Person]:
    """Two people beside the path that an oracle took."""
    first = trial.recorded.first[trial.goals[0]]
    return place_people(trial.recorded.poses[first : trial.goals[0] + 1, :2], scene)
