import pytest

from tutorial_lib.errors import InputError
from tutorial_lib.viz.notebook.tables import table


def test_a_table_is_html_with_the_best_in_bold_and_text_elsewhere():
    shown = table(
        {"planner": "", "success": ".0%", "steps": "d"},
        [["a <b>", 0.5, 12], ["c", 0.9, None]],
        {"success": max, "steps": min},
        "planners",
    )
    page = shown._repr_html_()
    assert "a &lt;b&gt;" in page
    assert "<b>90%</b>" in page
    assert "<b>12</b>" in page
    assert "<b>50%</b>" not in page
    assert "<caption>planners</caption>" in page
    lines = repr(shown).splitlines()
    assert lines[0] == "planners"
    assert lines[2].split() == ["a", "<b>", "50%", "12"]


def test_a_row_must_have_a_value_for_each_column():
    with pytest.raises(InputError, match="2 values in a row; give 1"):
        table({"one": ""}, [["a", "b"]])


def test_a_column_without_numbers_has_no_best():
    assert table({"n": "d"}, [[None]], {"n": max}).bold == frozenset()
