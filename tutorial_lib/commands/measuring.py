"""The README's tables of what can be measured, made from the help of the commands."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence

from tutorial_lib.commands import experiment
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.registry import BENCHMARKS, EXPERIMENTS
from tutorial_lib.experiments.results_page.markdown import table

BEGIN, END = "<!-- measuring: begin -->", "<!-- measuring: end -->"
"""Around the block of the project's README."""


def measuring_block() -> str:
    """The block of the project's README, markers included."""
    return "\n".join(
        [
            BEGIN,
            _folded("Experiments, and the options that each takes", _measured(EXPERIMENTS)),
            _folded("Benchmarks", _measured(BENCHMARKS)),
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
