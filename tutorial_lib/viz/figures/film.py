"""Films and pictures as files."""

import errno
import io
import os
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from queue import Queue
from threading import Thread

import cv2
import numpy as np
from cv2.utils import logging
from numpy.typing import NDArray
from PIL import Image

from tutorial_lib.errors import InputError
from tutorial_lib.files import atomic_path
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.given import Picture, picture_of

_MOST_WAITING = 30  # frames that wait to be encoded
_FEW = 256  # colours of a palette
_MEANS, _APART = Image.Quantize.MEDIANCUT, Image.Quantize.MAXCOVERAGE
_BYTES = np.array([1 << 16, 1 << 8, 1], np.int32)  # of red, green and blue in a colour's code
_AT_ONCE = 1 << 14  # colours that are compared with a palette


@contextmanager
def film_encoder(
    path: str | Path, temporary: Path, frames_per_second: float
) -> Iterator[Callable[[Picture], None]]:
    """Write a WebM film (VP8), which every browser plays, frame by frame.

    Args:
        path: the film's name, for errors; ends in .webm.
        temporary: where it is written, see `files.atomic_paths`.
        frames_per_second: of the film.

    Yields:
        A function that adds a frame (H, W, 3), uint8 RGB. Frames are encoded in a thread of their
        own while the next ones are made.

    Raises:
        InputError: when there are no frames, they are no such pictures, their sizes are odd or
            differ, the name is not a WebM film's, or this OpenCV cannot write one.
        OSError: when the disk did not take all frames.
        cv2.error: when OpenCV failed at a frame; it may be raised some frames later.
    """
    if Path(path).suffix != ".webm":
        raise InputError(f"{path}: a film's name ends in .webm; rename it")
    encoder = _Encoder(path, temporary, frames_per_second)
    try:
        yield encoder.add
    finally:
        encoder.finish()
    if encoder.error is not None:
        raise encoder.error
    if encoder.shape is None:
        raise InputError(f"{path}: no frames to write; give at least one")
    if (found := _frames_in(temporary)) != encoder.count:  # OpenCV says nothing of a full disk
        words = f"{found} of {encoder.count} frames could be read again"
        raise OSError(errno.ENOSPC, words, str(temporary))


def write_film(path: str | Path, frames: Iterable[Picture], frames_per_second: float) -> None:
    """Write frames (H, W, 3) uint8 RGB as a film, whole or not at all; see `film_encoder`."""
    with atomic_path(path) as temporary, film_encoder(path, temporary, frames_per_second) as add:
        for frame in frames:
            add(frame)


def exact_png(picture: Picture) -> bytes:
    """An RGB picture (H, W, 3) as the bytes of a PNG file with all its colours."""
    return cv2.imencode(".png", picture[..., ::-1])[1].tobytes()


def png(picture: Picture) -> bytes:
    """An RGB picture (H, W, 3) as the bytes of a PNG file of at most 256 colours.

    That is a third of the size of one with all colours; a notebook has many pictures.

    Raises:
        InputError: when it is not such a picture.
    """
    picture = picture_of("picture", picture)
    codes, where = np.unique(picture.astype(np.int32) @ _BYTES, return_inverse=True)
    there = codes[:, None] // _BYTES % 256
    palette = there if len(there) <= _FEW else _palette(Image.fromarray(picture))
    parts = np.array_split(there, len(there) // _AT_ONCE + 1)
    nearest = np.concatenate([_nearest(part, palette) for part in parts])
    few = Image.fromarray(nearest[where].reshape(picture.shape[:2]))
    few.putpalette(palette.astype(np.uint8).tobytes())
    buffer = io.BytesIO()
    few.save(buffer, "PNG")
    return buffer.getvalue()


def _palette(image: Image.Image) -> NDArray[np.int32]:
    """Colours (C, 3) for a picture that has too many."""
    # The things and the floors keep their own. Of the others, two thirds are means of what fills
    # the picture. With these alone, thin lines of bright colours would be mixed with each other.
    found: list[Sequence[int]] = [*colours.THINGS, *colours.ROOMS.values()]
    left = _FEW - len(found)
    for count, how in ((left * 2 // 3, _MEANS), (left - left * 2 // 3, _APART)):
        values = (image.quantize(count, method=how).getpalette() or [])[: 3 * count]
        found += [values[i : i + 3] for i in range(0, len(values), 3)]
    return np.array(found, np.int32)


def _nearest(wanted: NDArray[np.int32], palette: NDArray[np.int32]) -> NDArray[np.uint8]:
    """Which colour of a palette (C, 3) is nearest to each of these (N, 3)."""
    # Without the square of what is wanted, which is the same for all colours of the palette.
    far = (palette**2).sum(axis=1) - 2 * wanted.astype(np.float32) @ palette.T.astype(np.float32)
    return far.argmin(axis=1).astype(np.uint8)


class _Encoder:
    """Encodes frames in a thread."""

    def __init__(self, path: str | Path, temporary: Path, rate: float) -> None:
        self.shape: tuple[int, ...] | None = None
        self.count = 0
        self.error: Exception | None = None
        self._path, self._temporary, self._rate = path, temporary, rate
        self._waiting: Queue[Picture | None] = Queue(_MOST_WAITING)

    def add(self, frame: Picture) -> None:
        """Add a frame; the first one fixes the size. An `error` of the thread is raised."""
        if self.error is not None:
            raise self.error
        if self.shape is None:
            self._start(frame)
        if frame.shape != self.shape or frame.dtype != np.uint8:  # OpenCV would drop it silently
            raise InputError(f"{self._path}: frames differ in size or are not uint8; mend them")
        self.count += 1
        self._waiting.put(frame)

    def finish(self) -> None:
        """Wait until all frames are encoded, or there is an `error`."""
        if self.shape is not None:
            self._waiting.put(None)
            self._thread.join()

    def _start(self, frame: Picture) -> None:
        height, width = frame.shape[:2]
        if height % 2 or width % 2:
            size = f"frames of {width} x {height} pixels"
            raise InputError(f"{self._path}: {size}; give even numbers")
        code = cv2.VideoWriter.fourcc(*"VP80")
        with _hushed():
            writer = cv2.VideoWriter(str(self._temporary), code, self._rate, (width, height))
        if not writer.isOpened():
            raise InputError(
                f"{self._path}: this OpenCV writes no WebM; reinstall opencv-python-headless"
            )
        self.shape = frame.shape
        self._thread = Thread(target=self._encode, args=(writer,), daemon=True)
        self._thread.start()

    def _encode(self, writer: cv2.VideoWriter) -> None:
        level = logging.getLogLevel()
        logging.setLogLevel(logging.LOG_LEVEL_ERROR)  # no warning for each frame that is lost
        try:
            while (frame := self._waiting.get()) is not None:
                writer.write(frame[..., ::-1])
        except Exception as error:  # a thread has nobody to tell but who adds the frames
            self.error = error
            while self._waiting.get() is not None:  # else they would wait for ever
                pass
        writer.release()
        logging.setLogLevel(level)


def _frames_in(path: Path) -> int:
    """How many frames a film holds, which are found but not decoded."""
    count = 0
    with _hushed():
        film = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG, [cv2.CAP_PROP_FORMAT, -1])
        while film.grab():
            count += 1
        film.release()
    return count


@contextmanager
def _hushed() -> Iterator[None]:
    """Keep FFmpeg's warnings off the terminal: of VP8's tag, and of films that end too early."""
    sys.stderr.flush()
    kept, nowhere = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 2)
        yield
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nowhere)
