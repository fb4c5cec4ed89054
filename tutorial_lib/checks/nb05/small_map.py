"""A map of indices, small enough to look into, for notebook 05."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tutorial_lib.checks.engine import Mask
from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping.vertices import Indices


@dataclass(eq=False)
class SmallMap:
    """A map whose vertices are anchors, named by their index in a table of RE.

    Attributes:
        reach: (N, N) RE between all N anchors that there are.
        vertices: the anchors that are vertices, in the order in which they were added.
        paths: for each trajectory the vertices that it leads over.
        edge_reach: (N, N) RE of the pairs that may be edges, 0 elsewhere.
        driven: (N, N) True where a trajectory goes from vertex to vertex.
        trajectory, place: (N,) the trajectory that a vertex was made for, and its place there from
            0; -1 for anchors that are no vertices.
        before, after: (N,) the vertex next to a vertex on its own trajectory, -1 for none.
    """

    reach: Array
    vertices: list[int]
    paths: list[list[int]]
    edge_reach: Array
    driven: Mask
    trajectory: Indices
    place: Indices
    before: Indices
    after: Indices

    @classmethod
    def empty(cls, reach: Array) -> SmallMap:
        """A map without vertices."""
        count = len(reach)
        tables = np.zeros((count, count)), np.zeros((count, count), dtype=bool)
        return cls(reach, [], [], *tables, *np.full((4, count), -1))
