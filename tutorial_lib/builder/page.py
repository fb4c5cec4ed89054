"""What the builder adds to the page of a notebook: links, explained terms, folded code."""

import re
from dataclasses import dataclass
from pathlib import Path

from nbformat import NotebookNode

from tutorial_lib.errors import InputError
from tutorial_lib.reading.documents import read_json

GLOSSARY = "glossary.json"
"""Beside the sources: for each term its meaning, and perhaps its symbol and unit."""
MAP = "README.md"
"""Beside the notebooks: the map of the course and the glossary."""
_TERM = re.compile(r"\[\[([^\]]+)\]\]")


@dataclass(frozen=True)
class Entry:
    """An entry of the glossary.

    Attributes:
        term: as it is written in `[[term]]`.
        meaning: a sentence.
        symbol: in formulas, as LaTeX; may be empty.
        unit: may be empty.
    """

    term: str
    meaning: str
    symbol: str = ""
    unit: str = ""

    @property
    def anchor(self) -> str:
        """The name of its place on the page of the glossary."""
        return re.sub(r"[^a-z0-9]+", "-", self.term.lower()).strip("-")


def sources_in(folder: Path) -> list[Path]:
    """The sources of the notebooks, ``NN_name.py``, in their order."""
    return sorted(folder.glob("[0-9][0-9]_*.py"))


def read_glossary(folder: Path) -> dict[str, Entry]:
    """The entries by term, in the order of the alphabet; none without the file."""
    path = folder / GLOSSARY
    if not path.is_file():
        return {}
    try:
        known = read_json(path)
        entries = {term: Entry(term, **entry) for term, entry in known.items()}
    except (ValueError, TypeError, AttributeError) as error:
        raise InputError(f"{path}: not a glossary ({error}); see builder/page.py") from error
    return dict(sorted(entries.items(), key=lambda pair: pair[0].lower()))


def complete(notebook: NotebookNode, source: Path) -> None:
    """Add to a notebook the links to its neighbours, explain its terms, and fold hidden cells.

    Raises:
        InputError: naming a term that the glossary does not have.
    """
    entries = read_glossary(source.parent)
    links = navigation(source)
    texts = [cell for cell in notebook.cells if cell.cell_type == "markdown"]
    for cell in texts:
        cell.source = explained(cell.source, entries, source.name)
    if texts:
        title, _, rest = texts[0].source.partition("\n")
        texts[0].source = f"{title}\n\n{links}\n{rest}"
        texts[-1].source += f"\n\n---\n\n{links}"
    for cell in notebook.cells:
        if cell.metadata.pop("hidden", None):
            cell.metadata["jupyter"] = {"source_hidden": True}


def lead_to_notebooks(solved: NotebookNode) -> None:
    """Let the links of a solved notebook, beside which is the teacher's page, lead to the map."""
    for cell in solved.cells:
        if cell.cell_type == "markdown":
            cell.source = cell.source.replace(f"]({MAP}", f"](../notebooks/{MAP}")


def navigation(source: Path) -> str:
    """A line of links to the notebook before, the course's page, and the notebook after."""
    sources = sources_in(source.parent)
    place = sources.index(source)
    links = [f"[map of the course and glossary]({MAP})"]
    if place > 0:
        before = sources[place - 1]
        links.insert(0, f"[← {title_of(before)}]({before.stem}.ipynb)")
    if place + 1 < len(sources):
        after = sources[place + 1]
        links.append(f"[{title_of(after)} →]({after.stem}.ipynb)")
    return " · ".join(links)


def title_of(source: Path) -> str:
    """The heading of a notebook, as in ``01 · The world and the car``."""
    found = re.search(r"^# # (.+)$", source.read_text(encoding="utf-8"), re.MULTILINE)
    return found[1].strip() if found else source.stem


def explained(text: str, entries: dict[str, Entry], name: str) -> str:
    """Text whose `[[term]]`s are links to the glossary that show their meaning when pointed at.

    Raises:
        InputError: naming a term that the glossary does not have.
    """

    def link(match: re.Match[str]) -> str:
        term = match[1]
        found = entries.get(term) or entries.get(term[:1].lower() + term[1:])
        if found is None:
            raise InputError(f"{name}: [[{term}]] is not in {GLOSSARY}; add it, or mend the term")
        meaning = found.meaning.replace('"', "'")
        unit = f" ({found.unit})" if found.unit else ""
        return f'[{term}]({MAP}#{found.anchor} "{meaning}{unit}")'

    return _TERM.sub(link, text)
