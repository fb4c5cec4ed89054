"""The demo by sight: the car is shown a picture taken in the next room, and drives there."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from tutorial_lib.driving.demonstrations import demonstrate
from tutorial_lib.driving.episodes import Episodes
from tutorial_lib.driving.gridpath import GridPaths, path_length
from tutorial_lib.driving.local import ComposedController
from tutorial_lib.driving.metrics import REACHED
from tutorial_lib.driving.recorded import RecordedWorld
from tutorial_lib.driving.rmp import RMPController
from tutorial_lib.driving.rollouts import geodesic_limit
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.demo import EVERY, FILM_RATE, Outcome, check_folder, leave
from tutorial_lib.geometry import Array, to_world
from tutorial_lib.interfaces import Observation
from tutorial_lib.learning.estimators import WaypointNetwork
from tutorial_lib.learning.pilots import encoded
from tutorial_lib.viz.dashboard import DriveFilm, Moment
from tutorial_lib.viz.plan_view import Picture, PlanView
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera
from tutorial_lib.world.simulation import Simulation

NETWORK = "waypoint_k5"
CARS = 24
"""That record drives, of which one leads from the start to the goal."""
_NEAREST = 2.2  # metres of the drive from the start to the goal
_AROUND = 2.0  # metres of the map around the drive
_SHARP = Camera(rows=64, columns=192)  # for the film; the network looks at 16 x 64


def drive_by_sight(plan: FloorPlan, seed: int, folder: Path) -> Outcome:
    """Drive to a goal picture in the next room; leave demo.webm, demo.png and demo.json.

    The car gets its camera, its laser, and the pictures of the goal with their context, which were
    recorded on an earlier drive. It gets neither map nor pose.

    Raises:
        InputError: when no recorded drive leads from one room to the next.
    """
    check_folder(folder)
    rng = np.random.default_rng(seed)
    scene = Scene(plan)
    name = f"{plan.family} {plan.seed}"
    recorded = RecordedWorld(scene, demonstrate(name, scene, CARS, seed))
    episode, rooms = choose_errand(recorded, rng)
    predictor = WaypointNetwork(NETWORK)
    simulation = Simulation(scene, episode.starts)
    moments, track = _drive(simulation, predictor, episode)
    gap = float(np.linalg.norm(simulation.poses[0, :2] - episode.goals[0, :2]))
    geodesic = GridPaths(scene.clearance).fields(episode.goals[:, :2], shortest=True)
    outcome = Outcome(
        name="demo by sight",
        plan=name,
        seed=seed,
        rooms=rooms,
        rooms_away=1,
        reached=gap < REACHED and not simulation.collided[0],
        collided=bool(simulation.collided[0]),
        seconds=round(simulation.seconds, 1),
        driven=round(path_length(track), 2),
        geodesic=round(float(geodesic.distance(episode.starts[:, :2])[0]), 2),
        people=0,
    )
    title = f"{name}: by sight from {rooms[0]} to {rooms[1]}"
    driven = np.concatenate([track, episode.goals[:, :2]])
    low, high = driven.min(axis=0), driven.max(axis=0)
    half = (high - low).max() / 2 + _AROUND
    bounds = [*((low + high) / 2 - half), *((low + high) / 2 + half)]
    leave(folder, DriveFilm(PlanView(scene, bounds=bounds), moments, title), outcome)
    return outcome


def choose_errand(
    recorded: RecordedWorld, rng: np.random.Generator
) -> tuple[Episodes, tuple[str, str]]:
    """One episode through a door along a recorded drive, and the kinds of the two rooms.

    Raises:
        InputError: when no drive leads from room to room.
    """
    plan = recorded.scene.plan
    rooms, joined = plan.rooms, np.zeros((len(plan.rooms), len(plan.rooms)), dtype=bool)
    for door in plan.doors:
        first, second = door.rooms
        joined[first, second] = joined[second, first] = True
    sources, targets = recorded.draw(4_000, 1, rng)
    where = np.stack([room.contains(recorded.poses[:, :2]) for room in rooms])
    room_of = np.where(where.any(axis=0), where.argmax(axis=0), -1)
    ahead = recorded.arc[targets] - recorded.arc[sources]
    apart = (room_of[sources] >= 0) & (room_of[targets] >= 0)
    apart &= joined[room_of[sources], room_of[targets]] & (ahead >= _NEAREST)
    if not apart.any():
        raise InputError("demo: no drive leads from one room to the next; give a plan with rooms")
    first = np.flatnonzero(apart)[0]
    source, target = sources[first], targets[first]
    kinds = (rooms[room_of[source]].kind, rooms[room_of[target]].kind)
    start, paths = recorded.poses[[source]], GridPaths(recorded.scene.clearance)
    limit = geodesic_limit(paths, start, recorded.poses[[target], :2])
    return Episodes(recorded, start, targets[[first]], ahead[[first]], limit), kinds


def _drive(
    simulation: Simulation, predictor: WaypointNetwork, episode: Episodes
) -> tuple[list[Moment], Array]:
    """Drive until the goal is reached, something is touched or time is up."""
    controller = ComposedController(predictor, RMPController())
    targets, goal = encoded(predictor, episode.recorded, episode.targets), episode.goals[0]
    picture = _SHARP.look(simulation.scene, goal[None])[0][0]
    track, moments = [simulation.poses[0, :2]], []
    while True:
        gap = float(np.linalg.norm(simulation.poses[0, :2] - goal[:2]))
        over = gap < REACHED or simulation.collided[0] or simulation.seconds >= episode.limit[0]
        seen = simulation.observe()
        if over or len(track) % EVERY == 1:
            told = predictor.predict(seen, targets)
            moments.append(_moment(simulation, seen, told, np.array(track), goal, picture))
        if over:
            return moments + moments[-1:] * round(FILM_RATE), np.array(track)
        simulation.step(controller.act(seen, targets))
        track.append(simulation.poses[0, :2])


def _moment(
    simulation: Simulation,
    seen: Observation,
    told: tuple[Array, Array],
    track: Array,
    goal: Array,
    picture: Picture,
) -> Moment:
    """What the film shows: the path is the straight line to the waypoint that is predicted."""
    pose, (waypoints, overlaps) = simulation.poses[0], told
    sharp = _SHARP.look(simulation.scene, pose[None], simulation.discs)[0]
    path = np.stack([pose[:2], to_world(pose, waypoints[0])])
    lines = (
        ("time", f"{simulation.seconds:.1f} s"),
        ("waypoint, ahead and left", f"{waypoints[0, 0]:+.2f}, {waypoints[0, 1]:+.2f} m"),
        ("overlap of the pictures", f"{overlaps[0, 0]:.0%}, {overlaps[0, 1]:.0%}"),
        ("speed", f"{simulation.speed[0]:+.2f} m/s"),
    )
    return Moment(
        pose,
        simulation.body.footprint,
        replace(seen, image=sharp),
        track,
        path,
        goal[:2],
        simulation.discs,
        lines,
        picture,
    )
