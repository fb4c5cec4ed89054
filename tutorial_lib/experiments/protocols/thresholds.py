"""Thresholds of both maps that depend on how much of a building was driven."""

from collections.abc import Mapping
from dataclasses import dataclass

from tutorial_lib.experiments.common import agents
from tutorial_lib.topology.mapping.edge_rules import MapSettings


@dataclass(frozen=True)
class Thresholds:
    """Thresholds that depend on how much was driven.

    Attributes:
        p_edge: Meng's, see `MapSettings`.
        s_shortcut: SPTM's, see `SPTMAgent`.
    """

    p_edge: float = MapSettings().p_edge
    s_shortcut: float = agents.S_SHORTCUT


CHOSEN: Mapping[str, Thresholds] = {
    "0.2": Thresholds(0.99, 0.8),
    "0.4": Thresholds(0.99, 0.95),
    "tour": Thresholds(0.99, 0.9),
}
"""By `--drives`: what `meng_table2 --ablation thresholds` found best
in composed trials of its validation worlds."""
