"""What stands in a room, and how large it is. All lengths in metres."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

GAP = 0.03
"""Metres between a piece and the wall or the next piece."""

Range = tuple[float, float]

#        width along the wall   depth
SIZES: dict[str, tuple[Range, Range]] = {
    "armchair": ((0.75, 0.9), (0.75, 0.9)),
    "bathtub": ((1.5, 1.7), (0.7, 0.8)),
    "bed": ((1.4, 1.8), (2.0, 2.1)),
    "box": ((0.4, 0.7), (0.35, 0.6)),
    "cabinet": ((0.8, 1.4), (0.4, 0.5)),
    "chair": ((0.42, 0.48), (0.42, 0.48)),
    "chest": ((0.8, 1.1), (0.28, 0.34)),
    "coffee table": ((0.8, 1.2), (0.5, 0.6)),
    "copier": ((0.6, 0.75), (0.6, 0.7)),
    "counter": ((0.9, 2.2), (0.6, 0.62)),
    "desk": ((1.2, 1.6), (0.65, 0.8)),
    "dining table": ((1.4, 2.0), (0.8, 1.0)),
    "fridge": ((0.6, 0.75), (0.6, 0.68)),
    "meeting table": ((1.8, 3.2), (0.9, 1.2)),
    "nightstand": ((0.4, 0.5), (0.38, 0.45)),
    "office chair": ((0.5, 0.58), (0.5, 0.58)),
    "plant": ((0.35, 0.5), (0.35, 0.5)),
    "round table": ((0.8, 1.1), (0.8, 1.1)),
    "shelf": ((0.8, 1.8), (0.3, 0.4)),
    "sink": ((0.5, 0.8), (0.42, 0.5)),
    "sofa": ((1.7, 2.3), (0.85, 0.95)),
    "stove": ((0.6, 0.62), (0.6, 0.62)),
    "toilet": ((0.38, 0.42), (0.6, 0.68)),
    "wardrobe": ((1.2, 2.0), (0.58, 0.65)),
}
ROUND = ("plant", "round table")
"""Kinds drawn as octagons."""


@dataclass(frozen=True)
class Part:
    """A piece in the frame of its group: x along the wall from the middle, y away from the wall.

    Attributes:
        kind: of furniture.
        x, y: its middle, in metres.
        width, depth: in metres along x and y.
        turn: radians counter-clockwise, about its middle.
    """

    kind: str
    x: float
    y: float
    width: float
    depth: float
    turn: float = 0.0


Group = Callable[[np.random.Generator], list[Part]]


def row(*kinds: str) -> Group:
    """Pieces side by side along the wall."""

    def draw(rng: np.random.Generator) -> list[Part]:
        sizes = [_size(rng, kind) for kind in kinds]
        x = -(sum(width for width, _ in sizes) + GAP * (len(sizes) - 1)) / 2
        parts = []
        for kind, (width, depth) in zip(kinds, sizes, strict=True):
            parts.append(Part(kind, x + width / 2, GAP + depth / 2, width, depth))
            x += width + GAP
        return parts if rng.random() < 0.5 else [_mirrored(part) for part in parts]

    return draw


def facing(back: str, front: str, gap: Range) -> Group:
    """A piece at the wall, and another in front of it at some metres' distance."""

    def draw(rng: np.random.Generator) -> list[Part]:
        (width, depth), (w, d) = _size(rng, back), _size(rng, front)
        y = GAP + depth + rng.uniform(*gap) + d / 2
        shift = rng.uniform(-0.15, 0.15)
        turn = rng.uniform(-0.3, 0.3) if "chair" in front else 0.0
        return [
            Part(back, 0.0, GAP + depth / 2, width, depth),
            Part(front, shift, y + _swing(w, turn), w, d, turn),
        ]

    return draw


def table(kind: str, seat: str) -> Group:
    """A table with seats along both long sides."""

    def draw(rng: np.random.Generator) -> list[Part]:
        width, depth = _size(rng, kind)
        w, d = _size(rng, seat)
        y = GAP + d + GAP + depth / 2 + 0.06
        count = max(int(width / (w + 0.2)), 1)
        parts = [Part(kind, 0.0, y, width, depth)]
        for i in range(count):
            x = ((i + 0.5) / count - 0.5) * width
            for side in (-1, 1):
                turn = rng.uniform(-0.12, 0.12)
                away = depth / 2 + GAP + d / 2 + _swing(w, turn)
                parts.append(Part(seat, x, y + side * away, w, d, turn))
        return parts

    return draw


GROUPS: dict[str, Group] = {
    **{kind: row(kind) for kind in SIZES},
    "desk and chair": facing("desk", "office chair", (0.05, 0.12)),
    "sofa and table": facing("sofa", "coffee table", (0.3, 0.42)),
    "bed and nightstands": row("nightstand", "bed", "nightstand"),
    "bed and nightstand": row("bed", "nightstand"),
    "kitchen row": row("fridge", "counter", "stove"),
    "short kitchen row": row("fridge", "stove"),
    "dining group": table("dining table", "chair"),
    "meeting group": table("meeting table", "office chair"),
}

SIMPLER: dict[str, tuple[str, ...]] = {
    "bed and nightstands": ("bed and nightstand", "bed"),
    "desk and chair": ("desk",),
    "kitchen row": ("short kitchen row",),
    "meeting group": ("dining group", "round table"),
    "sofa and table": ("sofa",),
}
"""What a room gets where there is no place for a group."""


@dataclass(frozen=True)
class Furnishing:
    """What a kind of room gets: everything in `always`, then of `often` one for each `each` m²."""

    always: tuple[str, ...]
    often: tuple[str, ...]
    each: float


FURNISHING: dict[str, Furnishing] = {
    "hallway": Furnishing((), ("chest", "plant", "chest", "shelf"), 9.0),
    "passage": Furnishing((), ("box", "plant", "chest"), 14.0),
    "living": Furnishing(
        ("sofa and table", "shelf"),
        ("armchair", "shelf", "cabinet", "plant", "dining group", "sofa", "round table"),
        5.5,
    ),
    "kitchen": Furnishing(
        ("kitchen row",), ("dining group", "cabinet", "counter", "round table", "plant"), 5.0
    ),
    "bedroom": Furnishing(
        ("bed and nightstands", "wardrobe"),
        ("desk and chair", "shelf", "cabinet", "armchair", "plant", "chest"),
        5.5,
    ),
    "bathroom": Furnishing(("toilet", "sink"), ("bathtub", "cabinet", "sink", "plant"), 3.0),
    "office": Furnishing(
        ("desk and chair", "shelf"), ("desk and chair", "cabinet", "shelf", "plant", "chair"), 4.5
    ),
    "meeting": Furnishing(("meeting group",), ("cabinet", "plant", "shelf", "chair"), 7.0),
    "open plan": Furnishing(
        ("desk and chair", "desk and chair", "copier"),
        ("desk and chair", "desk and chair", "desk and chair", "shelf", "cabinet", "plant"),
        4.5,
    ),
    "lounge": Furnishing(
        ("sofa and table",), ("armchair", "round table", "plant", "shelf", "chair"), 5.0
    ),
    "storage": Furnishing(("shelf", "shelf"), ("box", "box", "shelf", "cabinet", "box"), 1.8),
    "open": Furnishing(("plant",), ("chair", "box", "round table", "plant", "shelf"), 12.0),
}
CENTRAL = ("dining group", "meeting group", "round table")
"""Groups that may stand in the middle of a room."""


def _size(rng: np.random.Generator, kind: str) -> tuple[float, float]:
    width, depth = SIZES[kind]
    return round(rng.uniform(*width), 2), round(rng.uniform(*depth), 2)


def _swing(width: float, turn: float) -> float:
    """How much further a turned piece must stand, in metres, so that its corners stay clear."""
    return width / 2 * abs(float(np.sin(turn)))


def _mirrored(part: Part) -> Part:
    return Part(part.kind, -part.x, part.y, part.width, part.depth, -part.turn)
