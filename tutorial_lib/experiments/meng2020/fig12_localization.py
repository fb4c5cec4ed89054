"""The Bayes filter by itself: driven along, standing still, and carried to another room.

An oracle drives robots through offices with look-alike rooms, and the filter follows what they see
and what their wheels measure. Some are carried to another room on the way; no odometer notices.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.oracle import OracleNavigation
from tutorial_lib.agents.place_guess import PlaceGuess
from tutorial_lib.driving.rollouts import rollout
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.common.statistics import measured_over_worlds
from tutorial_lib.experiments.protocols.lookalikes import (
    Office,
    draw_ambiguous_trials,
    make_office,
)
from tutorial_lib.experiments.protocols.navigation import experiences, vertex_poses
from tutorial_lib.experiments.protocols.navigation_tasks import Trials
from tutorial_lib.experiments.protocols.odometry import NAVIGATING
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Observation, Robots
from tutorial_lib.parallel import for_each
from tutorial_lib.world.simulation import STEP, Simulation

RIGHT = 2.5
"""Metres of geodesic to the vertex within which a robot is localized rightly."""
SURE = 0.9
"""Belief of being near the vertex from which on the filter is sure."""
NOTICED, FOUND = 5.0, 20.0
"""Seconds within which a carried robot should notice, and be localized again."""
CASES = ("driven", "doors", "standstill", "kidnapped")
"""Driven by the oracle; of that, in corridors that have a twin; still; carried away."""


@dataclass(frozen=True)
class Settings:
    """Settings of the localization study.

    Attributes:
        robots: in each office; every other one is carried away.
        before: seconds of driving before.
        after: seconds of driving after.
        still: seconds of standing still.
    """

    robots: int = 40
    before: float = 12.0
    after: float = 20.0
    still: float = 60.0


@dataclass(frozen=True, eq=False)
class Looks:
    """What the filter believed, T times of N robots.

    Attributes:
        vertex: (T, N) column, -1 off the map.
        sure: (T, N) belief of being near that vertex.
        gap: (T, N) metres to it; infinite off the map.
        poses: (T, N, 3) of the robots.
    """

    vertex: NDArray[np.intp]
    sure: Array
    gap: Array
    poses: Array


class _Watch:
    """Lets the filter look at each step, and carries robots away once."""

    def __init__(
        self, guess: PlaceGuess, limit: float, carried: Robots, to: Array, when: float
    ) -> None:
        self._guess, self._limit, self._when = guess, limit, when
        self._carried, self._to = carried, to
        self.vertex: list[NDArray[np.intp]] = []
        self.sure: list[Array] = []

    def record(
        self, simulation: Simulation, robots: Robots, observations: Observation, actions: Array
    ) -> None:
        """See `driving.rollouts.Record`."""
        del actions
        self._guess.observe(observations, robots)
        self.vertex.append(self._guess.filter.vertex.copy())
        self.sure.append(self._guess.confidence())
        if len(self._carried) and abs(simulation.seconds - self._when) < STEP / 2:
            simulation.place(self._carried, self._to)

    def after_step(
        self, simulation: Simulation, seconds: Array, before: Array
    ) -> dict[str, NDArray[np.bool_]]:
        """See `driving.rollouts.Ends`."""
        del simulation, before
        return {"over": seconds >= self._limit - STEP / 2}


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Drive, stand still, and carry robots away, in every office."""
    parts = for_each(run_world, options.worlds, options, settings, label="meng_fig12")
    return [_row(case, [part[case] for part in parts]) for case in CASES], []


def run_world(world: int, options: Options, settings: Settings) -> dict[str, dict[str, NDArray]]:
    """One office: for each case its measures, a column each."""
    office = make_office(world, options.seed, drifts=options.drifts)
    agent = agents.remedied("all")
    agent.learn(list(experiences(office.building)))
    rng = np.random.default_rng([options.seed, world, 9])
    trials = draw_ambiguous_trials(office, settings.robots, rng)
    places = vertex_poses(office.building, agent.topomap)[agent.topomap.alive]
    driven = _watched(office, trials, agent.guess(len(trials)), places, settings)
    still = _watched(office, trials, agent.guess(len(trials)), places, settings, moves=False)
    return _measured(office, driven, still, settings)


def _watched(
    office: Office,
    trials: Trials,
    guess: PlaceGuess,
    places: Array,
    settings: Settings,
    moves: bool = True,
) -> Looks:
    """What the filter believes of robots that an oracle drives, or that stand still."""
    building = office.building
    odometry = building.odometry.noise(NAVIGATING)
    simulation = Simulation(building.scene, trials.starts, odometry_noise=odometry)
    policy: Any = OracleNavigation(simulation, building.paths, trials.goal_poses)
    carried = np.arange(1, len(trials), 2) if moves else np.empty(0, dtype=int)
    watch = _Watch(
        guess,
        settings.before + settings.after if moves else settings.still,
        carried,
        _elsewhere(office, trials)[carried],
        settings.before,
    )
    found = rollout(simulation, policy if moves else _Still(), watch, watch.record)
    vertex, poses = np.array(watch.vertex), found.poses[: len(watch.vertex)]
    there = np.broadcast_to(places[vertex], (*vertex.shape, 3))
    gap = building.paths.between(poses[..., :2].reshape(-1, 2), there[..., :2].reshape(-1, 2))
    gap = np.where(vertex < 0, np.inf, gap.reshape(vertex.shape))
    return Looks(vertex, np.array(watch.sure), gap, poses)


class _Still:
    """Stands still."""

    def act(self, observations: Observation, robots: Robots) -> Array:
        """Actions (M, 2) of zero."""
        del observations
        return np.zeros((len(robots), 2))


def _elsewhere(office: Office, trials: Trials) -> Array:
    """(N, 3) for each trial a pose to be carried to: in a room of another kind than its own.

    Recorded trajectories begin there; its goal is elsewhere. To be carried to an exact twin
    cannot be noticed.
    """
    building, kind = office.building, office.group[office.rooms]
    begins = building.pairs[:, 0]
    poses = building.recorded.poses[building.recorded.first_frames]
    found = np.empty((len(trials), 3))
    for trial, (start, goal) in enumerate(trials.pairs):
        others = np.flatnonzero((kind[begins] != kind[start]) & (begins != goal))
        others = others if others.size else np.flatnonzero(begins != start)
        found[trial] = poses[others[trial % len(others)]]
    return found


def _measured(
    office: Office, driven: Looks, still: Looks, settings: Settings
) -> dict[str, dict[str, NDArray]]:
    """The measures of each case."""
    begin, stays = round(settings.before / STEP), slice(0, None, 2)
    right, sure = driven.gap <= RIGHT, driven.sure >= SURE
    own = driven.poses[:, stays]
    alike = np.bincount(office.group)[office.group] > 1
    halls = [
        room
        for room, twin in zip(office.building.scene.plan.rooms, alike, strict=True)
        if twin and room.kind == "hallway"
    ]
    inside = np.zeros(own.shape[:2], dtype=bool)
    for room in halls:
        inside |= room.contains(own[..., :2])
    calm = still.vertex[round(1.0 / STEP) :]
    carried = slice(1, None, 2)
    after = driven.gap[begin + 1 :, carried], driven.vertex[begin + 1 :, carried]
    noticed = (after[1] < 0) | (after[0] <= RIGHT)
    within = [round(limit / STEP) for limit in (NOTICED, FOUND)]
    return {
        "driven": {"right": right[:, stays].ravel(), "sure": sure[:, stays].ravel()},
        "doors": {"right": right[:, stays][inside], "sure": sure[:, stays][inside]},
        "standstill": {"changes": (np.diff(calm, axis=0) != 0).sum(axis=0)},
        "kidnapped": {
            "noticed": np.any(noticed[: within[0]], axis=0),
            "found": np.any((after[0] <= RIGHT)[: within[1]], axis=0),
        },
    }


def _row(case: str, parts: list[dict[str, NDArray]]) -> dict[str, Any]:
    """A line of the table: shares with intervals over worlds, None where a case has none."""
    columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    world = np.repeat(np.arange(len(parts)), [len(next(iter(p.values()))) for p in parts])
    every = np.ones(len(world), dtype=bool)
    measures = {
        "right": (columns.get("right"), every),
        "sure": (columns.get("sure"), every),
        "right_if_sure": (columns.get("right"), columns.get("sure", every).astype(bool)),
        "changes_at_most_once": (columns["changes"] <= 1 if "changes" in columns else None, every),
        "noticed": (columns.get("noticed"), every),
        "found": (columns.get("found"), every),
    }
    row: dict[str, Any] = {"case": case, "count": len(world)}
    for name, (values, kept) in measures.items():
        shares: tuple[float | None, ...] = (None, None, None)
        if values is not None and kept.any():
            shares = measured_over_worlds(_mean, world[kept], values[kept].astype(float))
        row |= dict(zip((name, f"{name}_low", f"{name}_high"), shares, strict=True))
    return row


def _mean(column: NDArray) -> float:
    return float(column.mean())


EXPERIMENT = Experiment(
    "meng_fig12_localization",
    run,
    tuple(range(20_000, 20_010)),
    tuple(range(20_000, 20_003)),
    Settings(),
    quick_settings=Settings(robots=10),
    canary=Settings(robots=2),
    accepts=frozenset({"odometry"}),
)
