"""Pictures combined: side by side or stacked, with titles, and as a strip of a film."""

from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.validation import flag, floats, instances, number, whole, with_methods
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.given import picture_of, pictures_of, pixels_of, resized
from tutorial_lib.viz.canvas.labels import SIZE, label, text_size
from tutorial_lib.viz.canvas.plan_view import Picture

TITLE = 30
"""Pixels of a title's height; it stays readable at half the size."""
STRIP = 960
"""Pixels of the width of a film's strip."""
_GAP = 8  # white pixels between its frames


def camera_picture(image: NDArray[np.uint8], width: int = 480, smooth: bool = False) -> Picture:
    """A camera's image (H, W, 3) enlarged for people, `width` x `width / 3` pixels.

    The camera sees 120 degrees from left to right and 60 from top to bottom, which is 3 to 1 on its
    image plane, whatever its number of rows. `smooth` blends the pixels; otherwise each is a tile.
    """
    image, width = picture_of("image", image), pixels_of("width", width, least=2)
    how = cv2.INTER_CUBIC if flag("smooth", smooth) else cv2.INTER_NEAREST
    return resized(image, (width, round(width / 3)), how)


def faded(picture: Picture, share: float = 0.5) -> Picture:
    """A picture made paler by a share from 0 to 1, so that drawings on it stand out."""
    picture, share = picture_of("picture", picture), number("share", share, least=0.0, most=1.0)
    paled = cv2.addWeighted(picture, 1 - share, np.full_like(picture, 255), share, 0)
    return np.asarray(paled, np.uint8)


def side_by_side(
    pictures: Sequence[Picture],
    titles: Sequence[str] = (),
    *,
    height: int | None = None,
    gap: int = 16,
) -> Picture:
    """Put pictures beside each other, each with its title above it.

    Args:
        pictures: (H, W, 3) uint8 each, of any size; untitled ones stand level in the middle.
        titles: one for each picture, or none at all.
        height: pixels to which every picture is scaled; as they are unless given.
        gap: white pixels between neighbours.

    Raises:
        InputError: when there is nothing to show, or titles are missing.
    """
    return _arranged(pictures, titles, height, gap, along=1)


def stacked(
    pictures: Sequence[Picture],
    titles: Sequence[str] = (),
    *,
    width: int | None = None,
    gap: int = 16,
) -> Picture:
    """Put pictures under each other, as `side_by_side` does beside each other."""
    return _arranged(pictures, titles, width, gap, along=0)


def evenly(total: int, count: int) -> NDArray[np.intp]:
    """Indices of `count` frames spread evenly over `total`; all of them when fewer.

    Raises:
        InputError: when there are no frames to choose from.
    """
    if total < 1 or count < 1:
        raise InputError("frames: no frames to show; give at least one, and a count >= 1")
    return np.linspace(0, total - 1, min(count, total)).round().astype(np.intp)


def film_strip(
    frames: Sequence[Picture], times: ArrayLike | None = None, count: int = 4
) -> Picture:
    """A film as `count` frames from first to last, side by side, with their times under them.

    Frames are scaled down to fit into `STRIP`, never up.

    Args:
        frames: (H, W, 3) uint8 each, of one size.
        times: (N,) seconds of the frames, written under them if given.
        count: frames to show; fewer if the film is shorter.

    Raises:
        InputError: when there are no frames, or not as many times.
    """
    with_methods("frames", frames, "__len__", "__getitem__")
    chosen = evenly(len(frames), whole("count", count, least=1))
    if times is not None:
        times = floats("times", times, ("N",))
        if len(times) != len(frames):
            raise InputError(f"times: {len(times)}, frames: {len(frames)}; give as many, or none")
    pictures = [picture_of(f"frames[{i}]", frames[i]) for i in chosen.tolist()]
    high, wide = pictures[0].shape[:2]
    scale = min(1.0, (STRIP - _GAP * (len(chosen) - 1)) / (len(chosen) * wide))
    size = (max(1, int(wide * scale)), max(1, int(high * scale)))
    pictures = [resized(picture, size, cv2.INTER_AREA) for picture in pictures]
    if times is not None:
        under = [line_of_text(f"{times[i]:.1f} s", size[0]) for i in chosen]
        pictures = [np.concatenate(pair) for pair in zip(pictures, under, strict=True)]
    return side_by_side(pictures, gap=_GAP)


def _arranged(
    pictures: Sequence[Picture], titles: Sequence[str], size: int | None, gap: int, along: int
) -> Picture:
    """Pictures in a row (`along` 1) or a column (0), scaled to `size` across it."""
    panels, titles = pictures_of("pictures", pictures), instances("titles", titles, str)
    if not panels or (titles and len(titles) != len(panels)):
        raise InputError(
            f"pictures: {len(panels)}, titles: {len(titles)}; "
            "give at least one picture, and as many titles or none"
        )
    gap = pixels_of("gap", gap, least=0)
    if size is not None:
        size = pixels_of("width" if along == 0 else "height", size)
        panels = [_scaled(panel, size / panel.shape[1 - along]) for panel in panels]
    if len(titles):
        panels = [
            np.concatenate([line_of_text(t, p.shape[1]), p])
            for t, p in zip(titles, panels, strict=True)
        ]
    across = max(panel.shape[1 - along] for panel in panels)
    panels = [_padded(panel, across, 1 - along, bool(len(titles))) for panel in panels]
    space = [gap, gap, 3]
    space[1 - along] = across
    white = np.full(space, colours.PAPER, np.uint8)
    parts = [part for panel in panels for part in (panel, white)]
    return np.concatenate(parts[:-1], axis=along)


def _scaled(picture: Picture, scale: float) -> Picture:
    height, width = picture.shape[:2]
    how = cv2.INTER_AREA if scale < 1 else cv2.INTER_NEAREST
    size = (max(1, round(width * scale)), max(1, round(height * scale)))
    return resized(picture, size, how)


def line_of_text(text: str, width: int) -> Picture:
    """A white line with a text, in smaller letters where it would not fit."""
    line = np.full((TITLE, width, 3), colours.PAPER, np.uint8)
    wide, _ = text_size(text)
    label(line, text, 1, TITLE - 10, SIZE * min(1.0, (width - 2) / max(wide, 1)))
    return line


def _padded(picture: Picture, size: int, axis: int, level: bool) -> Picture:
    """Grow a picture to `size` pixels along an axis: white on both sides, or after it."""
    more = size - picture.shape[axis]
    before = 0 if level else more // 2
    pads = [(0, 0)] * 3
    pads[axis] = (before, more - before)
    return np.pad(picture, pads, constant_values=255)
