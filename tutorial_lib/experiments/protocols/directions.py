"""Which direction leads to a goal: decisions at places of a world, with perfect perception."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.exploration.episodes import DIFFICULTIES
from tutorial_lib.exploration.labels import NO_ROOM, direction_ends, room_kinds
from tutorial_lib.geometry import Array
from tutorial_lib.learning.exploration_data import SHORTEST
from tutorial_lib.world.generators.wayfinding import Depth
from tutorial_lib.world.scene import Scene

_PLACES, _GOALS = 150, 24


@dataclass(frozen=True, eq=False)
class Decisions:
    """Directions to choose from, D in all, a row each; those of one decision in a row.

    Attributes:
        number: (D,) of the decision, rising.
        difficulty: (D,) index in `DIFFICULTIES`.
        metres: (D,) geodesic metres from the direction's end to the goal.
        here: (D, F) what a perfect observer knows of the place and the direction.
        goal: (D, F') what the goal's picture adds to that.
    """

    number: NDArray[np.intp]
    difficulty: NDArray[np.intp]
    metres: Array
    here: Array
    goal: Array


def decisions(scene: Scene, rng: np.random.Generator, *, signs: bool) -> Decisions:
    """Decisions at random places of a world, towards random goals of every difficulty.

    A direction is described by how far it is traversable within the local map, and by the kind of
    room and the clearance here and at its end; the goal by its kind of room, and whether it is that
    of the end. Where there are signs, their depth (see `wayfinding.Depth`) is read here, at the end
    and at the goal. Since one of the directions is chosen, its free metres, what is read at its
    end, and how that differs from the goal are also compared with their means over the directions.

    Args:
        scene: the world.
        rng: draws places, headings and goals.
        signs: whether signs can be read.
    """
    paths = GridPaths(scene.clearance)
    nodes = np.flatnonzero(paths.largest)
    places = paths.points[rng.choice(nodes, _PLACES)]
    goals = paths.points[rng.choice(nodes, _GOALS)]
    headings = rng.uniform(0.0, 2 * np.pi, len(places))
    ends, long = direction_ends(scene, np.column_stack([places, headings]))
    fields = paths.fields(goals, shortest=True)
    reading = _Reading(scene, signs)
    from_here, at_end = reading.of(places), reading.of(ends.reshape(-1, 2))
    at_goal = reading.of(goals)
    at_end = at_end.reshape(*ends.shape[:2], -1)
    parts, number = [], 0
    for goal in range(_GOALS):
        far = fields.distance(places, goal)
        metres = fields.distance(ends.reshape(-1, 2), goal).reshape(long.shape)
        possible = (long >= SHORTEST) & np.isfinite(metres)
        for level, (least, most) in enumerate(DIFFICULTIES.values()):
            for place in np.flatnonzero((far >= least) & (far < most) & (possible.sum(1) > 1)):
                rows = np.flatnonzero(possible[place])
                known = _known(from_here[place], at_end[place, rows], at_goal[goal])
                free = long[place, rows]
                here = np.column_stack([free, _beyond_mean(free), known[0]])
                parts.append((np.full(len(rows), level), metres[place, rows], here, known[1]))
                number += 1
    counts = [len(part[0]) for part in parts]
    columns = (np.concatenate(column) for column in zip(*parts, strict=True))
    return Decisions(np.repeat(np.arange(number), counts), *columns)


def _known(here: Array, ends: Array, goal: Array) -> tuple[Array, Array]:
    """What is read here (F,) and at D ends (D, F), and what the goal (F,) adds; D rows each."""
    here, goal = np.broadcast_to(here, ends.shape), np.broadcast_to(goal, ends.shape)
    from_end, from_here = np.abs(ends - goal), np.abs(here - goal)
    added = [goal, from_end, from_here, from_end - from_here, _beyond_mean(from_end)]
    return np.column_stack([here, ends, ends - here, _beyond_mean(ends)]), np.column_stack(added)


def _beyond_mean(values: Array) -> Array:
    """How far values (D, ...) of a decision's directions are from their mean."""
    return values - values.mean(axis=0)


def regret_of(scores: Array, metres: Array) -> Array:
    """Metres (N,) by which the direction of the highest score is longer than the best.

    Args:
        scores: (N, K) of K directions.
        metres: (N, K) to the goal, infinite for a direction that is none.
    """
    chosen = np.where(np.isfinite(metres), scores, -np.inf).argmax(axis=1)
    return metres[np.arange(len(metres)), chosen] - metres.min(axis=1)


def regret_in(found: Decisions, scores: Array) -> tuple[NDArray[np.intp], Array]:
    """For each decision its difficulty, and its regret in metres, see `regret_of`.

    Args:
        found: the decisions.
        scores: (D,) of every direction.
    """
    first, counts = np.unique(found.number, return_index=True, return_counts=True)[1:]
    row = np.repeat(np.arange(len(first)), counts)
    column = np.arange(len(row)) - first[row]
    shape = (len(first), counts.max(initial=1))
    likings, metres = np.full(shape, -np.inf), np.full(shape, np.inf)
    likings[row, column], metres[row, column] = scores, found.metres
    return found.difficulty[first], regret_of(likings, metres)


class _Reading:
    """What can be read at a place: its kind of room as flags, clearance, depth by the signs."""

    def __init__(self, scene: Scene, signs: bool) -> None:
        self._scene, self._depth = scene, Depth(scene.plan) if signs else None

    def of(self, points: Array) -> Array:
        """(N, F) numbers for points (N, 2)."""
        kinds = room_kinds(self._scene.plan, points)
        flags = (kinds[:, None] == np.arange(NO_ROOM + 1)).astype(float)
        clearance = self._scene.clearance.at(points)
        depth = np.zeros(len(points)) if self._depth is None else self._depth.by_room(points)
        return np.column_stack([flags, clearance, depth])
