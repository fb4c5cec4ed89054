"""The Gymnasium environments by name, and their observations in the form that RL libraries take.

Importing this module registers them; gymnasium does it itself for a name with the module in front:

    import gymnasium
    environment = gymnasium.make("tutorial_lib.environments:tutorial_lib/ImageGoalNav-v0")

`exploration.environment` says what they are and which options they have.
"""

from __future__ import annotations

import math

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.validation import instance, whole

IMAGE_GOAL = "tutorial_lib/ImageGoalNav-v0"
CAR = "tutorial_lib/CarNav-v0"

# Strings only: what a class needs, numba among it, is loaded when one is made.
gymnasium.register(
    id=IMAGE_GOAL,
    entry_point="tutorial_lib.exploration.environment:ImageGoalNavigation",
    vector_entry_point="tutorial_lib.exploration.many_environments:ManyImageGoalNavigations",
)
gymnasium.register(id=CAR, entry_point="tutorial_lib.exploration.environment:CarNavigation")


class FlatViews(gymnasium.ObservationWrapper):
    """Small flat parts, for networks with fully connected layers ("MultiInputPolicy").

    Images become means over equal parts of them, 0 to 1; depth becomes 1 / (1 + m), and the mean of
    that over as many columns; all else stays as it is. All parts are float32 with one axis.
    """

    def __init__(self, env: gymnasium.Env, rows: int = 4, columns: int = 32) -> None:
        """Choose how much is left.

        Args:
            env: one of this module's.
            rows: of an image; they divide its rows.
            columns: of an image and of depth; they divide its columns.
        """
        parts = _images_of(env)
        height, width, _ = parts["image"].shape
        rows = whole("rows", rows, least=1, most=height)
        columns = whole("columns", columns, least=1, most=width)
        for name, many, all_of_them in (("rows", rows, height), ("columns", columns, width)):
            if all_of_them % many:
                raise InputError(f"{name}: {many} do not divide {all_of_them}; give a divisor")
        super().__init__(env)
        self._rows, self._columns = rows, columns
        self.observation_space = spaces.Dict({name: self._box(parts[name]) for name in parts})

    def observation(self, observation: dict[str, NDArray]) -> dict[str, NDArray[np.float32]]:
        """The parts (K,) of what was observed."""
        return {name: self._flat(array) for name, array in observation.items()}

    def _box(self, box: spaces.Box) -> spaces.Box:
        size = self._flat(box.low).size
        if box.dtype == np.float64:
            return spaces.Box(box.low.astype(np.float32), box.high.astype(np.float32))
        return spaces.Box(0.0, 1.0, (size,), np.float32)

    def _flat(self, array: NDArray) -> NDArray[np.float32]:
        if array.dtype == np.float64:  # odometry, speed and steering
            return array.astype(np.float32)
        if array.ndim == 1:
            near = 1.0 / (1.0 + array)
            return near.reshape(self._columns, -1).mean(axis=1, dtype=np.float32)
        height, width, channels = array.shape
        cut = (self._rows, height // self._rows, self._columns, width // self._columns, channels)
        means = array.reshape(cut).mean(axis=(1, 3), dtype=np.float32)
        return np.minimum(means / np.float32(255), np.float32(1)).ravel()


class OneImage(gymnasium.ObservationWrapper):
    """One image (H, W, 6), for convolutional networks ("CnnPolicy"): what is seen, and the goal.

    The goal's channels stand behind those of the robot's view. Each row is repeated until the image
    has the 36 rows that the usual three convolutions need.
    """

    def __init__(self, env: gymnasium.Env, least_rows: int = 36) -> None:
        """Choose how many rows there must be.

        Args:
            env: one of this module's.
            least_rows: of the image; it has a multiple of the camera's rows.
        """
        rows, columns, channels = _images_of(env)["image"].shape
        self._repeats = math.ceil(whole("least_rows", least_rows, least=1, most=4096) / rows)
        super().__init__(env)
        shape = (rows * self._repeats, columns, 2 * channels)
        self.observation_space = spaces.Box(0, 255, shape, np.uint8)

    def observation(self, observation: dict[str, NDArray]) -> NDArray[np.uint8]:
        """The image of what was observed."""
        both = np.concatenate([observation["image"], observation["goal_image"]], axis=2)
        return both.repeat(self._repeats, axis=0)


def _images_of(env: gymnasium.Env) -> spaces.Dict:
    """What an environment observes, where that is a view and the goal's."""
    found = instance("env", env, gymnasium.Env).observation_space
    if not isinstance(found, spaces.Dict) or not {"image", "goal_image"} <= found.keys():
        kind = type(found).__name__
        raise InputError(f"env: it observes a {kind}; give one with image and goal_image")
    return found
