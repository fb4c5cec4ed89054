"""Navigation on film, and maps at which one tampers."""

from tutorial_lib.experiments.demos.navigation_demo import navigate_once
from tutorial_lib.experiments.demos.tampering import TamperedMap
from tutorial_lib.experiments.demos.task import place_people

__all__ = ["TamperedMap", "navigate_once", "place_people"]
