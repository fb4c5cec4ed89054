"""How the follower recovers: pushed aside, turned, obstructed by a person, or kidnapped."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.metrics import REACHED
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.common.statistics import measured_over_worlds
from tutorial_lib.experiments.protocols.following import Guide, ends_of, trajectories
from tutorial_lib.experiments.protocols.local_control import WORLDS
from tutorial_lib.experiments.protocols.odometry import Odometry
from tutorial_lib.geometry import Array, compose
from tutorial_lib.interfaces import Robots
from tutorial_lib.parallel import for_each
from tutorial_lib.topology.following.transitions import State
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.people import Person
from tutorial_lib.world.placing import is_free
from tutorial_lib.world.simulation import STEP, Simulation

ASIDE, TURNED = 0.5, np.deg2rad(40.0)
"""Metres and rad by which cars are moved."""
SOON = 5.0
"""Seconds within which a car that was carried away must notice it."""
_WHEN = (0.3, 0.7)  # shares of the trajectory between which the disturbance happens
_AWAY = 4.0  # metres from its trajectory to where a car is carried, out of sight of all of it
_TRIES = 400
_CROSSING = 0.8  # metres that a person walks to either side of the trajectory
_WALKING = 0.25  # m/s

Move = Callable[[RecordedWorld, int, Array, np.random.Generator], "Array | None"]
"""Returns where to put a robot, given the recorded frame that it passes and its pose; None where
there is no such place."""


@dataclass(frozen=True)
class Settings:
    """Settings of the disturbances.

    Attributes:
        context: of C and RE.
        threshold: p_sparsify.
        trajectories: in each world.
    """

    context: str = "k2"
    threshold: float = 0.99
    trajectories: int = 8


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Follow the same trajectories with every disturbance."""
    parts = for_each(run_world, options.worlds, options, settings, label="disturbances")
    return [_row(kind, [part[kind] for part in parts]) for kind in parts[0]], []


def run_world(world: int, options: Options, settings: Settings) -> dict[str, dict[str, Array]]:
    """Every disturbance in one world; each value is (N,) over its trajectories.

    Every robot counts, also one that was lost before it could be disturbed.
    """
    rng = np.random.default_rng([options.seed, world])
    recorded = trajectories(world, settings.trajectories, rng)
    odometry = Odometry(options.drifts, (options.seed, world))
    guide = Guide(recorded, settings.context, odometry)
    paths = [guide.anchors(i, settings.threshold) for i in range(len(recorded.trajectories))]
    ends = ends_of(paths)
    length = recorded.arc[ends[:, 1]] - recorded.arc[ends[:, 0]]
    due = recorded.arc[ends[:, 0]] + rng.uniform(*_WHEN, len(paths)) * length
    middle = np.searchsorted(recorded.arc, due)
    found = {}
    for kind, move in {"none": None, **MOVES}.items():
        moving = Disturbance(recorded, middle, move, rng)
        success, log = guide.deliver(paths, disturb=moving)
        found[kind] = _outcomes(success, log.state, moving.step)
    people = [in_the_way(recorded, frame, robot, rng) for robot, frame in enumerate(middle)]
    passing = Disturbance(recorded, middle, None, rng)
    success, log = guide.deliver(paths, people, passing)
    return {**found, "person": _outcomes(success, log.state, passing.step)}


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


def _outcomes(
    success: NDArray[np.bool_], state: NDArray[np.int8], step: NDArray[np.intp]
) -> dict[str, Array]:
    """How every rollout ended (N,); a robot that was not disturbed counts as well.

    Args:
        success: (N,) see `Guide.deliver`.
        state: (T, N) of the robots.
        step: (N,) at which they were disturbed, -1 for never.
    """
    lost = state == State.LOST
    when = np.where(lost.any(axis=0), lost.argmax(axis=0), len(state))
    since = STEP * (when - step)
    columns = {
        "finished": success,
        "disturbed": step >= 0,
        "lost": lost[-1],
        "soon": (step >= 0) & lost[-1] & (since <= SOON),
        "seconds": since,
    }
    return {name: column.astype(float) for name, column in columns.items()}


def _row(kind: str, parts: list[dict[str, Array]]) -> dict[str, Any]:
    world = np.repeat(np.arange(len(parts)), [len(part["lost"]) for part in parts])
    joined = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    disturbed = joined["disturbed"] > 0
    lost = disturbed & (joined["lost"] > 0)
    row: dict[str, Any] = {"disturbance": kind, "trajectories": len(world)}
    row["disturbed"] = int(disturbed.sum())
    for name, mine in (("finished", np.ones(len(world), bool)), ("soon", disturbed)):
        shares = (None, None, None)  # if there was nowhere to put a robot
        if mine.any():
            shares = measured_over_worlds(_mean, world[mine], joined[name][mine])
        row |= dict(zip((name, f"{name}_low", f"{name}_high"), shares, strict=True))
    row["lost"] = _mean(joined["lost"])
    row["seconds"] = float(np.median(joined["seconds"][lost])) if lost.any() else None
    return row


def _mean(column: Array) -> float:
    return float(column.mean())


EXPERIMENT = Experiment(
    "disturbances",
    run,
    WORLDS,
    WORLDS[:4],
    Settings(),
    quick_settings=Settings(trajectories=4),
    accepts=frozenset({"odometry"}),
)
