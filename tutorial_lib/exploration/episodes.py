"""Episodes of image-goal navigation: a start, a goal, and how far apart they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.validation import floats, instance, instances, listed, one_of, whole
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.generators import SIGNS
from tutorial_lib.world.importers import import_map
from tutorial_lib.world.occupancy import check_closed
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.worlds import scene_of, world_name

DIFFICULTIES = {"easy": (1.5, 3.0), "medium": (3.0, 5.0), "hard": (5.0, 10.0)}
"""Geodesic metres from start to goal (Chaplot et al. 2020, 5)."""
SUCCESS = 1.0
"""Metres from the goal, in a straight line, within which `stop` succeeds."""
SEQUENTIAL = (1.5, 5.0)
"""Metres from each of several goals to the next (section 6.1)."""
FAMILIES = ("apartment", "office")
"""Of the worlds, by seed."""
_MOST = 1_000_000  # episodes
_GOALS = 12  # drawn for one episode, before giving up
_KEPT = 16  # goals, to which the distances of all places are kept


@dataclass(frozen=True, eq=False)
class Episodes:
    """N episodes, in one world or several.

    Attributes:
        worlds: (N,) names of the worlds, see `world.worlds`.
        starts: (N, 3) poses.
        goals: (N, 3) poses from which the goals' pictures are taken.
        shortest: (N,) geodesic metres from start to goal.
        difficulty: (N,) keys of `DIFFICULTIES`, or "" for none of them.

    Raises:
        InputError: when there is none, or not as many of all.
    """

    worlds: tuple[str, ...]
    starts: Array
    goals: Array
    shortest: Array
    difficulty: tuple[str, ...]

    def __post_init__(self) -> None:
        instances("worlds", self.worlds, str)
        floats("starts", self.starts, ("N", 3))
        floats("goals", self.goals, ("N", 3))
        floats("shortest", self.shortest, ("N",), least=0.0, infinite=True)
        for name in dict.fromkeys(instances("difficulty", self.difficulty, str)):
            one_of("difficulty", name, (*DIFFICULTIES, ""))
        counts = {len(column) for column in vars(self).values()}
        if len(counts) != 1 or counts == {0}:
            lengths = ", ".join(f"{name}: {len(rows)}" for name, rows in vars(self).items())
            raise InputError(f"episodes: {lengths}; give as many of all, one at least")

    def __len__(self) -> int:
        return len(self.worlds)

    def __getitem__(self, index: NDArray[np.intp] | slice) -> Episodes:
        """The episodes that a slice or indices select."""
        rows = np.arange(len(self))[index]
        return Episodes(
            tuple(self.worlds[row] for row in rows),
            self.starts[rows],
            self.goals[rows],
            self.shortest[rows],
            tuple(self.difficulty[row] for row in rows),
        )

    @classmethod
    def joined(cls, parts: Sequence[Episodes]) -> Episodes:
        """All episodes of the parts, in their order."""
        parts = instances("parts", parts, Episodes, empty=False)
        return cls(
            sum((part.worlds for part in parts), ()),
            np.concatenate([part.starts for part in parts]),
            np.concatenate([part.goals for part in parts]),
            np.concatenate([part.shortest for part in parts]),
            sum((part.difficulty for part in parts), ()),
        )


def exploration_world(seed: int, signs: str = "plain", palette: str = "standard") -> str:
    """The world of that seed for exploration, with or without signs.

    Raises:
        InputError: for an unknown kind of signs or palette.

    >>> exploration_world(20_001, "wayfinding")
    'office/20001/standard/wayfinding'
    """
    one_of("signs", signs, SIGNS)
    whole("seed", seed, least=0)
    return world_name(FAMILIES[seed % len(FAMILIES)], seed, palette, signs=signs)


def draw_episodes(
    world: str, scene: Scene, counts: dict[str, int], rng: np.random.Generator
) -> Episodes:
    """Random episodes of each difficulty in one world.

    Args:
        world: its name.
        scene: the world.
        counts: how many of each of `DIFFICULTIES`.
        rng: draws them.

    Raises:
        InputError: when no episode is asked for, or the world is too small for a difficulty.
    """
    instance("world", world, str)
    _check_drawn(scene, rng)
    for difficulty, count in instance("counts", counts, dict).items():
        whole(f"counts: {difficulty}", count, least=0, most=_MOST)
    if not sum(counts.values()):
        raise InputError(f"episodes: counts {counts}; ask for at least one")
    return EpisodeSource(world, scene).draw(counts, rng)


def draw_sequence(
    scene: Scene,
    goals: Array,
    count: int,
    rng: np.random.Generator,
    metres: tuple[float, float] = SEQUENTIAL,
) -> Array:
    """Sequential goals (count, N, 3): the first are given, each other lies near the one before.

    Args:
        scene: the world of all.
        goals: (N, 3) the first ones.
        count: of goals for each robot, the first included.
        rng: draws the others.
        metres: geodesic, from and up to which a goal is away from the one before.

    Raises:
        InputError: when there is no such place.
    """
    _check_drawn(scene, rng)
    goals = floats("goals", goals, ("N", 3), empty=False)
    whole("count", count, least=1, most=_MOST)
    low, high = floats("metres", metres, (2,), least=0.0).tolist()
    if not low < high:
        raise InputError(f"metres: {low:g} to {high:g}; give the lower first")
    source, bounds, chain = EpisodeSource("", scene), (low, high), [goals]
    for _ in range(count - 1):
        chain.append(np.array([source.near(goal, bounds, rng) for goal in chain[-1]]))
    return np.stack(chain)


def _check_drawn(scene: Scene, rng: np.random.Generator) -> None:
    instance("scene", scene, Scene)
    instance("rng", rng, np.random.Generator)


class EpisodeSource:
    """Draws episodes in one world, of which it knows all places where a robot can be.

    Attributes:
        paths: the grid of these places.
    """

    def __init__(self, world: str, scene: Scene) -> None:
        """Look for the places of `scene`, whose name is `world`."""
        self._world, self.paths = world, GridPaths(scene.clearance)
        self._points = self.paths.points[self.paths.largest]
        self._metres: dict[tuple[float, float], Array] = {}

    def draw(self, counts: dict[str, int], rng: np.random.Generator, starts: int = 1) -> Episodes:
        """Episodes of each difficulty, unchecked; see `draw_episodes`.

        Args:
            counts: goals of each difficulty.
            rng: draws them.
            starts: episodes towards each goal; the distances to a goal take longest.
        """
        parts = [
            self._to_a_goal(name, rng, starts)
            for name, count in counts.items()
            for _ in range(count)
        ]
        places, goals, metres = (np.concatenate(column) for column in zip(*parts, strict=True))
        names = tuple(name for name, count in counts.items() for _ in range(count * starts))
        return Episodes((self._world,) * len(goals), places, goals, metres, names)

    def near(self, goal: Array, bounds: tuple[float, float], rng: np.random.Generator) -> Array:
        """A pose (3,) so many metres from another one."""
        found = self._around(goal, bounds, rng, 1)
        if found is None:
            raise InputError("goals: no place is that far from the one before; take another world")
        return found[0][0]

    def metres_to(self, x: float, y: float) -> Array:
        """Geodesic metres (K,) from each node of `paths` to a goal; those of the last are kept."""
        if (x, y) not in self._metres:
            if len(self._metres) == _KEPT:
                del self._metres[next(iter(self._metres))]
            self._metres[x, y] = self.paths.metres_to([x, y])[0]
        return self._metres[x, y]

    def _to_a_goal(
        self, difficulty: str, rng: np.random.Generator, count: int
    ) -> tuple[Array, Array, Array]:
        """Starts (C, 3), a goal as often, and the metres (C,) between them."""
        check_known("difficulty", difficulty, tuple(DIFFICULTIES))
        for _ in range(_GOALS):
            goal = self._pose(self._points[rng.integers(len(self._points))], rng)
            found = self._around(goal, DIFFICULTIES[difficulty], rng, count)
            if found is not None:
                return found[0], np.repeat(goal[None], count, axis=0), found[1]
        raise InputError(f"episodes: no {difficulty} one fits into this world; take a larger one")

    def _around(
        self, goal: Array, bounds: tuple[float, float], rng: np.random.Generator, count: int
    ) -> tuple[Array, Array] | None:
        """Poses (C, 3) so many metres from a goal, and how many (C,); None where there is none."""
        metres = self.metres_to(*goal[:2].tolist())[self.paths.largest]
        near = np.flatnonzero((metres >= bounds[0]) & (metres < bounds[1]))
        # A path of 1.5 m around a corner may end nearer than `SUCCESS`: stop would succeed at once.
        near = near[np.linalg.norm(self._points[near] - goal[:2], axis=1) >= SUCCESS]
        if not len(near):
            return None
        chosen = [near[rng.integers(len(near))] for _ in range(count)]
        poses = np.array([self._pose(self._points[place], rng) for place in chosen])
        return poses, metres[chosen]

    def _pose(self, point: Array, rng: np.random.Generator) -> Array:
        """A pose at a place, with a random heading: a round body fits with any."""
        return np.array([*point, rng.uniform(-np.pi, np.pi)])


class DrawnEpisodes:
    """Draws episodes; each world's places are looked for once.

    Attributes:
        sources: of the worlds in which episodes were drawn, by name.
    """

    def __init__(
        self,
        worlds: Sequence[int] | None,
        plan: str | Path | FloorPlan | None,
        signs: str,
        difficulty: str,
    ) -> None:
        """Choose worlds and difficulty; see `environment.ImageGoalNavigation`."""
        check_known("signs", signs, SIGNS)
        check_known("difficulty", difficulty, tuple(DIFFICULTIES))
        if plan is not None and (worlds is not None or signs != "plain"):
            raise InputError(
                "plan: it is the only world and has no signs; leave worlds and signs out"
            )
        self._plan = None if plan is None else Scene(_floor_plan(plan))
        self._worlds = _seeds(range(100) if worlds is None else worlds)
        self._signs, self._difficulty = signs, difficulty
        self._scenes: dict[str, Scene] = {}
        self.sources: dict[str, EpisodeSource] = {}

    def draw(
        self, options: dict[str, Any] | None, rng: np.random.Generator, starts: int = 1
    ) -> tuple[str, Scene, Episodes]:
        """The name of a world, the world, and an episode in it, or several to one goal."""
        worlds, difficulty = self._chosen({} if options is None else options)
        world = "plan"
        if self._plan is None:
            world = exploration_world(int(rng.choice(worlds)), self._signs)
        if world not in self.sources:
            self._scenes[world] = scene_of(world) if self._plan is None else self._plan
            self.sources[world] = EpisodeSource(world, self._scenes[world])
        return world, self._scenes[world], self.sources[world].draw({difficulty: 1}, rng, starts)

    def _chosen(self, options: dict[str, Any]) -> tuple[tuple[int, ...], str]:
        """Worlds and difficulty of the next episode."""
        known = ("difficulty", "world") if self._plan is None else ("difficulty",)
        for name in instance("options", options, dict):
            check_known("options", name, known)
        difficulty = options.get("difficulty", self._difficulty)
        check_known("options: difficulty", difficulty, tuple(DIFFICULTIES))
        if "world" not in options:
            return self._worlds, difficulty
        return (whole("options: world", options["world"], least=0),), difficulty


def check_known(what: str, value: object, known: tuple[object, ...]) -> None:
    """Check that a value is one of those that are known."""
    if not any(type(value) is type(one) and value == one for one in known):
        raise InputError(f"{what}: {value!r} is unknown; use one of {', '.join(map(str, known))}")


def _floor_plan(plan: str | Path | FloorPlan) -> FloorPlan:
    """A floor plan whose rooms are closed, from a file unless it is one."""
    if isinstance(plan, FloorPlan):
        check_closed(plan)
        return plan
    if not isinstance(plan, str | Path):
        raise InputError(
            f"plan: of type {type(plan).__name__}; give the name of a map's file or a FloorPlan"
        )
    return import_map(plan)


def _seeds(worlds: Sequence[int]) -> tuple[int, ...]:
    """Seeds of worlds, checked."""
    given = listed("worlds", worlds, "seeds of worlds")
    whole = [isinstance(seed, int | np.integer) and seed >= 0 for seed in given]
    if not given or not all(whole):
        raise InputError(f"worlds: {worlds!r}; give seeds, at least one, whole numbers from 0 on")
    return tuple(map(int, given))
