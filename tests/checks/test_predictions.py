import json

import numpy as np
import pytest

from tests.viz.pictures import decoded
from tutorial_lib.checks.framework import my_answers, record
from tutorial_lib.checks.predictions import Prediction
from tutorial_lib.errors import InputError
from tutorial_lib.viz.notebook.display import STATIC

WIDGET = "application/vnd.jupyter.widget-view+json"
BEFORE, AFTER = (np.full((60, 400, 3), shade, np.uint8) for shade in (200, 40))
GIVEN = {
    "notebook": "05",
    "name": "trip",
    "ask": "Where should it change?",
    "options": {"A": "at the door", "B": "in the corridor", "C": "nowhere"},
    "right": "B",
    "robot": "it changes in the corridor.",
    "tempting": "A",
    "because": "the door is nearest on the plan, but behind the robot.",
    "before": BEFORE,
    "after": AFTER,
}


pytestmark = pytest.mark.usefixtures("folder")


def test_a_click_shows_the_choice_the_robot_and_why_a_wrong_answer_tempts(folder):
    trip = Prediction(**GIVEN)
    assert not folder.exists()
    assert "robot:" not in trip.panel.line.value
    assert "C: nowhere" in trip.panel.line.value
    assert "right=" not in repr(trip)
    assert GIVEN["because"] not in repr(trip)
    trip.panel.buttons["A"].click()
    assert trip.text.split("\n") == [
        "You: A, at the door.",
        "Rover: it changes in the corridor.",
        "The right answer is B: in the corridor.",
        "A tempts: the door is nearest on the plan, but behind the robot.",
    ]
    assert (decoded(trip.panel.picture.value) == 40).all()
    kept = json.loads((folder / record.FILE).read_text())["05"]["predictions"]["trip"]
    assert (kept["choice"], kept["right"]) == ("A", "B")


def test_without_widgets_a_call_does_the_same_and_the_first_choice_is_kept():
    trip = Prediction(**GIVEN)
    before = trip.panel.picture.value
    assert trip.commit("B") is trip
    assert trip.text.startswith("You: B, in the corridor. Right!\n")
    assert "The right answer is" not in trip.text
    assert trip.panel.picture.value != before
    trip.commit("C")
    assert "You: C" in trip.panel.line.value
    assert record.predictions("05")["trip"]["choice"] == "B"
    assert Prediction(**GIVEN).choice == "B"
    with pytest.raises(InputError, match="choice: 'D'; give A, B or C"):
        trip.commit("D")


def test_a_cell_shows_buttons_and_where_there_are_none_a_picture_with_the_question():
    trip = Prediction(**GIVEN)
    shown = trip._repr_mimebundle_()
    assert WIDGET in shown
    assert shown["text/plain"].startswith("Where should it change?\nA: at the door")
    assert 'run trip.commit("A")' in shown["text/plain"]
    assert "robot:" not in shown["text/plain"]
    assert "image/png" in shown


def test_a_stored_page_shows_the_answer_under_the_question(monkeypatch):
    trip = Prediction(**GIVEN)
    asked = trip._still().shape[0]
    monkeypatch.setenv(STATIC, "1")
    told = trip._still()
    assert told.shape[0] > asked
    assert (told[30, told.shape[1] // 2] == 40).all()
    assert trip.choice == ""


def test_where_nothing_is_kept_a_choice_is_shown_all_the_same(monkeypatch):
    monkeypatch.setenv(my_answers.FOLDER, "")
    assert Prediction(**GIVEN).commit("C").text.startswith("You: C")
    assert Prediction(**GIVEN).choice == ""


def test_a_choice_that_is_no_option_any_more_is_forgotten():
    record.keep_prediction("05", "trip", "D", "D")
    assert Prediction(**GIVEN).choice == ""


@pytest.mark.parametrize("text", ["{", "[]", '{"05": 3}', '{"05": {"predictions": []}}'])
def test_a_damaged_record_is_named(folder, text):
    folder.mkdir()
    (folder / record.FILE).write_text(text)
    with pytest.raises(InputError, match=r"record\.json.*delete it"):
        Prediction(**GIVEN)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"options": {"A": "yes"}}, "options: 1; give two to four"),
        ({"right": "D"}, "right: 'D'"),
        ({"tempting": "D"}, "tempting: 'D'"),
        ({"tempting": "B"}, "'B' is right; give a wrong option"),
        ({"before": np.zeros((3, 3))}, "before"),
        ({"options": {"A": 1, "B": 2}}, "options"),
    ],
)
def test_a_question_that_cannot_be_asked_is_refused(changes, words):
    with pytest.raises(InputError, match=words):
        Prediction(**{**GIVEN, **changes})
