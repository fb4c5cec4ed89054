"""The stored results that come with the library and that notebooks show."""

import json
from pathlib import Path

from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.report import Report

FOLDER = Path(__file__).resolve().parents[2] / "results"


def load_result(name: str, folder: Path = FOLDER) -> Report:
    """Load the stored results of an experiment or benchmark.

    Raises:
        InputError: when there are none, or the file is damaged.
    """
    path = folder / f"{name}.json"
    try:
        text = json.loads(path.read_text(encoding="utf-8"))
        return Report(**(text | {"worlds": tuple(text["worlds"]), "notes": tuple(text["notes"])}))
    except FileNotFoundError:
        known = ", ".join(sorted(file.stem for file in folder.glob("*.json"))) or "none"
        raise InputError(f"results: no {name!r} in {folder}; there are {known}") from None
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(f"{path}: not a result ({error}); restore the file") from error
