"""A league table: scores of what a student designed, beside those to beat."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from tutorial_lib.checks.framework import record
from tutorial_lib.errors import InputError
from tutorial_lib.validation import instance
from tutorial_lib.viz.notebook.tables import Table, table


@dataclass(eq=False)
class League:
    """The scores of a notebook's challenge, the best first; kept in `my_answers`, never marked.

    Attributes:
        notebook: its number, as in "05".
        columns: of numbers, with their formats as in `table`; the last is the score.
        baselines: rows by name that are there from the beginning; the best is to be beaten.
        rows: names and numbers of what was entered.

    Raises:
        InputError: when a baseline has not a number for each column, or the kept scores are
            damaged.
    """

    notebook: str
    columns: Mapping[str, str]
    baselines: Mapping[str, Sequence[float]]
    rows: list[list[Any]] = field(default_factory=list, init=False)

    def __post_init__(self) -> None:
        for name, numbers in self.baselines.items():
            self._row(name, numbers)
        kept = record.scores(self.notebook)
        self.rows = [row for row in kept if len(row) == 1 + len(self.columns)]

    def enter(self, name: str, numbers: Sequence[float]) -> Table:
        """Enter a row, once, and show the table.

        Raises:
            InputError: when there is not a number for each column, or the row cannot be kept.
        """
        row = self._row(name, numbers)
        if row not in self.rows:
            self.rows.append(row)
            record.keep_score(self.notebook, row)
        return self.table()

    def table(self) -> Table:
        """All rows, the best score first."""
        given = [self._row(name, numbers) for name, numbers in self.baselines.items()]
        ranked = sorted([*self.rows, *given], key=lambda row: -row[-1])
        score, best = list(self.columns)[-1], max(given, key=lambda row: row[-1])
        lead = max((row[-1] for row in self.rows), default=best[-1]) - best[-1]
        caption = f"you lead by {lead:.3g}" if lead > 0 else f"to beat: {best[0]}, {best[-1]:g}"
        return table({"": "", **self.columns}, ranked, {score: max}, caption)

    def _row(self, name: str, numbers: Sequence[float]) -> list[Any]:
        if len(numbers) != len(self.columns):
            raise InputError(f"{name}: {len(numbers)} numbers; give {len(self.columns)}")
        return [instance("name", name, str), *(np.asarray(number).item() for number in numbers)]
