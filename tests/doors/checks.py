"""Doors of the checks: a check takes any answer, and says what is wrong with it."""

from tests.doors.test_doors import exports

JUDGED = "takes any answer: what is wrong with it is the verdict, see `tests/checks`"
DOORS = {}
WITHOUT = {name: JUDGED for package, name, _ in exports() if package == "checks"}
