"""The check of the kinematic bicycle, in notebook 01."""

from collections.abc import Callable

import numpy as np

from tutorial_lib import geometry
from tutorial_lib.checks.framework.answers import call
from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import expect_close
from tutorial_lib.geometry import Array
from tutorial_lib.world.bodies import BicycleCar, advance


def bicycle_step(
    pose: Array, speed: float, steering: float, wheelbase: float, seconds: float
) -> Array:
    """The pose (3,) after one step, by the library's car."""
    car = BicycleCar(wheelbase=wheelbase)
    x, y, heading = advance(pose, car.twist(np.array([speed, steering])), seconds)
    return np.array([x, y, pose[2] + geometry.wrap(heading - pose[2])])


@check(bicycle_step, (np.array([1.0, 2.0, 0.5]), 0.5, 0.2, 0.3, 0.02))
def check_bicycle_step(student: Callable[..., Array]) -> None:
    """The kinematic bicycle; any integrator that is right for small steps passes."""
    pose, wheelbase, seconds = np.array([1.0, 2.0, 0.5]), 0.30, 0.02
    still = np.asarray(call(student, pose, 0.0, 0.4, wheelbase, seconds), dtype=float)
    if still.shape == (3,) and abs(still[2] - pose[2]) > 1e-6:
        raise WrongAnswer("bicycle_step: the car turns even when it stands; multiply by the speed")
    for speed, steering in ((0.8, 0.0), (0.8, 0.45), (-0.3, 0.4), (0.5, -0.3)):
        rate = speed * np.tan(steering) / wheelbase
        want = bicycle_step(pose, speed, steering, wheelbase, seconds)

        def with_turn(turn: float, want: Array = want) -> Array:
            return np.array([*want[:2], pose[2] + turn])

        step = speed * seconds
        swapped = [pose[0] + step * np.sin(pose[2]), pose[1] + step * np.cos(pose[2]), want[2]]
        mistakes = {
            "divide by the wheelbase, do not multiply": with_turn(
                speed * np.tan(steering) * wheelbase * seconds
            ),
            "the turning rate has the tangent of the steering angle, tan, in it": with_turn(
                speed * steering / wheelbase * seconds
            ),
            "the turn is the turning rate times the seconds": with_turn(rate),
            "cos belongs to x and sin to y": swapped,
            "the rear axle moves along the heading, not along heading + steering": [
                pose[0] + step * np.cos(pose[2] + steering),
                pose[1] + step * np.sin(pose[2] + steering),
                want[2],
            ],
        }
        what = f"bicycle_step at {speed} m/s, steering {steering} rad"
        answer = call(student, pose, speed, steering, wheelbase, seconds)
        expect_close(what, answer, want, 3e-4, mistakes)
