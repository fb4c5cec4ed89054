"""What an agent with ghost nodes remembers at one moment, for pictures and tables."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.exploration.exploring_robot import ExploringRobot
from tutorial_lib.exploration.global_policy import ghost_places
from tutorial_lib.se2 import Array, to_world


@dataclass(frozen=True, eq=False)
class GhostMoment:
    """A graph with V nodes and G ghosts, in the frame of the robot's odometry.

    Attributes:
        nodes: (V, 2).
        edges: pairs of nodes.
        ghosts: (G, 2).
        hosts: (G,) the node on which each ghost hangs.
        directions: (G,) of each ghost in its node's frame.
        scores: (G,) of each ghost.
        here: the node in which the robot is; -1 where there is none.
        chosen: the ghost to which it goes; -1 for none.
        path: (P, 2) from the robot over nodes to its destination; empty where it has none.
    """

    nodes: Array
    edges: list[tuple[int, int]]
    ghosts: Array
    hosts: NDArray[np.intp]
    directions: NDArray[np.intp]
    scores: Array
    here: int
    chosen: int
    path: Array


def ghost_moment(robot: ExploringRobot, odometry: Array) -> GhostMoment:
    """What a robot at `odometry` (3,) remembers.

    Args:
        robot: of an agent that has acted on what it saw there.
        odometry: its pose.
    """
    memory, none = robot.memory, np.zeros((0, 2))
    graph = memory.graph
    if not len(graph):
        empty = np.zeros(0, np.intp)
        return GhostMoment(none, [], none, empty, empty, np.zeros(0), -1, -1, none)
    poses, ghosts = graph.poses_from(memory.node), list(graph.ghosts.values())
    keys = np.array([(ghost.node, ghost.direction) for ghost in ghosts], np.intp).reshape(-1, 2)
    chosen, path = -1, none
    if robot.destination is not None:
        place, ghost = robot.destination, robot.destination.ghost
        nodes = graph.path(memory.node, place.node)[1:]
        points = [*poses[nodes, :2], to_world(poses[place.node], place.place)]
        path = np.concatenate([odometry[None, :2], memory.in_odometry(np.array(points))])
        chosen = ghosts.index(ghost) if ghost in ghosts else -1
    return GhostMoment(
        nodes=memory.in_odometry(poses[:, :2]),
        edges=[(a, b) for a, around in enumerate(graph.edges) for b in around if a < b],
        ghosts=memory.in_odometry(ghost_places(memory, ghosts)) if ghosts else none,
        hosts=keys[:, 0],
        directions=keys[:, 1],
        scores=np.array([robot.scores[node][direction] for node, direction in keys]),
        here=memory.node,
        chosen=chosen,
        path=path,
    )
