"""Image-goal navigation (Chaplot et al. 2020, 3 and 5): N episodes in lock-step."""

from collections.abc import Iterator, Mapping
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.driving.metrics import spl
from tutorial_lib.errors import InputError
from tutorial_lib.exploration.episodes import SUCCESS, Episodes, check_known
from tutorial_lib.exploration.motion import ACTIONS, EXACT, move_among
from tutorial_lib.interfaces import ExplorerAgent, SequentialExplorer
from tutorial_lib.observation import Observation
from tutorial_lib.se2 import Array, compose, relative
from tutorial_lib.validation import flag, floats, instance, integers, whole, with_methods
from tutorial_lib.world.bodies import DifferentialDrive
from tutorial_lib.world.noise import STOP, DiscreteNoise
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera, Laser, PanoramicCamera

STEPS = 500
"""Actions of an episode, at most."""
SENSORS = ("rgbd", "rgb")


class ExplorationTask:
    """N round robots, each with an episode of its own, in one world or several.

    Robots pass through each other. An agent gets what `observe` and `goals` return and nothing
    else; the attributes here are for those who measure, and for oracles.

    Attributes:
        camera: of the robots.
        episodes: see `Episodes`.
        scenes: the worlds by name.
        poses: (N, 3) true poses.
        odometry: (N, 3) poses by dead reckoning, in the frame of each robot's start.
        done: (N,) has stopped, or has no steps left.
        success: (N,) has stopped within `SUCCESS` metres of its goal.
        steps: (N,) actions taken towards the present goal.
        travelled: (N,) metres towards the present goal; a robot that slips aside travels, too.
        collisions: (N,) actions that ended at a wall.
        path: true poses (N, 3) at the start and after each step.
    """

    camera: ClassVar[Camera | PanoramicCamera] = PanoramicCamera()

    def __init__(
        self,
        scenes: Mapping[str, Scene],
        episodes: Episodes,
        rng: np.random.Generator,
        *,
        sensor: str = "rgbd",
        noise: bool = True,
        limit: int = STEPS,
        stops_itself: bool = False,
    ) -> None:
        """Put robots at the starts of episodes.

        Args:
            scenes: the worlds by name.
            episodes: N of them.
            rng: draws actuation and odometry noise, from a stream of its own for each robot.
            sensor: one of `SENSORS`; with depth or without.
            noise: of motion and odometry; without it, actions are exact and so is odometry.
            limit: actions of an episode.
            stops_itself: episodes end near the goal without `stop` (the paper's Table 2); a `stop`
                anywhere else still ends them.

        Raises:
            InputError: when a world is missing, or the sensor is unknown.
        """
        for name, scene in instance("scenes", scenes, Mapping).items():
            instance(f"scenes: {name}", scene, Scene)
        instance("episodes", episodes, Episodes)
        instance("rng", rng, np.random.Generator)
        flag("noise", noise)
        flag("stops_itself", stops_itself)
        whole("limit", limit, least=1)
        self._rows = _rows_by_scene(scenes, episodes.worlds)
        check_known("sensor", sensor, SENSORS)
        self.episodes, self.scenes, count = episodes, scenes, len(episodes)
        self._depth, self._limit, self._stops_itself = sensor == "rgbd", limit, stops_itself
        self.poses, self.odometry = episodes.starts.astype(float), np.zeros((count, 3))
        self._goals, self._shortest = episodes.goals, episodes.shortest
        self._image = np.zeros((count, self.camera.rows, self.camera.columns, 3), np.uint8)
        self._ranges = np.zeros((count, self.camera.columns))
        self._stale = np.ones(count, bool)
        self._put_down(rng, noise)
        self.path, self.collisions = [self.poses], np.zeros(count, np.intp)
        self._begin()

    def __len__(self) -> int:
        return len(self.episodes)

    def _put_down(self, rng: np.random.Generator, noise: bool) -> None:
        """Make the robots ready to move from where they are."""
        self._noise = DiscreteNoise(len(self), rng) if noise else None

    def _begin(self) -> None:
        """Reset the counters of the present goals."""
        count = len(self)
        self.done, self.success = np.zeros((2, count), bool)
        self.steps, self.travelled = np.zeros(count, np.intp), np.zeros(count)

    @property
    def spl(self) -> Array:
        """(N,) success weighted by path length, towards the present goals."""
        return spl(self.success, self._shortest, self.travelled)

    @property
    def goal_poses(self) -> Array:
        """(N, 3) where the present goals' pictures are taken."""
        return self._goals

    def observe(self) -> Observation:
        """What the robots' sensors measure now; those that are done see what they saw last."""
        image, ranges = self._look(self.poses, self._stale)
        if len(image) == len(self):
            self._image, self._ranges = image, ranges
        else:
            self._image[self._stale], self._ranges[self._stale] = image, ranges
        self._stale[:] = False
        return self._observation(self._image.copy(), self._ranges.copy(), self.odometry.copy())

    def goals(self, robots: NDArray[np.intp] | None = None) -> Observation:
        """The pictures (N,) of the goals, with depth where the robots have it.

        Args:
            robots: (M,) rising indices of those whose goals are shown; all unless given.
        """
        chosen = np.ones(len(self), bool)
        if robots is not None:
            robots = integers("robots", robots, ("M",), least=0, most=len(self) - 1)
            chosen = np.isin(np.arange(len(self)), robots)
        image, ranges = self._look(self._goals, chosen)
        return self._observation(image, ranges, np.zeros((len(image), 3))).pictures()

    def step(self, actions: ArrayLike) -> None:
        """Carry out discrete actions; those of robots that are done do nothing.

        Args:
            actions: (N,) of STOP, FORWARD, LEFT, RIGHT.

        Raises:
            InputError: when an action is none of these.
        """
        running = ~self.done
        stops = self._carry_out(actions, running)
        self.steps[running] += 1
        self._stale |= running & ~stops
        self.path.append(self.poses)
        self._end(running, stops)

    def _carry_out(self, actions: ArrayLike, running: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Move the `running` robots (N,) as `step` does; which of them stop (N,)."""
        actions = integers("actions", actions, (len(self),), least=min(ACTIONS), most=max(ACTIONS))
        actions = np.where(running, actions, STOP)
        if self._noise is None:
            wanted, errors = EXACT[actions], np.zeros((len(self), 3))
        else:
            wanted, errors = self._noise.draw(actions)
        before, moving = self.poses, actions != STOP
        walls = [(scene.plan.segments, rows) for scene, rows in self._rows]
        after, stopped = move_among(before, wanted, walls, DifferentialDrive.radius)
        self.poses = np.where(moving[:, None], after, before)
        self.collisions += stopped & moving
        motions = relative(before, self.poses)
        self.odometry = compose(self.odometry, motions + errors)
        self.travelled = self.travelled + np.linalg.norm(motions[:, :2], axis=1)
        return actions == STOP

    def next_goals(self, goals: Array) -> None:
        """Give all robots another goal, from where they stand (section 6.1).

        Args:
            goals: (N, 3) poses.

        Raises:
            InputError: when there are not as many, or no path leads to one of them.
        """
        goals = floats("goals", goals)
        if goals.shape != (len(self), 3):
            raise InputError(f"goals: shape {goals.shape}; give ({len(self)}, 3), a pose a robot")
        shortest = np.empty(len(self))
        for scene, rows in self._rows:
            shortest[rows] = _shortest(scene, self.poses[rows, :2], goals[rows, :2])
        self._goals, self._shortest = goals, shortest
        self._begin()

    def replace(
        self, robots: NDArray[np.intp], episodes: Episodes, scenes: Mapping[str, Scene]
    ) -> None:
        """Let some robots begin other episodes.

        Args:
            robots: (M,) indices.
            episodes: M of them.
            scenes: their worlds by name; those of other robots are known.

        Raises:
            InputError: when there are not as many, or a world is missing.
        """
        robots = integers("robots", robots, ("M",), least=0, most=len(self) - 1)
        if len(instance("episodes", episodes, Episodes)) != len(robots):
            raise InputError(
                f"robots: {len(robots)}, episodes: {len(episodes)}; give as many of both"
            )
        self.scenes = {**self.scenes, **instance("scenes", scenes, Mapping)}
        both, order = Episodes.joined([self.episodes, episodes]), np.arange(len(self))
        order[robots] = len(self) + np.arange(len(robots))
        both = both[order]
        self._rows = _rows_by_scene(self.scenes, both.worlds)
        self.episodes = both
        self.poses, self._goals = self.poses.copy(), self._goals.copy()
        self.poses[robots], self.odometry[robots] = episodes.starts, 0.0
        self._goals[robots] = episodes.goals
        self._shortest = self.episodes.shortest
        for column in (self.done, self.success, self.steps, self.travelled, self.collisions):
            column[robots] = 0
        self._stale[robots] = True
        self.path = [self.poses]

    def carry(self, poses: Array) -> None:
        """Put all robots down elsewhere, at poses (N, 3); their odometry does not notice."""
        self.poses = floats("poses", poses, (len(self), 3)).copy()
        self._stale[:] = True
        self.path.append(self.poses)

    def _end(self, running: NDArray[np.bool_], stops: NDArray[np.bool_]) -> None:
        """Mark finished episodes and successes."""
        near = np.linalg.norm(self.poses[:, :2] - self._goals[:, :2], axis=1) < SUCCESS
        stopped = running & (stops | (near & self._stops_itself))
        self.success |= stopped & near
        self.done |= stopped | (running & (self.steps >= self._limit))

    def _look(self, poses: Array, chosen: NDArray[np.bool_]) -> tuple[NDArray[np.uint8], Array]:
        """Images and ranges of the chosen poses, in their order."""
        if len(self._rows) == 1:
            return self.camera.look(self._rows[0][0], poses[chosen])
        place = np.cumsum(chosen) - 1
        image = np.empty((chosen.sum(), *self._image.shape[1:]), np.uint8)
        ranges = np.empty((len(image), self._ranges.shape[1]))
        for scene, rows in self._rows:
            mine = rows[chosen[rows]]
            if len(mine):
                image[place[mine]], ranges[place[mine]] = self.camera.look(scene, poses[mine])
        return image, ranges

    def _observation(self, image: NDArray[np.uint8], ranges: Array, odometry: Array) -> Observation:
        still = np.zeros(len(image))
        laser = np.full((len(image), Laser.beams), np.nan)
        depth = ranges if self._depth else None
        senses = (image, depth, laser, odometry, still, still.copy())
        return Observation(*senses, camera=self.camera)


def _rows_by_scene(
    scenes: Mapping[str, Scene], worlds: tuple[str, ...]
) -> list[tuple[Scene, NDArray[np.intp]]]:
    """Each world with the rows of its episodes, if all are there."""
    missing = sorted(set(worlds) - scenes.keys())
    if missing:
        raise InputError(f"episodes: in {', '.join(missing)}; give these scenes as well")
    names = np.array(worlds)
    return [(scenes[name], np.flatnonzero(names == name)) for name in dict.fromkeys(worlds)]


def _shortest(scene: Scene, starts: Array, goals: Array) -> Array:
    """Metres (N,) between starts and goals, both (N, 2).

    A robot can stand in a pocket that the grid does not join to the rest: its path then begins at
    the nearest place of the largest part.
    """
    paths = GridPaths(scene.clearance)
    metres = paths.between(starts, goals)
    cut = np.flatnonzero(~np.isfinite(metres))
    if len(cut):
        points = paths.points[paths.largest]
        gaps = np.linalg.norm(points[:, None] - starts[cut], axis=2)
        metres[cut] = gaps.min(axis=0) + paths.between(points[gaps.argmin(axis=0)], goals[cut])
    if not np.isfinite(metres).all():
        lost = goals[~np.isfinite(metres)].tolist()
        raise InputError(f"goals: no path leads to {lost}; choose other places")
    return metres


def explore(task: ExplorationTask, agent: ExplorerAgent) -> None:
    """Let an agent act until all episodes of a task are over."""
    instance("task", task, ExplorationTask)
    with_methods("agent", agent, "start", "act")
    agent.start(task.goals())
    while not task.done.all():
        task.step(agent.act(task.observe(), ~task.done))


def explore_on(
    task: ExplorationTask, agent: ExplorerAgent, goals: Array
) -> Iterator[tuple[NDArray[np.bool_], Array]]:
    """Let an agent look for several goals in a row, and remember between them (section 6.1).

    Args:
        task: with the first goals.
        agent: one that can go on.
        goals: (K, N, 3) poses, the first ones included.

    Yields:
        Success (N,) and SPL (N,) for each of the K goals.

    Raises:
        InputError: when the agent cannot go on to another goal.
    """
    instance("task", task, ExplorationTask)
    goals = floats("goals", goals, ("K", len(task), 3))
    if not isinstance(agent, SequentialExplorer):
        raise InputError(f"agent: a {type(agent).__name__} has no look_for; it takes one goal only")
    agent.start(task.goals())
    for number, poses in enumerate(goals):
        if number:
            task.next_goals(poses)
            agent.look_for(task.goals())
        while not task.done.all():
            task.step(agent.act(task.observe(), ~task.done))
        yield task.success, task.spl
