"""The stored results that come with the library and that notebooks show."""

import math
from pathlib import Path
from typing import Any

from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.report import FORMS, Finding, Report
from tutorial_lib.reading.documents import read_json
from tutorial_lib.validation import instance, path_of

FOLDER = Path(__file__).resolve().parents[2] / "results"


def load_result(name: str, folder: Path = FOLDER) -> Report:
    """Load the stored results of an experiment or benchmark.

    Raises:
        InputError: when there are none, or the file is damaged.
    """
    folder = path_of("folder", folder)
    path = folder / f"{instance('name', name, str)}.json"
    if not path.exists():
        known = ", ".join(sorted(file.stem for file in folder.glob("*.json"))) or "none"
        raise InputError(
            f"name: no {name!r} among the results in folder {folder}; there are {known}"
        )
    text = read_json(path, "not a result; restore the file")
    try:
        _check(text)
        findings = tuple(Finding(**finding) for finding in text["findings"])
        lists = {"worlds": tuple(text["worlds"]), "notes": tuple(text["notes"])}
        return Report(**(text | lists | {"findings": findings}))
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(f"{path}: not a result ({error}); restore the file") from error


def _check(text: Any) -> None:  # noqa: ANN401 - anything JSON can hold
    """Check the types of a report, and that all rows of its table have the same columns."""
    fits = {
        "name": isinstance(text["name"], str),
        "seed": type(text["seed"]) is int,
        "worlds": _is_list(text["worlds"], int),
        "quick": isinstance(text["quick"], bool),
        "seconds": type(text["seconds"]) in (int, float) and 0 <= text["seconds"] < math.inf,
        "rows": _is_list(text["rows"], dict) and len(text["rows"]) > 0,
        "findings": _is_list(text["findings"], dict) and all(map(_is_finding, text["findings"])),
        "notes": _is_list(text["notes"], str),
        "map": isinstance(text.get("map", ""), str),
        "made_from": isinstance(text.get("made_from", {}), dict),
    }
    wrong = ", ".join(key for key, good in fits.items() if not good)
    if wrong:
        raise InputError(f"{wrong}: of another type, or empty")
    for number, row in enumerate(text["rows"]):
        if row.keys() != text["rows"][0].keys():
            raise InputError(f"rows[{number}]: has other columns than the first row")
        for key, value in row.items():
            if isinstance(value, float) and not math.isfinite(value):
                raise InputError(f"rows[{number}].{key}: {value} is no number")


def _is_finding(found: dict[str, Any]) -> bool:
    """Whether its words and numbers can be those of a `Finding`."""
    numbers = [found[key] for key in ("value", "low", "high") if found[key] is not None]
    said = isinstance(found["what"], str) and found["form"] in FORMS
    return said and all(type(one) in (int, float) and math.isfinite(one) for one in numbers)


def _is_list(value: object, kind: type) -> bool:
    return isinstance(value, list) and all(type(item) is kind for item in value)
