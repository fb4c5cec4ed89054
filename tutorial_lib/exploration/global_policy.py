"""The global policy (Chaplot et al. 2020, 4.1): which ghost to go to, and by which nodes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tutorial_lib.exploration.ghost_graph import Ghost
from tutorial_lib.exploration.graph_update import Memory
from tutorial_lib.exploration.labels import MAX_DISTANCE
from tutorial_lib.se2 import Array, to_world
from tutorial_lib.validation import flag, number

_ONE_OPENING = 1.0  # metres between ghosts that lead to the same place
_PASSED = 0.8  # metres from a node on the path at which a robot goes on to the next


@dataclass(frozen=True)
class GhostChoice:
    """How ghosts are compared.

    Attributes:
        travel_weight: of the distance to a ghost against its score, both in metres; the paper's
            rule, the highest score, has 0.
        combine_views: ghosts of several nodes at one place share the mean of their scores.
        reserve_penalty: of score, for directions of the reserve; by default they are not compared
            with ghosts, and only used when these run out.
    """

    travel_weight: float = 0.0
    combine_views: bool = False
    reserve_penalty: float = np.inf

    def __post_init__(self) -> None:
        number("travel_weight", self.travel_weight)
        flag("combine_views", self.combine_views)
        number("reserve_penalty", self.reserve_penalty, least=0.0, infinite=True)


def choose_ghost(
    memory: Memory, scores: Array, settings: GhostChoice, rng: np.random.Generator
) -> Ghost | None:
    """The best ghost; where there is none, the best of the reserve; None where there is neither.

    Changes the graph: a chosen direction of the reserve becomes a ghost, and all of them do once
    there is no ghost left.

    Args:
        memory: of the robot.
        scores: (V, K) of each node's directions, see `ExplorationModel.scores`.
        settings: how ghosts are compared.
        rng: breaks ties.
    """
    graph = memory.graph
    if not graph.ghosts:
        graph.use_reserve()
    reserve = list(graph.reserve.values()) if np.isfinite(settings.reserve_penalty) else []
    ghosts = [*graph.ghosts.values(), *reserve]
    if not ghosts:
        return None
    places = ghost_places(memory, ghosts)
    values = np.array([scores[ghost.node, ghost.direction] for ghost in ghosts], dtype=float)
    if settings.combine_views:
        together = np.linalg.norm(places[:, None] - places, axis=2) < _ONE_OPENING
        values = together @ values / together.sum(axis=1)
    if reserve:
        values[-len(reserve) :] -= settings.reserve_penalty
    metres = travel(memory, ghosts, places)
    values = values - settings.travel_weight * metres / MAX_DISTANCE
    best = np.flatnonzero(values == values.max())
    chosen = ghosts[int(best[rng.integers(len(best))])]
    graph.promote(chosen)
    return chosen


def travel(memory: Memory, ghosts: list[Ghost], places: Array) -> Array:
    """Metres (G,) from a robot to ghosts at `places` (G, 2), along the graph."""
    metres, _ = memory.graph.shortest(memory.node)
    nodes = np.array([ghost.node for ghost in ghosts])
    from_node = metres[nodes] + np.array([ghost.metres for ghost in ghosts])
    straight = np.linalg.norm(places - memory.offset[:2], axis=1)
    return np.where(nodes == memory.node, straight, from_node)


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
