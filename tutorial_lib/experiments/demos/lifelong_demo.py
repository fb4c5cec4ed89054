"""The demo of a map that mends itself: three queries of a hundred, on film, while a door shuts."""

import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from tutorial_lib.agents.ltvn import LTVNAgent
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.demos.forecast import Forecast
from tutorial_lib.experiments.demos.moments import OnLivingMap, map_counts
from tutorial_lib.experiments.demos.navigation_demo import drive
from tutorial_lib.experiments.demos.outcome import FILM, STRIP, Drive, check_folder, rounded
from tutorial_lib.experiments.demos.recorder import FILM_RATE, FilmRecorder, Write, demo_files
from tutorial_lib.experiments.demos.task import Say, Task, silent, task_of
from tutorial_lib.experiments.protocols.drives import part_of
from tutorial_lib.experiments.protocols.lifelong import (
    deep_experiences,
    deep_goals,
    image_poses,
    run_queries,
)
from tutorial_lib.experiments.protocols.navigation_tasks import Building, draw_trials, explored
from tutorial_lib.geometry import Array
from tutorial_lib.topology.maintenance import Maintenance
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.labels import label
from tutorial_lib.viz.canvas.living_maps import draw_living_map
from tutorial_lib.viz.canvas.plan_view import Picture
from tutorial_lib.viz.figures.dashboard import LEGEND, MARGIN, Moment, dashboard
from tutorial_lib.viz.figures.maps import pale_view
from tutorial_lib.world.generators import generate
from tutorial_lib.world.people import Person
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.simulation import Sensors

SEED, PLACES = 1, 8
"""Of the office, and the places between which its tour leads."""
TRIP = 4, 2
"""The places between which the filmed queries lead: past the door it is half as far as round."""
DOOR = (0.22, 1.93), (0.55, 1.89), (0.89, 1.84)
"""Where people stand when the door is shut."""
_SPARE = 40.0  # seconds more than usual that a query may take: time for the long way round
_LEGEND = (
    *((name.replace("person", "shut door"), colour) for name, colour in LEGEND),
    ("edge", colours.FAINT),
)
_EDGES = (
    "The map's edges: grey where it is sure of them, vermilion where it doubts them, "
    "dashed where they are pruned."
)
_LINE = 30  # pixels of a line of the story
_SIZE = 0.76
_BESIDE = 100  # pixels to the left of the door


@dataclass(frozen=True)
class Stage:
    """Queries of a life that are run in the same way; a single one is filmed.

    Attributes:
        first: number of the first query.
        last: number of the last one.
        shut: whether the door is.
        cost: seconds that it takes on an idle laptop.
    """

    first: int
    last: int
    shut: bool
    cost: float

    @property
    def door(self) -> str:
        """In words."""
        return "shut" if self.shut else "open"

    @property
    def filmed(self) -> bool:
        """Whether it is a single query."""
        return self.first == self.last


STAGES = (
    Stage(1, 1, False, 8.0),
    Stage(2, 9, True, 6.0),
    Stage(10, 10, True, 10.0),
    Stage(11, 50, True, 27.0),
    Stage(51, 99, False, 18.0),
    Stage(100, 100, False, 8.0),
)
_LEARNING = 12.0  # seconds to record the drives and learn the map on an idle laptop


@dataclass(frozen=True)
class Query(Drive):
    """How a filmed query went.

    Attributes:
        number: of the query.
        door: "open" or "shut".
        edges: of the map afterwards.
        pruned: edges that were out of the map then.
        returned: how often a pruned edge had come back by then.
    """

    number: int
    door: str
    edges: int
    pruned: int
    returned: int

    @property
    def sentence(self) -> str:
        """All of it in words."""
        return (
            f"query {self.number}, door {self.door}: {self.ending}, after {self.seconds:.0f} s; "
            f"map: {self.edges} edges, {self.pruned} pruned, {self.returned} returned"
        )


@dataclass(frozen=True)
class Queries:
    """How queries went that were not filmed: their numbers, how many reached the goal, seconds."""

    first: int
    last: int
    door: str
    reached: int
    seconds: float

    @property
    def sentence(self) -> str:
        """All of it in words."""
        count = self.last - self.first + 1
        return (
            f"queries {self.first} to {self.last}, to other goals, door {self.door}: "
            f"{self.reached} of {count} reach the goal, {self.seconds:.0f} s on average"
        )


@dataclass(frozen=True)
class Life:
    """What `demo.json` holds of a map's life; lengths in metres, times in seconds.

    Attributes:
        reached: whether all filmed queries reached the goal.
        story: what happened, in words, in order.
        start: x, y and heading of the filmed queries.
        goal: x, y and heading at which its image was taken.
        geodesic: of the shortest path, past the door.
        vertices: of the map.
        filmed: queries that were filmed.
        others: queries that were not.
    """

    reached: bool
    story: tuple[str, ...]
    name: str
    plan: str
    rooms: tuple[str, str]
    start: tuple[float, float, float]
    goal: tuple[float, float, float]
    geodesic: float
    vertices: int
    filmed: tuple[Query, ...]
    others: tuple[Queries, ...]
    film: str = FILM
    strip: str = STRIP


def run_lifelong_demo(folder: Path, *, stages: Sequence[Stage] = STAGES, say: Say = silent) -> Life:
    """Live through all stages; leave demo.webm, demo.png and demo.json.

    Args:
        folder: for the files.
        stages: of the life, in order.
        say: is called with what is being done.
    """
    check_folder(folder)
    forecast = Forecast(np.array([_LEARNING, *(stage.cost for stage in stages)]))
    begun = time.monotonic()
    say(f"recording drives through an office and learning a map of them; {forecast.words()} in all")
    office, agent, task = _beginning()
    forecast.done(time.monotonic() - begun)
    life = _Life(office, agent, task, stages)
    with demo_files(folder) as (write, finish):
        for stage in stages:
            say(f"{life.announced(stage)}; {forecast.words()} left")
            life.run(stage, write)
            forecast.done(time.monotonic() - begun)
        say("writing the film")
        outcome = life.outcome()
        finish(life.last_pictures, outcome)
    return outcome


def _beginning() -> tuple[Building, LTVNAgent, Task]:
    """The office, an agent that has learned a tour through it, and the trip that is filmed."""
    scene = Scene(generate("office", SEED))
    office = explored(f"office {SEED}", scene, np.random.default_rng(0), PLACES)
    number = np.flatnonzero((office.pairs == TRIP).all(axis=1))
    trial = draw_trials(office, 1, np.random.default_rng(0), among=number)
    toured = part_of(office, "tour", 0)
    task = task_of(toured, trial, len(office.pairs), np.array(scene.plan.bounds))
    agent = agents.ltvn()
    agent.learn(deep_experiences(toured))
    return office, agent, task


class _Life:
    """One map, and what its robots do on it.

    Attributes:
        story: what happened so far, in order.
        last_pictures: of the filmed queries.
    """

    def __init__(
        self, office: Building, agent: LTVNAgent, task: Task, stages: Sequence[Stage]
    ) -> None:
        """Nobody has driven yet."""
        self.story: list[Query | Queries] = []
        self.last_pictures: list[Picture] = []
        self._agent, self._task, self._total = agent, task, stages[-1].last
        others = draw_trials(office, self._total, np.random.default_rng(1))
        self._others = replace(others, seconds=others.seconds + _SPARE)
        self._vertices = image_poses(task.building, agent)
        self._door = [Person([place], speed=0.0, colour=colours.PERSON) for place in DOOR]
        self._film = LifeFilm(task.building.scene, agent.upkeep, self._vertices, DOOR, len(stages))

    def announced(self, stage: Stage) -> str:
        """What is done in a stage, in words."""
        if stage.filmed:
            return f"query {stage.first} of {self._total}, filmed, the door is {stage.door}"
        return f"queries {stage.first} to {stage.last}, to other goals, the door is {stage.door}"

    def run(self, stage: Stage, write: Write) -> None:
        """Run the queries of a stage; `write` gets each picture of a film."""
        self.story.append(self._filmed(stage, write) if stage.filmed else self._unfilmed(stage))

    def outcome(self) -> Life:
        """How all of it went."""
        task, trial = self._task, self._task.trial
        filmed = tuple(one for one in self.story if isinstance(one, Query))
        ends = trial.starts[:, :2], trial.goal_poses[:, :2]
        return Life(
            reached=all(one.reached for one in filmed),
            story=tuple(one.sentence for one in self.story),
            name="demo --lifelong",
            plan=task.building.name,
            rooms=task.rooms,
            start=rounded(trial.starts[0]),
            goal=rounded(trial.goal_poses[0]),
            geodesic=round(float(task.building.paths.between(*ends)[0]), 2),
            vertices=len(self._agent.sampled.vertices),
            filmed=filmed,
            others=tuple(one for one in self.story if isinstance(one, Queries)),
        )

    def _filmed(self, stage: Stage, write: Write) -> Query:
        agent, trial = self._agent, self._task.trial
        trial = replace(trial, seconds=trial.seconds + _SPARE)
        task = replace(self._task, trial=trial, people=self._door if stage.shut else [])
        agent.upkeep.begin(stage.first)
        navigation = agent.start(deep_goals(trial))
        title = f"{task.building.name}: query {stage.first} of {self._total}, door {stage.door}"
        before = [one.sentence for one in self.story]

        def watch(moment: Moment) -> None:
            now = f"query {stage.first}, door {stage.door}: under way"
            write(self._film.frame(moment, title, stage.door, [*before, now]))

        goal = trial.goal_poses[0]
        make = OnLivingMap(navigation, agent.upkeep, self._vertices, goal, task.image, stage.door)
        recorder = FilmRecorder(make, watch)
        went = drive(task, lambda _: navigation, recorder, sensors=Sensors(with_depth=True))
        counts = map_counts(agent.upkeep)
        query = Query(**asdict(went), number=stage.first, door=stage.door, **counts)
        last = self._film.frame(recorder.moments[-1], title, stage.door, [*before, query.sentence])
        for _ in range(round(2 * FILM_RATE)):
            write(last)
        self.last_pictures.append(last)
        return query

    def _unfilmed(self, stage: Stage) -> Queries:
        some = self._others.subset(np.arange(stage.first - 1, stage.last))
        people = self._door if stage.shut else []
        found, _ = run_queries(
            self._task.building, some, self._agent, first=stage.first, people=people
        )
        reached, seconds = int(found.there.sum()), round(float(found.seconds.mean()), 1)
        return Queries(stage.first, stage.last, stage.door, reached, seconds)


class LifeFilm:
    """Draws moments of a robot whose map changes meanwhile."""

    def __init__(
        self, scene: Scene, upkeep: Maintenance, vertices: Array, door: ArrayLike, lines: int
    ) -> None:
        """Film.

        Args:
            scene: the world.
            upkeep: of the map.
            vertices: (V, 3) where the map's images were taken.
            door: (K, 2) places across the door that is opened and shut.
            lines: of the story, at most.
        """
        self._view, self._upkeep, self._vertices = pale_view(scene), upkeep, vertices
        self._plan, self._door, self._lines = self._view.base, np.asarray(door), lines

    def frame(self, moment: Moment, title: str, door: str, story: Sequence[str]) -> Picture:
        """The picture of a moment; the map is drawn as it is now."""
        view = self._view
        view.base = self._plan.copy()
        upkeep = self._upkeep
        draw_living_map(view, view.base, self._vertices, upkeep.graph, upkeep.pruned)
        for place in self._door:
            view.ring(view.base, place, Person.radius, colours.PERSON)
        x, y = view.pixels(self._door[0]).round().astype(int).tolist()
        label(view.base, f"door {door}", x - _BESIDE, y + 6, 0.62)
        shown = dashboard(view, moment, title, _LEGEND)
        high = _LINE * (self._lines + 1) + MARGIN
        below = np.full((high, shown.shape[1], 3), colours.PAPER, np.uint8)
        label(below, _EDGES, MARGIN, _LINE, _SIZE, colours.FAINT)
        for number, line in enumerate(story, 2):
            label(below, line, MARGIN, _LINE * number, _SIZE)
        return np.concatenate([shown, below])
