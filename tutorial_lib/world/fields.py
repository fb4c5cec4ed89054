"""Reading structured input so that an error names the field."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from tutorial_lib.errors import InputError


class Field:
    """A value of a JSON or YAML document together with its place, as in ``walls[3].from``."""

    def __init__(self, value: Any, where: str) -> None:  # noqa: ANN401 - anything JSON can hold
        self.value = value
        self.where = where

    def fail(self, need: str) -> InputError:
        """The error to raise: the value found, and what is needed instead."""
        try:
            shown = repr(self.value)
        except ValueError:  # Python prints no whole number of more than 4,300 digits
            shown = f"a very large {type(self.value).__name__}"
        return InputError(f"{self.where}: {shown[:60]}{'…' * (len(shown) > 60)}; {need}")

    def __contains__(self, key: str) -> bool:
        return isinstance(self.value, dict) and key in self.value

    def __getitem__(self, key: str) -> Field:
        if not isinstance(self.value, dict):
            raise self.fail("give a mapping of names to values")
        if key not in self.value:
            raise InputError(f"{self.where}: has no {key!r}; add it")
        root = self.where.endswith(("json", "yaml", "yml", "text"))
        return Field(self.value[key], f"{self.where}: {key}" if root else f"{self.where}.{key}")

    def __iter__(self) -> Iterator[Field]:
        if not isinstance(self.value, list):
            raise self.fail("give a list")
        for i, item in enumerate(self.value):
            yield Field(item, f"{self.where}[{i}]")

    def number(self) -> float:
        """A finite number."""
        good = isinstance(self.value, int | float) and not isinstance(self.value, bool)
        try:
            number = float(self.value) if good else math.nan
        except OverflowError:  # a whole number with hundreds of digits
            number = math.inf
        if not math.isfinite(number):
            raise self.fail("give a finite number")
        return number

    def whole(self) -> int:
        """A whole number."""
        if not isinstance(self.value, int) or isinstance(self.value, bool):
            raise self.fail("give a whole number")
        if abs(self.value) >= 2**63:
            raise self.fail("give a whole number of at most 18 digits")
        return self.value

    def text(self) -> str:
        """A string."""
        if not isinstance(self.value, str):
            raise self.fail("give text")
        try:
            self.value.encode()
        except UnicodeEncodeError:  # JSON can name one half of such a pair
            raise self.fail("give text without halves of characters") from None
        return self.value

    def numbers(self, count: int) -> tuple[float, ...]:
        """Exactly `count` finite numbers."""
        if not isinstance(self.value, list) or len(self.value) != count:
            raise self.fail(f"give {count} numbers")
        return tuple(item.number() for item in self)

    def point(self) -> tuple[float, float]:
        """Two finite numbers [x, y]."""
        x, y = self.numbers(2)
        return x, y

    def points(self) -> tuple[tuple[float, float], ...]:
        """A list of points."""
        return tuple(item.point() for item in self)
