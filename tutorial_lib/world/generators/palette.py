"""The palettes as data: colours, features on the walls of each kind of room, looks of furniture.

Standard hues lie in 0-62, 105-145 and 190-232 degrees, shifted hues only in the gaps between, and
what is white or grey in the standard palette has a tint in the shifted one.
"""

from dataclasses import dataclass

Range = tuple[float, float]
Hsv = tuple[Range, Range, Range]
"""Ranges of hue in degrees, saturation and value in percent."""

# fmt: off
COLOURS: dict[str, tuple[Hsv, Hsv]] = {
    #               standard: hue, saturation, value      shifted
    "white":       (((30, 60),   ( 0,  6), (90, 98)), ((255, 335), (14, 22), (80, 95))),
    "grey":        (((195, 230), ( 2,  8), (60, 80)), ((158, 180), (16, 30), (50, 72))),
    "neutral":     (((28, 50),   ( 6, 15), (68, 86)), ((300, 340), (18, 30), (55, 80))),
    "pale yellow": (((44, 58),   (22, 42), (86, 97)), ((74, 94),   (35, 55), (70, 90))),
    "tile blue":   (((194, 214), (10, 28), (86, 98)), ((268, 292), (22, 40), (75, 92))),
    "deep blue":   (((200, 222), (40, 65), (55, 80)), ((248, 268), (50, 75), (45, 70))),
    "rose":        (((4, 22),    (18, 36), (84, 96)), ((158, 178), (30, 50), (65, 85))),
    "peach":       (((22, 36),   (25, 45), (82, 95)), ((312, 338), (30, 50), (65, 85))),
    "terracotta":  (((10, 24),   (40, 60), (60, 80)), ((286, 310), (40, 60), (50, 70))),
    "sand":        (((34, 46),   (25, 42), (74, 90)), ((160, 182), (40, 60), (45, 65))),
    "brown":       (((18, 32),   (35, 55), (42, 62)), ((76, 96),   (45, 65), (30, 50))),
    "wood":        (((20, 34),   (40, 65), (40, 70)), ((262, 290), (35, 60), (35, 60))),
    "dark":        (((15, 40),   (20, 50), (12, 28)), ((250, 300), (50, 80), (15, 30))),
    "metal":       (((200, 225), ( 3, 10), (40, 65)), ((160, 180), (25, 40), (30, 55))),
    "sky":         (((196, 214), (30, 50), (90, 99)), ((72, 96),   (20, 35), (92, 99))),
    "red":         (((0, 12),    (65, 90), (60, 95)), ((330, 345), (70, 95), (60, 95))),
    "orange":      (((18, 34),   (70, 95), (80, 99)), ((300, 318), (65, 95), (70, 99))),
    "yellow":      (((46, 60),   (60, 90), (85, 99)), ((70, 84),   (70, 95), (80, 99))),
    "green":       (((108, 142), (40, 75), (35, 75)), ((158, 180), (70, 95), (45, 85))),
    "blue":        (((205, 230), (55, 90), (45, 90)), ((246, 262), (60, 95), (50, 95))),
    "black":       (((0, 60),    ( 0, 10), ( 5, 14)), ((270, 330), (60, 90), ( 8, 18))),
    "floor":       (((18, 40),   (15, 45), (35, 60)), ((250, 330), (20, 45), (30, 60))),
    "ceiling":     (((30, 60),   ( 0,  6), (80, 92)), ((150, 180), (12, 30), (55, 80))),
}
# fmt: on
GAMMA: tuple[tuple[Range, ...], tuple[Range, ...]] = (((0.92, 1.08),), ((0.7, 0.8), (1.3, 1.5)))
"""Ranges of gamma in the standard and in the shifted palette; one of the ranges is drawn."""
NOISE: tuple[Range, Range] = ((0.0, 3.0), (6.0, 12.0))
"""Grey levels of grain in the standard and in the shifted palette."""
PALETTES = ("standard", "shifted")

BRIGHT = ("red", "orange", "yellow", "green", "blue", "white", "black")
BOOKS = ("red", "green", "blue", "brown", "sand", "black", "white")
FABRIC = ("rose", "peach", "terracotta", "deep blue", "green")


@dataclass(frozen=True)
class Feature:
    """Something on a wall: a frame, and fields of colour in it.

    Attributes:
        width: metres along the wall, small ones more often.
        fields: least and greatest number of fields.
        colours: names of the fields' colours.
        frame: name of the frame's colour; without one, the fields touch.
    """

    width: Range
    fields: tuple[int, int]
    colours: tuple[str, ...]
    frame: str = ""


FEATURES: dict[str, Feature] = {
    "poster": Feature((0.3, 1.5), (2, 5), BRIGHT),
    "picture": Feature((0.3, 0.8), (1, 3), BRIGHT, "dark"),
    "window": Feature((0.8, 2.0), (2, 3), ("sky",), "white"),
    "curtain": Feature((0.25, 0.6), (3, 6), FABRIC),
    "bookcase": Feature((0.7, 1.6), (5, 10), BOOKS, "wood"),
    "board": Feature((0.3, 1.0), (1, 1), ("wood",), "brown"),
    "whiteboard": Feature((0.8, 1.6), (1, 1), ("white",), "metal"),
    "notice board": Feature((0.6, 1.3), (3, 7), ("brown", *BRIGHT), "wood"),
    "closed door": Feature((0.7, 0.9), (1, 2), ("wood",), "dark"),
    "mirror": Feature((0.4, 0.8), (1, 1), ("sky",), "metal"),
    "towel": Feature((0.2, 0.5), (1, 3), ("deep blue", "rose", "white", "green")),
    "tiles": Feature((0.4, 1.2), (3, 7), ("deep blue", "white", "terracotta", "pale yellow")),
    "utensils": Feature((0.3, 0.9), (4, 8), ("metal", "red", "dark", "wood"), "pale yellow"),
    "crates": Feature((0.4, 1.0), (2, 4), ("wood", "sand", "orange", "dark")),
    "pipe": Feature((0.06, 0.15), (1, 2), ("metal", "red", "white")),
    "hook": Feature((0.05, 0.12), (1, 1), ("dark", "metal", "wood")),
    "sign": Feature((0.1, 0.25), (1, 2), BRIGHT),
    "line": Feature((0.04, 0.10), (1, 1), ("dark", "wood", "white")),
    "drawer": Feature((0.3, 0.5), (1, 1), ("wood",), "dark"),
    "pillow": Feature((0.4, 0.6), (1, 2), ("white", "rose", "deep blue")),
    "cushion": Feature((0.3, 0.5), (1, 2), FABRIC),
    "leaf": Feature((0.05, 0.15), (1, 2), ("green", "dark", "brown")),
    "label": Feature((0.08, 0.25), (1, 3), ("white", "black", "red")),
}


@dataclass(frozen=True)
class Strip:
    """How walls or furniture look: a base colour, and features at irregular distances.

    Attributes:
        base: names of base colours, one of which is drawn.
        features: names of features with how often each is drawn.
        gap: metres between features.
        tiles: metres between the thin lines of a regular pattern; 0 for none.
    """

    base: tuple[str, ...]
    features: dict[str, float]
    gap: Range = (0.06, 0.3)
    tiles: Range = (0.0, 0.0)


WALLS: dict[str, Strip] = {
    "hallway": Strip(
        ("neutral",), {"picture": 3, "closed door": 2, "notice board": 1.5, "sign": 3, "hook": 2}
    ),
    "passage": Strip(
        ("neutral", "sand", "grey"),
        {"poster": 3, "picture": 2, "notice board": 1, "closed door": 1, "sign": 3, "pipe": 2},
    ),
    "living": Strip(
        ("sand", "peach"), {"picture": 4, "bookcase": 2, "window": 1.5, "curtain": 3, "line": 4}
    ),
    "kitchen": Strip(
        ("pale yellow",),
        {"tiles": 3, "utensils": 2, "board": 2, "window": 1, "hook": 3, "sign": 1},
        tiles=(0.4, 0.6),
    ),
    "bedroom": Strip(
        ("rose", "peach"), {"picture": 3, "curtain": 3, "window": 1, "poster": 1.5, "line": 3}
    ),
    "bathroom": Strip(
        ("tile blue", "white"), {"mirror": 2, "towel": 4, "hook": 3, "tiles": 1}, tiles=(0.2, 0.3)
    ),
    "office": Strip(
        ("grey", "white"),
        {"whiteboard": 1, "window": 1.5, "poster": 2, "notice board": 1, "sign": 3, "line": 3},
    ),
    "meeting": Strip(
        ("grey", "white"), {"whiteboard": 3, "poster": 2, "window": 1.5, "sign": 4, "line": 4}
    ),
    "open plan": Strip(
        ("grey", "white"), {"window": 2, "notice board": 2, "poster": 2, "sign": 4, "line": 4}
    ),
    "lounge": Strip(
        ("neutral", "sand"), {"poster": 3, "picture": 3, "window": 1, "curtain": 2, "sign": 3}
    ),
    "storage": Strip(("brown",), {"crates": 4, "board": 3, "pipe": 3, "sign": 2}),
    "open": Strip(
        ("neutral", "terracotta", "sand"),
        {"poster": 4, "picture": 3, "window": 1, "bookcase": 1, "sign": 4, "pipe": 2},
    ),
    "hall": Strip(
        ("neutral", "grey", "white", "sand"),
        {"sign": 3, "pipe": 3, "closed door": 2, "window": 1, "poster": 1, "crates": 1, "board": 1},
        (0.3, 3.5),
    ),
    "door frame": Strip(("dark", "wood"), {"line": 1}, (0.1, 0.3)),
}

_WOODEN = Strip(("wood", "brown"), {"line": 3, "drawer": 1}, (0.2, 0.6))
_SOFT = Strip(FABRIC, {"cushion": 2, "line": 1}, (0.1, 0.5))
_WHITE = Strip(("white",), {"line": 2, "hook": 1}, (0.2, 0.7))

FURNITURE: dict[str, Strip] = {
    "armchair": _SOFT,
    "bathtub": _WHITE,
    "bench": Strip(("wood", "metal"), {"line": 2, "cushion": 1}, (0.2, 0.7)),
    "bed": Strip(("rose", "deep blue", "white"), {"pillow": 2, "line": 1}, (0.1, 0.5)),
    "box": Strip(("sand", "brown"), {"label": 2, "line": 1}, (0.1, 0.4)),
    "cabinet": Strip(("wood", "white", "grey"), {"drawer": 3, "label": 1}, (0.05, 0.3)),
    "chair": _WOODEN,
    "chest": Strip(("wood",), {"drawer": 3, "line": 1}, (0.05, 0.3)),
    "coffee table": _WOODEN,
    "copier": Strip(("grey",), {"label": 2, "line": 2, "sign": 1}, (0.1, 0.3)),
    "crate": Strip(("wood", "sand", "blue", "orange"), {"label": 2, "line": 2}, (0.15, 0.6)),
    "counter": Strip(("white", "wood"), {"drawer": 3, "hook": 1}, (0.05, 0.3)),
    "desk": Strip(("wood", "grey"), {"drawer": 2, "line": 1}, (0.2, 0.6)),
    "dining table": _WOODEN,
    "fridge": Strip(("metal", "white"), {"label": 2, "hook": 1}, (0.15, 0.4)),
    "machine": Strip(
        ("metal", "grey", "green", "blue"),
        {"label": 2, "sign": 2, "pipe": 2, "line": 1},
        (0.2, 0.9),
    ),
    "meeting table": _WOODEN,
    "nightstand": Strip(("wood", "white"), {"drawer": 2}, (0.05, 0.2)),
    "office chair": Strip(("black", "blue", "metal"), {"line": 1}, (0.2, 0.5)),
    "pallet": Strip(("wood", "sand"), {"crates": 3, "label": 2, "line": 1}, (0.05, 0.5)),
    "pillar": Strip(("grey", "white", "neutral"), {"sign": 2, "line": 1}, (0.3, 1.2)),
    "plant": Strip(("green",), {"leaf": 1}, (0.03, 0.15)),
    "rack": Strip(
        ("metal", "wood", "orange", "blue"),
        {"crates": 4, "label": 3, "board": 1, "sign": 1},
        (0.05, 0.9),
    ),
    "round table": _WOODEN,
    "shelf": Strip(("wood", "brown"), {"bookcase": 3, "board": 1, "crates": 1}, (0.03, 0.2)),
    "sink": _WHITE,
    "sofa": _SOFT,
    "stove": Strip(("metal", "black"), {"label": 1, "line": 2, "hook": 2}, (0.1, 0.3)),
    "toilet": _WHITE,
    "wardrobe": Strip(("wood", "white"), {"closed door": 2, "drawer": 1}, (0.03, 0.2)),
}
