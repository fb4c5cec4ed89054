"""Writes the results page from its JSON files, or says which of them no longer fit."""

import argparse
import json
import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor

from tutorial_lib.commands import experiment
from tutorial_lib.commands.constants import WRONG_INPUT
from tutorial_lib.course import NAME, course_folder, is_checkout
from tutorial_lib.experiments import registry
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Report
from tutorial_lib.experiments.common.results import FOLDER
from tutorial_lib.experiments.provenance import CHANGED, FITS, checked, standing_of
from tutorial_lib.experiments.results_page.markdown import table
from tutorial_lib.experiments.results_page.page import PAGE, write_results
from tutorial_lib.experiments.results_page.sources import EXPERIMENTS, command_of, load_results
from tutorial_lib.files import write_text

BEGIN, END = "<!-- measuring: begin -->", "<!-- measuring: end -->"
"""Around the block of the project's README."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the option."""
    parser.add_argument(
        "--stale",
        action="store_true",
        help="list the results whose networks or code have changed, and tell by a few episodes of "
        "each whether its numbers have",
    )


def run(options: argparse.Namespace) -> int:
    """Write the page and what the README quotes, or check the results."""
    if options.stale:
        return check_results()
    folder = course_folder()
    blocks = [measuring_block()]
    for path in write_results(folder / "README.md", folder / PAGE, blocks=blocks):
        print(f"wrote {path.relative_to(folder)}")
    return 0


def check_results() -> int:
    """Say what no longer fits, and what to do about it."""
    again = unfit()
    for name in again:
        installed = f"{NAME} {EXPERIMENTS[name]} --json FILE"
        print(f"measure again: {command_of(name) if is_checkout() else installed}")
    return WRONG_INPUT if again else 0


def unfit() -> list[str]:
    """Names of the results that must be measured again.

    Of those whose code has changed, the canary tells whether the numbers have; where they have not,
    the result gets the fingerprints of today's code.
    """
    reports = load_results().reports
    standings = {name: standing_of(reports[name]) for name in EXPERIMENTS}
    off = {name: standing for name, standing in standings.items() if standing.kind != FITS}
    print(f"{len(EXPERIMENTS) - len(off)} of {len(EXPERIMENTS)} results fit networks and code")
    for name, standing in off.items():
        print(f"{name}: {standing.words}", flush=True)
    changed = [name for name, standing in off.items() if standing.kind == CHANGED]
    again = [name for name in off if name not in changed]
    with ThreadPoolExecutor(os.cpu_count()) as threads:
        found = threads.map(lambda name: checked(reports[name], *asked(name)), changed)
        for name, (report, words) in zip(changed, found, strict=True):
            print(f"{name}: {words or 'code changed, numbers did not'}", flush=True)
            if words:
                again.append(name)
            else:
                store(report, name)
    return again


def asked(name: str) -> tuple[str, Options]:
    """The command and the options of a stored result."""
    parser = argparse.ArgumentParser()
    experiment.add_arguments(parser)
    given = parser.parse_args(EXPERIMENTS[name].split()[1:])
    return given.name, experiment.options_of(given)


def store(report: Report, name: str) -> None:
    """Write a result where it is kept."""
    write_text(FOLDER / f"{name}.json", json.dumps(report.as_dict(), indent=1) + "\n")


def measuring_block() -> str:
    """The block of the project's README, markers included."""
    return "\n".join(
        [
            BEGIN,
            _folded(
                "Experiments, and the options that each takes", _measured(registry.EXPERIMENTS)
            ),
            _folded("Benchmarks", _measured(registry.BENCHMARKS)),
            _folded("What the options mean", table(["option", "meaning"], list(_options()))),
            END,
        ]
    )


def _folded(title: str, text: str) -> str:
    """Text behind a fold: Markdown within HTML needs empty lines around it."""
    return f"<details><summary>{title}</summary>\n\n{text}\n\n</details>\n"


def _measured(entries: dict[str, Experiment]) -> str:
    rows = [
        [f"`{name}`", experiment.measured_by(entry), _code(entry.options())]
        for name, entry in entries.items()
    ]
    return table(["name", "measures", "takes"], rows)


def _options() -> Iterator[tuple[str, str]]:
    """Each option of `experiment`, with what it is given, and its help."""
    parser = argparse.ArgumentParser(add_help=False)
    experiment.add_arguments(parser)
    for action in parser._actions:
        if action.option_strings:
            values = "" if action.choices is None else f"{{{','.join(action.choices)}}}"
            yield _code([*action.option_strings, str(action.metavar or values)]), action.help or ""


def _code(words: Sequence[str]) -> str:
    text = " ".join(words).strip()
    return f"`{text}`" if text else ""
