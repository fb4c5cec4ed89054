"""Charts in the course's style, drawn by matplotlib without a display."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.validation import number, whole, with_methods
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.plan_view import Picture

_MOST = 100
"""Inches of a figure's side, and axes beside each other."""
if TYPE_CHECKING:
    from matplotlib.figure import Figure

_STYLE = {
    "font.size": 13,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": colours.unit(colours.FAINT),
    "axes.labelcolor": colours.unit(colours.INK),
    "axes.titlesize": 13,
    "axes.titlelocation": "left",
    "axes.grid": True,
    "grid.color": "0.92",
    "axes.axisbelow": True,
    "xtick.color": colours.unit(colours.INK),
    "ytick.color": colours.unit(colours.INK),
    "legend.frameon": False,
    "lines.linewidth": 2.2,
}


def chart(
    width: float = 7.0, height: float = 4.0, columns: int = 1
) -> tuple[Figure, NDArray[np.object_]]:
    """An empty figure of `width` x `height` inches and its (columns,) axes.

    The figure is not part of pyplot's state: show it by `from_figure`, or as a cell's last line.
    """
    from matplotlib import rc_context  # where it is needed: half a second
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    sizes = {"width": width, "height": height}
    width, height = (number(n, inches, above=0.0, most=_MOST) for n, inches in sizes.items())
    columns = whole("columns", columns, least=1, most=_MOST)
    with rc_context(_STYLE):
        figure = Figure(figsize=(width, height), dpi=96, layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.subplots(1, columns, squeeze=False)[0]
    return figure, axes


def from_figure(figure: Figure) -> Picture:
    """A matplotlib figure as an RGB picture (H, W, 3)."""
    from matplotlib import rc_context
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    canvas = FigureCanvasAgg(with_methods("figure", figure, "draw", "set_canvas"))
    with rc_context(_STYLE):
        canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()
