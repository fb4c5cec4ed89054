"""Small wrong changes to the code, as a tired engineer makes them; `tests.mutate` tries them out.

Each module here lists those of one part of the library, as `changes` reads them, or as rows of
`Mutation`. A change must leave the code importable, and mean something else; its old text stands
once in its file.
"""

import re
from importlib import import_module
from typing import NamedTuple

PARTS = (
    "reading", "world", "driving", "exploration", "learning", "topology", "agents", "experiments",
    "viz", "checks", "project",
)  # fmt: skip


class Mutation(NamedTuple):
    """A wrong change.

    Attributes:
        what: goes wrong, in a few words.
        file: of the library.
        old: text that stands there once.
        new: text in its place.
        tests: file of the tests that must notice it, and further arguments for pytest.
    """

    what: str
    file: str
    old: str
    new: str
    tests: str


def changes(text):
    """Rows of a text such as

        sums.py | test_sums.py -k total
        the total is a difference
            a + b -> a - b

    A line names a file of the library and, behind a bar, the tests that must notice the changes
    below it: what goes wrong and, indented, old -> new. The arrow may begin a line.
    """
    rows, file, tests = [], "", ""
    for block in re.split(r"\n+(?=\S)", text.strip()):
        first, _, edit = block.partition("\n")
        if edit:
            old, new = re.split(r"\s+-> ", edit.strip())
            rows.append((first, file, old, new, tests))
        else:
            file, tests = first.split(" | ")
    return rows


def mutations():
    """All of them, part by part."""
    rows = [row for part in PARTS for row in import_module(f"{__name__}.{part}").MUTATIONS]
    return [Mutation(*row) for row in rows]
