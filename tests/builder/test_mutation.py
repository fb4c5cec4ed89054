import json

import pytest

from tutorial_lib.builder import exercises, mutants, survivors
from tutorial_lib.builder.mutation import changes
from tutorial_lib.checks import nb01
from tutorial_lib.errors import InputError

pytestmark = pytest.mark.filterwarnings("ignore:divide by zero")  # some mutants do

CODE = """
def f(x, y):
    z = 0
    if x < y:
        z = max(x, 2)
    return z + y
"""


def changed(code=CODE, within=range(3, 7)):
    return {name: text for text, name in changes(code, within)}


def test_each_operator_makes_its_change():
    names = changed()
    for name in (
        "z = 0 -> z = 1",
        "z = 0 -> pass",
        "if x < y: -> if x <= y:",
        "if x < y: -> if x > y:",
        "if x < y: -> if True:",
        "if x < y: -> pass",
        "z = max(x, 2) -> z = min(x, 2)",
        "z = max(x, 2) -> z = x",
        "z = max(x, 2) -> z = max(x, 3)",
        "return z + y -> return z - y",
        "return z + y -> return y",
    ):
        assert name in names
    assert "z = max(x, 2) -> z = max(2, x)" not in names  # the same function
    assert len(set(names.values())) == len(names)


def test_changed_code_differs_by_that_change_alone():
    names = changed()
    assert "z = min(x, 2)" in names["z = max(x, 2) -> z = min(x, 2)"]
    assert "if x < y:" in names["z = max(x, 2) -> z = min(x, 2)"]
    for text in names.values():
        compile(text, "mutant", "exec")


def test_only_the_solution_is_changed():
    assert all(name.startswith("return") for name in changed(within=range(6, 7)))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("return x[1:3]", "return x[:3]"),
        ("return x and y", "return x or y"),
        ("return x and y", "return x"),
        ("return not x", "return x"),
        ("return x @ y", "return y @ x"),
        ("return [i for i in x if i]", "return [i for i in x]"),
        ("return x if y else 1", "return x"),
        ("return g(x, y)", "return g(y, x)"),
        ("return g(x, k=y)", "return g(x)"),
        ("x += y", "x = y"),
        ("return 0.5 * x", "return 1.0 * x"),
        ("return 0 <= x < y", "return 0 <= x <= y"),
    ],
)
def test_kinds_of_change(old, new):
    assert f"{old} -> {new}" in changed(f"def f(x, y):\n    {old}\n", range(2, 3))


SOURCE = '''
# %%
import numpy as np

kept = np.zeros(2)
unused = 1 / 0


# %% exercise="to_local"
def to_local(pose, points):
    """World points in the frame of a pose."""
    ### BEGIN SOLUTION
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    dx, dy = points[:, 0] - pose[0], points[:, 1] - pose[1]
    return np.stack([cos * dx + sin * dy, cos * dy - sin * dx], axis=1) + kept
    ### END SOLUTION


# %%
to_local = check_to_local.use(to_local)
'''


@pytest.fixture
def source(tmp_path):
    path = tmp_path / "01_world.py"
    path.write_text(SOURCE)
    return path


def test_a_solution_gets_only_what_it_needs_of_earlier_cells(source):
    (exercise,) = exercises(source)
    assert "kept" in exercise.given
    assert "unused" not in exercise.given
    assert exercise.check is nb01.check_to_local
    made = dict(mutants(exercise))
    assert len(made) > 40


@pytest.mark.full
def test_a_survivor_needs_a_reason_and_a_reason_a_survivor(source, tmp_path):
    known = tmp_path / "known.json"
    change = (
        "return np.stack([cos * dx + sin * dy, cos * dy - sin * dx], axis=1) + kept -> "
        "return np.stack([cos * dx + sin * dy, cos * dy - sin * dx], axis=1)"
    )
    ((_, tried, passed),) = survivors(source, known)
    assert tried > 40
    assert [s.reason for s in passed if s.change == change] == [""]
    known.write_text(json.dumps({"to_local": {change: "kept is zero"}}))
    ((_, _, passed),) = survivors(source, known)
    assert [s.reason for s in passed if s.change == change] == ["kept is zero"]
    known.write_text(json.dumps({"to_local": {"return 1 -> return 2": "there is none"}}))
    with pytest.raises(InputError, match="no such survivor"):
        list(survivors(source, known))
