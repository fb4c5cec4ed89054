"""Ten visits: every system over the life of a robot in one building (beyond the papers).

A life is ten goals, one after another, from where the robot stands; nothing ever corrects its
odometry but itself. In some lives somebody carries the robot elsewhere before a visit, and in
others the building changes.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.explorers import check_shipped, shipped
from tutorial_lib.experiments.common.own import CUSTOM, or_fault
from tutorial_lib.experiments.common.report import CAR, ROUND, Fault, Options, Rows
from tutorial_lib.experiments.common.statistics import difference, over_worlds
from tutorial_lib.experiments.race.changes import ChangingTask, changed
from tutorial_lib.experiments.race.relocations import Relocations
from tutorial_lib.experiments.race.runners import (
    DRIVING,
    FIELD,
    INGREDIENTS,
    RUNNERS,
    TOURED,
    own_runner,
)
from tutorial_lib.exploration.car_task import CarTask
from tutorial_lib.exploration.episodes import Episodes, draw_sequence, exploration_world
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import SequentialExplorer
from tutorial_lib.parallel import for_each
from tutorial_lib.se2 import wrap
from tutorial_lib.validation import instance
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.worlds import scene_of

WORLDS = tuple(range(20_000, 20_010))
VALIDATION = tuple(range(10_000, 10_010))
APART = (5.0, 10.0)
"""Metres from one goal to the next."""
PASSED, MISSED = 1.0, 2.0
"""Metres up to which a goal was passed on earlier visits, and from which on it was not."""
_AROUND = 1.5  # times as long may the path to a place be that was passed: no wall is between
SOON = 40
"""Actions, of half a second, in which a robot should find itself again."""
WRONG = 1.0
"""Metres by which it is wrong then, from which it found itself elsewhere."""
CARRIED = (3, 6)
"""Visits, counted from 0, before which robots are carried in the lives with a carry."""
STAYS, CHANGED = "stays", "changes"
"""What the building does, in the lives of which it changes in some."""
CHANGES = 5
"""The visit, counted from 0, before which the building changes in the lives where it does."""
PARTS = {"1-3": slice(0, 3), "8-10": slice(7, 10), "1-10": slice(0, 10)}
"""Visits of a row."""


@dataclass(frozen=True)
class Settings:
    """Settings of the race.

    Attributes:
        agents: of `RUNNERS`, the one first to which the others are compared.
        lives: in each world.
        visits: of each life.
        carried: visits before which a robot is carried elsewhere.
        drifts: whether odometry does, and motion is noisy.
        changes: the visit before which the building changes, see `changes`; never unless given.
        body: of the robots, one of `BODIES`; in the lives of cars nothing else happens.
    """

    agents: tuple[str, ...] = FIELD
    lives: int = 3
    visits: int = 10
    carried: tuple[int, ...] = ()
    drifts: bool = True
    changes: int | None = None
    body: str = ROUND


@dataclass(frozen=True, eq=False)
class Life:
    """What became of one agent's lives in one world, all arrays (visits, lives).

    Attributes:
        success: whether the robot stopped at its goal.
        spl: the same, weighted by path length.
        steps: actions.
        near: metres from the goal that it had passed before, at least; infinite on the first visit.
        drift: degrees that its odometry's heading is off at the end of a visit.
        again: actions after a carry until the robot joins its graphs; infinite where it does not,
            not a number where nobody carried it.
        wrong: metres by which it is wrong then.
        strange: metres from where it was put down to where it had been.
    """

    success: Array
    spl: Array
    steps: Array
    near: Array
    drift: Array
    again: Array
    wrong: Array
    strange: Array


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Run all agents through the same lives.

    Raises:
        InputError: where weights are missing, or the user's class cannot be loaded, before anything
            is run.
    """
    check_shipped(("nts", "ans_like", "il"), "rgbd")
    if options.agent:
        own_runner(options.agent)
        settings = replace(settings, agents=(*settings.agents, CUSTOM))
    worlds, kinds = options.worlds, {"": settings}
    if settings.changes is not None:
        known = for_each(drawn, worlds, options, settings, label="buildings")
        worlds = tuple(w for w, (some, *_) in zip(worlds, known, strict=True) if len(some) > 1)
        kinds = {STAYS: replace(settings, changes=settings.visits), CHANGED: settings}
    items = [
        (kind, world, agent) for kind in kinds for agent in settings.agents for world in worlds
    ]
    lives = for_each(run_life, items, options, kinds, label="race")
    found = dict(zip(items, lives, strict=True))
    rows: Rows = []
    faults: list[str] = []
    for kind, agent in product(kinds, settings.agents):
        mine = [found[kind, world, agent] for world in worlds]
        other = (STAYS, agent) if kind else (kind, settings.agents[0])
        first = [found[other[0], world, other[1]] for world in worlds]
        failed = [life for life in mine if isinstance(life, Fault)]
        faults += failed[:1]
        rows += [
            {"agent": agent, "visits": visits}
            | ({"building": kind} if kind else {})
            | _cells(mine, first, part, worlds)
            for visits, part in PARTS.items()
            if worlds and not failed and len(mine[0].success[part])
        ]
    against = "the building that stays" if settings.changes is not None else settings.agents[0]
    return rows, [
        *faults,
        "passed: goals within 1 m of where the robot had been; missed: farther than 2 m",
        f"gap: of {against} to this row, in the same lives",
        "drift: degrees of heading by which odometry is off at the end of the last visit",
    ]


def run_life(
    item: tuple[str, int, str], options: Options, kinds: Mapping[str, Settings]
) -> Life | Fault:
    """One agent's lives in one world; of the user's own agent also how it failed.

    Args:
        item: kind of lives, world and agent.
        options: of the experiment.
        kinds: settings by kind.
    """
    kind, seed, agent = item
    settings = kinds[kind]
    task, later, goals, carries = begun(seed, options, settings)
    own = _stream(seed, options, 2)
    carried = {visit: carries[visit] for visit in settings.carried}
    rebuilt = {visit: later[0] for visit in (settings.changes,) if visit is not None}
    if agent == CUSTOM:
        return or_fault(
            options.agent,
            lambda: live(task, own_runner(options.agent), goals, carried, rebuilt),
        )
    return live(task, RUNNERS[agent](task, shipped("nts", "rgbd"), own), goals, carried, rebuilt)


def begun(
    seed: int, options: Options, settings: Settings
) -> tuple[ExplorationTask, list[Scene], Array, Array]:
    """The robots in the world of that seed; the scene that it changes to, goals and carries.

    See `drawn`.
    """
    (scene, *later), goals, carries = drawn(seed, options, settings)
    name, starts = exploration_world(seed, "plain", options.palette), carries[0]
    lengths = GridPaths(scene.clearance).between(starts[:, :2], goals[0][:, :2])
    blank = ("",) * settings.lives
    episodes = Episodes((name,) * settings.lives, starts, goals[0], lengths, blank)
    make_task = CarTask if settings.body == CAR else ChangingTask
    noise = _stream(seed, options, 1)
    task = make_task({name: scene}, episodes, noise, noise=settings.drifts)
    return task, later, goals, carries


def drawn(
    seed: int, options: Options, settings: Settings
) -> tuple[tuple[Scene, ...], Array, Array]:
    """The world of that seed, as it is or before and after it changes, and its lives' goals.

    Where no change is possible, there is one scene only; goals and carries see `draw_lives`.
    """
    scene = scene_of(exploration_world(seed, "plain", options.palette))
    goals, carries = draw_lives(scene, settings, _stream(seed, options))
    if settings.changes is None:
        return (scene,), goals, carries
    stops = np.concatenate([carries[:1], goals])[..., :2]
    return changed(scene, stops, _stream(seed, options, 3)) or (scene,), goals, carries


def _stream(seed: int, options: Options, *number: int) -> np.random.Generator:
    return np.random.default_rng([options.seed, seed, *number])


def draw_lives(scene: Scene, settings: Settings, rng: np.random.Generator) -> tuple[Array, Array]:
    """Goals (V, N, 3), and poses (V, N, 3) to which robots may be carried; they start at the first.

    Each goal is `APART` from the one before, and so is each place from the goal of its visit.
    """
    count = settings.lives
    points = GridPaths(scene.clearance)
    free = points.points[points.largest]
    drawn = free[rng.integers(len(free), size=count)]
    first = np.column_stack([drawn, rng.uniform(-np.pi, np.pi, count)])
    chain = draw_sequence(scene, first, settings.visits + 1, rng, APART)
    goals = chain[1:]
    carries = np.stack([draw_sequence(scene, one, 2, rng, APART)[1] for one in goals])
    carries[0] = first
    return goals, carries


def live(
    task: ExplorationTask,
    agent: SequentialExplorer,
    goals: Array,
    carries: Mapping[int, Array] | None = None,
    rebuilt: Mapping[int, Scene] | None = None,
) -> Life:
    """Let an agent look for goals (V, N, 3) one after another.

    Args:
        task: all robots in one world; a `ChangingTask` where that is rebuilt.
        agent: that drives them.
        goals: of each visit.
        carries: by visit, where robots are carried before it.
        rebuilt: by visit, the building as it is from then on.
    """
    carries, rebuilt = carries or {}, rebuilt or {}
    (scene,) = task.scenes.values()
    paths, columns, watch = GridPaths(scene.clearance), [], Relocations(task, agent)
    agent.start(task.goals())
    for visit, poses in enumerate(goals):
        if visit in rebuilt:
            instance("task", task, ChangingTask).rebuild(rebuilt[visit])
        before = np.stack(task.path)
        strange = np.full(len(task), np.nan)
        if visit in carries:
            task.carry(carries[visit])
            strange = np.linalg.norm(before[:, :, :2] - task.poses[:, :2], axis=2).min(axis=0)
        watch.begin(carried=visit in carries)
        if visit:
            task.next_goals(poses)
            agent.look_for(task.goals())
        near = _nearest(paths, before if visit else before[:0], poses)
        while not task.done.all():
            actions = agent.act(task.observe(), ~task.done)
            watch.look()
            task.step(actions)
        off = wrap(task.odometry[:, 2] - (task.poses[:, 2] - task.path[0][:, 2]))
        seen = near, np.rad2deg(np.abs(off)), watch.again, watch.wrong, strange
        columns.append((task.success, task.spl, task.steps, *seen))
    return Life(*(np.array(column, float) for column in zip(*columns, strict=True)))


def _nearest(paths: GridPaths, tracks: Array, goals: Array) -> Array:
    """Metres (N,) from goals (N, 3) to what robots passed, (T, N, 3); infinite behind a wall."""
    near = np.full(len(goals), np.inf)
    for robot in range(len(goals) if len(tracks) else 0):
        gaps = np.linalg.norm(tracks[:, robot, :2] - goals[robot, :2], axis=1)
        best = int(gaps.argmin())
        (metres,) = paths.between(tracks[best, robot, None, :2], goals[robot, None, :2])
        near[robot] = gaps[best] if metres <= max(_AROUND * gaps[best], PASSED) else np.inf
    return near


def _cells(
    mine: list[Life], first: list[Life], part: slice, worlds: tuple[int, ...]
) -> dict[str, Any]:
    """An agent's visits of one part of its lives."""

    def column(lives: list[Life], name: str) -> Array:
        return np.concatenate([getattr(life, name)[part].ravel() for life in lives])

    where: NDArray = np.repeat(worlds, [life.success[part].size for life in mine])
    success, near = column(mine, "success"), column(mine, "near")
    row: dict[str, Any] = {"goals": len(success)}
    row |= dict(zip(("success", "low", "high"), over_worlds(success, where), strict=True))
    row |= {"spl": float(column(mine, "spl").mean()), "steps": float(column(mine, "steps").mean())}
    for name, there in (("passed", near <= PASSED), ("missed", near > MISSED)):
        row[f"{name}_goals"] = int(there.sum())
        row[name] = float(success[there].mean()) if there.any() else None
        row[f"{name}_spl"] = float(column(mine, "spl")[there].mean()) if there.any() else None
    gap = difference(column(first, "success"), success, where)
    row |= dict(zip(("gap", "gap_low", "gap_high"), gap, strict=True))
    row |= {"drift": float(np.mean([life.drift[-1] for life in mine]))}
    return row | _relocated(column(mine, "again"), column(mine, "wrong"), column(mine, "strange"))


def _relocated(again: Array, wrong: Array, strange: Array) -> dict[str, Any]:
    """How often a robot that was carried found itself again, and how often wrongly."""
    carried = np.isfinite(strange)
    known = carried & (strange <= MISSED)
    joined = carried & np.isfinite(again)

    def soon(which: NDArray[np.bool_]) -> float | None:
        watched = which & ~np.isnan(again)
        return float((again[watched] <= SOON).mean()) if watched.any() else None

    return {
        "carried": int(carried.sum()),
        "again": soon(carried),
        "carried_known": int(known.sum()),
        "again_known": soon(known),
        "again_wrong": float((wrong[joined] > WRONG).mean()) if joined.any() else None,
    }


_ABLATIONS = {
    "car": (  # pymunk takes ten times as long
        WORLDS,
        Settings(DRIVING, lives=2, body=CAR),
        Settings(("combined",), 1, 2, body=CAR),
    ),
    "carried": (
        WORLDS,
        Settings(("combined", "nts_forgets"), carried=CARRIED),
        Settings(("combined",), 1, 2, (1,)),
    ),
    "changed": (
        tuple(range(20_000, 20_014)),  # nine of them can change
        Settings(("combined", "nts_forgets", "ans_corrected"), changes=CHANGES),
        Settings(("combined",), 1, 2, changes=1),
    ),
    "exact": (
        WORLDS,
        Settings(("combined", "nts"), drifts=False),
        Settings(("combined",), 1, 2, drifts=False),
    ),
    "ingredients": (VALIDATION, Settings(INGREDIENTS), Settings(("no_closing",), 1, 2)),
    "toured": (WORLDS, Settings(TOURED), Settings(("meng_toured",), 1, 2)),
}
"""Worlds, settings, and those of the canary."""
EXPERIMENT = Experiment(
    "race",
    run,
    WORLDS,
    WORLDS[:3],
    Settings(),
    quick_settings=Settings(lives=2),
    canary=Settings(("combined", "nts"), 1, 2),
    accepts=frozenset({"palette", "agent"}),
    ablations={
        name: Experiment(f"race_{name}", run, worlds, worlds[:4], settings, canary=few)
        for name, (worlds, settings, few) in _ABLATIONS.items()
    },
)
