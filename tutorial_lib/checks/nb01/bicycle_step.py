"""The check of the kinematic bicycle, in notebook 01."""

import numpy as np

from tutorial_lib import geometry
from tutorial_lib.checks.engine import case, close, exercise, hint, mistakes_of, numbers, topics
from tutorial_lib.geometry import Array
from tutorial_lib.world.bodies import BicycleCar, advance


def bicycle_step(
    pose: Array, speed: float, steering: float, wheelbase: float, seconds: float
) -> Array:
    """The pose (3,) after one step, by the library's car."""
    car = BicycleCar(wheelbase=wheelbase, length=max(wheelbase, BicycleCar.length))
    x, y, heading = advance(pose, car.twist(np.array([speed, steering])), seconds)
    return np.array([x, y, pose[2] + geometry.wrap(heading - pose[2])])


def _straight(
    pose: Array, speed: float, steering: float, wheelbase: float, seconds: float
) -> Array:
    """The same with a straight step along the first heading, as the exercise has it."""
    x, y, heading = pose
    step, turn = speed * seconds, speed * np.tan(steering) / wheelbase * seconds
    return np.array([x + step * np.cos(heading), y + step * np.sin(heading), heading + turn])


_RNG = np.random.default_rng(3)
_RANGES = [-1.5, -0.7, 0.15, 0.01], [1.5, 0.7, 1.2, 0.12]
_POSE = np.array([1.0, 2.0, 0.5])
_RANDOM = [
    (_RNG.uniform([-3, -3, -3], [3, 3, 3]), *_RNG.uniform(*_RANGES).tolist()) for _ in range(30)
]
TOPICS = {
    "a car that stands, with its wheels turned": hint(
        "a car at rest neither moves nor turns", (_POSE, 0.0, 0.4, 0.3, 0.02)
    ),
    "straight ahead at 0.8 m/s with heading 0": hint(
        "with straight wheels the heading stays, and x grows by speed times seconds",
        (np.array([1.0, 2.0, 0.0]), 0.8, 0.0, 0.3, 0.02),
    ),
    "straight ahead at 0.8 m/s with heading 0.5": hint(
        "with straight wheels the heading stays, and the car moves along it",
        (_POSE, 0.8, 0.0, 0.3, 0.02),
    ),
    "a left turn at 0.8 m/s, steering 0.45 rad": hint(
        "write down the three equations, each times the seconds", (_POSE, 0.8, 0.45, 0.3, 0.02)
    ),
    "a right turn at 0.5 m/s, steering -0.3 rad": hint(
        "a negative angle turns the car to the right; the same equations hold",
        (_POSE, 0.5, -0.3, 0.3, 0.02),
    ),
    "in reverse at -0.3 m/s, to either side": hint(
        "a negative speed needs no special case: place and heading both change their sign",
        (_POSE, -0.3, 0.4, 0.3, 0.02),
        (_POSE, -0.3, -0.4, 0.3, 0.02),
    ),
    "a car with another wheelbase": hint(
        "the wheelbase is an argument: a car twice as long turns half as fast",
        (_POSE, 0.8, 0.3, 0.6, 0.02),
        (_POSE, 0.8, 0.3, 1.1, 0.02),
    ),
    "steps of other lengths": hint(
        "the seconds are an argument: twice the time, twice the step and twice the turn",
        *((_POSE, 0.8, 0.3, 0.3, seconds) for seconds in (0.01, 0.05, 0.1)),
    ),
    "a fast car with its wheels turned far": hint(
        "limit nothing here: the car's motors limit steering and speed before this function",
        (_POSE, 1.5, 0.0, 0.3, 0.02),
        (_POSE, -1.0, 0.0, 0.3, 0.02),
        (_POSE, 0.5, 0.7, 0.3, 0.1),
    ),
    "a slow car, and one whose wheels are hardly turned": hint(
        "a slow car moves, and a small steering angle turns it: leave no small number out",
        (_POSE, 0.03, 0.4, 0.3, 0.1),
        (_POSE, 0.8, 0.02, 0.3, 0.1),
        (_POSE, 0.8, -0.02, 0.3, 0.1),
    ),
    "a car that turns past half a turn, and one that has turned further": hint(
        "a heading may grow beyond pi; one that is wrapped must be a whole turn off",
        *((np.array([1.0, 2.0, h]), 0.8, s, 0.3, 0.1) for h, s in ((3.1, 0.4), (-3.1, -0.4))),
        (np.array([1.0, 2.0, 7.0]), 0.8, 0.3, 0.3, 0.02),
        (np.array([1.0, 2.0, -7.0]), 0.8, 0.3, 0.3, 0.02),
    ),
    "30 random steps": hint(
        "the simple cases are right; does a part of your formula hold for some of them only?",
        *_RANDOM,
    ),
}
MISTAKES = """
the car turns even when it stands; multiply the tangent by the speed
    turn = speed * seconds, speed * np -> turn = speed * seconds, np
divide by the wheelbase, do not multiply
    / wheelbase -> * wheelbase
the turning rate has the tangent of the steering angle, tan, in it
    np.tan(steering) -> steering
the wheelbase is missing: the turning rate is divided by it
    / wheelbase * seconds -> * seconds
np.tan takes radians, and the steering angle is in radians; do not convert it
    np.tan(steering) -> np.tan(np.rad2deg(steering))
the turn is the rate times the seconds, once; the seconds count twice in yours
    / wheelbase * seconds -> / wheelbase * seconds**2
v is the speed of the rear axle, so the step and the turn have no cosine of the steering
angle in them
    np.tan(steering) / wheelbase * seconds -> np.sin(steering) / wheelbase * seconds
    speed * seconds -> speed * np.cos(steering) * seconds
divided by the seconds; a rate is multiplied by them
    speed * seconds -> speed / seconds
    / wheelbase * seconds -> / wheelbase / seconds
a car in reverse moves backwards; do not stop it, nor take the speed without its sign
    speed * seconds -> max(speed, 0) * seconds
    speed * np.tan -> max(speed, 0) * np.tan
a car in reverse moves backwards; take the speed with its sign
    speed * seconds -> abs(speed) * seconds
the turning rate has the tangent of the steering angle, not its sine
    np.tan -> np.sin
the turning rate has the tangent of the steering angle, np.tan, not its inverse
    np.tan -> np.arctan
the turn is the turning rate times the seconds
    / wheelbase * seconds -> / wheelbase
in reverse the turn changes its sign too; do not take the speed without its sign
    speed * np.tan -> abs(speed) * np.tan
the car always turns left; a negative steering angle turns it to the right
    np.tan(steering) -> np.tan(abs(steering))
the car turns to the wrong side; a positive steering angle turns it to the left
    heading + turn -> heading - turn
the steering angle is in radians; do not convert it
    np.tan(steering) -> np.tan(np.deg2rad(steering))
the wheelbase is an argument; do not write 0.3 into the formula
    / wheelbase -> / 0.3
the turning rate alone came back as heading; add the turn to the old heading
    heading + turn -> turn
the changes came back; add them to the pose
    heading + turn]) -> heading + turn]) - pose
cos belongs to x and sin to y
    np.cos -> np.COS
    np.sin -> np.cos
    np.COS -> np.sin
the rear axle moves along the heading, not along heading + steering
    np.cos(heading) -> np.cos(heading + steering)
    np.sin(heading) -> np.sin(heading + steering)
x and y use the heading after the turn; take the one at the start of the step
    np.cos(heading) -> np.cos(heading + turn)
    np.sin(heading) -> np.sin(heading + turn)
the step runs along the heading, not always along x
    np.cos(heading) -> 1
    np.sin(heading) -> 0
the step, too, is the speed times the seconds
    speed * seconds -> speed
limit nothing here: the car's motors limit steering and speed before this function
    = pose -> = pose; speed, steering = np.clip(speed, -0.3, 0.8), np.clip(steering, -0.45, 0.45)
"""


def _same(got: Array, want: Array, pose: Array, *rest: float) -> bool:
    """Whether two poses agree, whole turns apart.

    A step that lies between the straight one and the arc is as good as either; `want` may be any
    pose, such as that of a known mistake.
    """
    if not np.isfinite(got).all() or abs(geometry.wrap(got[2] - want[2])) > 1e-6:
        return False
    arc, straight = bicycle_step(pose, *rest)[:2], _straight(pose, *rest)[:2]
    if not close(want[:2], arc, tolerance=1e-9):
        return close(got[:2], want[:2])
    gap = np.linalg.norm(arc - straight)
    nearest = min(np.linalg.norm(got[:2] - place) for place in (arc, straight))
    return bool(nearest < 1e-6 + 0.15 * gap)


check_bicycle_step = exercise(
    bicycle_step,
    topics(TOPICS),
    about="The kinematic bicycle: a straight step along the first heading, or the exact arc.",
    example=case(np.array([1.0, 2.0, 0.5]), 0.5, 0.2, 0.3, 0.02),
    others=mistakes_of(_straight, MISTAKES),
    form=lambda what, answer, *_: numbers(what, answer, (3,)),
    same=_same,
)
