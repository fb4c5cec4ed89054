"""What the steps of an episode pay: its SPL when it ends, or progress to the goal as well."""

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.exploration.episodes import EpisodeSource, check_known
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.se2 import Array

REWARDS = ("spl", "shaped")
SPL_PAYS, STEP_COSTS = 10.0, 0.001
"""Of the shaped reward, that of Chaplot et al. 2020 for agents that learn by reinforcement."""


class Rewards:
    """The rewards of N episodes in lock-step.

    "spl" pays an episode's SPL when it ends, and nothing before. "shaped" pays `SPL_PAYS` times as
    much, and for each step the metres by which the geodesic to the goal has become shorter, less
    `STEP_COSTS`. Over an episode of T steps that sums up to ``10 SPL + first - last - 0.001 T``,
    with the geodesic's metres at the first and the last step. Where a robot stands in a pocket of
    which the geodesics know nothing, they are those of the step before.
    """

    def __init__(self, kind: str, sources: Mapping[str, EpisodeSource]) -> None:
        """Choose one of `REWARDS`; `sources` are those of the episodes' worlds, by name."""
        check_known("reward", kind, REWARDS)
        self._shaped, self._sources = kind == "shaped", sources

    def begin(self, task: ExplorationTask, robots: Iterable[int] | None = None) -> None:
        """Note that the episodes of some robots begin, or all of a new task."""
        if not self._shaped:
            return
        if robots is None:
            robots = range(len(task))
            self._fields, self._metres = [np.empty(0)] * len(task), np.zeros(len(task))
        for robot in robots:
            x, y, _ = task.goal_poses[robot].tolist()
            self._fields[robot] = self._sources[task.episodes.worlds[robot]].metres_to(x, y)
            self._metres[robot] = task.episodes.shortest[robot]
        names = np.array(task.episodes.worlds)
        self._rows = {name: np.flatnonzero(names == name) for name in set(task.episodes.worlds)}

    def paid(self, task: ExplorationTask, acted: NDArray[np.bool_]) -> Array:
        """The rewards (N,) of a step, to the robots that `acted` (N,)."""
        ended = acted & task.done
        spl = np.where(ended, task.spl, 0.0) if ended.any() else np.zeros(len(task))
        if not self._shaped:
            return spl
        before, self._metres = self._metres, self._distances(task.poses)
        return np.where(acted, SPL_PAYS * spl + before - self._metres - STEP_COSTS, 0.0)

    def _distances(self, poses: Array) -> Array:
        """Geodesic metres (N,) from robots to their goals."""
        found = self._metres.copy()
        for name, rows in self._rows.items():
            nodes, gaps = self._sources[name].paths.nearest(poses[rows, :2])
            metres = gaps + [self._fields[row][node] for row, node in zip(rows, nodes, strict=True)]
            known = (nodes >= 0) & np.isfinite(metres)
            found[rows[known]] = metres[known]
        return found
