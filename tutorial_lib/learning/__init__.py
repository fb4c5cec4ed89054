"""Learning: labels, networks, training and trained weights; the only package with torch."""

from tutorial_lib.learning.batches import Source
from tutorial_lib.learning.calibration import auc, brier, sigmoid
from tutorial_lib.learning.encoders import PairEncoder
from tutorial_lib.learning.estimators import DirectNetwork, ReachabilityNetwork, WaypointNetwork
from tutorial_lib.learning.mining import all_logits
from tutorial_lib.learning.networks import Architecture, LocalNetwork
from tutorial_lib.learning.policies import by_waypoints, encoded
from tutorial_lib.learning.threads import use_threads
from tutorial_lib.learning.training import Settings, train
from tutorial_lib.learning.weights import load_card
from tutorial_lib.memory import keep_freed_memory

__all__ = [
    "Architecture",
    "DirectNetwork",
    "LocalNetwork",
    "PairEncoder",
    "ReachabilityNetwork",
    "Settings",
    "Source",
    "WaypointNetwork",
    "all_logits",
    "auc",
    "brier",
    "by_waypoints",
    "encoded",
    "load_card",
    "sigmoid",
    "train",
    "use_threads",
]

keep_freed_memory()
