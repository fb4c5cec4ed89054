"""Fig. 5 of Meng 2020: where three controllers keep anchors, and that tight places get more."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.stats import spearmanr

from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.common.statistics import measured_over_worlds
from tutorial_lib.experiments.protocols.following import Guide, trajectories
from tutorial_lib.experiments.protocols.local_control import WORLDS
from tutorial_lib.parallel import for_each
from tutorial_lib.se2 import Array, wrap


@dataclass(frozen=True)
class Settings:
    """Settings of Fig. 5.

    Attributes:
        contexts: of the controllers.
        threshold: p_sparsify.
        ahead: metres of path after an anchor, over which clearance and turning are measured.
        trajectories: in each world.
    """

    contexts: tuple[str, ...] = ("k2", "k5", "laser")
    threshold: float = 0.99
    ahead: float = 1.0
    trajectories: int = 8


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Sparsify the same trajectories for every controller.

    Rank correlations (Spearman) over all anchors: of the metres to the next anchor with the least
    clearance on the next metre of the path, and with how much the car turns there. (Measured over
    the whole gap to the next anchor, a longer gap would have more turns and more tight places
    because of its length.)
    """
    parts = for_each(run_world, options.worlds, options, settings, label="meng_fig5")
    rows: Rows = []
    for context in settings.contexts:
        found = [part[context] for part in parts]
        gaps = np.concatenate([part_gaps for part_gaps, _, _ in found])
        world = np.repeat(np.arange(len(found)), [len(part_gaps) for part_gaps, _, _ in found])
        anchors, frames = (sum(part[i] for part in found) for i in (1, 2))
        row = {"context": context, "threshold": settings.threshold, "anchors": anchors}
        row |= {"sparsity": anchors / frames, "metres": gaps[:, 0].mean()}
        for name, column in (("clearance", 1), ("turn", 2)):
            key = f"with_{name}"
            row[key], row[f"{key}_low"], row[f"{key}_high"] = measured_over_worlds(
                _rank_correlation, world, gaps[:, 0], gaps[:, column]
            )
        rows.append(row)
    return rows, []


def run_world(
    world: int, options: Options, settings: Settings
) -> dict[str, tuple[Array, int, int]]:
    """For each context, the gaps (M, 3) between consecutive anchors, and two counts.

    The columns of a gap are its length in metres and, over the next `settings.ahead` metres, the
    least clearance and the rad that the car turns. The counts are those of anchors and frames.
    """
    rng = np.random.default_rng([options.seed, world])
    recorded = trajectories(world, settings.trajectories, rng)
    clearance = recorded.scene.clearance.at(recorded.poses[:, :2])
    turned = np.abs(wrap(np.diff(recorded.poses[:, 2], prepend=recorded.poses[0, 2])))
    found = {}
    for context in settings.contexts:
        guide, gaps, kept, frames = Guide(recorded, context), [], 0, 0
        for trajectory in range(len(recorded.trajectories)):
            anchors = guide.anchors(trajectory, settings.threshold)
            kept += len(anchors)
            frames += int(anchors[-1] - anchors[0] + 1)
            # The last gap is cut off by the end of the trajectory.
            for first, last in pairwise(anchors[:-1]):
                ahead = recorded.frame_at(np.array([first]), np.array([settings.ahead]))[0]
                path = slice(first + 1, max(ahead, first + 1) + 1)
                metres = recorded.arc[last] - recorded.arc[first]
                gaps.append((metres, clearance[path].min(), turned[path].sum()))
        found[context] = np.reshape(gaps, (-1, 3)), kept, frames
    return found


def _rank_correlation(first: Array, second: Array) -> float:
    return float(spearmanr(first, second).statistic)


EXPERIMENT = Experiment(
    "meng_fig5", run, WORLDS, WORLDS[:5], Settings(), canary=Settings(trajectories=1)
)
