"""One navigation on film."""

from tutorial_lib.experiments.demos.navigation_demo import navigate_once
from tutorial_lib.experiments.demos.places import choose_places, place_people

__all__ = [
    "choose_places",
    "navigate_once",
    "place_people",
]
