"""Where robots of a class of one's own drove that missed their goals, and a film of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.explorers import own_explorer
from tutorial_lib.experiments.common.report import Options
from tutorial_lib.experiments.demos.exploration_film import SHARP as PANORAMA
from tutorial_lib.experiments.demos.moments import SHARP as CAMERA
from tutorial_lib.experiments.demos.recorder import FILM_RATE
from tutorial_lib.experiments.meng2020 import table1, table2
from tutorial_lib.experiments.nts import table1 as nts_table1
from tutorial_lib.experiments.protocols import local_control, navigation
from tutorial_lib.experiments.protocols.exploration import make_world
from tutorial_lib.experiments.race import ten_visits
from tutorial_lib.experiments.race.runners import own_runner
from tutorial_lib.exploration.task import ExplorationTask, explore, explore_on
from tutorial_lib.geometry import Array
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView
from tutorial_lib.viz.figures.directions import panorama_picture
from tutorial_lib.viz.figures.panels import camera_picture, evenly, side_by_side, stacked
from tutorial_lib.world.bodies import BicycleCar, DifferentialDrive
from tutorial_lib.world.simulation import STEP
from tutorial_lib.world.worlds import local_world, scene_of

ACTION = 0.5
"""Seconds that an action of a robot that explores takes, about."""
_FRAMES = 240  # of a film, at most
_PLAN, _WIDE = 640, 560  # pixels of the plan, and across the views beside it


@dataclass(frozen=True, eq=False)
class Trip:
    """What one robot drove that missed its goal.

    Attributes:
        world: its name, see `world.worlds.scene_of`.
        goal: (3,) pose at which the goal's image was taken.
        poses: (T, 3) of the robot.
        seconds: from the first pose to the last.
        panorama: whether it looks all around.
    """

    world: str
    goal: Array
    poses: Array
    seconds: float
    panorama: bool

    @classmethod
    def read(cls, stored: Mapping[str, Any]) -> Trip:
        """What `stored` gave."""
        given: dict[str, Any] = {**stored}
        given |= {name: np.array(given[name]) for name in ("goal", "poses")}
        return cls(**given)

    @property
    def stored(self) -> dict[str, Any]:
        """All of it, as JSON has it."""
        return {**vars(self), "goal": self.goal.tolist(), "poses": self.poses.tolist()}

    @property
    def gap(self) -> float:
        """Metres from where the robot ended to its goal."""
        return float(np.linalg.norm(self.poses[-1, :2] - self.goal[:2]))


def of_local_control(world: int, options: Options, settings: table1.Settings) -> Iterator[Trip]:
    """Trips of Table I in one world, without noise and obstacles."""
    condition = local_control.clean_condition(world, settings.episodes, options)
    found = condition.run(table1.custom(options.agent))
    for robot in np.flatnonzero(~found.reached).tolist():
        poses, goal = _until(found.poses, found.seconds, robot), condition.episodes.goals[robot]
        yield Trip(local_world(world), goal, poses, float(found.seconds[robot]), panorama=False)


def of_navigation(world: int, options: Options, settings: table2.Settings) -> Iterator[Trip]:
    """Trips of Table II in one world."""
    building, _, trials = table2.task_of(world, options, settings)
    outcome = navigation.attempt(building, trials, agents.custom(options.agent)).outcome
    for robot in np.flatnonzero(~outcome.success).tolist():
        poses, goal = _until(outcome.poses, outcome.seconds, robot), trials.goal_poses[robot]
        yield Trip(building.name, goal, poses, float(outcome.seconds[robot]), panorama=False)


def _until(poses: Array, seconds: Array, robot: int) -> Array:
    """(T, 3) poses of one robot of (T, N, 3), until its rollout ended."""
    return poses[: round(seconds[robot] / STEP) + 1, robot]


def of_exploring(world: int, options: Options, settings: nts_table1.Settings) -> Iterator[Trip]:
    """Trips of image-goal navigation in one world."""
    there = make_world(world, "plain", settings.episodes, options.seed)
    task = ExplorationTask(there.scenes, there.episodes, np.random.default_rng([*there.seed, 1]))
    explore(task, own_explorer(options.agent))
    yield from _missed(there.episodes.worlds[0], task, 0)


def of_visits(world: int, options: Options, settings: ten_visits.Settings) -> Iterator[Trip]:
    """Trips of the race in one world."""
    task, _, goals, _ = ten_visits.begun(world, options, settings)
    begun = 0
    for _ in explore_on(task, own_runner(options.agent), goals):
        yield from _missed(task.episodes.worlds[0], task, begun)
        begun = len(task.path) - 1


def _missed(world: str, task: ExplorationTask, begun: int) -> Iterator[Trip]:
    """What robots drove to their present goals, from a step on."""
    path = np.stack(task.path[begun:])
    for robot in np.flatnonzero(~task.success).tolist():
        steps = int(task.steps[robot])
        track = path[: steps + 1, robot]
        yield Trip(world, task.goal_poses[robot], track, ACTION * steps, panorama=True)


def film_of(trip: Trip, name: str) -> Iterator[Picture]:
    """The frames of a film: the plan with what was driven, and what the robot saw.

    Args:
        trip: that is shown.
        name: of the class.
    """
    scene, body = scene_of(trip.world), DifferentialDrive() if trip.panorama else BicycleCar()
    view = PlanView(scene, _PLAN, _PLAN)

    def look(pose: Array) -> Picture:
        camera = PANORAMA if trip.panorama else CAMERA
        image = camera.look(scene, pose[None])[0][0]
        if trip.panorama:
            return panorama_picture(image, _WIDE, _WIDE // 8)
        return camera_picture(image, _WIDE, smooth=True)

    chosen, wanted = evenly(len(trip.poses), _FRAMES), look(trip.goal)
    for step in [*chosen, *chosen[-1:].repeat(round(2 * FILM_RATE))]:
        pose, picture = trip.poses[step], view.base.copy()
        view.polyline(picture, trip.poses[: step + 1, :2], colours.TRACK, 3)
        view.goal(picture, trip.goal[:2])
        view.arrow(picture, trip.goal, colours.GOAL, 9)
        view.robot(picture, pose, body.footprint)
        beside = stacked([look(pose), wanted], ["what the robot sees", "the image of its goal"])
        seconds = trip.seconds * step / max(len(trip.poses) - 1, 1)
        gap = np.linalg.norm(pose[:2] - trip.goal[:2])
        words = f"{name}: {seconds:.0f} s, {gap:.1f} m from its goal in a straight line"
        yield side_by_side([picture, beside], [words, trip.world])
