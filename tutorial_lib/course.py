"""Where the course's folder is: its checkout or, of an installed course, where its pages lie."""

import os
import sys
from pathlib import Path

from tutorial_lib.errors import InputError

CHECKOUT = Path(__file__).resolve().parents[1]
"""The folder above the library: of an installed course, that of all packages."""
NAME = "topological-navigation"
"""Of the command, and of folders that belong to the course."""
CACHE = "TUTORIAL_CACHE"
"""The environment variable that names the folder of caches."""
_FIRST = Path("notebooks", "00_start_here.ipynb")


def is_checkout() -> bool:
    """Whether the library lies in its checkout."""
    return (CHECKOUT / "pyproject.toml").is_file() and (CHECKOUT / "start.py").is_file()


def find_course() -> Path | None:
    """The checkout or, of an installed course, the folder with its pages that one is in."""
    if is_checkout():
        return CHECKOUT
    here = Path.cwd()
    return next((folder for folder in (here, *here.parents) if (folder / _FIRST).is_file()), None)


def course_folder() -> Path:
    """The folder that `find_course` finds.

    Raises:
        InputError: when there is none.
    """
    folder = find_course()
    if folder is None:
        words = f"go to its folder, or copy it to here: {NAME} copy"
        raise InputError(f"{Path.cwd()}: the course's pages are not here; {words}")
    return folder


def cache_folder() -> Path:
    """Where files are kept that can be made again; it may not exist yet.

    The variable `TUTORIAL_CACHE` of the environment names it; else it is a folder of the course's
    own where the system wants such files.
    """
    if os.environ.get(CACHE):
        return Path(os.environ[CACHE]).expanduser()
    if sys.platform == "win32":
        usual = os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local"
    elif sys.platform == "darwin":
        usual = Path.home() / "Library" / "Caches"
    else:
        usual = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(usual) / NAME
