"""How large the house is, and how often its rules are broken: ``python -m tests.house``."""

import ast
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
LIBRARY = ROOT / "tutorial_lib"
OUTER = ("experiments", "results", "demos")
"""Packages that hold experiments with their tasks, results and demos."""


def lines_of(*folders):
    """Lines and files of Python in folders."""
    files = [file for folder in folders for file in folder.rglob("*.py")]
    return sum(len(file.read_text().splitlines()) for file in files), len(files)


def count(pattern, folder):
    """How often a pattern occurs in the Python files of a folder."""
    return sum(len(re.findall(pattern, file.read_text())) for file in folder.rglob("*.py"))


def module_of(file):
    """The whole name of a module's file, or of its package's."""
    parts = list(file.relative_to(ROOT).with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def importers():
    """For each module of the library, the modules that import it."""
    files = {module_of(file): file for file in LIBRARY.rglob("*.py")}
    found = {name: set() for name in files}
    for name, file in files.items():
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.ImportFrom) and node.module:
                whole = [node.module, *(f"{node.module}.{one.name}" for one in node.names)]
                for other in whole:
                    if other in found and other != name:
                        found[other].add(name)
    return found


REGISTERS = ("experiments.registry", "experiments.results_page.page", "cli")
"""Modules that know all experiments, all tables of the page, all commands."""


def is_door(name):
    """Whether a name is that of a package, whose ``__init__`` says what others may use."""
    return (ROOT / Path(*name.split("."))).is_dir()


def is_register(name):
    """Whether what a module imports alone is an entry point: a door does, and a register."""
    return is_door(name) or name.removeprefix("tutorial_lib.") in REGISTERS


def past_a_door(found):
    """Imports from another package's module in place of the package itself."""

    def package(name):
        return ".".join(name.split(".")[:2])

    return sum(
        package(name) != package(other)
        for other, names in found.items()
        if other.count(".") > 1
        for name in names
    )


def prose():
    """Lines of f-strings with eight words or more in the experiments."""
    words = re.compile(r'f"(?=[^"]*(?:\b[a-z]+\b[^"]*?){8})')
    return count(words, LIBRARY / "experiments")


def type_errors():
    """How many errors pyrefly finds; a question mark where it is not installed."""
    command = [sys.executable, "-m", "pyrefly", "check", "--output-format", "omit-errors"]
    run = subprocess.run(
        [*command, "--python-interpreter-path", sys.executable],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    found = re.search(r"INFO ([\d,]+) errors?", run.stdout + run.stderr)
    return found[1] if found else "?"


def main():
    """Print the table."""
    found = importers()
    library, files = lines_of(LIBRARY)
    single = [
        min(importing)
        for name, importing in found.items()
        if len(importing) == 1 and not is_door(name)
    ]
    tests, wrong = lines_of(ROOT / "tests")[0], lines_of(ROOT / "tests" / "wrong_answers")[0]
    rows = {
        "library, lines / files": f"{library:,} / {files}",
        "checks, lines": f"{lines_of(LIBRARY / 'checks')[0]:,}",
        "fault ==": count(r"fault ==", LIBRARY / "checks"),
        "tests, lines": f"{tests:,}",
        "wrong answers, lines": f"{wrong:,}",
        "experiments with tasks, results, demos, lines": (
            f"{lines_of(*(LIBRARY / one for one in OUTER if (LIBRARY / one).is_dir()))[0]:,}"
        ),
        "prose in f-strings, lines": prose(),
        "imports past a door": past_a_door(found),
        "modules with a single importer": len(single),
        "of these, in no door or register": sum(not is_register(only) for only in single),
        "type errors": type_errors(),
        "type errors ignored": count(r"pyrefly: ignore", LIBRARY),
    }
    for what, number in rows.items():
        print(f"{what:46}{number!s:>14}")


if __name__ == "__main__":
    main()
