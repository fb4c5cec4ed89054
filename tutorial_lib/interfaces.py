"""The seams: what an agent observes, and the small interfaces of its parts.

Any object with the right methods fits: a network, an oracle, a student's class. Everything comes in
batches: the first axis of every array counts robots, images or pairs.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError

Array = NDArray[np.float64]
Robots = NDArray[np.intp]
"""(M,) indices of robots in a fleet, rising."""
HERE, Edges = -1, set[tuple[int, int]]
"""Where the robot is, in place of a vertex; and edges, from a vertex or from there to a vertex."""


@dataclass(frozen=True)
class Observation:
    """All that an agent ever observes, for N robots at once.

    Attributes:
        image: (N, H, W, 3) uint8 RGB, left column = left of view.
        depth: (N, W) float metres for each image column, or None where there is no depth camera.
        laser: (N, B) float metres, B beams over the full circle, from -pi counter-clockwise.
        odometry: (N, 3) pose since the start by wheel odometry; it drifts.
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
        """The robots that `index` selects (a mask, a slice, indices or one index), as a batch."""
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

    def pictures(self) -> Observation:
        """The images, and depth where there is any, without what else was measured there.

        The laser has no reading (not a number, as ROS REP 117 has it); odometry, speed and steering
        are zero.
        """
        return Observation(
            self.image,
            self.depth,
            np.full(np.shape(self.laser), np.nan),
            np.zeros_like(self.odometry),
            np.zeros_like(self.speed),
            np.zeros_like(self.steering),
        )

    @classmethod
    def joined(cls, parts: Sequence[Observation]) -> Observation:
        """The robots of all parts, as one batch; depth only where all have it."""
        depths = [part.depth for part in parts]
        depth = None if any(d is None for d in depths) else np.concatenate(depths)
        names = ("image", "laser", "odometry", "speed", "steering")
        whole = {name: np.concatenate([getattr(p, name) for p in parts]) for name in names}
        return cls(depth=depth, **whole)


@dataclass(frozen=True, eq=False)
class Goals:
    """Images of where a robot is to go (image-goal navigation); one of several is enough.

    Whatever observations they are made of, only the pictures are kept: the odometry of who took
    them would lead to the goal. A network that looks at the laser has its scans in the contexts.

    Attributes:
        observations: (G,) the pictures taken there, see `Observation.pictures`.
        contexts: (G, 2k+1, ...) images of each in its context, as the network's view has them.

    Raises:
        InputError: when there is none, or not as many of both.
    """

    observations: Observation
    contexts: NDArray

    def __post_init__(self) -> None:
        if not len(self.contexts) or len(self.contexts) != len(self.observations):
            raise InputError(
                f"goals: {len(self.observations)} observations, {len(self.contexts)} contexts; "
                "give as many of both, one at least"
            )
        object.__setattr__(self, "observations", self.observations.pictures())

    def __len__(self) -> int:
        return len(self.contexts)


@dataclass(frozen=True)
class Plan:
    """A path over the map from what is observed now to a goal.

    Attributes:
        vertices: of the map, in order; none where the goal itself can be reached from here.
        goal: index of the goal image that it leads to.
        probabilities: RE of every step, the first from here and the last to the goal.
        refusal: why the robot should not start; empty if it should.
    """

    vertices: tuple[int, ...] = ()
    goal: int = 0
    probabilities: tuple[float, ...] = ()
    refusal: str = ""

    @property
    def probability(self) -> float:
        """That every step succeeds, were they independent; 0 where there is no path."""
        return float(np.prod(self.probabilities)) if self.probabilities else 0.0


@dataclass(frozen=True, eq=False)
class Experience:
    """What a robot observed on one trajectory at 10 Hz; all that an agent learns from.

    Attributes:
        observations: (T,) in order.
        timestamps: (T,) seconds, rising.

    Raises:
        InputError: when there are fewer than two, or not as many of both.
    """

    observations: Observation
    timestamps: Array

    def __post_init__(self) -> None:
        if not 2 <= len(self.observations) == len(self.timestamps):
            raise InputError(
                f"experience: {len(self.observations)} observations, {len(self.timestamps)} "
                "timestamps; give as many of both, two at least"
            )


Targets = Any
"""What a robot is to reach: images with their context, a pose for an oracle, ..."""


class View(Protocol):
    """What a network looks at: the camera's image or the laser's scan."""

    def of(self, observations: Observation) -> NDArray:
        """What N robots see, as the network wants it, (N, H, W, C)."""


@runtime_checkable
class WaypointPredictor(Protocol):
    """C_WP (Meng 2020, III-B): where to drive next in order to reach a target.

    Attributes:
        view: what it looks at.
        k: images of context on either side of a target.
    """

    view: View
    k: int

    def prepare(self, contexts: NDArray) -> Targets:
        """Targets from images (M, 2k+1, H, W, C); computed once, indexable by an array."""

    def predict(self, observations: Observation, targets: Targets) -> tuple[Array, Array]:
        """Waypoints (N, 2) in the robots' frames, and overlaps (N, 2) in [0, 1]."""


@runtime_checkable
class Controller(Protocol):
    """C_RMP (Meng 2020, III-B): drives to a waypoint without hitting anything."""

    def act(self, observations: Observation, waypoints: Array) -> Array:
        """Actions (N, 2): commanded speed in m/s, and steering in rad (car) or rad/s."""


@runtime_checkable
class LocalController(Protocol):
    """C (Meng 2020, III-B): from the current image and a target to an action."""

    def act(self, observations: Observation, targets: Targets) -> Array:
        """Actions (N, 2): commanded speed in m/s, and steering in rad (car) or rad/s."""


@runtime_checkable
class Policy(Protocol):
    """Drives a fleet in closed loop, see `driving.rollouts`."""

    def act(self, observations: Observation, robots: Robots) -> Array:
        """Actions (M, 2) of the robots (M,) that are still under way, as for a `Controller`."""


@runtime_checkable
class Reachability(Protocol):
    """RE (Meng 2020, III-C): the probability that C reaches a target.

    It may also have `embed(observations)`, for retrieval: without it a map is built exhaustively.
    """

    def prepare(self, targets: Targets) -> Any:  # noqa: ANN401 - whatever the estimator caches
        """Compute once what does not depend on the observation; may return `targets` itself."""

    def probability(self, observations: Observation, prepared: Any) -> Array:  # noqa: ANN401
        """Probabilities (N,) in [0, 1]."""


@runtime_checkable
class Localizer(Protocol):
    """Where on the map an observation may be."""

    def localize(self, observations: Observation, topomap: Any) -> Array:  # noqa: ANN401
        """Probabilities (N, V) over the vertices; what is missing to one means *lost*."""


@runtime_checkable
class Planner(Protocol):
    """From what a robot observes to a goal, over the map."""

    def plan(
        self,
        observation: Observation,
        goals: Goals,
        topomap: Any,  # noqa: ANN401
        excluded: Collection[tuple[int, int]] = (),
    ) -> Plan:
        """A path over the map that avoids the `excluded` edges, or a refusal."""


@runtime_checkable
class Explorer(Protocol):
    """Where to look next when the map does not hold the goal."""

    def choose(self, observation: Observation, goal: Goals) -> Any:  # noqa: ANN401
        """The next subgoal."""


@runtime_checkable
class Navigation(Policy, Protocol):
    """A `Policy` of N robots, each with a goal, that declares when it is over.

    Attributes:
        arrived: (N,) declares to have arrived.
        given_up: (N,) does not go on.
    """

    arrived: NDArray[np.bool_]
    given_up: NDArray[np.bool_]


@runtime_checkable
class Agent(Protocol):
    """A whole system."""

    def learn(self, experiences: Sequence[Experience]) -> None:
        """Learn a building from trajectories recorded in it."""

    def start(self, goals: Sequence[Goals]) -> Navigation:
        """Send robots that stand somewhere in that building to one goal each."""
