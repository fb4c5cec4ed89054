"""The one closed loop in which a fleet is driven to goals."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.driving.metrics import REACHED, time_limit
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.world.simulation import STEP, Simulation

SETTLED = 1.0
"""Seconds of standing still after which a robot is taken to stand still for good."""
_STILL = 1e-4  # metres or rad a step
Robots = NDArray[np.intp]
"""(M,) numbers of the robots that are still under way."""
Policy = Callable[[Simulation, Robots], Array]
"""Gives the actions (M, 2) of those robots; see `Simulation.observe` for what they sense."""
Record = Callable[[Simulation, Robots, Array], None]
"""Is shown the simulation before each step, the robots under way and their actions (M, 2)."""


@dataclass(frozen=True)
class Rollouts:
    """How a fleet's drives ended.

    Attributes:
        reached: (N,) the target was reached in time, and nothing was touched.
        collided: (N,) something was touched.
        seconds: (N,) until the drive ended.
        poses: (T, N, 3) where the robots were; one that is done rolls to a stop.
    """

    reached: NDArray[np.bool_]
    collided: NDArray[np.bool_]
    seconds: Array
    poses: Array


def drive(
    simulation: Simulation,
    driver: Policy,
    goals: ArrayLike,
    limit: ArrayLike,
    reached: float = REACHED,
    record: Record | None = None,
    settle: bool = False,
) -> Rollouts:
    """Drive until every robot has reached its goal, touched something or run out of time.

    The driver is asked only for the robots that are still under way; the others stand still.

    Args:
        simulation: N robots at their starts.
        driver: decides.
        goals: (N, 2) metres.
        limit: seconds (N,), or one number for all.
        reached: metres from the goal that count as reached.
        record: looks on.
        settle: end the drive of a robot that stands still for `SETTLED` seconds. A driver without
            memory would leave it there forever, where nothing moves and nothing is noisy.

    Raises:
        InputError: when goals or limits are not finite or not N.
    """
    count = len(simulation)
    goals, limit = np.asarray(goals, dtype=float), np.asarray(limit, dtype=float)
    if goals.shape != (count, 2) or not np.isfinite(goals).all():
        raise InputError(f"drive: goals {goals.shape}; give finite (N, 2) for {count} robots")
    if limit.shape not in ((), (count,)) or not np.isfinite(limit).all():
        raise InputError(f"drive: limit {limit}; give finite seconds for {count} robots")
    arrived, over = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
    seconds, still, track = np.zeros(count), np.zeros(count), [simulation.poses]
    while not over.all():
        robots, actions = np.flatnonzero(~over), np.zeros((count, 2))
        actions[robots] = driver(simulation, robots)
        if record is not None:
            record(simulation, robots, actions[robots])
        simulation.step(actions)
        track.append(simulation.poses)
        gap = np.linalg.norm(simulation.poses[:, :2] - goals, axis=1)
        seconds[robots] += STEP
        arrived |= ~over & ~simulation.collided & (gap < reached)
        over |= arrived | simulation.collided | (seconds >= limit)
        if settle:
            moved = np.abs(track[-1] - track[-2]).max(axis=1) > _STILL
            still = np.where(moved, 0.0, still + STEP)
            over |= still >= SETTLED
    return Rollouts(arrived, simulation.collided & ~arrived, seconds, np.stack(track))


def geodesic_limit(paths: GridPaths, starts: ArrayLike, goals: ArrayLike) -> Array:
    """Seconds (N,) that drives from `starts` (N, 2 or 3) to `goals` (N, 2) may take.

    Raises:
        InputError: when no way leads a robot to its goal.
    """
    starts = np.asarray(starts, dtype=float)[:, :2]
    shortest = paths.fields(goals, shortest=True)
    limit = time_limit(shortest.distance(starts, np.arange(len(starts))))
    for lost in np.flatnonzero(~np.isfinite(limit)):
        raise InputError(f"goal: no way leads robot {lost} to its goal; choose another goal")
    return limit
