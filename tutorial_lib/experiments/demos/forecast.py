"""How long work in parts takes: from what each part costs, corrected by the first that are done."""

from collections.abc import Sequence

import numpy as np

from tutorial_lib.geometry import Array

_METRE, _ANCHOR, _ASKED = 0.0114, 0.021, 0.0028
"""Seconds on an idle laptop for each metre of a drive and for each of its anchors; and for each
metre along which RE is asked."""
_ANCHORS = (0.97, 0.99, 0.997), (5.0, 3.0, 0.2)
"""RE over a step of `sureness.STEP` frames, and how many of these become anchors."""
_SPOKEN = 4.0  # seconds from one word to the next, at least


class Forecast:
    """Of the time that is left, while parts are done one after the other."""

    def __init__(self, costs: Array, pace: float = 1.0) -> None:
        """Forecast.

        Args:
            costs: (P,) seconds of each part on an idle laptop, in order.
            pace: times as long that this machine takes, until a part is done.
        """
        self._costs, self._pace = costs, pace
        self._finished, self._seconds, self._spoken = 0, 0.0, 0.0

    def done(self, seconds: float) -> bool:
        """Note that one more part was done, after so many seconds; whether to say what is left.

        It is said after the first part, and then from time to time.
        """
        self._finished, self._seconds = self._finished + 1, seconds
        due = self._finished == 1 or seconds - self._spoken >= _SPOKEN
        self._spoken = seconds if due else self._spoken
        return due and self._finished < len(self._costs)

    @property
    def left(self) -> float:
        """Seconds: what the parts that are left cost, at the pace of those that are done."""
        pace = self._seconds / self._costs[: self._finished].sum() if self._finished else self._pace
        return float(pace * self._costs[self._finished :].sum())

    def words(self) -> str:
        """What is left, in seconds."""
        return f"about {max(self.left, 1.0):.0f} s"


class DrivesForecast(Forecast):
    """The same while a map learns drives."""

    def __init__(
        self, lengths: Sequence[float], sure: Sequence[Array], asked: float | None = None
    ) -> None:
        """Forecast.

        Args:
            lengths: (D,) metres of the drives, in order.
            sure: (S,) of each drive, RE from step to step: where it is low, more has to be learned.
            asked: seconds that it took to ask for that, by which a busy machine is known.
        """
        self._metres = np.array(lengths, dtype=float)
        anchors = [float(np.interp(one, *_ANCHORS).sum()) for one in sure]
        usual = _ASKED * self._metres.sum()
        pace = 1.0 if asked is None else asked / usual
        super().__init__(_METRE * self._metres + _ANCHOR * np.array(anchors), pace)

    def words(self) -> str:
        """What is left, in drives, metres and seconds."""
        left = self._metres[self._finished :]
        drives = f"{len(left)} drives left, " if self._finished else ""
        return f"{drives}{left.sum():.0f} m, {super().words()}"
