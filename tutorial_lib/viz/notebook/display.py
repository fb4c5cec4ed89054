"""Pictures and films as output of notebook cells; nothing is fetched from the network."""

from __future__ import annotations

import base64
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.viz.canvas.plan_view import Picture
from tutorial_lib.viz.figures.film import png, write_film
from tutorial_lib.viz.figures.panels import film_strip


@dataclass(frozen=True)
class Still:
    """A picture as a cell's output."""

    picture: Picture

    def _repr_png_(self) -> bytes:
        return png(self.picture)

    def __repr__(self) -> str:
        height, width = self.picture.shape[:2]
        return f"a picture of {width} x {height} pixels"


@dataclass(frozen=True)
class Film:
    """A film as a cell's output, with a strip of its frames for viewers that cannot play it.

    Attributes:
        webm: the film's bytes.
        width: pixels.
        still: the strip.
    """

    webm: bytes
    width: int
    still: Picture

    def _repr_html_(self) -> str:
        data = base64.b64encode(self.webm).decode("ascii")
        return (
            f'<video controls loop muted playsinline width="{self.width}" style="max-width:100%" '
            f'src="data:video/webm;base64,{data}"></video>'
        )

    def _repr_png_(self) -> bytes:
        return png(self.still)

    def _ipython_display_(self) -> None:
        # Two outputs: a viewer shows one kind of each output, and hosted viewers drop the film.
        from IPython.display import publish_display_data

        publish_display_data({"text/html": self._repr_html_(), "text/plain": repr(self)})
        publish_display_data({"image/png": self._repr_png_(), "text/plain": "frames of the film"})

    def __repr__(self) -> str:
        return f"a film of {len(self.webm) / 1000:.0f} kB"


def show(picture: Picture) -> Still:
    """A picture (H, W, 3) as a cell's last line, or for `display`."""
    return Still(np.asarray(picture))


def play(
    frames: Sequence[Picture],
    frames_per_second: float,
    times: ArrayLike | None = None,
    count: int = 4,
) -> Film:
    """A film as a cell's last line, or for `display`.

    Args:
        frames: (H, W, 3) uint8 RGB, all of one size; a line or column of white makes it even.
        frames_per_second: of the film.
        times: (N,) seconds to write under the strip's frames; the film's own unless given.
        count: frames on the strip.

    Raises:
        InputError: when there are no frames, or their sizes differ.
    """
    even = [_even(np.asarray(frame)) for frame in frames]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "film.webm"
        write_film(path, even, frames_per_second)
        webm = path.read_bytes()
    times = np.arange(len(even)) / frames_per_second if times is None else times
    return Film(webm, even[0].shape[1], film_strip(even, times, count))


def _even(frame: Picture) -> Picture:
    height, width = frame.shape[:2]
    return np.pad(frame, [(0, height % 2), (0, width % 2), (0, 0)], constant_values=255)
