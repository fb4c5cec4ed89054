"""The task of a demo: from which place to which the robot navigates, past whom."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import shortest_path

from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.driving.data.perturbation import PAPER_PERTURBATION, perturbed
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.demos.ends import End, room_names
from tutorial_lib.experiments.demos.moments import sharp
from tutorial_lib.experiments.demos.routes import check_arrival, learned, trial_to
from tutorial_lib.experiments.demos.sureness import recognised_from, sureness
from tutorial_lib.experiments.protocols.navigation_tasks import (
    ROOMY,
    Building,
    Trials,
    recorded_between,
    spread_places,
)
from tutorial_lib.experiments.protocols.odometry import Odometry
from tutorial_lib.geometry import Array, arc_length
from tutorial_lib.viz.canvas.colours import PERSON
from tutorial_lib.viz.canvas.plan_view import Picture
from tutorial_lib.world.bodies import BicycleCar, Body
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.people import Person
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera

ROOMS_AWAY = 3
"""Doors of a trip, as nearly as there is one."""
TRIP = 20.0
"""Metres of a trip, as nearly as there is one, between those with as many doors."""
SURE = 0.7
"""Probability along a drive that makes a good trip; else that with the greatest is taken."""
RECOGNISED = 6
"""Places on the drives from which RE is sure of a good trip's goal."""
PART = 30.0
"""Metres on each side of the part of a larger plan in which a demo takes place."""
_MARGIN = 8.0  # metres around start and goal that were asked for
_NEAREST = 3.0  # metres between those
_TRIED = 8  # trips, of which the first that will do is run
_STROLL = 2.5  # metres that a person walks to and fro
_ASIDE = 0.45  # metres beside the path
_AT_EASE = 1.0  # metres of the path without people at either end

Say = Callable[[str], None]
"""Is called with what is being done."""


def silent(text: str) -> None:
    """Say nothing."""


@dataclass(frozen=True, eq=False)
class Task:
    """From which place to which an agent navigates, past whom.

    Attributes:
        building: with the drives that are learned.
        recorded: how many drives were recorded.
        trial: the only one.
        rooms: their names.
        away: doors between them.
        people: who walk beside the path.
        image: (H, W, 3) of the goal.
        bounds: x0, y0, x1, y1 of the part of the plan in which it takes place.
    """

    building: Building
    recorded: int
    trial: Trials
    rooms: tuple[str, str]
    away: int
    people: list[Person]
    image: Picture
    bounds: Array


def choose_task(
    scene: Scene,
    seed: int,
    places: int,
    agent: MengAgent,
    say: Say = silent,
    *,
    name: str = "",
    start: End | None = None,
    goal: End | None = None,
    body: Body | None = None,
    camera: Camera | None = None,
) -> Task:
    """Record drives between places of a scene, choose a trip, and the drives that are learned.

    Args:
        scene: the world.
        seed: of everything that is random.
        places: their number.
        agent: RE of this agent predicts along which drives it arrives.
        say: is called with what is being done.
        name: of the world; its family and seed unless given.
        start: that was asked for.
        goal: that was asked for.
        body: of the robots that record the drives and that navigates, a `BicycleCar` unless given.
        camera: through which they look, the usual one unless given.

    Raises:
        InputError: when the scene is too small, or a start or goal cannot be had.
    """
    rng = np.random.default_rng(seed)
    say("recording drives between the places of the building")
    paths, body = GridPaths(scene.clearance), body or BicycleCar()
    begins, ends = (None if end is None else end.find(scene, paths, body) for end in (start, goal))
    given = np.array([end for end in (begins, ends) if end is not None]).reshape(-1, 3)
    _check_apart(paths, given)
    paths, bounds = _part_of(scene, paths, given[:, :2], rng)
    spread = spread_places(paths, max(places - len(given), 1), rng)
    name = name or f"{scene.plan.family} {scene.plan.seed}"
    chosen = np.concatenate([given[:, :2], spread])
    whole = recorded_between(name, scene, paths, chosen, Odometry(seed=(seed,)), body)
    whole = replace(whole, camera=camera or Camera())
    fits = np.ones(len(whole.pairs), bool)
    if start is not None:
        fits &= whole.pairs[:, 0] == 0
    if goal is not None:
        fits &= whole.pairs[:, 1] == len(given) - 1
        check_arrival(whole, given[-1], goal.option)
    say("choosing a start and a goal image")
    sure = np.array([one.prod() for one in sureness(whole, agent)])
    heading = np.nan if ends is None else float(ends[2])
    trips = _trips(whole, fits, sure)
    found = _first_trip(whole, trips, begins, heading, sure, agent, rng)
    if found is None:
        advice = "choose other places, or turn the goal" if len(given) else "give a larger map"
        raise InputError(f"demo: the car arrives on no drive through {name}; {advice}")
    return task_of(*found, len(whole.pairs), bounds)


def _first_trip(
    whole: Building,
    trips: Sequence[int],
    start: Array | None,
    heading: float,
    sure: Array,
    agent: MengAgent,
    rng: np.random.Generator,
) -> tuple[Building, Trials] | None:
    """The first trip whose goal is recognised well; else that whose goal is recognised best.

    Returns:
        The building with the drives that are learned, and the trial; none if no car arrives.
    """
    best, most = None, -1
    for number in trips:
        goal = np.append(whole.places[whole.pairs[number, 1]], heading)
        trial = _trial(whole, number, start, goal, rng)
        if trial is None:
            continue
        found = learned(whole, number, goal, sure), trial
        places = recognised_from(*found, agent)
        if places > most:
            best, most = found, places
        if places >= RECOGNISED:
            break
    return best


def _trial(
    whole: Building, number: int, start: Array | None, goal: Array, rng: np.random.Generator
) -> Trials | None:
    """The trial that a drive would lead along; it starts as was asked for, or perturbed."""
    if start is not None and not np.isnan(start[2]):
        return trial_to(whole, number, start, goal)
    first = whole.recorded.poses[whole.recorded.first_frames[[number]]]
    starts, found = perturbed(whole.scene, first, PAPER_PERTURBATION, rng, whole.body)
    return trial_to(whole, number, starts[0] if found[0] else first[0], goal)


def task_of(building: Building, trial: Trials, recorded: int, bounds: Array) -> Task:
    """The task of a trial, for which the drives of a building are learned."""
    scene, first = building.scene, trial.recorded.first[trial.goals[0]]
    ends = trial.starts[:, :2], trial.goal_poses[:, :2]
    rooms, doors = _doors(scene.plan, *ends)
    names = room_names(scene.plan)
    return Task(
        building=building,
        recorded=recorded,
        trial=trial,
        rooms=(names[rooms[0, 0]], names[rooms[1, 0]]),
        away=int(doors[0]),
        people=place_people(trial.recorded.poses[first : trial.goals[0] + 1, :2], scene),
        image=sharp(building.camera).look(scene, trial.goal_poses[:1])[0][0],
        bounds=bounds,
    )


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


def doors_between(plan: FloorPlan) -> Array:
    """(R, R) the least number of doors between every two rooms; inf where there is none."""
    joined = np.zeros((len(plan.rooms),) * 2)
    for door in plan.doors:
        joined[door.rooms] = 1.0
    return shortest_path(joined, directed=False, unweighted=True)


def _doors(
    plan: FloorPlan, starts: Array, goals: Array
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The rooms (2, N) of starts (N, 2) and goals (N, 2), and the doors (N,) between them."""
    ends = np.concatenate([starts, goals])
    room = np.stack([one.contains(ends) for one in plan.rooms]).argmax(axis=0).reshape(2, -1)
    doors = doors_between(plan)[room[0], room[1]]
    return room, np.where(np.isfinite(doors), doors, 0).astype(int)


def _trips(building: Building, fits: NDArray[np.bool_], sure: Array) -> list[int]:
    """The drives that could be trips, those first that a demo should show.

    Args:
        building: with all drives.
        fits: (D,) those that join a start and a goal that were asked for.
        sure: (D,) probability along each.
    """
    lengths = np.array([one.arc_length[-1] for one in building.recorded.trajectories])
    _, doors = _doors(building.scene.plan, *building.places[building.pairs.T])
    unsure = np.maximum(SURE - sure, 0.0)
    order = np.lexsort((np.abs(lengths - TRIP), np.abs(doors - ROOMS_AWAY), unsure))
    return order[fits[order]][:_TRIED].tolist()


def _check_apart(paths: GridPaths, given: Array) -> None:
    if len(given) == 2:
        metres = float(paths.between(given[:1, :2], given[1:, :2])[0])
        if metres < _NEAREST:
            raise InputError(
                f"--goal: {metres:.1f} m from the start; choose places {_NEAREST:.0f} m apart"
            )


def _part_of(
    scene: Scene, paths: GridPaths, given: Array, rng: np.random.Generator
) -> tuple[GridPaths, Array]:
    """The paths in a part of a plan, which holds given places (N, 2), and the part's bounds.

    A plan that is not much larger than `PART` is taken as a whole.
    """
    whole = np.array(scene.plan.bounds)
    if (whole[2:] - whole[:2]).max() <= 1.2 * PART:
        return paths, whole
    roomy = paths.largest & (paths.clearance >= ROOMY)
    around = given if len(given) else paths.points[[rng.choice(np.flatnonzero(roomy))]]
    low, high = around.min(axis=0), around.max(axis=0)
    half = np.maximum(PART, high - low + 2 * _MARGIN) / 2
    corner = np.clip(
        (low + high) / 2 - half, whole[:2], np.maximum(whole[2:] - 2 * half, whole[:2])
    )
    bounds = np.concatenate([corner, np.minimum(corner + 2 * half, whole[2:])])
    grid = scene.clearance
    (top, left), (bottom, right) = grid.cells(bounds.reshape(2, 2))
    clearance = np.zeros_like(grid.clearance)
    inside = np.s_[top : bottom + 1, left : right + 1]
    clearance[inside] = grid.clearance[inside]
    part = GridPaths(replace(grid, clearance=clearance))
    nodes = part.nearest(given)[0]
    if (nodes < 0).any() or not part.largest[nodes].all():
        return paths, whole  # start and goal are joined outside
    return part, bounds
