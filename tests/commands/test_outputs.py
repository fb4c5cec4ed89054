"""What is left of outputs without their widgets."""

import pytest

from tutorial_lib.commands.outputs import WIDGET, without_bars, without_widgets

VIEW = {WIDGET: {"model_id": "1"}}
STILL = {"output_type": "execute_result", "data": {**VIEW, "image/png": "AA", "text/plain": "two"}}
TEXT = {"output_type": "stream", "name": "stdout", "text": "[00:00<?, ?it/s]"}
BARS = (
    "  0%|    | 0/3 [00:00<?, ?it/s]",
    "steps: 0it [00:00, ?it/s]",
    ["a list of ", "[00:00<?, ?it/s]"],
)


def bar(text):
    return {"output_type": "display_data", "data": {**VIEW, "text/plain": text}}


def test_the_picture_and_the_text_of_a_widget_stay():
    still, text = without_widgets([dict(STILL, data=dict(STILL["data"])), TEXT])
    assert still["data"] == {"image/png": "AA", "text/plain": "two"}
    assert text == TEXT


@pytest.mark.parametrize("text", BARS)
def test_progress_bars_go_and_what_only_prints_like_one_stays(text):
    assert without_bars([bar(text), STILL, TEXT]) == [STILL, TEXT]
    assert without_widgets([bar(text), TEXT]) == [TEXT]
    printed = {"output_type": "display_data", "data": {"text/plain": text}}
    assert without_widgets([printed]) == [printed]


def test_a_widget_that_left_no_picture_leaves_its_text():
    (own,) = without_widgets([bar("IntSlider(value=3)")])
    assert own["data"] == {"text/plain": "IntSlider(value=3)"}
