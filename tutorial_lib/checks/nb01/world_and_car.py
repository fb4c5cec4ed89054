"""Checks of notebook 01."""

from collections.abc import Callable

import cv2
import numpy as np
from numpy.typing import NDArray

from tutorial_lib import geometry
from tutorial_lib.checks.framework.check import WrongAnswer, call, check, expect_close
from tutorial_lib.geometry import Array
from tutorial_lib.world.bodies import BicycleCar, advance
from tutorial_lib.world.raycast import Fan, Raycaster
from tutorial_lib.world.sensors import EYE, WALL_HEIGHT, Camera

Function = Callable[..., Array]

_RNG_SEED = 1


@check(geometry.to_local, (np.array([1.0, 2.0, 0.5]), np.ones((100, 2))))
def check_to_local(student: Function) -> None:
    """Points of the world in the robot's frame."""
    rng = np.random.default_rng(_RNG_SEED)
    for pose in ([0.0, 0.0, 0.0], [2.0, -1.0, 0.0], [1.0, 2.0, 0.7], [-3.0, 0.5, 2.5]):
        pose, points = np.array(pose), rng.uniform(-4, 4, (5, 2))
        turned = geometry.to_world([0, 0, pose[2]], points - pose[:2])
        mistakes = {
            "the robot's frame is turned the wrong way; use minus the heading": turned,
            "subtract the robot's position before you turn": geometry.to_local(
                [0, 0, pose[2]], points
            ),
            "in the wrong order: shift first, then turn": geometry.to_local([0, 0, pose[2]], points)
            - pose[:2],
            "headings are in radians, not degrees": geometry.to_local(
                [*pose[:2], np.deg2rad(pose[2])], points
            ),
        }
        want = geometry.to_local(pose, points)
        expect_close(
            f"to_local from {pose.tolist()}", call(student, pose, points), want, 1e-6, mistakes
        )


@check(geometry.compose, (np.array([1.0, 2.0, 0.5]), np.array([0.1, 0.0, 0.2])))
def check_compose(student: Function) -> None:
    """One motion after another."""
    cases = (
        ([1.0, 2.0, 0.4], [0.5, 0.2, 0.3]),
        ([0.0, 1.0, -2.0], [1.5, -0.5, 1.0]),
        ([2.0, 0.0, 2.8], [1.0, 0.0, 1.4]),
    )
    for first, second in cases:
        first, second = np.array(first), np.array(second)
        want = geometry.compose(first, second)
        plain = np.array([*(first + second)[:2], want[2]])
        mistakes = {
            "the second pose is seen from the first: turn its step by the first heading": plain,
            "the other way round: first comes first": geometry.compose(second, first),
            "wrap the heading into -pi to pi": [*want[:2], first[2] + second[2]],
            "headings add up: the second is measured from the first": [*want[:2], second[2]],
            "the step is turned the wrong way; from the robot to the world it is R itself": [
                *geometry.compose([*first[:2], -first[2]], second)[:2],
                want[2],
            ],
            "turn the step by the first heading alone; the second comes after it": [
                *geometry.to_world([*first[:2], first[2] + second[2]], second[:2]),
                want[2],
            ],
            "wrap the heading into -pi to pi, not 0 to 2 pi": [*want[:2], want[2] % (2 * np.pi)],
        }
        what = f"compose of {first.tolist()} and {second.tolist()}"
        expect_close(what, call(student, first, second), want, 1e-6, mistakes)


def bicycle_step(
    pose: Array, speed: float, steering: float, wheelbase: float, seconds: float
) -> Array:
    """A pose (3,) after driving on, by the library's car."""
    car = BicycleCar(wheelbase=wheelbase)
    x, y, heading = advance(pose, car.twist(np.array([speed, steering])), seconds)
    return np.array([x, y, pose[2] + geometry.wrap(heading - pose[2])])


@check(bicycle_step, (np.array([1.0, 2.0, 0.5]), 0.5, 0.2, 0.3, 0.02))
def check_bicycle_step(student: Function) -> None:
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


def ray_segment(origin: Array, direction: Array, start: Array, end: Array) -> float:
    """Metres from `origin` along `direction` to the wall, inf when it is missed."""
    heading = np.arctan2(direction[1], direction[0])
    caster = Raycaster([[*start, *end]])
    return float(caster.cast(np.array([[*origin, heading]]), Fan([0.0])).distance[0, 0])


@check(ray_segment, tuple(np.array(p) for p in ([0.0, 0.0], [1.0, 0.0], [2.0, -1.0], [2.0, 1.0])))
def check_ray_segment(student: Function) -> None:
    """A ray against one wall: hits, misses, walls behind and parallel ones."""
    straight = np.array([1.0, 0.0])
    slanted = np.array([0.6, 0.8])
    origin = np.array([0.5, 0.2])
    cases = (
        ("ahead", straight, [2.0, -1.0], [2.0, 1.5], {}),
        ("slanting", slanted, [0.0, 2.0], [3.0, 1.4], {}),
        ("to the side", straight, [2.0, 1.0], [2.0, 3.0], {"the ray passes beyond its ends": 1.5}),
        ("behind", straight, [-1.0, -1.0], [-1.0, 1.0], {"it is behind the robot": 1.5}),
        ("parallel", straight, [1.0, 1.0], [3.0, 1.0], {"a parallel wall is missed": np.nan}),
    )
    for name, direction, start, end, mistakes in cases:
        start, end = np.array(start), np.array(end)
        want = ray_segment(origin, direction, start, end)
        if np.isfinite(want):
            place = np.linalg.norm(origin + want * direction - start)
            share = place / np.linalg.norm(end - start)
            along = "that is how far along the wall the ray hits, not how far away"
            mistakes = {f"{along} (a share)": share, f"{along} (metres)": place}
        with np.errstate(divide="ignore", invalid="ignore"):
            answer = call(student, origin, direction, start, end)
        expect_close(f"ray_segment, wall {name}", answer, want, 1e-6, mistakes)


def wall_share(depth: float, rows: int) -> Array:
    """(rows,) the share of each pixel of a column that a wall at `depth` covers, from the top."""
    return _shares((WALL_HEIGHT - EYE) / depth, -EYE / depth, rows)


@check(wall_share, (2.0, 16))
def check_wall_share(student: Function) -> NDArray[np.uint8]:
    """One column of a picture, with exact shares."""
    depths, rows = np.array([0.6, 1.0, 1.7, 3.1, 6.0]), 16
    answers = []
    for depth in depths:
        got = student(depth, rows)
        answers.append(got if np.shape(got) == (rows,) else np.full(rows, np.nan))
    picture = _columns([wall_share(depth, rows) for depth in depths], answers)
    for depth in depths:
        want = wall_share(depth, rows)
        halves = _shares(0.5 / depth, -0.5 / depth, rows)
        mistakes = {
            "some pixels are partly covered; give the share, not 0 or 1": np.round(want),
            "upside down: row 0 is the top of the picture": want[::-1],
            "the eye is 0.25 m above the floor, not half way up the wall": halves,
            "divide the heights by the depth": _shares(WALL_HEIGHT - EYE, -EYE, rows),
            "the wall rises 0.75 m above the eye, not 1 m": _shares(
                WALL_HEIGHT / depth, -EYE / depth, rows
            ),
        }
        got = student(depth, rows)
        values = np.asarray(got, dtype=float) if got is not None else want
        if values.shape == want.shape and ((values < -1e-6) | (values > 1 + 1e-6)).any():
            raise WrongAnswer("wall_share: shares lie between 0 and 1; clip them", picture)
        expect_close(f"wall_share at {depth} m", got, want, 2e-3, mistakes, picture)
    return picture


def _shares(top: float, bottom: float, rows: int) -> Array:
    slope = Camera().slope
    height = 2 * slope / rows
    upper = slope - height * np.arange(rows)
    return np.clip((np.minimum(top, upper) - np.maximum(bottom, upper - height)) / height, 0, 1)


def _columns(target: list[Array], yours: list[Array]) -> NDArray[np.uint8]:
    """Target and yours, one column of pixels for each depth, with their names."""
    blocks = []
    for name, shares in (("target", target), ("yours", yours)):
        grey = np.nan_to_num(np.clip(np.stack(shares, axis=1), 0, 1))
        pixels = (235 - 175 * grey).astype(np.uint8)
        block = cv2.resize(pixels, None, fx=32, fy=12, interpolation=cv2.INTER_NEAREST)
        block = cv2.copyMakeBorder(block, 26, 6, 6, 6, cv2.BORDER_CONSTANT, value=255)
        cv2.putText(block, name, (6, 18), cv2.FONT_HERSHEY_SIMPLEX, 0.5, 45, 1, cv2.LINE_AA)
        blocks.append(block)
    return np.repeat(np.concatenate(blocks, axis=1)[..., None], 3, axis=2)
