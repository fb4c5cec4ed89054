"""Remedies for places that look alike, each of which can be left out.

Meng 2020, III-G names the first two and, as future work, the third; the fourth and recovery are the
field's: users of its successors ask for them.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

from tutorial_lib.interfaces import WaypointPredictor
from tutorial_lib.topology.localization import FilterSettings
from tutorial_lib.topology.planner import DijkstraPlanner
from tutorial_lib.validation import flag, one_of


@dataclass(frozen=True)
class Remedies:
    """Which remedies are on.

    Attributes:
        sequence: sequences are matched, in map building and where the robot looks for its vertex;
            otherwise single views are. Turns, which no sequence confirms, are for goals that no
            other path leads to.
        replan: a robot that is lost plans again, and so does one that is long in dead reckoning.
        cycles: visits of vertices are counted; in a cycle the robot plans around them.
        filter: a Bayes filter localizes the robot, and recovery begins when it is off the map;
            otherwise the most similar vertex is taken.
    """

    sequence: bool = True
    replan: bool = True
    cycles: bool = True
    filter: bool = True

    def __post_init__(self) -> None:
        for name in _PARTS:
            flag(name, getattr(self, name))

    @classmethod
    def named(cls, name: str) -> Remedies:
        """Those of a row of the experiment.

        Raises:
            InputError: for an unknown name.

        >>> Remedies.named("no_filter")
        Remedies(sequence=True, replan=True, cycles=True, filter=False)
        """
        one_of("name", name, REMEDIES)
        which = name.removeprefix("no_")
        if which in ("none", "all"):
            return cls(*[which == "all"] * len(_PARTS))
        return cls(**{part: (part == which) != name.startswith("no_") for part in _PARTS})


_PARTS = tuple(one.name for one in fields(Remedies))
REMEDIES = ("none", *_PARTS, *(f"no_{part}" for part in _PARTS), "all")
"""None, each alone, all but one, and all."""


@dataclass(frozen=True, eq=False)
class Tools:
    """What remedies need.

    Attributes:
        planner: plans paths over the map.
        predictor: C_WP.
        remedies: that are on.
        filter_settings: of the Bayes filter.
    """

    planner: DijkstraPlanner
    predictor: WaypointPredictor
    remedies: Remedies
    filter_settings: FilterSettings
