"""A notebook solved and unsolved in one run: what no exercise has a part in is run once."""

import dis
import re
from types import CodeType

from nbformat.v4 import new_code_cell

_SLOW = re.compile(r"# .*\(about \d+ s\)\n")
_READS = ("LOAD_NAME", "LOAD_GLOBAL", "LOAD_FROM_DICT_OR_GLOBALS")

BEGIN = new_code_cell('''
class _Unsolved:
    """Values that names have in the unsolved notebook, while the solved one's are in place."""

    values = {}

    def keep(names):
        """Take over what names are before a cell gives them two values."""
        for name in names:
            _Unsolved.values.pop(name, None)
            if name in globals():
                _Unsolved.values[name] = globals()[name]

    def swap(names):
        """Put one notebook's values in the place of the other's."""
        here = {name: globals().pop(name) for name in names if name in globals()}
        there = {n: _Unsolved.values.pop(n) for n in names if n in _Unsolved.values}
        globals().update(there)
        _Unsolved.values.update(here)
''')


def both(solved, unsolved, *, slow_ones=True):
    """Cells that run both notebooks, and which of them are cells of each.

    An unsolved cell follows its solved one, on values of its own, if it reads what comes from an
    exercise. The others are the same code on the same values, and stand for both. So does, without
    `slow_ones`, a cell that announces its seconds: behind a check the student's function and the
    library's, which stands in for one that is missing, do the same.

    Returns:
        The cells, the indices of all cells of the solved notebook, and those of the cells of the
        unsolved one that were run again.
    """
    cells, first, second = [BEGIN], [], []
    for cell, other, names, new in _parts(solved, unsolved, slow_ones):
        if names is not None:
            cells.append(new_code_cell(f"_Unsolved.keep({sorted(new)})"))
        first.append(len(cells))
        cells.append(cell)
        if names is not None:
            swap = f"_Unsolved.swap({sorted(names)})"
            second.append(len(cells) + 1)
            cells += [new_code_cell(swap), other, new_code_cell(swap)]
    return cells, first, second


def _parts(solved, unsolved, slow_ones):
    """For each cell its twin, the names with two values after it, and those that are new.

    Both are None where the cell reads no name with two values.
    """
    two, needs = set(), {}
    for cell, other in zip(solved, unsolved, strict=True):
        if cell.cell_type != "code":
            yield cell, other, None, None
            continue
        now, later, stored = flow(compile(cell.source, "cell", "exec"))
        reads = now | later
        once = not slow_ones and _SLOW.match(cell.source)
        depends = not once and not two.isdisjoint(_all(reads, needs))
        if "exercise" in cell.metadata or depends:
            new, two = stored - two, two | stored
            yield cell, other, two, new
        else:
            two -= stored
            yield cell, other, None, None
        behind = later.union(*(needs.get(name, ()) for name in reads))
        needs |= dict.fromkeys(stored, behind)


def flow(code):
    """The names that code reads before it stores them, that its functions read, and it stores."""
    now, later, stored = set(), set(), set()
    for step in dis.get_instructions(code):
        if isinstance(step.argval, CodeType):
            within, deeper, _ = flow(step.argval)
            later |= (within | deeper) - stored
        elif step.opname in _READS and step.argval not in stored:
            now.add(step.argval)
        elif step.opname.startswith("STORE_") and step.opname.endswith(("_NAME", "_GLOBAL")):
            stored.add(step.argval)
    return now, later, stored


def _all(names, needs):
    """Names, and those that functions and objects behind them read."""
    found, left = set(), set(names)
    while left:
        name = left.pop()
        found.add(name)
        left |= needs.get(name, set()) - found
    return found
