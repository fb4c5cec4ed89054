"""The system of Meng 2020: a sparse map of reachable pictures, planned on and followed by sight."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from tutorial_lib.agents.agent import Experience
from tutorial_lib.agents.navigator import MapNavigation
from tutorial_lib.interfaces import Controller, Observation, Reachability, WaypointPredictor
from tutorial_lib.topology.following.follower import Follower
from tutorial_lib.topology.following.transitions import FollowerSettings
from tutorial_lib.topology.mapping.anchors import anchors_of
from tutorial_lib.topology.mapping.edge_rules import MapSettings
from tutorial_lib.topology.mapping.insertion import add_trajectory
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.topology.planner import DijkstraPlanner, Goals, Plan


@dataclass
class MengAgent:
    """Learns a map from drives, and sends a fleet over it; an `Agent`.

    Attributes:
        predictor: C_WP.
        controller: C_RMP.
        reachability: RE.
        planner: finds ways over the map.
        settings: of the map.
        follower: when the follower believes what it is told.
        p_sparsify: RE by which anchors are chosen.
        replans: how often a robot that was lost plans anew before it gives up.
        topomap: what was learned.
    """

    predictor: WaypointPredictor
    controller: Controller
    reachability: Reachability
    planner: DijkstraPlanner = field(default_factory=DijkstraPlanner)
    settings: MapSettings = field(default_factory=MapSettings)
    follower: FollowerSettings = field(default_factory=FollowerSettings)
    p_sparsify: float = 0.99
    replans: int = 8

    def __post_init__(self) -> None:
        self.topomap = TopoMap(self.reachability, self.settings)

    def learn(self, experiences: Sequence[Experience]) -> None:
        """Let the map grow, drive by drive."""
        view, k = self.predictor.view, self.predictor.architecture.k
        for experience in experiences:
            seen = experience.observations
            anchors = anchors_of(
                self.reachability, seen, view.of(seen), k, self.p_sparsify, experience.timestamps
            )
            add_trajectory(self.topomap, anchors)

    def start(self, goals: Sequence[Goals]) -> MapNavigation:
        """Send robots to one goal each."""
        follower = Follower(self.predictor, self.controller, self.reachability, self.follower)
        return MapNavigation(self._find_way, follower, self.topomap, goals, self.replans)

    def _find_way(self, observation: Observation, goals: Goals, excluded: set[int]) -> Plan:
        return self.planner.plan(observation, goals, self.topomap, excluded)
