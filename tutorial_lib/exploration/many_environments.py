"""Many episodes in lock-step, as a vector environment of Gymnasium."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from gymnasium import spaces
from gymnasium.utils.seeding import np_random
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from tutorial_lib.exploration.environment import observations, running, views
from tutorial_lib.exploration.episodes import DrawnEpisodes, Episodes, check_known
from tutorial_lib.exploration.motion import ACTIONS
from tutorial_lib.exploration.rewards import Rewards
from tutorial_lib.exploration.task import SENSORS, STEPS, ExplorationTask
from tutorial_lib.se2 import Array
from tutorial_lib.validation import flag, integers, whole
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.noise import STOP
from tutorial_lib.world.scene import Scene

_MOST = 100_000  # environments in lock-step
_AHEAD, _STARTS = 8, 8  # goals whose episodes are drawn at once, and starts towards each


class ManyImageGoalNavigations(VectorEnv):
    """N episodes in lock-step, much faster than N environments.

    In the step after the end of an episode its robot begins another one, whatever its action
    (Gymnasium's mode "next step"). Its `info` has arrays (N,) of what the other's has.

    Attributes:
        stops_itself: see `ExplorationTask`; after a change, from the next `reset` on.
    """

    metadata: ClassVar[dict[str, Any]] = {  # pyrefly: ignore[bad-override]
        "autoreset_mode": AutoresetMode.NEXT_STEP
    }

    def __init__(
        self,
        num_envs: int = 64,
        *,
        worlds: Sequence[int] | None = None,
        plan: str | Path | FloorPlan | None = None,
        signs: str = "plain",
        difficulty: str = "medium",
        sensor: str = "rgbd",
        noise: bool = True,
        reward: str = "spl",
        stops_itself: bool = False,
    ) -> None:
        """Choose what `num_envs` episodes are drawn from; see `ImageGoalNavigation`."""
        check_known("sensor", sensor, SENSORS)
        self.num_envs = whole("num_envs", num_envs, least=1, most=_MOST)
        self._drawn = DrawnEpisodes(worlds, plan, signs, difficulty)
        self._rewards = Rewards(reward, self._drawn.sources)
        self._sensor, self._noise = sensor, flag("noise", noise)
        self.stops_itself = flag("stops_itself", stops_itself)
        self.single_observation_space = observations(ExplorationTask.camera, sensor)
        self.single_action_space = spaces.Discrete(len(ACTIONS))
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._task: ExplorationTask | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, NDArray], dict[str, Any]]:
        """Draw an episode for every robot; the same seed draws the same ones.

        Args:
            seed: of these episodes and those after them.
            options: as of `ImageGoalNavigation.reset`; also of the episodes after these.

        Raises:
            InputError: as there.
        """
        if seed is not None:
            self._np_random, self._np_random_seed = np_random(seed)
        self._options = options
        self._ahead: Episodes | None = None
        self._scenes: dict[str, Scene] = {}
        episodes, scenes = self._next(self.num_envs)
        self._task = ExplorationTask(
            scenes,
            episodes,
            self.np_random,
            sensor=self._sensor,
            noise=self._noise,
            stops_itself=self.stops_itself,
        )
        self._rewards.begin(self._task)
        self._over = np.zeros(self.num_envs, bool)
        self._goals = views(self._task.goals())
        return self._observe(), self._info()

    def step(
        self, actions: NDArray[np.integer]
    ) -> tuple[dict[str, NDArray], Array, NDArray, NDArray, dict[str, Any]]:
        """Carry out actions (N,).

        Returns:
            Observations; rewards (N,); whether each episode has ended (N,) by itself, or (N,) after
            its last step; and `info`.

        Raises:
            InputError: for an unknown action, and before `reset`.
        """
        task, fresh = running(self._task), np.flatnonzero(self._over)
        acting = integers("actions", actions, (self.num_envs,), least=0, most=len(ACTIONS) - 1)
        task.step(acting)  # robots whose episodes are over do nothing
        if len(fresh):
            self._begin(task, fresh)
        over = task.done.copy()
        truncated = over & (acting != STOP) & (task.steps >= STEPS)
        rewards = self._rewards.paid(task, ~self._over)
        self._over = over
        return self._observe(), rewards, over & ~truncated, truncated, self._info()

    def restart(self, robots: NDArray[np.integer]) -> dict[str, NDArray]:
        """Let some robots begin other episodes at once, and not in the next step.

        Args:
            robots: (M,) rising indices.

        Returns:
            What all observe.
        """
        task = running(self._task)
        robots = integers("robots", robots, ("M",), least=0, most=self.num_envs - 1, empty=False)
        self._begin(task, robots)
        self._over[robots] = False
        return self._observe()

    def _begin(self, task: ExplorationTask, robots: NDArray[np.intp]) -> None:
        """Put robots at the starts of other episodes."""
        episodes, scenes = self._next(len(robots))
        task.replace(robots, episodes, scenes)
        self._rewards.begin(task, robots)
        goals = views(task.goals(robots))
        for name, rows in self._goals.items():
            rows[robots] = goals[name]

    def _next(self, count: int) -> tuple[Episodes, dict[str, Scene]]:
        """Episodes that were drawn ahead, and their worlds."""
        parts, missing = [], count
        while missing:
            if self._ahead is None or self._taken == len(self._ahead):
                self._ahead, self._taken = self._turns(), 0
            parts.append(self._ahead[self._taken : self._taken + missing])
            self._taken += len(parts[-1])
            missing -= len(parts[-1])
        episodes = parts[0] if len(parts) == 1 else Episodes.joined(parts)
        return episodes, {world: self._scenes[world] for world in set(episodes.worlds)}

    def _turns(self) -> Episodes:
        """Several goals with several starts each, in random order."""
        turns = [self._drawn.draw(self._options, self.np_random, _STARTS) for _ in range(_AHEAD)]
        self._scenes |= {world: scene for world, scene, _ in turns}
        episodes = Episodes.joined([turn for *_, turn in turns])
        return episodes[self.np_random.permutation(len(episodes))]

    def _observe(self) -> dict[str, NDArray]:
        seen = running(self._task).observe()
        goals = {f"goal_{name}": rows.copy() for name, rows in self._goals.items()}
        return {**views(seen), **goals, "odometry": seen.odometry}

    def _info(self) -> dict[str, Any]:
        task = running(self._task)
        return {"success": task.success.copy(), "spl": task.spl, "steps": task.steps.copy()}
