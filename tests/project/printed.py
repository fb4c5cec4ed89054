"""What the cells of a notebook print, and whether two runs of it print the same."""

import re
from html import unescape

TOLERANCE = 0.1
"""Relative: networks that a notebook trains come out a little otherwise on other processors."""
NUMBER = re.compile(r"[-+]?\d[\d,]*(?:\.\d+)?(?:e[-+]?\d+)?")
_TIME = re.compile(rf"{NUMBER.pattern}\s?(?:ms|s|seconds|min|minutes)\b")
_TAG = re.compile(r"<style>.*?</style>|<[^>]+>", re.DOTALL)
_SHOWN = ("text/html", "text/markdown", "text/plain")
_PLACE = re.compile(r"0x[0-9a-f]+|(?<=^Python )[\d.]+ at \S+", re.MULTILINE)
"""An address, or this machine's Python."""


def printed(cell):
    """The text that a cell has put out: printed, or shown as a table, a text or a value.

    Pictures, widgets and progress bars have none; of a value with a table the table counts.
    """
    parts = []
    for output in cell.get("outputs", []):
        if output.output_type == "stream" and output.name == "stdout":
            parts.append(output.text)
        data = output.get("data", {})
        if not any(kind.startswith(("image/", "application/")) for kind in data):
            kind = next((kind for kind in _SHOWN if kind in data), None)
            if kind is not None:
                parts.append(unescape(_TAG.sub(" ", data[kind])))
    return _PLACE.sub("", "\n".join(parts))


def differences(before, now):
    """Lines that differ: in a word, or in a number by more than `TOLERANCE`; times may differ."""
    old, new = (
        [line.split() for line in _TIME.sub("TIME", text).splitlines() if line.strip()]
        for text in (before, now)
    )
    if len(old) != len(new):
        return [f"{len(old)} lines, now {len(new)}"]
    return [
        f"{' '.join(was)!r}, now {' '.join(is_now)!r}"
        for was, is_now in zip(old, new, strict=True)
        if not _alike(" ".join(was), " ".join(is_now))
    ]


def _alike(was, is_now):
    if NUMBER.split(was) != NUMBER.split(is_now):
        return False
    pairs = zip(NUMBER.findall(was), NUMBER.findall(is_now), strict=True)
    return all(_near(*pair) for pair in pairs)


def _near(was, is_now):
    a, b = (float(text.replace(",", "")) for text in (was, is_now))
    last = 10.0 ** -max(len(text.partition(".")[2]) for text in (was, is_now))
    return abs(a - b) <= TOLERANCE * max(abs(a), abs(b)) + 1.001 * last
