"""Episodes of all difficulties, with and without signs, in lock-step: what policies learn from."""

from itertools import product
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from tutorial_lib.exploration.episodes import DIFFICULTIES
from tutorial_lib.exploration.many_environments import ManyImageGoalNavigations
from tutorial_lib.exploration.motion import ACTIONS
from tutorial_lib.learning.panorama_network import PanoramaNetwork
from tutorial_lib.learning.reinforcement_views import PolicyViews
from tutorial_lib.se2 import Array
from tutorial_lib.world.generators import SIGNS

_SCALE = 0.1  # of rewards: values near 1 are learnt best


class PolicyEnvironments:
    """As many robots of each difficulty and kind of signs; they observe the parts of `PolicyViews`.

    Episodes end near their goals by themselves, until `ask_for_stop` is called.

    Attributes:
        num_envs: robots.
        single_observation_space: of one.
        single_action_space: of one.
        difficulty: of the episodes of each robot.
    """

    render_mode = None  # Stable-Baselines3 asks for it

    def __init__(self, worlds: int, each: int, pairs: PanoramaNetwork, *, maps: bool) -> None:
        """Put robots into every kind of episodes.

        Args:
            worlds: of each kind, which shares them with no other: the training worlds from 0 on.
            each: robots of each kind.
            pairs: the multi-task network.
            maps: whether they have maps.
        """
        kinds = list(product(DIFFICULTIES, SIGNS))
        self._parts = [
            ManyImageGoalNavigations(
                each,
                worlds=range(number * worlds, (number + 1) * worlds),
                difficulty=difficulty,
                signs=signs,
                reward="shaped",
                stops_itself=True,
            )
            for number, (difficulty, signs) in enumerate(kinds)
        ]
        self._each, self.num_envs = each, each * len(kinds)
        self.difficulty = [difficulty for difficulty, _ in kinds for _ in range(each)]
        self._views = PolicyViews(self.num_envs, pairs, maps=maps)
        boxes: dict[str, spaces.Space] = {
            name: spaces.Box(-np.inf, np.inf, (size,), np.float32)
            for name, size in self._views.sizes.items()
        }
        self.single_observation_space = spaces.Dict(boxes)
        self.single_action_space = spaces.Discrete(len(ACTIONS))

    def ask_for_stop(self) -> None:
        """From the next reset on, let episodes near their goals go on until the robot stops."""
        for part in self._parts:
            part.stops_itself = False

    def reset(self, seed: int | None = None) -> tuple[dict[str, NDArray], None]:
        """Begin all episodes; the same seed draws the same ones."""
        seeds = [None if seed is None else seed + i for i in range(len(self._parts))]
        self._seen = [part.reset(seed=one)[0] for part, one in zip(self._parts, seeds, strict=True)]
        self._shown = self._begin(np.arange(self.num_envs))
        return self._shown, None

    def step(
        self, actions: NDArray[np.intp]
    ) -> tuple[dict[str, NDArray], Array, NDArray, NDArray, dict[str, Any]]:
        """As that of `ManyImageGoalNavigations`, with smaller rewards."""
        self._views.acted(actions)
        shares = np.split(actions, len(self._parts))
        told = [part.step(share) for part, share in zip(self._parts, shares, strict=True)]
        seen, *columns, infos = zip(*told, strict=True)
        self._seen = list(seen)
        rewards, ended, truncated = (np.concatenate(column) for column in columns)
        info = {name: np.concatenate([one[name] for one in infos]) for name in infos[0]}
        self._shown = self._see(np.arange(self.num_envs))
        return self._shown, _SCALE * rewards, ended, truncated, info

    def restart(self, robots: NDArray[np.intp]) -> dict[str, NDArray]:
        """As that of `ManyImageGoalNavigations`."""
        for number, part in enumerate(self._parts):
            mine = robots[robots // self._each == number] - number * self._each
            if len(mine):
                self._seen[number] = part.restart(mine)
        begun = self._begin(robots)
        self._shown = {name: part.copy() for name, part in self._shown.items()}
        for name, part in begun.items():
            self._shown[name][robots] = part
        return self._shown

    def close(self) -> None:
        """Nothing is open."""

    def _begin(self, robots: NDArray[np.intp]) -> dict[str, NDArray]:
        """Show robots their goals; what they see at their starts."""
        self._views.begin(robots, *self._sensed(robots, "goal_image", "goal_depth"))
        return self._see(robots)

    def _see(self, robots: NDArray[np.intp]) -> dict[str, NDArray]:
        return self._views.see(robots, *self._sensed(robots, "image", "depth", "odometry"))

    def _sensed(self, robots: NDArray[np.intp], *names: str) -> list[NDArray]:
        """What robots observe by some senses."""
        return [np.concatenate([seen[name] for seen in self._seen])[robots] for name in names]
