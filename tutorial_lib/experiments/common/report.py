"""What every experiment and benchmark gives back: rows, as a table and as JSON."""

from __future__ import annotations

import argparse
import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Options:
    """What a run was asked for on the command line.

    Attributes:
        worlds: seeds of the worlds; empty for the experiment's own.
        seed: of everything that is random but the worlds.
        quick: fewer episodes, same code.
        map: a file to run on instead of generated worlds.
        ablation: which one to run instead of the whole experiment.
        palette: of generated worlds.
        agent: FILE.py:CLASS of a system, or a piece of one, to race with the others.
    """

    worlds: tuple[int, ...] = ()
    seed: int = 0
    quick: bool = False
    map: Path | None = None
    ablation: str = ""
    palette: str = "standard"
    agent: str = ""


@dataclass(frozen=True)
class Report:
    """The result of one run.

    Attributes:
        name: of the experiment or benchmark.
        seed: it was run with.
        worlds: seeds of the worlds.
        quick: whether fewer episodes were run.
        seconds: it took.
        rows: one for each line of the table; all have the same keys.
        notes: what to read below the table.
        map: the file's name, where it was run on one.
    """

    name: str
    seed: int
    worlds: tuple[int, ...]
    quick: bool
    seconds: float
    rows: list[dict[str, Any]]
    notes: tuple[str, ...] = ()
    map: str = ""

    def as_dict(self) -> dict[str, Any]:
        """For JSON, which has no word for what is not a number: that is None."""
        told = asdict(self)
        told["rows"] = [{key: _finite(value) for key, value in row.items()} for row in self.rows]
        return told

    def as_text(self) -> str:
        """A table that a person can read; lists are for the JSON only."""
        keys = [key for key, value in self.rows[0].items() if not isinstance(value, list)]
        cells = [keys, *([_shown(row[key]) for key in keys] for row in self.rows)]
        widths = [max(len(line[i]) for line in cells) for i in range(len(keys))]
        lines = ["  ".join(c.rjust(w) for c, w in zip(line, widths, strict=True)) for line in cells]
        lines.insert(1, "  ".join("-" * width for width in widths))
        return "\n".join([*lines, *self.notes, f"({self.name}: {self.seconds:.0f} s)"])


def parse_worlds(text: str) -> tuple[int, ...]:
    """World seeds from "A:B", which means A to B - 1."""
    try:
        first, last = (int(part) for part in text.split(":"))
    except ValueError:
        first, last = 0, 0
    if not 0 <= first < last:
        raise argparse.ArgumentTypeError(f"{text!r}: give A:B with 0 <= A < B, as in 20000:20020")
    return tuple(range(first, last))


def _finite(value: Any) -> Any:  # noqa: ANN401 - whatever stands in a row
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _shown(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, float):
        return f"{value:,.0f}" if abs(value) >= 1000 else f"{value:.4g}"
    return str(value)
