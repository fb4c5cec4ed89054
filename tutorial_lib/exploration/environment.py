"""Image-goal navigation as a Gymnasium environment, so that any agent can be evaluated.

Importing this module registers ``tutorial_lib/ImageGoalNav-v0``:

    import gymnasium, tutorial_lib.exploration.environment
    environment = gymnasium.make("tutorial_lib/ImageGoalNav-v0", difficulty="hard")
    at_home = gymnasium.make("tutorial_lib/ImageGoalNav-v0", plan="my_home.yaml")
    many = gymnasium.make_vec("tutorial_lib/ImageGoalNav-v0", num_envs=64)
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.utils.seeding import np_random
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.exploration.episodes import (
    DIFFICULTIES,
    Episodes,
    EpisodeSource,
    exploration_world,
)
from tutorial_lib.exploration.motion import ACTIONS
from tutorial_lib.exploration.task import SENSORS, STEPS, ExplorationTask
from tutorial_lib.exploration.top_view import top_view
from tutorial_lib.observation import Observation
from tutorial_lib.se2 import Array
from tutorial_lib.validation import instance, integers, whole
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.generators import SIGNS
from tutorial_lib.world.importers import import_map
from tutorial_lib.world.noise import STOP
from tutorial_lib.world.occupancy import check_closed
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import PanoramicCamera
from tutorial_lib.world.worlds import scene_of

NAME = "tutorial_lib/ImageGoalNav-v0"
_FARTHEST = 1_000.0  # metres: no world is larger
_MOST = 100_000  # environments in lock-step
_AHEAD, _STARTS = 8, 8  # goals whose episodes are drawn at once, and starts towards each


class ImageGoalNavigation(gymnasium.Env):
    """One episode at a time; actions are stop, forward, left and right, 0 to 3.

    The reward is the episode's SPL, when it ends. `info` has "success", "spl" and "steps".

    Rendered images are for people: "rgb_array" is the panorama, "top_view" shows where robot and
    goal are, which no agent may know.
    """

    # gymnasium declares what belongs to the class as if it were an instance's.
    metadata: ClassVar[dict[str, Any]] = {  # pyrefly: ignore[bad-override]
        "render_modes": ["rgb_array", "top_view"],
        "render_fps": 10,
    }

    def __init__(
        self,
        *,
        worlds: Sequence[int] | None = None,
        plan: str | Path | FloorPlan | None = None,
        signs: str = "plain",
        difficulty: str = "medium",
        sensor: str = "rgbd",
        noise: bool = True,
        render_mode: str | None = None,
    ) -> None:
        """Choose what episodes are drawn from.

        Args:
            worlds: seeds, 0 to 99 unless given; those below 10,000 are for training.
            plan: a map file of any kind that `world.import_map` reads, or a floor plan, in which
                all episodes take place instead.
            signs: of the worlds, "plain" or "wayfinding".
            difficulty: one of `episodes.DIFFICULTIES`.
            sensor: "rgbd" or "rgb".
            noise: of motion and odometry.
            render_mode: None, "rgb_array" or "top_view".

        Raises:
            InputError: where there are no worlds, or one is no seed; for a plan that cannot be read
                or beside worlds or signs; for unknown signs, difficulty, sensor or render mode.
        """
        _check("sensor", sensor, SENSORS)
        _check("render_mode", render_mode, (None, *self.metadata["render_modes"]))
        self._source = _Source(worlds, plan, signs, difficulty)
        self._sensor, self._noise, self.render_mode = sensor, noise, render_mode
        self._task: ExplorationTask | None = None
        self.observation_space = _observations(sensor)
        self.action_space = spaces.Discrete(len(ACTIONS))

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, NDArray], dict[str, Any]]:
        """Draw an episode; the same seed draws the same one.

        Args:
            seed: of this episode and those after it.
            options: of this episode only: "difficulty", and "world", a seed, unless there is a plan
                of one's own.

        Raises:
            InputError: for an unknown option, and when the world drawn is too small for the
                difficulty.
        """
        super().reset(seed=seed, options=options)
        world, scene, episode = self._source.draw(
            {} if options is None else options, self.np_random
        )
        self._task = ExplorationTask(
            {world: scene}, episode, self.np_random, sensor=self._sensor, noise=self._noise
        )
        self._goal = self._task.goals()
        return self._observe(), self._info()

    def step(self, action: int) -> tuple[dict[str, NDArray], float, bool, bool, dict[str, Any]]:
        """Carry out an action.

        Raises:
            InputError: for an unknown action, before `reset`, and when the episode is over.
        """
        task = _running(self._task)
        if task.done[0]:
            raise InputError("step: the episode is over; call reset")
        task.step(np.array([action]))
        over = bool(task.done[0])
        truncated = bool(over and action != STOP and task.steps[0] >= STEPS)
        reward = float(task.spl[0]) if over else 0.0
        return self._observe(), reward, over and not truncated, truncated, self._info()

    def render(self) -> NDArray[np.uint8] | None:
        """The image that `render_mode` asks for, (H, W, 3), if it does.

        Raises:
            InputError: before `reset`.
        """
        task = _running(self._task)
        if self.render_mode == "top_view":
            (scene,) = task.scenes.values()
            return top_view(scene, [poses[0] for poses in task.path], task.goal_poses[0])
        return task.observe().image[0] if self.render_mode == "rgb_array" else None

    def _observe(self) -> dict[str, NDArray]:
        seen = _running(self._task).observe()
        goal = {f"goal_{name}": rows[0].copy() for name, rows in _seen(self._goal).items()}
        return {
            **{name: rows[0] for name, rows in _seen(seen).items()},
            **goal,
            "odometry": seen.odometry[0],
        }

    def _info(self) -> dict[str, Any]:
        task = _running(self._task)
        return {
            "success": bool(task.success[0]),
            "spl": float(task.spl[0]),
            "steps": int(task.steps[0]),
        }


class ManyImageGoalNavigations(VectorEnv):
    """N episodes in lock-step, much faster than N environments.

    In the step after the end of an episode its robot begins another one, whatever its action
    (Gymnasium's mode "next step"). Its `info` has arrays (N,) of what the other's has.
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
    ) -> None:
        """Choose what `num_envs` episodes are drawn from; see `ImageGoalNavigation`."""
        _check("sensor", sensor, SENSORS)
        self.num_envs = whole("num_envs", num_envs, least=1, most=_MOST)
        self._source = _Source(worlds, plan, signs, difficulty)
        self._sensor, self._noise = sensor, noise
        self.single_observation_space = _observations(sensor)
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
        self._options = {} if options is None else options
        self._ahead: list[Episodes] = []
        self._scenes: dict[str, Scene] = {}
        episodes, scenes = self._drawn(self.num_envs)
        self._task = ExplorationTask(
            scenes, episodes, self.np_random, sensor=self._sensor, noise=self._noise
        )
        self._over = np.zeros(self.num_envs, bool)
        self._goals = _seen(self._task.goals())
        return self._observe(), self._info()

    def step(
        self, actions: NDArray[np.integer]
    ) -> tuple[dict[str, NDArray], Array, NDArray, NDArray, dict[str, Any]]:
        """Carry out actions (N,).

        Returns:
            Observations; rewards (N,), the SPL of episodes that end; whether each has ended (N,) by
            itself, or (N,) after its last step; and `info`.

        Raises:
            InputError: for an unknown action, and before `reset`.
        """
        task, fresh = _running(self._task), np.flatnonzero(self._over)
        acting = integers("actions", actions, (self.num_envs,), least=0, most=len(ACTIONS) - 1)
        task.step(acting)  # robots whose episodes are over do nothing
        if len(fresh):
            episodes, scenes = self._drawn(len(fresh))
            task.replace(fresh, episodes, scenes)
            goals = _seen(task.goals(fresh))
            for name, rows in self._goals.items():
                rows[fresh] = goals[name]
        over = task.done.copy()
        truncated = over & (acting != STOP) & (task.steps >= STEPS)
        rewards = np.where(over, task.spl, 0.0)
        self._over = over
        return self._observe(), rewards, over & ~truncated, truncated, self._info()

    def _drawn(self, count: int) -> tuple[Episodes, dict[str, Scene]]:
        """Episodes, drawn ahead in turns of several starts to one goal; and their worlds."""
        while len(self._ahead) < count:
            turns = [
                self._source.draw(self._options, self.np_random, _STARTS) for _ in range(_AHEAD)
            ]
            self._scenes |= {world: scene for world, scene, _ in turns}
            episodes = Episodes.joined([turn for *_, turn in turns])
            order = self.np_random.permutation(len(episodes))
            self._ahead += [episodes[order[i : i + 1]] for i in range(len(order))]
        chosen, self._ahead = self._ahead[:count], self._ahead[count:]
        episodes = Episodes.joined(chosen)
        return episodes, {world: self._scenes[world] for world in set(episodes.worlds)}

    def _observe(self) -> dict[str, NDArray]:
        seen = _running(self._task).observe()
        goals = {f"goal_{name}": rows.copy() for name, rows in self._goals.items()}
        return {**_seen(seen), **goals, "odometry": seen.odometry}

    def _info(self) -> dict[str, Any]:
        task = _running(self._task)
        return {"success": task.success.copy(), "spl": task.spl, "steps": task.steps.copy()}


class _Source:
    """Where episodes are drawn from; each world's places are looked for once."""

    def __init__(
        self,
        worlds: Sequence[int] | None,
        plan: str | Path | FloorPlan | None,
        signs: str,
        difficulty: str,
    ) -> None:
        _check("signs", signs, SIGNS)
        _check("difficulty", difficulty, tuple(DIFFICULTIES))
        if plan is not None and (worlds is not None or signs != "plain"):
            raise InputError(
                "plan: it is the only world and has no signs; leave worlds and signs out"
            )
        self._plan = None if plan is None else Scene(_floor_plan(plan))
        self._worlds = _seeds(range(100) if worlds is None else worlds)
        self._signs, self._difficulty = signs, difficulty
        self._known: dict[str, tuple[Scene, EpisodeSource]] = {}

    def draw(
        self, options: dict[str, Any], rng: np.random.Generator, starts: int = 1
    ) -> tuple[str, Scene, Episodes]:
        """The name of a world, the world, and an episode in it, or several to one goal."""
        worlds, difficulty = self._chosen(options)
        world = "plan"
        if self._plan is None:
            world = exploration_world(int(rng.choice(worlds)), self._signs)
        if world not in self._known:
            scene = scene_of(world) if self._plan is None else self._plan
            self._known[world] = scene, EpisodeSource(world, scene)
        scene, source = self._known[world]
        return world, scene, source.draw({difficulty: 1}, rng, starts)

    def _chosen(self, options: dict[str, Any]) -> tuple[tuple[int, ...], str]:
        """Worlds and difficulty of the next episode."""
        known = ("difficulty", "world") if self._plan is None else ("difficulty",)
        for name in instance("options", options, dict):
            _check("options", name, known)
        difficulty = options.get("difficulty", self._difficulty)
        _check("options: difficulty", difficulty, tuple(DIFFICULTIES))
        if "world" not in options:
            return self._worlds, difficulty
        return (whole("options: world", options["world"], least=0),), difficulty


def _observations(sensor: str) -> spaces.Dict:
    """What one robot observes."""
    camera = PanoramicCamera()
    picture = spaces.Box(0, 255, (camera.rows, camera.columns, 3), np.uint8)
    parts: dict[str, spaces.Space] = {"image": picture, "goal_image": picture}
    if sensor == "rgbd":
        depth = spaces.Box(0.0, _FARTHEST, (camera.columns,), np.float32)
        parts |= {"depth": depth, "goal_depth": depth}
    parts["odometry"] = spaces.Box(-_FARTHEST, _FARTHEST, (3,), np.float64)
    return spaces.Dict(parts)


def _running(task: ExplorationTask | None) -> ExplorationTask:
    """The task of an environment, which there is after its first reset."""
    if task is None:
        raise InputError("environment: call reset first")
    return task


def _seen(observations: Observation) -> dict[str, NDArray]:
    """Images (N, H, W, 3), and depth (N, W) where there is some."""
    found: dict[str, NDArray] = {"image": observations.image}
    if observations.depth is not None:
        found["depth"] = np.minimum(observations.depth, _FARTHEST).astype(np.float32)
    return found


def _floor_plan(plan: str | Path | FloorPlan) -> FloorPlan:
    """A floor plan whose rooms are closed, from a file unless it is one."""
    if isinstance(plan, FloorPlan):
        check_closed(plan)
        return plan
    if not isinstance(plan, str | Path):
        raise InputError(
            f"plan: of type {type(plan).__name__}; give the name of a map's file or a FloorPlan"
        )
    return import_map(plan)


gymnasium.register(
    id=NAME,
    entry_point=f"{__name__}:ImageGoalNavigation",
    vector_entry_point=f"{__name__}:ManyImageGoalNavigations",
)


def _check(what: str, value: object, known: tuple[object, ...]) -> None:
    if value not in known:
        raise InputError(f"{what}: {value!r} is unknown; use one of {', '.join(map(str, known))}")


def _seeds(worlds: Sequence[int]) -> tuple[int, ...]:
    """Seeds of worlds, checked."""
    given = list(worlds) if isinstance(worlds, Iterable) else []
    whole = [isinstance(seed, int | np.integer) and seed >= 0 for seed in given]
    if not given or not all(whole):
        raise InputError(f"worlds: {worlds!r}; give seeds, at least one, whole numbers from 0 on")
    return tuple(map(int, given))
