"""The check of the distance to a waypoint, in notebook 08."""

from functools import partial

import numpy as np

from tutorial_lib.checks.engine import calling, case, close, exercise, farthest, numbers
from tutorial_lib.geometry import Array
from tutorial_lib.topology.mapping.image_pool import length

_SOME = np.random.default_rng(3).uniform([-3, -3, -3.1], [3, 3, 3.1], (6, 3))
CASES = {
    "straight ahead": case(np.array([[2.0, 0.0, 0.0]])),
    "to the side": case(np.array([[3.0, 4.0, 0.0]])),
    "a turn in place": case(np.array([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])),
    "a quarter of a circle of 1 m": case(np.array([[1.0, 1.0, np.pi / 2]])),
    "the same to the right": case(np.array([[1.0, -1.0, -np.pi / 2]])),
    "backwards, with half a turn": case(np.array([[-1.0, 0.5, np.pi / 2], [-2.0, 0.0, 3.0]])),
    "small turns": case(np.array([[3.0, 0.0, 0.04], [2.0, 1.0, -0.02]])),
    "nowhere": case(np.zeros((1, 3))),
    "six at random": case(_SOME),
    "a table of them, (2, 3, 3)": case(_SOME.reshape(2, 3, 3)),
    "one waypoint, (3,)": case(_SOME[0]),
}
MISTAKES = """
the turn stands in the matrix twice, once with either sign: 2 turn^2 under the root
    2 * turn**2 -> turn**2
the velocity leads along an arc, and an arc is longer than its chord: divide by sinc
    chord / np.sinc(half / np.pi) -> chord
half the turn goes into the sinc, not all of it
    turn / 2 -> turn
the norm is the root of the sum of squares; yours has no root
    np.sqrt(arc**2 + 2 * turn**2) -> arc**2 + 2 * turn**2
np.sinc(x) is sin(pi x) / (pi x): give it half the turn divided by pi
    half / np.pi -> half
divide the chord by the sinc: an arc is longer than its chord, not shorter
    chord / np.sinc -> chord * np.sinc
a norm adds squares; yours adds the lengths themselves
    np.sqrt(arc**2 + 2 * turn**2) -> arc + np.sqrt(2) * np.abs(turn)
the turn counts, too: a robot that turns in place has not stayed where it was
    2 * turn**2 -> 0 * turn
both x and y count
    waypoints[..., 1]) -> 0 * waypoints[..., 1])
"""


def _broken(got: Array, want: Array, waypoints: Array) -> str:
    worst = waypoints.reshape(-1, 3)[np.abs(got - want).argmax()]
    if not worst[2]:
        return "without a turn it is the straight distance"
    if not worst[:2].any():
        return "a turn in place counts sqrt(2) times its angle"
    return "the arc is the chord / sinc(turn / 2), and the norm sqrt(arc^2 + 2 turn^2)"


_FORM = "waypoints are an array (..., 3): waypoints[..., 0] is x, and [..., 2] the turn"
check_length = exercise(
    length,
    CASES,
    MISTAKES,
    about="Waypoints straight ahead, along arcs, behind, and turns in place.",
    example=case(_SOME),
    invoke=calling(dict.fromkeys((TypeError, IndexError), _FORM)),
    form=lambda what, got, waypoints: numbers(what, got, waypoints.shape[:-1]),
    same=partial(close, tolerance=1e-6),
    difference=farthest,
    broken=_broken,
)
