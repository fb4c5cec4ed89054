"""One colour for each kind of thing in all pictures (Okabe and Ito; colour-blind safe)."""

ROBOT = (0, 114, 178)
GOAL = (0, 158, 115)
PATH = (230, 159, 0)
TRACK = (86, 180, 233)
BELIEVED = (45, 48, 56)
LASER = (213, 94, 0)
VIEW = (240, 228, 66)
PERSON = (204, 121, 167)
INK = (45, 48, 56)
FAINT = (104, 110, 120)
PAPER = (255, 255, 255)
SOLID = (88, 92, 102)

THINGS = (ROBOT, GOAL, PATH, TRACK, LASER, VIEW, PERSON, INK, FAINT, PAPER, SOLID)
"""All of these, kept exactly where a picture has few colours (`film.png`)."""

ROOMS = {
    "hallway": (236, 236, 232),
    "living": (246, 234, 220),
    "kitchen": (250, 244, 214),
    "bedroom": (234, 230, 246),
    "bathroom": (220, 238, 246),
    "office": (230, 238, 228),
    "storage": (234, 226, 216),
    "open": (240, 240, 238),
}
"""Floor tints by the kind of room."""


def unit(colour: tuple[int, int, int]) -> tuple[float, float, float]:
    """A colour with parts from 0 to 1, as matplotlib wants it.

    >>> unit(PAPER)
    (1.0, 1.0, 1.0)
    """
    red, green, blue = colour
    return red / 255, green / 255, blue / 255
