"""Pairs of a start and a target along recorded trajectories, for learning waypoints."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.data.perturbation import Perturbation, perturbed
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.geometry import Array
from tutorial_lib.learning.labels import Labels, label, waypoint_labels
from tutorial_lib.world.visibility import FIELD_OF_VIEW


@dataclass(frozen=True)
class WaypointPairs:
    """Starts and targets of one world, S starts for each of G targets.

    Attributes:
        starts: (G, S, 3) poses.
        sources: (G, S) the recorded frame that each start is perturbed from.
        goals: (G, 3) poses of the targets.
        contexts: (G, 2k+1, 3) poses of the target's images.
        labels: of all pairs, (G * S) of them.
        valid: (G, S) whether the pair has a label.
    """

    starts: Array
    sources: NDArray[np.intp]
    goals: Array
    contexts: Array
    labels: Labels
    valid: NDArray[np.bool_]


def draw_waypoint_pairs(
    recorded: RecordedWorld,
    targets: int,
    starts: int,
    k: int,
    perturbation: Perturbation,
    rng: np.random.Generator,
    close: float = 0.0,
    field_of_view: float = FIELD_OF_VIEW,
) -> WaypointPairs:
    """Draw pairs of which the target is 1 m behind to 3 m ahead of the start.

    So are those of Table I (Meng 2020, III-B). The paper's C learns from two images of a trajectory
    "with certain visual overlap" (IV).

    Args:
        recorded: trajectories of one world.
        targets: G, the number of targets.
        starts: S, the number of starts for each.
        k: frames of context on either side.
        perturbation: of the starts.
        rng: of everything drawn.
        close: see `RecordedWorld.draw`.
        field_of_view: radians of the camera, for the overlaps.
    """
    scene = recorded.scene
    sources, frames = recorded.draw(targets, starts, rng, close)
    moved, found = perturbed(scene, recorded.poses[sources], perturbation, rng)
    goals = np.repeat(frames, starts)
    waypoints, sees = waypoint_labels(scene.caster, moved, recorded.poses, sources, goals)
    return WaypointPairs(
        moved.reshape(targets, starts, 3),
        sources.reshape(targets, starts),
        recorded.poses[frames],
        recorded.poses[recorded.context(frames, k)],
        label(scene.caster, moved, recorded.poses[goals], waypoints, field_of_view),
        (found & sees).reshape(targets, starts),
    )
