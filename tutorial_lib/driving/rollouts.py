"""The one closed loop: observe, act, step, until every robot's rollout has ended."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.array_forms import quoted
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.driving.metrics import REACHED, time_limit
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Navigation, Observation, Policy, Robots
from tutorial_lib.validation import (
    alike,
    flag,
    flags,
    floats,
    instance,
    number,
    whole,
    with_methods,
)
from tutorial_lib.world.simulation import STEP, Simulation, checked_actions

SETTLED = 1.0
"""Seconds of standing still after which a robot is taken to stand still for good."""
STUCK = 2.0
"""Seconds of touching something after which a navigation ends."""
_STILL = 1e-4  # metres or rad a step
Record = Callable[[Simulation, Robots, Observation, Array], None]
"""Called before each step: the simulation, the robots under way, what they observe, and their
actions (M, 2)."""


class Ends(Protocol):
    """When rollouts end, and how."""

    def after_step(
        self, simulation: Simulation, seconds: Array, before: Array
    ) -> Mapping[str, NDArray[np.bool_]]:
        """Called after each step.

        Args:
            simulation: N robots.
            seconds: (N,) that each rollout has taken.
            before: (N, 3) poses before the step.

        Returns:
            For each ending, which robots (N,) it holds for; of several the last one counts.
        """


@dataclass(frozen=True)
class Rollouts:
    """How a fleet's rollouts ended.

    Attributes:
        ending: (N,) names, as the `Ends` have them.
        collided: (N,) something was touched, and the target not reached.
        seconds: (N,) until the end.
        poses: (T, N, 3) of the robots; one whose rollout has ended rolls to a stop.
    """

    ending: NDArray[np.str_]
    collided: NDArray[np.bool_]
    seconds: Array
    poses: Array

    @property
    def reached(self) -> NDArray[np.bool_]:
        """(N,) the target was reached in time, and nothing was touched."""
        return self.ending == "reached"

    @property
    def last_poses(self) -> Array:
        """(N, 3) where each rollout ended."""
        steps = np.rint(self.seconds / STEP).astype(int)
        return self.poses[steps, np.arange(len(steps))]


def rollout(
    simulation: Simulation, policy: Policy, ends: Ends, record: Record | None = None
) -> Rollouts:
    """Drive a fleet until every rollout has ended.

    Only the robots that are still under way observe and act; the others stand still.

    Args:
        simulation: N robots at their starts.
        policy: chooses actions.
        ends: decides when a rollout is over.
        record: is shown every step before it is made.

    Raises:
        InputError: when the policy returns anything but finite (M, 2), `ends` anything but names
            with truth values (N,), or a navigation that ends the rollouts has more or fewer robots,
            has arrived before it begins, or is not the one that drives.
    """
    count = len(instance("simulation", simulation, Simulation))
    with_methods("policy", policy, "act")
    if isinstance(ends, NavigationEnds):
        ends.check_start(policy, count)
    with_methods("ends", ends, "after_step")
    if record is not None and not callable(record):
        raise InputError(f"record: {record!r}; give a function")
    ending, over = np.full(count, "", dtype=object), np.zeros(count, dtype=bool)
    seconds, poses = np.zeros(count), [simulation.poses]
    while not over.all():
        robots, actions = np.flatnonzero(~over), np.zeros((count, 2))
        observations = simulation.observe(robots)
        actions[robots] = checked_actions(policy.act(observations, robots), len(robots))
        if record is not None:
            record(simulation, robots, observations, actions[robots])
        simulation.step(actions)
        poses.append(simulation.poses)
        seconds[robots] += STEP
        endings = instance("after_step", ends.after_step(simulation, seconds, poses[-2]), Mapping)
        for name, ended in endings.items():
            if not (isinstance(name, str) and name):
                raise InputError(f"after_step: an ending {name!r}; give it a name")
            ending[flags(f"after_step: {name}", ended, (count,)) & ~over] = name
        over = ending != ""
    collided = simulation.collided & (ending != "reached")
    return Rollouts(ending.astype(str), collided, seconds, np.stack(poses))


class ReachGoals:
    """A rollout ends at its goal ("reached"), at a touch ("collided"), or when time is up ("late").

    With `settle` also when the robot stands still for `SETTLED` seconds ("settled"): a policy
    without memory would leave it there forever, where nothing moves and nothing is noisy.
    """

    def __init__(
        self, goals: ArrayLike, limit: ArrayLike, reached: float = REACHED, settle: bool = False
    ) -> None:
        """Set the goals.

        Args:
            goals: (N, 2) metres.
            limit: seconds (N,), or one number for all.
            reached: metres from the goal that count as reached.
            settle: see above.

        Raises:
            InputError: when goals or limits are not finite, or do not fit each other.
        """
        self.goals, self.limit = floats("goals", goals, ("N", 2)), floats("limit", limit, least=0)
        count = len(self.goals)
        if self.limit.shape not in ((), (count,)):
            raise InputError(f"limit: shape {self.limit.shape}; give seconds for {count} goals")
        self.reached, self.settle = number("reached", reached, above=0), flag("settle", settle)
        self._still = np.zeros(count)

    def after_step(
        self, simulation: Simulation, seconds: Array, before: Array
    ) -> dict[str, NDArray[np.bool_]]:
        """See `Ends`."""
        count = len(self.goals)
        if len(instance("simulation", simulation, Simulation)) != count:
            raise InputError(
                f"goals: {count} for {len(simulation)} robots of the simulation; give as many"
            )
        seconds = floats("seconds", seconds, (count,), least=0)
        before = floats("before", before, (count, 3))
        poses = simulation.poses
        gap = np.linalg.norm(poses[:, :2] - self.goals, axis=1)
        moved = np.abs(poses - before).max(axis=1) > _STILL
        self._still = np.where(moved, 0.0, self._still + STEP)
        return {
            "settled": self.settle & (self._still >= SETTLED),
            "late": seconds >= self.limit,
            "collided": simulation.collided,
            "reached": ~simulation.collided & (gap < self.reached),
        }


class NavigationEnds:
    """A rollout ends when the robot itself declares it ("arrived" or "gave_up"), or else.

    It is "stuck" when it touches something for `STUCK` seconds, and "late" when time is up.
    """

    def __init__(self, navigation: Navigation, limit: ArrayLike) -> None:
        """Watch a navigation for at most `limit` seconds: (N,), or one number for all.

        Raises:
            InputError: when it is no `Navigation`, or limits are no numbers from 0 on.
        """
        self._navigation = with_methods("navigation", navigation, "act")
        if not (hasattr(navigation, "arrived") and hasattr(navigation, "given_up")):
            raise InputError(
                f"navigation: {quoted(navigation)}; give an object that has arrived and given_up"
            )
        self._limit = floats("limit", limit, least=0.0)
        self._touched = np.zeros(())

    def check_start(self, policy: Policy, count: int) -> None:
        """Refuse a navigation that cannot drive the `count` robots of a simulation.

        Raises:
            InputError: when it is of more or fewer robots, one has arrived already, or the policy
                that drives is another navigation.
        """
        whole("count", count, least=0)
        arrived = self._navigation.arrived
        if np.ndim(arrived):  # else it knows of its robots from the first step on
            if np.size(arrived) != count:
                raise InputError(
                    f"count of robots: {count} in the simulation, {np.size(arrived)} in the "
                    "navigation"
                )
            if flags("arrived", arrived, (count,)).any():
                raise InputError("navigation: arrived before it begins; start a new one each time")
        if hasattr(policy, "arrived") and policy is not self._navigation:
            raise InputError(
                f"policy: {quoted(policy)} is another navigation than `ends` watches; "
                "give the same to both"
            )

    def after_step(
        self, simulation: Simulation, seconds: Array, before: Array
    ) -> dict[str, NDArray[np.bool_]]:
        """See `Ends`."""
        del before
        count = len(instance("simulation", simulation, Simulation))
        seconds = floats("seconds", seconds, (count,), least=0)
        if self._limit.shape not in ((), (count,)):
            raise InputError(f"limit: shape {self._limit.shape}; give seconds for {count} robots")
        self._touched = np.where(simulation.touching, self._touched + STEP, 0.0)
        return {
            "late": seconds >= self._limit,
            "stuck": self._touched >= STUCK - STEP / 2,
            "gave_up": flags("given_up", self._navigation.given_up, (count,)),
            "arrived": flags("arrived", self._navigation.arrived, (count,)),
        }


def geodesic_limit(paths: GridPaths, starts: ArrayLike, goals: ArrayLike) -> Array:
    """Seconds (N,) that rollouts from `starts` (N, 2 or 3) to `goals` (N, 2) may take.

    Raises:
        InputError: when a goal cannot be reached.
    """
    starts = floats("starts", starts, ("N", "2 or 3"))
    if starts.shape[1] < 2:
        raise InputError(f"starts: shape {starts.shape}; give x and y of each")
    goals = floats("goals", goals, ("N", 2))
    alike(starts=starts, goals=goals)
    shortest = instance("paths", paths, GridPaths).fields(goals, shortest=True)
    limit = time_limit(shortest.distance(starts[:, :2], np.arange(len(starts))))
    for lost in np.flatnonzero(~np.isfinite(limit)):
        raise InputError(
            f"goals: no path leads from starts[{lost}] to goals[{lost}]; choose others"
        )
    return limit
