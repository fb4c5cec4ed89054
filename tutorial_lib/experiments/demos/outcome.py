"""What a demo leaves behind: a film, a strip of pictures, and its figures."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from tutorial_lib.files import check_writable

FILM, STRIP, FIGURES = "demo.webm", "demo.png", "demo.json"


@dataclass(frozen=True)
class Drive:
    """How one policy did; lengths in metres, times in seconds."""

    reached: bool
    collided: bool
    seconds: float
    driven: float


@dataclass(frozen=True)
class Outcome(Drive):
    """What `demo.json` holds of the agent that navigates by sight.

    Attributes:
        geodesic: metres of the shortest path.
        probability: of the first plan.
        plans: their number.
        vertices: of the map.
        edges: of the map.
        oracle: how the oracle did on the same task, where one drove it.
    """

    name: str
    plan: str
    seed: int
    rooms: tuple[str, str]
    rooms_away: int
    geodesic: float
    people: int
    probability: float
    plans: int
    vertices: int
    edges: int
    oracle: Drive | None = None
    film: str = FILM
    strip: str = STRIP


def check_folder(folder: Path) -> None:
    """Check that a demo can leave its files in `folder`.

    Raises:
        InputError: when it cannot.
    """
    for name in (FILM, STRIP, FIGURES):
        check_writable(folder / name)
