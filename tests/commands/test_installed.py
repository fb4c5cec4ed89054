"""What an environment lacks is found out without importing it."""

import importlib
import subprocess
import sys
from importlib import metadata

import pytest

from tutorial_lib.commands import installed
from tutorial_lib.commands.installed import COMPLETE, lost


@pytest.fixture
def packages(tmp_path, monkeypatch):
    """Three packages: `one` requires `two>=2`, and with its extra also `three`, as `two` does."""
    add(tmp_path, "one", "1.0", ["two>=2", 'three; extra == "more"', 'four; extra == "others"'])
    add(tmp_path, "two", "2.5", ['five; python_version < "3"', "one[more]"])
    add(tmp_path, "three", "0.1", [])
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path


def add(folder, name, version, requires):
    (folder / name / "deep").mkdir(parents=True)
    info = folder / f"{name}-{version}.dist-info"
    info.mkdir()
    files = [f"{name}/__init__.py", f"{name}/part.py", f"{name}/deep/__init__.py"]
    for file in files:
        (folder / file).write_text("raise SystemExit('imported')")
    lines = [f"Name: {name}", f"Version: {version}", *(f"Requires-Dist: {r}" for r in requires)]
    (info / "METADATA").write_text("\n".join([*lines, "", "Requires-Dist: nothing", "", "Words"]))
    record = [*files, "../../bin/one", f"{name}/notes.txt"]
    (info / "RECORD").write_text("\n".join(f"{file},sha256=abc,12" for file in record))


def test_nothing_is_lost_where_all_is_there(packages):
    assert lost("one") == lost("one[more]") == lost("one[none]") == []


def test_an_extra_s_packages_are_looked_for_where_it_is_asked_for(packages, monkeypatch, capsys):
    monkeypatch.setattr(installed, "COURSE", "one")
    for extras in ([], ["more"], ["others"], ["more", "others"]):
        installed.main(extras)
    assert capsys.readouterr().out.split() == [COMPLETE, COMPLETE, "four", "four"]


def test_a_missing_package_is_named_where_it_is_required(packages):
    assert lost("one[others]") == ["four"]
    assert lost("no-such-package>=1") == ["no-such-package"]
    (packages / "three-0.1.dist-info" / "METADATA").unlink()
    (packages / "three-0.1.dist-info" / "RECORD").unlink()
    (packages / "three-0.1.dist-info").rmdir()
    importlib.invalidate_caches()
    assert lost("one") == lost("one[more]") == ["three"]


def test_a_wrong_version_is_named(packages):
    (packages / "two-2.5.dist-info" / "METADATA").write_text("Name: two\nVersion: 1.9\n")
    assert lost("one") == ["two"]
    (packages / "two-2.5.dist-info" / "METADATA").unlink()
    assert lost("one") == ["two"]


@pytest.mark.parametrize("file", ["__init__.py", "part.py"])
def test_a_package_without_its_code_is_named(packages, file):
    (packages / "two" / file).unlink()
    assert lost("one") == ["two"]


def test_without_packaging_nothing_else_can_be_said(monkeypatch):
    monkeypatch.setitem(sys.modules, "packaging.requirements", None)
    assert lost() == ["packaging"]


def test_this_environment_is_complete():
    try:
        metadata.distribution("topological-visual-navigation")
    except metadata.PackageNotFoundError:
        pytest.skip("the course is not installed here")
    command = [sys.executable, "-m", "tutorial_lib.commands.installed"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.stdout.split() == [COMPLETE]


def test_what_an_installation_leaves_in_the_current_folder_hides_nothing(
    packages, tmp_path_factory, monkeypatch
):
    here = tmp_path_factory.mktemp("course")
    (here / "one.egg-info").mkdir()
    (here / "one.egg-info" / "PKG-INFO").write_text("Name: one\nVersion: 1.0\n")
    monkeypatch.chdir(here)
    monkeypatch.syspath_prepend(here)
    importlib.invalidate_caches()
    assert lost("one[more]") == []
    (packages / "three" / "part.py").unlink()
    assert lost("one[more]") == ["three"]
