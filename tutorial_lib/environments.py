"""The Gymnasium environments by name, and their observations in the form that RL libraries take.

Importing this module registers them; gymnasium does it itself for a name with the module in front:

    import gymnasium
    environment = gymnasium.make("tutorial_lib.environments:tutorial_lib/ImageGoalNav-v0")

`exploration.environment` says what they are and which options they have.
"""

import math
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.utils import RecordConstructorArgs
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.validation import instance, whole, with_methods

IMAGE_GOAL = "tutorial_lib/ImageGoalNav-v0"
CAR = "tutorial_lib/CarNav-v0"

# Strings only: what a class needs, numba among it, is loaded when one is made.
gymnasium.register(
    id=IMAGE_GOAL,
    entry_point="tutorial_lib.exploration.environment:ImageGoalNavigation",
    vector_entry_point="tutorial_lib.exploration.many_environments:ManyImageGoalNavigations",
)
gymnasium.register(id=CAR, entry_point="tutorial_lib.exploration.environment:CarNavigation")


class FlatViews(gymnasium.ObservationWrapper, RecordConstructorArgs):
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
        parts = _images_of("env", instance("env", env, gymnasium.Env).observation_space)
        self._cut = _Cut(parts, rows, columns)
        RecordConstructorArgs.__init__(self, rows=rows, columns=columns)
        gymnasium.ObservationWrapper.__init__(self, env)
        self.observation_space = self._cut.space

    def observation(self, observation: dict[str, NDArray]) -> dict[str, NDArray[np.float32]]:
        """The parts (K,) of what was observed."""
        return self._cut.flat(observation)


class OneImage(gymnasium.ObservationWrapper, RecordConstructorArgs):
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
        parts = _images_of("env", instance("env", env, gymnasium.Env).observation_space)
        rows, columns, channels = parts["image"].shape
        self._repeats = math.ceil(whole("least_rows", least_rows, least=1, most=4096) / rows)
        RecordConstructorArgs.__init__(self, least_rows=least_rows)
        gymnasium.ObservationWrapper.__init__(self, env)
        shape = (rows * self._repeats, columns, 2 * channels)
        self.observation_space = spaces.Box(0, 255, shape, np.uint8)

    def observation(self, observation: dict[str, NDArray]) -> NDArray[np.uint8]:
        """The image of what was observed."""
        both = np.concatenate([observation["image"], observation["goal_image"]], axis=2)
        return both.repeat(self._repeats, axis=0)


def for_baselines(many: Any, rows: int = 4, columns: int = 32) -> Any:  # noqa: ANN401
    """Many episodes in lock-step as Stable-Baselines3 has them, with the parts of `FlatViews`.

    Its `info` has what the loggers of Stable-Baselines3 ask for: "episode" and "is_success".

    Args:
        many: what `gymnasium.make_vec` makes of `IMAGE_GOAL`.
        rows: of an image; they divide its rows.
        columns: of an image and of depth; they divide its columns.

    Returns:
        A `stable_baselines3.common.vec_env.VecEnv`, whose episodes begin again at once.

    Raises:
        InputError: without Stable-Baselines3, which is in the extra `rl`.
    """
    with_methods("many", many, "restart", "step", "reset")
    cut = _Cut(_images_of("many", many.single_observation_space), rows, columns)
    return in_lock_step(many, cut.space, cut.flat)


def in_lock_step(
    many: Any,  # noqa: ANN401
    space: spaces.Space,
    shown: Callable[[dict[str, NDArray]], dict[str, NDArray]],
) -> Any:  # noqa: ANN401
    """Many episodes as Stable-Baselines3 has them, see `for_baselines`.

    Args:
        many: has `num_envs`, `single_action_space`, `reset`, `step`, `restart` and `close`.
        space: of what is shown of one robot.
        shown: what is shown of what all observe.

    Raises:
        InputError: without Stable-Baselines3.
    """
    try:
        from stable_baselines3.common.vec_env import VecEnv
    except ImportError as error:
        words = 'Stable-Baselines3 is missing; python -m pip install ".[rl]"'
        raise InputError(f"in_lock_step: {words}") from error

    class LockStep(VecEnv):
        """The environments behind the interface of Stable-Baselines3."""

        def __init__(self) -> None:
            super().__init__(many.num_envs, space, many.single_action_space)
            self._returns = np.zeros(many.num_envs)

        def reset(self) -> dict[str, NDArray]:
            seen, _ = many.reset(seed=self._seeds[0])
            self._reset_seeds()
            self._returns[:] = 0.0
            return shown(seen)

        def step_async(self, actions: NDArray) -> None:
            self._actions = actions

        def step_wait(self) -> tuple[dict[str, NDArray], NDArray, NDArray, list[dict[str, Any]]]:
            seen, rewards, ended, truncated, info = many.step(self._actions)
            over, flat = ended | truncated, shown(seen)
            self._returns += rewards
            infos: list[dict[str, Any]] = [{} for _ in over]
            for robot in np.flatnonzero(over):
                infos[robot] = {
                    "terminal_observation": {name: rows[robot] for name, rows in flat.items()},
                    "TimeLimit.truncated": bool(truncated[robot]),
                    "is_success": bool(info["success"][robot]),
                    "spl": float(info["spl"][robot]),
                    "episode": {"r": self._returns[robot], "l": int(info["steps"][robot])},
                }
            if over.any():
                self._returns[over] = 0.0
                flat = shown(many.restart(np.flatnonzero(over)))
            return flat, rewards, over, infos

        def close(self) -> None:
            many.close()

        def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:  # noqa: ANN401
            return [getattr(many, attr_name)] * len(list(self._get_indices(indices)))

        def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:  # noqa: ANN401
            setattr(many, attr_name, value)

        def env_method(self, method_name: str, *arguments: Any, **options: Any) -> list[Any]:  # noqa: ANN401
            raise InputError(
                f"env_method: {method_name!r} of one environment; all are one: use get_attr"
            )

        def env_is_wrapped(self, wrapper_class: type, indices: Any = None) -> list[bool]:  # noqa: ANN401
            return [False] * len(list(self._get_indices(indices)))

    return LockStep()


class _Cut:
    """Observations cut into parts, of which the means stay; see `FlatViews`.

    Attributes:
        space: of what is left.
    """

    def __init__(self, parts: dict[str, spaces.Box], rows: int, columns: int) -> None:
        height, width, _ = parts["image"].shape
        self._rows = _divisor("rows", rows, height)
        self._columns = _divisor("columns", columns, width)
        self.space = spaces.Dict({name: self._box(box) for name, box in parts.items()})

    def flat(self, observation: dict[str, NDArray]) -> dict[str, NDArray[np.float32]]:
        """Parts (..., K) of what one robot observed, or many."""
        return {name: self._flat(array) for name, array in observation.items()}

    def _box(self, box: spaces.Box) -> spaces.Box:
        flat = self._flat(box.low)
        if box.dtype == np.float64:
            return spaces.Box(flat, self._flat(box.high))
        return spaces.Box(0.0, 1.0, flat.shape, np.float32)

    def _flat(self, array: NDArray) -> NDArray[np.float32]:
        if array.dtype == np.float64:  # odometry, speed and steering
            return array.astype(np.float32)
        if array.dtype == np.float32:  # depth
            near = 1 / (1 + array)
            return near.reshape(*array.shape[:-1], self._columns, -1).mean(axis=-1)
        *many, height, width, channels = array.shape
        high, wide = height // self._rows, width // self._columns
        # Sums of bytes, first of the rows: these lie in one piece.
        sums = array.reshape(*many, self._rows, high, -1).sum(axis=-2, dtype=np.uint32)
        sums = sums.reshape(*many, self._rows, self._columns, wide, channels).sum(axis=-2)
        return (sums.reshape(*many, -1) / (255 * high * wide)).astype(np.float32)


def _divisor(name: str, value: int, length: int) -> int:
    """A number of equal parts of a length."""
    value = whole(name, value, least=1, most=length)
    if length % value:
        raise InputError(f"{name}: {value} do not divide {length}; give a divisor")
    return value


def _images_of(name: str, found: spaces.Space) -> dict[str, spaces.Box]:
    """What is observed, where that is a view and the goal's."""
    if not isinstance(found, spaces.Dict) or not {"image", "goal_image"} <= found.keys():
        kind = type(found).__name__
        raise InputError(f"{name}: it observes a {kind}; give one with image and goal_image")
    return {part: box for part, box in found.items() if isinstance(box, spaces.Box)}
