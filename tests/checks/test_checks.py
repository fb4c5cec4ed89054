import importlib.util
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from tutorial_lib.checks import nb01, nb02, nb03, nb04, nb05, nb06, nb07, nb08, nb09, nb10
from tutorial_lib.checks.framework import guard
from tutorial_lib.checks.framework.answers import numbers
from tutorial_lib.checks.framework.check import Check, Result, WrongAnswer, check
from tutorial_lib.checks.framework.comparison import close, compare, farthest

ANSWERS = Path(__file__).parents[1] / "wrong_answers"
NOTEBOOKS = {
    "01_world_and_car": nb01,
    "02_local_control": nb02,
    "03_reachability": nb03,
    "04_sparsification": nb04,
    "05_map_building": nb05,
    "06_probabilistic_planning": nb06,
    "07_aliasing": nb07,
    "08_lifelong_maps": nb08,
    "09_ghost_nodes": nb09,
    "10_ten_visits": nb10,
}


@cache
def load(name):
    spec = importlib.util.spec_from_file_location(f"answers_{name}", ANSWERS / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def answers():
    for name, checks in NOTEBOOKS.items():
        for key, answer in vars(load(name)).items():
            exercise, _, what = key.partition("__")
            if what and exercise:
                judge = getattr(checks, f"check_{exercise}")
                yield pytest.param(judge, answer, id=key)


def all_checks():
    return [c for m in NOTEBOOKS.values() for c in vars(m).values() if isinstance(c, Check)]


@pytest.fixture(autouse=True)
def _impatient(monkeypatch):
    monkeypatch.setattr(guard, "SECONDS", 3.0)  # some wrong answers never end


@cache
def judged(judge, answer):
    return judge(answer)


@pytest.mark.parametrize(("judge", "answer"), list(answers()))
@pytest.mark.filterwarnings("ignore:Converting a tensor")
def test_wrong_answers_fail_with_their_message_and_right_ones_pass(judge, answer):
    result = judged(judge, answer)
    if "__right" in answer.__name__:
        assert result.status == "passed", result.message
    else:
        assert result.status == "failed"
        assert answer.__doc__ in result.message


@pytest.mark.parametrize("judge", all_checks(), ids=lambda c: c.name)
def test_references_pass_and_stubs_are_not_attempted(judge):
    def stub(*_):
        raise NotImplementedError("your turn")

    assert judge(judge.reference).status == "passed"
    assert judge(stub).status == "not attempted"
    assert judge(lambda *_: None).status == "failed"
    assert "TypeError" in judge(lambda: 0).message
    assert judge.__doc__


@pytest.mark.parametrize("judge", all_checks(), ids=lambda c: c.name)
def test_every_wrong_answer_gets_a_message_of_its_own(judge):
    wrong = [
        judged(judge, answer).message
        for name in NOTEBOOKS
        for key, answer in vars(load(name)).items()
        if key.startswith(f"{judge.name}__") and "__right" not in key
    ]
    assert len(wrong) >= 3
    assert len(set(wrong)) == len(wrong)


def test_an_answer_is_as_fast_however_often_it_was_measured():
    judge = nb05.check_insert  # whose answers change the map that they are given

    def insert(*arguments):
        return judge.reference(*arguments)

    before = len(judge.example[0].vertices)
    assert judge.use(insert) is insert
    assert len(judge.example[0].vertices) == before


def test_a_slow_answer_is_praised_but_not_used(monkeypatch, capsys):
    @check(lambda x: x, (1.0,), calls=10_000)
    def check_identity(student):
        """It gives back what it got."""
        compare("identity", student, {"a number": (2.0,)}, lambda x: x, {})

    def slow(x):
        sum(range(20_000))
        return x

    def quick(x):
        return x + 0.0

    @check(lambda x: x, (1.0,), calls=10)
    def check_now_and_then(student):
        """It is called ten times."""
        compare("identity", student, {"a number": (2.0,)}, lambda x: x, {})

    assert check_identity.use(slow) is check_identity.reference
    assert "times slower" in capsys.readouterr().out
    assert check_identity.use(quick) is quick
    assert check_now_and_then.use(slow) is slow
    assert check_identity.use(lambda x: x + 1) is check_identity.reference


@pytest.mark.parametrize(
    ("got", "words"),
    [
        (None, "return missing"),
        ("four", "a str came back"),
        (np.array([1.0, 2.0, 3.0]), r"shape \(3,\), but \(2,\) is needed"),
        (np.array([np.nan, 2.0]), "not a number"),
        (np.array([1.0, 2.5]), r"2.5 at \(1,\), but 2 is right"),
        (np.array([2.0, 1.0]), "they are swapped"),
        ([1.0, 2.0], "a list came back"),
    ],
)
def test_messages_go_from_shape_to_value(got, words):
    with pytest.raises(WrongAnswer, match=words):
        compare(
            "answer",
            lambda: got,
            {"two": ()},
            lambda: np.array([1.0, 2.0]),
            {"they are swapped": lambda: np.array([2.0, 1.0])},
            form=lambda what, answer: numbers(what, answer, (2,)),
            same=close,
            difference=farthest,
        )


def test_a_check_that_runs_again_repeats_its_verdict(capsys):
    judge = nb01.check_to_local
    given = judge.use(lambda pose, points: points)
    assert given is judge.reference
    capsys.readouterr()
    assert judge.use(given) is given
    said = capsys.readouterr().out
    assert "to_local: failed" in said
    assert "Run the cell with your to_local again" in said


def test_the_library_s_function_is_no_answer(capsys):
    judge = nb01.check_compose
    assert judge.use(judge.reference) is judge.reference
    assert "compose: not attempted" in capsys.readouterr().out


def test_results_escape_what_students_write():
    result = nb01.check_to_local(lambda *_: 1 / 0)
    assert "ZeroDivisionError" in str(result)

    def fail(*_):
        raise ValueError("<script>")

    assert "<script>" not in nb01.check_to_local(fail)._repr_html_()
    judge = nb01.check_wall_share
    assert "data:image/png" in judge(judge.reference)._repr_html_()


def luminance(colour):
    """Of #rrggbb, by WCAG 2."""
    parts = np.array([int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)])
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return linear @ [0.2126, 0.7152, 0.0722]


@pytest.mark.parametrize("status", ["passed", "failed", "not attempted"])
@pytest.mark.parametrize("page", ["#ffffff", "#111111"])
def test_a_verdict_can_be_read_on_light_and_on_dark_pages(status, page):
    shown = Result("double", status, "Words.")._repr_html_()
    (style,) = re.findall(rf'<b style="([^"]+)">{status}</b>', shown)
    colours = dict(part.split(":") for part in style.split(";") if part)
    dark, light = sorted(luminance(colours.get(key, page)) for key in ("color", "background"))
    assert (light + 0.05) / (dark + 0.05) >= 4.5


def test_large_answers_must_be_as_right_as_small_ones():
    assert close(np.array([1000.0000005]), [1000.0])
    assert not close(np.array([1000.0005]), [1000.0])


def test_a_probability_that_is_a_little_off_is_wrong():
    right = nb06.check_most_probable_path.reference

    def nearly(*case):
        path, probability = right(*case)
        return path, 0.998 * probability

    assert nb06.check_most_probable_path(right).status == "passed"
    assert nb06.check_most_probable_path(nearly).status == "failed"
