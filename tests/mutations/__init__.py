"""Small wrong changes to the code, as a tired engineer makes them; `tests.mutate` tries them out.

Each module here lists those of one part of the library, as rows of `Mutation`. A change must leave
the code importable, and mean something else; its old text stands once in its file.
"""

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


def mutations():
    """All of them, part by part."""
    rows = [row for part in PARTS for row in import_module(f"{__name__}.{part}").MUTATIONS]
    return [Mutation(*row) for row in rows]
