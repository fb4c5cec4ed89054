"""Copies the course's pages to where somebody reads them."""

import argparse
import hashlib
import json
import re
from importlib import metadata
from pathlib import Path

from tutorial_lib.course import CHECKOUT, NAME, is_checkout
from tutorial_lib.errors import InputError
from tutorial_lib.files import make_folder, write_files
from tutorial_lib.reading.documents import read_json

_PROJECT = "topological-visual-navigation"
_NOTES = f".{NAME}.json"
_OF_THE_LIBRARY = re.compile(r"""[("](?:\.\./)*(tutorial_lib/[\w./]+\.(?:py|md))""")
"""A link to the library's text, in Markdown or HTML."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the folder."""
    parser.add_argument(
        "folder", nargs="?", type=Path, default=Path(), help="the current one unless given"
    )


def run(options: argparse.Namespace) -> int:
    """Copy, and say where to begin."""
    copy_here(options.folder)
    print(f"Begin with {options.folder / 'notebooks' / '00_start_here.ipynb'}")
    return 0


def copy_here(folder: Path) -> None:
    """Copy the pages into a folder, and say which are there in an older version of one's own."""
    for name in copy_pages(folder):
        print(f"kept your {name}; for the one that is newer rename yours, and copy again")
    print(f"The course is in {folder.resolve()}")


def copy_pages(folder: Path) -> list[str]:
    """Copy the notebooks, their solutions and what they link to; keep what was changed there.

    Args:
        folder: made where it is missing. A file in it with the digest of what was copied before is
            as it came, and gives way to a newer one.

    Returns:
        The names of changed files of which there is another version than the one they came from.

    Raises:
        InputError: when this is the checkout, or the pages were not installed.
    """
    if is_checkout():
        raise InputError(f"copy: the pages are in {CHECKOUT}, the checkout; open them there")
    before, kept = _copied(folder), []
    now = dict(before)
    for name, source in _pages().items():
        data, target = source.read_bytes(), folder / name
        new, there = _digest(data), _digest(target.read_bytes()) if target.exists() else None
        if there not in (None, new, before.get(name)):
            kept += [name] if before.get(name) != new else []
            continue
        if there != new:
            make_folder(target.parent)
            write_files({target: data})
        now[name] = new
    if now != before:
        write_files({folder / _NOTES: json.dumps(now, indent=1).encode()})
    return kept


def _pages() -> dict[str, Path]:
    """The files by their names in the course's folder, with those of the library they link to."""
    share = ("share", NAME)
    pages = {}
    for file in metadata.files(_PROJECT) or ():
        if share in zip(file.parts, file.parts[1:], strict=False):
            name = "/".join(file.parts[file.parts.index(NAME) + 1 :])
            pages[name] = Path(file.locate()).resolve()
    if not pages or not all(page.is_file() for page in pages.values()):
        raise InputError("the course's pages are missing; install the course again with pip")
    for page in list(pages.values()):
        if page.suffix in (".md", ".ipynb"):
            linked = _OF_THE_LIBRARY.findall(page.read_text(encoding="utf-8"))
            pages.update({name: CHECKOUT / name for name in linked if (CHECKOUT / name).is_file()})
    return pages


def _copied(folder: Path) -> dict[str, str]:
    """The digests of what was copied into a folder before; nothing where that cannot be read."""
    try:
        found = read_json(folder / _NOTES)
    except InputError:
        return {}
    return found if isinstance(found, dict) else {}


def _digest(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
