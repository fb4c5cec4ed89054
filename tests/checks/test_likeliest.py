import pytest

from tutorial_lib.checks.framework.check import WrongAnswer
from tutorial_lib.checks.framework.likeliest import compare_likeliest

CASES = {"one": (1,), "minus two": (-2,), "three": (3,), "nothing": (0,)}
FAULTS = {
    "negative numbers are doubled, too": lambda x: 2 * x if x > 0 else x,
    "twice, not three times": lambda x: 3 * x,
    "divides by zero": lambda x: [][x],
}


def judged(student):
    return compare_likeliest("double", student, CASES, lambda x: 2 * x, FAULTS)


def test_right_answers_pass():
    assert judged(lambda x: x + x) is None


def test_the_mistake_that_explains_most_is_named_at_the_case_that_shows_it():
    with pytest.raises(WrongAnswer, match="double, minus two: negative numbers"):
        judged(lambda x: max(x, 0) + x)
    with pytest.raises(WrongAnswer, match="double, minus two: twice, not three times"):
        judged(lambda x: 3 * x if x != 1 else 7)


def test_an_unknown_mistake_shows_both_answers_at_the_first_case():
    with pytest.raises(WrongAnswer, match="double, one: 8 came back; 2 is right"):
        judged(lambda x: 2 * x + 7 * (x == 1) - (x == 1))
