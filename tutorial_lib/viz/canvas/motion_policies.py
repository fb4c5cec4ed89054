"""Riemannian motion policies: accelerations drawn as arrows, metrics as ellipses."""

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.validation import alike, floats, instance
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.given import check_canvas, places_of
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView

_CORNERS = 40  # of the polygon that stands for an ellipse
_SIZE = 0.06  # metres that stand for a weight of 1
_MOST = 3.0  # times as long is the longest semi-axis


def draw_arrows(view: PlanView, picture: Picture, points: ArrayLike, vectors: ArrayLike) -> None:
    """Draw an arrow from each of `points` (P, 2) along `vectors` (P, 2), both in metres."""
    points = places_of("points", points, (..., 2)).reshape(-1, 2)
    vectors = places_of("vectors", vectors, (..., 2)).reshape(-1, 2)
    alike(points=points, vectors=vectors)
    check_canvas(picture)
    ends = instance("view", view, PlanView).pixels(points + vectors)
    for start, end in zip(view.pixels(points), ends, strict=True):
        length = max(float(np.linalg.norm(end - start)), 1e-9)
        tail, tip = (tuple(np.round(16 * corner).astype(int).tolist()) for corner in (start, end))
        share = min(0.5, 6.0 / length)
        cv2.arrowedLine(picture, tail, tip, colours.INK, 1, cv2.LINE_AA, 4, share)


def draw_metrics(view: PlanView, picture: Picture, points: ArrayLike, metrics: ArrayLike) -> None:
    """Draw metrics (P, 2, 2) at `points` (P, 2) as ellipses, long along large weights.

    A semi-axis is 6 cm times the root of the weight along it, at most 18 cm.
    """
    instance("view", view, PlanView)
    points = places_of("points", points, (..., 2)).reshape(-1, 2)
    metrics = floats("metrics", metrics, (..., 2, 2)).reshape(-1, 2, 2)
    alike(points=points, metrics=metrics)
    for point, metric in zip(points, metrics, strict=True):
        view.polyline(picture, point + ellipse(metric, _SIZE, _MOST), colours.GOAL, 1)


def ellipse(metric: ArrayLike, size: float, most: float) -> NDArray[np.float64]:
    """The outline (P, 2) in metres that stands for a metric (2, 2).

    A semi-axis is `size` metres times the root of the weight along it, at most `most` times `size`.

    >>> np.abs(ellipse([[4.0, 0.0], [0.0, 1.0]], 0.1, 3.0)).max(axis=0).round(6).tolist()
    [0.2, 0.1]
    """
    weights, axes = np.linalg.eigh(np.asarray(metric, dtype=float))
    reach = size * np.minimum(np.sqrt(np.maximum(weights, 0.0)), most)
    turn = np.linspace(0.0, 2 * np.pi, _CORNERS + 1)
    return np.stack([np.cos(turn), np.sin(turn)], axis=1) * reach @ axes.T
