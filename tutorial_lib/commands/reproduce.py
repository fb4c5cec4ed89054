"""Measures stored results again, those that no longer fit or all; what is killed goes on."""

import argparse
import json
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from tutorial_lib.commands.constants import PROJECT
from tutorial_lib.commands.experiment import add_scheduler
from tutorial_lib.commands.results import unfit
from tutorial_lib.course import cache_folder
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.results_page.sources import COMMANDS, load_results
from tutorial_lib.files import make_folder, write_text
from tutorial_lib.learning.weights import FOLDER as WEIGHTS
from tutorial_lib.learning.weights import load_card
from tutorial_lib.reading.documents import read_json

NETWORKS = ("waypoint", "reachability", "relative", "nts", "il", "ans_like")
"""In this order they are trained: those that come later start from those before, or drive them."""
LAST = ("results", "build")
"""Commands that write the page, and run the notebooks that show results."""
SHARED = ("train", "experiment")
"""Commands whose work a scheduler's workers may do."""


@dataclass(frozen=True)
class Step:
    """One command of a plan.

    Attributes:
        arguments: of ``python -m tutorial_lib``.
        hours: that it took when it ran last.
    """

    arguments: str
    hours: float = 0.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare what is measured again."""
    parser.add_argument(
        "names", nargs="*", metavar="NAME", help="of results; the stale ones if none"
    )
    parser.add_argument("--all", action="store_true", help="the whole course, networks included")
    parser.add_argument(
        "--plan",
        action="store_true",
        help="only say what would run, and how long; canaries tell what is stale",
    )
    add_scheduler(parser)


def run(options: argparse.Namespace) -> int:
    """Say what will run and how long it took before, then run it."""
    steps = planned(options.names, everything=options.all)
    for step in steps:
        print(f"{step.hours:6.2f} h   {step.arguments}")
    print(f"{len(steps)} commands, {sum(step.hours for step in steps):.1f} h when they ran last")
    if options.plan:
        return 0
    done = _Done(steps)
    for step in steps:
        if step.arguments not in done.arguments:
            arguments = step.arguments.split()
            if options.scheduler and arguments[0] in SHARED:
                arguments += ["--scheduler", options.scheduler]
            code = subprocess.call([sys.executable, "-m", "tutorial_lib", *arguments], cwd=PROJECT)
            if code:
                raise InputError(f"{step.arguments}: failed; the same command goes on from there")
            done.add(step.arguments)
    done.forget()
    return 0


def planned(names: list[str], *, everything: bool) -> list[Step]:
    """The commands that measure results again, in the order in which they must run.

    Args:
        names: of results; those that no longer fit if there are none.
        everything: all networks, results and notebooks instead.

    Raises:
        InputError: for a name that is not a result's, and for names where everything is asked for.
    """
    if names and everything:
        raise InputError(
            f"{names[0]} --all: everything is measured again; leave out one of the two"
        )
    unknown = [name for name in names if name not in COMMANDS]
    if unknown:
        raise InputError(f"{unknown[0]}: no result; there are {', '.join(COMMANDS)}")
    reports = load_results().reports
    chosen = COMMANDS if everything else names or unfit()
    steps = _trainings() if everything else []
    for name in chosen:
        kept = Path("tutorial_lib", "results", f"{name}.json").as_posix()
        steps.append(Step(f"{COMMANDS[name]} --json {kept}", reports[name].seconds / 3_600))
    return steps + [Step(command) for command in LAST] if steps else []


def _trainings() -> list[Step]:
    cards = [load_card(path.stem) for path in sorted(WEIGHTS.glob("*.json"))]
    # What starts from another network comes after those that start anew.
    cards.sort(key=lambda card: (_family(card.command), bool(card.recipe.get("start"))))
    return [Step(card.command, card.minutes / 60) for card in cards]


def _family(command: str) -> int:
    """The place in `NETWORKS` of what a command trains; what is not known there comes last."""
    name = command.split()[1]
    return NETWORKS.index(name) if name in NETWORKS else len(NETWORKS)


class _Done:
    """Commands of a plan that have ended, in a file, so that the plan goes on after a kill."""

    def __init__(self, steps: list[Step]) -> None:
        plan = [step.arguments for step in steps]
        self._path = cache_folder() / "unfinished" / "reproduce.json"
        self.arguments: list[str] = []
        kept = read_json(self._path, "delete it") if self._path.is_file() else {}
        if isinstance(kept, dict) and kept.get("plan") == plan:
            self.arguments = kept.get("done", [])
        self._plan = plan

    def add(self, arguments: str) -> None:
        """Note that a command has ended."""
        self.arguments.append(arguments)
        make_folder(self._path.parent)
        write_text(self._path, json.dumps({"plan": self._plan, "done": self.arguments}))

    def forget(self) -> None:
        """The plan is done."""
        self._path.unlink(missing_ok=True)
