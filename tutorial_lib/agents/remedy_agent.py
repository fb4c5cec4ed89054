"""The system of Meng 2020 with remedies for places that look alike."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.agents.place_guess import PlaceGuess
from tutorial_lib.agents.remedies import Remedies, Tools
from tutorial_lib.agents.remedy_navigation import RemedyNavigation
from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import Goals
from tutorial_lib.topology.localization import FilterSettings
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.topology.planner import DijkstraPlanner
from tutorial_lib.validation import instance, whole

SEQUENCE = 4
"""Anchors before and after both ends of an edge, and of one that is replaced, that must match."""


@dataclass(kw_only=True)
class RemedyAgent(MengAgent):
    """Meng's agent with remedies; see `MapAgent` and `MengAgent` for the other parts.

    Attributes:
        remedies: that are on.
        filter_settings: of the Bayes filter.
    """

    remedies: Remedies = field(default_factory=Remedies)
    filter_settings: FilterSettings = field(default_factory=FilterSettings)

    def __post_init__(self) -> None:
        instance("remedies", self.remedies, Remedies)
        instance("filter_settings", self.filter_settings, FilterSettings)
        instance("planner", self.planner, DijkstraPlanner)  # it is given other localizers
        super().__post_init__()

    def with_remedies(self, remedies: Remedies) -> RemedyAgent:
        """The same agent with other remedies, and what it has learned so far.

        Raises:
            InputError: when its map was built with sequences and this one's is not, or conversely.
        """
        if instance("remedies", remedies, Remedies).sequence != self.remedies.sequence:
            raise InputError("remedies: a map is built with sequences or without; learn again")
        other = replace(self, remedies=remedies)
        other.topomap, other._targets = self.topomap, self._targets  # encoded once for all
        return other

    def empty_map(self) -> TopoMap:
        """A map whose edges, and reused vertices, rest on sequences or on single anchors."""
        reach = SEQUENCE if self.remedies.sequence else 0
        settings = replace(self.settings, sequence=reach, reuse_sequence=reach)
        return TopoMap(self.reachability, settings)

    def start(self, goals: Sequence[Goals]) -> RemedyNavigation:
        """Send robots to one goal each; see `MapAgent`."""
        *parts, replan_time = self._parts(goals)
        replan_time = replan_time if self.remedies.replan else 0.0
        return RemedyNavigation(self._tools(), *parts, replan_time)

    def guess(self, robots: int) -> PlaceGuess:
        """Localizes so many robots, which may be anywhere.

        Raises:
            InputError: when nothing was learned.
        """
        whole("robots", robots, least=0, most=1_000_000)
        self._check_map()
        contexts = self.topomap.vertices.contexts[np.arange(len(self.topomap.vertices))]
        return PlaceGuess(robots, self.topomap, self._tools(), self.predictor.prepare(contexts))

    def _tools(self) -> Tools:
        planner = instance("planner", self.planner, DijkstraPlanner)
        return Tools(planner, self.predictor, self.remedies, self.filter_settings)
