"""The trajectories that were recorded in one world, and pairs of places along them."""

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.driving.data.trajectories import CONTEXT_INTERVAL, Trajectory
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import Array
from tutorial_lib.interfaces import Experience, Goals, Observation
from tutorial_lib.validation import (
    alike,
    floats,
    instance,
    instances,
    integers,
    number,
    whole,
    with_methods,
)
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera
from tutorial_lib.world.simulation import STEP

BEHIND, AHEAD = 1.0, 3.0
"""Metres along the drive from a place to its target, at most (Meng 2020, III-B, Table I)."""
MOST_CONTEXT, MOST_PAIRS = 10_000, 10_000_000
"""Images on either side of a target, and pairs drawn at once: more are a mistake."""
CLOSE = 0.8
"""Metres along the trajectory of pairs that decide the last bit of an approach."""
_BETWEEN = 60.0  # seconds from one trajectory to the next


def frames_around(frames: ArrayLike, k: int, first: ArrayLike, last: ArrayLike) -> NDArray[np.intp]:
    """Frames of contextified targets ``o_{i - k dT} ... o_{i + k dT}`` (Meng 2020, III-B).

    Args:
        frames: (N,) indices i of the targets.
        k: images on either side.
        first: (N,) or one number, the first frame of the trajectory, which is repeated before it.
        last: the same for the last frame, which is repeated after it.

    Returns:
        (N, 2k+1) in the order of time.

    >>> frames_around([0, 10], 2, 0, 12).tolist()
    [[0, 0, 0, 3, 6], [4, 7, 10, 12, 12]]
    """
    frames = integers("frames", frames, ("N",), least=0)
    k = whole("k", k, least=0, most=MOST_CONTEXT)
    ends = []
    for name, end in (("first", first), ("last", last)):
        end = integers(name, end, (...,), least=0)
        if end.shape not in ((), frames.shape):
            raise InputError(f"{name}: shape {end.shape}, frames: {frames.shape}; give as many")
        ends.append(np.reshape(end, (-1, 1)))
    return np.clip(frames[:, None] + CONTEXT_INTERVAL * np.arange(-k, k + 1), *ends)


class RecordedWorld:
    """All the trajectories recorded in one world, laid end to end.

    Attributes:
        scene: the world.
        poses: (F, 3) of all frames.
        speed, steering: (F,) m/s and rad.
        arc: (F,) metres driven up to each frame, never falling from one trajectory to the next.
        first, last: (F,) the first and last frame of the trajectory of each frame.
        first_frames: (M,) the first frame of each of M trajectories.
    """

    def __init__(self, scene: Scene, trajectories: Sequence[Trajectory]) -> None:
        """Lay `trajectories` end to end."""
        self.scene = instance("scene", scene, Scene)
        self.trajectories = trajectories = instances(
            "trajectories", trajectories, Trajectory, empty=False
        )
        lengths = np.array([len(trajectory) for trajectory in trajectories])
        ends = np.cumsum(lengths)
        self.first_frames = ends - lengths
        self.poses = np.concatenate([trajectory.poses for trajectory in trajectories])
        self.speed = np.concatenate([trajectory.speed for trajectory in trajectories])
        self.steering = np.concatenate([trajectory.steering for trajectory in trajectories])
        self.first = np.repeat(self.first_frames, lengths)
        self.last = np.repeat(ends - 1, lengths)
        # A gap wider than any pair keeps a search along the arc within its trajectory.
        gap = np.repeat(np.arange(len(lengths)) * 100.0, lengths)
        length = np.cumsum([0.0] + [t.arc_length[-1] for t in trajectories[:-1]])
        arcs = np.concatenate([trajectory.arc_length for trajectory in trajectories])
        self.arc = arcs + gap + np.repeat(length, lengths)

    def frames_of(self, trajectory: int) -> NDArray[np.intp]:
        """(T,) the frames of one trajectory, in order.

        Raises:
            InputError: when there is no such trajectory.
        """
        number = whole("trajectory", trajectory, least=0, most=len(self.trajectories) - 1)
        first = self.first_frames[number]
        return np.arange(first, self.last[first] + 1)

    @cached_property
    def begins(self) -> Array:
        """(M,) seconds at which each trajectory begins, were they recorded one after the other."""
        long = [trajectory.timestamps[-1] + _BETWEEN for trajectory in self.trajectories]
        return np.cumsum([0.0, *long[:-1]])

    def experience(self, trajectory: int, camera: Camera | None = None) -> Experience:
        """What the robot observed on one trajectory: what an agent learns from.

        Args:
            trajectory: its number.
            camera: takes the images; the usual one unless given.

        Raises:
            InputError: when there is no such trajectory.
        """
        seen = self.observe(self.frames_of(trajectory), camera)
        return Experience(seen, self.begins[trajectory] + self.trajectories[trajectory].timestamps)

    def experiences(self) -> list[Experience]:
        """The same of all trajectories."""
        return [self.experience(i) for i in range(len(self.trajectories))]

    def poses_at(self, times: ArrayLike) -> Array:
        """Poses (N, 3) at `times` (N,) of experiences, as where a map's vertices were recorded.

        Raises:
            InputError: when no frame was recorded at a time.
        """
        times = floats("times", times, ("N",))
        which = np.searchsorted(self.begins, times, side="right") - 1
        first = self.first_frames[which]
        steps = np.rint((times - self.begins[which]) / STEP)
        lost = (which < 0) | (steps > self.last[first] - first)
        if lost.any():
            raise InputError(f"times: {times[lost][0]:g} s; give seconds at which one was recorded")
        return self.poses[first + steps.astype(np.intp)]

    def goals(
        self, frames: NDArray[np.intp], k: int = 5, camera: Camera | None = None
    ) -> list[Goals]:
        """The images of frames (N,) as goals: each alone stands for its context.

        Args:
            frames: their indices.
            k: images of context on either side, as the networks want them.
            camera: takes the images; the usual one unless given.

        Raises:
            InputError: as `observe` does.
        """
        seen, k = self.observe(frames, camera), whole("k", k, least=0, most=MOST_CONTEXT)
        contexts = np.repeat(seen.image[:, None], 2 * k + 1, axis=1)
        return [Goals(seen[[i]], contexts[[i]]) for i in range(len(seen))]

    def context(self, frames: NDArray[np.intp], k: int) -> NDArray[np.intp]:
        """Frames of the contextified targets ``o_{i - k dT} ... o_{i + k dT}`` (Meng 2020, III-B).

        Args:
            frames: (N,) indices i of the targets.
            k: images on either side.

        Returns:
            (N, 2k+1); beyond either end of a trajectory its first or last frame is repeated.

        Raises:
            InputError: when a trajectory is shorter than one context, or there is no such frame.
        """
        frames = self._checked(frames)
        k = whole("k", k, least=0, most=MOST_CONTEXT)
        needed = 2 * k * CONTEXT_INTERVAL + 1
        shortest = (self.last - self.first + 1)[frames].min(initial=needed)
        if shortest < needed:
            raise InputError(
                f"k: {k} needs a trajectory of {needed} frames and one has {shortest}; "
                "record longer ones or give a smaller k"
            )
        return frames_around(frames, k, self.first[frames], self.last[frames])

    def observe(
        self, frames: NDArray[np.intp], camera: Camera | None = None, depth: bool = False
    ) -> Observation:
        """What the robot sensed at frames (N,): images are rendered, the rest was recorded.

        Args:
            frames: their indices.
            camera: takes the images; the usual one unless given.
            depth: whether that camera measures depth, too.

        Raises:
            InputError: when there is no such frame, or lasers have different numbers of beams.
        """
        frames = self._checked(frames)
        if camera is not None:
            with_methods("camera", camera, "look")
        laser, odometry = self._sensed
        camera = Camera() if camera is None else camera
        image, metres = camera.look(self.scene, self.poses[frames])
        senses = (laser[frames], odometry[frames], self.speed[frames], self.steering[frames])
        return Observation(image, metres if depth else None, *senses, camera=camera)

    @cached_property
    def _sensed(self) -> tuple[NDArray[np.float32], Array]:
        """Laser (F, B) and odometry (F, 3) of all frames; only to observe are they needed."""
        if len({trajectory.laser.shape[1] for trajectory in self.trajectories}) > 1:
            raise InputError("trajectories: lasers with different numbers of beams; separate them")
        laser = np.concatenate([trajectory.laser for trajectory in self.trajectories])
        return laser, np.concatenate([trajectory.odometry for trajectory in self.trajectories])

    def _checked(self, frames: ArrayLike) -> NDArray[np.intp]:
        """Frames (N,) that there are."""
        return integers("frames", frames, ("N",), least=0, most=len(self.poses) - 1)

    def frame_at(self, frames: NDArray[np.intp], ahead: Array) -> NDArray[np.intp]:
        """(N,) the frame `ahead` (N,) metres of each frame, or the end of the trajectory."""
        frames, ahead = self._checked(frames), floats("ahead", ahead, ("N",))
        alike(frames=frames, ahead=ahead)
        found = np.searchsorted(self.arc, self.arc[frames] + ahead)
        return np.clip(found, self.first[frames], self.last[frames])

    def draw(
        self, targets: int, starts: int, rng: np.random.Generator, close: float = 0.0
    ) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Pairs of frames along one trajectory, the target 1 m behind to 3 m ahead (Table I).

        Args:
            targets: G, how many targets.
            starts: S, for each.
            rng: draws them.
            close: share of the pairs that are within `CLOSE` instead, as at its end.

        Returns:
            (G * S,) frames to drive from, those of one target in a row, and (G,) targets.
        """
        targets = whole("targets", targets, least=0, most=MOST_PAIRS)
        starts = whole("starts", starts, least=0, most=MOST_PAIRS)
        close = number("close", close, least=0, most=1)
        instance("rng", rng, np.random.Generator)
        frames, count = rng.integers(len(self.poses), size=targets), targets * starts
        ahead = rng.uniform(-BEHIND, AHEAD, size=count)
        if close:
            near = rng.random(count) < close
            ahead = np.where(near, rng.uniform(-CLOSE, CLOSE, size=count), ahead)
        return self.frame_at(np.repeat(frames, starts), -ahead), frames
