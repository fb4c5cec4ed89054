"""Plain image similarity, to compare learned reachability with."""

import math

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Observation
from tutorial_lib.validation import floats, instance
from tutorial_lib.validation import images as pictures


class ImageSimilarity:
    """A `Reachability` without learning: the similarity of two images, pixel by pixel.

    The correlation of two images, from -1 to 1, is moved to 0 ... 1. It is no probability, but
    stands where one is expected, as the similarity of SPTM does.
    """

    def prepare(self, images: NDArray[np.uint8]) -> Array:
        """Images (M, P, H, W, 3) of targets, of which the middle one counts, as rows (M, D)."""
        images = pictures("images", images, ("M", "P", "H", "W", 3))
        return _rows(images[:, images.shape[1] // 2])

    def probability(self, observations: Observation, prepared: Array) -> Array:
        """Similarities (N,) in [0, 1]."""
        instance("observations", observations, Observation)
        prepared = floats("prepared", prepared, ("M", "D"))
        if len(prepared) != len(observations):
            raise InputError(f"targets: {len(prepared)} for {len(observations)}; give as many")
        return 0.5 + 0.5 * np.clip((_rows(observations.image) * prepared).sum(axis=1), -1.0, 1.0)


def _rows(images: NDArray[np.uint8]) -> Array:
    """Images (N, H, W, 3) as rows (N, D) of mean zero and length one."""
    rows = images.reshape(len(images), math.prod(images.shape[1:])).astype(np.float32)
    rows -= rows.mean(axis=1, keepdims=True)
    return rows / np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1e-6)
