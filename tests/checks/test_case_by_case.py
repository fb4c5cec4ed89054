import pytest

from tutorial_lib.checks.framework.case_by_case import case_by_case
from tutorial_lib.checks.framework.check import WrongAnswer

CASES = {f"of {n}": (n,) for n in (0, 2, -3, -4, -5, -6, -7)}
FAULTS = {"the sign is lost": lambda n: -abs(n), "it is always 0": lambda n: 0}


def judged(student):
    return case_by_case("absolute", student, CASES, abs, FAULTS)


def test_the_right_answer_passes():
    assert judged(lambda n: n if n > 0 else -n) is None


def test_a_known_mistake_is_named_with_what_is_wrong():
    with pytest.raises(WrongAnswer, match=r"absolute, of 2: the sign is lost \(-2 came back"):
        judged(lambda n: -abs(n))


def test_a_mistake_that_is_nearly_known_is_named_too():
    with pytest.raises(WrongAnswer, match="the sign is lost"):
        judged(lambda n: -abs(n) if n > -7 else 1 / 0)


def test_a_mistake_that_explains_little_is_not_named():
    with pytest.raises(WrongAnswer) as error:
        judged(lambda n: 0 if n > -4 else -n + 1)
    assert "always 0" not in str(error.value)
    assert "of 2: 0 came back; 2 is right" in str(error.value)
