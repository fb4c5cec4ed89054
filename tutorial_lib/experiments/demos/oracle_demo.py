"""The demo with an oracle: from one room to another past two people, on film."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.control.oracle import OraclePolicy
from tutorial_lib.driving.geodesics import CLEARANCE, DistanceFields, GridPaths
from tutorial_lib.driving.metrics import REACHED
from tutorial_lib.driving.rollouts import rollout
from tutorial_lib.errors import InputError
from tutorial_lib.files import check_writable, write_text
from tutorial_lib.geometry import Array, arc_length
from tutorial_lib.interfaces import Observation, Robots
from tutorial_lib.viz.canvas.colours import PERSON
from tutorial_lib.viz.canvas.plan_view import PlanView
from tutorial_lib.viz.figures.dashboard import Moment, RolloutFilm
from tutorial_lib.viz.figures.film import write_film, write_picture
from tutorial_lib.viz.figures.panels import evenly, stacked
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.people import Person
from tutorial_lib.world.placing import is_free
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera
from tutorial_lib.world.simulation import Sensors, Simulation

FILM, STRIP, FIGURES = "demo.webm", "demo.png", "demo.json"
ROOMS_AWAY = 3
_SHORTEST, _FAR = 3.0, 10.0  # metres of path: needed, and enough
_STROLL = 2.5  # metres that a person walks to and fro
_ASIDE = 0.45  # metres beside the path
_AT_EASE = 1.0  # metres of the path without people at either end
_TRIES = 20  # pairs of rooms
EVERY = 2  # simulation steps for each frame of the film
FILM_RATE = 15.0
_STANDING = 0.05  # m/s


@dataclass(frozen=True)
class Outcome:
    """What `demo.json` holds; lengths in metres, times in seconds.

    An agent with a map adds the probability of its first plan, the number of plans, and the size
    of its map.
    """

    name: str
    plan: str
    seed: int
    rooms: tuple[str, str]
    rooms_away: int
    reached: bool
    collided: bool
    seconds: float
    driven: float
    geodesic: float
    people: int
    probability: float | None = None
    plans: int | None = None
    vertices: int | None = None
    edges: int | None = None
    film: str = FILM
    strip: str = STRIP


def run_demo(plan: FloorPlan, seed: int, folder: Path) -> Outcome:
    """Drive through `plan` with an oracle; leave demo.webm, demo.png and demo.json in `folder`.

    Raises:
        InputError: when the plan has no two places far enough apart.
    """
    check_folder(folder)
    rng = np.random.default_rng(seed)
    scene = Scene(plan)
    paths = GridPaths(scene.clearance)
    start, goal, rooms, away = choose_places(scene, paths, rng)
    fields = paths.fields(goal)
    path = fields.path(start[:2])
    sensors = Sensors(camera=Camera(rows=64, columns=192))
    people = place_people(path, scene)
    simulation = Simulation(scene, start[None], people=people, sensors=sensors)
    limit = 30.0 + 4.0 * arc_length(path)[-1]
    recorder = FilmRecorder(lambda simulation, track: _moment(simulation, fields, track))
    policy = OraclePolicy(simulation, paths, goal)
    rollout(simulation, policy, _StandAtGoal(goal, limit), recorder)
    recorder.finish(simulation)
    gap = float(np.linalg.norm(simulation.poses[0, :2] - goal))
    outcome = Outcome(
        name="demo",
        plan=f"{plan.family} {plan.seed}",
        seed=seed,
        rooms=rooms,
        rooms_away=away,
        reached=gap < REACHED and not simulation.collided[0],
        collided=bool(simulation.collided[0]),
        seconds=round(simulation.seconds, 1),
        driven=round(float(arc_length(recorder.track)[-1]), 2),
        geodesic=round(float(paths.fields(goal, shortest=True).distance(start[None, :2])[0]), 2),
        people=len(people),
    )
    leave(folder, RolloutFilm(PlanView(scene), recorder.moments, _title(plan, rooms)), outcome)
    return outcome


def check_folder(folder: Path) -> None:
    """Check that a demo can leave its files in `folder`."""
    for name in (FILM, STRIP, FIGURES):
        check_writable(folder / name)


def leave(folder: Path, film: RolloutFilm, outcome: Outcome) -> None:
    """Write the film, its strip of pictures and the figures of a demo into `folder`."""
    write_film(folder / FILM, film, FILM_RATE)
    write_picture(folder / STRIP, stacked([film[i] for i in evenly(len(film), 3)]))
    write_text(folder / FIGURES, json.dumps(asdict(outcome), indent=1) + "\n")


def choose_places(
    scene: Scene, paths: GridPaths, rng: np.random.Generator
) -> tuple[Array, Array, tuple[str, str], int]:
    """A start pose (3,), a goal (2,), the kinds of their rooms and the doors between them.

    The goal is `ROOMS_AWAY` doors away where the plan has such rooms; on a map without rooms it is
    the place farthest from a random one. Of several pairs the first that is far enough is taken.

    Raises:
        InputError: when no two places are at least 3 m apart.
    """
    plan = scene.plan
    doors = doors_between(plan)
    away = min(ROOMS_AWAY, int(doors[np.isfinite(doors)].max()))
    pairs = np.argwhere(doors == away)
    best, best_length = None, _SHORTEST
    for first, second in pairs[rng.permutation(len(pairs))][:_TRIES]:
        here, there = (_nodes_in(plan, paths, room) for room in (first, second))
        if not len(here) or not len(there):
            continue
        goal = paths.points[rng.choice(there)]
        fields = paths.fields(goal)
        start = rng.choice(here) if away else here[fields.cost[0, here].argmax()]
        path = fields.path(paths.points[start])
        pose = _face_along(scene, path)
        if pose is not None and arc_length(path)[-1] >= best_length:
            kinds = (plan.rooms[first].kind, plan.rooms[second].kind)
            best, best_length = (pose, goal, kinds, away), arc_length(path)[-1]
            if best_length >= _FAR:
                break
    if best is None:
        raise InputError(f"demo: {plan.family} has no two places 3 m apart; give a larger map")
    return best


def place_people(path: Array, scene: Scene) -> list[Person]:
    """Two people who walk to and fro beside a path (P, 2), where there is most room."""
    miles = arc_length(path)
    people, middle = [], miles[-1] / 2
    for first, last in ((_AT_EASE, middle), (middle, miles[-1] - _AT_EASE)):
        begins = np.linspace(first, max(first, last - _STROLL), 30)
        stretches = begins[:, None] + np.linspace(0, min(_STROLL, last - first), 12)
        routes = np.stack([np.interp(stretches, miles, path[:, axis]) for axis in (0, 1)], axis=-1)
        along = np.gradient(routes, axis=1)
        left = np.stack([-along[..., 1], along[..., 0]], axis=-1)
        left /= np.linalg.norm(left, axis=-1, keepdims=True)
        routes = np.concatenate([routes + _ASIDE * left, routes - _ASIDE * left])
        roomiest = scene.clearance.at(routes).min(axis=1).argmax()
        people.append(Person(routes[roomiest], speed=0.4, colour=PERSON))
    return people


class _StandAtGoal:
    """The rollout ends when the car stands at the goal, touches something, or time is up."""

    def __init__(self, goal: Array, limit: float) -> None:
        self._goal, self._limit = goal, limit

    def after_step(
        self, simulation: Simulation, seconds: Array, before: Array
    ) -> dict[str, NDArray[np.bool_]]:
        """See `driving.rollouts.Ends`."""
        del before
        gap = np.linalg.norm(simulation.poses[:, :2] - self._goal, axis=1)
        return {
            "late": seconds >= self._limit,
            "collided": simulation.collided,
            "reached": (gap < REACHED) & (np.abs(simulation.speed) < _STANDING),
        }


class FilmRecorder:
    """Keeps a `Moment` of every `EVERY`-th step of one robot, and its track.

    Attributes:
        track: positions (2,), step by step.
        moments: for the film.
    """

    def __init__(self, make_moment: Callable[[Simulation, Array], Moment]) -> None:
        """Record with a function that makes a moment of a simulation and the track (T, 2)."""
        self._make_moment = make_moment
        self.track: list[Array] = []
        self.moments: list[Moment] = []

    def __call__(
        self, simulation: Simulation, robots: Robots, observations: Observation, actions: Array
    ) -> None:
        """See `driving.rollouts.Record`."""
        del robots, observations, actions
        self.track.append(simulation.poses[0, :2])
        if len(self.track) % EVERY == 1:
            self.moments.append(self._make_moment(simulation, np.array(self.track)))

    def finish(self, simulation: Simulation) -> None:
        """Add the last moment, which stays on screen for a second."""
        self.track.append(simulation.poses[0, :2])
        last = self._make_moment(simulation, np.array(self.track))
        self.moments += [last] * (1 + round(FILM_RATE))


def _moment(simulation: Simulation, fields: DistanceFields, track: Array) -> Moment:
    pose, observation = simulation.poses[0], simulation.observe()
    path = fields.path(pose[:2])
    lines = (
        ("time", f"{simulation.seconds:.1f} s"),
        ("to go", f"{arc_length(path)[-1]:.1f} m"),
        ("speed", f"{simulation.speed[0]:+.2f} m/s"),
        ("steering", f"{np.rad2deg(simulation.controls[0, 1]):+.0f} deg"),
    )
    discs, footprint = simulation.discs, simulation.body.footprint
    return Moment(pose, footprint, observation, track, path, fields.goals[0], discs, lines)


def _title(plan: FloorPlan, rooms: tuple[str, str]) -> str:
    if plan.doors:
        return f"{plan.family} {plan.seed}: from {rooms[0]} to {rooms[1]}"
    return f"{plan.family} map, {plan.area:.0f} square metres"


def doors_between(plan: FloorPlan) -> Array:
    """(R, R) the least number of doors between every two rooms; inf where there is none."""
    count = len(plan.rooms)
    doors = np.where(np.eye(count, dtype=bool), 0.0, np.inf)
    for door in plan.doors:
        first, second = door.rooms
        doors[first, second] = doors[second, first] = 1.0
    for between in range(count):
        doors = np.minimum(doors, doors[:, between, None] + doors[None, between])
    return doors


def _nodes_in(plan: FloorPlan, paths: GridPaths, room: int) -> NDArray[np.intp]:
    """Indices of the grid's nodes inside a room, a little off the walls."""
    inside = plan.rooms[room].contains(paths.points)
    return np.flatnonzero(inside & paths.largest & (paths.clearance > CLEARANCE + 0.1))


def _face_along(scene: Scene, path: Array) -> Array | None:
    """A free pose at a path's start that looks along it, as nearly as there is room."""
    ahead = path[min(5, len(path) - 1)] - path[0]
    heading = float(np.arctan2(ahead[1], ahead[0]))
    turns = np.array([0.0, 0.5, -0.5, 1.0, -1.0, 2.0, -2.0, np.pi])
    poses = np.column_stack([np.tile(path[0], (len(turns), 1)), heading + turns])
    free = np.flatnonzero(is_free(scene, BicycleCar(), poses))
    return poses[free[0]] if free.size else None
