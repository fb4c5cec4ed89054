"""What one robot saw wherever it looked, and where in its graph that was."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.interfaces import ExplorationModel
from tutorial_lib.se2 import Array, compose, to_world

_SAME = 1.5  # metres between two estimates of one goal, at most


@dataclass(frozen=True, eq=False)
class Sight:
    """A goal as an old look shows it.

    Attributes:
        node: in whose frame the look was taken.
        place: (2,) of the goal in that frame, by F_R.
        probability: of F_L that the look shows the goal.
    """

    node: int
    place: Array
    probability: float


@dataclass(eq=False)
class Looks:
    """Every look of one robot.

    Attributes:
        nodes: the node that it was in.
        poses: (3,) its pose in that node's frame.
        features: (D,) of its panorama.
    """

    nodes: list[int] = field(default_factory=list)
    poses: list[Array] = field(default_factory=list)
    features: list[NDArray[np.float32]] = field(default_factory=list)

    def __len__(self) -> int:
        return len(self.nodes)

    def keep(self, node: int, pose: Array, features: NDArray[np.float32]) -> None:
        """Add a look."""
        self.nodes.append(node)
        self.poses.append(np.array(pose, float))
        self.features.append(features)

    def absorb(self, other: Looks, shift: int) -> None:
        """Take over the looks of a graph whose nodes are `shift` higher now."""
        self.nodes += [node + shift for node in other.nodes]
        self.poses += other.poses
        self.features += other.features

    def of(self, model: ExplorationModel, goal: NDArray[np.float32], least: float) -> list[Sight]:
        """Where a goal (D,) was seen, the most probable first, from `least` of F_L on."""
        if not len(self):
            return []
        features = np.stack(self.features)
        goals = np.repeat(goal[None], len(features), axis=0)
        likely = model.same_node(features, goals)
        order = np.argsort(-likely, kind="stable")
        order = order[likely[order] >= least]
        bearing, metres = model.relative(features[order], goals[order]).T
        local = np.stack([metres * np.cos(bearing), metres * np.sin(bearing), 0 * metres], axis=1)
        poses = compose(np.reshape([self.poses[i] for i in order], (-1, 3)), local)
        rows = zip(order.tolist(), poses[:, :2], strict=True)
        return [Sight(self.nodes[i], place, float(likely[i])) for i, place in rows]


def not_at(sights: list[Sight], place: Array, poses: Array | None = None) -> list[Sight]:
    """The sights that do not mean a place (2,), where the goal was not.

    Args:
        sights: of the goal.
        place: (2,).
        poses: (V, 3) of the sights' nodes in the frame of the place; one frame unless given.
    """
    poses = np.zeros((1 + max((s.node for s in sights), default=0), 3)) if poses is None else poses
    places = [to_world(poses[sight.node], sight.place) for sight in sights]
    return [
        sight
        for sight, there in zip(sights, places, strict=True)
        if np.linalg.norm(there - place) > _SAME
    ]
