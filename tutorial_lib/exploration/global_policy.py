"""The global policy (Chaplot et al. 2020, 4.1): which ghost to go to, and by which nodes."""

import numpy as np

from tutorial_lib.exploration.ghost_graph import Ghost
from tutorial_lib.exploration.graph_update import Memory
from tutorial_lib.se2 import Array, to_world

_PASSED = 0.8  # metres from a node on the path at which a robot goes on to the next


def choose_ghost(memory: Memory, scores: Array, rng: np.random.Generator) -> Ghost | None:
    """The best ghost; where there is none, the best of the reserve; None where there is neither.

    Changes the graph: once there is no ghost left, every direction of the reserve becomes one.

    Args:
        memory: of the robot.
        scores: (V, K) of each node's directions, see `ExplorationModel.scores`.
        rng: breaks ties.
    """
    graph = memory.graph
    if not graph.ghosts:
        graph.use_reserve()
    if not graph.ghosts:
        return None
    ghosts = list(graph.ghosts.values())
    values = np.array([scores[ghost.node, ghost.direction] for ghost in ghosts], dtype=float)
    best = np.flatnonzero(values == values.max())
    return ghosts[int(best[rng.integers(len(best))])]


def ghost_places(memory: Memory, ghosts: list[Ghost]) -> Array:
    """Where ghosts are (G, 2), in the frame of the robot's node."""
    poses = memory.graph.poses_from(memory.node)
    return np.array([to_world(poses[g.node], memory.graph.place_of(g)) for g in ghosts])


def subgoal(memory: Memory, node: int, place: Array) -> tuple[Array, bool]:
    """Where to go now on the path to a place at another node.

    A robot that passes a node of the path is in that node from then on.

    Args:
        memory: of the robot.
        node: at which the place is.
        place: (2,) in that node's frame.

    Returns:
        (2,) in the frame of the robot's odometry, the next node of the path or the place; and
        whether it is the place.
    """
    for other in memory.graph.path(memory.node, node)[1:]:
        pose = memory.graph.edges[memory.node][other]
        if np.linalg.norm(pose[:2] - memory.offset[:2]) > _PASSED:
            return memory.in_odometry(pose[:2]), False
        memory.enter(other)
    return memory.in_odometry(place), True
