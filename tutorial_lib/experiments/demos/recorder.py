"""Records a rollout of one robot for a film, and writes what a demo leaves behind."""

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np

from tutorial_lib.experiments.demos.outcome import FIGURES, FILM, STRIP, Drive
from tutorial_lib.files import atomic_paths
from tutorial_lib.interfaces import Observation, Robots
from tutorial_lib.se2 import Array, arc_length
from tutorial_lib.viz.canvas.plan_view import Picture
from tutorial_lib.viz.figures.dashboard import Moment
from tutorial_lib.viz.figures.film import exact_png, film_encoder
from tutorial_lib.viz.figures.panels import stacked
from tutorial_lib.world.simulation import Simulation

EVERY = 4
"""Simulation steps for each frame of the film."""
FILM_RATE = 12.0
"""Frames a second: nearly five times as fast as the robot."""
Write = Callable[[Picture], None]
"""Adds a picture to a film."""


@contextmanager
def demo_files(folder: Path) -> Iterator[tuple[Write, Callable[[Sequence[Picture], Any], None]]]:
    """Write the files of a demo: all of them or none, so that all tell of the same run.

    Yields:
        What adds a picture to the film, and what writes the pictures of the strip and the figures.
    """
    files = (folder / name for name in (FILM, STRIP, FIGURES))
    with atomic_paths(*files) as (film, strip, figures):

        def finish(pictures: Sequence[Picture], outcome: Any) -> None:  # noqa: ANN401 - a dataclass
            strip.write_bytes(exact_png(stacked(pictures)))
            figures.write_text(json.dumps(asdict(outcome), indent=1) + "\n", encoding="utf-8")

        with film_encoder(folder / FILM, film, FILM_RATE) as write:
            yield write, finish


class FilmRecorder:
    """Keeps a `Moment` of every `EVERY`-th step of one robot, and its track.

    Attributes:
        track: positions (2,), step by step.
        moments: for the film.
    """

    _simulation: Simulation

    def __init__(
        self,
        make_moment: Callable[[Simulation, Array], Moment],
        watch: Callable[[Moment], None] = lambda moment: None,
    ) -> None:
        """Record.

        Args:
            make_moment: makes a moment of a simulation and the track (T, 2).
            watch: is called with each moment as soon as there is one.
        """
        self._make_moment, self._watch = make_moment, watch
        self.track: list[Array] = []
        self.moments: list[Moment] = []

    def __call__(
        self, simulation: Simulation, robots: Robots, observations: Observation, actions: Array
    ) -> None:
        """See `driving.rollouts.Record`."""
        del robots, observations, actions
        self._simulation = simulation
        self.track.append(simulation.poses[0, :2])
        if len(self.track) % EVERY == 1:
            self._keep(self._make_moment(simulation, np.array(self.track)))

    def finish(self, *, reached: bool, ending: str) -> Drive:
        """Add the last moment, which says how it ended and stays on screen for two seconds.

        Returns:
            How the rollout went.
        """
        simulation = self._simulation
        self.track.append(simulation.poses[0, :2])
        last = replace(self._make_moment(simulation, np.array(self.track)), ending=ending)
        for _ in range(round(2 * FILM_RATE)):
            self._keep(last)
        return Drive(
            reached=reached,
            ending=ending,
            collided=bool(simulation.collided[0]),
            seconds=round(simulation.seconds, 1),
            driven=round(float(arc_length(self.track)[-1]), 2),
        )

    def _keep(self, moment: Moment) -> None:
        self.moments.append(moment)
        self._watch(moment)
