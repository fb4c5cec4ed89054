"""Runs an experiment, prints its table, and writes its rows."""

from __future__ import annotations

import argparse
import json
from dataclasses import fields, replace
from pathlib import Path

from tutorial_lib.agents.remedies import REMEDIES
from tutorial_lib.commands.constants import WRONG_INPUT
from tutorial_lib.commands.map_options import add_map
from tutorial_lib.experiments.common.cluster import on_cluster
from tutorial_lib.experiments.common.experiment import STANDARD, Experiment
from tutorial_lib.experiments.common.report import (
    BODIES,
    DRIFTING,
    ODOMETRY,
    ROUND,
    Options,
    parse_worlds,
)
from tutorial_lib.experiments.protocols.drives import parse_drives
from tutorial_lib.experiments.protocols.navigation import GOAL_IMAGES
from tutorial_lib.experiments.protocols.trial_choices import GOALS, STARTS
from tutorial_lib.experiments.provenance import made_from
from tutorial_lib.experiments.registry import EXPERIMENTS
from tutorial_lib.files import check_writable, write_text
from tutorial_lib.world.generators import FAMILIES
from tutorial_lib.world.generators.palette import PALETTES


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the experiments and their options."""
    add_common(parser, EXPERIMENTS)
    add_map(parser)
    known = dict.fromkeys(name for entry in EXPERIMENTS.values() for name in entry.ablations)
    parser.add_argument("--ablation", choices=known, default="")
    parser.add_argument("--palette", choices=PALETTES, default=STANDARD)
    parser.add_argument(
        "--family", choices=(*FAMILIES, "all"), default="", help="of generated worlds"
    )
    parser.add_argument(
        "--agent", default="", metavar="FILE.py:CLASS", help="a class of your own, as row custom"
    )
    parser.add_argument(
        "--odometry", choices=ODOMETRY, default=DRIFTING, help="of the robots' wheels"
    )
    parser.add_argument(
        "--drives", type=parse_drives, default="", help="learned: a share as 0.2, or a tour"
    )
    parser.add_argument("--starts", choices=STARTS, default="", help="of trials")
    parser.add_argument("--goals", choices=GOALS, default="", help="how they are seen")
    parser.add_argument(
        "--goal-images", choices=GOAL_IMAGES, default="", help="one image, or the end of a drive"
    )
    parser.add_argument(
        "--remedies", choices=REMEDIES, default="", help="for places that look alike"
    )
    parser.add_argument("--body", choices=BODIES, default=ROUND, help="of robots that explore")


def add_common(parser: argparse.ArgumentParser, table: dict[str, Experiment]) -> None:
    """Declare the experiments of a table, and the options that all of them take."""
    parser.epilog = _accepted(table)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("name", choices=table)
    parser.add_argument("--json", type=Path, help="where to write the rows")
    parser.add_argument("--worlds", type=parse_worlds, default=(), metavar="A:B")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--quick", action="store_true", help="fewer episodes, same code")
    add_scheduler(parser)
    parser.set_defaults(table=table)


def add_scheduler(parser: argparse.ArgumentParser) -> None:
    """Declare where the work is done."""
    parser.add_argument(
        "--scheduler", default="", metavar="tcp://HOST:PORT", help="of Dask, whose workers do it"
    )


def run(options: argparse.Namespace) -> int:
    """Run an experiment or a benchmark."""
    if options.json is not None:
        check_writable(options.json)
    asked = options_of(options)
    with on_cluster(options.scheduler):
        report = options.table[options.name].report(asked)
    print(report.as_text())
    if options.json is not None:
        if options.table is EXPERIMENTS and not (asked.quick or asked.agent):
            report = replace(report, made_from=made_from(options.name, asked))
        write_text(options.json, json.dumps(report.as_dict(), indent=1) + "\n")
    return WRONG_INPUT if report.failed else 0


def options_of(given: argparse.Namespace) -> Options:
    """What the command line says about a run."""
    names = {field.name for field in fields(Options)}
    return Options(**{name: value for name, value in vars(given).items() if name in names})


def _accepted(table: dict[str, Experiment]) -> str:
    """Which experiment takes which options, a line each."""
    width = max(map(len, table))
    lines = [
        f"  {name:{width}}  {' '.join(entry.options())}".rstrip() for name, entry in table.items()
    ]
    return "\n".join(["all take --json, --seed and --quick; besides:", *lines])
