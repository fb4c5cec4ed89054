"""Checks of notebook 03: reachability."""

from tutorial_lib.checks.nb03.fit_temperature import check_fit_temperature
from tutorial_lib.checks.nb03.mine_pairs import check_mine_pairs
from tutorial_lib.checks.nb03.reach_loss import check_reach_loss
from tutorial_lib.checks.nb03.reliability_diagram import check_reliability_diagram
from tutorial_lib.checks.nb03.rollout_labels import check_rollout_labels

__all__ = [
    "check_fit_temperature",
    "check_mine_pairs",
    "check_reach_loss",
    "check_reliability_diagram",
    "check_rollout_labels",
]
