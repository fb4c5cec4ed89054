"""What one robot of Neural Topological SLAM remembers, and where it is going."""

from dataclasses import dataclass, field

import numpy as np

from tutorial_lib.exploration.ghost_graph import Ghost
from tutorial_lib.exploration.graph_update import Memory
from tutorial_lib.geometry import Array

ARRIVED = 0.4
"""Metres from where a robot is going, or from the end of the path to it, at which it is there."""
_TIMEOUT = 50  # steps in which a robot must come nearer to where it is going
_NEARER = 0.1  # metres that count as nearer


@dataclass(frozen=True, eq=False)
class Destination:
    """Where a robot is going over its graph.

    Attributes:
        node: of the graph.
        place: (2,) in that node's frame.
        ghost: that is there, if any.
    """

    node: int
    place: Array
    ghost: Ghost | None = None


@dataclass(eq=False)
class ExploringRobot:
    """One robot: what it remembers, and where it is going.

    Attributes:
        rng: its own, so that what it draws does not depend on other robots.
        memory: its graph.
        scores: (K,) of each node's directions.
        destination: None where it has to choose.
        reached: whether it is there, or does not come nearer.
    """

    rng: np.random.Generator
    memory: Memory = field(default_factory=Memory)
    scores: list[Array] = field(default_factory=list)
    destination: Destination | None = None
    reached: bool = False
    _target: Array = field(default_factory=lambda: np.full(2, np.inf))
    _nearest: float = np.inf
    _waited: int = 0

    def go_to(self, destination: Destination | None) -> None:
        """Go there from now on."""
        self.destination, self.reached = destination, False
        self.interrupt()

    def interrupt(self) -> None:
        """It goes elsewhere for a while: that it does not come nearer says nothing."""
        self._nearest, self._waited = np.inf, 0

    def is_valid(self) -> bool:
        """Whether it is going anywhere, and the ghost there was not explored meanwhile."""
        if self.destination is None:
            return False
        ghost = self.destination.ghost
        return ghost is None or (ghost.node, ghost.direction) in self.memory.graph.ghosts

    def watch(self, target: Array, here: Array, left: float, last: bool) -> None:
        """Notice that the destination is reached, or that it cannot be.

        Args:
            target: (2,) the point that it drives to.
            here: (2,) where it is.
            left: metres to the end of the path.
            last: whether the target is the destination.
        """
        gap = float(np.linalg.norm(target - here))
        if np.linalg.norm(target - self._target) > 2 * ARRIVED:
            self._nearest, self._waited, self._target = np.inf, 0, target
        if gap < self._nearest - _NEARER:
            self._nearest, self._waited = gap, 0
        self._waited += 1
        self.reached = self._waited > _TIMEOUT or (last and min(gap, left) < ARRIVED)
