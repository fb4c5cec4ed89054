import pytest

from tutorial_lib.checks.framework import my_answers


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Where answers and predictions are kept; not there yet."""
    monkeypatch.setenv(my_answers.FOLDER, str(tmp_path / "mine"))
    return tmp_path / "mine"
