"""Where a package of the builder is missing, `build` says how to install it."""

import sys

from tutorial_lib.cli import main
from tutorial_lib.commands.constants import WRONG_INPUT


def test_without_its_packages_build_says_what_to_install(monkeypatch, capsys):
    for name in [name for name in sys.modules if name.startswith("tutorial_lib.builder")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "jupytext", None)
    assert main(["build", "--students"]) == WRONG_INPUT
    words = capsys.readouterr().err
    assert "jupytext" in words
    assert '-m pip install -e ".[test]"' in words
