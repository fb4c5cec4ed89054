"""Image-goal navigation as Gymnasium environments, so that any agent can be evaluated.

`tutorial_lib.environments` registers them:

    import gymnasium, tutorial_lib.environments
    environment = gymnasium.make("tutorial_lib/ImageGoalNav-v0", difficulty="hard")
    at_home = gymnasium.make("tutorial_lib/ImageGoalNav-v0", plan="my_home.yaml")
    car = gymnasium.make("tutorial_lib/CarNav-v0", reward="shaped")
    many = gymnasium.make_vec("tutorial_lib/ImageGoalNav-v0", num_envs=64)
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import ArrayLike, NDArray

import tutorial_lib.environments  # noqa: F401 - registers the names for whoever imports this
from tutorial_lib.errors import InputError
from tutorial_lib.exploration.car_task import CAR, SteeredCarTask
from tutorial_lib.exploration.episodes import DrawnEpisodes, Episodes, check_known
from tutorial_lib.exploration.motion import ACTIONS
from tutorial_lib.exploration.rewards import Rewards
from tutorial_lib.exploration.task import SENSORS, ExplorationTask
from tutorial_lib.exploration.top_view import top_view
from tutorial_lib.observation import Observation
from tutorial_lib.se2 import Array
from tutorial_lib.validation import flag, floats, whole
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.noise import STOP
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera, PanoramicCamera

_FARTHEST = 1_000.0  # metres: no world is larger


class ImageGoalNavigation(gymnasium.Env):
    """A round robot with a panorama; actions are stop, forward, left and right, 0 to 3.

    The reward is the episode's SPL, when it ends, unless another is chosen. `info` has "success",
    "spl" and "steps".

    Rendered images are for people: "rgb_array" is the robot's view, "top_view" shows where robot
    and goal are, which no agent may know.
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
        reward: str = "spl",
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
            reward: one of `rewards.REWARDS`.
            render_mode: None, "rgb_array" or "top_view".

        Raises:
            InputError: where there are no worlds, or one is no seed; for a plan that cannot be read
                or beside worlds or signs; for a choice that is unknown.
        """
        check_known("sensor", sensor, SENSORS)
        check_known("render_mode", render_mode, (None, *self.metadata["render_modes"]))
        self._drawn = DrawnEpisodes(worlds, plan, signs, difficulty)
        self._rewards = Rewards(reward, self._drawn.sources)
        self._sensor, self._noise, self.render_mode = sensor, flag("noise", noise), render_mode
        self._task: ExplorationTask | None = None
        self.observation_space, self.action_space = self._spaces()

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
        world, scene, episode = self._drawn.draw(options, self.np_random)
        self._task = task = self._put_down({world: scene}, episode)
        self._rewards.begin(task)
        self._goal = {f"goal_{name}": rows[0] for name, rows in views(task.goals()).items()}
        return self._observe(), self._info()

    def step(
        self, action: int | NDArray
    ) -> tuple[dict[str, NDArray], float, bool, bool, dict[str, Any]]:
        """Carry out an action.

        Raises:
            InputError: for an unknown action, before `reset`, and when the episode is over.
        """
        task = running(self._task)
        if task.done[0]:
            raise InputError("step: the episode is over; call reset")
        task.step(self._actions(action))
        over = bool(task.done[0])
        reward = float(self._rewards.paid(task, np.ones(1, bool))[0])
        truncated = over and not self._ended_itself(task, action)
        return self._observe(), reward, over and not truncated, truncated, self._info()

    def render(self) -> NDArray[np.uint8] | None:
        """The image that `render_mode` asks for, (H, W, 3), if it does.

        Raises:
            InputError: before `reset`.
        """
        task = running(self._task)
        if self.render_mode == "top_view":
            (scene,) = task.scenes.values()
            return top_view(scene, [poses[0] for poses in task.path], task.goal_poses[0])
        return task.observe().image[0] if self.render_mode == "rgb_array" else None

    def _spaces(self) -> tuple[spaces.Space, spaces.Space]:
        """Of observations and actions."""
        return observations(ExplorationTask.camera, self._sensor), spaces.Discrete(len(ACTIONS))

    def _put_down(self, scenes: Mapping[str, Scene], episode: Episodes) -> ExplorationTask:
        """A robot at the start of an episode."""
        return ExplorationTask(
            scenes, episode, self.np_random, sensor=self._sensor, noise=self._noise
        )

    def _actions(self, action: object) -> ArrayLike:
        """What the task is given for an action."""
        return np.array([whole("action", action, least=0, most=len(ACTIONS) - 1)])

    def _ended_itself(self, task: ExplorationTask, action: object) -> bool:
        """Whether an episode that is over was not cut short."""
        return bool(action == STOP)

    def _observe(self) -> dict[str, NDArray]:
        seen = running(self._task).observe()
        goal = {name: part.copy() for name, part in self._goal.items()}
        return {name: rows[0] for name, rows in views(seen).items()} | goal | self._felt(seen)

    def _felt(self, seen: Observation) -> dict[str, Array]:
        """What is measured beside the views."""
        return {"odometry": seen.odometry[0]}

    def _info(self) -> dict[str, Any]:
        task = running(self._task)
        return {
            "success": bool(task.success[0]),
            "spl": float(task.spl[0]),
            "steps": int(task.steps[0]),
        }


class CarNavigation(ImageGoalNavigation):
    """The same for the car, with a camera ahead; an action is speed and steering, -1 to 1 of each.

    They are shares of the top speed, 0.5 m/s (in reverse 0.3 m/s at most), and of the greatest
    steering angle, 0.45 rad, for a tenth of a second. An episode ends within `episodes.SUCCESS`
    metres of the goal, without `stop`, or after 500 steps. Only odometry has noise.
    """

    def _spaces(self) -> tuple[spaces.Space, spaces.Space]:
        seen = observations(SteeredCarTask.camera, self._sensor)
        seen["speed"] = spaces.Box(-_FARTHEST, _FARTHEST, (1,), np.float64)
        seen["steering"] = spaces.Box(-CAR.max_steering, CAR.max_steering, (1,), np.float64)
        return seen, spaces.Box(-1.0, 1.0, (2,), np.float32)

    def _put_down(self, scenes: Mapping[str, Scene], episode: Episodes) -> ExplorationTask:
        options = {"sensor": self._sensor, "noise": self._noise, "stops_itself": True}
        return SteeredCarTask(scenes, episode, self.np_random, **options)

    def _actions(self, action: object) -> ArrayLike:
        shares = floats("action", action, (2,), least=-1.0, most=1.0)
        return shares[None] * [CAR.max_speed, CAR.max_steering]

    def _ended_itself(self, task: ExplorationTask, action: object) -> bool:
        return bool(task.success[0])

    def _felt(self, seen: Observation) -> dict[str, Array]:
        return super()._felt(seen) | {"speed": seen.speed, "steering": seen.steering}


def observations(camera: Camera | PanoramicCamera, sensor: str) -> spaces.Dict:
    """What one robot observes."""
    picture = spaces.Box(0, 255, (camera.rows, camera.columns, 3), np.uint8)
    parts: dict[str, spaces.Space] = {"image": picture, "goal_image": picture}
    if sensor == "rgbd":
        depth = spaces.Box(0.0, _FARTHEST, (camera.columns,), np.float32)
        parts |= {"depth": depth, "goal_depth": depth}
    parts["odometry"] = spaces.Box(-_FARTHEST, _FARTHEST, (3,), np.float64)
    return spaces.Dict(parts)


def running(task: ExplorationTask | None) -> ExplorationTask:
    """The task of an environment, which there is after its first reset."""
    if task is None:
        raise InputError("environment: call reset first")
    return task


def views(observations: Observation) -> dict[str, NDArray]:
    """Images (N, H, W, 3), and depth (N, W) where there is some."""
    found: dict[str, NDArray] = {"image": observations.image}
    if observations.depth is not None:
        found["depth"] = np.minimum(observations.depth, _FARTHEST).astype(np.float32)
    return found
