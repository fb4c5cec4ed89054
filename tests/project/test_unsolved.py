"""A notebook that is run solved and unsolved at once prints what each of the two would."""

import contextlib
import io

import pytest
from nbformat.v4 import new_code_cell, new_markdown_cell

from tests.project.unsolved import both

EXERCISE = "def double(x):\n    return 2 * x"
STUB = "def double(x):\n    return 0"


def cells_of(exercise, rest):
    first = new_code_cell(exercise, metadata={"exercise": "double"})
    return [new_code_cell("start = 3"), first, new_markdown_cell("text"), *map(new_code_cell, rest)]


def run(cells):
    """What each cell prints."""
    names, said = {}, []
    for cell in cells:
        with contextlib.redirect_stdout(io.StringIO()) as out:
            if cell.cell_type == "code":
                exec(compile(cell.source, "cell", "exec"), names)
        said.append(out.getvalue())
    return said


@pytest.mark.parametrize(
    ("rest", "again"),
    [
        (["print(start)"], []),
        (["print(double(start))"], [0]),
        (["print(start)", "x = double(start)", "print(x)", "print(start)"], [1, 2]),
        (["def f(x):\n    return double(x)", "print(f(4))"], [0, 1]),
        (["class A:\n    b = [double(1)]", "a = A()", "print(a.b)"], [0, 1, 2]),
        (["x = double(1)", "print(x)", "x = 5", "print(x)"], [0, 1]),
        (["def f():\n    return x", "x = double(1)", "print(f())"], [1, 2]),
        (["x = 1", "x = x + double(x)", "x = x + double(x)", "print(x)"], [1, 2, 3]),
        (["x = double(1)", "x = 7", "x = x + double(x)", "print(x)"], [0, 2, 3]),
        (["x = 1", "y = [x for x in [double(2)]]", "print(x)", "print(y)"], [1, 3]),
        (["import math as x", "for x in range(double(1)):\n    pass", "print(x)"], [1, 2]),
        (["f = [lambda: double(1)]", "g = f + []", "print(g[0]())"], [0, 1, 2]),
        (["def f():\n    global x\n    x = double(1)", "f()", "x = 1", "print(x)"], [0, 1]),
    ],
)
def test_each_prints_what_it_prints_alone(rest, again):
    solved, unsolved = cells_of(EXERCISE, rest), cells_of(STUB, rest)
    cells, first, second = both(solved, unsolved)
    said = run(cells)
    assert [said[i] for i in first] == run(solved)
    ran = [1, *(3 + i for i in again)]
    assert [said[i] for i in second] == [run(unsolved)[i] for i in ran]
    assert [cells[i] for i in second] == [unsolved[i] for i in ran]


def test_what_only_the_solution_defines_is_missing_without_it():
    solved = cells_of(f"helper = 1\n{EXERCISE}", ["print(helper)"])
    cells, _, second = both(solved, cells_of(STUB, ["print(helper)"]))
    run(cells[: second[-1]])
    with pytest.raises(NameError):
        run(cells)
