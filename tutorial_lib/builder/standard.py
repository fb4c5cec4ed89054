"""What every notebook must have; the builder refuses one that falls behind."""

import ast
import html
import re
from collections.abc import Iterator
from pathlib import Path

from nbformat import NotebookNode

from tutorial_lib.errors import InputError

MOST_GIVEN = 140
"""Lines of given code that stand open on the page, imports and exercises aside."""
LARGE = range(30, 46)
"""Minutes of the larger exercise that every notebook from 02 on has."""
WIDEST = 79
"""Columns of an exercise's docstrings: a page 900 pixels wide shows that many."""
HINTS = ("Hint 1: concept", "Hint 2: approach", "Hint 3: one line")
_HEADER = r"### Exercise \d+ · `{name}` \((easy|medium|hard|large), (\d+) minutes\)"
_MINUTES = re.compile(r"\*\*(\d+) minutes(?:, then (\d+))?\.\*\*")
_PAPER = re.compile(r"https://(arxiv\.org|doi\.org)/")
_SHORTEST = 12  # characters of a statement that a hint may hold


def check_standard(notebook: NotebookNode, source: Path, solutions: dict[str, str]) -> None:
    """Refuse a notebook that falls behind.

    Args:
        notebook: with its exercises, before anything is added.
        source: ``solutions/NN_name.py``.
        solutions: the code of each exercise's solution.

    Raises:
        InputError: that says what is missing.
    """
    for fault in _faults(notebook, source.stem, solutions):
        raise InputError(f"{source.name}: {fault}")


def minutes_of(source: Path) -> str:
    """The minutes of a notebook's sittings at its top, as "115 + 60"; "" if there are none."""
    found = _MINUTES.search(source.read_text(encoding="utf-8"))
    return " + ".join(filter(None, found.groups())) if found else ""


def _faults(notebook: NotebookNode, stem: str, solutions: dict[str, str]) -> Iterator[str]:
    texts = "\n".join(cell.source for cell in notebook.cells if cell.cell_type == "markdown")
    yield from _faults_of_folding(notebook)
    yield from _faults_of_width(notebook)
    if not solutions:
        return
    if not _MINUTES.search(texts):
        yield "its top does not say **N minutes.** or **N minutes, then M.**; measure them"
    if not _PAPER.search(texts):
        yield "no link to a paper (https://arxiv.org/... or https://doi.org/...); add one"
    large = []
    for name, solution in solutions.items():
        header = re.search(_HEADER.format(name=name), texts)
        if not header:
            yield f"no heading '### Exercise N · `{name}` (level, N minutes)'; write one"
            continue
        large += [int(header[2])] if header[1] == "large" else []
        text = texts[header.end() :].partition("### ")[0]
        yield from _faults_of_hints(name, text, solution)
    if int(stem[:2]) >= 2 and not any(minutes in LARGE for minutes in large):
        yield f"no larger exercise, (large, {LARGE[0]} to {LARGE[-1]} minutes); add one"


def _faults_of_folding(notebook: NotebookNode) -> Iterator[str]:
    given = 0
    for cell in notebook.cells:
        if cell.cell_type != "code" or "exercise" in cell.metadata:
            continue
        lines = [line for line in cell.source.splitlines() if line.strip()]
        if cell.metadata.get("hidden"):
            if not lines[0].startswith("# "):
                yield f"a hidden cell begins with {lines[0]!r}; begin with its title, '# ...'"
        elif not lines[0].startswith(("import ", "from ")):
            given += len(lines)
    if given > MOST_GIVEN:
        yield f"{given} lines of given code stand open; fold what is not to be read (hidden=true)"


def _faults_of_width(notebook: NotebookNode) -> Iterator[str]:
    for cell in notebook.cells:
        if "exercise" not in cell.metadata:
            continue
        inside = False
        for line in cell.source.splitlines():
            if (inside or '"""' in line) and len(line) > WIDEST:
                yield f"a docstring of {cell.metadata['exercise']!r} is cut off: {line.strip()}"
            inside ^= line.count('"""') == 1


def _faults_of_hints(name: str, text: str, solution: str) -> Iterator[str]:
    for hint in HINTS:
        if f"<summary>{hint}</summary>" not in text:
            yield f"exercise {name!r} has no '{hint}'; write it"
    last = text.rpartition(f"<summary>{HINTS[-1]}</summary>")[2].partition("</details>")[0]
    shown = _plain(html.unescape(re.sub(r"<[^>]+>", "", last)))
    for line in _statements(solution):
        if len(line) > _SHORTEST and _plain(line) in shown:
            yield f"hint 3 of {name!r} gives a line away: {line}; ask for it instead"


def _statements(solution: str) -> Iterator[str]:
    """What a hint may not hold: simple statements, and the values that they assign or return."""
    for node in ast.walk(ast.parse(solution)):
        if isinstance(node, ast.Assign | ast.AugAssign | ast.Return | ast.Expr):
            yield ast.unparse(node)
            if node.value is not None:
                yield ast.unparse(node.value)


def _plain(text: str) -> str:
    return re.sub(r"[\s()]", "", text)
