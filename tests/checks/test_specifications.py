"""Exercises as specifications: every known mistake is one, and is named by its own words."""

import functools
import textwrap

import numpy as np
import pytest

from tests.checks.test_checks import all_checks
from tutorial_lib.checks.engine import edited, exercise, mistakes_of
from tutorial_lib.checks.framework.topics import Topic
from tutorial_lib.errors import InputError

SPECIFIED = [check for check in all_checks() if check.mistakes is not None]
MISTAKES = [
    pytest.param(check, words, mistake, id=f"{check.name}: {words[:50]}")
    for check in SPECIFIED
    for words, mistake in check.mistakes.items()
]


def test_exercises_are_specified():
    assert {check.notebook for check in SPECIFIED} >= {f"{number:02}" for number in range(1, 11)}


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


def test_words_and_edits_may_take_several_lines():
    text = """
    one line,
    and another
        x + 1
            -> x - 1
        return -> y = x; return
    one line
        x + 1 -> x
    """
    found = mistakes_of(rule, textwrap.dedent(text))
    assert list(found) == ["one line, and another", "one line"]
    assert [mistake(5) for mistake in found.values()] == [4, 5]


def specified(cases, **more):
    return exercise(
        rule,
        cases,
        "add\n    x + 1 -> x - 1",
        about="It adds.",
        example=(1,),
        **more,
    )


def test_cases_may_have_words_of_their_own():
    check = specified(
        [Topic("one", "count on", [(1,)]), Topic("more", "go on", [(2,), (3,)])],
        form=lambda what, answer, *_: answer,
        difference=lambda got, want, *_: f"{got}, not {want}",
    )
    assert check(rule).status == "passed"
    assert check(lambda x: x - 1).message == "rule, one: add"
    assert check(lambda x: min(x + 1, 3)).message == "rule, more: go on (3, not 4)"


def test_later_cases_come_when_all_others_are_right():
    check = specified({"one": (1,)}, later={"cases": {"large": (99,)}})
    assert check(rule).status == "passed"
    assert check(lambda x: x - 1).message == "rule, one: add (0 came back; 2 is right)"
    assert check(lambda x: min(x, 9) + 1).message == "rule, large: 10 came back; 100 is right"


def test_groups_of_cases_are_made_and_judged_one_after_the_other():
    made = []

    def groups():
        for name, x in (("one", 1), ("large", 99)):
            made.append(name)
            yield {name: (x,)}

    check = specified(groups)
    assert check(lambda x: x - 1).message == "rule, one: add (0 came back; 2 is right)"
    assert made == ["one"]
    assert check(lambda x: min(x, 9) + 1).message == "rule, large: 10 came back; 100 is right"
    assert check(rule).status == "passed"


def test_what_is_judged_may_be_more_than_the_answer():
    check = specified({"one": (1,)}, run=lambda function, x: (function(x), "run"))
    assert check(rule).status == "passed"
    assert check(lambda x: x - 1).message.startswith("rule, one: add (")


def in_place_of_floats(value, make):
    """An answer with something else in place of each float."""
    if isinstance(value, np.ndarray) and value.dtype.kind == "f":
        return make(value)
    if type(value) is float:
        return make(np.asarray(value)).item()
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        return type(value)(*(in_place_of_floats(part, make) for part in value))
    if isinstance(value, tuple | list):
        return type(value)(in_place_of_floats(part, make) for part in value)
    return value


@pytest.mark.filterwarnings("error::numpy.exceptions.ComplexWarning")
@pytest.mark.parametrize(
    "make",
    [
        lambda x: x + 5j,
        lambda x: x.astype(str),
        lambda x: (x + 5j).astype(np.complex64).astype(object),
        lambda x: x.astype(str).astype(object),
    ],
)
@pytest.mark.parametrize("check", SPECIFIED, ids=lambda check: check.name)
def test_complex_numbers_and_text_are_no_floats(check, make):
    changed = []

    @functools.wraps(check.reference)
    def answer(*arguments, **named):
        right = check.reference(*arguments, **named)
        other = in_place_of_floats(right, make)
        changed.append(other is not right and repr(other) != repr(right))
        return other

    result = check(answer)
    if not any(changed):
        pytest.skip("no floats in its answers")
    assert result.status == "failed"
    assert "Warning" not in result.message
