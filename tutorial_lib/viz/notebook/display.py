"""Pictures and films as output of notebook cells; nothing is fetched from the network."""

import base64
import html
import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.errors import InputError
from tutorial_lib.validation import alike, floats, instance, number
from tutorial_lib.viz.canvas.given import Picture, picture_of, pictures_of
from tutorial_lib.viz.figures.film import png, write_film
from tutorial_lib.viz.figures.panels import film_strip, line_of_text

STATIC = "TUTORIAL_STATIC"
"""The environment variable that is set while a notebook is stored for hosted viewers."""
SHORTEST, NARROWEST = 6.0, 640
"""Seconds that a film lasts at least, and pixels that it is wide at least."""
_FASTEST = 1000.0  # frames a second
_CONTROLS = 56  # pixels under a film, where players draw their controls


@dataclass(frozen=True)
class Still:
    """A picture as a cell's output.

    Attributes:
        picture: (H, W, 3) uint8 RGB.
        alt: says what it shows to readers who do not see it.
    """

    picture: Picture
    alt: str = ""

    def _repr_mimebundle_(self, **_: Any) -> tuple[dict[str, Any], dict[str, Any]]:  # noqa: ANN401 - IPython's
        """The PNG; in a live notebook as HTML, since JupyterLab gives a bare PNG no alt text."""
        data, text = base64.b64encode(png(self.picture)).decode("ascii"), {"text/plain": repr(self)}
        if os.environ.get(STATIC):
            return text | {"image/png": data}, {"image/png": {"alt": self.alt}}
        width = self.picture.shape[1]
        style = f"max-width:100%;width:{width}px;background:white"
        alt, source = html.escape(self.alt), f"data:image/png;base64,{data}"
        page = f'<img alt="{alt}" style="{style}" src="{source}">'
        return text | {"text/html": page}, {}

    def __repr__(self) -> str:
        height, width = self.picture.shape[:2]
        return self.alt or f"a picture of {width} x {height} pixels"


@dataclass(frozen=True)
class Film:
    """A film as a cell's output, with a strip of its frames for viewers that cannot play it.

    Attributes:
        webm: the film's bytes.
        width: pixels.
        still: the strip.
        alt: says what it shows.
    """

    webm: bytes
    width: int
    still: Picture
    alt: str = ""

    def _repr_html_(self) -> str:
        data = base64.b64encode(self.webm).decode("ascii")
        return (
            f'<video controls loop muted playsinline width="{max(self.width, NARROWEST)}" '
            f'aria-label="{html.escape(self.alt)}" style="max-width:100%" '
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


def show(picture: Picture, alt: str = "") -> Still:
    """A picture (H, W, 3) as a cell's last line, or for `display`.

    Args:
        picture: uint8 RGB.
        alt: says what it shows; the title of the cell (its first line, a comment) unless given.

    Raises:
        InputError: when it is no such picture.
    """
    return Still(picture_of("picture", picture), instance("alt", alt, str) or _title_of_cell())


def play(
    frames: Sequence[Picture],
    frames_per_second: float,
    times: ArrayLike | None = None,
    count: int = 4,
    alt: str = "",
    strip: Sequence[Picture] | None = None,
) -> Film:
    """A film as a cell's last line, or for `display`.

    Each frame has its time written above it, as on the strip. A film that would last less than
    `SHORTEST` is slowed down.

    Args:
        frames: (H, W, 3) uint8 RGB, all of one size.
        frames_per_second: of the film.
        times: (N,) seconds of the frames; the film's own unless given.
        count: frames on the strip.
        alt: says what it shows; the title of the cell unless given.
        strip: pictures of the same moments for the strip, whose words would be too small on that of
            the frames; the frames unless given.

    Raises:
        InputError: when there are no frames, their sizes differ, or `strip` has not as many.
    """
    given, alt = pictures_of("frames", frames), instance("alt", alt, str)
    if len({frame.shape for frame in given}) != 1:
        raise InputError(f"frames: {len(given)}; give one at least, and all of one size")
    rate = number("frames_per_second", frames_per_second, above=0.0, most=_FASTEST)
    rate = min(rate, len(given) / SHORTEST)
    seconds = np.arange(len(given)) / rate if times is None else floats("times", times, ("N",))
    shown = given if strip is None else pictures_of("strip", strip)
    alike(frames=given, strip=shown)
    still = film_strip(shown, seconds, count)
    timed = [_timed(frame, at) for frame, at in zip(given, seconds, strict=True)]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "film.webm"
        write_film(path, timed, rate)
        webm = path.read_bytes()
    return Film(webm, timed[0].shape[1], still, alt or _title_of_cell())


def _timed(frame: Picture, seconds: float) -> Picture:
    """A frame with its time above it and room for a player's controls under it; even sizes."""
    line = line_of_text(f"{seconds:.1f} s", frame.shape[1])
    framed = np.concatenate([line, frame])
    height, width = framed.shape[:2]
    under = _CONTROLS + (height + _CONTROLS) % 2
    return np.pad(framed, [(0, under), (0, width % 2), (0, 0)], constant_values=255)


def _title_of_cell() -> str:
    """The comment that the running cell begins with; empty outside of a notebook."""
    from IPython import get_ipython

    shell = get_ipython()
    code = shell.user_ns.get("In", [""])[-1] if shell else ""
    first = code.lstrip().partition("\n")[0]
    return first.lstrip("# ").rstrip() if first.startswith("#") else ""
