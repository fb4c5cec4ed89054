"""People who walk, and obstacles that stand still: discs that robots see and collide with."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pymunk
from numpy.typing import ArrayLike, NDArray

from tutorial_lib.se2 import arc_length
from tutorial_lib.validation import floats, integers, number, whole
from tutorial_lib.world.materials import Colour
from tutorial_lib.world.raycast import Discs

EVERYBODY = -1
_PATIENCE = 2.0  # seconds that a person waits for a robot before walking back
_BESIDE = 0.6  # share of the distance ahead at which a person minds a robot beside it


@dataclass(frozen=True)
class Person:
    """A person who walks to and fro along a route; with one point, an obstacle that stands there.

    Attributes:
        route: (K, 2) points in metres.
        speed: m/s.
        radius: metres.
        owner: index of the robot for which it exists, or `EVERYBODY`.
        colour: RGB.
        distance: metres walked along the route at the start.
        keep_off: metres between person and robot's pose at which the person stops and waits.
    """

    route: ArrayLike
    speed: float = 0.5
    radius: float = 0.18
    owner: int = EVERYBODY
    colour: Colour = (214, 39, 40)
    distance: float = 0.0
    keep_off: float = 1.3

    def __post_init__(self) -> None:
        floats("route", self.route, ("K", 2), empty=False)
        number("radius", self.radius, above=0)
        for name in ("speed", "keep_off"):
            number(name, getattr(self, name), least=0)
        whole("owner", self.owner, least=EVERYBODY)
        integers("colour", self.colour, (3,), least=0, most=255)
        number("distance", self.distance)


class Crowd:
    """All people and obstacles of a simulation, as kinematic bodies of its space."""

    def __init__(self, people: Sequence[Person]) -> None:
        """Put all people at the start of their routes."""
        self.people = tuple(people)
        self._routes = [np.asarray(person.route, dtype=float) for person in people]
        self._miles = [arc_length(route) for route in self._routes]
        self._walked = np.array([person.distance for person in people], dtype=float)
        self._ahead = np.ones(len(people))
        self._waited = np.zeros(len(people))
        self.owners = np.array([person.owner for person in people], dtype=np.int32)
        self.radii = np.array([person.radius for person in people], dtype=float)
        colours = [person.colour for person in people]
        self._colours = np.array(colours, dtype=np.float32).reshape(-1, 3)
        self.bodies = [pymunk.Body(body_type=pymunk.Body.KINEMATIC) for _ in people]
        for body, (x, y) in zip(self.bodies, self._points(self._walked).tolist(), strict=True):
            body.position = x, y

    @property
    def positions(self) -> NDArray[np.float64]:
        """(K, 2) metres."""
        return np.array([body.position for body in self.bodies], dtype=float).reshape(-1, 2)

    @property
    def discs(self) -> Discs:
        """People and obstacles as the rays meet them."""
        circles = np.concatenate([self.positions, self.radii[:, None]], axis=1)
        return Discs(circles, self.owners, self._colours)

    def walk(self, robots: NDArray[np.float64], seconds: float) -> None:
        """Set all velocities for the next `seconds`, given the robots' poses (N, 3)."""
        before = self.positions
        wanted = self._walked + self._ahead * seconds * [person.speed for person in self.people]
        after = self._points(wanted)
        for k, body in enumerate(self.bodies):
            step = after[k] - before[k]
            if self._is_blocked(k, before[k], step, robots):
                self._waited[k] += seconds
                body.velocity = 0.0, 0.0
                if self._waited[k] > _PATIENCE:
                    self._ahead[k], self._waited[k] = -self._ahead[k], 0.0
                continue
            self._walked[k], self._waited[k] = wanted[k], 0.0
            body.velocity = tuple((step / seconds).tolist())

    def _is_blocked(
        self,
        k: int,
        here: NDArray[np.float64],
        step: NDArray[np.float64],
        robots: NDArray[np.float64],
    ) -> bool:
        """Whether a robot that exists for person k blocks its step."""
        mine = robots if self.owners[k] == EVERYBODY else robots[[self.owners[k]]]
        towards = mine[:, :2] - here
        gap = np.linalg.norm(towards, axis=1)
        # The cosine of the angle between the step and the robot's direction.
        ahead = towards @ step / np.maximum(gap * np.linalg.norm(step), 1e-9)
        keep_off = self.people[k].keep_off
        in_front = (gap < keep_off) & (ahead > 0)
        beside = (gap < _BESIDE * keep_off) & (ahead > -0.7)
        return bool((in_front | beside).any())

    def _points(self, walked: NDArray[np.float64]) -> NDArray[np.float64]:
        """(K, 2) where people are after walking that far, to and fro."""
        points = np.zeros((len(self.people), 2))
        for k, (route, miles) in enumerate(zip(self._routes, self._miles, strict=True)):
            total = miles[-1]
            place = 0.0 if total == 0 else total - abs(walked[k] % (2 * total) - total)
            points[k] = [np.interp(place, miles, route[:, axis]) for axis in (0, 1)]
        return points
