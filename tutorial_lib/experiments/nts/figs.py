"""Figs. 3, 4, 9 and 10 of Chaplot et al. 2020: what the functions predict, and whole episodes.

The places are chosen by the geometry and the seed, never by what a network makes of them.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.nts import NTSAgent
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.explorers import check_shipped, make_explorer, shipped
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.nts.figs_pictures import pictures
from tutorial_lib.experiments.protocols.exploration import WORLDS
from tutorial_lib.experiments.protocols.ghost_moments import GhostMoment, ghost_moment
from tutorial_lib.exploration.bearings import DIRECTIONS
from tutorial_lib.exploration.episodes import (
    DIFFICULTIES,
    Episodes,
    draw_episodes,
    exploration_world,
)
from tutorial_lib.exploration.labels import MAX_DISTANCE, PanoramaLabels
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.exploration.true_geometry import TrueGeometry
from tutorial_lib.files import write_files
from tutorial_lib.interfaces import ExplorationModel
from tutorial_lib.learning.exploration_data import random_poses
from tutorial_lib.parallel import for_each
from tutorial_lib.se2 import Array, to_world
from tutorial_lib.viz.figures.film import exact_png
from tutorial_lib.world.floorplan import ROOM_KINDS
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.worlds import scene_of

_APART = 3  # bins between the best directions towards two goals, at least
_LOOKS = (0.0, 0.33, 0.66, 1.0)  # share of an episode's steps at which Fig. 9 shows the graph
NUMBERS = (
    *("agree", "chosen", "best", "regret"),
    *("success", "spl", "steps", "travelled", "nodes"),
)
"""Columns of every row, None where its figure has none of it."""
LISTS = ("pose", "goal", "explorable", "scores", "truth", "track", "moments")
"""The same for what pictures are drawn from, which only the JSON holds; places are the world's."""


@dataclass(frozen=True)
class Settings:
    """Settings of the figures.

    Attributes:
        panoramas: of Fig. 3, in each world.
        signs: of the worlds; with signs, scores have something to go by.
        places: among which the source of Figs. 4 and 10 is looked for, and half as many goals.
        geometry: the true geometry stands in for the network.
    """

    panoramas: int = 2
    signs: str = "wayfinding"
    places: int = 60
    geometry: bool = False


@dataclass(frozen=True, eq=False)
class Place:
    """A world, how to run in it, and the seed of what is random in it."""

    name: str
    scene: Scene
    settings: Settings
    seed: tuple[int, int]

    def task(self, episodes: Episodes, *, noise: bool = True) -> ExplorationTask:
        """The task of these episodes."""
        rng = np.random.default_rng([*self.seed, 1])
        return ExplorationTask({self.name: self.scene}, episodes, rng, noise=noise)

    def episodes(self, starts: Array, goals: Array, shortest: Array) -> Episodes:
        """Episodes from `starts` (N, 3) to `goals` (N, 3), with their shortest paths (N,)."""
        count = len(starts)
        return Episodes((self.name,) * count, starts, goals, shortest, ("",) * count)

    def model(self, task: ExplorationTask) -> ExplorationModel:
        """The network, or what stands in for it."""
        return TrueGeometry(task) if self.settings.geometry else shipped("nts", "rgbd")

    def row(self, figure: int, case: int, what: str, **values: Any) -> dict[str, Any]:  # noqa: ANN401
        """A row in which what is not given is None, and arrays are lists."""
        shown = {key: _listed(v) if isinstance(v, np.ndarray) else v for key, v in values.items()}
        head = {"figure": figure, "world": self.name, "case": case, "what": what}
        return head | dict.fromkeys(NUMBERS) | {name: [] for name in LISTS} | shown


def outcome_of(task: ExplorationTask, row: int) -> dict[str, Any]:
    """How an episode went."""
    return {
        "success": bool(task.success[row]),
        "spl": round(float(task.spl[row]), 3),
        "steps": int(task.steps[row]),
        "travelled": round(float(task.travelled[row]), 2),
        "track": np.array(task.path[: int(task.steps[row]) + 1])[:, row, :2],
    }


def in_world(moment: GhostMoment, start: Array) -> dict[str, Any]:
    """A graph as lists; odometry 0 is `start` (3,), so that it can be drawn on the plan."""
    return {
        "nodes": to_world(start, moment.nodes).round(3).tolist(),
        "edges": [list(edge) for edge in moment.edges],
        "ghosts": to_world(start, moment.ghosts).round(3).tolist(),
        "hosts": moment.hosts.tolist(),
        "directions": moment.directions.tolist(),
        "scores": moment.scores.round(3).tolist(),
        "chosen": moment.chosen,
        "path": to_world(start, moment.path).round(3).tolist(),
    }


def _listed(values: NDArray) -> list[Any]:
    """Numbers to four digits, in lists."""
    return values.tolist() if values.dtype == bool else np.round(values, 4).tolist()


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Make the rows of all figures, and leave their pictures in the current folder.

    Raises:
        InputError: where weights are missing, before anything is run.
    """
    if not settings.geometry:
        check_shipped(("nts",), "rgbd")
    found = for_each(run_world, options.worlds, options, settings, label="nts_figs")
    rows = sorted((row for part in found for row in part), key=lambda row: row["figure"])
    drawn = {Path.cwd() / f"nts_{name}.png": exact_png(p) for name, p in pictures(rows).items()}
    write_files(drawn)
    return rows, [
        "agree: directions in which F_G and its label say the same, of 12",
        "chosen, best: directions; regret: metres by which the path from the chosen one is longer",
        f"pictures: {', '.join(path.name for path in drawn)}",
    ]


def run_world(world: int, options: Options, settings: Settings) -> Rows:
    """The rows of all figures in one world."""
    name = exploration_world(world, settings.signs)
    place = Place(name, scene_of(name), settings, (options.seed, world))
    return [*_explorable(place), *_two_goals(place), *_trajectories(place)]


def _explorable(place: Place) -> Rows:
    """Fig. 3: F_G on panoramas from which two directions or more are explorable."""
    poses = random_poses(place.scene, place.settings.places, np.random.default_rng(place.seed))
    labels = PanoramaLabels(place.scene, poses).explorable
    some = np.flatnonzero(labels.sum(axis=1) >= 2)[: place.settings.panoramas]
    task = place.task(place.episodes(poses[some], poses[some], np.zeros(len(some))))
    model = place.model(task)
    likely = model.explorable(model.embed(task.observe()))
    return [
        place.row(
            *(3, case, "F_G"),
            pose=poses[row],
            explorable=likely[case] >= 0.5,
            scores=likely[case],
            truth=labels[row].astype(float),
            agree=int(((likely[case] >= 0.5) == labels[row]).sum()),
        )
        for case, row in enumerate(some)
    ]


def _two_goals(place: Place) -> Rows:
    """Figs. 4 and 10: scores of one source for two goals, and the ghosts that they choose."""
    chosen = _source_and_goals(place)
    if chosen is None:
        return []
    source, goals, metres, explorable, rooms = chosen
    starts = np.repeat(source[None], 2, axis=0)
    task = place.task(place.episodes(starts, goals, metres[:, -1]))
    metres = metres[:, :-1]
    model = place.model(task)
    scores = model.scores(model.embed(task.observe()), model.embed(task.goals()))
    agent = NTSAgent(model, np.random.default_rng([*place.seed, 2]))
    agent.start(task.goals())
    seen = task.observe()
    actions = agent.act(seen, ~task.done)
    first = [
        in_world(ghost_moment(robot, odometry), source)
        for robot, odometry in zip(agent.robots, seen.odometry, strict=True)
    ]
    while not task.done.all():
        task.step(actions)
        actions = agent.act(task.observe(), ~task.done)
    rows: Rows = []
    for case, what in enumerate(rooms):
        far = np.where(explorable, metres[case], np.inf)
        same = {"pose": source, "goal": goals[case], "best": int(far.argmin())}
        choice = int(np.where(explorable, scores[case], -np.inf).argmax())
        truth = np.maximum(1 - metres[case] / MAX_DISTANCE, 0.0)
        shown = {"explorable": explorable, "scores": scores[case], "truth": truth}
        rows.append(place.row(4, case, what, **same | shown | _choice(choice, far)))
        ghost = first[case]["chosen"]
        taken = None if ghost < 0 else first[case]["directions"][ghost]
        ended = outcome_of(task, case) | {"nodes": len(agent.robots[case].memory.graph)}
        taken_too = _choice(taken, far) | {"moments": [first[case]]}
        rows.append(place.row(10, case, what, **same | ended | taken_too))
    return rows


def _choice(direction: int | None, metres: Array) -> dict[str, Any]:
    """The direction that was chosen, and its regret; None where it is not explorable."""
    if direction is None or not np.isfinite(metres[direction]):
        return {"chosen": direction, "regret": None}
    return {"chosen": direction, "regret": round(float(metres[direction] - metres.min()), 2)}


def _source_and_goals(
    place: Place,
) -> tuple[Array, Array, Array, NDArray[np.bool_], list[str]] | None:
    """A source and two goals in other kinds of rooms and other directions, 5 to 10 m away.

    Returns:
        The source (3,); the goals (2, 3); metres (2, K + 1) from the end of each direction and from
        the source; which directions (K,) are explorable; the kinds of the goals' rooms. None where
        there are no such goals.
    """
    count = place.settings.places
    rng = np.random.default_rng([*place.seed, 3])
    poses = random_poses(place.scene, count + count // 2, rng)
    labels = PanoramaLabels(place.scene, poses)
    goals = np.arange(count, len(poses))
    least, most = DIFFICULTIES["hard"]
    for source in np.flatnonzero(labels.explorable[:count].sum(axis=1) >= 3):
        metres = labels.metres(np.full(len(goals), source), goals)
        far = (metres[:, -1] >= least) & (metres[:, -1] < most)
        far &= labels.rooms[goals] < len(ROOM_KINDS)
        best = np.where(labels.explorable[source], metres[:, :-1], np.inf).argmin(axis=1)
        turn = np.abs(best[:, None] - best)
        apart = np.minimum(turn, DIRECTIONS - turn) >= _APART
        apart &= labels.rooms[goals][:, None] != labels.rooms[goals]
        pairs = np.argwhere(apart & far[:, None] & far)
        if len(pairs):
            both = pairs[0]
            kinds = [ROOM_KINDS[kind] for kind in labels.rooms[goals[both]]]
            known = labels.explorable[source]
            return poses[source], poses[goals[both]], metres[both], known, kinds
    return None


def _trajectories(place: Place) -> Rows:
    """Fig. 9: a hard episode by NTS and by frontiers, with noise and without."""
    rng = np.random.default_rng([*place.seed, 4])
    episode = draw_episodes(place.name, place.scene, {"hard": 1}, rng)
    ends = {"pose": episode.starts[0], "goal": episode.goals[0]}
    cases = [(agent, noise) for agent in ("nts", "fbe") for noise in (True, False)]
    rows: Rows = []
    for case, (agent, noise) in enumerate(cases):
        task = place.task(episode, noise=noise)
        moments = _explored(place, task, agent)
        looks = np.rint(np.array(_LOOKS) * (len(moments) - 1)).astype(int) if moments else []
        ended = outcome_of(task, 0) | {"nodes": len(moments[-1]["nodes"]) if moments else None}
        shown = {"moments": [moments[look] for look in looks]}
        what = f"{agent}, {'noise' if noise else 'no noise'}"
        rows.append(place.row(9, case, what, **ends | ended | shown))
    return rows


def _explored(place: Place, task: ExplorationTask, agent: str) -> list[dict[str, Any]]:
    """Let an agent explore; its graph at every step, if it has one."""
    rng = np.random.default_rng([*place.seed, 5])
    explorer = make_explorer(agent, task, "rgbd", rng, geometry=place.settings.geometry)
    explorer.start(task.goals())
    start, moments = task.poses[0], []
    while not task.done.all():
        seen = task.observe()
        actions = explorer.act(seen, ~task.done)
        if isinstance(explorer, NTSAgent):
            moment = in_world(ghost_moment(explorer.robots[0], seen.odometry[0]), start)
            if explorer.search.found[0]:  # then it goes there, and no longer to a ghost
                path = np.stack([seen.odometry[0, :2], explorer.search.places[0]])
                moment["path"] = to_world(start, path).round(3).tolist()
            moments.append(moment | {"step": int(task.steps[0])})
        task.step(actions)
    return moments


_GEOMETRY = Experiment("nts_figs_geometry", run, WORLDS[:2], settings=Settings(geometry=True))
EXPERIMENT = Experiment(
    "nts_figs",
    run,
    WORLDS[:2],
    settings=Settings(),
    canary=Settings(panoramas=1, places=6),
    ablations={"geometry": _GEOMETRY},
)
