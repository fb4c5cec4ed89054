"""What templates may say of the library's settings: its modules, by the names they have there."""

from __future__ import annotations

from typing import Any

from tutorial_lib.driving import metrics
from tutorial_lib.driving.data import reachability_pairs, recorded_world
from tutorial_lib.experiments.protocols import local_control, reachability

LIBRARY: dict[str, Any] = {
    "local_control": local_control,
    "metrics": metrics,
    "reachability": reachability,
    "reachability_pairs": reachability_pairs,
    "recorded_world": recorded_world,
}
