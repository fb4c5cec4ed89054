"""What a robot saw wherever it looked, and from where."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.interfaces import ExplorationModel
from tutorial_lib.se2 import Array, compose, to_world

_SAME = 1.5  # metres between two estimates of one goal, at most


@dataclass(eq=False)
class Looks:
    """Every look of one robot.

    Attributes:
        poses: (3,) of the robot, in the frame of its odometry.
        features: (D,) of its panorama.
    """

    poses: list[Array] = field(default_factory=list)
    features: list[NDArray[np.float32]] = field(default_factory=list)

    def __len__(self) -> int:
        return len(self.poses)

    def keep(self, pose: Array, features: NDArray[np.float32]) -> None:
        """Add a look."""
        self.poses.append(np.array(pose, float))
        self.features.append(features)

    def absorb(self, other: Looks, motion: Array) -> None:
        """Take over looks whose frame is at `motion` (3,) in this one."""
        self.poses += [compose(motion, pose) for pose in other.poses]
        self.features += other.features

    def places(self, model: ExplorationModel, goal: NDArray[np.float32], least: float) -> Array:
        """Where a goal (D,) was seen, (S, 2), the most probable first, from `least` of F_L on."""
        if not len(self):
            return np.zeros((0, 2))
        features = np.stack(self.features)
        goals = np.repeat(goal[None], len(features), axis=0)
        likely = model.same_node(features, goals)
        order = np.argsort(-likely, kind="stable")
        order = order[likely[order] >= least]
        bearing, metres = model.relative(features[order], goals[order]).T
        local = metres[:, None] * np.stack([np.cos(bearing), np.sin(bearing)], axis=1)
        return to_world(np.reshape([self.poses[i] for i in order], (-1, 3)), local)


def not_at(places: Array, place: Array) -> Array:
    """Those of the places (S, 2) that do not mean one (2,) where the goal was not."""
    return places[np.linalg.norm(places - place, axis=1) > _SAME]
