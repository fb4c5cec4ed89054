"""Says which packages an environment lacks: ``python -m tutorial_lib.commands.installed [EXTRA]``.

start.py asks this before each start. Nothing is imported but what is installed is looked at, which
takes a fraction of a second; importing torch alone would take several.
"""

import sys
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path

COURSE = "topological-visual-navigation"
COMPLETE = "complete"
_CODE = (".py", ".pth", ".so", ".pyd")


def lost(course: str = COURSE) -> list[str]:
    """The names of required packages that are missing, of a wrong version, or without their code.

    Args:
        course: a requirement; what it requires is looked at, too.
    """
    try:
        from packaging.requirements import Requirement
    except ImportError:
        return ["packaging"]
    found, seen, waiting = set(), set(), [Requirement(course)]
    while waiting:
        wanted = waiting.pop()
        if str(wanted) in seen:
            continue
        seen.add(str(wanted))
        package = next(iter(metadata.distributions(name=wanted.name, path=_folders())), None)
        if package is None:
            found.add(wanted.name)
            continue
        fields = list(_fields(package))
        version = dict(fields).get("Version", "")
        if not version or not wanted.specifier.contains(version, prereleases=True):
            found.add(wanted.name)
        if any(not Path(str(package.locate_file(path))).exists() for path in _code(package)):
            found.add(wanted.name)
        for needed in (Requirement(text) for key, text in fields if key == "Requires-Dist"):
            marker, extras = needed.marker, {"", *wanted.extras}
            if marker is None or any(marker.evaluate({"extra": extra}) for extra in extras):
                waiting.append(needed)
    return sorted(found)


def _folders() -> list[str]:
    """Where packages are looked for: not in the current folder, where pip leaves an egg-info."""
    return [folder for folder in sys.path if folder and Path(folder) != Path.cwd()]


def _fields(package: metadata.Distribution) -> Iterator[tuple[str, str]]:
    """The head of a package's METADATA, which `importlib` would parse together with its readme."""
    for line in (package.read_text("METADATA") or "").partition("\n\n")[0].splitlines():
        key, colon, text = line.partition(": ")
        if colon:
            yield key, text


def _code(package: metadata.Distribution) -> Iterator[str]:
    """The modules at the top of a package, and those in its outermost folder."""
    for line in (package.read_text("RECORD") or "").splitlines():
        path = line.partition(",")[0]
        if path.count("/") <= 1 and path.endswith(_CODE) and not path.startswith(("..", '"')):
            yield path


def main(extras: list[str]) -> None:
    """Print what the course with some of its extras lacks."""
    print(" ".join(lost(f"{COURSE}[{','.join(extras)}]")) or COMPLETE)


if __name__ == "__main__":
    main(sys.argv[1:])
