"""The agents that explore, by their names in tables, with shipped networks or with an oracle."""

from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any

import numpy as np

from tutorial_lib.agents.frontier import FrontierAgent
from tutorial_lib.agents.imitation import ImitationAgent
from tutorial_lib.agents.nts import NTSAgent, NTSSettings
from tutorial_lib.agents.oracle_explorer import OracleExplorer
from tutorial_lib.agents.random_walk import RandomWalkAgent
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.own import load_own
from tutorial_lib.exploration.graph_update import PAPER, Localisation
from tutorial_lib.exploration.other_scores import HistogramScores, ScoresOf
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.exploration.true_geometry import TrueGeometry
from tutorial_lib.interfaces import ExplorationModel, ExplorerAgent
from tutorial_lib.learning.exploration_model import LearnedExploration
from tutorial_lib.learning.exploration_policies import (
    LearnedFrontierScorer,
    LearnedImitation,
    with_pairs,
)
from tutorial_lib.learning.reinforcement_network import LearnedReinforcement, ReinforcementNetwork
from tutorial_lib.learning.weights import FOLDER

AGENTS = {
    "rgbd": (
        *("nts", "nts_no_graph", "nts_no_score", "nts_blind"),
        *("fbe", "ans_like", "il", "random", "oracle"),
    ),
    "rgb": ("nts", "ans_like", "il"),
}
"""The agents of Table 1 by sensor. Frontier exploration maps measured depth, so that it has no row
without; bounds and the ablations of graph, score and goal are run with depth only."""
WITH_GEOMETRY = (
    *("nts", "nts_2m", "nts_no_graph", "nts_no_score", "nts_histogram"),
    *("fbe", "random", "oracle"),
)
"""The agents that run without a network where an oracle stands in for it."""
AS_IN_PAPER = (
    *("nts_masked", "nts_all_nodes", "nts_by_odometry", "nts_no_ghost_nodes"),
    "nts_paper",
)
"""The course's agent with one thing as the paper has it, and with all four: F_S that learnt from
unconnected pairs only; F_L over all nodes; edges to known nodes by odometry; no node at a ghost
where F_L has the robot in the old one."""
BY_REINFORCEMENT = ("target_rl", "map_rl")
"""The paper's baselines that learn by reinforcement: from pictures, and from a metric map too."""
_FINE = {"directions": 24, "radius": 2.0}
"""Of "nts_2m": more directions with ghosts that are nearer, which fit into small rooms."""
_SETTINGS = {
    "nts_no_graph": NTSSettings(use_graph=False),
    "nts_no_score": NTSSettings(use_score=False),
    "nts_2m": NTSSettings(**_FINE),
    "nts_all_nodes": NTSSettings(localisation=Localisation(all_nodes=True)),
    "nts_by_odometry": NTSSettings(localisation=Localisation(edges_by_odometry=True)),
    "nts_no_ghost_nodes": NTSSettings(localisation=Localisation(nodes_at_ghosts=False)),
    "nts_paper": NTSSettings(localisation=PAPER),
}
"""Of the agents with ghost nodes, by their name; the usual ones of others."""
_SCORED_BY = {
    "nts_blind": "nts_blind",
    "nts_masked": "nts_masked",
    "nts_paper": "nts_masked",
}
"""Whose scores agents have that have those of another network, by their name."""
_CLASSES: dict[str, Callable[[str], Any]] = {
    "nts": LearnedExploration,
    "nts_blind": LearnedExploration,
    "nts_masked": LearnedExploration,
    "ans_like": LearnedFrontierScorer,
    "il": LearnedImitation,
    **dict.fromkeys(BY_REINFORCEMENT, partial(with_pairs, wanted=ReinforcementNetwork)),
}
"""What puts the weights of each kind behind its interface, by their name; those that draw their
actions are only loaded, with the network that they read."""


def make_explorer(
    name: str, task: ExplorationTask, sensor: str, rng: np.random.Generator, *, geometry: bool
) -> ExplorerAgent:
    """An agent for a task.

    Args:
        name: one of `AGENTS`, `BY_REINFORCEMENT` or `AS_IN_PAPER`; with `geometry` of
            `WITH_GEOMETRY` in place of the first two.
        task: of which oracles see more than others.
        sensor: of its networks.
        rng: draws what is random in the agent.
        geometry: the true geometry stands in for the network.

    Raises:
        InputError: for an unknown name or sensor, and where weights are needed that are not there.
    """
    own = WITH_GEOMETRY if geometry else (*AGENTS["rgbd"], *BY_REINFORCEMENT)
    known = (*own, *AS_IN_PAPER)
    if name not in known:
        raise InputError(f"agent: {name!r} is unknown here; use one of {', '.join(known)}")
    if sensor not in AGENTS:
        raise InputError(f"sensor: {sensor!r} is unknown; use one of {', '.join(AGENTS)}")
    if name == "oracle":
        return OracleExplorer(task)
    if name == "nts_2m":
        return NTSAgent(TrueGeometry(task, **_FINE), rng, _SETTINGS[name])
    if name == "il":
        return ImitationAgent(shipped("il", sensor))
    if name in BY_REINFORCEMENT:
        network, pairs = shipped(name, sensor)
        return LearnedReinforcement(network, pairs, rng)
    model: ExplorationModel = TrueGeometry(task) if geometry else shipped("nts", sensor)
    if name == "random":
        return RandomWalkAgent(model, rng)
    if name == "fbe":
        return FrontierAgent(model, rng=rng)
    if name == "ans_like":
        return FrontierAgent(model, scorer=shipped("ans_like", sensor), rng=rng)
    if name in _SCORED_BY and not geometry:
        model = ScoresOf(model, shipped(_SCORED_BY[name], sensor))
    elif name == "nts_histogram":
        model = HistogramScores(model)
    return NTSAgent(model, rng, _SETTINGS.get(name))


def own_explorer(where: str) -> ExplorerAgent:
    """An explorer of the user's own, from "FILE.py:CLASS".

    Raises:
        InputError: as `load_own` does.
    """
    return load_own(where, ("explorer",))[1]


def check_shipped(agents: tuple[str, ...], sensor: str) -> None:
    """Check that the weights of all networks that these agents need are there.

    Raises:
        InputError: naming those that are not, and the command that trains them.
    """
    needed = {_SCORED_BY.get(name, name) for name in agents} & set(_CLASSES)
    needed |= {"nts"} if set(agents) - {"il", "oracle"} else set()
    for kind in sorted(needed):
        _check(kind, sensor)


@lru_cache(maxsize=8)
def shipped(kind: str, sensor: str) -> Any:  # noqa: ANN401 - a model, a scorer or a policy
    """A trained network.

    Args:
        kind: "nts", "nts_blind", "nts_masked", "ans_like", "il", "target_rl" or "map_rl".
        sensor: "rgbd" or "rgb".

    Raises:
        InputError: where its weights are not there.
    """
    _check(kind, sensor)
    return _CLASSES[kind](f"{kind}_{sensor}")


def _check(kind: str, sensor: str) -> None:
    file = FOLDER / f"{kind}_{sensor}.safetensors"
    if not file.exists():
        network, _, variant = kind.partition("_") if kind.startswith("nts") else (kind, "", "")
        command = f"train {network} --sensor {sensor}" + (f" --{variant}" if variant else "")
        raise InputError(
            f"{file.stem}: its weights are not there; python -m tutorial_lib {command} makes them"
        )
