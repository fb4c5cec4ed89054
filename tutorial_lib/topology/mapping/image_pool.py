"""All images of a building that a map is built from, and what a model says about each pair."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.interfaces import Observation, RelativeModel
from tutorial_lib.se2 import Array, compose, wrap
from tutorial_lib.topology.mapping.growing_batch import GrowingBatch
from tutorial_lib.topology.mapping.retrieval import likeness, most_alike
from tutorial_lib.validation import alike, batch, floats, instance, integers, with_methods

CANDIDATES = 64
"""Images that each one is compared with: those most like it, as for Meng's map, where the model
embeds images; of the others r-hat counts as 0. Else all are compared (ours)."""
_AT_ONCE = 512
_AGREES = 0.6  # metres from a waypoint within which a detour by another image ends


def length(waypoints: Array) -> Array:
    """``d(w) = ||log T(w)||_F`` of waypoints (..., 3) (LTVN, Graph Building): (...) metres.

    T(w) is the matrix of the motion in SE(2). Its logarithm holds the one constant motion of a
    second that leads there: velocity (2,), and turning rate twice. So 1 rad counts as 1.41 m, and
    the velocity's part is the length of the arc, not of its chord.

    >>> length(np.array([[3.0, 4.0, 0.0], [0.0, 0.0, 1.0]])).round(3)
    array([5.   , 1.414])
    """
    waypoints = floats("waypoints", waypoints, (..., 3))
    turn = wrap(waypoints[..., 2])
    half = turn / 2
    chord = np.hypot(waypoints[..., 0], waypoints[..., 1])
    arc = chord / np.sinc(half / np.pi)  # numpy's sinc is sin(pi x) / (pi x)
    return np.sqrt(arc**2 + 2 * turn**2)


class ImagePool:
    """Images, indexed from 0 in the order in which they came; an index never changes.

    Attributes:
        model: LTVN's, see `RelativeModel`.
        observations: (M,) what was seen.
        prepared: (M,) the images as targets.
        drive, frame: (M,) the drive that each belongs to, and its number there.
        reachable: (M, M) r-hat from each image to each.
        waypoints: (M, M, 3) the pose of each, as predicted from each.
    """

    def __init__(self, model: RelativeModel) -> None:
        """No images."""
        self.model = with_methods("model", model, "prepare", "predict")
        self.observations, self.prepared = GrowingBatch(), GrowingBatch()
        self.drive = self.frame = np.empty(0, dtype=np.intp)
        self.reachable, self.waypoints = np.empty((0, 0)), np.empty((0, 0, 3))

    def __len__(self) -> int:
        return len(self.drive)

    def add(
        self,
        observations: Observation,
        contexts: NDArray,
        drive: NDArray[np.intp],
        frame: NDArray[np.intp],
    ) -> NDArray[np.intp]:
        """Add N images, ask the model about all new pairs, and return the images' indices.

        Args:
            observations: N.
            contexts: (N, 2k+1, ...) images of each in its context, as the model's view has them.
            drive: (N,) see `ImagePool`.
            frame: (N,) see `ImagePool`.
        """
        batch("contexts", instance("contexts", contexts, np.ndarray))
        count, old = len(observations), len(self)
        drive = integers("drive", drive, (count,), least=0)
        frame = integers("frame", frame, (count,), least=0)
        alike(observations=observations.odometry, contexts=contexts)
        self.observations.append(observations)
        self.prepared.append(self.model.prepare(contexts))
        self.drive, self.frame = np.append(self.drive, drive), np.append(self.frame, frame)
        new, everyone = np.arange(old, old + count), np.arange(old + count)
        reachable = np.zeros((old + count, old + count))
        waypoints = np.zeros((*reachable.shape, 3))
        reachable[:old, :old], waypoints[:old, :old] = self.reachable, self.waypoints
        for sources, targets in ((new, everyone), (everyone[:old], new)):
            if sources.size:
                self._ask(sources, targets, reachable, waypoints)
        np.fill_diagonal(reachable, 0.0)  # nobody drives to where it is
        self.reachable, self.waypoints = reachable, waypoints
        return new

    def _ask(self, sources: NDArray, targets: NDArray, reachable: Array, waypoints: Array) -> None:
        """Ask the model about sources (S,) and the targets (T,) that look like them."""
        rows, columns = self._alike(sources, targets)
        order = np.argsort(rows, kind="stable")  # a source that is repeated is encoded once
        from_, to = sources[rows[order]], targets[columns[order]]
        for some in np.array_split(np.arange(len(from_)), 1 + len(from_) // _AT_ONCE):
            if some.size:
                seen, shown = self.observations[from_[some]], self.prepared[to[some]]
                reachable[from_[some], to[some]], waypoints[from_[some], to[some]] = (
                    self.model.predict(seen, shown)
                )

    def _alike(self, sources: NDArray, targets: NDArray) -> tuple[NDArray, NDArray]:
        """Rows and columns of the pairs that are asked about, see `CANDIDATES`."""
        model, few = self.model, max(len(sources), len(targets)) <= CANDIDATES
        if few or not (hasattr(model, "embed") and hasattr(model, "embed_targets")):
            rows, columns = np.indices((len(sources), len(targets)))
            return rows.ravel(), columns.ravel()
        seen = model.embed(self.observations[sources])
        alike = likeness(seen, model.embed_targets(self.prepared[targets]))
        if len(targets) >= len(sources):
            columns = most_alike(alike, CANDIDATES)
            return np.repeat(np.arange(len(sources)), columns.shape[1]), columns.ravel()
        rows = most_alike(alike.T, CANDIDATES)
        return rows.ravel(), np.repeat(np.arange(len(targets)), rows.shape[1])

    def seen_from(self, observation: Observation, images: NDArray) -> tuple[Array, Array]:
        """r-hat (N,) and waypoints (N, 3) from one observation to images (N,)."""
        images = integers("images", images, ("N",), least=0, most=len(self) - 1)
        if not images.size:
            return np.empty(0), np.empty((0, 3))
        return self.model.predict(observation[np.zeros(len(images), int)], self.prepared[images])

    def lead_to(self, images: NDArray, target: Any) -> tuple[Array, Array]:  # noqa: ANN401
        """r-hat (N,) and waypoints (N, 3) from images (N,) to one prepared target."""
        images = integers("images", images, ("N",), least=0, most=len(self) - 1)
        if not images.size:
            return np.empty(0), np.empty((0, 3))
        return self.model.predict(self.observations[images], target[np.zeros(len(images), int)])


def support(pool: ImagePool, accepted: NDArray[np.bool_]) -> Array:
    """(M, M) the share of images between each pair that agree with its waypoint (ours).

    An image k is between i and j where i to k and k to j are accepted; it agrees where the waypoint
    to k and the one from there end within 0.6 m of the waypoint to j. Look-alike places
    have no such witnesses, or these contradict. A pair with nobody between has support 0.
    """
    count = len(pool)
    found = np.zeros((count, count))
    for source in range(count):
        between = np.flatnonzero(accepted[source])
        if not between.size:
            continue
        via = compose(pool.waypoints[source, between][:, None], pool.waypoints[between])
        off = np.hypot(*(via - pool.waypoints[source][None])[..., :2].transpose(2, 0, 1))
        witness = accepted[between]
        agree = (witness & (off < _AGREES)).sum(axis=0)
        found[source] = agree / np.maximum(witness.sum(axis=0), 1)
    return found
