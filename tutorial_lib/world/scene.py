"""A floor plan made ready for rays: what they meet and how it looks."""

from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from tutorial_lib.validation import instance
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.materials import PERIOD, TEXELS
from tutorial_lib.world.occupancy import ClearanceGrid, clearance_grid
from tutorial_lib.world.raycast import Raycaster

SHADE = 0.15
"""How much darker a wall along x is than one along y, so that corners are visible."""


class Scene:
    """The walls of a plan behind a raycaster, and their strips ready to be painted.

    It never changes: copies of what has one share it, and only its plan is pickled.
    """

    def __init__(self, plan: FloorPlan) -> None:
        """Prepare `plan`."""
        self.plan = instance("plan", plan, FloorPlan)
        self.caster = Raycaster(plan.segments)

    def __reduce__(self) -> tuple[type["Scene"], tuple[FloorPlan]]:
        return Scene, (self.plan,)

    def __deepcopy__(self, _memo: dict[int, object]) -> "Scene":
        return self

    @cached_property
    def clearance(self) -> ClearanceGrid:
        """The free space as a grid."""
        return clearance_grid(self.plan)

    @cached_property
    def wall_ends(self) -> KDTree:
        """All ends of walls and furniture, for queries of those nearby."""
        return KDTree(self.plan.segments.reshape(-1, 2))

    @cached_property
    def surfaces(self) -> NDArray[np.float32]:
        """(S, 6) each segment's material, offset and length in metres, shade, direction x and y."""
        run = self.plan.segments[:, 2:] - self.plan.segments[:, :2]
        length = np.linalg.norm(run, axis=1)
        shade = 1.0 - SHADE * np.abs(run[:, 0]) / length
        offsets = self.plan.segment_offsets % PERIOD
        columns = [self.plan.segment_materials, offsets, length, shade, *(run.T / length)]
        return np.stack(columns, axis=1).astype(np.float32)

    @cached_property
    def strips(self) -> NDArray[np.float32]:
        """(M, TEXELS + 1, 3) running sums of each strip.

        The mean colour of any stretch of wall follows from a difference of two of them, so a far
        wall is seen as the average of its colours and not as one arbitrary texel.
        """
        sums = np.zeros((len(self.plan.materials), TEXELS + 1, 3))
        np.cumsum(self.plan.atlas, axis=1, dtype=np.float64, out=sums[:, 1:])
        return sums.astype(np.float32)

    @cached_property
    def backdrop(self) -> NDArray[np.float32]:
        """(2, 3) the colours of ceiling and floor."""
        look = self.plan.look
        return look.tone(np.array([look.ceiling, look.floor], np.float32))
