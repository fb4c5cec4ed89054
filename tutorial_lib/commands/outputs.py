"""Outputs of a notebook's cells without their widgets, which end with their kernel."""

import re
from typing import Any

WIDGET = "application/vnd.jupyter.widget-view+json"
"""The kind of output that a widget is."""
_BAR = re.compile(r"\[00:00.*it/s\]")


def without_widgets(outputs: list[Any]) -> list[Any]:
    """The outputs, in which the picture or text that a widget leaves stands alone; no bars.

    Args:
        outputs: of a cell, as nbformat has them; are changed.
    """
    kept = without_bars(outputs)
    for output in kept:
        output.get("data", {}).pop(WIDGET, None)
    return kept


def without_bars(outputs: list[Any]) -> list[Any]:
    """The outputs but for progress bars; as widgets they heed no TQDM_DISABLE, and stay at 0%."""
    return [output for output in outputs if not _is_bar(output.get("data", {}))]


def _is_bar(data: dict[str, Any]) -> bool:
    return WIDGET in data and _BAR.search(str(data.get("text/plain"))) is not None
