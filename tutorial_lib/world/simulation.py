"""Motion and contact, simulated by pymunk: one robot or a fleet."""

import copy
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import Observation
from tutorial_lib.se2 import Array, compose, relative, wrap
from tutorial_lib.validation import (
    alike,
    flag,
    floats,
    instance,
    instances,
    integers,
    number,
    whole,
    with_methods,
)
from tutorial_lib.world.bodies import BicycleCar, Body
from tutorial_lib.world.fleet import Fleet
from tutorial_lib.world.interaction import check_distinct, robot_discs
from tutorial_lib.world.noise import (
    NoNoise,
    OdometryNoise,
    scale_controls,
)
from tutorial_lib.world.people import Crowd, Person
from tutorial_lib.world.placing import check_apart, check_free, checked_body
from tutorial_lib.world.raycast import Discs
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Sensors

STEP = 0.1
"""Seconds between two actions: control at 10 Hz."""
SUBSTEPS = 5


class Simulation:
    """A scene with robots in it, all of one body.

    Copies, and pickles of it, go on as it does to the last bit, noise included. Making one repeats
    all motions since the start.

    Attributes:
        scene: the world.
        body: the robots' model.
        poses: (N, 3) true poses of the robots.
        controls: (N, 2) speed in m/s, and steering in rad (car) or rad/s.
        speed: (N,) true forward speed in the last step, m/s.
        odometry: (N, 3) pose relative to the start, as the wheels measure it.
        seconds: simulated so far.
    """

    def __init__(
        self,
        scene: Scene,
        poses: ArrayLike,
        *,
        body: Body | None = None,
        people: Sequence[Person] = (),
        interacting: bool = False,
        control_noise: float = 0.0,
        odometry_noise: OdometryNoise | None = None,
        sensors: Sensors | None = None,
        rng: np.random.Generator | None = None,
    ) -> None:
        """Put robots into a scene.

        Args:
            scene: the world.
            poses: (N, 3) where the robots start.
            body: their model, a `BicycleCar` unless given.
            people: people and obstacles.
            interacting: whether robots see, touch and push each other, or pass through unseen.
            control_noise: sigma of `scale_controls`.
            odometry_noise: exact odometry unless given; experiments give `DriftingOdometry`.
            sensors: camera and laser.
            rng: needed when there is noise, but for that of `DriftingOdometry`.

        Raises:
            InputError: when a robot would start inside a wall or one that it interacts with, or
                there is noise and no `rng`.
        """
        self.scene = instance("scene", scene, Scene)
        self.body = BicycleCar() if body is None else checked_body(body)
        self.sensors = Sensors() if sensors is None else instance("sensors", sensors, Sensors)
        self.poses = _frozen(_poses(poses))
        check_free(scene, self.body, self.poses)
        noise = NoNoise() if odometry_noise is None else odometry_noise
        self._odometry_noise = with_methods("odometry_noise", noise, "measure")
        self._control_noise = number("control_noise", control_noise, least=0)
        if rng is not None:
            instance("rng", rng, np.random.Generator)
        if rng is None and (control_noise or self._odometry_noise.needs_rng):
            raise InputError("rng: None, and noise needs one; give np.random.default_rng(seed)")
        self._rng, self.interacting = rng, flag("interacting", interacting)
        count = len(self.poses)
        self.controls, self.odometry = np.zeros((count, 2)), np.zeros((count, 3))
        self.speed, self.seconds = np.zeros(count), 0.0
        crowd = Crowd(instances("people", people, Person))
        if not (crowd.owners < count).all():
            raise InputError(f"people: an owner is beyond the last robot, {count - 1}")
        check_apart(self.body, self.poses, crowd.discs)
        if interacting:
            check_distinct(self.body, self.poses)
        walls, footprint = scene.plan.segments, self.body.footprint
        self._fleet = Fleet(walls, footprint, self.poses, crowd, interacting)

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self.poses.setflags(write=False)

    def __copy__(self) -> "Simulation":
        return copy.deepcopy(self)

    def __len__(self) -> int:
        return len(self.poses)

    @property
    def touching(self) -> NDArray[np.bool_]:
        """(N,) whether a robot touches something now."""
        return self._fleet.contacts > 0

    @property
    def collided(self) -> NDArray[np.bool_]:
        """(N,) whether a robot ever touched something."""
        return self._fleet.collided.copy()

    @property
    def crowd(self) -> Crowd:
        """People and obstacles."""
        return self._fleet.crowd

    @property
    def discs(self) -> Discs | None:
        """People and obstacles as the rays meet them, and robots where they interact."""
        if not self.interacting:
            return self.crowd.discs if self.crowd.people else None
        return Discs.joined([self.crowd.discs, robot_discs(self.body, self.poses)])

    def step(self, actions: ArrayLike) -> None:
        """Drive for `STEP` seconds.

        Args:
            actions: (N, 2) commanded speed in m/s, and steering in rad (car) or rad/s.

        Raises:
            InputError: when an action is missing or not finite.
        """
        actions = checked_actions(actions, len(self))
        before, wanted = self.poses, scale_controls(actions, self._control_noise, self._rng)
        self._fleet.walk(STEP)
        for _ in range(SUBSTEPS):
            self.controls = self.body.respond(self.controls, wanted, STEP / SUBSTEPS)
            twists = self.body.twist(self.controls)
            self._fleet.substep(twists[:, 0], twists[:, 1], STEP / SUBSTEPS)
        self._finish(before)

    def place(self, robots: ArrayLike, poses: ArrayLike) -> None:
        """Teleport robots, at rest (kidnapped-robot test); odometry is unaffected.

        Args:
            robots: (M,) their indices, each once.
            poses: (M, 3) where to.

        Raises:
            InputError: when a robot would stand in a wall, on a person, or in a robot that it
                interacts with; none is moved then.
        """
        robots = np.atleast_1d(integers("robots", robots, least=0, most=len(self) - 1))
        poses = _poses(poses)
        if robots.ndim > 1 or len(np.unique(robots)) < len(robots):
            raise InputError(f"robots: {robots.tolist()}; give (M,) indices, each once")
        alike(robots=robots, poses=poses)
        check_free(self.scene, self.body, poses)
        alone = np.full_like(self.poses, 1e9)  # only those that move can collide
        alone[robots] = poses
        check_apart(self.body, alone, self.crowd.discs)
        placed = self.poses.copy()
        placed[robots] = poses
        if self.interacting:
            check_distinct(self.body, placed)
        self._fleet.place(robots, poses)
        placed[:, 2] = wrap(placed[:, 2])
        self.poses = _frozen(placed)
        self.controls[robots], self.speed[robots] = 0.0, 0.0

    def observe(self, robots: NDArray[np.intp] | None = None) -> Observation:
        """What the robots' sensors measure now.

        Args:
            robots: (M,) indices of the robots to observe; all unless given.
        """
        numbers = np.arange(len(self), dtype=np.int32)
        if robots is not None:
            numbers = numbers[integers("robots", robots, ("M",), least=0, most=len(self) - 1)]
        poses, discs = self.poses[numbers], self.discs
        image, depth = self._look(poses, discs, numbers)
        return Observation(
            image=image,
            depth=depth if self.sensors.with_depth else None,
            laser=self.sensors.laser.scan(self.scene, poses, discs, numbers),
            odometry=self.odometry[numbers],
            speed=self.speed[numbers],
            steering=self.controls[numbers, 1],
            body=self.body,
            camera=self.sensors.camera,
        )

    def _look(
        self, poses: Array, discs: Discs | None, numbers: NDArray[np.int32]
    ) -> tuple[NDArray[np.uint8], Array]:
        """Images and depth; both are empty where there is no camera."""
        if self.sensors.camera is None:
            return np.empty((len(poses), 0, 0, 3), np.uint8), np.empty((len(poses), 0))
        return self.sensors.camera.look(self.scene, poses, discs, numbers)

    def _finish(self, before: NDArray[np.float64]) -> None:
        """Update what follows from the motion since `before`."""
        poses = self._fleet.poses.copy()
        poses[:, 2] = wrap(poses[:, 2])
        self.poses = _frozen(poses)
        motions = relative(before, self.poses)
        self.speed = motions[:, 0] / STEP
        read = self._odometry_noise.measure(motions, self._rng)
        self.odometry = compose(self.odometry, read)
        self.seconds += STEP


def checked_actions(actions: ArrayLike, robots: int) -> Array:
    """Actions (M, 2) as finite numbers, a copy; an `InputError` where they are anything else."""
    found = floats("actions", actions, ("M", 2))
    if len(found) != whole("robots", robots, least=0):
        raise InputError(f"actions: {found.shape}; give (M, 2), a row for each of {robots} robots")
    return found.copy()


def _poses(poses: ArrayLike) -> Array:
    """Poses (N, 3); a single one is taken, too."""
    return floats("poses", np.atleast_2d(floats("poses", poses, (..., 3))), ("N", 3))


def _frozen(poses: Array) -> Array:
    """A copy that cannot be written to: a robot is moved by driving it."""
    poses = np.array(poses)
    poses.setflags(write=False)
    return poses
