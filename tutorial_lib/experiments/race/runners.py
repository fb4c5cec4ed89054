"""Who runs the race, by their names in its table."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.discrete_ltvn import DiscreteLTVN
from tutorial_lib.agents.frontier import FrontierAgent
from tutorial_lib.agents.lifelong import LifelongAgent, LifelongSettings
from tutorial_lib.agents.ltvn import LTVNAgent
from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.agents.nts import NTSAgent, NTSSettings
from tutorial_lib.agents.returning import ReturningAgent, visit
from tutorial_lib.agents.scan_corrected import ScanCorrected
from tutorial_lib.agents.sptm import SPTMAgent
from tutorial_lib.experiments.common.explorers import make_explorer, own_explorer, shipped
from tutorial_lib.experiments.protocols.visits import (
    remembering,
    remembering_ltvn,
    remembering_sptm,
    shown,
)
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.interfaces import ExplorationModel, ExplorerAgent, SequentialExplorer
from tutorial_lib.observation import Observation
from tutorial_lib.validation import with_methods

Maker = Callable[[ExplorationTask, ExplorationModel, np.random.Generator], SequentialExplorer]

COMBINED = LifelongSettings()
"""What is raced, chosen on validation worlds."""
SHOWN = 1_300
"""Actions for which a robot is shown a building: as many as the combined agent lives."""


class Forgetting:
    """A `SequentialExplorer` that begins anew with each goal: the mark for every memory."""

    def __init__(self, explorer: ExplorerAgent) -> None:
        """Explore by `explorer`."""
        self._explorer = with_methods("explorer", explorer, "start", "act")

    def start(self, goals: Observation) -> None:
        """Begin episodes towards `goals` (N,)."""
        self._explorer.start(goals)

    def look_for(self, goals: Observation) -> None:
        """Begin anew, with other goals (N,)."""
        self._explorer.start(goals)

    def act(self, observations: Observation, running: NDArray[np.bool_]) -> NDArray:
        """What the explorer does (N,)."""
        return self._explorer.act(observations, running)


def _lifelong(**changed: Any) -> Maker:  # noqa: ANN401 - fields of the settings
    settings = replace(COMBINED, **changed)
    return lambda task, model, rng: LifelongAgent(model, rng, settings)


def _frontier(scorer: str = "", *, recalls: bool = False) -> Maker:
    def make(
        task: ExplorationTask, model: ExplorationModel, rng: np.random.Generator
    ) -> FrontierAgent:
        prefers = shipped(scorer, "rgbd") if scorer else None
        return FrontierAgent(model, scorer=prefers, recalls=recalls, rng=rng)

    return make


def _corrected(maker: Maker) -> Maker:
    return lambda task, model, rng: ScanCorrected(maker(task, model, rng))


def _shown(
    memory: Callable[[], MengAgent | SPTMAgent | LTVNAgent], guide: str, *, explores: bool = False
) -> Maker:
    """A robot that made a map, before its life, of what a guide saw on the way to other goals.

    Args:
        memory: makes the agent that learns the map.
        guide: of `RUNNERS`.
        explores: where no path is probable enough; without, it only plans. Not for LTVN's.
    """

    def make(
        task: ExplorationTask, model: ExplorationModel, rng: np.random.Generator
    ) -> Forgetting:
        ((name, scene),) = task.scenes.items()

        def guided(tour: ExplorationTask) -> SequentialExplorer:
            return RUNNERS[guide](tour, model, rng)

        known = memory()
        deep = isinstance(known, LTVNAgent)
        known.learn(visit(shown(name, scene, guided, SHOWN, rng), 0, with_depth=deep))
        if deep:
            return Forgetting(DiscreteLTVN(known))
        return Forgetting(ReturningAgent(known, NTSAgent(model, rng) if explores else None))

    return make


def _forgetting(name: str) -> Maker:
    def make(
        task: ExplorationTask, model: ExplorationModel, rng: np.random.Generator
    ) -> Forgetting:
        return Forgetting(make_explorer(name, task, "rgbd", rng, geometry=False))

    return make


RUNNERS: Mapping[str, Maker] = {
    "combined": _lifelong(),
    "no_closing": _lifelong(exploring=NTSSettings()),
    "no_looks": _lifelong(recalls_looks=False),
    "no_metric": _lifelong(metric=False),
    "no_travel": _lifelong(travel=0.0),
    "no_relocating": _lifelong(relocates=False),
    "nts": lambda task, model, rng: NTSAgent(model, rng),
    "nts_closing": lambda task, model, rng: NTSAgent(model, rng, NTSSettings(closes_loops=True)),
    "nts_forgets": _forgetting("nts"),
    "fbe": _frontier(),
    "fbe_recalls": _frontier(recalls=True),
    "ans_like": _frontier("ans_like"),
    "ans_recalls": _frontier("ans_like", recalls=True),
    "ans_corrected": _corrected(_frontier("ans_like", recalls=True)),
    "il_forgets": _forgetting("il"),
    "random_forgets": _forgetting("random"),
    "oracle": _forgetting("oracle"),
    "meng_toured": _shown(remembering, "oracle"),
    "sptm_toured": _shown(remembering_sptm, "oracle"),
    "ltvn_toured": _shown(remembering_ltvn, "oracle"),
    "meng_explored": _shown(remembering, "combined"),
    "sptm_explored": _shown(remembering_sptm, "combined"),
    "ltvn_explored": _shown(remembering_ltvn, "combined"),
    "meng_explores": _shown(remembering, "oracle", explores=True),
}
"""Those that forget begin anew with each goal."""
INGREDIENTS = (
    *("combined", "no_closing", "no_looks", "no_metric", "no_travel", "no_relocating"),
    "nts",
)
"""The combined agent without one of its parts each, and without all of them."""
TOURED = (
    *("combined", "meng_toured", "sptm_toured", "ltvn_toured", "meng_explores"),
    *("meng_explored", "sptm_explored", "ltvn_explored", "oracle"),
)
"""The combined agent beside systems that have to be shown a building: by the oracle, or by the
combined agent while it explores."""
DRIVING = ("combined", "nts", "ans_corrected", "oracle")
"""Those that are raced in the body of a car, too."""
FIELD = (
    *("combined", "nts_closing", "nts", "nts_forgets", "ans_corrected", "ans_recalls"),
    *("ans_like", "fbe_recalls", "fbe", "il_forgets", "random_forgets", "oracle"),
)
"""All that are raced."""


def own_runner(where: str) -> SequentialExplorer:
    """The user's own agent from "FILE.py:CLASS"; one that takes one goal only begins anew.

    Raises:
        InputError: as `own_explorer` does.
    """
    agent = own_explorer(where)
    return agent if isinstance(agent, SequentialExplorer) else Forgetting(agent)
