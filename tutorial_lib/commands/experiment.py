"""Runs an experiment, prints its table, and writes its rows."""

import argparse
import json
import sys
from dataclasses import fields, replace
from pathlib import Path

from tutorial_lib.agents.remedies import REMEDIES
from tutorial_lib.commands.constants import WRONG_INPUT
from tutorial_lib.commands.map_options import add_map
from tutorial_lib.errors import InputError
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

ABLATIONS = {
    "smoothing": "C with and without the mean of its last waypoints",
    "thresholds": "thresholds of RE and of SPTM's similarity, for what --drives says",
    "goal_images": "thresholds of a goal, shown as one image and as a clip",
    "audit": "how many pairs labelled 0 without a rollout would be reached",
    "localization": "the Bayes filter by itself",
    "geometry": "the true geometry in place of the networks, for those that drive",
    "rules": "NTS with the rules of the paper that ours leaves out",
    "rl": "the paper's two baselines that learn by reinforcement",
    "exact": "motion and odometry without noise",
    "car": "the body of a car, which cannot turn in place",
    "carried": "lives in which somebody carries the robot elsewhere, twice",
    "changed": "lives in which a door closes, another opens, and furniture moves",
    "ingredients": "the combined agent without one of its parts at a time",
    "toured": "robots that were shown the building first, by an oracle or while exploring",
    "meng": "Meng's map, kept up to date and as it was built",
    "parts": "the agent without one of its parts at a time",
}
"""What else an experiment compares, by name: these run in its place."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the experiments and their options."""
    add_common(parser, EXPERIMENTS)
    add_scheduler(parser)
    add_map(parser)
    runs = "; ".join(f"{name}: {words}" for name, words in ABLATIONS.items())
    parser.add_argument(
        "--ablation", choices=ABLATIONS, default="", help=f"what runs in its place. {runs}"
    )
    words = "shifted: colours, gamma and noise that no network has seen"
    parser.add_argument("--palette", choices=PALETTES, default=STANDARD, help=words)
    words = "of generated worlds; all: in turn, by seed"
    parser.add_argument("--family", choices=(*FAMILIES, "all"), default="", help=words)
    parser.add_argument(
        "--agent",
        default="",
        metavar="FILE.py:CLASS",
        help="a class of your own, as row custom; leaderboard --template KIND writes one to begin "
        "with. Its runs begin anew after an interruption: the class may have changed",
    )
    words = "of the robots' wheels; exact: without drift"
    parser.add_argument("--odometry", choices=ODOMETRY, default=DRIFTING, help=words)
    parser.add_argument(
        "--drives",
        type=_drives,
        default="",
        metavar="SHARE",
        help="what agents learn of the drives: a share such as 0.2, so that most trials must be "
        "composed of several; tour: from each place to the next and back; or continuous, the same "
        "as one drive",
    )
    words = "of trials; anywhere: on a drive, looking aside"
    parser.add_argument("--starts", choices=STARTS, default="", help=words)
    words = "how they are seen; turned: as on arrival from elsewhere"
    parser.add_argument("--goals", choices=GOALS, default="", help=words)
    parser.add_argument(
        "--goal-images", choices=GOAL_IMAGES, default="", help="one image, or the end of a drive"
    )
    words = "for places that look alike (notebook 07): each alone, all but one, or all"
    parser.add_argument("--remedies", choices=REMEDIES, default="", help=words)
    parser.add_argument("--body", choices=BODIES, default=ROUND, help="of robots that explore")
    parser.add_argument(
        "--robot",
        default="",
        metavar="FILE.py:NAME",
        help="what makes the body of the robots, as a car of other sizes, or a pair (body, Camera) "
        "whose camera has another field_of_view; networks stay the same, or are those of "
        "train --degrees",
    )


def _drives(text: str) -> str:
    try:
        return parse_drives(text)
    except InputError as error:
        raise argparse.ArgumentTypeError(str(error).removeprefix("--drives ")) from None


def add_common(parser: argparse.ArgumentParser, table: dict[str, Experiment]) -> None:
    """Declare the experiments of a table, and the options that all of them take."""
    parser.epilog = _accepted(table)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("name", choices=table)
    parser.add_argument("--json", type=Path, metavar="FILE", help="where to write the rows")
    parser.add_argument(
        "--worlds",
        type=parse_worlds,
        default=(),
        metavar="A:B",
        help="seeds of the worlds, from A to B - 1",
    )
    parser.add_argument(
        "--seed", type=int, default=0, metavar="N", help="of all else that is random"
    )
    parser.add_argument("--quick", action="store_true", help="fewer episodes, same code")
    parser.set_defaults(table=table, scheduler="")


def add_scheduler(parser: argparse.ArgumentParser) -> None:
    """Declare where the work is done; a benchmark measures this machine alone."""
    parser.add_argument(
        "--scheduler",
        default="",
        metavar="tcp://HOST:PORT",
        help="a Dask scheduler, whose workers do it",
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


def measured_by(entry: Experiment) -> str:
    """What an experiment measures: the first line of its module."""
    return (sys.modules[entry.run.__module__].__doc__ or "").partition("\n")[0]


def _accepted(table: dict[str, Experiment]) -> str:
    """What each experiment measures, and which options it takes."""
    width = max(map(len, table))
    lines = []
    for name, entry in table.items():
        lines += [f"  {name:{width}}  {' '.join(entry.options())}".rstrip()]
        lines += [f"  {'':{width}}  {measured_by(entry)}"]
    return "\n".join(["all take --json, --seed and --quick; besides:", *lines])
