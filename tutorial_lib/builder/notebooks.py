"""Builds two notebooks from one source: for students, and with solutions and outputs.

``solutions/NN_name.py`` holds percent cells (jupytext). A cell that starts with
``# %% exercise="name"`` defines a function of that name, whose body is marked by
``### BEGIN SOLUTION`` and ``### END SOLUTION``; a later cell calls ``check_name.use(name)``; and
``tests/wrong_answers/NN_name.py`` holds at least three answers that the check must reject.
"""

import ast
import hashlib
import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from textwrap import dedent, fill

import jupytext
import nbformat
from nbclient import NotebookClient
from nbclient.exceptions import CellExecutionError
from nbformat import NotebookNode

from tutorial_lib.builder.page import complete, lead_to_notebooks
from tutorial_lib.builder.standard import check_standard
from tutorial_lib.checks.framework import my_answers
from tutorial_lib.commands.outputs import without_widgets
from tutorial_lib.errors import InputError
from tutorial_lib.files import write_text
from tutorial_lib.learning.threads import processor
from tutorial_lib.viz.notebook.display import STATIC

BEGIN, END = "### BEGIN SOLUTION", "### END SOLUTION"
STUB = 'raise NotImplementedError("your turn")'
_SOLUTION = re.compile(rf"^([ \t]*){BEGIN}[ \t]*\n(.*?)^[ \t]*{END}[ \t]*$", re.DOTALL | re.M)
"""A marked solution: how far it is indented, and its lines."""
WRONG_ANSWERS = 3
"""Needed for each exercise."""
LARGEST = 1_000_000
"""Bytes of a notebook with its outputs."""
_STORED = {my_answers.FOLDER: "", STATIC: "1", "TQDM_DISABLE": "1"}
"""While a notebook is executed for its page: no answers are saved, no progress bars shown."""
_TIMEOUT = 120  # seconds a cell may take while it is built


def build(source: Path, project: Path, *, students_only: bool = False) -> list[Path]:
    """Write the notebooks of one source.

    The solved one is executed again only if its code has changed.

    Args:
        source: ``solutions/NN_name.py``.
        project: the folder that holds notebooks, solutions and tests.
        students_only: leave the solved notebook alone; nothing is executed.

    Returns:
        The files that were written.

    Raises:
        InputError: naming the line of the source that is wrong.
    """
    solved = read(source, project / "tests" / "wrong_answers" / source.name)
    written = [project / "notebooks" / f"{source.stem}.ipynb"]
    write_text(written[0], to_text(for_students(solved)))
    if students_only:
        return written
    lead_to_notebooks(solved)
    target = source.with_suffix(".ipynb")
    before = target.read_text(encoding="utf-8") if target.exists() else ""
    if not (before and _take_outputs(solved, before)):
        execute(solved, project / "notebooks")
    text = to_text(solved)
    if len(text.encode()) > LARGEST:
        raise InputError(f"{target.name}: {len(text.encode()):,} bytes; show smaller pictures")
    if text != before:
        write_text(target, text)
        written.append(target)
    return written


def cells_of(text: str) -> NotebookNode:
    """A source as a notebook, as it stands."""
    return NotebookNode(jupytext.reads(text, fmt="py:percent"))


def read(source: Path, wrong_answers: Path) -> NotebookNode:
    """The solved notebook, without outputs, after all rules have been checked."""
    text = source.read_text(encoding="utf-8")
    notebook = cells_of(text)
    starts = [n for n, line in enumerate(text.splitlines(), 1) if line.startswith("# %%")]
    if len(starts) != len(notebook.cells):
        raise InputError(f"{source.name}:1: text stands before the first '# %%'; start with a cell")
    checks = _answers(wrong_answers)
    names: set[str] = set()
    solutions: dict[str, str] = {}
    for number, (cell, line) in enumerate(zip(notebook.cells, starts, strict=True)):
        where = f"{source.name}:{line}"
        name = cell.metadata.get("exercise")
        _check_markers(cell.source, source.name, line, name is not None)
        if name is None:
            continue
        if name in names:
            raise InputError(f"{where}: a second exercise {name!r}; rename it")
        names.add(name)
        solutions[name] = solution_of(cell.source)
        _check_signature(cell.source, where, name)
        if not any(f"check_{name}.use({name})" in c.source for c in notebook.cells[number + 1 :]):
            raise InputError(f"{where}: exercise {name!r} has no check_{name}.use({name}) after it")
        if checks.count(name) < WRONG_ANSWERS:
            raise InputError(
                f"{where}: {wrong_answers.name} in tests/wrong_answers has {checks.count(name)} "
                f"wrong answers for {name!r}; write {WRONG_ANSWERS} functions {name}__what_is_wrong"
            )
    check_standard(notebook, source, solutions)
    complete(notebook, source)
    _finish(notebook, source.stem)
    return notebook


def for_students(solved: NotebookNode) -> NotebookNode:
    """A copy with every solution replaced by a stub."""
    notebook = nbformat.from_dict(solved)
    notebook = NotebookNode(nbformat.reads(nbformat.writes(notebook), as_version=4))
    for cell in notebook.cells:
        if cell.cell_type == "code":
            cell.source = stubbed(cell.source)
            cell.outputs, cell.execution_count = [], None
    return notebook


def stubbed(code: str) -> str:
    """Code whose marked solutions are replaced by a stub."""
    return _SOLUTION.sub(rf"\1{STUB}", code)


def solution_of(code: str) -> str:
    """The lines between the markers, as code of its own."""
    return dedent("".join(solution for _, solution in _SOLUTION.findall(code)))


def unmarked(code: str) -> str:
    """Code with the solution, but without the markers."""
    return "\n".join(line for line in code.splitlines() if line.strip() not in (BEGIN, END))


def execute(notebook: NotebookNode, folder: Path, env: Mapping[str, str] | None = None) -> None:
    """Run every cell in `folder`, and keep the outputs and on what kind of processor they came.

    Args:
        notebook: gets its outputs.
        folder: to run in.
        env: variables of the environment that differ from those of a page that is stored.

    Raises:
        InputError: when a cell raises.
    """
    client = NotebookClient(
        notebook,
        timeout=_TIMEOUT,
        kernel_name="python3",
        store_widget_state=False,
        record_timing=False,
        resources={"metadata": {"path": str(folder)}},
    )
    try:
        client.execute(env={**os.environ, **_STORED, **(env or {})})
    except CellExecutionError as error:
        raise InputError(f"a cell of the notebook raised {error.ename}: {error.evalue}") from error
    for cell in notebook.cells:
        cell.source = unmarked(cell.source)
        if cell.cell_type == "code":
            cell.outputs = without_widgets(cell.outputs)
    notebook.metadata.pop("widgets", None)
    notebook.metadata.language_info = {"name": "python"}
    notebook.metadata.processor = processor()


def to_text(notebook: NotebookNode) -> str:
    """The text of the notebook's file."""
    return nbformat.writes(notebook) + "\n"


def compact_imports(code: str) -> str:
    """Code whose long import lists fill lines of 100 columns, in place of a line for each name."""

    def filled(match: re.Match[str]) -> str:
        names = " ".join(match[2].split())
        return f"{match[1]}{fill(names, 100, initial_indent='    ', subsequent_indent='    ')}\n)"

    return re.sub(r"^(from \S+ import \(\n)((?:    \w+,\n)+)\)", filled, code, flags=re.MULTILINE)


def _finish(notebook: NotebookNode, stem: str) -> None:
    """Compact imports, and metadata and cell ids that are the same at every build."""
    for cell in notebook.cells:
        cell.source = compact_imports(cell.source)
    kernel = "Python 3 (ipykernel)"  # as JupyterLab would write it
    kernelspec = {"display_name": kernel, "language": "python", "name": "python3"}
    language = {"name": "python"}
    notebook.metadata = nbformat.from_dict({"kernelspec": kernelspec, "language_info": language})
    seen: dict[str, int] = {}
    for cell in notebook.cells:
        digest = hashlib.sha256(f"{stem}\n{cell.source}".encode()).hexdigest()[:12]
        seen[digest] = seen.get(digest, 0) + 1
        cell.id = digest if seen[digest] == 1 else f"{digest}-{seen[digest]}"


def _take_outputs(solved: NotebookNode, page: str) -> bool:
    """Give a notebook the outputs of its page, if that was executed with this code."""
    there = NotebookNode(nbformat.reads(page, as_version=4))
    cells = [cell for cell in solved.cells if cell.cell_type == "code"]
    ran = [cell for cell in there.cells if cell.cell_type == "code"]
    if [cell.source for cell in ran] != [unmarked(cell.source) for cell in cells]:
        return False
    for cell, other in zip(cells, ran, strict=True):
        cell.outputs, cell.execution_count = without_widgets(other.outputs), other.execution_count
    for cell in solved.cells:
        cell.source = unmarked(cell.source)
    solved.metadata = NotebookNode({**there.metadata, **solved.metadata})
    return True


def _check_markers(code: str, name: str, start: int, is_exercise: bool) -> None:
    opened = 0
    for line, text in enumerate(code.splitlines(), start + 1):
        marker = text.strip()
        if marker in (BEGIN, END) and not is_exercise:
            raise InputError(f'{name}:{line}: {marker} outside an exercise="name" cell; name it')
        if marker == BEGIN and opened:
            raise InputError(f"{name}:{line}: {BEGIN} again, before {END}; close the first")
        if marker == END and not opened:
            raise InputError(f"{name}:{line}: {END} without {BEGIN}; open it")
        opened = line if marker == BEGIN else 0 if marker == END else opened
    if opened:
        raise InputError(f"{name}:{opened}: {BEGIN} is never closed; write {END}")
    if is_exercise and BEGIN not in code:
        raise InputError(f"{name}:{start}: the exercise has no {BEGIN}; mark its solution")


def _check_signature(code: str, where: str, name: str) -> None:
    """Stub and solution must define the same functions with the same arguments."""
    solution, stub = list(_signatures(code, where)), list(_signatures(stubbed(code), where))
    if solution != stub:
        missing = ", ".join(sorted(set(solution) ^ set(stub)))
        raise InputError(
            f"{where}: stub and solution differ in {missing}; keep def outside {BEGIN}"
        )
    if not any(line.startswith(f"{name}(") for line in stub):
        raise InputError(f"{where}: the exercise {name!r} defines no function of that name")


def _signatures(code: str, where: str) -> Iterator[str]:
    try:
        tree = ast.parse(code)
    except SyntaxError as error:
        raise InputError(f"{where}: {error.msg} in line {error.lineno} of the cell") from None
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            yield f"{node.name}({ast.unparse(node.args)})"


def _answers(path: Path) -> list[str]:
    """The exercise to which each wrong answer in a file belongs."""
    if not path.exists():
        return []
    tree = ast.parse(path.read_text(encoding="utf-8"))
    names = [node.name for node in tree.body if isinstance(node, ast.FunctionDef)]
    return [
        n.split("__")[0] for n in names if "__" in n and not n.split("__")[1].startswith("right")
    ]
