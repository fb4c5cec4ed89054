"""How likely is what a robot sees, were it at each vertex? By predicted overlap of the views."""

import numpy as np

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Observation, Targets, WaypointPredictor
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.validation import batch, instance, with_methods

_CANDIDATES = 48  # vertices that are compared with a view, those most alike


class ViewSensor:
    """Likelihoods of views: the mutual overlap with each vertex's picture, as C_WP predicts it.

    It is nearly one where the picture was taken, about a half 1.5 m before, and nearly nothing
    elsewhere, unless that looks alike. RE would do worse: it is high for all that lies ahead.
    """

    def __init__(self, topomap: TopoMap, predictor: WaypointPredictor, targets: Targets) -> None:
        """Look for a map's vertices.

        Args:
            topomap: the map, which must not grow meanwhile.
            predictor: C_WP.
            targets: all vertices as it prepared them, the removed ones as well.
        """
        self._map = instance("topomap", topomap, TopoMap)
        self._predictor = with_methods("predictor", predictor, "predict")
        self._targets = batch("targets", targets)
        if len(targets) < len(topomap.vertices):
            raise InputError(f"targets: {len(targets)}; give {len(topomap.vertices)}, all vertices")
        self._column = np.full(len(topomap.vertices), -1)
        self._column[topomap.alive] = np.arange(len(topomap))

    def __call__(self, observations: Observation) -> Array:
        """(N, V) likelihoods, 0 for vertices that are not alike at all."""
        instance("observations", observations, Observation)
        near = self._map.nearby(observations, _CANDIDATES)
        likelihood = np.zeros((len(observations), len(self._map)))
        if near.size:
            rows = np.repeat(np.arange(len(near)), near.shape[1])
            _, overlaps = self._predictor.predict(observations[rows], self._targets[near.ravel()])
            likelihood[rows, self._column[near.ravel()]] = np.asarray(overlaps).mean(axis=1)
        return np.clip(likelihood, 0.0, 1.0)
