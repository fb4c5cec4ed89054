"""The vertices of a map as targets, encoded once for all robots and all goals."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.interfaces import Reachability, Targets, WaypointPredictor
from tutorial_lib.topology.mapping.growing_batch import GrowingBatch, joined
from tutorial_lib.topology.mapping.topomap import TopoMap


class MapTargets:
    """The vertices of a map as targets of C_WP and RE; each is encoded once.

    Attributes:
        topomap: the map, which may grow from one use to the next.
    """

    def __init__(
        self, topomap: TopoMap, predictor: WaypointPredictor, reachability: Reachability
    ) -> None:
        """Encode nothing yet."""
        self.topomap, self._encoders = topomap, (predictor, reachability)
        self._encoded = GrowingBatch(), GrowingBatch()

    def followed_by(self, contexts: NDArray) -> tuple[Targets, Any]:
        """The vertices and behind them other images (M, 2k+1, ...), for C_WP and for RE."""
        vertices, both = self.topomap.vertices, []
        for encoder, kept in zip(self._encoders, self._encoded, strict=True):
            fresh = np.arange(len(kept), len(vertices))
            if fresh.size:
                same = encoder is vertices.reachability
                kept.append(
                    vertices.prepared_targets(fresh)
                    if same
                    else encoder.prepare(vertices.contexts[fresh])
                )
            others = encoder.prepare(contexts)
            both.append(joined([kept[np.arange(len(kept))], others]) if len(kept) else others)
        return both[0], both[1]
