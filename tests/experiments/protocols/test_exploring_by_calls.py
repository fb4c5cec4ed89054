"""One robot that is driven by calls, and an episode that is watched."""

import networkx as nx
import numpy as np
import pytest

from tutorial_lib.agents.nts import NTSAgent
from tutorial_lib.checks.nb09.explore import explore
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.protocols.called_robot import CalledRobot
from tutorial_lib.experiments.protocols.watching import watch
from tutorial_lib.exploration.episodes import draw_episodes, exploration_world
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.exploration.true_geometry import TrueGeometry
from tutorial_lib.geometry import relative
from tutorial_lib.world.worlds import scene_of

NAME = exploration_world(10_100)


@pytest.fixture(scope="module")
def scene():
    return scene_of(NAME)


@pytest.fixture(scope="module")
def episodes(scene):
    counts = {"easy": 2, "medium": 2, "hard": 4}
    return draw_episodes(NAME, scene, counts, np.random.default_rng(4))


def task_of(scene, episodes, **options):
    return ExplorationTask({NAME: scene}, episodes, np.random.default_rng(1), **options)


def robot_of(scene, episode, **options):
    task = task_of(scene, episode, **options)
    return CalledRobot(task, TrueGeometry(task))


@pytest.mark.full
def test_the_loop_of_the_notebook_reaches_goals(scene, episodes):
    reached = 0
    for number in range(len(episodes)):
        robot = robot_of(scene, episodes[[number]])
        stopped, graph, ghosts = explore(robot)
        assert stopped <= bool(robot.task.done[0])
        assert robot.task.success[0] <= stopped
        assert not len(graph) or nx.is_connected(graph)
        assert set(graph.nodes) == set(robot.nodes)
        assert all(node in graph and 0 <= direction < 12 for node, direction in ghosts)
        reached += int(robot.task.success[0])
    assert reached >= len(episodes) - 2


def test_a_drive_ends_where_it_is_sent(scene, episodes):
    robot = robot_of(scene, episodes[[7]], noise=False)
    robot.remember(0)
    assert robot.node() == 0
    assert np.linalg.norm(robot.nodes[0]) == 0
    open_to = np.flatnonzero(robot.explorable())
    assert len(open_to)
    direction = int(open_to[0])
    steps = robot.steps
    assert robot.to_ghost((0, direction))
    assert robot.steps < steps
    (place,) = robot.beside().values()
    back = relative(place, np.zeros(3))
    bearing = np.arctan2(back[1], back[0])
    assert abs(np.angle(np.exp(1j * (bearing - direction * np.pi / 6)))) < np.deg2rad(20)
    assert np.linalg.norm(back[:2]) == pytest.approx(3.0, abs=0.6)
    robot.to_node(0)
    assert np.linalg.norm(robot.beside()[0][:2]) < 0.6


def test_the_node_before_is_always_beside(scene, episodes):
    robot = robot_of(scene, episodes[[7]])
    assert robot.beside() == {}
    robot.remember(0)
    assert robot.beside() == {}
    robot.to_ghost((0, int(np.flatnonzero(robot.explorable())[0])))
    robot.nodes[0] = np.array([30.0, 0.0, 0.0])
    before = robot.beside()
    assert np.linalg.norm(before[0][:2]) > 20
    assert robot.node() is None
    robot.remember(1)
    assert robot.beside().keys() == before.keys()  # in whatever order the two are called


def test_without_steps_nothing_moves(scene, episodes):
    robot = robot_of(scene, episodes[[6]])
    robot.remember(0)
    robot.task.step([0])
    assert robot.steps == 0
    before = robot.task.poses.copy()
    robot.to_node(0)
    robot.to_ghost((0, 3))
    assert not robot.to_goal()
    assert np.array_equal(robot.task.poses, before)


def test_a_robot_has_one_episode(scene, episodes):
    with pytest.raises(InputError, match="8 episodes; give it one"):
        robot_of(scene, episodes)


def test_an_episode_is_watched_from_its_start_to_its_end(scene, episodes):
    task = task_of(scene, episodes[[5]])
    agent = NTSAgent(TrueGeometry(task), np.random.default_rng(0))
    seen = watch(task, agent)
    assert len(seen.moments) == task.steps[0]
    assert np.allclose([m.pose for m in seen.moments], np.array(task.path)[:-1, 0])
    assert np.allclose(seen.moments[0].believed, seen.moments[0].pose)
    assert np.allclose(seen.scores, seen.truth, atol=0.02)  # the model is the true geometry
    for moment in seen.moments:
        assert len(moment.nodes) <= len(seen.panoramas)
        for node, direction, place, score in moment.ghosts:
            local = relative(moment.nodes[node], [*place, 0.0])
            bearing = np.arctan2(local[1], local[0])
            assert round(bearing * 6 / np.pi) % 12 == direction
            assert score == seen.scores[node, direction]
        assert (moment.target is None) or not moment.found


def test_without_noise_it_is_where_it_believes_to_be(scene, episodes):
    task = task_of(scene, episodes[[4]], noise=False)
    seen = watch(task, NTSAgent(TrueGeometry(task), np.random.default_rng(0)))
    for moment in seen.moments:
        assert np.allclose(moment.believed[:2], moment.pose[:2], atol=1e-6)
    assert np.allclose(seen.moments[-1].nodes[0, :2], seen.moments[0].pose[:2], atol=1e-6)
