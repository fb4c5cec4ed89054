import os
import sys
from pathlib import Path

import pytest

from tutorial_lib import course
from tutorial_lib.checks.framework import my_answers
from tutorial_lib.checks.nb00 import environment
from tutorial_lib.cli import main
from tutorial_lib.errors import InputError

PROJECT = Path(__file__).resolve().parents[1]


@pytest.fixture
def installed(tmp_path, monkeypatch):
    """The library lies among other packages; the current folder is an empty one."""
    monkeypatch.setattr(course, "CHECKOUT", tmp_path / "packages")
    monkeypatch.delenv(my_answers.FOLDER, raising=False)
    monkeypatch.setenv("NUMBA_CACHE_DIR", "")  # which the command line sets
    here = tmp_path / "here"
    here.mkdir()
    monkeypatch.chdir(here)
    return here


def with_pages(folder):
    (folder / "notebooks").mkdir()
    (folder / "notebooks" / "00_start_here.ipynb").touch()
    return folder


def test_here_is_the_checkout_wherever_one_is(tmp_path, monkeypatch):
    monkeypatch.chdir(with_pages(tmp_path))
    monkeypatch.delenv(my_answers.FOLDER, raising=False)
    assert course.is_checkout()
    assert course.find_course() == course.course_folder() == PROJECT
    assert my_answers.folder() == PROJECT / "my_answers"


def test_an_installed_course_is_where_one_is_or_above(installed, monkeypatch):
    with_pages(installed)
    for folder in (installed, installed / "notebooks"):
        monkeypatch.chdir(folder)
        assert course.course_folder() == installed
        assert my_answers.folder() == installed / "my_answers"


def test_without_its_pages_an_installed_course_says_how_to_get_them(installed):
    assert course.find_course() is None
    with pytest.raises(InputError, match="topological-navigation copy"):
        course.course_folder()
    assert my_answers.folder() == installed / "my_answers"


def test_a_fault_of_an_installed_course_is_mended_by_pip(installed, monkeypatch, capsys):
    monkeypatch.setattr(environment, "find_faults", lambda: ["numba is missing"])
    assert not environment.check_environment()
    assert "fix: install the course again: python -m pip install" in capsys.readouterr().out


def test_an_installed_course_builds_nothing_and_compiles_elsewhere(installed, monkeypatch, capsys):
    monkeypatch.delenv("NUMBA_CACHE_DIR")
    monkeypatch.setenv("XDG_CACHE_HOME", str(installed))
    assert main(["build"]) == 2
    assert Path(os.environ["NUMBA_CACHE_DIR"]) == course.cache_folder() / "numba"
    assert "only in the course's checkout" in capsys.readouterr().err
    assert main(["progress"]) == 2
    assert "copy it to here: topological-navigation copy" in capsys.readouterr().err


@pytest.mark.skipif(os.name == "nt", reason="a home by another name")
@pytest.mark.parametrize(
    ("system", "given", "folder"),
    [
        ("linux", "/cache", "/cache/topological-navigation"),
        ("linux", "", "/at-home/.cache/topological-navigation"),
        ("darwin", "/cache", "/at-home/Library/Caches/topological-navigation"),
        ("win32", "", "/local/topological-navigation"),
    ],
)
def test_the_cache_is_where_the_system_wants_it(monkeypatch, system, given, folder):
    monkeypatch.setattr(sys, "platform", system)
    monkeypatch.setenv("HOME", "/at-home")
    monkeypatch.setenv("XDG_CACHE_HOME", given)
    monkeypatch.setenv("LOCALAPPDATA", "/local")
    assert course.cache_folder() == Path(folder)
