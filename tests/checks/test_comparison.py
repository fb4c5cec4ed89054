from functools import partial

import numpy as np
import pytest

from tutorial_lib.checks.framework.answers import calling, numbers
from tutorial_lib.checks.framework.check import WrongAnswer
from tutorial_lib.checks.framework.comparison import compare

CASES = {"small": (1, 2), "equal": (2, 2), "large": (30, 40)}
FAULTS = {"add, do not multiply": lambda a, b: a * b, "add, do not subtract": lambda a, b: a - b}


def add(a, b):
    return a + b


def compared(student, **options):
    return compare("add", student, CASES, add, FAULTS, **options)


def test_right_answers_pass():
    assert compared(add) is None


def test_the_mistake_that_explains_all_answers_is_named_at_the_first_wrong_one():
    with pytest.raises(
        WrongAnswer, match=r"^add, small: add, do not multiply \(2 came back; 3 is right\)$"
    ):
        compared(lambda a, b: a * b)


def test_a_mistake_that_explains_only_some_answers_is_not_named():
    with pytest.raises(WrongAnswer, match=r"^add, large: 1200 came back; 70 is right$"):
        compared(lambda a, b: a * b if a > 2 else a + b)


def test_a_rule_is_said_where_no_mistake_is_named():
    def broken(got, want, a, b):
        return f"{a} and {b} make more" if got < want else ""

    with pytest.raises(WrongAnswer, match=r"^add, small: 1 and 2 make more \(0 came back; 3 is"):
        compared(lambda a, b: 0, broken=broken)
    with pytest.raises(WrongAnswer, match=r"^add, small: 9 came back; 3 is right$"):
        compared(lambda a, b: 9, broken=broken)
    with pytest.raises(WrongAnswer, match=r"^add, small: add, do not multiply \(2 came"):
        compared(lambda a, b: a * b, broken=broken)


SIGNS = {f"of {n}": (n,) for n in (0, 2, -3, -4, -5, -6, -7)}


def test_a_mistake_that_is_nearly_known_is_named_too():
    faults = {"the sign is lost": lambda n: -abs(n), "it is always 0": lambda n: 0}
    with pytest.raises(
        WrongAnswer, match=r"absolute, of 2: perhaps: the sign is lost \(-2 came back"
    ):
        compare("absolute", lambda n: -abs(n) if n > -7 else 1 / 0, SIGNS, abs, faults)
    with pytest.raises(WrongAnswer, match=r"of 2: 0 came back; 2 is right$"):
        compare("absolute", lambda n: 0 if n > -4 else -n + 1, SIGNS, abs, faults)


def test_a_fault_that_raises_explains_nothing():
    faults = {"never": lambda a, b: [][a], "add, do not multiply": lambda a, b: a * b}
    with pytest.raises(WrongAnswer, match="do not multiply"):
        compare("add", lambda a, b: a * b, CASES, add, faults)


def test_known_mistakes_are_made_once_for_all_answers():
    calls = []

    def rule(numbers, fault=""):
        calls.append(fault)
        return len(numbers) if fault == "count" else sum(numbers)

    def said(cases):
        faults = {"add, do not count": partial(rule, fault="count")}
        with pytest.raises(WrongAnswer) as caught:
            compare("total", len, cases, rule, faults)
        return str(caught.value)

    cases = {"two": ([3, 4],), "three": ([1, 1, 5],)}
    assert said(cases) == "total, two: add, do not count (2 came back; 7 is right)"
    assert calls.count("count") == 2
    assert (
        said(cases)
        == said(dict(cases))
        == "total, two: add, do not count (2 came back; 7 is right)"
    )
    assert calls.count("count") == 2
    assert (
        said({"others": ([5, 6],)}) == "total, others: add, do not count (2 came back; 11 is right)"
    )
    assert calls.count("count") == 3


def test_the_form_comes_first_and_holds_for_faults_as_well():
    def form(what, answer, a, b):
        return numbers(what, answer, ()).round()

    assert compared(lambda a, b: a + b + 0.1, form=form) is None
    with pytest.raises(WrongAnswer, match=r"^add, small: add, do not subtract \("):
        compared(lambda a, b: a - b - 0.1, form=form)
    with pytest.raises(WrongAnswer, match=r"^add, large: shape \(1,\), but \(\) is needed"):
        compared(lambda a, b: np.array([70]) if a > 2 else a + b, form=form)


def test_what_is_equal_how_to_say_it_and_what_to_draw_can_be_chosen():
    def draw(want, got):
        return np.array([want, got])

    options = {
        "same": lambda got, want, a, b: abs(got - want) < a,
        "difference": lambda got, want, a, b: f"{a} and {b} make {want}",
        "draw": draw,
    }
    assert compared(lambda a, b: a + b + 0.5, **options).tolist() == [3, 3.5]
    with pytest.raises(WrongAnswer, match=r"^add, small: 1 and 2 make 3$") as raised:
        compared(lambda a, b: a + b + 1, **options)
    assert raised.value.picture.tolist() == [3, 4]


def test_words_may_say_it_all():
    options = {
        "difference": lambda *_: "",
        "broken": lambda got, want, a, b: f"{want}, not {got}",
        "altered": lambda pairs: f"{len(pairs)} answers are new" if pairs[0][0] > 9 else "",
    }
    with pytest.raises(WrongAnswer, match=r"^add, small: add, do not subtract$"):
        compared(lambda a, b: a - b, **options)
    with pytest.raises(WrongAnswer, match=r"^add, small: 3, not 7$"):
        compared(lambda a, b: 7, **options)
    with pytest.raises(WrongAnswer, match=r"^add, small: 3 answers are new$"):
        compared(lambda a, b: 77, **options)


def test_errors_are_explained():
    invoke = calling({IndexError: "stay within the list"}, {"division": "never divide by zero"})
    words = r"^add, small: your code stops with IndexError: .*, in line .*; stay within the list$"
    with pytest.raises(WrongAnswer, match=words):
        compared(lambda a, b: [][a], invoke=invoke)
    with pytest.raises(WrongAnswer, match=r"ZeroDivisionError: .*; never divide by zero$"):
        compared(lambda a, b: a / 0, invoke=invoke)
    with pytest.raises(WrongAnswer, match=r"KeyError: 1, in line .*; there is no such key$"):
        compared(lambda a, b: {}[a], invoke=invoke)
