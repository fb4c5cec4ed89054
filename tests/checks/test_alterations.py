"""Right answers of which something was taken away, and words that show what."""

import numpy as np
import pytest

from tutorial_lib.checks.framework.alterations import altered
from tutorial_lib.checks.framework.comparison import farthest
from tutorial_lib.checks.framework.wording import both
from tutorial_lib.checks.nb01 import check_bicycle_step, check_compose
from tutorial_lib.checks.nb02 import check_obstacle_policy
from tutorial_lib.checks.nb05 import check_edge_weights

WANT = np.array([0.123456789, 0.7, 20.0 / 3.0])


@pytest.mark.parametrize("digits", range(1, 9))
def test_rounded_answers_are_told_so_with_their_digits(digits):
    got = np.round(WANT, digits)
    assert altered([(got, WANT)]).startswith(f"your answers are rounded to {digits} digit")


@pytest.mark.parametrize(
    ("got", "words"),
    [
        (WANT.astype(np.float32).astype(float), "float32 keeps seven digits"),
        (WANT + 1e-5, "nearly right"),
        (WANT * (1 - 1e-6), "nearly right"),
        (WANT + 1e-3, ""),
        (WANT[::-1], ""),
        (WANT * np.nan, ""),
    ],
)
def test_small_differences_are_named_and_others_are_not(got, words):
    assert altered([(got, WANT)]).startswith(words)
    assert bool(altered([(got, WANT)])) == bool(words)


@pytest.mark.parametrize(
    ("mine", "right"), [(0.25, 0.75), (0.4814, 0.48140000001), (1 / 3, 1 / 3 + 1e-15), (-1.0, 1.0)]
)
def test_two_numbers_that_differ_look_different(mine, right):
    one, other = both(mine, right)
    assert one != other
    assert float(one) == pytest.approx(mine, rel=1e-3)
    assert float(other) == pytest.approx(right, rel=1e-3)


@pytest.mark.parametrize("number", [1 / 3, 0.1, np.inf, np.nan])
def test_two_numbers_that_are_equal_need_no_more_digits(number):
    assert both(number, number) == (f"{number:.4g}",) * 2


def test_where_answers_differ_most_shows_that_they_do():
    assert farthest(WANT + np.eye(3)[1] / 10, WANT) == "0.8 at (1,), but 0.7 is right"
    assert farthest(WANT + np.eye(3)[1] * 1e-7, WANT) == "0.7000001 at (1,), but 0.7 is right"
    assert "divided by zero" in farthest(WANT * np.nan, WANT)


def test_an_array_that_every_call_fills_anew_is_no_answer():
    kept = np.zeros(3)

    def compose(first, second):
        kept[:] = check_compose.reference(first, second)
        return kept

    found = check_compose(compose)
    assert found.status == "failed"
    assert "each call changes what the one before it returned" in found.message


def test_pi_with_few_digits_is_named():
    def compose(first, second):
        pose = check_compose.reference(first, second).copy()
        heading = first[2] + second[2]
        pose[2] = heading - 2 * 3.1416 * np.round(heading / (2 * np.pi))
        return pose

    assert "pi written with few digits" in check_compose(compose).message


@pytest.mark.parametrize("wrapped", [lambda h: h - np.pi * (h > np.pi), lambda h: min(h, np.pi)])
def test_a_heading_beyond_pi_may_be_wrapped_by_whole_turns_only(wrapped):
    def step(*arguments):
        x, y, heading = check_bicycle_step.reference(*arguments)
        return np.array([x, y, wrapped(heading)])

    assert check_bicycle_step(step).status == "failed"


def test_single_precision_is_enough_for_large_accelerations():
    def policy(distances, closing, *gains):
        away, metric = check_obstacle_policy.reference(distances, closing, *gains)
        return away.astype(np.float32), metric.astype(np.float32)

    assert check_obstacle_policy(policy).status == "passed"


@pytest.mark.parametrize("little", [1e-8, 1e-6])
def test_what_is_added_to_re_is_not_called_a_missing_inf(little):
    def weights(reach, driven, p_edge):
        kept = ((reach > p_edge) | driven) & ~np.eye(len(reach), dtype=bool)
        return np.where(kept, -np.log(reach + little), np.inf)

    message = check_edge_weights(weights).message
    assert "of RE as it is and with all digits" in message
    assert "everywhere" not in message
