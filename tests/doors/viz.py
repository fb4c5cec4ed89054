"""Doors of drawing."""

from tests.doors.test_doors import exports

DRAWN = "draws what is checked where it is made"
DOORS = {}
WITHOUT = {name: DRAWN for package, name, _ in exports() if package == "viz"}
