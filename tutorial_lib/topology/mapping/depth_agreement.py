"""Whether two depth images can be views of one place from the predicted poses (ours)."""

import numpy as np

from tutorial_lib.se2 import Array, to_world
from tutorial_lib.validation import alike, floats

_OFF = 0.25  # metres, or that share of the distance, by which lengths may differ


def depth_agreement(sources: Array, targets: Array, waypoints: Array, bearings: Array) -> Array:
    """(N,) the share of what a target measures that its source measures there, too.

    The ends of the target's rays are carried into the source's frame by the predicted waypoint. Of
    those in the source's field of view one agrees if the ray of its column is as long; one that is
    farther away is hidden and says nothing. A pair without any such end has 0.

    Args:
        sources: (N, W) metres along each column's ray, left to right.
        targets: (N, W) the same of the targets.
        waypoints: (N, 3) poses of the targets, predicted from the sources.
        bearings: (W,) rad of the columns' rays, falling from left to right.
    """
    sources = floats("sources", sources, ("N", "W"))
    targets = floats("targets", targets, ("N", "W"))
    waypoints = floats("waypoints", waypoints, ("N", 3))
    bearings = floats("bearings", bearings, (sources.shape[1],))
    alike(sources=sources, targets=targets, waypoints=waypoints)
    ends = targets[..., None] * np.stack([np.cos(bearings), np.sin(bearings)], axis=-1)
    seen = to_world(waypoints[:, None], ends)
    bearing, metres = np.arctan2(seen[..., 1], seen[..., 0]), np.hypot(seen[..., 0], seen[..., 1])
    column = np.searchsorted(-bearings, -bearing).clip(0, len(bearings) - 1)
    inside = (bearing <= bearings[0]) & (bearing >= bearings[-1])
    measured = np.take_along_axis(sources, column, axis=1)
    within = _OFF * np.maximum(1.0, metres)
    agrees = inside & (np.abs(metres - measured) <= within)
    against = inside & (metres < measured - within)  # the source looks through it
    counted = agrees.sum(axis=1) + against.sum(axis=1)
    return agrees.sum(axis=1) / np.maximum(counted, 1)
