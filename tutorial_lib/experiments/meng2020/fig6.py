"""Fig. 6 of Meng 2020: one long trajectory, followed by its anchors."""

from dataclasses import dataclass

import numpy as np

from tutorial_lib.driving.data.demonstrations import demonstrate
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.trajectories import Trajectory
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options, Rows
from tutorial_lib.experiments.protocols.following import CARS, UNDER_WAY, Guide
from tutorial_lib.experiments.protocols.local_control import WORLDS
from tutorial_lib.learning.threads import use_threads
from tutorial_lib.topology.following.transitions import State
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.simulation import STEP
from tutorial_lib.world.worlds import local_world, scene_of


@dataclass(frozen=True)
class Settings:
    """Settings of Fig. 6.

    Attributes:
        length: metres of the paper's trajectory.
        context: of C and RE.
        threshold: p_sparsify.
        places: numbered along the trajectory; the figure shows their images.
    """

    length: float = 23.0
    context: str = "k5"
    threshold: float = 0.99
    places: int = 9


def run(options: Options, settings: Settings) -> tuple[Rows, list[str]]:
    """Follow the recorded trajectory whose length is closest to that of the paper's."""
    use_threads(2)
    name = local_world(options.worlds[0])
    scene = scene_of(name)
    chosen = choose_trajectory(name, scene, options.seed, settings.length)
    guide = Guide(RecordedWorld(scene, [chosen]), settings.context)
    anchors = guide.anchors(0, settings.threshold)
    metres, tracks, log = guide.follow([anchors])
    steps = np.flatnonzero(np.isfinite(log.probability[:, 0]))
    numbered = steps[np.linspace(0, len(steps) - 1, settings.places).astype(int)]
    rows: Rows = [
        {
            "place": number,
            "seconds": STEP * step,
            "x": tracks[step, 0, 0],
            "y": tracks[step, 0, 1],
            "heading": tracks[step, 0, 2],
            "state": State(log.state[step, 0]).name.lower(),
            "active": int(log.active[step, 0]),
            "anchors": len(anchors),
            "probability": log.probability[step, 0],
        }
        for number, step in enumerate(numbered, start=1)
    ]
    length = chosen.arc_length[-1]
    note = f"{metres[0]:.1f} of {length:.1f} m followed by {len(anchors)} of {len(chosen)} frames"
    return rows, [note]


def choose_trajectory(
    world: str, scene: Scene, seed: int, length: float = Settings.length
) -> Trajectory:
    """The recorded trajectory closest to `length` metres, counted once the car is under way."""
    recorded = demonstrate(world, scene, CARS, seed)
    moved = [part.since(UNDER_WAY) for part in recorded if part.arc_length[-1] > 2 * UNDER_WAY]
    return min(moved, key=lambda part: abs(part.arc_length[-1] - length))


EXPERIMENT = Experiment("meng_fig6", run, WORLDS[:1], settings=Settings(), canary=Settings())
