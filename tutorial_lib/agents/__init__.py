"""Whole systems: they learn a building from recorded trajectories and navigate in it."""

from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.agents.oracle import OracleNavigation
from tutorial_lib.agents.random import RandomAgent
from tutorial_lib.agents.remedies import REMEDIES, Remedies
from tutorial_lib.agents.remedy_agent import RemedyAgent
from tutorial_lib.agents.sptm import SPTMAgent

__all__ = [
    "REMEDIES",
    "MengAgent",
    "OracleNavigation",
    "RandomAgent",
    "Remedies",
    "RemedyAgent",
    "SPTMAgent",
]
