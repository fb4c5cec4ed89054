"""How the follower recovers: pushed aside, turned, obstructed by a person, or kidnapped."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.common.statistics import measured_over_worlds
from tutorial_lib.experiments.protocols.following import Guide, ends_of, trajectories
from tutorial_lib.experiments.protocols.local_control import WORLDS
from tutorial_lib.experiments.protocols.moves import MOVES, Disturbance, in_the_way
from tutorial_lib.experiments.protocols.odometry import Odometry
from tutorial_lib.geometry import Array
from tutorial_lib.parallel import for_each
from tutorial_lib.topology.following.transitions import State
from tutorial_lib.world.simulation import STEP

SOON = 5.0
"""Seconds within which a car that was carried away must notice it."""
_WHEN = (0.3, 0.7)  # shares of the trajectory between which the disturbance happens


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
    canary=Settings(trajectories=1),
    accepts=frozenset({"odometry"}),
)
