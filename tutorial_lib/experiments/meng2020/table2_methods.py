"""The agents of Table II, one at a time, so that they can run beside each other."""

from __future__ import annotations

import numpy as np

from tutorial_lib.agents.oracle import OracleNavigation
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.own import CUSTOM, or_fault
from tutorial_lib.experiments.common.report import Fault
from tutorial_lib.experiments.protocols.navigation import Result, attempt, navigate
from tutorial_lib.experiments.protocols.navigation_tasks import Building, Trials
from tutorial_lib.topology.mapping.edge_rules import MapSettings

METHODS = ("meng", "sptm", "random", "oracle")
"""In the order of the rows."""


def run_method(
    method: str,
    building: Building,
    whole: Building,
    trials: Trials,
    p_edge: float,
    s_shortcut: float,
    agent: str,
    remedies: str,
    images: str,
) -> Result | Fault:
    """One agent: what it learns of a building, and how its trials end; or how it failed.

    Args:
        method: name of the agent.
        building: with the drives that it learns.
        whole: with all drives; only the oracle sees it.
        trials: to be run.
        p_edge: of Meng's map.
        s_shortcut: of SPTM's.
        agent: FILE.py:CLASS of the custom one.
        remedies: of Meng's, for places that look alike; see `agents.remedies`.
        images: of the goals, one of `GOAL_IMAGES`.
    """
    if method == "oracle":
        return Result(
            navigate(
                building, trials, lambda sim: OracleNavigation(sim, whole.paths, trials.goal_poses)
            )
        )
    if method == CUSTOM:
        return or_fault(agent, lambda: attempt(building, trials, agents.custom(agent), images))
    settings = MapSettings(p_edge=p_edge)
    if method == "random":
        made = agents.random_agent(np.random.default_rng([*building.odometry.seed, 1]))
    elif method == "sptm":
        made = agents.sptm(s_shortcut=s_shortcut)
    elif remedies:
        made = agents.remedied(remedies, settings=settings)
    else:
        made = agents.meng(settings=settings)
    return attempt(building, trials, made, images)
