"""A controller drives the body that the robots have: that of the simulation they are in."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import Any, Protocol, TypeVar

from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import Observation
from tutorial_lib.world.bodies import BicycleCar, Body, DifferentialDrive


class _Drives(Protocol):
    @property
    def body(self) -> Body: ...


Driver = TypeVar("Driver", bound=_Drives)


def for_robots(controller: Driver, observations: Observation) -> Driver:
    """The controller for the body of the robots that observe this: itself if it fits.

    Args:
        controller: a dataclass with a `body`.
        observations: of the robots; recorded ones do not say which body it was.

    Raises:
        InputError: when the body is neither a car nor a differential drive.
    """
    body = observations.body
    if body is None or body == controller.body:
        return controller
    if not isinstance(body, BicycleCar | DifferentialDrive):
        raise InputError(
            f"body: a {type(body).__name__} is neither a BicycleCar nor a DifferentialDrive; "
            "drive it with a controller of its own"
        )
    return _for_body(controller, body)


@lru_cache(maxsize=16)
def _for_body(controller: Any, body: BicycleCar | DifferentialDrive) -> Any:  # noqa: ANN401
    return replace(controller, body=body)
