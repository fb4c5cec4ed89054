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
