"""The check of a ray against a wall, in notebook 01."""

from collections.abc import Callable

import numpy as np

from tutorial_lib.checks.framework.answers import numbers
from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import close
from tutorial_lib.checks.framework.topics import Topic, judge_topics
from tutorial_lib.checks.framework.wording import kind
from tutorial_lib.geometry import Array

_PARALLEL = 1e-12


def ray_segment(origin: Array, direction: Array, start: Array, end: Array) -> float:
    """Metres from `origin` along `direction` to the wall, inf when it is missed."""
    if abs(_cross(direction, end - start)) < _PARALLEL:
        return np.inf
    t, u = _meet(origin, direction, start, end)
    return t if t >= 0 and 0 <= u <= 1 else np.inf


def _cross(p: Array, q: Array) -> float:
    return float(p[0] * q[1] - p[1] * q[0])


def _meet(origin: Array, direction: Array, start: Array, end: Array) -> tuple[float, float]:
    """The t and u of the ray and the line of the wall; inf or nan if they are parallel."""
    wall, offset = end - start, start - origin
    across = np.float64(_cross(direction, wall))
    return _cross(offset, wall) / across, _cross(offset, direction) / across


def _variant(
    hit: Callable[[float, float], bool] = lambda t, u: t >= 0 and 0 <= u <= 1,
    value: Callable[[float, float], float] = lambda t, u: t,
    miss: float = np.inf,
    parallel: float = np.inf,
) -> Callable[..., float]:
    """The rule with another condition or other answers."""

    def rule(origin: Array, direction: Array, start: Array, end: Array) -> float:
        if abs(_cross(direction, end - start)) < _PARALLEL:
            return parallel
        t, u = _meet(origin, direction, start, end)
        return value(t, u) if hit(t, u) else miss

    return rule


def _in_metres(origin: Array, direction: Array, start: Array, end: Array) -> float:
    u = _meet(origin, direction, start, end)[1] * np.linalg.norm(end - start)
    t = ray_segment(origin, direction, start, end)
    return u if np.isfinite(t) else t


def _unit_wall(origin: Array, direction: Array, start: Array, end: Array) -> float:
    unit = start + (end - start) / np.linalg.norm(end - start)
    return ray_segment(origin, direction, start, unit)


_FAULTS = {
    "the ray passes beyond the wall's ends there: test u, on both sides": _variant(
        lambda t, u: t >= 0
    ),
    "the ray passes before the wall's start there: u must not be negative": _variant(
        lambda t, u: t >= 0 and u <= 1
    ),
    "the ray passes beyond the wall's end there: u must not be above 1": _variant(
        lambda t, u: t >= 0 and u >= 0
    ),
    "it is behind the robot: t must not be negative": _variant(lambda t, u: 0 <= u <= 1),
    "it is behind the robot: a negative t is a miss, whatever its size": _variant(
        lambda t, u: 0 <= u <= 1, lambda t, u: abs(t)
    ),
    "a ray that starts on the wall hits it at 0 m: t = 0 counts": _variant(
        lambda t, u: t > 0 and 0 <= u <= 1
    ),
    "a ray that hits exactly an end of the wall hits it: u = 0 and u = 1 count": _variant(
        lambda t, u: t >= 0 and 0 < u < 1
    ),
    "u must not be negative: test 0 <= u, not its absolute value": _variant(
        lambda t, u: t >= 0 and abs(u) <= 1
    ),
    "both conditions must hold, t >= 0 and 0 <= u <= 1; one alone is not enough": _variant(
        lambda t, u: t >= 0 or 0 <= u <= 1
    ),
    "t is a distance in metres; it has no upper limit, and only u ends at 1": _variant(
        lambda t, u: 0 <= t <= 1 and 0 <= u <= 1
    ),
    "a ray that misses returns np.inf, not 0": _variant(miss=0.0, parallel=0.0),
    "a ray that misses returns np.inf, not -1": _variant(miss=-1.0, parallel=-1.0),
    "a ray that misses returns np.inf, not nan": _variant(miss=np.nan, parallel=np.nan),
    "that is how far along the wall the ray hits (u), not how far away it is (t)": _variant(
        value=lambda t, u: u
    ),
    "that is how far along the wall the ray hits, in metres, not how far away it is": _in_metres,
    "a sign is wrong: the offset runs from the ray's origin to the wall's start, a - o": _variant(
        lambda t, u: t <= 0 and -1 <= u <= 0, lambda t, u: -t
    ),
    "u has the wrong sign: both fractions have a - o above and d x (b - a) below": _variant(
        lambda t, u: t >= 0 and -1 <= u <= 0
    ),
    "the wall runs from a to b: subtract a from b": (
        lambda origin, direction, start, end: ray_segment(origin, direction, start, start + end)
    ),
    "the offset runs from the ray's origin to the wall's start: subtract o from a": (
        lambda origin, direction, start, end: ray_segment(0 * origin, direction, start, end)
    ),
    "u is a share of the wall's length; do not divide b - a by its length": _unit_wall,
    "a parallel wall is missed: return np.inf before you divide by zero": _variant(parallel=np.nan),
    "a parallel wall is missed: its answer, too, is np.inf": _variant(parallel=0.0),
}


def _topics() -> list[Topic]:
    ahead, slanted = [1.0, 0.0], [0.6, 0.8]
    by, at = [0.5, 0.25], [0.0, 0.0]

    def case(origin: list, direction: list, start: list, end: list) -> tuple[Array, ...]:
        return tuple(np.array(p, dtype=float) for p in (origin, direction, start, end))

    def both(about: str, words: str, *cases: tuple[Array, ...]) -> Topic:
        """The cases, and the same walls the other way round."""
        turned = [(o, d, end, start) for o, d, start, end in cases]
        return Topic(about, words, [*cases, *turned])

    return [
        Topic(
            "a wall straight ahead",
            "solve for t and u by the two fractions above; t is the answer",
            [case(by, ahead, [2, -1], [2, 1.5])],
        ),
        both(
            "the same wall the other way round",
            "which end is the start does not matter: the denominator may be negative",
            case(by, ahead, [2, -1], [2, 1.5]),
        ),
        both(
            "slanting rays and walls",
            "check the signs of the two fractions",
            case(by, slanted, [0, 2], [3, 1.4]),
            case(by, [-0.6, 0.8], [-3, 1], [1, 2]),
            case(by, [-0.8, -0.6], [-3, -1], [1, -2]),
        ),
        Topic(
            "a wall to the side, whose start is nearer to the ray",
            "the ray passes before the wall's start: u is negative, so it misses",
            [case(by, ahead, [2, 1], [2, 3]), case(by, slanted, [2, 1], [4, 0])],
        ),
        Topic(
            "a wall to the side, whose end is nearer to the ray",
            "the ray passes beyond the wall's end: u is above 1, so it misses",
            [case(by, ahead, [2, 3], [2, 1]), case(by, slanted, [4, 0], [2, 1])],
        ),
        both(
            "a wall that the ray just misses",
            "beyond an end by a centimetre or less is a miss, too: u runs from 0 to 1, exactly",
            case(by, ahead, [2, 0.26], [2, 1.26]),
            case(by, ahead, [2, -0.75], [2, 0.24]),
            case(by, ahead, [2, 0.2501], [2, 1.2501]),
        ),
        both(
            "a wall behind the robot",
            "a ray runs one way only: t is negative, so it misses",
            case(by, ahead, [-1, -1], [-1, 1]),
            case(by, ahead, [0.25, -1], [0.25, 1]),
            case(by, ahead, [0.4999, -1], [0.4999, 1]),
            case(by, slanted, [-2, 0], [2, -2]),
        ),
        both(
            "a ray that starts on the wall",
            "t = 0 counts: the answer is 0",
            case(at, ahead, [0, -1], [0, 1]),
        ),
        both(
            "a ray that hits exactly an end of the wall",
            "u = 0 and u = 1 count: the ray hits",
            case(at, ahead, [2, 0], [2, 1]),
            case(at, [0, 1], [-2, 4], [0, 4]),
        ),
        both(
            "a parallel wall, beside the ray",
            "it is missed: return np.inf before you divide by zero",
            case(by, ahead, [1, 1], [3, 1]),
            case(at, slanted, [1, 0], [1.6, 0.8]),
        ),
        both(
            "a wall along the ray",
            "it is parallel too, so it is missed: return np.inf",
            case(by, ahead, [1, 0.25], [3, 0.25]),
            case(at, ahead, [-1, 0], [1, 0]),
        ),
        both(
            "a wall along a slanting ray, whose denominator is 1e-16",
            "rounding keeps it from being zero: 1e-12 or less counts as parallel, to either side",
            case([0, 0.1], slanted, [0.3, 0.5], [0.9, 1.3]),
            case([0, 0.1], slanted, [0.36, 0.58], [0.66, 0.98]),
        ),
        both(
            "a wall 200 m away",
            "the function has no largest range: far hits count, too",
            case(by, ahead, [200, -300], [200, 300]),
        ),
        both(
            "a wall that is almost parallel to the ray",
            "a small denominator is not zero: only 1e-12 or less counts as parallel",
            case(at, ahead, [10, -0.0001], [20, 0.0001]),
            case(at, ahead, [1, -2e-10], [3, 2e-10]),
        ),
        both(
            "walls of 1 cm and of 1 mm",
            "a short wall has a small denominator, but it is not parallel",
            case(by, ahead, [3, 0.245], [3, 0.255]),
            case(by, ahead, [3, 0.2495], [3, 0.2505]),
        ),
        Topic(
            "60 random rays",
            "the simple cases are right; does a part of your rule hold for some directions only?",
            _random(60),
        ),
    ]


def _random(count: int) -> list[tuple[Array, ...]]:
    rng = np.random.default_rng(4)
    angles = rng.uniform(-np.pi, np.pi, count)
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    places = rng.uniform(-4, 4, (count, 3, 2))
    places[::2, 0] *= 0.3
    return [(o, d, a, b) for (o, a, b), d in zip(places, directions, strict=True)]


@check(ray_segment, tuple(np.array(p) for p in ([0.0, 0.0], [1.0, 0.0], [2.0, -1.0], [2.0, 1.0])))
def check_ray_segment(student: Callable[..., float]) -> None:
    """A ray against one wall: hits, misses, ends, walls behind and parallel ones."""
    with np.errstate(divide="ignore", invalid="ignore"):
        judge_topics(
            "ray_segment",
            student,
            _topics(),
            ray_segment,
            _FAULTS,
            form=_form,
            same=_same,
            difference=_difference,
        )


def _form(what: str, answer: object, *case: Array) -> Array:
    if answer is None and np.isinf(ray_segment(*case)):
        raise WrongAnswer(f"{what}: nothing came back; a ray that misses returns np.inf")
    if isinstance(answer, list | tuple):
        raise WrongAnswer(f"{what}: {kind(answer)} came back; return one number")
    if np.shape(answer) == (2,):
        raise WrongAnswer(f"{what}: a point came back; return how far away it is, one number")
    if np.shape(answer):
        raise WrongAnswer(f"{what}: shape {np.shape(answer)} came back; return one number")
    return numbers(what, answer, ())


def _same(got: Array, want: float, *case: Array) -> bool:
    """Whether two answers agree; of a wall along the ray, any distance on it is good, too.

    Only where rounding keeps the denominator from being zero: other rules than that of the two
    fractions see such a wall as crossing the ray.
    """
    origin, direction, start, end = case
    near, far = sorted([(start - origin) @ direction, (end - origin) @ direction])
    rounded = 0 < abs(_cross(direction, end - start)) < _PARALLEL
    return close(got, want, tolerance=1e-5) or bool(rounded and near > 0 and near <= got <= far)


def _difference(got: Array, want: float, *case: Array) -> str:
    if np.isnan(got):
        return f"not a number came back; {want:.4g} is right. Is something divided by zero?"
    if np.isinf(want) and np.isfinite(got) and got < 0:
        return f"{got:.4g} came back; a ray that misses returns np.inf"
    return f"{got:.4g} came back; {want:.4g} is right"
