"""Waypoint labels from above, expected and yours, beside each other."""

import cv2
import numpy as np
from numpy.typing import NDArray

from tutorial_lib.geometry import Array
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.labels import label as label_on


def labels_from_above(
    walls: Array, start: Array, track: Array, want: object, got: object
) -> NDArray[np.uint8]:
    """Wall, trajectory, start and both labels, in the frame of the start."""
    blocks = []
    for name, label in (("expected", want), ("yours", got)):
        block = np.full((300, 330, 3), 255, np.uint8)

        def at(point: Array) -> tuple[int, int]:
            return round(60 + 100 * point[0]), round(270 - 100 * point[1])

        for wall in walls:
            cv2.line(block, at(wall[:2]), at(wall[2:]), colours.SOLID, 6, cv2.LINE_AA)
        for place in track[::2]:
            cv2.circle(block, at(place), 3, colours.PATH, -1, cv2.LINE_AA)
        cv2.circle(block, at(start), 8, colours.ROBOT, -1, cv2.LINE_AA)
        point = np.asarray(label, dtype=float) if label is not None else np.full(2, np.nan)
        if point.shape == (2,) and np.isfinite(point).all() and np.abs(point).max() < 10:
            turn = start[2] + np.arctan2(point[1], point[0])
            end = start[:2] + np.hypot(*point) * np.array([np.cos(turn), np.sin(turn)])
            cv2.line(block, at(start), at(end), colours.GOAL, 2, cv2.LINE_AA)
            cv2.circle(block, at(end), 7, colours.GOAL, -1, cv2.LINE_AA)
        label_on(block, name, 8, 20)
        blocks.append(block)
    return np.concatenate(blocks, axis=1)
