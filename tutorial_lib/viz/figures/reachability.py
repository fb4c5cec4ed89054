"""Figures of reachability: along a trajectory, pairs of images, reliability diagrams."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.validation import alike, flag, floats, instance, whole, with_methods
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.given import picture_of
from tutorial_lib.viz.canvas.labels import label
from tutorial_lib.viz.canvas.plan_view import Picture
from tutorial_lib.viz.canvas.probabilities import probability_colours
from tutorial_lib.viz.figures.charts import chart, from_figure
from tutorial_lib.viz.figures.panels import camera_picture, side_by_side, stacked

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_Z = 1.96  # of a 95% interval


def probability_bar(low: str = "never", high: str = "always") -> Picture:
    """A legend: the colours between the words for 0 and 1."""
    low, high = instance("low", low, str), instance("high", high, str)
    colourful = np.tile(probability_colours(np.linspace(0, 1, 200)), (16, 1, 1))
    words = []
    for word in (low, high):
        words.append(np.full((22, 11 * len(word), 3), colours.PAPER, np.uint8))
        label(words[-1], word, 2, 16)
    return side_by_side([words[0], colourful, words[1]], gap=8)


def pictured_pair(now: ArrayLike, target: ArrayLike, width: int = 300) -> Picture:
    """The current image (H, W, 3) above the target image."""
    given = {"now": now, "target": target}
    pictures = [camera_picture(picture_of(name, image), width) for name, image in given.items()]
    return stacked(pictures, ["now", "target"], gap=4)


def draw_reliability(
    axis: Axes,
    predicted: ArrayLike,
    measured: ArrayLike,
    count: ArrayLike | None = None,
    **looks: Any,  # noqa: ANN401 - matplotlib's
) -> None:
    """Draw a reliability diagram on an axis, with the diagonal of perfect calibration.

    Args:
        axis: to draw on.
        predicted: (B,) mean probability of each bin.
        measured: (B,) share of successes.
        count: (B,) or one number, how many are in a bin; draws Wilson's 95% intervals if given,
            none for an empty bin.
        looks: of the line, such as label or color.
    """
    with_methods("axis", axis, "plot", "vlines", "set", "set_aspect")
    predicted = floats("predicted", predicted, ("B",), nan=True, least=0.0, most=1.0)
    measured = floats("measured", measured, ("B",), nan=True, least=0.0, most=1.0)
    alike(predicted=predicted, measured=measured)
    if count is not None:
        count = floats("count", count, least=0.0)
        if count.shape not in ((), measured.shape):
            raise InputError(f"count: shape {count.shape}; give {measured.shape} or one number")
    axis.plot([0, 1], [0, 1], color=colours.unit(colours.FAINT), linewidth=1.2, zorder=1)
    looks = {"marker": "o", "markersize": 6, "clip_on": False, **looks}
    (line,) = axis.plot(predicted, measured, zorder=3, **looks)
    if count is not None:
        low, high = _interval(measured, np.where(count > 0, count, np.nan))
        axis.vlines(predicted, low, high, colors=line.get_color(), linewidth=1.2, zorder=2)
    axis.set(xlim=(0, 1), ylim=(0, 1), xlabel="predicted probability", ylabel="share reached")
    axis.set_aspect("equal")


def along_trajectory(
    metres: ArrayLike, probability: ArrayLike, now: int, reached: bool | None = None
) -> Picture:
    """RE (T,) for each target along a trajectory, with the present one marked.

    Args:
        metres: (T,) along the trajectory from the start to each target.
        probability: (T,) that RE predicts.
        now: index of the present target.
        reached: the outcome of the rollout to it, if there was one.
    """
    metres = floats("metres", metres, ("T",), empty=False)
    probability = floats("probability", probability, ("T",), least=0.0, most=1.0)
    alike(metres=metres, probability=probability)
    now = whole("now", now, least=0, most=len(metres) - 1)
    reached = None if reached is None else flag("reached", reached)
    figure, (axis,) = chart(4.6, 2.7)
    axis.plot(metres, probability, color=colours.unit(colours.ROBOT), clip_on=False)
    axis.axvline(metres[now], color=colours.unit(colours.GOAL), linewidth=1.5)
    if reached is not None:
        tone = colours.unit(colours.ROBOT if reached else colours.LASER)
        axis.plot(metres[now], float(reached), "s", color=tone, markersize=9, clip_on=False)
    axis.set(ylim=(0, 1), xlim=(metres[0], metres[-1]), ylabel="RE")
    axis.set(xlabel="m along the trajectory to the target")
    return from_figure(figure)


def _interval(share: NDArray, count: NDArray) -> tuple[NDArray, NDArray]:
    """Wilson's 95% interval of shares (B,) of `count` (B,) or one number."""
    middle = share + _Z**2 / (2 * count)
    half = _Z * np.sqrt(share * (1 - share) / count + _Z**2 / (4 * count**2))
    return (middle - half) / (1 + _Z**2 / count), (middle + half) / (1 + _Z**2 / count)
