"""The types that the library's annotations state fit together; pyproject.toml configures it."""

import importlib.util
import re
import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]
IGNORED = 10
"""Lines at most at which the annotations of other packages are wrong."""
WRONG = """
from tutorial_lib.validation import whole

whole(name="k", value=3, least="none")
"""


def checked(*arguments):
    """A run of the checker with the project's settings."""
    if importlib.util.find_spec("pyrefly") is None:
        pytest.skip("pyrefly is not installed; it is in the extra dev")
    if sys.version_info < (3, 11):
        pytest.skip("the last numpy for Python 3.10 has other annotations")
    command = [sys.executable, "-m", "pyrefly", "check", "--python-interpreter-path"]
    return subprocess.run(
        [*command, sys.executable, *map(str, arguments)],
        cwd=PROJECT,
        capture_output=True,
        encoding="utf-8",
    )


@pytest.mark.full
def test_the_library_s_types_fit():
    run = checked()
    assert run.returncode == 0, run.stdout + run.stderr
    assert " 0 errors" in run.stdout + run.stderr


def test_a_wrong_call_is_found(tmp_path):
    module = tmp_path / "module.py"
    module.write_text(WRONG)
    run = checked("--config", PROJECT / "pyproject.toml", module)
    assert run.returncode == 1, run.stdout + run.stderr
    assert "[bad-argument-type]" in run.stdout
    assert "least" in run.stdout


def test_little_is_ignored_and_each_time_one_kind_of_error():
    texts = [file.read_text() for file in (PROJECT / "tutorial_lib").rglob("*.py")]
    found = [
        line
        for text in texts
        for line in text.splitlines()
        if re.search(r"# (type|pyrefly): ignore", line)
    ]
    assert len(found) < IGNORED
    assert [line for line in found if not re.search(r"# pyrefly: ignore\[[\w-]+\]", line)] == []
