"""What is done: exercises whose passed answer is saved in `my_answers`, and predictions made."""

import re
from dataclasses import dataclass
from pathlib import Path

from tutorial_lib.checks.framework import my_answers, record
from tutorial_lib.errors import InputError
from tutorial_lib.reading.documents import read_json
from tutorial_lib.reading.limits import MAX_NOTEBOOK
from tutorial_lib.reading.regular import read_text

_LONGEST_NAME = 100  # characters of an exercise's function


@dataclass(frozen=True)
class Done:
    """An exercise, and what became of it.

    Attributes:
        name: of the exercise.
        passed: what the saved answer says of itself; empty if there is none.
    """

    name: str
    passed: str


def progress(notebooks: Path) -> dict[str, list[Done]]:
    """The exercises of each notebook in a folder, in their order; its name is ``02_local_control``.

    Raises:
        InputError: when there are no notebooks, or one is damaged.
    """
    found = {
        file.stem: [Done(name, _passed(file.stem[:2], name)) for name in _exercises(file)]
        for file in sorted(notebooks.glob("[0-9][0-9]_*.ipynb"))
    }
    if not any(found.values()):
        raise InputError(f"{notebooks}: no notebooks with exercises; give the course's folder")
    return found


def report(found: dict[str, list[Done]]) -> str:
    """A table in words: for each notebook how many are done, each exercise, and predictions.

    Raises:
        InputError: when the file with the predictions is damaged.
    """
    lines = []
    for notebook, own in found.items():
        done = sum(bool(one.passed) for one in own)
        lines.append(f"{notebook}: {done} of {len(own)}" if own else f"{notebook}: no exercises")
        lines += [
            f"  {'x' if one.passed else '-'} {one.name:22} {one.passed}".rstrip() for one in own
        ]
        made = record.predictions(notebook[:2]).values()
        if made:
            right = sum(one.get("choice") == one.get("right") for one in made)
            lines.append(f"  predictions: {len(made)} made, {right} right")
    every = [one for own in found.values() for one in own]
    done = sum(bool(one.passed) for one in every)
    return "\n".join([*lines, f"{done} of {len(every)} exercises are done"])


def _exercises(file: Path) -> list[str]:
    try:
        cells = read_json(file, "restore it", MAX_NOTEBOOK)["cells"]
        names = [cell["metadata"]["exercise"] for cell in cells if "exercise" in cell["metadata"]]
    except InputError:
        raise
    except (KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{file}: damaged ({error!r}); restore it") from error
    for name in names:
        # It becomes the name of a file.
        if not (isinstance(name, str) and name.isidentifier() and len(name) <= _LONGEST_NAME):
            raise InputError(f"{file}: damaged (exercise {name!r:.40} is no function); restore it")
    return names


def _passed(notebook: str, name: str) -> str:
    """When the saved answer passed, and which version it is."""
    file = my_answers.path(notebook, name)
    if my_answers.folder() is None or not file.is_file():
        return ""
    first = read_text(file, advice="delete it and solve the exercise again").partition("\n")[0]
    found = re.search(r"# version (\d+) .* passed its check on (.+)", first)
    return f"{found[2]}, version {found[1]}" if found else "saved"
