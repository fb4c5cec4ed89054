"""Lifelong Topological Visual Navigation: a sampled map that mends itself while robots use it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.agents.ltvn_navigation import LTVNNavigation
from tutorial_lib.agents.ltvn_state import TravelSettings
from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Controller, Experience, Goals, RelativeModel
from tutorial_lib.se2 import wrap
from tutorial_lib.topology.maintenance import Maintenance, MaintenanceRules
from tutorial_lib.topology.mapping.image_pool import ImagePool
from tutorial_lib.topology.mapping.sampling_map import SampledMap, SamplingRules, sampled_map
from tutorial_lib.topology.mapping.sparsify import contextified
from tutorial_lib.topology.mapping.turn_edges import TurnSettings
from tutorial_lib.validation import instance, instances, number, one_of, whole, with_methods

BACKING = RMPController(reverse_cost=0.3)
"""Drives in reverse where it can."""
TURNS = TurnSettings(reach=0.6)
"""Nearer than for Meng's map: where it has turned a robot must be at the target."""

TWINS = ("controller", "backing", "maintenance", "travel")
"""Attributes in which agents on the same map may differ."""


@dataclass(kw_only=True)
class LTVNAgent:
    """Builds a map by sampling, navigates over it, and keeps it up to date.

    Attributes:
        model: reachability and relative pose of two images.
        controller: drives to a waypoint.
        backing: the same along edges in reverse.
        rules: of the map.
        maintenance: what traversals change; nothing if None.
        travel: thresholds of navigation.
        apart: metres, or `turned` rad, from one image of a drive to the next by odometry.
        turned: see `apart`.
        turns: when images that look different ways are joined by turning; never if None (ours).
        seed: of the order in which images are sampled.
        sampled: the map, empty at first.
        frames: (M,) of each image of its pool, on its drive.
        upkeep: its maintenance.
    """

    model: RelativeModel
    controller: Controller = field(default_factory=RMPController)
    backing: Controller = BACKING
    rules: SamplingRules = field(default_factory=SamplingRules)
    maintenance: MaintenanceRules | None = field(default_factory=MaintenanceRules)
    travel: TravelSettings = field(default_factory=TravelSettings)
    apart: float = 0.64
    turned: float = 0.7
    turns: TurnSettings | None = TURNS
    seed: int = 0

    def __post_init__(self) -> None:
        with_methods("model", self.model, "prepare", "predict")
        with_methods("controller", self.controller, "act")
        with_methods("backing", self.backing, "act")
        instance("rules", self.rules, SamplingRules)
        if self.maintenance is not None:
            instance("maintenance", self.maintenance, MaintenanceRules)
        instance("travel", self.travel, TravelSettings)
        number("apart", self.apart, above=0.0)
        number("turned", self.turned, above=0.0)
        if self.turns is not None:
            instance("turns", self.turns, TurnSettings)
        whole("seed", self.seed, least=0)
        self.frames = np.empty(0, dtype=np.intp)
        self.use(SampledMap(ImagePool(self.model), self.rules))

    def learn(self, experiences: Sequence[Experience]) -> None:
        """Build a map of drives; it replaces what was learned before.

        Raises:
            InputError: when one is no `Experience`, or there is none.
        """
        seen, frames = [], []
        for experience in instances("experiences", experiences, Experience, empty=False):
            observations = experience.observations
            contexts = contextified(self.model.view.of(observations), self.model.k)
            kept = spaced(observations.odometry, self.apart, self.turned)
            seen.append((observations[kept], contexts[kept]))
            frames.append(kept)
        rng = np.random.default_rng(self.seed)
        self.frames = np.concatenate(frames)
        sampled = sampled_map(self.model, self.rules, seen, rng)
        if self.turns is not None:
            sampled.join_by_turning(self.turns)
        self.use(sampled)

    def use(self, sampled: SampledMap) -> None:
        """Navigate over a map that is there already."""
        self.sampled = instance("sampled", sampled, SampledMap)
        rules = MaintenanceRules() if self.maintenance is None else self.maintenance
        price, noise = sampled.rules.reverse or 1.0, sampled.rules.spread**2
        self.upkeep = Maintenance(sampled.graph, rules, price, noise)

    def twin(self, **changed: Any) -> LTVNAgent:  # noqa: ANN401 - of its attributes
        """An agent with a copy of this one's map, whose maintenance begins anew.

        Args:
            changed: attributes that a map does not depend on, see `TWINS`.
        """
        for name in changed:
            one_of("changed", name, TWINS)
        made = replace(self, **changed)
        made.frames = self.frames
        made.use(self.sampled.copy())
        return made

    def start(self, goals: Sequence[Goals]) -> LTVNNavigation:
        """Send robots to one goal each; all mend the same map.

        Raises:
            InputError: when nothing was learned.
        """
        if not len(self.sampled.pool):
            raise InputError("map: none; let the agent learn first")
        return LTVNNavigation(
            self.sampled,
            self.upkeep,
            (self.controller, self.backing),
            goals,
            self.travel,
            mends=self.maintenance is not None,
        )


def spaced(odometry: Array, apart: float, turned: float) -> NDArray[np.intp]:
    """Frames (K,) of a drive, each `apart` metres or `turned` rad from the one before."""
    kept = [0]
    for frame, pose in enumerate(odometry):
        last = odometry[kept[-1]]
        far = np.hypot(*(pose - last)[:2]) >= apart
        if far or abs(float(wrap(pose[2] - last[2]))) >= turned:
            kept.append(frame)
    return np.array(kept)
