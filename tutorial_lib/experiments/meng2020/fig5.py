"""Fig. 5 of Meng 2020: where three controllers keep anchors, and that tight places get more."""

from __future__ import annotations

import time
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.stats import spearmanr

from tutorial_lib.experiments.common.report import Options, Report
from tutorial_lib.experiments.common.statistics import measured_over_worlds
from tutorial_lib.experiments.protocols.following import Guide, trajectories
from tutorial_lib.experiments.protocols.local_control import WORLDS
from tutorial_lib.geometry import Array, wrap
from tutorial_lib.parallel import for_each

CONTEXTS = ("k2", "k5", "laser")
THRESHOLD = 0.99
"""p_sparsify of the figure."""
AHEAD = 1.0
"""Metres of the way from an anchor on that tell how tight it is there."""
_EACH = 8


def run(options: Options) -> Report:
    """Sparsify the same trajectories for every controller.

    The correlations are Spearman's, over all anchors: of the metres to the next one with the least
    clearance on the next metre of the way, and with how much the car turns on it. (On the whole way
    to the next anchor, a longer one would have more turns and more tight places by its length.)
    """
    begun = time.perf_counter()
    worlds = options.worlds or (WORLDS[:5] if options.quick else WORLDS)
    parts = for_each(place_anchors, worlds, options.seed, label="meng_fig5")
    rows: list[dict[str, Any]] = []
    for context in CONTEXTS:
        found = [part[context] for part in parts]
        gaps = np.concatenate([some for some, _, _ in found])
        where = np.repeat(np.arange(len(found)), [len(some) for some, _, _ in found])
        anchors, frames = (sum(part[i] for part in found) for i in (1, 2))
        row = {"context": context, "threshold": THRESHOLD, "anchors": anchors}
        row |= {"sparsity": anchors / frames, "metres": gaps[:, 0].mean()}
        for name, column in (("clearance", 1), ("turn", 2)):
            key = f"with_{name}"
            row[key], row[f"{key}_low"], row[f"{key}_high"] = measured_over_worlds(
                _rank_correlation, where, gaps[:, 0], gaps[:, column]
            )
        rows.append(row)
    took = time.perf_counter() - begun
    return Report("meng_fig5", options.seed, worlds, options.quick, took, rows)


def place_anchors(world: int, seed: int) -> dict[str, tuple[Array, int, int]]:
    """For each context the gaps (M, 3) between consecutive anchors, the anchors and the frames.

    A gap is its metres, and of its first `AHEAD` metres, or of as many as come after it, the least
    clearance and the rad that the car turned. Of anchors and frames it is told how many there were.
    """
    recorded = trajectories(world, _EACH, np.random.default_rng([seed, world]))
    clearance = recorded.scene.clearance.at(recorded.poses[:, :2])
    turned = np.abs(wrap(np.diff(recorded.poses[:, 2], prepend=recorded.poses[0, 2])))
    found = {}
    for context in CONTEXTS:
        guide, gaps, kept, frames = Guide(recorded, context), [], 0, 0
        for trajectory in range(len(recorded.trajectories)):
            anchors = guide.anchors(trajectory, THRESHOLD)
            kept += len(anchors)
            frames += int(anchors[-1] - anchors[0] + 1)
            # The last gap is cut off by the end of the trajectory.
            for first, last in pairwise(anchors[:-1]):
                ahead = recorded.frame_at(np.array([first]), np.array([AHEAD]))[0]
                way = slice(first + 1, max(ahead, first + 1) + 1)
                metres = recorded.arc[last] - recorded.arc[first]
                gaps.append((metres, clearance[way].min(), turned[way].sum()))
        found[context] = np.reshape(gaps, (-1, 3)), kept, frames
    return found


def _rank_correlation(first: Array, second: Array) -> float:
    return float(spearmanr(first, second).statistic)
