"""The demo: the car knows a building from drives, is shown a picture, and finds its way to it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from tutorial_lib.agents.navigator import MapNavigation
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.demos.oracle_demo import (
    EVERY,
    FILM_RATE,
    ROOMS_AWAY,
    Outcome,
    check_folder,
    doors_between,
    leave,
    place_people,
)
from tutorial_lib.experiments.protocols.navigation import (
    GRACE,
    NEAR,
    TIMES,
    K,
    experiences,
    goals_of,
    vertex_poses,
)
from tutorial_lib.experiments.protocols.navigation_tasks import Building, Trials, explored, trials
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
"""Between which drives are recorded."""
_TRIALS = 40  # of which one leads as many rooms away as can be
_SHARP = Camera(rows=64, columns=192)  # for the film; the network looks at 16 x 64
_FADED = 0.6  # of the plan, under the map


def run_map_demo(plan: FloorPlan, seed: int, folder: Path) -> Outcome:
    """Learn a map, find to a picture some rooms away; leave demo.webm, demo.png and demo.json.

    Raises:
        InputError: when the plan is too small for `PLACES` places.
    """
    check_folder(folder)
    use_threads(2)
    film, outcome = navigate_once(Scene(plan), seed)
    leave(folder, film, outcome)
    return outcome


def navigate_once(scene: Scene, seed: int, places: int = PLACES) -> tuple[RolloutFilm, Outcome]:
    """Record drives between places, learn a map, and find to a picture: the film, and how it went.

    The car gets its camera and laser, what was sensed on the drives, and the goal's picture; it
    gets neither the floor plan nor its pose.
    """
    name = f"{scene.plan.family} {scene.plan.seed}"
    house = explored(name, scene, np.random.default_rng(seed), places)
    agent = agents.meng()
    agent.learn(list(experiences(house)))
    asked, rooms, away = farthest(house, trials(house, _TRIALS, np.random.default_rng(seed)))
    people = people_beside(asked, scene)
    simulation = Simulation(scene, asked.starts, people=people)
    journey = agent.start(goals_of(asked, VIEWS["camera16"], K))
    poses = vertex_poses(house, agent.topomap)
    moments, track = _drive(simulation, journey, asked, poses)
    gap = float(np.linalg.norm(simulation.poses[0, :2] - asked.goal_poses[0, :2]))
    ends, plans = (asked.starts[:, :2], asked.goal_poses[:, :2]), journey.history[0]
    outcome = Outcome(
        name="demo",
        plan=name,
        seed=seed,
        rooms=rooms,
        rooms_away=away,
        reached=bool(journey.arrived[0]) and gap <= NEAR,
        collided=bool(simulation.collided[0]),
        seconds=round(simulation.seconds, 1),
        driven=round(float(arc_length(track)[-1]), 2),
        geodesic=round(float(house.paths.between(*ends)[0]), 2),
        people=len(people),
        probability=round(plans[0].probability, 3),
        plans=len(plans),
        vertices=len(agent.topomap),
        edges=agent.topomap.graph.number_of_edges(),
    )
    title = f"{name}: from {rooms[0]} to {rooms[1]}"
    return RolloutFilm(view_of(house, agent.topomap, poses), moments, title), outcome


def farthest(house: Building, asked: Trials) -> tuple[Trials, tuple[str, str], int]:
    """The trial that leads `ROOMS_AWAY` rooms away, or as nearly; the rooms' kinds; the doors."""
    plan = house.scene.plan
    ends = np.stack([asked.starts[:, :2], asked.goal_poses[:, :2]])
    inside = np.stack([room.contains(ends.reshape(-1, 2)) for room in plan.rooms])
    room = inside.argmax(axis=0).reshape(2, -1)
    doors = doors_between(plan)[room[0], room[1]]
    doors = np.where(np.isfinite(doors), doors, 0).astype(int)
    if not len(asked):
        raise InputError(f"demo: no way between places of {plan.family}; give a larger map")
    best = int(np.lexsort((-asked.seconds, np.abs(doors - ROOMS_AWAY)))[0])
    kinds = tuple(plan.rooms[int(number)].kind for number in room[:, best])
    return asked.some(np.array([best])), (kinds[0], kinds[1]), int(doors[best])


def view_of(house: Building, topomap: TopoMap, poses: Array) -> PlanView:
    """The plan with the map on it."""
    view = PlanView(house.scene)
    view.base = faded(view.base, _FADED)
    draw_topomap(view, view.base, topomap, poses)
    return view


def _drive(
    simulation: Simulation, journey: MapNavigation, asked: Trials, poses: Array
) -> tuple[list[Moment], Array]:
    """Drive until the car declares to be there, gives up, or time is up."""
    goal, robots = asked.goal_poses[0], np.array([0])
    picture = _SHARP.look(simulation.scene, goal[None])[0][0]
    track, moments = [simulation.poses[0, :2]], []
    limit = TIMES * asked.seconds[0] + GRACE
    while True:
        action = journey.act(simulation.observe(), robots)
        over = journey.arrived[0] or journey.given_up[0] or simulation.seconds >= limit
        if over or len(track) % EVERY == 1:
            moments.append(moment(simulation, journey, np.array(track), poses, goal, picture))
        if over:
            return moments + moments[-1:] * round(FILM_RATE), np.array(track)
        simulation.step(action)
        track.append(simulation.poses[0, :2])


def moment(
    simulation: Simulation,
    journey: MapNavigation,
    track: Array,
    poses: Array,
    goal: Array,
    picture: Picture,
) -> Moment:
    """What the film shows: the plan over its anchors to the goal, and what it is worth."""
    pose, run, plans = simulation.poses[0], journey.run, journey.history[0]
    sharp = _SHARP.look(simulation.scene, pose[None], simulation.discs)[0]
    here, count = max(int(run.active[0]), 0), len(plans[-1].vertices)
    ahead = [poses[vertex, :2] for vertex in plans[-1].vertices[here:]]
    path = np.stack([pose[:2], *ahead, goal[:2]])
    doing = "looks around" if journey.plans[0] is None else State(run.state[0]).name
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


def people_beside(asked: Trials, scene: Scene) -> list[Person]:
    """Two people beside the way that an oracle took."""
    way = asked.recorded.poses[asked.recorded.first[asked.goals[0]] : asked.goals[0] + 1, :2]
    return place_people(way, scene)
