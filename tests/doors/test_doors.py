"""No public function takes what it cannot work with, and each says which argument is wrong."""

import ast
import importlib
import pkgutil
import re
from pathlib import Path

import numpy as np
import pytest

import tutorial_lib
from tests.doors.arguments import floats, whole
from tests.doors.walk import TABLES, call, doors, parts, walk
from tutorial_lib.errors import InputError

ROOT = Path(__file__).resolve().parents[2]
GROUND = (
    "geometry", "observation", "interfaces", "files", "memory", "parallel", "validation",
    "environments",
)  # fmt: skip
"""Modules without a package; `tests/doors/ground.py` has their doors."""
WHOLE = (*GROUND, "driving.metrics", "learning.calibration")
"""Modules in which all names are public, whatever their packages export."""
PACKAGES = sorted(
    package.name for package in pkgutil.iter_modules(tutorial_lib.__path__) if package.ispkg
)


def imported():
    """What README and the sources of the notebooks import from the library: (module, name)."""
    sources = [file.read_text() for file in sorted((ROOT / "solutions").glob("*.py"))]
    sources += re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    for source in sources:
        for node in ast.walk(ast.parse(source)):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("tutorial_lib"):
                yield from ((node.module, alias.name) for alias in node.names)


def exports():
    """Every public name of the library, as (package or ground module, name, what it is)."""
    names = set(imported())
    for module in WHOLE:
        found = importlib.import_module(f"tutorial_lib.{module}")
        names |= {
            (found.__name__, name)
            for name, value in vars(found).items()
            if not name.startswith("_") and getattr(value, "__module__", "") == found.__name__
        }
    for package in pkgutil.walk_packages(tutorial_lib.__path__, "tutorial_lib."):
        if package.ispkg:
            found = importlib.import_module(package.name)
            names |= {(package.name, name) for name in getattr(found, "__all__", ())}
    for module, name in sorted(names):
        value = getattr(importlib.import_module(module), name, None)
        home = getattr(value, "__module__", module) or module
        if home.startswith("tutorial_lib."):
            part = home.split(".")[1]
            yield "ground" if part in GROUND else part, name, value


@pytest.mark.parametrize("table", ["ground", *PACKAGES])
def test_every_door_has_a_call_that_works_or_a_reason_for_none(table):
    wanted = {
        door
        for package, name, value in exports()
        if package == table
        for door in parts(name, value)
    }
    module = importlib.import_module(f"tests.doors.{table}") if table in TABLES else None
    calls, without = getattr(module, "DOORS", {}), getattr(module, "WITHOUT", {})
    missing = wanted - set(calls) - set(without)
    missing = sorted(door for door in missing if door.split(".")[0] not in without)
    assert not missing, missing
    assert all(without.values())


@pytest.mark.parametrize(
    ("table", "name"), [(table, name) for table in TABLES for name in doors(table)]
)
def test_a_door_takes_only_what_it_can_work_with(table, name):
    wrong = walk(doors(table)[name]).wrong
    assert not wrong, "\n".join(wrong)


def ends(function):
    """How calls of a function end whose `x` is one number or more from 0 on."""
    return walk(lambda: call(function, x=floats([1.0, 2.0], ("N",), least=0))).ends


def test_the_walk_sees_silent_nonsense_deep_errors_and_errors_without_a_name():
    def silent(x):
        return 0.0

    def deep(x):
        if np.ndim(x) != 1:
            raise TypeError
        raise InputError("x")

    def unnamed(x):
        raise InputError("wrong")

    assert ends(silent)["silent"] > 10
    assert ends(deep)["deep"] > 2
    assert ends(unnamed)["unnamed"] > 10
    assert ends(unnamed)["refused"] > 1  # what is fine


def test_a_result_that_is_not_a_number_is_no_right_value():
    def result(n):
        return {"x": [np.array([np.nan])]}

    assert "gave {'x'" in walk(lambda: call(result, n=whole(1))).wrong[0]
