"""Navigates or explores once, on film. What it needs is imported after its first word."""

from __future__ import annotations

import argparse
from pathlib import Path

from tutorial_lib.commands.constants import MISSED
from tutorial_lib.commands.map_options import add_map
from tutorial_lib.commands.narrator import Narrator
from tutorial_lib.errors import InputError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_map(parser)
    parser.add_argument(
        "--family",
        default="apartment",
        help="apartment, office, symmetric_office, loop_corridor, maze, hall or scanned",
    )
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument(
        "--oracle",
        action="store_true",
        help="show beside it an oracle on the same task, which knows the floor plan and its pose",
    )
    parser.add_argument(
        "--learn", action="store_true", help="learn the map again, and keep it for later demos"
    )
    parser.add_argument(
        "--explore",
        action="store_true",
        help="look for the goal in a place never seen, without a map; generated plans have seeds "
        "from 10000 on, in which no network learned",
    )


def run(options: argparse.Namespace) -> int:
    """Run the demo, and say all the time what is being done."""
    if options.region is not None and options.map is None:
        raise InputError("--region: is that of a map's file; give --map, or leave it out")
    reached = _explore(options) if options.explore else _navigate(options)
    return 0 if reached else MISSED


def _explore(options: argparse.Namespace) -> bool:
    """Explore; whether the goal was found."""
    for name in ("oracle", "learn"):
        if getattr(options, name):
            raise InputError(f"--{name}: the demo cannot use it with --explore; leave it out")
    with Narrator() as say:
        say("importing the library: the demo takes about 30 s on two idle cores")
        from tutorial_lib.experiments.demos.exploration_demo import run_exploration_demo
        from tutorial_lib.world.generators import generate
        from tutorial_lib.world.importers import import_map
        from tutorial_lib.world.worlds import TRAINING_SEEDS

        if options.map is not None:
            plan = import_map(options.map, seed=options.seed, region=options.region)
        else:
            # What is wrong with the seed is said of the seed that was given.
            number = options.seed + (TRAINING_SEEDS.stop if options.seed >= 0 else 0)
            plan = generate(options.family, number, signs="wayfinding")
        outcome = run_exploration_demo(plan, options.seed, Path.cwd(), say=say)
    verdict = "found the goal" if outcome.reached else "MISSED the goal"
    print(
        f"{outcome.plan}, never seen before: {verdict} after {outcome.steps} actions and "
        f"{outcome.travelled} m (geodesic {outcome.geodesic} m, SPL {outcome.spl})."
    )
    print(f"Look at {outcome.film} and {outcome.strip}; the figures are in demo.json.")
    return outcome.reached


def _navigate(options: argparse.Namespace) -> bool:
    """Navigate over a map; whether the goal was reached."""
    takes = 30 if options.oracle else 20
    with Narrator() as say:
        say(f"importing the library: the demo takes about {takes} s on two idle cores")
        from tutorial_lib.experiments.demos.navigation_demo import run_demo
        from tutorial_lib.world.generators import generate
        from tutorial_lib.world.importers import import_map

        if options.map is not None:
            plan = import_map(options.map, seed=options.seed, region=options.region)
        else:
            plan = generate(options.family, options.seed)
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
    return outcome.reached
