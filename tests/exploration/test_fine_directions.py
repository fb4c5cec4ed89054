"""More directions and nearer ghosts than the paper's, with the true geometry."""

import numpy as np
import pytest

from tutorial_lib.agents.nts import NTSAgent, NTSSettings
from tutorial_lib.exploration.ghost_graph import GhostGraph
from tutorial_lib.exploration.graph_update import free_metres
from tutorial_lib.exploration.labels import PanoramaLabels
from tutorial_lib.exploration.task import ExplorationTask, explore
from tutorial_lib.exploration.true_geometry import TrueGeometry

FINE = {"directions": 24, "radius": 2.0}


@pytest.fixture
def task(scenes, episodes):
    return ExplorationTask(scenes, episodes, np.random.default_rng(1))


def test_true_geometry_answers_with_the_labels_of_these_directions(scenes, episodes, task):
    model = TrueGeometry(task, **FINE)
    here, there = model.embed(task.observe()), model.embed(task.goals())
    explorable, scores = model.explorable(here), model.scores(here, there)
    same = model.same_node(here, there)
    assert explorable.shape == scores.shape == (len(episodes), 24)
    for name in dict.fromkeys(episodes.worlds):
        rows = np.flatnonzero(np.array(episodes.worlds) == name)
        poses = np.concatenate([episodes.starts[rows], episodes.goals[rows]])
        labels = PanoramaLabels(scenes[name], poses.astype(np.float32), **FINE)
        source, goal = np.arange(len(rows)), np.arange(len(rows)) + len(rows)
        assert np.array_equal(explorable[rows], labels.explorable[source])
        assert np.allclose(scores[rows], labels.scores(source, goal), atol=1e-3)
        assert np.array_equal(same[rows], labels.connected(source, goal))


def test_ghosts_hang_two_metres_away_in_24_directions(task):
    agent = NTSAgent(TrueGeometry(task, **FINE), np.random.default_rng(0), NTSSettings(**FINE))
    explore(task, agent)
    assert task.success.mean() >= 0.8
    ghosts = [ghost for robot in agent.robots for ghost in robot.memory.graph.ghosts.values()]
    directions = {ghost.direction for ghost in ghosts}
    assert max(directions) > 12
    metres = np.array([ghost.metres for ghost in ghosts])
    assert metres.max() == 2.0  # those of the reserve are nearer
    for robot in agent.robots:
        assert all(len(row) == 24 for row in robot.scores)


@pytest.mark.full
@pytest.mark.parametrize("changed", [{"use_graph": False}, {"use_score": False}])
def test_the_ablations_have_as_many_directions(task, changed):
    settings = NTSSettings(**FINE, **changed)
    agent = NTSAgent(TrueGeometry(task, **FINE), np.random.default_rng(0), settings)
    explore(task, agent)
    assert task.success.mean() >= 0.5


def test_a_direction_is_free_up_to_the_radius():
    free = free_metres(np.full((1, 192), 2.5), 24, 2.0)
    assert free.shape == (1, 24)
    assert np.allclose(free, 2.0)
    graph = GhostGraph(24, 2.0)
    graph.add_node(np.arange(24) == 18)
    (ghost,) = graph.ghosts.values()
    assert np.allclose(graph.place_of(ghost), [0.0, -2.0])
