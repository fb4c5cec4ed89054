"""Doors of the builder: none, since a command alone calls it, on the sources of the project."""

from tutorial_lib import builder

SOURCES = "works on the sources of this project, which a command finds"
DOORS = {}
WITHOUT = dict.fromkeys(builder.__all__, SOURCES)
