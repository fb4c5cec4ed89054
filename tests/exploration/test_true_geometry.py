"""The oracle model returns the labels."""

import numpy as np
import pytest

from tutorial_lib.errors import InputError
from tutorial_lib.exploration.labels import PanoramaLabels
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.exploration.true_geometry import TrueGeometry
from tutorial_lib.interfaces import ExplorationModel
from tutorial_lib.observation import Observation


def test_its_answers_are_the_labels(scenes, episodes):
    task = ExplorationTask(scenes, episodes, np.random.default_rng(0))
    model = TrueGeometry(task)
    assert isinstance(model, ExplorationModel)
    seen = task.observe()
    sources, goals = model.embed(seen), model.embed(task.goals())
    for name, scene in scenes.items():
        rows = np.flatnonzero([world == name for world in episodes.worlds])
        count = len(rows)
        poses = np.concatenate([episodes.starts[rows], episodes.goals[rows]])
        labels = PanoramaLabels(scene, poses.astype(np.float32).astype(float))
        first, second = np.arange(count), np.arange(count, 2 * count)
        here, there = sources[rows], goals[rows]
        assert np.array_equal(model.explorable(here) > 0.5, labels.explorable[:count])
        assert np.array_equal(model.same_node(here, there) > 0.5, labels.connected(first, second))
        assert np.allclose(model.relative(here, there), labels.relative(first, second), atol=1e-5)
        assert np.allclose(model.scores(here, there), labels.scores(first, second), atol=1e-3)
    assert np.array_equal(model.ranges(seen), seen.depth)
    rgb = Observation(seen.image, None, seen.laser, seen.odometry, seen.speed, seen.steering)
    assert np.allclose(model.ranges(rgb), seen.depth, atol=1e-4)


def test_it_knows_no_picture_from_elsewhere(scenes, episodes):
    task = ExplorationTask(scenes, episodes, np.random.default_rng(0))
    other = ExplorationTask(scenes, episodes[:3], np.random.default_rng(0))
    other.step([1, 1, 1])
    with pytest.raises(InputError, match="this moment and goals only"):
        TrueGeometry(task).embed(other.observe())
