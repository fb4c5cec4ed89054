"""What a fleet follows: a path of anchors for each robot."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.driving.control.composed import checked_waypoints
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Observation, Reachability, Targets, WaypointPredictor
from tutorial_lib.topology.query import query
from tutorial_lib.validation import alike, batch, flags, instance, integers, with_methods


@dataclass(frozen=True)
class AnchorPaths:
    """The paths of N robots over A anchors, which they may share.

    Attributes:
        targets: the anchors as targets of the waypoint predictor; an array of indices selects
            from them.
        prepared: the same anchors as `Reachability.prepare` made them.
        paths: for each robot the indices of its anchors, in order; frames of a trajectory or
            vertices of a map, for instance.

    Raises:
        InputError: when a path is empty or leads beyond the anchors.
    """

    targets: Targets
    prepared: Any
    paths: Sequence[ArrayLike]

    def __post_init__(self) -> None:
        for name in ("targets", "prepared"):
            batch(name, getattr(self, name))
        with_methods("paths", self.paths, "__len__")
        if len(self.targets) != len(self.prepared):
            raise InputError(
                f"paths: {len(self.targets)} targets but {len(self.prepared)} prepared for "
                "reachability; give the same anchors to both"
            )
        if not len(self.paths):
            raise InputError("paths: none; give one path for each robot")
        for i, path in enumerate(self.paths):
            path = _array(path)
            if path.ndim != 1 or not len(path) or path.dtype.kind not in "iu":
                raise InputError(f"paths: path {i} is {path}; give (L,) indices, L >= 1")
            if not 0 <= path.min() <= path.max() < len(self.targets):
                raise InputError(
                    f"paths: path {i} is {path}; anchors are 0 to {len(self.targets) - 1}"
                )

    @classmethod
    def end_to_end(cls, targets: Targets, prepared: Any, lengths: ArrayLike) -> AnchorPaths:  # noqa: ANN401
        """Paths of so many anchors each, which lie one after the other among the targets."""
        batch("targets", targets)
        lengths = integers("lengths", lengths, ("N",), least=1, empty=False)
        bounds = np.cumsum([0, *lengths])
        if bounds[-1] != len(targets):
            raise InputError(f"lengths: {bounds[-1]} in all, targets: {len(targets)}; give as many")
        return cls(targets, prepared, [np.arange(*ends) for ends in pairwise(bounds.tolist())])

    def __len__(self) -> int:
        return len(self.paths)

    @cached_property
    def lengths(self) -> NDArray[np.intp]:
        """(N,) anchors of each path."""
        return np.array([len(np.asarray(path)) for path in self.paths])

    @cached_property
    def _laid_out(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """All paths laid end to end, and (N,) where each begins."""
        return np.concatenate([np.asarray(path) for path in self.paths]), (
            np.cumsum(self.lengths) - self.lengths
        )

    def _anchors(self, robots: NDArray[np.intp], places: NDArray[np.intp]) -> NDArray[np.intp]:
        laid, begins = self._laid_out
        return laid[begins[robots] + places]

    def probabilities(
        self,
        reachability: Reachability,
        observations: Observation,
        robots: NDArray[np.intp],
        places: NDArray[np.intp],
        queried: NDArray[np.bool_],
    ) -> Array:
        """RE of anchors on the robots' paths, all in one call.

        Args:
            reachability: RE.
            observations: M robots.
            robots: (M,) their indices.
            places: (M, W) of the anchors along the paths.
            queried: (M, W) which of them to query; those that do not exist never are.

        Returns:
            (M, W), NaN where RE is not queried.
        """
        with_methods("reachability", reachability, "probability")
        robots, places, queried = self._checked(observations, robots, places, queried)
        rows, columns = np.nonzero(queried & self.exist(robots, places))
        found = np.full(places.shape, np.nan)
        anchors = self._anchors(robots[rows], places[rows, columns])
        found[rows, columns] = query(reachability, observations[rows], self.prepared[anchors])
        return found

    def waypoints(
        self,
        predictor: WaypointPredictor,
        observations: Observation,
        robots: NDArray[np.intp],
        places: NDArray[np.intp],
        queried: NDArray[np.bool_],
    ) -> tuple[Array, Array]:
        """Waypoints (M, W, 2) and mean overlaps (M, W) of anchors, as for `probabilities`."""
        with_methods("predictor", predictor, "predict")
        robots, places, queried = self._checked(observations, robots, places, queried)
        rows, columns = np.nonzero(queried & self.exist(robots, places))
        waypoints, overlaps = np.full((*places.shape, 2), np.nan), np.full(places.shape, np.nan)
        if len(rows):
            anchors = self._anchors(robots[rows], places[rows, columns])
            predicted = predictor.predict(observations[rows], self.targets[anchors])
            waypoints[rows, columns] = checked_waypoints(predicted[0], len(rows))
            overlaps[rows, columns] = _checked_overlaps(predicted[1], len(rows)).mean(axis=1)
        return waypoints, overlaps

    def exist(self, robots: NDArray[np.intp], places: NDArray[np.intp]) -> NDArray[np.bool_]:
        """(M, W) which of the `places` (M, W) exist on the paths of `robots` (M,)."""
        robots = integers("robots", robots, ("M",), least=0, most=len(self) - 1)
        places = integers("places", places, ("M", "W"))
        alike(robots=robots, places=places)
        return (places >= 0) & (places < self.lengths[robots, None])

    def _checked(
        self,
        observations: Observation,
        robots: NDArray[np.intp],
        places: NDArray[np.intp],
        queried: NDArray[np.bool_],
    ) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.bool_]]:
        instance("observations", observations, Observation)
        robots = integers("robots", robots, ("M",), least=0, most=len(self) - 1)
        places = integers("places", places, ("M", "W"))
        queried = flags("queried", queried, ("M", "W"))
        alike(observations=observations, robots=robots, places=places, queried=queried)
        alike(places=places.T, queried=queried.T)
        return robots, places, queried


def _array(path: ArrayLike) -> NDArray:
    """A path as an array; one that is ragged has no numbers."""
    try:
        return np.asarray(path)
    except ValueError:
        return np.empty(0)


def _checked_overlaps(overlaps: ArrayLike, pairs: int) -> Array:
    overlaps = np.asarray(overlaps, dtype=float)
    if overlaps.shape != (pairs, 2) or not np.isfinite(overlaps).all():
        raise InputError(f"overlaps: {overlaps.shape}; give finite (N, 2) for {pairs} pairs")
    return overlaps
