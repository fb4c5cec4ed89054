"""Table II's task: buildings with places, trajectories between them, and trials."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import permutations
from pathlib import Path
from typing import TypeGuard

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.data.demonstrations import SHORTEST, demonstrate_between
from tutorial_lib.driving.data.perturbation import PAPER_PERTURBATION, Perturbation, perturbed
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.trajectories import Trajectory
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.protocols.odometry import RECORDING, USUAL, Odometry
from tutorial_lib.geometry import Array
from tutorial_lib.validation import flag, floats, instance, integers, whole
from tutorial_lib.world.bodies import BicycleCar, Body
from tutorial_lib.world.importers import Region, import_map
from tutorial_lib.world.placing import is_free
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera
from tutorial_lib.world.worlds import map_world, scene_of

WORLDS = tuple(range(20_000, 20_005))
"""Of Table II and what belongs to it."""
CAR = BicycleCar()
"""The robot, unless it is another."""
PLACES = 10
"""Joined pairwise by 90 trajectories (Meng 2020, IV-C)."""
ROOMY = 0.45
"""Metres of clearance that a place has."""
ANYWHERE_PERTURBATION = Perturbation(wide=1.0, wide_turn=float(np.deg2rad(60.0)))
"""Of starts on a trajectory that do not look along it."""
_MANY = 10_000  # places, or trials, that a building may have
_FAR = 3.0  # metres from a start to its goal at least
_SPARE, _SPARE_ANYWHERE = 1.1, 1.5  # times as many trials are drawn, since some have no room
_LOOK = 1.0  # metres of the path along which a car's first heading points
_TURNS = np.array([0.0, 0.4, -0.4, 0.8, -0.8, 1.2, -1.2, np.pi])


@dataclass(frozen=True, eq=False)
class Building:
    """A world with places that recorded trajectories join pairwise.

    Attributes:
        name: of the world.
        scene: the world.
        paths: its geodesics.
        places: (P, 2) metres.
        recorded: the trajectories, one for each pair.
        pairs: (D, 2) the places that each trajectory joins.
        odometry: of the robots that record trajectories and navigate in it.
        body: likewise.
        camera: likewise; with any the drives are the same, and `view_of` knows it.
    """

    name: str
    scene: Scene
    paths: GridPaths
    places: Array
    recorded: RecordedWorld
    pairs: NDArray[np.intp]
    odometry: Odometry = USUAL
    body: Body = CAR
    camera: Camera = field(default_factory=Camera)


@dataclass(frozen=True, eq=False)
class Trials:
    """Starts and goal images of navigation; none of them is on the map.

    For each trial an oracle drove from the same start to the same place in `seconds`; the goal
    image was taken where it arrived.

    Attributes:
        pairs: (N, 2) places at either end.
        starts: (N, 3) poses, perturbed.
        recorded: the oracle's trajectories.
        goals: (N,) frames of those.
        seconds: (N,) that the oracle took.
    """

    pairs: NDArray[np.intp]
    starts: Array
    recorded: RecordedWorld
    goals: NDArray[np.intp]
    seconds: Array

    def __len__(self) -> int:
        return len(self.starts)

    def subset(self, indices: NDArray[np.intp]) -> Trials:
        """The trials of those indices (M,)."""
        indices = integers("indices", indices, ("M",), least=0, most=len(self) - 1)
        pairs, starts, recorded = self.pairs[indices], self.starts[indices], self.recorded
        return Trials(pairs, starts, recorded, self.goals[indices], self.seconds[indices])

    @property
    def goal_poses(self) -> Array:
        """(N, 3) poses at which the goal images were taken."""
        return self.recorded.poses[self.goals]


def make_building(
    place: int | Path,
    seed: int,
    count: int = PLACES,
    palette: str = "standard",
    *,
    drifts: bool = True,
    family: str = "",
    region: Region | None = None,
    body: Body = CAR,
) -> Building:
    """Choose places that cover a world, and record a trajectory for each ordered pair of them.

    Args:
        place: seed of a large generated world, or a map's file.
        seed: of everything that is random.
        count: places.
        palette: of a generated world.
        drifts: whether the robots' odometry does.
        family: of a generated world; that of its seed unless given.
        region: of a map, see `import_map`.
        body: of the robots that record trajectories and navigate.

    Raises:
        InputError: when the world is too small for so many places.
    """
    generated = not isinstance(place, Path)
    if generated:
        whole("place", place, least=0)
    seed, count = whole("seed", seed, least=0), whole("count", count, least=2, most=_MANY)
    drifts = flag("drifts", drifts)
    name = map_world(place, palette, family) if generated else place.name
    scene = scene_of(name) if generated else Scene(import_map(place, seed=seed, region=region))
    seeds = (seed, place if generated else 0)
    rng, odometry = np.random.default_rng(seeds), Odometry(drifts, seeds)
    return explored(name, scene, rng, count, odometry, body)


def explored(
    name: str,
    scene: Scene,
    rng: np.random.Generator,
    count: int = PLACES,
    odometry: Odometry = USUAL,
    body: Body = CAR,
) -> Building:
    """Choose places that cover a scene, and record a trajectory for each ordered pair of them.

    Raises:
        InputError: when the world is too small for so many places.
    """
    paths = GridPaths(scene.clearance)
    return recorded_between(name, scene, paths, spread_places(paths, count, rng), odometry, body)


def recorded_between(
    name: str,
    scene: Scene,
    paths: GridPaths,
    places: Array,
    odometry: Odometry = USUAL,
    body: Body = CAR,
) -> Building:
    """Record a trajectory for each ordered pair of places (P, 2).

    Raises:
        InputError: when there is none between any two.
    """
    count = len(places)
    pairs = np.array(list(permutations(range(count), 2)))
    starts = facing(scene, paths, places, pairs, body)
    goals, noise = places[pairs[:, 1]], odometry.noise(RECORDING)
    trajectories = demonstrate_between(name, scene, paths, starts, goals, 0, noise, body)
    kept = {i: one for i, one in enumerate(trajectories) if long_enough(one)}
    if not kept:
        raise InputError(
            f"{name}: no trajectory between any two of {count} places; give a larger map"
        )
    recorded = RecordedWorld(scene, list(kept.values()))
    return Building(name, scene, paths, places, recorded, pairs[list(kept)], odometry, body)


def draw_trials(
    building: Building,
    count: int,
    rng: np.random.Generator,
    among: NDArray[np.intp] | None = None,
) -> Trials:
    """Draw trials between the places of a building; pairs come equally often.

    A trial starts where the recorded trajectory of its pair did, perturbed as in Table I. `among`
    holds the numbers of the pairs to draw from, all unless given; other numbers are refused.
    """
    known = len(instance("building", building, Building).pairs)
    count = whole("count", count, least=1, most=_MANY)
    instance("rng", rng, np.random.Generator)
    among = np.arange(known) if among is None else among
    among = integers("among", among, ("M",), least=0, most=known - 1, empty=False)
    which = np.resize(rng.permutation(among), round(_SPARE * count) + 1)
    first = building.recorded.first_frames[which]
    starts, found = perturbed(
        building.scene, building.recorded.poses[first], PAPER_PERTURBATION, rng, building.body
    )
    return _shown(building, starts[found], building.pairs[which[found]], count)


def trials_from_anywhere(building: Building, count: int, rng: np.random.Generator) -> Trials:
    """Draw trials from anywhere on the recorded trajectories to any of the places (Fig. 9).

    Many starts look far aside. The first place of their pair is that of the trajectory.
    """
    instance("building", building, Building)
    count = whole("count", count, least=1, most=_MANY)
    instance("rng", rng, np.random.Generator)
    size = round(_SPARE_ANYWHERE * count)
    frames = rng.integers(len(building.recorded.poses), size=size)
    starts, found = perturbed(
        building.scene, building.recorded.poses[frames], ANYWHERE_PERTURBATION, rng, building.body
    )
    which = np.searchsorted(building.recorded.first_frames, frames, side="right") - 1
    pairs = np.stack(
        [building.pairs[which, 0], rng.integers(len(building.places), size=len(frames))], 1
    )
    far = np.linalg.norm(starts[:, :2] - building.places[pairs[:, 1]], axis=1) > _FAR
    return _shown(building, starts[found & far], pairs[found & far], count)


def _shown(building: Building, starts: Array, pairs: NDArray[np.intp], count: int) -> Trials:
    """At most `count` trials, each with the image that an oracle took at its end."""
    places = building.places[pairs[:, 1]]
    where = building.name, building.scene, building.paths
    shown = demonstrate_between(*where, starts, places, 0, body=building.body)
    arrived = [(i, one) for i, one in enumerate(shown) if long_enough(one)][:count]
    kept, oracle = [i for i, _ in arrived], RecordedWorld(building.scene, [t for _, t in arrived])
    goals = np.unique(oracle.last)
    seconds = np.array([one.timestamps[-1] for one in oracle.trajectories])
    return Trials(pairs[kept], starts[kept], oracle, goals, seconds)


def spread_places(paths: GridPaths, count: int, rng: np.random.Generator) -> Array:
    """Roomy places (count, 2), each as far from the others as possible: they cover the world.

    Raises:
        InputError: when there are fewer.
    """
    instance("paths", paths, GridPaths)
    count = whole("count", count, least=1, most=_MANY)
    instance("rng", rng, np.random.Generator)
    for roomy in (ROOMY, 0.0):
        nodes = np.flatnonzero(paths.largest & (paths.clearance >= roomy))
        if len(nodes) < count:
            continue
        nearest, chosen = np.full(len(nodes), np.inf), [int(rng.integers(len(nodes)))]
        # The first is drawn only to find one that is far from it.
        for step in range(count + 1):
            field = paths.fields(paths.points[nodes[chosen[-1]]], shortest=True)
            far = field.cost[0, nodes]
            nearest = far if step <= 1 else np.minimum(nearest, far)
            chosen.append(int(nearest.argmax()))
        if nearest.max() > 0:
            return paths.points[nodes[chosen[1:-1]]]
    raise InputError(
        f"count: the world has no room for {count} places; give a larger one, or fewer"
    )


def facing(
    scene: Scene, paths: GridPaths, places: Array, pairs: NDArray[np.intp], body: Body = CAR
) -> Array:
    """Poses (D, 3) at the first place of each pair (D, 2) that look along the path to the other."""
    instance("scene", scene, Scene)
    places = floats("places", places, ("P", 2))
    name, last = f"pairs of {len(places)} places", len(places) - 1
    pairs = integers(name, pairs, ("D", 2), least=0, most=last)
    try:
        fields = instance("paths", paths, GridPaths).fields(places)
    except InputError as error:
        raise InputError(f"places, paths: {error}") from error
    poses = np.empty((len(pairs), 3))
    for i, (start, goal) in enumerate(pairs):
        path = fields.path(places[start], goal)
        far = np.linalg.norm(path - path[0], axis=1)
        ahead = path[min(int(np.searchsorted(far, _LOOK)), len(path) - 1)] - path[0]
        heading = np.arctan2(ahead[1], ahead[0])
        tried = np.column_stack([np.tile(path[0], (len(_TURNS), 1)), heading + _TURNS])
        poses[i] = tried[is_free(scene, body, tried).argmax()]
    return poses


def long_enough(trajectory: Trajectory | None) -> TypeGuard[Trajectory]:
    """Whether a trajectory arrived, and has enough frames for a context."""
    return trajectory is not None and len(trajectory) >= SHORTEST
