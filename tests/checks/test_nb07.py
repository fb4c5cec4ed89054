"""Checks of notebook 07: mistakes that come in several forms, and ties."""

import numpy as np
import pytest

from tutorial_lib.checks.engine import edited
from tutorial_lib.checks.nb07 import check_predict, check_track, check_update
from tutorial_lib.checks.nb07.track_stories import STORIES, Drive


def nowhere_where(impossible):
    def update(prior, likelihood):
        weights = prior * likelihood
        nowhere = impossible(weights.sum(axis=1))
        weights[nowhere] = np.eye(weights.shape[1])[-1]
        return weights / weights.sum(axis=1, keepdims=True)

    return update


@pytest.mark.parametrize(
    "impossible",
    [
        lambda total: np.isclose(total, 0),
        lambda total: total < 1e-12,
        lambda total: total < np.finfo(float).eps,
    ],
)
def test_any_threshold_on_the_products_is_named(impossible):
    result = check_update(nowhere_where(impossible))
    assert result.status == "failed"
    assert "a sum may be tiny and not 0" in result.message


def test_an_answer_that_changes_its_arguments_does_not_spoil_the_next():
    def predict(belief, motion, lengths, onward):
        belief *= 2
        motion *= 2
        return belief

    for _ in range(2):
        result = check_predict(predict)
        assert "your function changes its argument belief" in result.message
    assert check_predict(lambda belief, *_: belief * 1.01).message.endswith(
        "sums to 1.01, not to 1)"
    )


def test_exact_zeros_pass():
    assert check_update(nowhere_where(lambda total: total <= 0)).status == "passed"


@pytest.mark.parametrize("vertices", [[True], [None], [0.0], [np.float32(1)], ["1"]])
def test_vertices_that_are_no_whole_numbers_are_shown(vertices):
    def track(odometry, look, *model):
        beliefs, _ = check_track.reference(odometry, look, *model)
        return beliefs, vertices * len(odometry)

    result = check_track(track)
    assert result.status == "failed"
    assert f"the vertex is {vertices[0]!r}" in result.message


@pytest.mark.parametrize(
    ("beliefs", "words"),
    [
        (np.array([["a"]]), "the beliefs are no array of numbers"),
        (np.zeros((20, 1, 7)), r"append belief[0], a row"),
        (np.zeros((1, 7)), "one row a step"),
        (np.zeros((20, 7)), "is 0.896, yours 0"),
    ],
)
def test_beliefs_of_another_form_are_refused(beliefs, words):
    def track(*arguments):
        return beliefs, check_track.reference(*arguments)[1]

    result = check_track(track)
    assert result.status == "failed"
    assert words in result.message


def test_what_look_gave_may_be_kept_but_not_changed():
    drive = Drive(next(iter(STORIES.values())))
    seen = drive.look(0)
    drive.demand_untouched()
    seen[0] = 2.0
    with pytest.raises(Exception, match="changes the array that look gave it"):
        drive.demand_untouched()


def test_no_story_has_two_greatest_beliefs_between_which_a_robot_must_choose():
    last = "int(np.flatnonzero(belief[0] == belief[0].max())[-1])"
    track = edited(check_track.reference, [("int(belief[0].argmax())", last)])
    assert check_track(track).status == "passed"
