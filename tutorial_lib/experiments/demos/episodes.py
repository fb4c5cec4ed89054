"""The episode of the demo of exploration: one that is drawn, or one that was asked for."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.demos.ends import End
from tutorial_lib.exploration.episodes import (
    DIFFICULTIES,
    SUCCESS,
    Episodes,
    draw_episodes,
)
from tutorial_lib.world.bodies import DifferentialDrive
from tutorial_lib.world.scene import Scene


def draw_episode(name: str, scene: Scene, seed: int) -> Episodes:
    """One episode, as difficult as the world allows.

    Raises:
        InputError: when not even an easy one fits.
    """
    *harder, easiest = reversed(DIFFICULTIES)
    for difficulty in harder:
        with suppress(InputError):
            return draw_episodes(name, scene, {difficulty: 1}, np.random.default_rng(seed))
    try:
        return draw_episodes(name, scene, {easiest: 1}, np.random.default_rng(seed))
    except InputError as error:
        least = DIFFICULTIES[easiest][0]
        words = f"demo: {name} has no two places {least:g} m apart ({error}); give a larger map"
        raise InputError(words) from error


def episode_between(
    name: str, scene: Scene, start: End | None, goal: End | None, seed: int
) -> Episodes:
    """The episode from a start to a goal that were asked for; the other is drawn where one was.

    Raises:
        InputError: when one of them cannot be had, or they are too near each other.
    """
    rng, paths = np.random.default_rng(seed), GridPaths(scene.clearance)
    begin, end = (
        None if one is None else one.find(scene, paths, DifferentialDrive())
        for one in (start, goal)
    )
    if begin is None or end is None:
        given = end if begin is None else begin
        if given is None:
            raise InputError("demo: give a start or a goal")
        metres = paths.fields(given[None, :2], shortest=True).distance(paths.points)
        low, high = DIFFICULTIES["hard"]
        apart = np.linalg.norm(paths.points - given[:2], axis=1) >= SUCCESS
        reachable = np.where(apart & (metres < high), metres, -1.0)
        if reachable.max() < 0:
            words = f"no place {SUCCESS:.0f} to {high:.0f} m away can be reached"
            raise InputError(f"demo: {words}; choose another start or goal")
        far = np.flatnonzero(reachable >= min(low, reachable.max()))
        drawn = np.append(paths.points[rng.choice(far)], np.nan)
        begin, end = (drawn, end) if begin is None else (begin, drawn)
    starts, goals = (np.array([one]) for one in (begin, end))
    for poses in (starts, goals):
        poses[np.isnan(poses)] = rng.uniform(-np.pi, np.pi)
    shortest = paths.between(starts[:, :2], goals[:, :2])
    if np.linalg.norm(starts[0, :2] - goals[0, :2]) < SUCCESS:
        raise InputError(
            f"--goal: {shortest[0]:.1f} m from the start; choose places {SUCCESS:.0f} m apart"
        )
    fits = [word for word, (low, high) in DIFFICULTIES.items() if low <= shortest[0] < high]
    return Episodes((name,), starts, goals, shortest, (fits[0] if fits else "",))
