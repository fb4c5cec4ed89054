"""An exercise as a specification: its rule, cases, and mistakes as edits of the rule."""

from tutorial_lib.checks.engine.edits import edited, mistakes_of
from tutorial_lib.checks.engine.exercise import case, exercise

__all__ = ["case", "edited", "exercise", "mistakes_of"]
