"""Goals are pictures: nothing else of who took them is kept."""

from dataclasses import replace

import numpy as np
import pytest

from tutorial_lib.interfaces import Goals, Observation


def sensed(count, depth=None):
    """Observations in which nothing is zero."""
    rng = np.random.default_rng(0)
    image = rng.integers(1, 255, (count, 2, 4, 3), dtype=np.uint8)
    laser, odometry = rng.uniform(1, 5, (count, 8)).astype(np.float32), rng.normal(size=(count, 3))
    return Observation(image, depth, laser, odometry, odometry[:, 0], odometry[:, 1])


@pytest.mark.parametrize("depth", [None, np.full((3, 4), 2.5)])
def test_goals_keep_images_depth_and_contexts_and_nothing_else(depth):
    taken, contexts = sensed(3, depth), np.arange(6.0).reshape(3, 2)
    goals = Goals(taken, contexts)
    shown = goals.observations
    assert len(goals) == len(shown) == 3
    assert (shown.image == taken.image).all()
    assert shown.depth is taken.depth
    assert goals.contexts is contexts
    assert shown.laser.shape == taken.laser.shape
    assert np.isnan(shown.laser).all()
    for name in ("odometry", "speed", "steering"):
        assert getattr(shown, name).shape == getattr(taken, name).shape
        assert (getattr(shown, name) == 0.0).all()
    assert (taken.odometry != 0.0).all()  # what was observed is left as it was


def test_no_other_way_to_make_goals_keeps_more():
    goals = replace(Goals(sensed(1), np.zeros((1, 3))), observations=sensed(1))
    assert (goals.observations.odometry == 0.0).all()
    assert np.isnan(goals.observations[[0]].laser).all()
