"""Fig. 11 of Meng 2020: a path that was never recorded, composed of several trajectories."""

from dataclasses import dataclass

import numpy as np

from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.protocols.navigation import (
    ONE,
    K,
    experiences,
    goals_of,
    navigate,
    vertex_poses,
)
from tutorial_lib.experiments.protocols.navigation_tasks import (
    PLACES,
    WORLDS,
    draw_trials,
    make_building,
)
from tutorial_lib.learning.threads import use_threads
from tutorial_lib.learning.views import VIEWS


@dataclass(frozen=True)
class Settings:
    """Settings of Fig. 11.

    Attributes:
        places: of the building.
        share: of the trajectories, which are learned.
        trials: to choose from.
    """

    places: int = PLACES
    share: float = 0.4
    trials: int = 40


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Find a trial whose own trajectory was not learned and whose path joins several others.

    Of those that succeed, the one whose path has the most vertices of a second trajectory is shown.
    """
    use_threads(2)
    world = options.worlds[0]
    building = make_building(world, options.seed, settings.places, drifts=options.drifts)
    rng = np.random.default_rng([options.seed, world, 7])
    pairs = building.pairs
    kept = np.sort(rng.permutation(len(pairs))[: round(settings.share * len(pairs))])
    trials, agent = draw_trials(building, settings.trials, rng), agents.meng()
    agent.learn(list(experiences(building, kept.tolist())))
    navigation = agent.start(goals_of(trials, VIEWS["camera16"], K))
    outcome = navigate(building, trials, lambda _: navigation)
    known = {tuple(pair) for pair in pairs[kept].tolist()}
    best, most = -1, 0
    for trial in np.flatnonzero(outcome.success):
        plans = navigation.history[trial]
        if tuple(trials.pairs[trial].tolist()) in known or len(plans) > 1:
            continue
        found = agent.topomap.trajectory[list(plans[0].vertices)]
        second = sorted(np.bincount(found))[-2:][0] if len(set(found.tolist())) > 1 else 0
        if second > most:
            best, most = int(trial), int(second)
    if best < 0:
        raise InputError("meng_fig11: no new path was found in this world; give another one")
    plan, poses = navigation.history[best][0], vertex_poses(building, agent.topomap)
    first, last = trials.pairs[best].tolist()
    rows: Rows = [
        {
            "from_place": first,
            "to_place": last,
            "goal_images": ONE,
            "step": step,
            "vertex": int(vertex),
            "trajectory": int(kept[agent.topomap.trajectory[vertex]]),
            "x": float(poses[vertex, 0]),
            "y": float(poses[vertex, 1]),
            "heading": float(poses[vertex, 2]),
            "probability": plan.probabilities[step],
        }
        for step, vertex in enumerate(plan.vertices)
    ]
    note = (
        f"from place {first} to {last} with {plan.probability:.1%}; reached after "
        f"{outcome.seconds[best]:.0f} s; {len(kept)} of {len(pairs)} trajectories known"
    )
    return rows, [note]


EXPERIMENT = Experiment(
    "meng_fig11", run, WORLDS[:1], settings=Settings(), accepts=frozenset({"odometry"})
)
