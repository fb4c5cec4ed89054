"""Rollouts for the check of their labels, in notebook 03."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tutorial_lib.driving.metrics import time_limit
from tutorial_lib.geometry import Array

Case = tuple[Array, Array, NDArray[np.bool_], Array]
"""times (T,), gaps (T, N), touched (T, N), geodesic (N,)."""
Story = tuple[str, list[float], list[float | tuple[float, float]], float]
"""What it is like, metres to the target every 5 s, when something is touched (single moments or
from, to), and the geodesic."""

STORIES: tuple[Story, ...] = (
    ("arrives in time", [2.0, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0], [], 2.0),
    ("never comes near", [3.0, 2.5, 2.2, 2.0, 2.0, 2.0, 2.0], [], 3.0),
    ("scrapes past a post, then arrives", [2.0, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0], [3.0], 2.0),
    ("arrives, touches a wall later", [2.0, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0], [11.0], 2.0),
    ("arrives too late", [2.0, 1.5, 1.0, 0.8, 0.1, 0.1, 0.1], [], 2.0),
    ("needs some of the 5 s", [1.5, 0.6, 0.0, 0.0, 0.0, 0.0, 0.0], [], 1.5),
    ("passes the target, rolls on", [1.6, 0.0, 1.6, 3.0, 4.0, 4.0, 4.0], [], 1.6),
    ("stops 0.4 m from the target", [2.0, 0.7, 0.4, 0.4, 0.4, 0.4, 0.4], [], 2.0),
    ("ends at a wall", [3.0, 1.5, 1.0, 1.0, 1.0, 1.0, 1.0], [(8.0, 30.0)], 3.0),
    ("has a long path", [5.5, 4.0, 2.5, 1.2, 0.1, 0.1, 0.1], [], 5.5),
    ("leans on a wall as it arrives", [2.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0], [(7.0, 30.0)], 2.0),
    ("stops 0.2 m from the target", [2.0, 0.7, 0.2, 0.2, 0.2, 0.2, 0.2], [], 2.0),
    ("stands at the target from the start", [0.1] * 7, [], 0.1),
    ("is there at the start, rolls away", [0.1, 1.5, 2.0, 2.0, 2.0, 2.0, 2.0], [(6.0, 9.0)], 0.1),
    ("touches a wall at the start", [0.1] * 7, [0.0], 0.1),
    ("is there in the last moment alone", [9.0, 9.0, 9.0, 9.0, 9.0, 9.0, 0.1], [], 9.0),
    ("is late by a second", [2.0, 2.0, 2.0, 0.0, 0.0, 0.0, 0.0], [], 2.1),
    ("is slow, its path is long", [6.0, 5.5, 5.0, 4.5, 4.0, 0.0, 0.0], [], 6.3),
)


def rollouts_of(stories: Sequence[Story] = STORIES) -> Case:
    """The arguments for these stories, every 0.1 s for half a minute."""
    times = np.arange(301) / 10
    gaps = np.stack([np.interp(times, 5.0 * np.arange(7), s[1]) for s in stories], axis=1)
    touched = np.zeros(gaps.shape, dtype=bool)
    for number, story in enumerate(stories):
        for moment in story[2]:
            begin, end = moment if isinstance(moment, tuple) else (moment, moment)
            touched[round(10 * begin) : round(10 * end) + 1, number] = True
    return times, gaps, touched, np.array([story[3] for story in stories])


def at_limits() -> Case:
    """Two cars at exactly 0.30 m and at exactly t_max, and one that touches in that moment."""
    times = np.array([0.0, 5.0, 15.0, 20.0])
    gaps = np.array([[3.0, 3.0, 3.0], [0.3, 2.0, 0.2], [0.9, 0.1, 0.0], [0.9, 2.0, 0.0]])
    touched = np.zeros(gaps.shape, dtype=bool)
    touched[1, 2] = touched[3, 1] = True
    return times, gaps, touched, np.full(3, 3.0)


def last_moment() -> Case:
    """Two cars that are near in the last of three moments alone; one touches something then."""
    gaps = np.array([[2.0, 2.0, 0.1], [1.0, 1.0, 2.0], [0.2, 0.2, 3.0]])
    touched = np.zeros(gaps.shape, dtype=bool)
    touched[2, 1] = True
    return np.array([0.0, 4.0, 8.0]), gaps, touched, np.full(3, 2.0)


def random_rollouts(moments: int, cars: int, seed: int) -> Case:
    """Rollouts at uneven times; some touch something, and half of them come near somewhere."""
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.uniform(0.0, 60.0 / moments, moments))
    times -= times[0]
    gaps = rng.uniform(0.0, 20.0 / moments + 0.8, (moments, cars))
    touched = rng.random((moments, cars)) < 1.0 / moments
    geodesic = rng.uniform(0.2, 5.0, cars)
    # None is within a hair of its limit.
    near = np.abs(times[:, None] - time_limit(geodesic)).min(axis=0) < 1e-3
    return times, gaps, touched, np.where(near, geodesic + 0.01, geodesic)
