"""Does F_S choose the right direction? Its first choice on unseen worlds, beside baselines.

A decision is a place, a goal, and the directions that are traversable for a metre or more. The
choice is right when the path from its end is within 0.5 m of the best one's. F_S is asked where the
goal is not in the node of the source: decisions between unconnected places come first, then all.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.explorers import check_shipped, shipped
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.common.statistics import difference, over_worlds
from tutorial_lib.experiments.protocols.directions import regret_of
from tutorial_lib.exploration.episodes import DIFFICULTIES, exploration_world
from tutorial_lib.exploration.labels import PanoramaLabels
from tutorial_lib.exploration.other_scores import HistogramScores, RandomScores
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import ExplorationModel
from tutorial_lib.learning.exploration_data import SHORTEST, random_poses
from tutorial_lib.learning.exploration_losses import WITHIN
from tutorial_lib.observation import Observation
from tutorial_lib.parallel import for_each
from tutorial_lib.world.generators import SIGNS
from tutorial_lib.world.sensors import PanoramicCamera
from tutorial_lib.world.worlds import scene_of

SCORES = ("semantic", "masked", "blind", "histogram", "random")
"""F_S; the same network with scores that learnt from unconnected pairs only, as in the paper; with
scores that see the source alone; how much a direction's patch has the colours of some patch of the
goal; and no knowledge at all."""
_DEPTH_ONLY = ("masked", "blind")
PAIRS = ("unconnected", "all")
"""Which decisions are counted: those whose goal is in another node than the source, or all."""


@dataclass(frozen=True)
class Settings:
    """Settings of the experiment.

    Attributes:
        places: of each world, from which a direction is to be chosen.
        goals: of each world.
        sensors: whose networks are compared.
    """

    places: int = 120
    goals: int = 24
    sensors: tuple[str, ...] = ("rgb", "rgbd")


@dataclass(frozen=True, eq=False)
class Chosen:
    """D decisions of one world.

    Attributes:
        difficulty: (D,) index in `DIFFICULTIES`.
        connected: (D,) whether source and goal are in one node, the label of F_L.
        regret: (D,) metres by which each choice is longer than the best, by sensor and score.
    """

    difficulty: NDArray[np.intp]
    connected: NDArray[np.bool_]
    regret: dict[tuple[str, str], Array]


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Let all scores choose at the same places, with and without signs.

    Raises:
        InputError: where weights are missing, before anything is run.
    """
    for sensor in settings.sensors:
        others = (f"nts_{score}" for score in scores_of(sensor) if score in _DEPTH_ONLY)
        check_shipped(("nts", *others), sensor)
    rows: Rows = []
    for signs in SIGNS:
        names = [exploration_world(seed, signs) for seed in options.worlds]
        found = for_each(choices, names, options.seed, settings, label=f"{signs} worlds")
        worlds = np.repeat(options.worlds, [len(chosen.difficulty) for chosen in found])
        joined = _joined(found)
        for sensor, pairs in product(settings.sensors, PAIRS):
            for number, difficulty in enumerate(DIFFICULTIES):
                mine = joined.difficulty == number
                mine &= ~joined.connected | (pairs == "all")
                if mine.any():
                    subset = {s: joined.regret[sensor, s][mine] for s in scores_of(sensor)}
                    key = {"sensor": sensor, "signs": signs, "pairs": pairs}
                    rows += _rows(key | {"difficulty": difficulty}, subset, worlds[mine])
    notes = [
        f"top1: the chosen direction's end is within {WITHIN} m of the best one's",
        "gain: of semantic over this score on the same decisions, 95% intervals over worlds",
    ]
    return rows, notes


def _joined(parts: Sequence[Chosen]) -> Chosen:
    """The decisions of all worlds."""
    regret = {key: np.concatenate([p.regret[key] for p in parts]) for key in parts[0].regret}
    difficulty, connected = (
        np.concatenate([getattr(p, name) for p in parts]) for name in ("difficulty", "connected")
    )
    return Chosen(difficulty, connected, regret)


def _rows(key: dict[str, str], regret: dict[str, Array], worlds: NDArray[np.intp]) -> Rows:
    """A row for each score, from its regret (D,) in decisions of one kind."""
    right = {score: (metres <= WITHIN).astype(float) for score, metres in regret.items()}
    rows: Rows = []
    for score, metres in regret.items():
        top1, low, high = over_worlds(right[score], worlds)
        gained = (None, None, None)
        if score != "semantic":
            gained = difference(right["semantic"], right[score], worlds)
        rows.append(
            {"score": score, **key, "decisions": len(metres), "top1": top1}
            | {"low": low, "high": high, "regret": float(metres.mean())}
            | dict(zip(("gain", "gain_low", "gain_high"), gained, strict=True))
        )
    return rows


def choices(name: str, seed: int, settings: Settings) -> Chosen:
    """The decisions of the world of that name, and what each score chooses."""
    scene = scene_of(name)
    # The same places with and without signs.
    rng = np.random.default_rng([seed, scene.plan.seed])
    poses = random_poses(scene, settings.places + settings.goals, rng)
    image, depth = PanoramicCamera().look(scene, poses)
    labels = PanoramaLabels(scene, poses, depth)
    source, goal = (index.ravel() for index in np.indices((settings.places, settings.goals)))
    goal = goal + settings.places
    metres = labels.metres(source, goal)
    far, metres = metres[:, -1], metres[:, :-1]
    metres = np.where(labels.lengths[source] >= SHORTEST, metres, np.inf)
    bounds = np.array(list(DIFFICULTIES.values()))
    level = (far[:, None] >= bounds[:, 0]) & (far[:, None] < bounds[:, 1])
    kept = level.any(axis=1) & (np.isfinite(metres).sum(axis=1) > 1)
    source, goal, metres, level = source[kept], goal[kept], metres[kept], level[kept]
    still = np.zeros(len(poses))
    seen = Observation(image, depth, still[:, None], poses * 0.0, still, still).pictures()
    regret = {}
    for sensor in settings.sensors:
        for score, model in models_of(sensor, rng).items():
            rows = model.embed(seen)
            found = model.scores(rows[source], rows[goal])
            regret[sensor, score] = regret_of(found, metres)
    return Chosen(level.argmax(axis=1), labels.connected(source, goal), regret)


def scores_of(sensor: str) -> tuple[str, ...]:
    """Those of `SCORES` that are compared with a sensor: some of them with depth only."""
    return tuple(score for score in SCORES if score not in _DEPTH_ONLY or sensor == "rgbd")


def models_of(sensor: str, rng: np.random.Generator) -> dict[str, ExplorationModel]:
    """What scores directions, by the names of `scores_of`; `rng` draws random ones."""
    learned = shipped("nts", sensor)
    models = {
        "semantic": learned,
        "histogram": HistogramScores(learned),
        "random": RandomScores(learned, rng),
    }
    others = [score for score in scores_of(sensor) if score in _DEPTH_ONLY]
    return models | {score: shipped(f"nts_{score}", sensor) for score in others}


EXPERIMENT = Experiment(
    "nts_scores",
    run,
    tuple(range(20_000, 20_020)),
    tuple(range(20_000, 20_010)),
    settings=Settings(),
    quick_settings=Settings(sensors=("rgbd",)),
    canary=Settings(places=12, goals=4),
)
