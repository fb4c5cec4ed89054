"""The check of the waypoint label, in notebook 02."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.checks.framework.answers import numbers
from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import close, farthest
from tutorial_lib.checks.framework.topics import Topic, judge_topics
from tutorial_lib.checks.nb02.label_cases import (
    CORNER,
    CORNER_WALL,
    FAR_WALL,
    LONG,
    POST,
    ROUND,
    STRAIGHT,
    among,
    case,
    clear_sight,
    only,
    random_case,
)
from tutorial_lib.checks.nb02.label_mistakes import BEHIND, FAULTS, waypoint_label
from tutorial_lib.checks.nb02.label_picture import labels_from_above
from tutorial_lib.geometry import Array
from tutorial_lib.world.raycast import Raycaster


def _topics() -> list[Topic]:
    rng = np.random.default_rng(9)
    none = "nothing is in sight, so there is no last place; return None"
    return [
        Topic(
            "round a corner",
            "of frames source + 1 to target, take the last that is in sight, as seen from start",
            [case([1.0, -0.2, 0.3], CORNER, 10, 40, among([CORNER_WALL]))],
        ),
        Topic(
            "a target in sight",
            "the target itself is a candidate: here it is the waypoint",
            [case([0.2, 0.1, 0.3], CORNER, 2, 15, among([FAR_WALL]))],
        ),
        Topic(
            "past a post",
            "the last place in sight counts, also if a post hides some places before it",
            [case([0.0, -0.6, 0.2], STRAIGHT, 0, 40, among([POST]))],
        ),
        Topic(
            "out and back",
            "the last place along the trajectory counts, whatever its distance in metres",
            [case([0.0, 0.3, 0.0], ROUND, 0, len(ROUND) - 1, among([FAR_WALL]))],
        ),
        Topic(
            "a trajectory that goes on",
            "nothing beyond the target is a candidate",
            [case([0.5, 0.2, 0.1], STRAIGHT, 5, 20, among([FAR_WALL]))],
        ),
        Topic(
            "a waypoint 12 m away",
            "there is no largest distance: the farthest place in sight counts",
            [case([0.0, 0.2, 0.1], LONG, 0, 120, among([FAR_WALL]))],
        ),
        Topic(
            "only the first candidate in sight",
            "the first candidate is frame source + 1",
            [case([0.5, 0.2, 0.1], STRAIGHT, 5, 20, only(STRAIGHT, [6]))],
        ),
        Topic(
            "a waypoint 3 cm away",
            "there is no smallest distance: a place beside the car counts",
            [case([0.6, 0.03, 0.1], STRAIGHT, 5, 20, only(STRAIGHT, [6]))],
        ),
        Topic(
            "target behind, in sight",
            BEHIND,
            [case([2.1, 1.5, 1.6], CORNER, 35, 25, among([CORNER_WALL]))],
        ),
        Topic(
            "target behind, hidden",
            BEHIND,
            [case([2.1, 1.5, 1.6], CORNER, 35, 5, among([CORNER_WALL]))],
        ),
        Topic(
            "target at the source",
            "a target at the source's own frame is its own waypoint too: target <= source",
            [
                case([0.9, 0.2, -0.4], CORNER, 10, 10, among([CORNER_WALL])),
                case([0.9, 0.2, -0.4], CORNER, 10, 10, only(CORNER, [])),
            ],
        ),
        Topic(
            "nothing in sight",
            none,
            [case([0.1, 0.0, 0.0], STRAIGHT, 2, 30, among([[0.25, -2, 0.25, 2]]))],
        ),
        Topic(
            "nothing in sight but the place of source, and places before it or after the target",
            f"these are no candidates; {none}",
            [
                case([0.1, 0.3, 0.0], STRAIGHT, 9, 30, only(STRAIGHT, [9])),
                case([0.1, 0.3, 0.0], STRAIGHT, 9, 30, only(STRAIGHT, [3, 35])),
            ],
        ),
        Topic(
            "40 random trajectories",
            "take the last frame in sight from source + 1 to target, whatever the distances; a "
            "target at or before source is its own waypoint",
            [random_case(rng) for _ in range(40)],
        ),
    ]


@check(
    waypoint_label,
    (np.zeros(3), STRAIGHT, 0, 40, clear_sight(Raycaster([FAR_WALL]))),
)
def check_waypoint_label(student: Callable[..., Any]) -> NDArray[np.uint8]:
    """Round a corner, past a post, out and back, targets ahead and behind, nothing in sight."""
    judge_topics(
        "waypoint_label",
        student,
        _topics(),
        waypoint_label,
        FAULTS,
        form=_form,
        same=_same,
        difference=_difference,
        draw=_picture,
    )
    return _picture(student)


def _form(what: str, answer: object, *arguments: Any) -> Array | None:  # noqa: ANN401
    if answer is None:
        return None
    if isinstance(answer, int | np.integer):
        raise WrongAnswer(f"{what}: a frame's index came back; return its place, an array (2,)")
    if waypoint_label(*arguments) is None and np.shape(answer) != (2,):
        raise WrongAnswer(f"{what}: there is no waypoint; return None, no {type(answer).__name__}")
    return numbers(what, answer, (2,))


def _same(got: Array | None, want: Array | None, *_: object) -> bool:
    if got is None or want is None:
        return got is want
    return close(got, want)


def _difference(got: Array | None, want: Array | None, *_: object) -> str:
    if want is None:
        return f"{np.round(got, 2).tolist()} came back, but there is no waypoint; return None"
    if got is None:
        return f"None came back, but {want.round(2).tolist()} is right"
    return farthest(got, want)


def _picture(student: Callable[..., Any]) -> NDArray[np.uint8]:
    arguments = _topics()[0].cases[0]
    right, yours = waypoint_label(*arguments), student(*arguments)
    return labels_from_above(np.array([CORNER_WALL]), *arguments[:2], right, yours)
