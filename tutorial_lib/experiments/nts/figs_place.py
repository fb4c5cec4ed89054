"""A world of the figures: its tasks, its model, and the rows that are made in it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.experiments.common.explorers import shipped
from tutorial_lib.experiments.protocols.ghost_moments import GhostMoment
from tutorial_lib.exploration.episodes import Episodes
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.exploration.true_geometry import TrueGeometry
from tutorial_lib.interfaces import ExplorationModel
from tutorial_lib.se2 import Array, to_world
from tutorial_lib.world.scene import Scene

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
