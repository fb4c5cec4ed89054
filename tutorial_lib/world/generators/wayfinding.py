"""Signs that lead: accents on the walls whose colour follows the distance along the corridors."""

import colorsys
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import KDTree

from tutorial_lib.geometry import Array
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.generators.layout import FRAME
from tutorial_lib.world.materials import PERIOD, Colour, Material, Stripe
from tutorial_lib.world.occupancy import clearance_grid

WIDTH, PITCH = 0.35, 0.8
"""Metres of an accent, and from one to the next."""
FRONT = 0.3
"""Metres in front of a wall at which the distance of an accent is taken."""
SPAN = (0.5, 0.8)
"""Shares of the circle of hues that the accents of one world run through."""
SHADES = {"standard": (0.85, 0.95), "shifted": (0.45, 0.60)}
"""Saturation and value of the accents: they take any hue, so duller ones are never trained on."""
PASSABLE = ("hallway", "open")
"""Kinds of room in which distance goes on; any other has that of its nearest door all over."""
_RESOLUTION = 0.1
_FIT = 0.1  # metres of clearance on the paths along which distance is measured
_THINNEST = 0.02  # metres of an accent at the end of a wall


def with_signs(plan: FloorPlan, rng: np.random.Generator) -> FloorPlan:
    """The same plan with accents that tell how far along the building's longest path a place is.

    Args:
        plan: in colour.
        rng: draws the range of hues, anew for each world.
    """
    start, sign = rng.random(), rng.choice([-1.0, 1.0])
    span, shade = sign * rng.uniform(*SPAN), SHADES[plan.look.palette]

    def colour(depth: float) -> Colour:
        red, green, blue = colorsys.hsv_to_rgb((start + span * depth) % 1.0, *shade)
        return round(255 * red), round(255 * green), round(255 * blue)

    accents = _accents(plan)
    depth_of = Depth(plan)
    depths = depth_of.by_room(accents.points)
    stripes: dict[str, list[Stripe]] = {}
    for name, low, high, depth in zip(
        accents.materials, accents.low, accents.high, depths, strict=True
    ):
        stripe = Stripe(round(low, 3), min(round(high, 3), PERIOD), colour(depth))
        stripes.setdefault(name, []).append(stripe)
    materials = [
        replace(material, stripes=(*material.stripes, *stripes.get(material.name, ())))
        for material in plan.materials
    ]
    posts = [i for i, name in enumerate(plan.wall_materials) if name == FRAME]
    names = list(plan.wall_materials)
    middles = plan.walls[posts].reshape(-1, 2, 2).mean(axis=1)
    for i, depth in zip(posts, depth_of.at(middles), strict=True):
        names[i] = f"{FRAME} {i}"
        materials.append(Material(names[i], colour(depth)))
    return replace(plan, materials=tuple(materials), wall_materials=tuple(names))


class Depth:
    """Where a place is along the longest path through a building: 0 at one end, 1 at the other."""

    def __init__(self, plan: FloorPlan) -> None:
        """Find the longest of the shortest paths between hallways, by two sweeps."""
        grid = clearance_grid(plan, _RESOLUTION)
        rows, columns = np.nonzero(grid.clearance >= _FIT)
        self._plan, self._points = plan, grid.centres(np.stack([rows, columns], axis=1))
        self._tree = KDTree(self._points)
        number = np.full(np.add(grid.clearance.shape, 1), -1)
        number[rows, columns] = np.arange(len(rows))
        graph = _graph(number)
        ends = self._hallways()
        distance = dijkstra(graph, indices=int(ends[0]), directed=False)
        for _ in range(2):
            reached = ends[np.isfinite(distance[ends])]
            root = int(reached[distance[reached].argmax()])
            distance = dijkstra(graph, indices=root, directed=False)
        distance[~np.isfinite(distance)] = 0.0
        self._depth = distance / distance.max()

    def at(self, points: Array) -> Array:
        """Depths (N,) of the floor nearest to points (N, 2)."""
        return self._depth[self._tree.query(points)[1]]

    def by_room(self, points: Array) -> Array:
        """Depths (N,) as the accents show them: all over a room that of its nearest door."""
        depths = self.at(points)
        for number, room in enumerate(self._plan.rooms):
            doors = [d for d in self._plan.doors if number in d.rooms]
            if room.kind not in PASSABLE and doors:
                middles = np.array([np.add(door.start, door.end) / 2 for door in doors])
                depths[room.contains(points)] = self.at(middles).min()
        return depths

    def _hallways(self) -> NDArray[np.intp]:
        """Indices of the points in hallways; of all where there is none."""
        halls = [room for room in self._plan.rooms if room.kind == "hallway"]
        inside = np.any([room.contains(self._points) for room in halls], axis=0)
        return np.flatnonzero(inside) if halls else np.arange(len(self._points))


@dataclass(frozen=True, eq=False)
class _Accents:
    """All accents: their materials, metres along those, and the floor (N, 2) in front of them."""

    materials: list[str]
    low: Array
    high: Array
    points: Array


def _accents(plan: FloorPlan) -> _Accents:
    """One accent in every `PITCH` metres of strip."""
    run = plan.walls[:, 2:] - plan.walls[:, :2]
    length = np.linalg.norm(run, axis=1)
    ahead = run / length[:, None]
    begin, end = plan.wall_offsets, np.minimum(plan.wall_offsets + length, PERIOD)
    first = np.floor(begin / PITCH).astype(int)
    count = np.ceil(end / PITCH).astype(int) - first
    wall = np.repeat(np.arange(len(run)), np.maximum(count, 0))
    place = np.arange(len(wall)) - np.repeat(np.cumsum(count) - count, count) + first[wall]
    low = np.maximum(place * PITCH, begin[wall])
    high = np.minimum(place * PITCH + WIDTH, end[wall])
    seen = (high - low > _THINNEST) & [plan.wall_materials[i] != FRAME for i in wall]
    wall, low, high = wall[seen], low[seen], high[seen]
    along = ((low + high) / 2 - begin[wall])[:, None] * ahead[wall]
    left = np.stack([-ahead[wall, 1], ahead[wall, 0]], axis=1)
    points = plan.walls[wall, :2] + along + FRONT * left
    return _Accents([plan.wall_materials[i] for i in wall], low, high, points)


def _graph(number: NDArray[np.intp]) -> csr_array:
    """Metres between neighbouring cells; `number` (H + 1, W + 1) is -1 where none is free."""
    starts, ends, metres = [], [], []
    for rows, columns in ((0, 1), (1, 0), (1, 1), (1, -1)):
        here, there = number, np.roll(number, (-rows, -columns), axis=(0, 1))
        both = (here >= 0) & (there >= 0)
        starts.append(here[both])
        ends.append(there[both])
        metres.append(np.full(both.sum(), _RESOLUTION * np.hypot(rows, columns)))
    size = number.max() + 1
    parts = (np.concatenate(starts), np.concatenate(ends))
    return csr_array((np.concatenate(metres), parts), shape=(size, size))
