"""Words that generated messages share."""

from typing import Any

_COUNTED = {0: "never", 1: "once", 2: "twice"}


def kind(value: Any) -> str:  # noqa: ANN401 - whatever students return
    """The type of a value with its article: "an int", "a list"; "None" for None."""
    name = type(value).__name__
    if value is None:
        return "None"
    return f"{'an' if name[0] in 'aeioAEIO' or name == 'ndarray' else 'a'} {name}"


def both(mine: float, right: float, digits: int = 4) -> tuple[str, str]:
    """Two numbers with as many digits as it takes to see that they differ.

    >>> both(0.25, 0.75), both(1 / 3, 1 / 3)
    (('0.25', '0.75'), ('0.3333', '0.3333'))
    >>> both(0.481400012, 0.4814)
    ('0.48140001', '0.4814')
    """
    for count in range(digits, 18):
        if f"{mine:.{count}g}" != f"{right:.{count}g}":
            return f"{mine:.{count}g}", f"{right:.{count}g}"
    return f"{mine:.{digits}g}", f"{right:.{digits}g}"


def times(count: int) -> str:
    """How often: "never", "once", "twice", "3 times"."""
    return _COUNTED.get(count, f"{count} times")


def number_of(count: int, one: str) -> str:
    """So many of something, of which one is called `one`: "1 step", "2 steps"."""
    return f"{count} {one}{'' if count == 1 else 's'}"
