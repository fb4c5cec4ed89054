"""What a robot observes, now, on the way, or in the picture of a goal: all that an agent gets."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.validation import alike, floats, instance, instances

# Name, number of axes and kinds of numbers of each array beside the odometry.
_SENSES = (
    ("image", 4, "fiu"),
    ("depth", 2, "fiu"),
    ("laser", 2, "fiu"),
    ("speed", 1, "fiu"),
    ("steering", 1, "fiu"),
)


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
        body: of all N, see `world.bodies`: a robot knows how it is built. None where it is not
            known, as in what was recorded.
        camera: that took the images, see `world.sensors`; None where it is not known.
    """

    image: NDArray[np.uint8]
    depth: NDArray[np.floating] | None
    laser: NDArray[np.floating]
    odometry: NDArray[np.float64]
    speed: NDArray[np.float64]
    steering: NDArray[np.float64]
    body: Any = None
    camera: Any = None

    def __post_init__(self) -> None:
        odometry = instance("odometry", self.odometry, np.ndarray)
        if odometry.ndim != 2 or odometry.shape[1] != 3 or odometry.dtype.kind not in "fiu":
            floats("odometry", odometry, ("N", 3), infinite=True, nan=True)
        for name, axes, kinds in _SENSES:
            array = getattr(self, name)
            if array is None and name == "depth":
                continue
            right = type(array) is np.ndarray and array.dtype.kind in kinds
            if not (right and array.ndim == axes and len(array) == len(odometry)):
                self._check(name, axes)

    def _check(self, name: str, axes: int) -> None:
        """Look closely at an array that does not seem to be right."""
        array = instance(name, getattr(self, name), np.ndarray)
        floats(name, array, ("N", "H", "W", "C")[:axes], infinite=True, nan=True)
        alike(**{name: array, "odometry": self.odometry})

    def __len__(self) -> int:
        return len(self.odometry)

    def __getitem__(self, index: Any) -> Observation:  # noqa: ANN401 - any numpy index
        """The robots that `index` selects (a mask, a slice, indices or one index), as a batch."""
        index = np.array([index]) if isinstance(index, int | np.integer) else index
        depth = None if self.depth is None else self.depth[index]
        return Observation(
            self.image[index],
            depth,
            self.laser[index],
            self.odometry[index],
            self.speed[index],
            self.steering[index],
            self.body,
            self.camera,
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
            camera=self.camera,
        )

    @classmethod
    def joined(cls, parts: Sequence[Observation]) -> Observation:
        """The robots of all parts, as one batch; depth, body and camera only where all have it."""
        parts = instances("parts", parts, cls, empty=False)
        depths = [part.depth for part in parts if part.depth is not None]
        depth = np.concatenate(depths) if len(depths) == len(parts) else None
        names = ("image", "laser", "odometry", "speed", "steering")
        whole: dict[str, Any] = {
            name: np.concatenate([getattr(p, name) for p in parts]) for name in names
        }
        for name in ("body", "camera"):
            first, *others = (getattr(part, name) for part in parts)
            whole[name] = first if all(other == first for other in others) else None
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
        observations = instance("observations", self.observations, Observation)
        contexts = instance("contexts", self.contexts, np.ndarray)
        if contexts.dtype.kind not in "fiu":
            raise InputError(f"contexts: array of {contexts.dtype}; give images or scans")
        if not contexts.ndim:
            raise InputError("contexts: one value; give one context for each goal")
        if not len(contexts) or len(contexts) != len(observations):
            raise InputError(
                f"goals: {len(self.observations)} observations, {len(self.contexts)} contexts; "
                "give as many of both, one at least"
            )
        object.__setattr__(self, "observations", self.observations.pictures())

    def __len__(self) -> int:
        return len(self.contexts)


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
    timestamps: NDArray[np.float64]

    def __post_init__(self) -> None:
        instance("observations", self.observations, Observation)
        times = floats("timestamps", self.timestamps, ("T",))
        if not 2 <= len(self.observations) == len(self.timestamps):
            raise InputError(
                f"experience: {len(self.observations)} observations, {len(self.timestamps)} "
                "timestamps; give as many of both, two at least"
            )
        if not (np.diff(times) > 0).all():
            raise InputError("timestamps: not rising; give seconds in the order of time")
