"""What a robot on LTVN's map knows: where it drives, how it got there, what failed."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tutorial_lib.se2 import Array
from tutorial_lib.topology.maintenance import Edge
from tutorial_lib.validation import number

GOAL = -1
"""The goal, in place of a vertex."""


@dataclass(frozen=True)
class TravelSettings:
    """Thresholds of navigation.

    Attributes:
        sure: r-hat above which a robot counts a vertex as seen among all, or the goal.
        near: the same among vertices next to its last path, and of the target where it arrives.
        doubt: r-hat of an edge's target below which the robot does not set off (ours).
        localize: D_l, length within which the robot is at a vertex.
        executed: metres from a waypoint within which the robot has driven there.
        arrival: metres to a target within which an arrival there is strict.
        goal: metres to the goal, as it is predicted, within which a robot declares to be there.
        strict: whether success needs both; else, as in the paper, that the target is connectable.
        trust: whether a robot that arrived counts as being there.
        patience: seconds that an edge which failed is avoided.
        search: seconds of turning after which a robot that cannot localize gives up.
        slow: seconds a metre after which a traversal has failed, twice as many in reverse; and
            `spare` seconds more.
        spare: see `slow`.
    """

    sure: float = 0.8
    near: float = 0.5
    doubt: float = 0.1
    localize: float = 1.5
    executed: float = 0.25
    arrival: float = 0.8
    goal: float = 0.35
    strict: bool = True
    trust: bool = True
    patience: float = 60.0
    search: float = 20.0
    slow: float = 3.0
    spare: float = 3.0

    def __post_init__(self) -> None:
        for name in ("sure", "near", "doubt"):
            number(name, getattr(self, name), least=0.0, most=1.0)
        for name in ("localize", "executed", "arrival", "goal", "search", "slow"):
            number(name, getattr(self, name), above=0.0)
        for name in ("patience", "spare"):
            number(name, getattr(self, name), least=0.0)


@dataclass
class Leg:
    """What a robot drives now.

    Attributes:
        source: vertex where it is localized.
        target: vertex that it drives to, or `GOAL`.
        kind: how it was localized.
        arrived_by: edge on which it came to the source.
        measured: d(w) of the target as seen from where it set off; none if it was not seen.
        aim: (3,) the target in the odometry's frame.
        until: seconds at which it has failed.
        reverse: whether it drives there in reverse.
        turn: whether it turns where it stands.
        closest: metres to the aim so far, at least; of a turn 0 once it faces as it should.
    """

    source: int
    target: int
    kind: str
    arrived_by: Edge | None
    measured: float | None
    aim: Array
    until: float
    reverse: bool = False
    turn: bool = False
    closest: float = np.inf


@dataclass
class RobotState:
    """What one robot knows of its way to the goal.

    Attributes:
        goal: the goal's image, prepared.
        exits: vertices from which the goal is seen, and its waypoints (3,) from there.
        leg: what it drives now.
        path: the last plan.
        trusted: where it has just arrived: the vertex, how it is known, the edge on which it came,
            and the vertex's pose; None once it looks around.
        avoided: edges that failed, until when.
        searched: steps that it has turned without knowing where it is.
    """

    goal: Any
    exits: dict[int, Array]
    leg: Leg | None = None
    path: list[int] = field(default_factory=list)
    trusted: tuple[int, str, Edge | None, Array] | None = None
    avoided: dict[Edge, float] = field(default_factory=dict)
    searched: int = 0
