"""Exercises as specifications: every known mistake is one, and is named by its own words."""

import pytest

from tests.checks.test_checks import all_checks
from tutorial_lib.checks.engine import edited, mistakes_of
from tutorial_lib.errors import InputError

SPECIFIED = [check for check in all_checks() if check.mistakes is not None]
MISTAKES = [
    pytest.param(check, words, mistake, id=f"{check.name}: {words[:50]}")
    for check in SPECIFIED
    for words, mistake in check.mistakes.items()
]


def test_exercises_are_specified():
    assert {check.notebook for check in SPECIFIED} >= {"01", "02", "03", "07", "08", "09"}


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize(("check", "words", "mistake"), MISTAKES)
def test_a_mistake_is_one_and_is_named_by_its_own_words(check, words, mistake):
    result = check(mistake)
    assert result.status == "failed"
    assert words in result.message


def rule(x):
    return x + 1


def test_an_edit_that_does_not_apply_is_refused():
    assert edited(rule, [("x + 1", "x - 1")])(5) == 4
    with pytest.raises(InputError, match=r"rule: 'x' stands there 2 times"):
        edited(rule, [("x", "y")])
    with pytest.raises(InputError, match=r"rule: 'z' stands there 0 times"):
        mistakes_of(rule, "no z\n    z -> y\n")
    with pytest.raises(InputError, match="below words"):
        mistakes_of(rule, "    x + 1 -> y\n")
