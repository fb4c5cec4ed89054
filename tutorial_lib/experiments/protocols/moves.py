"""What happens to a robot under way: it is pushed, turned, carried, or met by a person."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.metrics import REACHED
from tutorial_lib.interfaces import Robots
from tutorial_lib.se2 import Array, compose
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.people import Person
from tutorial_lib.world.placing import is_free
from tutorial_lib.world.simulation import Simulation

ASIDE, TURNED = 0.5, np.deg2rad(40.0)
"""Metres and rad by which cars are moved."""
_AWAY = 4.0  # metres from its trajectory to where a car is carried, out of sight of all of it
_TRIES = 400
_CROSSING = 0.8  # metres that a person walks to either side of the trajectory
_WALKING = 0.25  # m/s

Move = Callable[[RecordedWorld, int, Array, np.random.Generator], "Array | None"]
"""Returns where to put a robot, given the recorded frame that it passes and its pose; None where
there is no such place."""


class Disturbance:
    """Moves each robot once, when it passes a given frame of its trajectory.

    Attributes:
        step: (N,) at which this happened, -1 for never.
    """

    def __init__(
        self,
        recorded: RecordedWorld,
        frames: NDArray[np.intp],
        move: Move | None,
        rng: np.random.Generator,
    ) -> None:
        """`frames` (N,) of the robots; without `move` only `step` is set."""
        self.recorded, self.frames, self.move, self.rng = recorded, frames, move, rng
        self.step, self._steps = np.full(len(frames), -1), 0

    def __call__(self, simulation: Simulation, robots: Robots) -> None:
        """Move the robots that are at their frame now."""
        gap = simulation.poses[:, :2] - self.recorded.poses[self.frames, :2]
        near = np.linalg.norm(gap, axis=1) < REACHED
        for robot in robots[near[robots] & (self.step[robots] < 0)]:
            if self.move is None:
                self.step[robot] = self._steps
                continue
            here = simulation.poses[robot]
            pose = self.move(self.recorded, self.frames[robot], here, self.rng)
            if pose is not None:
                simulation.place([robot], pose[None])
                self.step[robot] = self._steps
        self._steps += 1


def pushed(
    recorded: RecordedWorld, frame: int, here: Array, rng: np.random.Generator
) -> Array | None:
    """Pushed `ASIDE` metres to the left or right."""
    del frame
    for side in rng.permutation([-ASIDE, ASIDE]):
        there = compose(here, np.array([0.0, side, 0.0]))
        in_sight = recorded.scene.caster.sees(here[None, :2], there[None, :2])[0]
        if in_sight and is_free(recorded.scene, BicycleCar(), there[None])[0]:
            return there
    return None


def turned(
    recorded: RecordedWorld, frame: int, here: Array, rng: np.random.Generator
) -> Array | None:
    """Turned by `TURNED` to the left or right."""
    del frame
    for angle in rng.permutation([-TURNED, TURNED]):
        there = compose(here, np.array([0.0, 0.0, angle]))
        if is_free(recorded.scene, BicycleCar(), there[None])[0]:
            return there
    return None


def carried(
    recorded: RecordedWorld, frame: int, here: Array, rng: np.random.Generator
) -> Array | None:
    """Kidnapped to another trajectory, out of sight of all of its own."""
    del here
    own = recorded.poses[recorded.first[frame] : recorded.last[frame] + 1, :2]
    for there in recorded.poses[rng.integers(len(recorded.poses), size=_TRIES)]:
        far = np.linalg.norm(own - there[:2], axis=1).min() > _AWAY
        far &= is_free(recorded.scene, BicycleCar(), there[None])[0]
        if far and not recorded.scene.caster.sees(np.tile(there[:2], (len(own), 1)), own).any():
            return there
    return None


MOVES: dict[str, Move] = {
    "pushed": pushed,
    "turned": turned,
    "carried": carried,
}
"""Disturbances that move the robot."""


def in_the_way(recorded: RecordedWorld, frame: int, robot: int, rng: np.random.Generator) -> Person:
    """A person who walks back and forth across a trajectory, as far as there is room."""
    x, y, heading = recorded.poses[frame]
    across = np.array([-np.sin(heading), np.cos(heading)])
    reach = np.linspace(0.0, _CROSSING, 17)
    sides = []
    for side in (-across, across):
        points = np.array([x, y]) + reach[:, None] * side
        free = recorded.scene.clearance.at(points) > Person.radius
        sides.append(points[max(int(free.cumprod().sum()) - 1, 0)])
    route = np.array(sides)
    walked = rng.uniform(0.0, np.linalg.norm(route[1] - route[0]))
    return Person(route, speed=_WALKING, owner=robot, distance=float(walked))
