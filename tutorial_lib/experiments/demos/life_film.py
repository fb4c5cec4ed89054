"""The film of a map's life: the dashboard on a plan with the map as it is now, and the story."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.geometry import Array
from tutorial_lib.topology.maintenance import Maintenance
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.labels import label
from tutorial_lib.viz.canvas.living_maps import draw_living_map
from tutorial_lib.viz.canvas.plan_view import Picture
from tutorial_lib.viz.figures.dashboard import LEGEND, MARGIN, Moment, dashboard
from tutorial_lib.viz.figures.maps import pale_view
from tutorial_lib.world.people import Person
from tutorial_lib.world.scene import Scene

_LEGEND = (
    *((name.replace("person", "shut door"), colour) for name, colour in LEGEND),
    ("edge", colours.FAINT),
)
_EDGES = (
    "The map's edges: grey where it is sure of them, vermilion where it doubts them, "
    "dashed where they are pruned."
)
_LINE = 30  # pixels of a line of the story
_SIZE = 0.76
_BESIDE = 100  # pixels to the left of the door


class LifeFilm:
    """Draws moments of a robot whose map changes meanwhile."""

    def __init__(
        self, scene: Scene, upkeep: Maintenance, vertices: Array, door: ArrayLike, lines: int
    ) -> None:
        """Film.

        Args:
            scene: the world.
            upkeep: of the map.
            vertices: (V, 3) where the map's images were taken.
            door: (K, 2) places across the door that is opened and shut.
            lines: of the story, at most.
        """
        self._view, self._upkeep, self._vertices = pale_view(scene), upkeep, vertices
        self._plan, self._door, self._lines = self._view.base, np.asarray(door), lines

    def frame(self, moment: Moment, title: str, door: str, story: Sequence[str]) -> Picture:
        """The picture of a moment; the map is drawn as it is now."""
        view = self._view
        view.base = self._plan.copy()
        upkeep = self._upkeep
        draw_living_map(view, view.base, self._vertices, upkeep.graph, upkeep.pruned)
        for place in self._door:
            view.ring(view.base, place, Person.radius, colours.PERSON)
        x, y = view.pixels(self._door[0]).round().astype(int).tolist()
        label(view.base, f"door {door}", x - _BESIDE, y + 6, 0.62)
        shown = dashboard(view, moment, title, _LEGEND)
        high = _LINE * (self._lines + 1) + MARGIN
        below = np.full((high, shown.shape[1], 3), colours.PAPER, np.uint8)
        label(below, _EDGES, MARGIN, _LINE, _SIZE, colours.FAINT)
        for number, line in enumerate(story, 2):
            label(below, line, MARGIN, _LINE * number, _SIZE)
        return np.concatenate([shown, below])
