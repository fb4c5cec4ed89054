import numpy as np
import pytest

from tutorial_lib.checks.framework.answers import numbers
from tutorial_lib.checks.framework.check import WrongAnswer
from tutorial_lib.checks.framework.topics import Topic, judge_topics

TOPICS = [
    Topic("one half", "half is a share", [(0.5, 1.0)]),
    Topic("larger numbers", "multiply the two", [(2.0, 3.0), (2.0, 5.0), (2.0, 7.0)]),
]
FAULTS = {"add nothing": lambda a, b: a + b, "no square": lambda a, b: a * b * b}


def product(a, b):
    return a * b


def judge(student):
    judge_topics(
        "product",
        student,
        TOPICS,
        product,
        FAULTS,
        form=lambda what, answer, *case: numbers(what, answer, ()),
        draw=lambda student: np.zeros((1, 1, 3), np.uint8),
    )


def message(student):
    with pytest.raises(WrongAnswer) as found:
        judge(student)
    assert found.value.picture is None or found.value.picture.shape == (1, 1, 3)
    return str(found.value)


def test_right_answers_pass():
    judge(lambda a, b: b * a + 1e-12)


def test_the_first_lesson_that_goes_wrong_speaks():
    said = message(lambda a, b: a * b + (a > 1))
    assert said == "product, larger numbers: multiply the two (7, but 6 is right)"


def test_a_known_mistake_is_named_only_if_it_gives_every_answer():
    assert message(lambda a, b: a + b) == "product, one half: add nothing"
    assert "add nothing" not in message(lambda a, b: a + b if a < 1 else a * b * 2)


def test_an_argument_that_is_not_used_is_named():
    assert "another b never changes your answer; it should" in message(lambda a, b: 3 * a)


def test_errors_of_the_student_s_code_come_with_the_case_and_the_line():
    def fails(a, b):
        return [a][int(b)]

    said = message(fails)
    assert "one half: your code stops with IndexError" in said
    assert "return [a][int(b)]" in said
    assert "half is a share" in said


def test_an_exercise_that_was_not_attempted_stays_so():
    def stub(a, b):
        raise NotImplementedError

    with pytest.raises(NotImplementedError):
        judge(stub)


def test_an_answer_of_an_odd_form_gets_a_sentence():
    def fail(*_):
        raise TypeError("unhashable")

    with pytest.raises(WrongAnswer, match="product, one half: a set came back whose form"):
        judge_topics("product", lambda a, b: {a}, TOPICS, product, FAULTS, form=fail)
