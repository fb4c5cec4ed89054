"""The system of Meng 2020: a sparse map of reachable images, planned on and followed by sight."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from tutorial_lib.agents.navigator import MapAgent
from tutorial_lib.interfaces import Edges, Experience, Goals, Observation, Plan, Planner
from tutorial_lib.topology.mapping.anchors import Anchors, anchors_of
from tutorial_lib.topology.mapping.edge_rules import MapSettings
from tutorial_lib.topology.mapping.insertion import add_trajectory
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.topology.mapping.turn_edges import TurnSettings, add_turns
from tutorial_lib.topology.planner import DijkstraPlanner, checked_plan
from tutorial_lib.validation import instance, instances, number, with_methods


@dataclass(kw_only=True)
class MengAgent(MapAgent):
    """Builds a map from trajectories and navigates over it; see `MapAgent` for the other parts.

    Attributes:
        planner: plans paths over the map.
        settings: of the map.
        p_sparsify: RE by which anchors are chosen.
        turns: when places are joined by turning; never if None.
    """

    planner: Planner = field(default_factory=DijkstraPlanner)
    settings: MapSettings = field(default_factory=MapSettings)
    p_sparsify: float = 0.99
    turns: TurnSettings | None = field(default_factory=TurnSettings)

    def __post_init__(self) -> None:
        with_methods("planner", self.planner, "plan")
        instance("settings", self.settings, MapSettings)
        number("p_sparsify", self.p_sparsify, least=0.0, most=1.0)
        if self.turns is not None:
            instance("turns", self.turns, TurnSettings)
        super().__post_init__()

    def empty_map(self) -> TopoMap:
        """A map whose edges are RE's."""
        return TopoMap(self.reachability, self.settings)

    def learn(self, experiences: Sequence[Experience]) -> None:
        """Sparsify each trajectory and insert it into the map.

        Raises:
            InputError: when one is no `Experience`, before any is learned.
        """
        for experience in instances("experiences", experiences, Experience):
            self.insert(self.sparsified(experience))

    def sparsified(self, experience: Experience) -> Anchors:
        """The anchors of a trajectory."""
        seen = instance("experience", experience, Experience).observations
        view, k = self.predictor.view, self.predictor.k
        return anchors_of(
            self.reachability, seen, view.of(seen), k, self.p_sparsify, experience.timestamps
        )

    def insert(self, anchors: Anchors) -> None:
        """Add a trajectory to the map, and join it by turning to what was there."""
        instance("anchors", anchors, Anchors)
        added = add_trajectory(self.topomap, anchors)
        if self.turns is not None:
            add_turns(self.topomap, anchors, added.path, self.turns)

    def find_path(self, observation: Observation, goals: Goals, excluded: Edges) -> Plan:
        """The planner's path.

        Raises:
            InputError: when it is no path over vertices of the map to one of the goal's images, or
                takes an excluded edge.
        """
        instance("observation", observation, Observation)
        instance("goals", goals, Goals)
        plan = self.planner.plan(observation, goals, self.topomap, excluded)
        return checked_plan(plan, self.topomap, goals, excluded)
