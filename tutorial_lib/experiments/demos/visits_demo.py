"""The demo of a life: the first, the third and the tenth visit of one robot, its map growing."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tutorial_lib.agents.lifelong import LifelongAgent
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.experiments.common.explorers import check_shipped, shipped
from tutorial_lib.experiments.demos.exploration_demo import (
    ExplorationRecorder,
    exploration_ending,
    explore_recorded,
    headings_off,
)
from tutorial_lib.experiments.demos.exploration_film import ExplorationFilm
from tutorial_lib.experiments.demos.outcome import FILM, STRIP, check_folder
from tutorial_lib.experiments.demos.recorder import demo_files
from tutorial_lib.experiments.demos.task import Say, silent
from tutorial_lib.experiments.race.ten_visits import Settings, draw_lives
from tutorial_lib.exploration.episodes import Episodes, exploration_world
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.world.worlds import scene_of

WORLD, LIFE = 10_004, 3
"""Seeds of the building, which no network knows, and of all that is random."""
VISITS, SHOWN = 10, (0, 2, 9)
"""Goals of the life, and those that are filmed."""


@dataclass(frozen=True)
class Visit:
    """How one visit ended; lengths in metres.

    Attributes:
        number: from 1 on.
        reached: stopped within 1 m of the goal.
        ending: in words.
        steps: actions.
        spl: success weighted by path length.
        nodes: of the graph at its end.
        drift: degrees of heading by which odometry is off.
        off: degrees by which the robot itself is, since walls corrected it.
    """

    number: int
    reached: bool
    ending: str
    steps: int
    spl: float
    nodes: int
    drift: float
    off: float


@dataclass(frozen=True)
class LifeOnFilm:
    """What `demo.json` holds of a life.

    Attributes:
        reached: whether the goals of all visits on film were.
        visits: all of them.
    """

    reached: bool
    plan: str
    visits: tuple[Visit, ...]
    name: str = "demo --life"
    film: str = FILM
    strip: str = STRIP


def run_visits_demo(folder: Path, *, visits: int = VISITS, say: Say = silent) -> LifeOnFilm:
    """Let one robot live through its visits; leave demo.webm, demo.png and demo.json.

    Args:
        folder: for the files.
        visits: goals of the life.
        say: is called with what is being done.

    Raises:
        InputError: when the network's weights are not there.
    """
    check_folder(folder)
    check_shipped(("nts",), "rgbd")
    say("drawing a life")
    name = exploration_world(WORLD)
    scene, rng = scene_of(name), np.random.default_rng(LIFE)
    goals, starts = draw_lives(scene, Settings(lives=1, visits=visits), rng)
    metres = GridPaths(scene.clearance).between(starts[0][:, :2], goals[0][:, :2])
    episode = Episodes((name,), starts[0], goals[0], metres, ("",))
    task = ExplorationTask({name: scene}, episode, rng)
    model = shipped("nts", "rgbd")
    agent = LifelongAgent(model, np.random.default_rng(LIFE))
    agent.start(task.goals())
    films, done = [], list[Visit]()
    recorder = ExplorationRecorder(task, agent, model)
    for number, poses in enumerate(goals):
        say(f"visit {number + 1} of {visits}")
        if number:
            task.next_goals(poses)
            agent.look_for(task.goals())
        recorder.moments = []
        explore_recorded(task, agent, recorder, quiet=number not in SHOWN)
        done.append(_visit(number, task, agent))
        if number in SHOWN:
            title = f"visit {number + 1} of {visits} to one building: find where this was taken"
            shown = scene, recorder.moments, starts[0][0], poses[0], title
            films.append(ExplorationFilm(*shown, "by odometry that walls correct"))
    life = LifeOnFilm(all(done[i].reached for i in SHOWN if i < visits), name, tuple(done))
    say("writing the film")
    with demo_files(folder) as (write, finish):
        for film in films:
            for picture in film:
                write(picture)
        finish([film[len(film) - 1] for film in films], life)
    return life


def _visit(number: int, task: ExplorationTask, agent: LifelongAgent) -> Visit:
    """How a visit ended."""
    drift, off = headings_off(task, agent)
    return Visit(
        number=number + 1,
        reached=bool(task.success[0]),
        ending=exploration_ending(task),
        steps=int(task.steps[0]),
        spl=round(float(task.spl[0]), 2),
        nodes=len(agent.robots[0].memory.graph),
        drift=drift,
        off=off,
    )
