"""What is loaded, and what can come of it."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

SECONDS = 10.0
"""Of computing that a case may take."""
WAIT = 120.0
"""Seconds on the clock that it may wait for something, computing nothing."""
GIGABYTE = 10**9
"""Bytes that a case may need, besides those of the process."""
LOADED, ALTERED, REFUSED = "loaded", "altered", "refused"
FOREIGN, HANG, MEMORY, WRONG = "FOREIGN", "HANG", "MEMORY", "WRONG"
GOOD, BAD = (LOADED, ALTERED, REFUSED), (FOREIGN, HANG, MEMORY, WRONG)
"""Outcomes: what was saved was loaded; something else from a file without a checksum, or with a
right one; an `InputError` of one line; any other error; too long; too much memory; something else
from a file with a checksum."""


@dataclass(frozen=True)
class Outcome:
    """What came of a case.

    Attributes:
        target: name of the loader.
        change: that was made to one of its files, in words.
        verdict: one of `GOOD` or `BAD`.
        words: the error's.
        seconds: of computing.
        megabytes: that the process grew by, at most.
    """

    target: str
    change: str
    verdict: str
    words: str = ""
    seconds: float = 0.0
    megabytes: float = 0.0


@dataclass(frozen=True)
class Target:
    """A loader.

    Attributes:
        name: of it.
        make: writes files that it reads into a folder.
        load: reads them again.
        sealed: what the names of files end in of which every altered byte must be noticed.
    """

    name: str
    make: Callable[[Path], object]
    load: Callable[[Path], Any]
    sealed: tuple[str, ...] = ()
