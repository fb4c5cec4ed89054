"""A car in a room turns where its path does, and at its goal until it faces that."""

from types import SimpleNamespace

import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.geometry import compose, to_local, wrap
from tutorial_lib.topology.following.anchor_paths import AnchorPaths
from tutorial_lib.topology.following.follower import Follower
from tutorial_lib.topology.following.transitions import State
from tutorial_lib.topology.following.turns import TURN_TIME, PathTurns
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.simulation import STEP, Sensors, Simulation

START = np.array([2.0, 5.0, 0.0])
THERE = [[x, 5.0, 0.0] for x in (3.5, 5.0, 6.5)]
BACK = [[x, 5.0, np.pi] for x in (6.3, 4.8, 3.3)]


class Sight:
    """C_WP and RE of a robot that knows its pose by exact odometry; targets are poses (N, 3)."""

    view, k = SimpleNamespace(), 0

    def __init__(self, facing=1.0):
        self.facing = facing  # rad within which RE sees a target

    def prepare(self, contexts):
        return np.asarray(contexts)

    def predict(self, observations, targets):
        poses = compose(START, observations.odometry)
        gap = np.linalg.norm(poses[:, :2] - targets[:, :2], axis=1)
        aside = np.abs(wrap(poses[:, 2] - targets[:, 2]))
        overlap = np.clip(1 - gap / 4, 0, 1) * np.clip(1 - aside / 2, 0, 1)
        return to_local(poses, targets[:, :2]), np.column_stack([overlap, overlap])

    def probability(self, observations, prepared):
        poses = compose(START, observations.odometry)
        gap = np.linalg.norm(poses[:, :2] - prepared[:, :2], axis=1)
        aside = np.abs(wrap(poses[:, 2] - prepared[:, 2]))
        return np.where((gap < 2.5) & (aside < self.facing), 0.999, 0.02)


def followed(path, turns, seconds, sight):
    """A follower that drove along a path of poses, and the car."""
    simulation = Simulation(Scene(make_box()), START[None], sensors=Sensors(camera=None))
    poses, robot = np.array(path), np.array([0])
    paths = AnchorPaths(poses, poses, [np.arange(len(poses))])
    follower = Follower(paths, sight, RMPController(), sight, starts=[0])
    follower.assign(0, np.arange(len(poses)), turns)
    for _ in range(round(seconds / STEP)):
        simulation.step(follower.act(simulation.observe(), robot))
        if follower.memory.over[0]:
            break
    assert not simulation.collided.any()
    return follower, simulation.poses[0]


def test_a_path_that_goes_back_is_followed_by_turning_where_it_does():
    follower, pose = followed(THERE + BACK, {3: np.pi}, 60, Sight())
    assert follower.memory.done[0]
    assert pose[:2] == pytest.approx(BACK[-1][:2], abs=0.4)
    assert abs(wrap(pose[2] - np.pi)) < 1.0
    states = follower.log().state[:, 0]
    turning = np.flatnonzero(states == State.TURN)
    assert 20 < len(turning) < TURN_TIME / STEP
    assert follower.log().visited[turning[0], 0] == 2


def test_without_a_turn_it_is_lost_there():
    follower, pose = followed(THERE + BACK, {}, 60, Sight())
    assert follower.memory.lost[0]
    assert pose[0] > 5.5


def test_a_turn_after_which_nothing_is_seen_comes_to_an_end():
    blind = [[x, 20.0, np.pi] for x in (6.3, 4.8)]
    follower, _ = followed(THERE + blind, {3: np.pi}, 60, Sight())
    assert follower.memory.lost[0]
    turning = (follower.log().state[:, 0] == State.TURN).sum() * STEP
    assert turning == pytest.approx(TURN_TIME, abs=0.5)


def test_at_the_goal_it_turns_until_it_faces_it():
    goal = [5.0, 5.0, np.pi]
    follower, pose = followed([[3.5, 5.0, 0.0], goal], {}, 60, Sight(facing=4.0))
    assert follower.memory.done[0]
    assert np.linalg.norm(pose[:2] - goal[:2]) < 0.5
    assert abs(wrap(pose[2] - np.pi)) < np.deg2rad(60)


def test_turns_are_those_of_each_robot_s_path():
    turns = PathTurns(2)
    turns.set(1, {2: 1.0})
    robots = np.array([0, 1])
    assert turns.before(robots, np.array([2, 2])).tolist() == [False, True]
    assert turns.before(robots, np.array([1, 1])).tolist() == [False, False]
    turns.set(1, {})
    assert not turns.before(robots, np.array([2, 2])).any()
