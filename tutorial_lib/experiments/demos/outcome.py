"""What a demo leaves behind: a film, a strip of pictures, and its figures."""

from dataclasses import dataclass
from pathlib import Path

from tutorial_lib.files import check_writable
from tutorial_lib.geometry import Array

FILM, STRIP, FIGURES = "demo.webm", "demo.png", "demo.json"


@dataclass(frozen=True)
class Drive:
    """How one policy did; lengths in metres, times in seconds.

    Attributes:
        reached: it said that it was at the goal, and was.
        ending: what happened, in words.
        collided: it touched something.
        seconds: until the end.
        driven: metres.
    """

    reached: bool
    ending: str
    collided: bool
    seconds: float
    driven: float


@dataclass(frozen=True)
class Outcome(Drive):
    """What `demo.json` holds of the agent that navigates by sight.

    Attributes:
        name: of the demo.
        plan: name of the world.
        seed: of everything that is random.
        rooms: in which it begins and ends.
        rooms_away: doors between them.
        start: x, y and heading.
        goal: x, y and heading at which its image was taken.
        geodesic: metres of the shortest path.
        body: of the robot.
        camera: likewise.
        people: who walk beside the path.
        probability: of the first plan.
        plans: their number.
        drives: that were learned.
        composed_of: drives that the first plan leads over.
        map: the file of the learned map, or none where it was not kept.
        vertices: of the map.
        edges: of the map.
        oracle: how the oracle did on the same task, where one drove it.
    """

    name: str
    plan: str
    seed: int
    rooms: tuple[str, str]
    rooms_away: int
    start: tuple[float, float, float]
    goal: tuple[float, float, float]
    geodesic: float
    body: str
    camera: str
    people: int
    probability: float
    plans: int
    drives: int
    composed_of: int
    map: str | None
    vertices: int
    edges: int
    oracle: Drive | None = None
    film: str = FILM
    strip: str = STRIP


def rounded(pose: Array) -> tuple[float, float, float]:
    """A pose (3,) to centimetres and 0.01 rad."""
    x, y, heading = (round(float(number), 2) for number in pose)
    return x, y, heading


def check_folder(folder: Path) -> None:
    """Check that a demo can leave its files in `folder`.

    Raises:
        InputError: when it cannot.
    """
    for name in (FILM, STRIP, FIGURES):
        check_writable(folder / name)
