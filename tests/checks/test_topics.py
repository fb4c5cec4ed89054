from functools import partial

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


def _row(count, what, answer, *case):
    return numbers(what, answer, (count,))


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

    with pytest.raises(WrongAnswer, match="product, one half: a set came back, which"):
        judge_topics("product", lambda a, b: {a}, TOPICS, product, FAULTS, form=fail)


def test_small_changes_of_right_answers_are_named():
    assert "their digits are cut off; return all digits" in message(lambda a, b: int(a * b))

    def first(student):
        topic = Topic("rows", "add them", [(np.array([0.26, 1.75, 3.5, 7.0, 9.0]),)])
        form = partial(_row, 5)
        with pytest.raises(WrongAnswer) as found:
            judge_topics("twice", student, [topic], lambda a: 2 * a, {}, form=form)
        return str(found.value)

    assert "cut off at 10; nothing limits" in first(lambda a: np.minimum(2 * a, 10))
    assert "as small as 0.52 come back as 0" in first(lambda a: np.where(a < 1, 0, 2 * a))
    assert "rounded to 1 digit;" in first(lambda a: np.round(2 * a, 1))
    assert "add them (" in first(lambda a: 3 * a)


def test_a_function_that_remembers_and_one_that_gives_back_its_argument_are_told_so():
    seen = []

    def remembers(a, b):
        seen.append(a)
        return a * b + len(seen)

    assert "called again with the same arguments" in message(remembers)
    form = partial(_row, 2)
    topic = Topic("an array", "leave it", [(np.ones(2),)])
    with pytest.raises(WrongAnswer, match="is your argument x itself"):
        judge_topics("same", lambda x: x, [topic], lambda x: x.copy(), {}, form=form)


def test_a_mistake_in_part_of_the_cases_is_added():
    cases = [(1.0, 2.0), (2.0, 5.0), (3.0, 7.0)]
    with pytest.raises(WrongAnswer, match=r"multiply \(.*\). In some cases: add nothing"):
        judge_topics(
            "product",
            lambda a, b: a + b if a > 1 else a * b,
            [Topic("numbers", "multiply", cases)],
            product,
            {"add nothing": lambda a, b: a + b},
            form=lambda what, answer, *case: numbers(what, answer, ()),
        )
