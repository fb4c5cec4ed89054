"""Mazes of corridors, with loops and a few wider places."""

from collections import Counter
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tutorial_lib.world.generators.drafts import Opening
from tutorial_lib.world.generators.layout import CORNER, Layout
from tutorial_lib.world.generators.rectilinear import DoesNotFit, Rect, tidy, trace

Cell = tuple[int, int]
"""Column and row in the maze."""
Passage = tuple[Cell, Cell]

ROOM_CELLS = 15
"""Least number of cells of a room; passages between rooms have a door."""
SMALLEST_ROOM = 5
"""Cells: a smaller rest belongs to the room beside it."""
LOOPS = 0.12
"""Share of the closed walls between two rooms, cell by cell, that get a door."""
CELLS_PER_PLAZA = 35
"""Cells for which one wider place is tried."""
WINDING = 0.8
"""Chance that a passage goes on from the newest cell, which makes long winding corridors."""


@dataclass(frozen=True)
class Grid:
    """The maze as a raster of uneven lines: wall, corridor, wall, corridor, ..., wall.

    Attributes:
        columns, rows: cells.
        corridor: its width, in metres.
        wall: its thickness, in metres.
    """

    columns: int
    rows: int
    corridor: float
    wall: float

    @cached_property
    def xs(self) -> list[float]:
        """Metres: the lines between columns of walls and of cells."""
        return self._lines(self.columns)

    @cached_property
    def ys(self) -> list[float]:
        """Metres: the lines between rows of walls and of cells."""
        return self._lines(self.rows)

    def _lines(self, count: int) -> list[float]:
        steps = [self.wall, self.corridor] * count + [self.wall]
        return [tidy(value) for value in np.cumsum([0.0, *steps])]

    def cells(self) -> list[Cell]:
        """All cells."""
        return [(column, row) for row in range(self.rows) for column in range(self.columns)]

    def passages(self) -> list[Passage]:
        """All pairs of cells side by side, the lower first."""
        return [
            ((c, r), (c + dc, r + dr))
            for c, r in self.cells()
            for dc, dr in ((1, 0), (0, 1))
            if c + dc < self.columns and r + dr < self.rows
        ]

    def gap(self, passage: Passage) -> Rect:
        """The whole of the wall between two cells, in metres."""
        (c, r), (c1, r1) = passage
        i, j = c + c1 + 1, r + r1 + 1
        return self.xs[i], self.ys[j], self.xs[i + 1], self.ys[j + 1]


def maze(rng: np.random.Generator, area: float) -> Layout:
    """Draw a maze of about `area` square metres.

    Raises:
        DoesNotFit: if this draw cannot be built.
    """
    layout = Layout(tidy(rng.choice([0.10, 0.12, 0.14])))
    corridor = tidy(rng.uniform(1.2, 1.7))
    cells = area / (corridor * (corridor + layout.thickness))
    columns = max(round(np.sqrt(cells * rng.uniform(0.5, 2.0))), 4)
    grid = Grid(columns, max(round(cells / columns), 4), corridor, layout.thickness)
    plaza = _plazas(rng, grid)
    tree = _tree(rng, grid, plaza)
    room = _rooms(rng, plaza, tree)
    _add_rooms(layout, grid, plaza, tree, room)
    for passage in grid.passages():
        one, two = (room[plaza[cell]] for cell in passage)
        if one != two and (passage in tree.values() or rng.random() < LOOPS):
            layout.openings.append(_door(rng, grid, passage, (one, two)))
    if len(layout.openings) < len(layout.rooms):
        raise DoesNotFit("a maze without a loop")
    return layout


def _plazas(rng: np.random.Generator, grid: Grid) -> dict[Cell, Cell]:
    """For each cell the first cell of the place it belongs to: itself, or a square of four."""
    plaza = {cell: cell for cell in grid.cells()}
    for _ in range(len(plaza) // CELLS_PER_PLAZA):
        c, r = int(rng.integers(grid.columns - 1)), int(rng.integers(grid.rows - 1))
        square = [(c, r), (c + 1, r), (c, r + 1), (c + 1, r + 1)]
        size = Counter(plaza.values())
        if all(size[plaza[cell]] == 1 for cell in square):
            plaza.update(dict.fromkeys(square, (c, r)))
    return plaza


def _tree(rng: np.random.Generator, grid: Grid, plaza: dict[Cell, Cell]) -> dict[Cell, Passage]:
    """A tree through all places: the passages into all but the first, in the order reached."""
    beside: dict[Cell, list[tuple[Cell, Passage]]] = {place: [] for place in plaza.values()}
    for passage in grid.passages():
        one, two = (plaza[cell] for cell in passage)
        if one != two:
            beside[one].append((two, passage))
            beside[two].append((one, passage))
    start = plaza[grid.columns // 2, grid.rows // 2]
    way_in: dict[Cell, Passage] = {}
    active, reached = [start], {start}
    while active:
        i = len(active) - 1 if rng.random() < WINDING else int(rng.integers(len(active)))
        fresh = [entry for entry in beside[active[i]] if entry[0] not in reached]
        if not fresh:
            active.pop(i)
            continue
        place, passage = fresh[rng.integers(len(fresh))]
        way_in[place] = passage
        reached.add(place)
        active.append(place)
    return way_in


def _rooms(
    rng: np.random.Generator, plaza: dict[Cell, Cell], tree: dict[Cell, Passage]
) -> dict[Cell, int]:
    """Cut the tree into rooms: for each place the index of its room."""
    parent = {
        place: next(plaza[cell] for cell in passage if plaza[cell] != place)
        for place, passage in tree.items()
    }
    size = Counter(plaza.values())
    (start,) = set(size) - set(tree)
    heads = []
    for place in reversed(tree):
        if size[place] >= ROOM_CELLS * rng.uniform(0.8, 1.6):
            heads.append(place)
        else:
            size[parent[place]] += size[place]
    if heads and size[start] < SMALLEST_ROOM:
        heads.pop()  # the one reached first, so it belongs to the start's room
    room = {start: 0}
    for place in tree:
        room[place] = 1 + heads.index(place) if place in heads else room[parent[place]]
    return room


def _add_rooms(
    layout: Layout,
    grid: Grid,
    plaza: dict[Cell, Cell],
    tree: dict[Cell, Passage],
    room: dict[Cell, int],
) -> None:
    """Add every room with the walls around its corridors."""
    owner = np.full((2 * grid.rows + 1, 2 * grid.columns + 1), -1)
    wide = set()
    for (c, r), cells in Counter(plaza.values()).items():
        span = 1 if cells == 1 else 3  # a square of four has no walls inside
        owner[2 * r + 1 : 2 * r + 1 + span, 2 * c + 1 : 2 * c + 1 + span] = room[c, r]
        if cells > 1:
            wide.add(room[c, r])
    for (c, r), (c1, r1) in tree.values():
        one, two = room[plaza[c, r]], room[plaza[c1, r1]]
        if one == two:
            owner[r + r1 + 1, c + c1 + 1] = one
    for number in range(max(room.values()) + 1):
        use = "open" if number in wide else "passage"
        layout.add_faces(use, trace(owner == number, grid.xs, grid.ys), f"{use} {number}")


def _door(
    rng: np.random.Generator, grid: Grid, passage: Passage, rooms: tuple[int, int]
) -> Opening:
    """A door somewhere across a passage."""
    x0, y0, x1, y1 = grid.gap(passage)
    along_x = passage[0][0] == passage[1][0]
    width = tidy(min(rng.uniform(0.9, 1.1), grid.corridor - 2 * CORNER))
    shift = tidy(CORNER + rng.random() * (grid.corridor - 2 * CORNER - width))
    if along_x:
        return Opening((tidy(x0 + shift), y0, tidy(x0 + shift + width), y1), True, rooms)
    return Opening((x0, tidy(y0 + shift), x1, tidy(y0 + shift + width)), False, rooms)
