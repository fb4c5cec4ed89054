"""Whole systems: they learn a building from recordings and navigate in it, or explore one."""

from tutorial_lib.agents.frontier import FrontierAgent
from tutorial_lib.agents.imitation import ImitationAgent
from tutorial_lib.agents.lifelong import LifelongAgent, LifelongSettings
from tutorial_lib.agents.ltvn import LTVNAgent
from tutorial_lib.agents.mending import MendingMengAgent
from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.agents.nts import NTSAgent, NTSSettings
from tutorial_lib.agents.oracle import OracleNavigation
from tutorial_lib.agents.oracle_explorer import OracleExplorer
from tutorial_lib.agents.random import RandomAgent
from tutorial_lib.agents.random_walk import RandomWalkAgent
from tutorial_lib.agents.remedies import REMEDIES, Remedies
from tutorial_lib.agents.remedy_agent import RemedyAgent
from tutorial_lib.agents.returning import ReturningAgent
from tutorial_lib.agents.sptm import SPTMAgent

__all__ = [
    "REMEDIES",
    "FrontierAgent",
    "ImitationAgent",
    "LTVNAgent",
    "LifelongAgent",
    "LifelongSettings",
    "MendingMengAgent",
    "MengAgent",
    "NTSAgent",
    "NTSSettings",
    "OracleExplorer",
    "OracleNavigation",
    "RandomAgent",
    "RandomWalkAgent",
    "Remedies",
    "RemedyAgent",
    "ReturningAgent",
    "SPTMAgent",
]
