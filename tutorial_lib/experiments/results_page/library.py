"""What templates may say of the library's settings: its modules, by the names they have there."""

from __future__ import annotations

from typing import Any

from tutorial_lib.driving import metrics
from tutorial_lib.driving.data import reachability_pairs, recorded_world
from tutorial_lib.experiments.protocols import local_control, reachability
from tutorial_lib.experiments.robustness import disturbances
from tutorial_lib.topology.following import transitions as follower

LIBRARY: dict[str, Any] = {
    "disturbances": disturbances,
    "follower": follower,
    "local_control": local_control,
    "metrics": metrics,
    "reachability": reachability,
    "reachability_pairs": reachability_pairs,
    "recorded_world": recorded_world,
}
