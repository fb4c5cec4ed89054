"""Table I with smoothed waypoints: is C better when it averages its last predictions?"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tutorial_lib.driving.control.smoothed import SHARE
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Finding, Options, Rows
from tutorial_lib.experiments.common.statistics import difference, over_worlds
from tutorial_lib.experiments.protocols.estimators import CONTROLLERS
from tutorial_lib.experiments.protocols.local_control import WORLDS, attempt, clean_condition
from tutorial_lib.geometry import Array
from tutorial_lib.learning.estimators import WaypointNetwork
from tutorial_lib.learning.policies import by_smoothed_waypoints
from tutorial_lib.parallel import for_each


@dataclass(frozen=True)
class Settings:
    """Settings of the ablation.

    Attributes:
        controllers: names as in Table I.
        shares: of the newest waypoint in the average; with 1, which is first, nothing is smoothed.
        episodes: in each generated world.
        map_episodes: in the world of a map's file.
    """

    controllers: tuple[str, ...] = tuple(CONTROLLERS)
    shares: tuple[float, ...] = (1.0, SHARE)
    episodes: int = 100
    map_episodes: int = 200


def run(options: Options, settings: Settings) -> tuple[Rows, list[Finding]]:
    """Run the clean episodes of Table I with each controller, smoothed and not.

    With `options.map` the only world is that file's.
    """
    places: list[int | Path] = [*options.worlds]
    if options.map is not None:
        places = [options.map]
        settings = replace(settings, episodes=settings.map_episodes)
    parts = for_each(run_world, places, options, settings, label="smoothing")
    rows: Rows = []
    gains = []
    first, *others = settings.shares
    for name in settings.controllers:
        worlds = np.repeat(np.arange(len(parts)), [len(part[name, first]) for part in parts])
        reached = {s: np.concatenate([part[name, s] for part in parts]) for s in settings.shares}
        for share, found in reached.items():
            row = dict(zip(("success", "low", "high"), over_worlds(found, worlds), strict=True))
            rows.append({"controller": name, "share": share, "episodes": len(found), **row})
        for share in others:
            gain = difference(reached[share], reached[first], worlds)
            gains.append(Finding(f"{name}: {share:g} - {first:g}", *gain))
    return rows, gains


def run_world(
    place: int | Path, options: Options, settings: Settings
) -> dict[tuple[str, float], Array]:
    """Whether each controller reached each target of one world, by its name and the share.

    Args:
        place: seed of a generated world, or a map's file.
        options: have the seed of trajectories and episodes, and the family.
        settings: the controllers, the shares and how many episodes.
    """
    condition = clean_condition(place, settings.episodes, options)
    found = {}
    for name in settings.controllers:
        predictor = WaypointNetwork(CONTROLLERS[name])
        for share in settings.shares:
            policy = by_smoothed_waypoints(predictor, share)
            found[name, share] = attempt(condition, policy)["reached"]
    return found


EXPERIMENT = Experiment(
    "ablation_smoothing",
    run,
    WORLDS,
    WORLDS[:10],
    Settings(),
    quick_settings=Settings(episodes=40, map_episodes=40),
    canary=Settings(episodes=2, map_episodes=2),
    accepts=frozenset({"map", "family"}),
)
