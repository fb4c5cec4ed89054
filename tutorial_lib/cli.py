"""The commands: ``python -m tutorial_lib {lab,demo,progress,mark,build,train,...}``."""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import time
from dataclasses import fields
from pathlib import Path

from tutorial_lib.checks.marking import mark
from tutorial_lib.checks.progress import progress, report
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.experiment import STANDARD, Experiment
from tutorial_lib.experiments.common.report import DRIFTING, ODOMETRY, Options, parse_worlds
from tutorial_lib.experiments.demos.navigation_demo import run_demo
from tutorial_lib.experiments.registry import BENCHMARKS, EXPERIMENTS
from tutorial_lib.experiments.results_page.page import write_results
from tutorial_lib.files import check_writable, write_text
from tutorial_lib.learning import reach_recipes, recipes
from tutorial_lib.learning.weights import save_network
from tutorial_lib.world.generators import FAMILIES, generate
from tutorial_lib.world.generators.palette import PALETTES
from tutorial_lib.world.importers import import_map

NETWORKS = {
    "waypoint": recipes.WAYPOINT,
    "reachability": {**reach_recipes.REACHABILITY, "sptm": reach_recipes.SPTM},
}
"""Recipes that `train` takes, by name and k."""
PROJECT = Path(__file__).resolve().parent.parent
INTERRUPTED, WRONG_INPUT, MISSED = 130, 2, 1


def main(arguments: list[str]) -> int:
    """Run a command and return its exit code; wrong input gets one line on stderr."""
    if arguments[:1] == ["lab"]:  # the remaining arguments are JupyterLab's
        return open_lab(arguments[1:])
    options = _parser().parse_args(arguments)
    try:
        return options.run(options)
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)
        return WRONG_INPUT
    except OSError as error:
        print(f"error: {error}; check the folder and the disk space", file=sys.stderr)
        return WRONG_INPUT
    except KeyboardInterrupt:
        print("interrupted; nothing half-written was left", file=sys.stderr)
        return INTERRUPTED


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m tutorial_lib", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    commands.add_parser("lab", help="open JupyterLab on the first notebook; arguments go to it")
    demo = commands.add_parser(
        "demo", help="navigate once by sight; leaves demo.webm, demo.png, demo.json"
    )
    demo.add_argument("--map", type=Path, help="a ROS map's YAML, a HouseExpo or a plan's JSON")
    demo.add_argument("--family", choices=FAMILIES, default="apartment")
    demo.add_argument("--seed", type=int, default=0)
    demo.add_argument(
        "--oracle",
        action="store_true",
        help="show beside it an oracle on the same task, which knows the floor plan and its pose",
    )
    demo.add_argument(
        "--learn", action="store_true", help="learn the map again, and keep it for later demos"
    )
    demo.set_defaults(run=_demo)
    done = commands.add_parser("progress", help="which exercises are done, in every notebook")
    done.set_defaults(run=_progress)
    marked = commands.add_parser("mark", help="check the answers that students handed in")
    marked.add_argument("folders", nargs="+", type=Path, metavar="FOLDER", help="my_answers")
    marked.set_defaults(run=_mark)
    build = commands.add_parser("build", help="write the notebooks from solutions/*.py")
    build.add_argument("names", nargs="*", help="as in 01_world_and_car; all unless given")
    build.add_argument(
        "--students", action="store_true", help="only what students get; runs nothing"
    )
    build.set_defaults(run=_build)
    train = commands.add_parser("train", help="train a network from scratch, data included")
    train.add_argument("name", choices=tuple(NETWORKS))
    choices = dict.fromkeys(k for known in NETWORKS.values() for k in known)
    train.add_argument("--k", choices=tuple(choices), required=True)
    train.set_defaults(run=_train)
    for name, table in (("experiment", EXPERIMENTS), ("bench", BENCHMARKS)):
        command = commands.add_parser(
            name,
            help=f"one of: {', '.join(table)}",
            epilog=_accepted(table),
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        command.add_argument("name", choices=table)
        command.add_argument("--json", type=Path, help="where to write the rows")
        command.add_argument("--worlds", type=parse_worlds, default=(), metavar="A:B")
        command.add_argument("--seed", type=int, default=0)
        command.add_argument("--quick", action="store_true", help="fewer episodes, same code")
        if table is EXPERIMENTS:
            command.add_argument("--map", type=Path, help="a map's file, in place of worlds")
            known = [name for entry in table.values() for name in entry.ablations]
            command.add_argument("--ablation", choices=known, default="")
            command.add_argument("--palette", choices=PALETTES, default=STANDARD)
            command.add_argument("--agent", default="", metavar="FILE.py:CLASS")
            command.add_argument(
                "--odometry", choices=ODOMETRY, default=DRIFTING, help="of the robots' wheels"
            )
        command.set_defaults(run=_report, table=table)
    results = commands.add_parser("results", help="write the page of results from its JSON files")
    results.set_defaults(run=_results)
    return parser


def _accepted(table: dict[str, Experiment]) -> str:
    """Which experiment takes which options, a line each."""
    width = max(map(len, table))
    lines = [
        f"  {name:{width}}  {' '.join(entry.options())}".rstrip() for name, entry in table.items()
    ]
    return "\n".join(["all take --json, --seed and --quick; besides:", *lines])


def lab_command(arguments: list[str]) -> list[str]:
    """The command line that opens JupyterLab on the first notebook."""
    return [
        sys.executable,
        "-m",
        "jupyterlab",
        f"--ServerApp.root_dir={PROJECT}",
        "--LabApp.default_url=/lab/tree/notebooks/00_start_here.ipynb",
        "--LabApp.news_url=None",  # works offline: no news, no check for updates
        "--LabApp.check_for_updates_class=jupyterlab.NeverCheckForUpdate",
        *(["--allow-root"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []),
        *arguments,
    ]


def open_lab(arguments: list[str]) -> int:
    """Open JupyterLab, wait until it is closed, and return its exit code."""
    try:
        return subprocess.call(lab_command(arguments))
    except KeyboardInterrupt:
        return INTERRUPTED


def _demo(options: argparse.Namespace) -> int:
    if options.map is not None:
        plan = import_map(options.map, seed=options.seed)
    else:
        plan = generate(options.family, options.seed)
    begun = time.monotonic()

    def say(text: str) -> None:
        print(f"{time.monotonic() - begun:5.1f} s  {text}", flush=True)

    outcome = run_demo(
        plan, options.seed, Path.cwd(), oracle=options.oracle, learn=options.learn, say=say
    )
    drives = [("by sight", outcome), *([("oracle", outcome.oracle)] if outcome.oracle else [])]
    print(f"{outcome.plan}, from {outcome.rooms[0]} to {outcome.rooms[1]}:")
    for name, drive in drives:
        verdict = "reached the goal" if drive.reached else "MISSED the goal"
        words = f"after {drive.seconds} s and {drive.driven} m (geodesic {outcome.geodesic} m)"
        print(f"  {name}: {verdict} {words}")
    print(f"Look at {outcome.film} and {outcome.strip}; the figures are in demo.json.")
    return 0 if outcome.reached else MISSED


def _progress(options: argparse.Namespace) -> int:
    del options
    print(report(progress(PROJECT / "notebooks")))
    return 0


def _mark(options: argparse.Namespace) -> int:
    for folder in options.folders:
        results = list(mark(folder))
        passed = sum(result.status == "passed" for result in results)
        print(f"{folder}: {passed} of {len(results)} pass")
        for result in results:
            print(f"  {result}")
    return 0


def _build(options: argparse.Namespace) -> int:
    # Its dependencies are installed with the tests, not with the library.
    from tutorial_lib.builder import build, write_guides

    known = {source.stem: source for source in sorted(PROJECT.glob("solutions/*.py"))}
    for name in options.names:
        if name not in known:
            raise InputError(f"build: no solutions/{name}.py; there are {', '.join(known)}")
    print(*(f"wrote {file.relative_to(PROJECT)}" for file in write_guides(PROJECT)), sep="\n")
    for name in options.names or known:
        for file in build(known[name], PROJECT, students_only=options.students):
            print(f"wrote {file.relative_to(PROJECT)}")
    return 0


def _train(options: argparse.Namespace) -> int:
    known = NETWORKS[options.name]
    if options.k not in known:
        raise InputError(f"train {options.name}: --k {options.k}; give one of {', '.join(known)}")
    recipe = known[options.k]
    if options.name == "waypoint":
        network, card = recipes.train_local(recipe, recipes.WORK)
    else:
        network, card = reach_recipes.train_reachability(recipe, recipes.WORK)
    path = save_network(network, card)
    # Otherwise the next call would resume a finished training.
    for checkpoint in recipe.checkpoints(recipes.WORK):
        checkpoint.unlink(missing_ok=True)
    print(f"wrote {path.relative_to(PROJECT)} after {card.minutes} min: {card.validation}")
    return 0


def _report(options: argparse.Namespace) -> int:
    if options.json is not None:
        check_writable(options.json)
    names = {field.name for field in fields(Options)}
    given = {name: value for name, value in vars(options).items() if name in names}
    report = options.table[options.name].report(Options(**given))
    print(report.as_text())
    if options.json is not None:
        write_text(options.json, json.dumps(report.as_dict(), indent=1) + "\n")
    return 0


def _results(options: argparse.Namespace) -> int:
    del options
    for path in write_results(PROJECT / "README.md"):
        print(f"wrote {path.relative_to(PROJECT)}")
    return 0
