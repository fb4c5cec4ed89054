"""The task of a demo: from which room to which the robot navigates, past whom."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tutorial_lib.errors import InputError
from tutorial_lib.experiments.demos.moments import SHARP
from tutorial_lib.experiments.demos.places import ROOMS_AWAY, doors_between, place_people
from tutorial_lib.experiments.protocols.navigation_tasks import (
    Building,
    Trials,
    draw_trials,
    explored,
)
from tutorial_lib.experiments.protocols.odometry import Odometry
from tutorial_lib.viz.canvas.plan_view import Picture
from tutorial_lib.world.people import Person
from tutorial_lib.world.scene import Scene

_TRIALS = 20  # of which the one that leads most rooms away is run

Say = Callable[[str], None]
"""Is called with what is being done."""


def silent(text: str) -> None:
    """Say nothing."""


@dataclass(frozen=True, eq=False)
class Task:
    """From which room to which an agent navigates, past whom.

    Attributes:
        building: explored before.
        trial: the only one.
        rooms: their kinds.
        away: doors between them.
        people: who walk beside the path.
        image: (H, W, 3) of the goal.
    """

    building: Building
    trial: Trials
    rooms: tuple[str, str]
    away: int
    people: list[Person]
    image: Picture


def choose_task(scene: Scene, seed: int, places: int, say: Say = silent) -> Task:
    """Explore a scene, and choose the trial that leads `ROOMS_AWAY` rooms away, or as nearly."""
    name = f"{scene.plan.family} {scene.plan.seed}"
    say("recording trajectories between the places of the building")
    odometry = Odometry(seed=(seed,))
    building = explored(name, scene, np.random.default_rng(seed), places, odometry)
    say("choosing a start and a goal image")
    drawn = draw_trials(building, _TRIALS, np.random.default_rng(seed))
    trial, rooms, away = farthest(building, drawn)
    first = trial.recorded.first[trial.goals[0]]
    people = place_people(trial.recorded.poses[first : trial.goals[0] + 1, :2], scene)
    image = SHARP.look(scene, trial.goal_poses[:1])[0][0]
    return Task(building, trial, rooms, away, people, image)


def farthest(building: Building, trials: Trials) -> tuple[Trials, tuple[str, str], int]:
    """The trial that leads `ROOMS_AWAY` rooms away, or as nearly; the rooms' kinds; the doors."""
    plan = building.scene.plan
    ends = np.stack([trials.starts[:, :2], trials.goal_poses[:, :2]])
    inside = np.stack([room.contains(ends.reshape(-1, 2)) for room in plan.rooms])
    room = inside.argmax(axis=0).reshape(2, -1)
    doors = doors_between(plan)[room[0], room[1]]
    doors = np.where(np.isfinite(doors), doors, 0).astype(int)
    if not len(trials):
        raise InputError(f"demo: no path between places of {plan.family}; give a larger map")
    best = int(np.lexsort((-trials.seconds, np.abs(doors - ROOMS_AWAY)))[0])
    kinds = tuple(plan.rooms[int(number)].kind for number in room[:, best])
    return trials.subset(np.array([best])), (kinds[0], kinds[1]), int(doors[best])
