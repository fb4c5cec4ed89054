import json

import pytest

from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.results import FOLDER, load_result


def test_stored_results_are_read_and_missing_or_damaged_ones_named(tmp_path):
    names = [file.stem for file in FOLDER.glob("*.json")]
    assert names
    for name in names:
        assert load_result(name).rows
    with pytest.raises(InputError, match="no 'nothing'"):
        load_result("nothing", tmp_path)
    for text in ("{", json.dumps({"name": "bad"}), json.dumps([1])):
        (tmp_path / "bad.json").write_text(text)
        with pytest.raises(InputError, match="restore the file"):
            load_result("bad", tmp_path)


ROW = {"method": "a", "trials": 40, "success": 0.5}
FINDING = {"what": "a - b", "value": 0.1, "low": 0.0, "high": 0.2, "form": "points"}
GOOD = {
    "name": "table",
    "seed": 0,
    "worlds": [1, 2],
    "quick": False,
    "seconds": 1.5,
    "rows": [ROW, ROW],
    "notes": ["a note"],
    "findings": [FINDING],
    "map": "",
}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({}, ""),
        ({"rows": [ROW, {"method": "b", "trials": 40}]}, r"rows\[1\]: has other columns"),
        ({"rows": [ROW, {**ROW, "more": 1}]}, r"rows\[1\]: has other columns"),
        ({"rows": [{**ROW, "success": float("nan")}]}, r"rows\[0\]\.success: nan is no number"),
        ({"rows": []}, "rows: of another type, or empty"),
        ({"rows": [[1, 2]]}, "rows: of another type"),
        ({"rows": {"a": ROW}}, "rows: of another type"),
        ({"worlds": "12"}, "worlds: of another type"),
        ({"worlds": [1, True]}, "worlds: of another type"),
        ({"notes": "a note"}, "notes: of another type"),
        ({"findings": ["a - b: 0.1"]}, "findings: of another type"),
        ({"findings": [{"what": "a - b"}]}, "value"),
        ({"findings": [FINDING | {"value": "0.1"}]}, "findings: of another type"),
        ({"findings": [FINDING | {"value": float("nan")}]}, "findings: of another type"),
        ({"findings": [FINDING | {"form": "metre"}]}, "findings: of another type"),
        ({"seed": "0", "quick": 1}, "seed, quick: of another type"),
        ({"seconds": float("nan")}, "seconds: of another type"),
        ({"seconds": -1}, "seconds: of another type"),
        ({"map": None}, "map: of another type"),
        ({"more": 1}, "more"),
    ],
)
def test_what_a_result_says_is_checked(tmp_path, change, words):
    (tmp_path / "table.json").write_text(json.dumps(GOOD | change))
    if not words:
        assert load_result("table", tmp_path).rows == [ROW, ROW]
        return
    with pytest.raises(InputError, match=rf"table\.json: not a result .*{words}.*; restore"):
        load_result("table", tmp_path)
