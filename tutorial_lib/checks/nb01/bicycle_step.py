"""The check of the kinematic bicycle, in notebook 01."""

from collections.abc import Callable

import numpy as np

from tutorial_lib import geometry
from tutorial_lib.checks.framework.answers import numbers
from tutorial_lib.checks.framework.check import check
from tutorial_lib.checks.framework.comparison import close
from tutorial_lib.checks.framework.topics import Topic, judge_topics
from tutorial_lib.geometry import Array
from tutorial_lib.world.bodies import BicycleCar, advance

Step = tuple[Array, float, float, float, float]


def bicycle_step(
    pose: Array, speed: float, steering: float, wheelbase: float, seconds: float
) -> Array:
    """The pose (3,) after one step, by the library's car."""
    car = BicycleCar(wheelbase=wheelbase)
    x, y, heading = advance(pose, car.twist(np.array([speed, steering])), seconds)
    return np.array([x, y, pose[2] + geometry.wrap(heading - pose[2])])


def _straight(pose: Array, step: float, heading: float, turn: float) -> Array:
    """A step in metres along a heading, and a turn."""
    return pose + np.array([step * np.cos(heading), step * np.sin(heading), turn])


def _with_turn(turn: Callable[..., float]) -> Callable[..., Array]:
    """The right step with another rule for the turn: (speed, steering, wheelbase, seconds)."""
    return lambda pose, speed, *rest: _straight(pose, speed * rest[-1], pose[2], turn(speed, *rest))


def _turn(speed: float, steering: float, wheelbase: float, seconds: float) -> float:
    return speed * np.tan(steering) / wheelbase * seconds


def _along(heading: Callable[..., float]) -> Callable[..., Array]:
    """The right turn with another heading for the step: (heading, turn, steering)."""
    return lambda pose, speed, steering, wheelbase, seconds: _straight(
        pose,
        speed * seconds,
        heading(pose[2], _turn(speed, steering, wheelbase, seconds), steering),
        _turn(speed, steering, wheelbase, seconds),
    )


def _swapped(pose: Array, speed: float, *rest: float) -> Array:
    step = speed * rest[-1]
    return pose + np.array([step * np.sin(pose[2]), step * np.cos(pose[2]), _turn(speed, *rest)])


def _euler(pose: Array, *controls: float) -> Array:
    return _straight(pose, controls[0] * controls[-1], pose[2], _turn(*controls))


_FAULTS = {
    "the car turns even when it stands; multiply the tangent by the speed": _with_turn(
        lambda v, steering, wheelbase, dt: np.tan(steering) / wheelbase * dt
    ),
    "divide by the wheelbase, do not multiply": _with_turn(
        lambda v, steering, wheelbase, dt: v * np.tan(steering) * wheelbase * dt
    ),
    "the turning rate has the tangent of the steering angle, tan, in it": _with_turn(
        lambda v, steering, wheelbase, dt: v * steering / wheelbase * dt
    ),
    "the wheelbase is missing: the turning rate is divided by it": _with_turn(
        lambda v, steering, wheelbase, dt: v * np.tan(steering) * dt
    ),
    "np.tan takes radians, and the steering angle is in radians; do not convert it": _with_turn(
        lambda v, steering, wheelbase, dt: v * np.tan(np.rad2deg(steering)) / wheelbase * dt
    ),
    "the turn is the rate times the seconds, once; the seconds count twice in yours": _with_turn(
        lambda v, steering, wheelbase, dt: v * np.tan(steering) / wheelbase * dt * dt
    ),
    "v is the speed of the rear axle, so the step and the turn have no cosine of the steering "
    "angle in them": (
        lambda pose, v, steering, wheelbase, dt: _straight(
            pose, v * np.cos(steering) * dt, pose[2], v * np.sin(steering) / wheelbase * dt
        )
    ),
    "divided by the seconds; a rate is multiplied by them": (
        lambda pose, speed, steering, wheelbase, seconds: _straight(
            pose, speed / seconds, pose[2], speed * np.tan(steering) / wheelbase / seconds
        )
    ),
    "a car in reverse moves backwards; do not stop it, nor take the speed without its sign": (
        lambda pose, speed, *rest: _euler(pose, max(speed, 0.0), *rest)
    ),
    "a car in reverse moves backwards; take the speed with its sign": (
        lambda pose, speed, *rest: _straight(
            pose, abs(speed) * rest[-1], pose[2], _turn(speed, *rest)
        )
    ),
    "the turning rate has the tangent of the steering angle, not its sine": _with_turn(
        lambda v, steering, wheelbase, dt: v * np.sin(steering) / wheelbase * dt
    ),
    "the turning rate has the tangent of the steering angle, np.tan, not its inverse": _with_turn(
        lambda v, steering, wheelbase, dt: v * np.arctan(steering) / wheelbase * dt
    ),
    "the turn is the turning rate times the seconds": _with_turn(
        lambda v, steering, wheelbase, dt: v * np.tan(steering) / wheelbase
    ),
    "in reverse the turn changes its sign too; do not take the speed without its sign": _with_turn(
        lambda v, steering, wheelbase, dt: _turn(abs(v), steering, wheelbase, dt)
    ),
    "the car always turns left; a negative steering angle turns it to the right": _with_turn(
        lambda v, steering, wheelbase, dt: _turn(v, abs(steering), wheelbase, dt)
    ),
    "the car turns to the wrong side; a positive steering angle turns it to the left": _with_turn(
        lambda v, steering, wheelbase, dt: -_turn(v, steering, wheelbase, dt)
    ),
    "the steering angle is in radians; do not convert it": _with_turn(
        lambda v, steering, wheelbase, dt: _turn(v, np.deg2rad(steering), wheelbase, dt)
    ),
    "the wheelbase is an argument; do not write 0.3 into the formula": _with_turn(
        lambda v, steering, wheelbase, dt: _turn(v, steering, 0.3, dt)
    ),
    "the turning rate alone came back as heading; add the turn to the old heading": (
        lambda pose, *controls: np.array([*_euler(pose, *controls)[:2], _turn(*controls)])
    ),
    "the changes came back; add them to the pose": (
        lambda pose, *controls: _euler(pose, *controls) - pose
    ),
    "cos belongs to x and sin to y": _swapped,
    "the rear axle moves along the heading, not along heading + steering": _along(
        lambda heading, turn, steering: heading + steering
    ),
    "x and y use the heading after the turn; take the one at the start of the step": _along(
        lambda heading, turn, steering: heading + turn
    ),
    "the step runs along the heading, not always along x": _along(
        lambda heading, turn, steering: 0.0
    ),
    "the step, too, is the speed times the seconds": (
        lambda pose, speed, *rest: _straight(pose, speed, pose[2], _turn(speed, *rest))
    ),
    "limit nothing here: the car's motors limit steering and speed before this function": (
        lambda pose, speed, steering, *rest: _euler(
            pose, np.clip(speed, -0.3, 0.8), np.clip(steering, -0.45, 0.45), *rest
        )
    ),
}


def _topics() -> list[Topic]:
    rng = np.random.default_rng(3)
    ranges = np.array([[-1.5, -0.7, 0.15, 0.01], [1.5, 0.7, 1.2, 0.12]])
    pose = np.array([1.0, 2.0, 0.5])
    random = [
        (rng.uniform([-3, -3, -3], [3, 3, 3]), *(float(c) for c in rng.uniform(*ranges)))
        for _ in range(30)
    ]
    return [
        Topic(
            "a car that stands, with its wheels turned",
            "a car at rest neither moves nor turns",
            [(pose, 0.0, 0.4, 0.3, 0.02)],
        ),
        Topic(
            "straight ahead at 0.8 m/s with heading 0",
            "with straight wheels the heading stays, and x grows by speed times seconds",
            [(np.array([1.0, 2.0, 0.0]), 0.8, 0.0, 0.3, 0.02)],
        ),
        Topic(
            "straight ahead at 0.8 m/s with heading 0.5",
            "with straight wheels the heading stays, and the car moves along it",
            [(pose, 0.8, 0.0, 0.3, 0.02)],
        ),
        Topic(
            "a left turn at 0.8 m/s, steering 0.45 rad",
            "write down the three equations, each times the seconds",
            [(pose, 0.8, 0.45, 0.3, 0.02)],
        ),
        Topic(
            "a right turn at 0.5 m/s, steering -0.3 rad",
            "a negative angle turns the car to the right; the same equations hold",
            [(pose, 0.5, -0.3, 0.3, 0.02)],
        ),
        Topic(
            "in reverse at -0.3 m/s, to either side",
            "a negative speed needs no special case: place and heading both change their sign",
            [(pose, -0.3, 0.4, 0.3, 0.02), (pose, -0.3, -0.4, 0.3, 0.02)],
        ),
        Topic(
            "a car with another wheelbase",
            "the wheelbase is an argument: a car twice as long turns half as fast",
            [(pose, 0.8, 0.3, 0.6, 0.02), (pose, 0.8, 0.3, 1.1, 0.02)],
        ),
        Topic(
            "steps of other lengths",
            "the seconds are an argument: twice the time, twice the step and twice the turn",
            [(pose, 0.8, 0.3, 0.3, seconds) for seconds in (0.01, 0.05, 0.1)],
        ),
        Topic(
            "a fast car with its wheels turned far",
            "limit nothing here: the car's motors limit steering and speed before this function",
            [(pose, 1.5, 0.0, 0.3, 0.02), (pose, -1.0, 0.0, 0.3, 0.02), (pose, 0.5, 0.7, 0.3, 0.1)],
        ),
        Topic(
            "a slow car, and one whose wheels are hardly turned",
            "a slow car moves, and a small steering angle turns it: leave no small number out",
            [
                (pose, 0.03, 0.4, 0.3, 0.1),
                (pose, 0.8, 0.02, 0.3, 0.1),
                (pose, 0.8, -0.02, 0.3, 0.1),
            ],
        ),
        Topic(
            "30 random steps",
            "the simple cases are right; does a part of your formula hold for some of them only?",
            random,
        ),
    ]


@check(bicycle_step, (np.array([1.0, 2.0, 0.5]), 0.5, 0.2, 0.3, 0.02))
def check_bicycle_step(student: Callable[..., Array]) -> None:
    """The kinematic bicycle: a straight step along the first heading, or the exact arc."""
    judge_topics("bicycle_step", student, _topics(), bicycle_step, _FAULTS, form=_form, same=_same)


def _form(what: str, answer: object, *case: object) -> Array:
    return numbers(what, answer, (3,))


def _same(got: Array, want: Array, *case: object) -> bool:
    """Whether two poses agree, whole turns apart.

    A step that lies between the straight one and the arc is as good as either; `want` may be any
    pose, such as that of a known mistake.
    """
    if not np.isfinite(got).all() or abs(geometry.wrap(got[2] - want[2])) > 1e-6:
        return False
    arc, straight = bicycle_step(*case)[:2], _euler(*case)[:2]
    if not close(want[:2], arc, tolerance=1e-9):
        return close(got[:2], want[:2])
    gap = np.linalg.norm(arc - straight)
    nearest = min(np.linalg.norm(got[:2] - place) for place in (arc, straight))
    return nearest < 1e-6 + 0.15 * gap
