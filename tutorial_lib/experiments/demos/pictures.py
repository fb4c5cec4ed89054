"""The plan under a demo's film, and two films beside each other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from tutorial_lib.experiments.protocols.navigation_tasks import Building
from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView
from tutorial_lib.viz.canvas.topomaps import draw_topomap
from tutorial_lib.viz.figures.panels import faded, side_by_side

_FADED = 0.6  # of the plan, under the map
_BESIDE = 570  # pixels of height where agent and oracle are shown beside each other


def view_of(building: Building, topomap: TopoMap, poses: Array, bounds: Array) -> PlanView:
    """The part of the plan within bounds (4,) with the map on it; its walls stay dark."""
    view = PlanView(building.scene, bounds=bounds)
    view.base = faded(view.base, _FADED)
    for wall in building.scene.plan.walls:
        view.polyline(view.base, wall.reshape(2, 2), colours.SOLID, 1)
    draw_topomap(view, view.base, topomap, poses)
    return view


@dataclass(frozen=True)
class Beside(Sequence[Picture]):
    """The frames of a film, and beside each the frame of another; the shorter one waits.

    Attributes:
        first: grows while its robot drives.
        second: may be empty; then the first is shown alone.
    """

    first: Sequence[Picture]
    second: Sequence[Picture]

    def __len__(self) -> int:
        return max(len(self.first), len(self.second))

    def __getitem__(self, index: int) -> Picture:
        mine = self.first[min(index, len(self.first) - 1)]
        if not len(self.second):
            return mine
        other = self.second[min(index, len(self.second) - 1)]
        return side_by_side([mine, other], height=_BESIDE, gap=20)
