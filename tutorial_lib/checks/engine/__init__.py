"""An exercise as a specification: its rule, cases, and mistakes as edits of the rule.

It is also the door to what most exercises need of `checks.framework`.
"""

from tutorial_lib.checks.engine.edits import edited, mistakes_of
from tutorial_lib.checks.engine.exercise import case, exercise
from tutorial_lib.checks.framework.answers import Mask, calling, keeping, mask, numbers, parts
from tutorial_lib.checks.framework.check import WrongAnswer, check
from tutorial_lib.checks.framework.comparison import close, farthest
from tutorial_lib.checks.framework.topics import hint, topics
from tutorial_lib.checks.framework.wording import kind

__all__ = [
    "Mask", "WrongAnswer", "calling", "case", "check", "close", "edited", "exercise",
    "farthest", "hint", "keeping", "kind", "mask", "mistakes_of", "numbers", "parts", "topics",
]  # fmt: skip
