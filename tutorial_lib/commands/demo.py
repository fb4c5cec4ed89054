"""Navigates, explores, or lives through many queries, on film.

What it needs is imported after its first word.
"""

from __future__ import annotations

import argparse
import time
from contextlib import suppress
from pathlib import Path
from threading import Event, Thread
from types import TracebackType
from typing import TYPE_CHECKING

from tutorial_lib.commands.constants import MISSED
from tutorial_lib.commands.map_options import add_map
from tutorial_lib.errors import InputError

if TYPE_CHECKING:
    from tutorial_lib.experiments.demos.ends import End
    from tutorial_lib.experiments.demos.exploration_demo import Explored
    from tutorial_lib.experiments.demos.lifelong_demo import Life
    from tutorial_lib.experiments.demos.outcome import Outcome
    from tutorial_lib.experiments.demos.visits_demo import LifeOnFilm
    from tutorial_lib.world.floorplan import FloorPlan


FAMILY = "apartment"
EXPLORED = 2
"""Seed of the usual exploration: from a bedroom over a corridor into the living room, past several
ghosts of which it chooses some; with seed 0 it would be one straight corridor."""
LIFELONG_REFUSES = (
    *("map", "region", "family", "seed", "start", "goal"),
    *("oracle", "learn", "agent", "robot", "explore"),
)
"""Options that do not count beside `--lifelong` and `--life`, whose building is always the same."""
REFUSES = {
    "life": (*LIFELONG_REFUSES, "lifelong"),
    "lifelong": LIFELONG_REFUSES,
    "explore": ("oracle", "learn", "agent", "robot"),
}
"""Options that do not count, by the mode of the demo."""
_PLACE = "x,y,heading in metres and radians, or a room's name"
QUIET = 4.0
"""Seconds after which a word is said of work that still goes on."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_map(parser)
    parser.add_argument(
        "--family",
        help=f"{FAMILY} unless given; or office, symmetric_office, loop_corridor, maze, hall, "
        "scanned",
    )
    parser.add_argument("--seed", type=int, help="of the plan, and of all that is random")
    parser.add_argument("--start", metavar="PLACE", help=f"where to begin: {_PLACE}")
    parser.add_argument("--goal", metavar="PLACE", help="where the goal's image is taken, likewise")
    parser.add_argument(
        "--oracle",
        action="store_true",
        help="show beside it an oracle on the same task, which knows the floor plan and its pose",
    )
    parser.add_argument(
        "--learn", action="store_true", help="learn the map again, and keep it for later demos"
    )
    parser.add_argument(
        "--agent",
        metavar="FILE.py:CLASS",
        help="a component of your own, as a planner, in the place of the library's: how it does on "
        "the same task",
    )
    parser.add_argument(
        "--robot",
        metavar="FILE.py:NAME",
        help="a body of your own, as `def small(): return BicycleCar(wheelbase=0.2)`, or a pair of "
        "it and a Camera of another field_of_view: it records the drives, and navigates",
    )
    parser.add_argument(
        "--explore",
        action="store_true",
        help="look for the goal in a place never seen, without a map; generated plans have seeds "
        "from 10000 on, in which no network learned",
    )
    parser.add_argument(
        "--lifelong",
        action="store_true",
        help="film the first, the tenth and the hundredth query on a map that mends itself, in an "
        "office where a door is shut and opened again",
    )
    parser.add_argument(
        "--life",
        action="store_true",
        help="film the first, the third and the tenth visit of a robot to a building that it "
        "explores, remembers and knows better each time",
    )


def run(options: argparse.Namespace) -> int:
    """Run the demo, and say all the time what is being done."""
    mode = next((mode for mode in REFUSES if getattr(options, mode)), "")
    if mode not in ("life", "lifelong"):
        if options.region is not None and options.map is None:
            raise InputError("--region: is that of a map's file; give --map, or leave it out")
        if options.map is not None and options.family is not None:
            words = "the demo cannot use it beside --map; leave one of them out"
            raise InputError(f"--family: {words}")
    for name in REFUSES.get(mode, ()):
        given = getattr(options, name)
        if given is not None and given is not False:  # a seed of 0 is given, too
            raise InputError(f"--{name}: the demo cannot use it with --{mode}; leave it out")
    demos = {"life": _visit, "lifelong": _live, "explore": _explore, "": _navigate}
    with Narrator() as say:
        say("importing the library")
        outcome, lines = demos[mode](options, say)
    print(*lines, sep="\n")
    print(f"Look at {outcome.film} and {outcome.strip}; the figures are in demo.json.")
    return 0 if outcome.reached else MISSED


def _live(_: argparse.Namespace, say: Narrator) -> tuple[Life, list[str]]:
    """A hundred queries on one map: how they went, and that in words."""
    from tutorial_lib.experiments.demos.lifelong_demo import run_lifelong_demo

    life = run_lifelong_demo(Path.cwd(), say=say)
    title = f"{life.plan}, from {life.rooms[0]} to {life.rooms[1]}, three times:"
    return life, [title, *(f"  {line}" for line in life.story)]


def _visit(_: argparse.Namespace, say: Narrator) -> tuple[LifeOnFilm, list[str]]:
    """Ten visits to one building, likewise."""
    from tutorial_lib.experiments.demos.visits_demo import run_visits_demo

    life = run_visits_demo(Path.cwd(), say=say)
    return life, [f"{life.plan}, ten goals one after another:"] + [
        f"  visit {visit.number}: {visit.ending}, after {visit.steps} actions (SPL "
        f"{visit.spl:.2f}); {visit.nodes} nodes; odometry is off by {visit.drift:.0f} degrees, "
        f"the robot by {visit.off:.0f}"
        for visit in life.visits
    ]


def _explore(options: argparse.Namespace, say: Narrator) -> tuple[Explored, list[str]]:
    """Explore, likewise."""
    from tutorial_lib.experiments.demos.exploration_demo import run_exploration_demo
    from tutorial_lib.world.worlds import TRAINING_SEEDS

    seed = EXPLORED if options.seed is None else options.seed
    # What is wrong with the seed is said of the seed that was given.
    number = seed + (TRAINING_SEEDS.stop if seed >= 0 else 0)
    plan, name = _plan(options, seed, number, signs="wayfinding")
    start, goal = _ends(options)
    outcome = run_exploration_demo(
        plan, seed, Path.cwd(), start=start, goal=goal, name=name, say=say
    )
    return outcome, [
        f"{outcome.plan}, never seen before: {outcome.ending}, after {outcome.steps} actions and "
        f"{outcome.travelled} m (geodesic {outcome.geodesic} m, SPL {outcome.spl})."
    ]


def _navigate(options: argparse.Namespace, say: Narrator) -> tuple[Outcome, list[str]]:
    """Navigate over a map, likewise."""
    from tutorial_lib.experiments.demos.navigation_demo import run_demo

    seed, own = options.seed or 0, options.agent or ""
    plan, name = _plan(options, seed, seed)
    start, goal = _ends(options)
    outcome = run_demo(
        plan,
        seed,
        Path.cwd(),
        start=start,
        goal=goal,
        name=name,
        oracle=options.oracle,
        learn=options.learn,
        own=own,
        robot=options.robot or "",
        say=say,
    )
    drives = [(f"by sight, with {own}" if own else "by sight", outcome)]
    drives += [("oracle", outcome.oracle)] if outcome.oracle else []
    lines = [f"{outcome.plan}, from {outcome.rooms[0]} to {outcome.rooms[1]}:"]
    for name, drive in drives:
        words = f"after {drive.seconds} s and {drive.driven} m (geodesic {outcome.geodesic} m)"
        lines.append(f"  {name}: {drive.ending}, {words}")
    kept = f"the map is {outcome.map}" if outcome.map else "the map was not kept: --learn keeps it"
    composed = f"{outcome.composed_of} of {outcome.drives} learned drives"
    return outcome, [*lines, f"The first plan is composed of {composed}; {kept}."]


def _plan(
    options: argparse.Namespace, seed: int, number: int, signs: str = "plain"
) -> tuple[FloorPlan, str]:
    """The plan that was asked for, and its name: of a map that of its file."""
    from tutorial_lib.world.generators import generate
    from tutorial_lib.world.importers import import_map

    if options.map is not None:
        return import_map(options.map, seed=seed, region=options.region), options.map.stem
    plan = generate(options.family or FAMILY, number, signs=signs)
    return plan, f"{plan.family} {plan.seed}"


def _ends(options: argparse.Namespace) -> tuple[End | None, End | None]:
    """Start and goal that were asked for."""
    from tutorial_lib.experiments.demos.ends import parse_end

    start = None if options.start is None else parse_end("--start", options.start)
    return start, None if options.goal is None else parse_end("--goal", options.goal)


class Narrator:
    """Prints what is being done, with the seconds since the beginning; a context manager."""

    def __init__(self) -> None:
        self._begun = self._said = time.monotonic()
        self._doing = ""
        self._over = Event()
        self._thread = Thread(target=self._keep_talking, daemon=True)

    def __enter__(self) -> Narrator:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._over.set()
        self._thread.join()

    def __call__(self, text: str) -> None:
        """Say what is being done from now on."""
        self._doing = text.partition(":")[0]
        self._print(text)

    def _keep_talking(self) -> None:
        while not self._over.wait(max(0.0, self._said + QUIET - time.monotonic())):
            if time.monotonic() - self._said >= QUIET:
                with suppress(BrokenPipeError):  # which the next word of the work itself meets
                    self._print(f"still {self._doing}")

    def _print(self, text: str) -> None:
        self._said = time.monotonic()
        print(f"{self._said - self._begun:5.1f} s  {text}", flush=True)
