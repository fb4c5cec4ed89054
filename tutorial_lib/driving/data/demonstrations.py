"""Demonstrations: an oracle drives between random places, and what the robots sense is recorded.

After Meng 2020 (IV): a reactive controller follows the geodesic at 10 Hz. After its authors' code:
random starts, goals and headings in the free space; rollouts that collide are dropped.
"""

from collections.abc import Sequence
from pathlib import Path
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.control.oracle import TURN_ROUND, OraclePolicy, TurnFirst
from tutorial_lib.driving.data.trajectories import (
    CONTEXT_INTERVAL,
    Trajectory,
    load_trajectories,
    save_trajectories,
)
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.driving.metrics import time_limit
from tutorial_lib.driving.rollouts import ReachGoals, geodesic_limit, rollout
from tutorial_lib.errors import InputError
from tutorial_lib.files import make_folder
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Controller, Observation, Robots
from tutorial_lib.parallel import for_each
from tutorial_lib.validation import floats, instance, whole, with_methods
from tutorial_lib.world.bodies import BicycleCar, Body
from tutorial_lib.world.noise import MOST_ROBOTS, DriftingOdometry, OdometryNoise
from tutorial_lib.world.placing import check_free, checked_body, random_free_poses
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.simulation import STEP, Sensors, Simulation
from tutorial_lib.world.worlds import parse_world, scene_of

NEAREST, FARTHEST = 4.0, 20.0
"""Metres of geodesic from a demonstration's start to its goal."""
_LEAST, _SMALL = 2.0, 0.8  # where nothing is so far: metres at least, and share of the farthest
SHORTEST = 2 * 5 * CONTEXT_INTERVAL + 1
"""Frames of a demonstration at least: one context with k = 5."""


def demonstrate(
    world: str,
    scene: Scene,
    count: int,
    seed: int,
    controller: Controller | None = None,
    odometry_noise: OdometryNoise | None = None,
    body: Body | None = None,
) -> list[Trajectory]:
    """Drive a fleet along geodesics between random places, and record it.

    Args:
        world: name to put on the trajectories.
        scene: that world.
        count: cars that start.
        seed: of starts, goals and noise.
        controller: drives to the waypoints; `PARKING` unless given.
        odometry_noise: of the recorded odometry; it drifts, after the seed, unless given.
        body: of the cars, a `BicycleCar` unless given.

    Returns:
        At most `count` trajectories, those that arrived; each ends a step before its goal counts as
        reached.

    Raises:
        InputError: when the world is too small for a geodesic of 2 m.
    """
    check_recipe(world, scene, seed, odometry_noise)
    count = whole("count", count, least=0, most=MOST_ROBOTS)
    rng = np.random.default_rng(seed)
    paths = GridPaths(scene.clearance)
    body = BicycleCar() if body is None else body
    starts, goals, limit = _starts_and_goals(scene, paths, count, rng, body)
    simulation = _fleet(scene, starts, seed, odometry_noise, body, rng)
    oracle = OraclePolicy(simulation, paths, goals, controller)
    found = _recorded(world, seed, oracle, limit)
    return [one for one in found if one is not None and len(one) >= SHORTEST]


def demonstrate_between(
    world: str,
    scene: Scene,
    paths: GridPaths,
    starts: Array,
    goals: Array,
    seed: int,
    odometry_noise: OdometryNoise | None = None,
    body: Body | None = None,
) -> list[Trajectory | None]:
    """Drive from given poses to given places, and record it.

    Args:
        world: name to put on the trajectories.
        scene: that world.
        paths: its geodesics.
        starts: (N, 3) poses.
        goals: (N, 2) metres.
        seed: to put on the trajectories, and of the drift of the recorded odometry; nothing else
            is random.
        odometry_noise: of the recorded odometry; it drifts, after the seed, unless given.
        body: of the robots, a `BicycleCar` unless given.

    Returns:
        N trajectories as from `demonstrate`, None for a car that did not arrive.

    Raises:
        InputError: when no path leads from a start to its goal.
    """
    check_recipe(world, scene, seed, odometry_noise)
    starts = floats("starts", starts, ("N", 3))
    body = BicycleCar() if body is None else checked_body(body)
    check_free(scene, body, starts, "starts")
    simulation = _fleet(scene, starts, seed, odometry_noise, body)
    limit = geodesic_limit(paths, starts, goals)
    return _recorded(world, seed, OraclePolicy(simulation, paths, goals), limit)


def demonstrate_on(
    world: str,
    scene: Scene,
    paths: GridPaths,
    start: Array,
    goals: Array,
    seed: int,
    odometry_noise: OdometryNoise | None = None,
    body: Body | None = None,
) -> Trajectory | None:
    """Drive one car from place to place without a break, and record it.

    Where the path to the next place begins behind it, the car turns in place first.

    Args:
        world: name to put on the trajectory.
        scene: that world.
        paths: its geodesics.
        start: (1, 3) pose.
        goals: (G, 2) metres, in order.
        seed: as for `demonstrate_between`.
        odometry_noise: likewise.
        body: likewise.

    Returns:
        The trajectory, None if the car did not arrive everywhere.
    """
    check_recipe(world, scene, seed, odometry_noise)
    start = floats("start", start, (1, 3))
    body = BicycleCar() if body is None else checked_body(body)
    check_free(scene, body, start, "start")
    goals = floats("goals", goals, ("G", 2), empty=False)
    simulation, recorder = _fleet(scene, start, seed, odometry_noise, body), Recorder()
    for goal in goals:
        oracle = OraclePolicy(simulation, paths, goal[None])
        limit = geodesic_limit(paths, simulation.poses, goal[None]) + TURN_ROUND
        ends = ReachGoals(oracle.goals, limit)
        if not rollout(simulation, TurnFirst(oracle), ends, record=recorder).reached.all():
            return None
    return recorder.trajectory(world, seed, 0)


def record_demonstrations(
    worlds: Sequence[str],
    count: int,
    seed: int,
    folder: str | Path,
    jobs: int = 2,
) -> list[Path]:
    """Record demonstrations in many worlds, one file each; existing files are kept.

    So an interrupted recording resumes where it stopped and ends with the same files. A file that
    is damaged, or was recorded with another seed or count, is recorded again.

    Args:
        worlds: their names, see `world.worlds`.
        count: cars that start in each world.
        seed: of the whole recording.
        folder: for the files; made where it is missing.
        jobs: processes.

    Returns:
        The files, in the order of `worlds`.

    Raises:
        InputError: when a name is wrong, before anything is recorded, or a world is too small.
    """
    for name in worlds:
        parse_world(name)
    folder = Path(folder)
    make_folder(folder)
    names = list(dict.fromkeys(worlds))
    paths = for_each(_record, names, count, seed, folder, label="demonstrations", jobs=jobs)
    done = dict(zip(names, paths, strict=True))
    return [done[name] for name in worlds]


def world_seed(seed: int, world: str, count: int) -> int:
    """The seed of one world's demonstrations; the same in every process and on every machine."""
    seed, count = whole("seed", seed, least=0), whole("count", count, least=0)
    instance("world", world, str)
    recipe = crc32(f"{world} {count} 0".encode())  # without noise of the controls
    return int(np.random.SeedSequence([seed, recipe]).generate_state(1)[0])


def _record(world: str, count: int, seed: int, folder: Path) -> Path:
    """Record one world, unless its file is there."""
    path = folder / f"{world.replace('/', '-')}.npz"
    own = world_seed(seed, world, count)
    if not _is_recorded(path, world, own):
        save_trajectories(path, demonstrate(world, scene_of(world), count, own))
    return path


def _is_recorded(path: Path, world: str, seed: int) -> bool:
    try:
        found = load_trajectories(path)
    except InputError:
        return False
    return {(one.world, one.seed) for one in found} == {(world, seed)}


def _fleet(
    scene: Scene,
    starts: Array,
    seed: int,
    odometry_noise: OdometryNoise | None,
    body: Body,
    rng: np.random.Generator | None = None,
) -> Simulation:
    """Images are rendered on load; the controllers need only the laser."""
    odometry = DriftingOdometry(seed) if odometry_noise is None else odometry_noise
    sensors = Sensors(camera=None)
    return Simulation(scene, starts, body=body, odometry_noise=odometry, sensors=sensors, rng=rng)


def _recorded(world: str, seed: int, oracle: OraclePolicy, limit: Array) -> list[Trajectory | None]:
    """The trajectory of each robot, None for one that did not arrive."""
    recorder = Recorder()
    rollouts = rollout(oracle.simulation, oracle, ReachGoals(oracle.goals, limit), record=recorder)
    return [
        recorder.trajectory(world, seed, robot) if reached else None
        for robot, reached in enumerate(rollouts.reached)
    ]


def _starts_and_goals(
    scene: Scene, paths: GridPaths, count: int, rng: np.random.Generator, body: Body
) -> tuple[Array, Array, Array]:
    """Random starts (N, 3), goals (N, 2) and time limits (N,) in seconds."""
    places = np.flatnonzero(paths.largest)
    starts = random_free_poses(scene, body, paths.points[places], count, rng)
    distance = paths.fields(starts[:, :2], shortest=True).cost[:, places]
    goals = np.empty(count, dtype=np.intp)
    for robot, far in enumerate(distance):
        farthest = far.max()
        if farthest < _LEAST:
            raise InputError(
                f"demonstrations: no place is {_LEAST} m away from where a car starts; "
                "give a larger world"
            )
        nearest = NEAREST if farthest >= NEAREST else _SMALL * farthest
        fit = np.flatnonzero((far >= nearest) & (far <= FARTHEST))
        goals[robot] = rng.choice(fit)
    limit = time_limit(distance[np.arange(count), goals])
    return starts, paths.points[places[goals]], limit


class Recorder:
    """Records what the moving robots sense and do."""

    def __init__(self) -> None:
        """Nothing yet."""
        self._steps: list[tuple[Robots, tuple[NDArray[np.floating], ...]]] = []

    def __call__(
        self, simulation: Simulation, robots: Robots, seen: Observation, actions: Array
    ) -> None:
        """Keep one step, before it is made."""
        laser = seen.laser.astype(np.float32)
        poses = simulation.poses[robots]
        row = (poses, seen.odometry, laser, seen.speed, seen.steering, actions)
        self._steps.append((robots, row))

    def trajectory(self, world: str, seed: int, robot: int) -> Trajectory:
        """The trajectory of one robot."""
        rows = []
        for robots, row in self._steps:
            place = np.searchsorted(robots, robot)
            if place == len(robots) or robots[place] != robot:
                break  # a robot that is done does not move again
            rows.append([column[place] for column in row])
        columns = (np.array(column) for column in zip(*rows, strict=True))
        poses, odometry, laser, speed, steering, actions = columns
        timestamps = np.arange(len(rows), dtype=float) * STEP
        return Trajectory(world, seed, poses, odometry, laser, speed, steering, actions, timestamps)


def check_recipe(world: str, scene: Scene, seed: int, odometry_noise: OdometryNoise | None) -> None:
    """Check what every recording needs.

    Raises:
        InputError: naming what is wrong.
    """
    instance("world", world, str)
    instance("scene", scene, Scene)
    whole("seed", seed, least=0)
    if odometry_noise is not None:
        with_methods("odometry_noise", odometry_noise, "measure")
