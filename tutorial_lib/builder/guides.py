"""The pages for students and teachers, made from the notebooks' sources.

``notebooks/README.md`` is the map of the course and the glossary; ``solutions/REFERENCE.md`` has
goals, minutes, open questions with their answers, and mistakes with the check's words. What a
teacher reads first, ``solutions/README.md``, is written by hand.
"""

import ast
import html
import re
from functools import partial
from importlib import import_module
from pathlib import Path

from tutorial_lib.builder.notebooks import cells_of
from tutorial_lib.builder.page import Entry, read_glossary, sources_in, title_of
from tutorial_lib.builder.standard import minutes_of
from tutorial_lib.errors import InputError
from tutorial_lib.files import write_text

MADE = "<!-- Below this line the build writes. -->"
"""In both pages, under what is written by hand."""
_EXERCISE = re.compile(r"### Exercise \d+ · `(\w+)` \((\w+), (\d+) minutes\)")
_GOALS = re.compile(r"After this notebook you (?:can|will)\W*\n\n((?:- .+\n(?:  .+\n)*)+)")
_ANSWER = re.compile(r"<details><summary>(?!Hint)(.+?)</summary>(.+?)</details>", re.DOTALL)
_QUESTION = re.compile(r"\*\*(?:Predict|Before you (?:run|move)).+?(?=\n\n|\Z)", re.DOTALL)


def write_guides(project: Path) -> list[Path]:
    """Write both pages of a project, each below the introduction that it already has.

    Returns:
        The files that were written.
    """
    sources, wrong_answers = sources_in(project / "solutions"), project / "tests" / "wrong_answers"
    pages = {
        project / "notebooks" / "README.md": partial(students_page, sources),
        project / "solutions" / "REFERENCE.md": partial(teachers_page, sources, wrong_answers),
    }
    for file, page in pages.items():
        top, mark, _ = file.read_text(encoding="utf-8").partition(MADE)
        if not mark:
            raise InputError(f"{file}: no line {MADE!r}; what stands below it is made by the build")
        write_text(file, page(f"{top}{MADE}\n"))
    return list(pages)


def students_page(sources: list[Path], introduction: str) -> str:
    """The map of the course and the glossary, below an introduction written by hand."""
    rows = []
    for source in sources:
        link, minutes = f"[{title_of(source)}]({source.stem}.ipynb)", minutes_of(source)
        rows.append(f"| {link} | {_listed(source)} | {minutes} |")
    table = ["| notebook | you write | minutes |", "|---|---|---|", *rows]
    entries = read_glossary(sources[0].parent)
    terms = ["| term | symbol | unit | meaning | notebooks |", "|---|---|---|---|---|"]
    terms += [_row(entry, sources) for entry in entries.values()]
    parts = [introduction.rstrip(), "## The notebooks", "\n".join(table), "## Glossary"]
    return "\n\n".join([*parts, "\n".join(terms)]) + "\n"


def teachers_page(sources: list[Path], wrong_answers: Path, introduction: str) -> str:
    """Goals, minutes, open questions and common mistakes of every notebook, likewise.

    The folder `wrong_answers` has the answers that the checks reject.
    """
    parts = [introduction.rstrip()]
    for source in sources:
        text = _prose(source)
        parts.append(f"## {title_of(source)}")
        parts.append(f"{minutes_of(source)} minutes.")
        goals = _GOALS.search(text)
        if goals:
            parts.append(f"After it a student can\n\n{goals[1].rstrip()}")
        if _EXERCISE.search(text):
            parts.append(_exercises(text))
        found = {
            "Questions and what to expect": _questions(text),
            "Predictions": _predictions(source),
            "Mistakes that the checks know": _known_mistakes(text, source),
            "Common mistakes and what the check says": _mistakes(wrong_answers / source.name),
        }
        parts += [f"### {title}\n\n" + "\n".join(lines) for title, lines in found.items() if lines]
    return "\n\n".join(parts) + "\n"


def _prose(source: Path) -> str:
    cells = cells_of(source.read_text(encoding="utf-8")).cells
    text = "\n\n".join(cell.source for cell in cells if cell.cell_type == "markdown")
    return re.sub(r"\[\[([^\]]+)\]\]", r"\1", text)


def _listed(source: Path) -> str:
    found = _EXERCISE.findall(_prose(source))
    return ", ".join(f"`{name}` ({minutes})" for name, _, minutes in found) or "nothing"


def _row(entry: Entry, sources: list[Path]) -> str:
    named = rf"\b{entry.term}\b" if "_" in entry.term else rf"\[\[{re.escape(entry.term)}\]\]"
    mark = re.compile(named, re.IGNORECASE)  # a threshold is used wherever its name stands
    used = [s.stem[:2] for s in sources if mark.search(s.read_text(encoding="utf-8"))]
    symbol = f"${entry.symbol}$" if entry.symbol else ""
    term = f'<a id="{entry.anchor}"></a>{entry.term}'
    return f"| {term} | {symbol} | {entry.unit} | {entry.meaning} | {', '.join(used)} |"


def _exercises(text: str) -> str:
    rows = [
        f"| `{name}` | {level} | {minutes} |" for name, level, minutes in _EXERCISE.findall(text)
    ]
    return "\n".join(["| exercise | level | minutes |", "|---|---|---|", *rows])


def _questions(text: str) -> list[str]:
    """For each answer behind a fold the prediction asked for before it, and the answer."""
    items, since = [], 0
    for found in _ANSWER.finditer(text):
        asked = _QUESTION.findall(text[since : found.start()])
        question, since = _line(asked[-1]) if asked else f"**{_line(found[1])}**", found.end()
        items.append(f"- {question}\n  *Answer:* {_line(found[2])}")
    return items


def _predictions(source: Path) -> list[str]:
    """The predictions that a notebook asks for by `Prediction`, with what is right and tempts."""
    items = []
    for node in ast.walk(ast.parse(source.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "Prediction":
            names = ("notebook", "name", "ask", "options")
            given = dict(zip(names, node.args, strict=False))
            given |= {keyword.arg: keyword.value for keyword in node.keywords}
            options = ast.literal_eval(given["options"])
            right, tempting = (ast.literal_eval(given[key]) for key in ("right", "tempting"))
            listed = "; ".join(f"{letter}: {words}" for letter, words in options.items())
            answer = f"{right}. {tempting} tempts: {_said(given['because'])}"
            items.append(f"- {_said(given['ask'])} {listed}\n  *Answer:* {answer}")
    return items


def _said(node: ast.expr) -> str:
    """The text of a string in a source; what is computed is left out."""
    parts = node.values if isinstance(node, ast.JoinedStr) else [node]
    return "".join(str(part.value) if isinstance(part, ast.Constant) else "…" for part in parts)


def _known_mistakes(text: str, source: Path) -> list[str]:
    """By exercise, what its check says of each mistake that it knows."""
    items = []
    for name, *_ in _EXERCISE.findall(text):
        checks = import_module(f"tutorial_lib.checks.nb{source.stem[:2]}")
        known = getattr(getattr(checks, f"check_{name}", None), "mistakes", None) or {}
        if known:
            items.append(f"- `{name}`")
        items += [f"  - {html.escape(words, quote=False)}" for words in known]
    return items


def _mistakes(path: Path) -> list[str]:
    """A table of wrong answers: what they do, and the words by which the check names it."""
    if not path.is_file():
        return []
    rows = []
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if not isinstance(node, ast.FunctionDef):
            continue
        exercise, _, mistake = node.name.partition("__")
        if mistake and not mistake.startswith("right"):
            said = html.escape(_line(ast.get_docstring(node) or ""))
            rows.append(
                f"| `{exercise}` | {mistake.replace('_', ' ')} | {said.replace('|', '&#124;')} |"
            )
    return ["| exercise | the answer | the check says ... |", "|---|---|---|", *rows]


def _line(text: str) -> str:
    return " ".join(text.split())
