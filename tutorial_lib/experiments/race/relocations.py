"""When robots that were carried find themselves in their graphs again, and whether rightly."""

import numpy as np

from tutorial_lib.agents.lifelong import LifelongAgent
from tutorial_lib.exploration.graph_update import Memory
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import SequentialExplorer
from tutorial_lib.se2 import compose, inverse, relative


class Relocations:
    """Watches an agent that begins another graph when it was carried; of others it knows nothing.

    Attributes:
        again: (N,) actions of this visit until a robot joined its graphs; infinite where it did
            not, not a number where nobody carried it.
        wrong: (N,) metres between where it is and where it took itself to be then.
    """

    def __init__(self, task: ExplorationTask, agent: SequentialExplorer) -> None:
        """Watch `agent`, and read true poses from `task`."""
        self._task = task
        self._agent = agent if isinstance(agent, LifelongAgent) else None
        self._true: dict[int, dict[int, Array]] = {}  # poses of nodes, by memory and number

    def begin(self, *, carried: bool) -> None:
        """A visit begins."""
        count, self._steps = len(self._task), 0
        self.again = np.full(count, np.inf if carried and self._agent else np.nan)
        self.wrong, self._apart = np.full(count, np.nan), np.zeros(count, np.intp)

    def look(self) -> None:
        """The agent has chosen actions at the task's present poses."""
        if self._agent is None:
            return
        self._steps += 1
        rows = zip(self._agent.robots, self._agent.islands, self._task.poses, strict=True)
        for number, (robot, islands, pose) in enumerate(rows):
            memory = robot.memory
            joined = len(islands.left) < self._apart[number]
            self._apart[number] = len(islands.left)
            if memory.node >= 0 and not joined:
                here = compose(pose, inverse(memory.offset))
                self._true.setdefault(id(memory), {}).setdefault(memory.node, here)
            if joined and self.again[number] == np.inf:
                self.again[number] = self._steps
                self.wrong[number] = self._off(memory, pose)

    def _off(self, memory: Memory, pose: Array) -> float:
        """Metres between a robot's true pose and where it takes itself to be in its graph."""
        true, metres = self._true[id(memory)], memory.graph.metres_from(memory.node)
        node = min(true, key=lambda node: metres[node])
        believed = compose(memory.graph.poses_from(node)[memory.node], memory.offset)
        return float(np.linalg.norm(relative(true[node], pose)[:2] - believed[:2]))
