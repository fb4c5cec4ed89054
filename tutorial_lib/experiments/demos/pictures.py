"""Two films beside each other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from tutorial_lib.viz.canvas.plan_view import Picture
from tutorial_lib.viz.figures.panels import side_by_side

_BESIDE = 570  # pixels of height where agent and oracle are shown beside each other


class Frames(Protocol):
    """Pictures, perhaps each drawn on request."""

    def __len__(self) -> int: ...

    def __getitem__(self, index: int, /) -> Picture: ...


@dataclass(frozen=True)
class Beside:
    """The frames of a film, and beside each the frame of another; the shorter one waits.

    Attributes:
        first: grows while its robot drives.
        second: may be empty; then the first is shown alone.
    """

    first: Frames
    second: Frames

    def __len__(self) -> int:
        return max(len(self.first), len(self.second))

    def __getitem__(self, index: int) -> Picture:
        mine = self.first[min(index, len(self.first) - 1)]
        if not len(self.second):
            return mine
        other = self.second[min(index, len(self.second) - 1)]
        return side_by_side([mine, other], height=_BESIDE, gap=20)
