"""The seams: what an agent sees, and the small interfaces its parts have.

Anything with the right method fits: a network, an oracle, a student's function. Everything comes in
batches, so the first axis of every array counts robots, images or pairs.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Observation:
    """All that an agent ever gets, for N robots at once.

    Attributes:
        image: (N, H, W, 3) uint8 RGB, left column = left of view.
        depth: (N, W) float metres for each image column, or None where there is no depth camera.
        laser: (N, B) float metres, B beams over the full circle, from -pi counter-clockwise.
        odometry: (N, 3) pose since the start, as the wheels tell it; it drifts.
        speed: (N,) m/s, negative in reverse.
        steering: (N,) the car's steering angle in rad; for a differential drive its rad/s.
    """

    image: NDArray[np.uint8]
    depth: NDArray[np.floating] | None
    laser: NDArray[np.floating]
    odometry: NDArray[np.float64]
    speed: NDArray[np.float64]
    steering: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.odometry)

    def __getitem__(self, index: Any) -> Observation:  # noqa: ANN401 - any numpy index
        """The robots that `index` selects (a mask, a slice, numbers or one number), as a batch."""
        index = [index] if isinstance(index, int | np.integer) else index
        depth = None if self.depth is None else self.depth[index]
        return Observation(
            self.image[index],
            depth,
            self.laser[index],
            self.odometry[index],
            self.speed[index],
            self.steering[index],
        )

    @classmethod
    def joined(cls, parts: Sequence[Observation]) -> Observation:
        """The robots of all parts, as one batch; depth only where all have it."""
        depths = [part.depth for part in parts]
        depth = None if any(d is None for d in depths) else np.concatenate(depths)
        names = ("image", "laser", "odometry", "speed", "steering")
        whole = {name: np.concatenate([getattr(p, name) for p in parts]) for name in names}
        return cls(depth=depth, **whole)


Targets = Any
"""What a robot is to reach: pictures with their context, a pose for an oracle, ..."""


@runtime_checkable
class WaypointPredictor(Protocol):
    """C_WP (Meng 2020, III-B): where to drive next so as to reach the target."""

    def predict(
        self, observations: Observation, targets: Targets
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Waypoints (N, 2) in the robots' frames, and overlaps (N, 2) in [0, 1]."""


@runtime_checkable
class Controller(Protocol):
    """C_RMP (Meng 2020, III-B): drives to a waypoint without hitting anything."""

    def act(self, observations: Observation, waypoints: NDArray[np.float64]) -> NDArray[np.float64]:
        """Actions (N, 2): commanded speed in m/s, and steering in rad (car) or rad/s."""


@runtime_checkable
class LocalController(Protocol):
    """C (Meng 2020, III-B): from what is seen and what should be seen to an action."""

    def act(self, observations: Observation, targets: Targets) -> NDArray[np.float64]:
        """Actions (N, 2): commanded speed in m/s, and steering in rad (car) or rad/s."""


@runtime_checkable
class Reachability(Protocol):
    """RE (Meng 2020, III-C): the probability that C reaches a target."""

    def prepare(self, targets: Targets) -> Any:  # noqa: ANN401 - whatever the estimator caches
        """Compute once what does not depend on the observation; may return `targets` itself."""

    def probability(
        self,
        observations: Observation,
        prepared: Any,  # noqa: ANN401
    ) -> NDArray[np.float64]:
        """Probabilities (N,) in [0, 1]."""


@runtime_checkable
class Localizer(Protocol):
    """Where on the map an observation may be."""

    def localize(
        self,
        observations: Observation,
        topomap: Any,  # noqa: ANN401
    ) -> NDArray[np.float64]:
        """Probabilities (N, V) over the vertices; what is missing to one means *lost*."""


@runtime_checkable
class Planner(Protocol):
    """From where the robot is to what it should see, over the map."""

    def plan(
        self,
        observation: Observation,
        goals: Targets,
        topomap: Any,  # noqa: ANN401
        excluded: Collection[int] = (),
    ) -> Any:  # noqa: ANN401
        """A path over the map with its probability, or a refusal; not over what is excluded."""


@runtime_checkable
class Explorer(Protocol):
    """Where to look next when the map does not hold the goal."""

    def choose(self, observation: Observation, goal: Targets) -> Any:  # noqa: ANN401
        """The next subgoal."""
