"""Widgets and what shows pictures and films as the output of a cell."""

from tutorial_lib.viz.notebook.display import play, show
from tutorial_lib.viz.notebook.tables import table
from tutorial_lib.viz.notebook.teleoperation import TeleopController
from tutorial_lib.viz.notebook.widgets import presses, sliders, teleop

__all__ = [
    "TeleopController",
    "play",
    "presses",
    "show",
    "sliders",
    "table",
    "teleop",
]
