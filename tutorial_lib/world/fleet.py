"""The pymunk space: robots, which ignore each other or not, walls, and people."""

from __future__ import annotations

from typing import Any

import numpy as np
import pymunk
import pymunk.batch
from numpy.typing import NDArray

from tutorial_lib.geometry import Array
from tutorial_lib.world.people import EVERYBODY, Crowd

_MASS = 1.0
_FRICTION = 1.0
_ROBOT, _THING = 1, 2
_FIELDS = pymunk.batch.BodyFields
_READ = _FIELDS.POSITION | _FIELDS.ANGLE
_WRITE = _FIELDS.FORCE | _FIELDS.TORQUE


class Fleet:
    """Robots of one footprint in one space.

    On every substep each robot's force is chosen so that the solver starts from the requested
    velocity; contact then removes the part that is blocked. A velocity moves the robot in the
    substep after it is set.

    A copy repeats all motions from the start: pymunk's own copies lose what the solver remembers
    of the last step, and a robot in a corner would go on differently.

    Attributes:
        crowd: the people.
        poses: (N, 3), headings not wrapped.
        contacts: (N,) how many things each robot touches now.
        collided: (N,) whether it ever touched one.
    """

    def __init__(
        self,
        segments: Array,
        footprint: Array,
        poses: Array,
        crowd: Crowd,
        interacting: bool = False,
    ) -> None:
        """Put robots at `poses` (N, 3) among wall `segments` (S, 4) and a crowd.

        Args:
            segments: of the walls.
            footprint: (K, 2) of each robot.
            poses: of the robots.
            crowd: at the start of its routes.
            interacting: whether robots touch each other; else they pass through each other.
        """
        self._beginning = segments, footprint, poses, crowd.people, interacting
        self._history: list[tuple[str, tuple[Any, ...]]] = []
        self.crowd, self.poses = crowd, poses.copy()
        self.contacts = np.zeros(len(poses), dtype=int)
        self.collided = np.zeros(len(poses), dtype=bool)
        self._space = pymunk.Space()
        self._space.damping = 0.0
        self._space.collision_slop = 0.001
        self._robots: list[pymunk.Body] = []
        self._add_robots(footprint, 0 if interacting else 1)
        self._add_things(segments, crowd)
        self._space.on_collision(_ROBOT, _THING, begin=self._begin, separate=self._separate)
        self._space.on_collision(_ROBOT, _ROBOT, begin=self._meet, separate=self._part)
        self._state = pymunk.batch.Buffer()
        # The space holds the robots first, then the people, which no force moves.
        self._forces = np.zeros((len(poses) + len(crowd.bodies), 3))
        self._orders = pymunk.batch.Buffer()
        self._orders.set_float_buf(self._forces)

    def __getstate__(self) -> tuple[Any, ...]:
        return self._beginning, self._history

    def __setstate__(self, state: tuple[Any, ...]) -> None:
        (segments, footprint, poses, people, interacting), history = state
        self.__init__(segments, footprint, poses, Crowd(people), interacting)
        for name, arguments in history:
            getattr(self, name)(*arguments)

    def __deepcopy__(self, _memo: dict[int, Any]) -> Fleet:
        # What was done is never written to: both share it.
        copied = Fleet.__new__(Fleet)
        copied.__setstate__(self.__getstate__())
        return copied

    def walk(self, seconds: float) -> None:
        """Let people walk on for the next `seconds`."""
        self._history.append(("walk", (seconds,)))
        self.crowd.walk(self.poses, seconds)

    def substep(self, ahead: Array, turn: Array, seconds: float) -> None:
        """Request velocities ahead and turning rates, m/s and rad/s (N,), and step."""
        self._history.append(("substep", (ahead, turn, seconds)))
        # The velocity acts in the next substep; halfway through, it points along the arc's chord.
        heading = self.poses[:, 2] + 1.5 * seconds * turn
        # The space damps all velocity away, so force * time / mass is the velocity.
        forces, scale = self._forces[: len(self.poses)], _MASS / seconds
        forces[:, 0] = np.cos(heading) * ahead * scale
        forces[:, 1] = np.sin(heading) * ahead * scale
        forces[:, 2] = turn * scale
        pymunk.batch.set_space_bodies(self._space, _WRITE, self._orders)
        self._space.step(seconds)
        self._state.clear()
        pymunk.batch.get_space_bodies(self._space, _READ, self._state)
        state = np.frombuffer(self._state.float_buf(), dtype=np.float64)
        self.poses = state.reshape(-1, 3)[: len(self.poses)].copy()

    def place(self, robots: NDArray[np.intp], poses: Array) -> None:
        """Put these robots at rest at `poses` (M, 3)."""
        self._history.append(("place", (robots.copy(), poses.copy())))
        for number, (x, y, heading) in zip(robots.tolist(), poses.tolist(), strict=True):
            robot = self._robots[number]
            robot.position, robot.angle = (x, y), heading
            robot.velocity, robot.angular_velocity = (0.0, 0.0), 0.0
            self._space.reindex_shapes_for_body(robot)
        self.poses[robots] = poses

    def _add_robots(self, footprint: Array, group: int) -> None:
        among_robots = pymunk.ShapeFilter(group=group)  # shapes of one group ignore each other
        corners = [tuple(corner) for corner in footprint.tolist()]
        for number, (x, y, heading) in enumerate(self.poses.tolist()):
            robot = pymunk.Body(_MASS, _MASS)
            robot.position, robot.angle = (x, y), heading
            shape = pymunk.Poly(robot, corners)
            shape.filter, shape.collision_type, shape.owner = among_robots, _ROBOT, number
            shape.friction = _FRICTION  # of two robots: walls and people have none
            self._space.add(robot, shape)
            self._robots.append(robot)

    def _add_things(self, segments: Array, crowd: Crowd) -> None:
        for x0, y0, x1, y1 in segments.tolist():
            wall = pymunk.Segment(self._space.static_body, (x0, y0), (x1, y1), 0.0)
            wall.collision_type, wall.owner = _THING, EVERYBODY
            self._space.add(wall)
        for person, disc in zip(crowd.people, crowd.bodies, strict=True):
            shape = pymunk.Circle(disc, person.radius)
            shape.collision_type, shape.owner = _THING, person.owner
            self._space.add(disc, shape)

    def _begin(self, arbiter: pymunk.Arbiter, _space: pymunk.Space, _data: object) -> None:
        robot, concerned = _parties(arbiter)
        arbiter.process_collision = concerned
        self.contacts[robot] += concerned
        self.collided[robot] |= concerned

    def _separate(self, arbiter: pymunk.Arbiter, _space: pymunk.Space, _data: object) -> None:
        robot, concerned = _parties(arbiter)
        self.contacts[robot] -= concerned

    def _meet(self, arbiter: pymunk.Arbiter, _space: pymunk.Space, _data: object) -> None:
        robots = [shape.owner for shape in arbiter.shapes]
        self.contacts[robots] += 1
        self.collided[robots] = True

    def _part(self, arbiter: pymunk.Arbiter, _space: pymunk.Space, _data: object) -> None:
        self.contacts[[shape.owner for shape in arbiter.shapes]] -= 1


def _parties(arbiter: pymunk.Arbiter) -> tuple[int, bool]:
    """The robot's index, and whether the thing it met exists for it."""
    robot, thing = sorted(arbiter.shapes, key=lambda shape: shape.collision_type)
    return robot.owner, thing.owner in (EVERYBODY, robot.owner)
