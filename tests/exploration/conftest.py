"""Small worlds and episodes for exploration."""

import numpy as np
import pytest

from tutorial_lib.exploration.episodes import Episodes, draw_episodes, exploration_world
from tutorial_lib.world.worlds import scene_of

WORLDS = (exploration_world(10_100), exploration_world(10_101, "wayfinding"))


@pytest.fixture(scope="session")
def scenes():
    """An apartment, and an office with signs."""
    return {name: scene_of(name) for name in WORLDS}


@pytest.fixture(scope="session")
def episodes(scenes):
    """Four episodes of each difficulty in each of two worlds."""
    counts = {"easy": 4, "medium": 4, "hard": 4}
    parts = [
        draw_episodes(name, scene, counts, np.random.default_rng([3, number]))
        for number, (name, scene) in enumerate(scenes.items())
    ]
    return Episodes.joined(parts)
