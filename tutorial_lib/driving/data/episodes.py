"""Episodes of local control: from beside a trajectory to a frame of it (Meng 2020, Table I)."""

from dataclasses import dataclass, replace
from itertools import combinations, pairwise, product

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.data.perturbation import PAPER_PERTURBATION, perturbed
from tutorial_lib.driving.data.recorded_world import BEHIND, MOST_PAIRS, RecordedWorld
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.driving.metrics import REACHED, time_limit
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.validation import flag, instance, number, whole
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.people import Person
from tutorial_lib.world.scene import Scene

RADIUS = 0.15
"""Metres, of an obstacle that is not in any recording."""
_FROM_START, _FROM_TARGET = 0.75, 0.6  # metres that an obstacle's middle keeps
_BESIDE, _CLEAR = 0.35, 0.25  # metres between an obstacle and the line past it: at it, anywhere
_AT_EASE = 0.3  # metres from start and target within which walls may be nearer
_TRIES = 60
_ROOMY = BicycleCar(length=0.52, width=0.34)  # a start has 5 cm to spare all around
_MOST_EACH = 10  # obstacles: they are passed on either side, which is two to the power of it
_SPARE = 8  # times as many pairs are drawn


@dataclass(frozen=True)
class Episodes:
    """Starts and targets in one world.

    Attributes:
        recorded: the trajectories they lie on.
        starts: (N, 3) poses.
        targets: (N,) frames to reach.
        ahead: (N,) metres of the trajectory between them, negative for a target behind.
        limit: (N,) seconds allowed.
    """

    recorded: RecordedWorld
    starts: Array
    targets: NDArray[np.intp]
    ahead: Array
    limit: Array

    def __len__(self) -> int:
        return len(self.starts)

    def subset(self, index: NDArray[np.intp]) -> "Episodes":
        """Those that an array of indices selects."""
        names = ("starts", "targets", "ahead", "limit")
        return replace(self, **{name: getattr(self, name)[index] for name in names})

    def within(self, recorded: RecordedWorld) -> "Episodes":
        """The same episodes in a world that looks different."""
        return replace(self, recorded=recorded)

    @property
    def goals(self) -> Array:
        """(N, 3) poses of the targets."""
        return self.recorded.poses[self.targets]


def draw_episodes(
    recorded: RecordedWorld,
    paths: GridPaths,
    count: int,
    rng: np.random.Generator,
    least: float = -BEHIND,
    fewer: bool = False,
) -> Episodes:
    """Targets from 1 m behind to 3 m ahead along a trajectory (Meng 2020, Table I).

    Starts are perturbed as in the authors' code. Three things that the paper leaves open: a start
    has 5 cm to spare all around, it is not yet within 0.3 m of its target, and the two images may
    have nothing in common.

    Args:
        recorded: trajectories of one world.
        paths: its geodesics.
        count: N episodes.
        rng: draws them.
        least: metres along the trajectory to the target, at least.
        fewer: whether less than `count` will do.

    Raises:
        InputError: when a world has too little room to start in.
    """
    instance("recorded", recorded, RecordedWorld)
    instance("paths", paths, GridPaths)
    instance("rng", rng, np.random.Generator)
    count, least = whole("count", count, least=0, most=MOST_PAIRS // _SPARE), number("least", least)
    fewer = flag("fewer", fewer)
    sources, targets = recorded.draw(_SPARE * count, 1, rng)
    ahead = recorded.arc[targets] - recorded.arc[sources]
    sources, targets = sources[ahead >= least], targets[ahead >= least]
    starts, found = perturbed(
        recorded.scene, recorded.poses[sources], PAPER_PERTURBATION, rng, _ROOMY
    )
    # A pose that already is at its target shows nothing.
    gap = np.linalg.norm(starts[:, :2] - recorded.poses[targets, :2], axis=1)
    good = np.flatnonzero(found & (gap >= REACHED))[: count + count // 10 + 5]
    geodesic = paths.between(starts[good, :2], recorded.poses[targets[good], :2])
    kept = np.isfinite(geodesic)
    good, geodesic = good[kept][:count], geodesic[kept][:count]
    if len(good) < count and not fewer:
        raise InputError(f"count: only {len(good)} of {count} episodes fit; give a larger world")
    ahead = (recorded.arc[targets] - recorded.arc[sources])[good]
    return Episodes(recorded, starts[good], targets[good], ahead, time_limit(geodesic))


def with_obstacles(
    episodes: Episodes, each: int, count: int, rng: np.random.Generator
) -> tuple[Episodes, list[Person]]:
    """The first `count` of those episodes that have room for `each` obstacles in between.

    An obstacle stands within 0.3 m of the straight line between start and target, with a passage on
    one side at least.

    Returns:
        The episodes, fewer where there are not so many, and their obstacles, which exist for the
        robot of that episode only.
    """
    instance("episodes", episodes, Episodes)
    instance("rng", rng, np.random.Generator)
    each, count = whole("each", each, least=1, most=_MOST_EACH), whole("count", count, least=0)
    chosen, obstacles = [], []
    for index, (start, goal) in enumerate(zip(episodes.starts, episodes.goals, strict=True)):
        places = _places(episodes.recorded, start[:2], goal[:2], each, rng)
        if len(places) == each and len(chosen) < count:
            obstacles += [Person([place], radius=RADIUS, owner=len(chosen)) for place in places]
            chosen.append(index)
    return episodes.subset(np.array(chosen, dtype=np.intp)), obstacles


def _places(
    recorded: RecordedWorld, start: Array, goal: Array, each: int, rng: np.random.Generator
) -> list[Array]:
    """Where obstacles can stand between two points so that a car gets past; none without room."""
    if np.linalg.norm(goal - start) < _FROM_START + _FROM_TARGET:
        return []
    for _ in range(_TRIES):
        places = [_near_the_line(start, goal, rng) for _ in range(each)]
        apart = np.linalg.norm(np.array(places)[:, None] - [start, goal], axis=2)
        kept = (apart >= [_FROM_START, _FROM_TARGET]).all()
        kept = kept and all(np.linalg.norm(a - b) >= 2 * RADIUS for a, b in combinations(places, 2))
        if kept and _can_be_passed(recorded.scene, start, goal, places):
            return places
    return []


def _near_the_line(start: Array, goal: Array, rng: np.random.Generator) -> Array:
    """A point within 0.3 m of the straight line between two points."""
    along = goal - start
    aside = np.array([-along[1], along[0]]) / max(float(np.linalg.norm(along)), 1e-9)
    return start + rng.uniform(0.0, 1.0) * along + rng.uniform(-0.3, 0.3) * aside


def _can_be_passed(scene: Scene, start: Array, goal: Array, places: list[Array]) -> bool:
    """Whether a bent line leads past all obstacles, on either side, with room for a car."""
    along = (goal - start) / np.linalg.norm(goal - start)
    aside = (RADIUS + _BESIDE) * np.array([-along[1], along[0]])
    in_order = sorted(places, key=lambda place: float(along @ place))
    for sides in product((1.0, -1.0), repeat=len(places)):
        beside = [place + side * aside for place, side in zip(in_order, sides, strict=True)]
        line = _sampled(np.array([start, *beside, goal]))
        ends = np.linalg.norm(line[:, None] - [start, goal], axis=2).min(axis=1)
        gap = np.linalg.norm(line[:, None] - in_order, axis=2).min(axis=1) - RADIUS
        gap = np.minimum(gap, scene.clearance.at(line))
        if (gap[ends > _AT_EASE] >= _CLEAR).all():
            return True
    return False


def _sampled(corners: Array) -> Array:
    """Points (P, 2) about every 5 cm of a line through `corners` (C, 2)."""
    parts = [np.linspace(a, b, 2 + int(np.linalg.norm(b - a) / 0.05)) for a, b in pairwise(corners)]
    return np.concatenate(parts)
