"""Faults in a building: a path is permanently blocked, or the goal is in another building.

Trials are judged as in Table II: arrival is declared at the goal, facing as it does, within twice
the time of an oracle that knows the detour, and half a minute. A path is only blocked where the
agent's map holds another one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.driving.geodesics import CLEARANCE
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.common.statistics import measured_over_worlds
from tutorial_lib.experiments.protocols.navigation import (
    FACING,
    ONE,
    K,
    experiences,
    goals_of,
    navigate,
    refusals,
    vertex_poses,
)
from tutorial_lib.experiments.protocols.navigation_tasks import (
    PLACES,
    WORLDS,
    Building,
    Trials,
    draw_trials,
    make_building,
)
from tutorial_lib.experiments.protocols.obstacles import APART, path_left, paths_around
from tutorial_lib.learning.views import VIEWS
from tutorial_lib.parallel import for_each
from tutorial_lib.se2 import Array, wrap
from tutorial_lib.world.people import Person
from tutorial_lib.world.simulation import Simulation

DETOUR = 2.5
"""A detour is at most so many times as long as the blocked path."""
_MIDDLE = (0.25, 0.75)  # shares of the path between which it is blocked
_WIDEST = 1.6  # metres to the wall on either side up to which a path can be blocked
_CLOSE = 1.0  # metres
_ELSEWHERE = 10_000  # unknown goals are from the world whose seed is smaller by this


@dataclass(frozen=True)
class Settings:
    """Settings of the faults.

    Attributes:
        places: of a building.
        trials: of each fault in each building.
    """

    places: int = PLACES
    trials: int = 60


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Block the paths of robots, and ask for paths to goals in another building."""
    parts = for_each(run_world, options.worlds, options, settings, label="faults")
    return [_row(fault, [part[fault] for part in parts]) for fault in parts[0]], []


def run_world(world: int, options: Options, settings: Settings) -> dict[str, dict[str, NDArray]]:
    """One world: for each fault, columns (N,) of the outcomes."""
    seed, count = options.seed, settings.trials
    building = make_building(world, seed, settings.places, drifts=options.drifts)
    agent = agents.meng()
    agent.learn(list(experiences(building)))
    trials = draw_trials(building, 3 * count, np.random.default_rng([seed, world, 2]))
    elsewhere = make_building(abs(world - _ELSEWHERE), seed, settings.places)
    strange = draw_trials(elsewhere, count, np.random.default_rng([seed, world, 3]))
    own = trials.subset(np.arange(min(count, len(trials))))
    observations = Simulation(building.scene, own.starts).observe()
    return with_blocked_paths(building, agent, trials, count) | {
        "own_goal": refusals(agent, observations, own),
        "strange_goal": refusals(agent, observations, strange),
    }


def with_blocked_paths(
    building: Building, agent: MengAgent, trials: Trials, count: int
) -> dict[str, dict[str, NDArray]]:
    """The same trials without people, and with people across the path."""
    rows, kept, detours = blockades(building, trials, 2 * count)
    passable = other_paths(building, agent, trials.subset(kept), rows)
    chosen = np.flatnonzero(passable)[:count]
    if not len(chosen):
        nothing = {"reached": np.empty(0), "plans": np.empty(0)}
        return {"none": nothing, "blocked": nothing}
    people = [  # each of whom exists for one robot only
        Person(place[None], speed=0.0, owner=owner)
        for owner, number in enumerate(chosen)
        for place in rows[number]
    ]
    blocked = replace(trials.subset(kept[chosen]), seconds=detours[chosen])
    goals = goals_of(blocked, VIEWS["camera16"], K)
    found = {}
    for fault, there in (("none", []), ("blocked", people)):
        navigation = agent.start(goals)
        outcome = navigate(building, blocked, lambda _, own=navigation: own, there)
        made = [sum(plan.probability > 0 for plan in plans) for plans in navigation.history]
        found[fault] = {"reached": outcome.success, "plans": np.array(made)}
    return found


def other_paths(
    building: Building, agent: MengAgent, trials: Trials, rows: Sequence[Array]
) -> NDArray[np.bool_]:
    """Which trials (N,) have a path on the agent's map that leads through nobody.

    Args:
        building: that was learned.
        agent: with its map.
        trials: N of them.
        rows: for each trial the positions (P, 2) of the people.
    """
    poses = vertex_poses(building, agent.topomap)
    found = np.zeros(len(trials), dtype=bool)
    for trial, (start, goal) in enumerate(zip(trials.starts, trials.goal_poses, strict=True)):
        ends = _close(poses, goal) & (np.abs(wrap(poses[:, 2] - goal[2])) < FACING)
        begins = _close(poses, start)
        found[trial] = path_left(agent.topomap.graph, poses, rows[trial], begins, ends)
    return found


def _close(poses: Array, pose: Array) -> NDArray[np.bool_]:
    """Which poses (V, 3) are so close to one that it is on the map there."""
    return np.linalg.norm(poses[:, :2] - pose[:2], axis=1) < _CLOSE


def blockades(
    building: Building, trials: Trials, count: int
) -> tuple[list[Array], NDArray[np.intp], Array]:
    """People who stand across the oracle's paths, where there is a detour around them.

    Returns:
        For each of M trials the positions (P, 2) of the people; indices (M,) of the trials,
        M <= count; and the seconds (M,) that an oracle needs at its speed which knows of the
        blockade.
    """
    rows, kept, seconds = list[Array](), [], []
    for trial in range(len(trials)):
        if len(kept) == count:
            break
        track = trials.recorded.trajectories[trial].poses
        row = _across(building, track)
        if row is None:
            continue
        ends = track[[0, -1], :2]
        around = paths_around(building, row).between(ends[:1], ends[1:])[0]
        straight = building.paths.between(ends[:1], ends[1:])[0]
        if not straight + 2 * CLEARANCE < around <= DETOUR * straight:
            continue
        rows.append(row)
        kept.append(trial)
        seconds.append(trials.seconds[trial] * around / straight)
    return rows, np.array(kept, dtype=np.intp), np.array(seconds)


def _across(building: Building, track: Array) -> Array | None:
    """Positions (P, 2) of people across a path (T, 3), where it is narrowest; None if too wide."""
    first, last = (round(share * len(track)) for share in _MIDDLE)
    middle = track[first:last]
    x, y, heading = middle[building.scene.clearance.at(middle[:, :2]).argmin()]
    side = np.array([-np.sin(heading), np.cos(heading)])
    steps = np.arange(0.0, _WIDEST, APART / 2)
    places = [np.array([[x, y]])]
    for sign in (-1, 1):
        points = np.array([x, y]) + sign * steps[:, None] * side
        free = building.scene.clearance.at(points) > 0
        if free.all():
            return None
        places.append(points[1 : int(free.argmin())])
    row = np.concatenate(places)
    order = np.argsort((row - [x, y]) @ side)
    return row[order][::2] if len(row) > 2 else row


def _row(fault: str, parts: list[dict[str, NDArray]]) -> dict[str, Any]:
    columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    world = np.repeat(np.arange(len(parts)), [len(next(iter(p.values()))) for p in parts])
    row: dict[str, Any] = {"fault": fault, "goal_images": ONE, "trials": len(world)}
    for name in ("reached", "refused"):
        shares: tuple[float | None, ...] = (None, None, None)
        if name in columns and len(world):
            shares = measured_over_worlds(_mean, world, columns[name].astype(float))
        row |= dict(zip((name, f"{name}_low", f"{name}_high"), shares, strict=True))
    for name in ("plans", "probability"):
        row[name] = _mean(columns[name]) if name in columns and len(world) else None
    return row


def _mean(column: NDArray) -> float:
    return float(column.mean())


EXPERIMENT = Experiment(
    "faults",
    run,
    WORLDS,
    WORLDS[:3],
    Settings(),
    quick_settings=Settings(trials=20),
    canary=Settings(places=5, trials=4),
    accepts=frozenset({"odometry"}),
)
