"""The check of a ray against a wall, in notebook 01."""

from typing import Any

import numpy as np

from tutorial_lib.checks.engine import WrongAnswer, close, exercise, hint, kind, numbers, topics
from tutorial_lib.geometry import Array

_PARALLEL = 1e-12


def ray_segment(origin: Array, direction: Array, start: Array, end: Array) -> float:
    """Metres from `origin` along `direction` to the wall, inf when it is missed."""
    wall, offset = end - start, start - origin
    across = _cross(direction, wall)
    if abs(across) < _PARALLEL:
        return np.inf
    t, u = _cross(offset, wall) / across, _cross(offset, direction) / across
    return t if t >= 0 and 0 <= u <= 1 else np.inf


def _cross(p: Array, q: Array) -> float:
    return float(p[0] * q[1] - p[1] * q[0])


_AHEAD, _SLANTED = [1.0, 0.0], [0.6, 0.8]
_BY, _AT = [0.5, 0.25], [0.0, 0.0]


def _ray(origin: list, direction: list, start: list, end: list) -> tuple[Array, ...]:
    return tuple(np.array(p, dtype=float) for p in (origin, direction, start, end))


def _both(words: str, *cases: tuple[Array, ...]) -> tuple:
    """The cases, and the same walls the other way round."""
    return hint(words, *cases, *((o, d, end, start) for o, d, start, end in cases))


def _onto_axes(count: int) -> list[tuple[Array, ...]]:
    """Rays at all angles onto walls along an axis, which they hit."""
    rng, cases = np.random.default_rng(5), []
    for number in range(count):
        start = rng.uniform(-4, 4, 2)
        end = start.copy()
        end[number % 2] += rng.uniform(1, 4)
        origin, hit = rng.uniform(-4, 4, 2), start + rng.uniform(0.2, 0.8) * (end - start)
        cases.append((origin, (hit - origin) / np.linalg.norm(hit - origin), start, end))
    return cases


def _random(count: int) -> list[tuple[Array, ...]]:
    rng = np.random.default_rng(4)
    angles = rng.uniform(-np.pi, np.pi, count)
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    places = rng.uniform(-4, 4, (count, 3, 2))
    places[::2, 0] *= 0.3
    return [(o, d, a, b) for (o, a, b), d in zip(places, directions, strict=True)]


TOPICS = {
    "a wall straight ahead": hint(
        "solve for t and u by the two fractions above; t is the answer",
        _ray(_BY, _AHEAD, [2, -1], [2, 1.5]),
    ),
    "the same wall the other way round": _both(
        "which end is the start does not matter: the denominator may be negative",
        _ray(_BY, _AHEAD, [2, -1], [2, 1.5]),
    ),
    "slanting rays and walls": _both(
        "check the signs of the two fractions",
        _ray(_BY, _SLANTED, [0, 2], [3, 1.4]),
        _ray(_BY, [-0.6, 0.8], [-3, 1], [1, 2]),
        _ray(_BY, [-0.8, -0.6], [-3, -1], [1, -2]),
    ),
    "a wall to the side, whose start is nearer to the ray": hint(
        "the ray passes before the wall's start: u is negative, so it misses",
        _ray(_BY, _AHEAD, [2, 1], [2, 3]),
        _ray(_BY, _SLANTED, [2, 1], [4, 0]),
    ),
    "a wall to the side, whose end is nearer to the ray": hint(
        "the ray passes beyond the wall's end: u is above 1, so it misses",
        _ray(_BY, _AHEAD, [2, 3], [2, 1]),
        _ray(_BY, _SLANTED, [4, 0], [2, 1]),
    ),
    "a wall that the ray just misses": _both(
        "beyond an end by a centimetre or less is a miss, too: u runs from 0 to 1, exactly",
        _ray(_BY, _AHEAD, [2, 0.26], [2, 1.26]),
        _ray(_BY, _AHEAD, [2, -0.75], [2, 0.24]),
        _ray(_BY, _AHEAD, [2, 0.2501], [2, 1.2501]),
        _ray(_BY, _AHEAD, [2, 0.250001], [2, 1.250001]),
    ),
    "a wall behind the robot": _both(
        "a ray runs one way only: t is negative, so it misses",
        _ray(_BY, _AHEAD, [-1, -1], [-1, 1]),
        _ray(_BY, _AHEAD, [0.25, -1], [0.25, 1]),
        _ray(_BY, _AHEAD, [0.4999, -1], [0.4999, 1]),
        _ray(_BY, _SLANTED, [-2, 0], [2, -2]),
    ),
    "a ray that starts on the wall": _both(
        "t = 0 counts: the answer is 0", _ray(_AT, _AHEAD, [0, -1], [0, 1])
    ),
    "a ray that starts on an end of the wall": _both(
        "t = 0 counts there, too: the answer is 0", _ray(_AT, _AHEAD, [0, 0], [0, 1])
    ),
    "a ray that hits exactly an end of the wall": _both(
        "u = 0 and u = 1 count: the ray hits",
        _ray(_AT, _AHEAD, [2, 0], [2, 1]),
        _ray(_AT, [0, 1], [-2, 4], [0, 4]),
    ),
    "a parallel wall, beside the ray": _both(
        "it is missed: return np.inf before you divide by zero",
        _ray(_BY, _AHEAD, [1, 1], [3, 1]),
        _ray(_AT, _SLANTED, [1, 0], [1.6, 0.8]),
    ),
    "a wall along the ray": _both(
        "it is parallel too, so it is missed: return np.inf",
        _ray(_BY, _AHEAD, [1, 0.25], [3, 0.25]),
        _ray(_AT, _AHEAD, [-1, 0], [1, 0]),
    ),
    "a wall along a slanting ray, whose denominator is 1e-16": _both(
        "rounding keeps it from being zero: what is below 1e-12 counts as parallel, to either side",
        _ray([0, 0.1], _SLANTED, [0.3, 0.5], [0.9, 1.3]),
        _ray([0, 0.1], _SLANTED, [0.36, 0.58], [0.66, 0.98]),
    ),
    "a wall 200 m away": _both(
        "the function has no largest range: far hits count, too",
        _ray(_BY, _AHEAD, [200, -300], [200, 300]),
    ),
    "a wall that is almost parallel to the ray": _both(
        "a small denominator is not zero: only what is below 1e-12 counts as parallel",
        _ray(_AT, _AHEAD, [10, -0.0001], [20, 0.0001]),
        _ray(_AT, _AHEAD, [1, -2e-10], [3, 2e-10]),
    ),
    "walls of 1 cm and of 1 mm": _both(
        "a short wall has a small denominator, but it is not parallel",
        _ray(_BY, _AHEAD, [3, 0.245], [3, 0.255]),
        _ray(_BY, _AHEAD, [3, 0.2495], [3, 0.2505]),
    ),
    "60 random rays": hint(
        "the simple cases are right; does a part of your rule hold for some directions only?",
        *_random(60),
    ),
    "20 slanting rays that hit a wall along x or y": hint(
        "u says whether the ray hits; where the hit lies is rounded, and may be beside the wall",
        *_onto_axes(20),
    ),
}
MISTAKES = """
the ray passes beyond the wall's ends there: test u, on both sides
    t >= 0 and 0 <= u <= 1 -> t >= 0
the ray passes before the wall's start there: u must not be negative
    0 <= u <= 1 -> u <= 1
the ray passes beyond the wall's end there: u must not be above 1
    0 <= u <= 1 -> u >= 0
it is behind the robot: t must not be negative
    t >= 0 and 0 <= u -> 0 <= u
it is behind the robot: a negative t is a miss, whatever its size
    return t if t >= 0 and -> return abs(t) if
a ray that starts on the wall hits it at 0 m: t = 0 counts
    t >= 0 -> t > 0
a ray that hits exactly an end of the wall hits it: u = 0 and u = 1 count
    0 <= u <= 1 -> 0 < u < 1
u must not be negative: test 0 <= u, not its absolute value
    0 <= u <= 1 -> abs(u) <= 1
both conditions must hold, t >= 0 and 0 <= u <= 1; one alone is not enough
    t >= 0 and -> t >= 0 or
t is a distance in metres; it has no upper limit, and only u ends at 1
    t >= 0 and -> 0 <= t <= 1 and
a ray that misses returns np.inf, not 0
    return np.inf -> return 0
    else np.inf -> else 0
a ray that misses returns np.inf, not -1
    return np.inf -> return -1
    else np.inf -> else -1
a ray that misses returns np.inf, not nan
    return np.inf -> return np.nan
    else np.inf -> else np.nan
that is how far along the wall the ray hits (u), not how far away it is (t)
    return t if -> return u if
that is how far along the wall the ray hits, in metres, not how far away it is
    return t if -> return u * np.linalg.norm(wall) if
a sign is wrong: the offset runs from the ray's origin to the wall's start, a - o
    start - origin -> origin - start
u has the wrong sign: both fractions have a - o above and d x (b - a) below
    _cross(offset, direction) -> _cross(direction, offset)
the wall runs from a to b: subtract a from b
    end - start -> end
the offset runs from the ray's origin to the wall's start: subtract o from a
    start - origin -> start
u is a share of the wall's length; do not divide b - a by its length
    end - start -> (end - start) / np.linalg.norm(end - start)
a parallel wall is missed: return np.inf before you divide by zero
    return np.inf -> return np.nan
a parallel wall is missed: its answer, too, is np.inf
    return np.inf -> return 0
"""


def _form(what: str, answer: Any, *case: Array) -> Array:  # noqa: ANN401 - students'
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


check_ray_segment = exercise(
    ray_segment,
    topics(TOPICS),
    MISTAKES,
    about="A ray against one wall: hits, misses, ends, walls behind and parallel ones.",
    example=_ray(_AT, _AHEAD, [2.0, -1.0], [2.0, 1.0]),
    form=_form,
    same=_same,
    difference=_difference,
)
