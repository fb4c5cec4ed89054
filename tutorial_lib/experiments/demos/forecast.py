"""How long a map takes to learn: from the lengths of its drives, corrected by the first ones."""

from __future__ import annotations

import numpy as np

from tutorial_lib.geometry import Array

_METRE, _AGAIN = 0.05, 0.02
"""Seconds on a usual laptop for each metre of a drive, and more for each metre where as many were
learned on a square metre before."""
_SPOKEN = 4.0  # seconds from one word to the next, at least


class Forecast:
    """Of the time that is left, while drives are learned one after the other."""

    def __init__(self, lengths: Array, area: float) -> None:
        """Forecast.

        Args:
            lengths: (D,) metres of the drives, in order.
            area: square metres of the plan: where there is little room, drives meet more often.
        """
        before = np.cumsum(lengths) - lengths
        self._costs = lengths * (_METRE + _AGAIN * before / area)
        self._metres, self._done, self._seconds, self._spoken = lengths, 0, 0.0, 0.0

    def learned(self, seconds: float) -> bool:
        """Note that one more drive was learned, and since when; whether to say what is left."""
        self._done, self._seconds = self._done + 1, seconds
        due = seconds - self._spoken >= _SPOKEN and self._done < len(self._costs)
        self._spoken = seconds if due else self._spoken
        return due

    @property
    def left(self) -> float:
        """Seconds: what the drives that are left cost, as those that were learned did."""
        known = self._costs[: self._done].sum()
        pace = self._seconds / known if self._done else 1.0
        return float(pace * self._costs[self._done :].sum())

    def words(self) -> str:
        """What is left, in metres and seconds."""
        left = self._metres[self._done :]
        drives = f"{len(left)} drives left, " if self._done else ""
        return f"{drives}{left.sum():.0f} m, about {max(self.left, 1):.0f} s"
