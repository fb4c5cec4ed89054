import doctest
import importlib
import pkgutil
import re
import subprocess
import sys
from pathlib import Path

import pytest

import tutorial_lib

PROJECT = Path(__file__).resolve().parents[2]
TOP = {
    "LICENSE", "README.md", "environment.md", "notebooks", "pyproject.toml", "solutions",
    "start.py", "tests", "tutorial_lib",
}  # fmt: skip
LONGEST = 400
MACHINE_PATH = re.compile(r"(?<![\w.])/(?:home|root|Users|work|mnt)/[\w.-]+")
MODULES = [
    module.name
    for module in pkgutil.walk_packages(tutorial_lib.__path__, "tutorial_lib.")
    if not module.name.endswith("__main__")  # which runs the command line
]


def git(*arguments):
    """Lines of git's answer about the project; skips the test where there is no checkout."""
    if not (PROJECT / ".git").exists():
        pytest.skip("not a git checkout")
    run = subprocess.run(["git", *arguments], cwd=PROJECT, capture_output=True, text=True)
    if run.returncode:
        pytest.skip(f"git does not answer: {run.stderr.strip()}")
    return run.stdout.splitlines()


@pytest.mark.parametrize("command", [["check"], ["format", "--check"]], ids=" ".join)
def test_ruff_is_content(command):
    run = subprocess.run(
        [sys.executable, "-m", "ruff", *command, "--no-cache", "."],
        cwd=PROJECT,
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stdout + run.stderr


@pytest.mark.parametrize("name", MODULES)
def test_doctests(name):
    assert doctest.testmod(importlib.import_module(name)).failed == 0


def test_there_are_doctests():
    names = ("tutorial_lib.geometry",)
    assert all(doctest.testmod(importlib.import_module(name)).attempted > 5 for name in names)


def test_modules_stay_short():
    lengths = {
        str(file.relative_to(PROJECT)): len(file.read_text(encoding="utf-8").splitlines())
        for file in (PROJECT / "tutorial_lib").rglob("*.py")
    }
    assert len(lengths) > 20
    assert {name: n for name, n in lengths.items() if n > LONGEST} == {}


def test_the_top_level_holds_what_the_design_allows_and_nothing_else():
    tracked = {Path(name).parts[0] for name in git("ls-files", "-z")[0].split("\0") if name}
    assert {name for name in tracked if not name.startswith(".")} <= TOP
    assert {"README.md", "pyproject.toml", "start.py", "tutorial_lib"} <= tracked


def test_nothing_names_a_path_of_one_machine():
    names = git("ls-files", "-z", "--cached", "--others", "--exclude-standard")[0].split("\0")
    found = []
    for name in filter(None, names):
        file = PROJECT / name
        if file.suffix in (".py", ".md", ".toml", ".ipynb", ".json") and file.is_file():
            lines = file.read_text(encoding="utf-8").splitlines()
            found += [f"{name}: {line.strip()}" for line in lines if MACHINE_PATH.search(line)]
    assert found == []


def test_the_pattern_of_machine_paths_finds_them():
    folder = "/home"
    assert MACHINE_PATH.search(f'open("{folder}/anna/plan.json")')
    assert not MACHINE_PATH.search("https://example.org/home/anna")
