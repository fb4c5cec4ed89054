"""LTVN's model, tuned to one building: labels from odometry, blocks, and which model is kept."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from tests.conftest import make_box
from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import Experience
from tutorial_lib.learning.analytic_label import AnalyticLabel
from tutorial_lib.learning.estimators import RelativeNetwork
from tutorial_lib.learning.fine_tuning import (
    ANY,
    FAR,
    LATER,
    NEAR,
    TUNED,
    OwnDrives,
    by_odometry,
    fine_tuned,
)
from tutorial_lib.learning.networks import Architecture, LocalNetwork
from tutorial_lib.se2 import compose, relative
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.simulation import Sensors, Simulation

STEP = 0.05
"""Metres between two frames of the drives below."""
SMALL = Architecture(0, view="rgbd16", outputs="relative")


def drive(start, frames=80, turn=0.0):
    """A drive from a pose in a box, with odometry that begins at the origin."""
    poses = [np.array(start, float)]
    for _ in range(frames - 1):
        poses.append(compose(poses[-1], (STEP, 0.0, turn)))
    poses = np.array(poses)
    scene = Scene(make_box(16.0, 10.0, [(8.0, 5.0, 0.5)]))
    seen = Simulation(scene, poses, sensors=Sensors(with_depth=True)).observe()
    seen = replace(seen, odometry=relative(poses[0], poses))
    return Experience(seen, 0.1 * np.arange(frames))


@pytest.fixture(scope="module")
def drives():
    return [drive((2.0, 2.0 + n, 0.1 * n)) for n in range(3)] + [drive((2.0, 6.0, 0.0), turn=0.03)]


def label_of(poses, source, target):
    """(reached, known) of one pair of frames."""
    pair = (np.array([source]), np.array([target]))
    reached, known = by_odometry(np.array(poses, float), *pair, AnalyticLabel())
    return bool(reached[0]), bool(known[0])


def test_a_straight_drive_reaches_what_is_ahead_and_not_what_is_behind():
    poses = [(STEP * i, 0.0, 0.0) for i in range(200)]
    assert label_of(poses, 0, 30) == (True, True)
    assert label_of(poses, 30, 0) == (False, True)  # behind
    assert label_of(poses, 0, LATER) == (False, True)  # three metres, as far as the label goes
    assert label_of(poses, 0, LATER - 1) == (True, True)
    assert label_of(poses, 0, LATER + 10) == (False, False)  # later, and not far enough away
    assert label_of(poses, 0, round(FAR / STEP) + 1) == (False, True)


def test_a_detour_tells_nothing_of_what_is_in_sight():
    out = [(0.03 * i, 0.06 * i, 0.8) for i in range(20)]
    back = [(0.57 + 0.03 * i, 1.14 - 0.06 * i, 0.8) for i in range(20)]
    assert label_of(out + back, 0, 12) == (True, True)
    assert label_of(out + back, 0, 39) == (False, False)


def test_a_drive_that_returns_is_no_far_pair():
    there = [(STEP * i, 0.0, 0.0) for i in range(120)]
    again = [(STEP * (119 - i), 0.0, np.pi) for i in range(120)]
    assert label_of(there + again, 0, 239) == (False, False)  # the same place, much later


def test_a_target_that_looks_elsewhere_is_not_reachable():
    turning = [(0.01 * i, 0.0, 0.05 * i) for i in range(60)]
    assert label_of(turning, 0, 50) == (False, True)


def test_blocks_hold_what_odometry_says(drives):
    source = OwnDrives(drives, replace(SMALL, k=2), worlds=4, targets=8)
    block = source.block([0, 1])
    starts, count = NEAR + ANY, 4 * 8
    assert block.contexts.shape[:2] == (count, 5)
    assert len(block.current) == count * starts
    assert block.context_poses.shape == (count * starts, 5, 4)
    middle = block.context_poses[:, 2]
    assert np.allclose(middle[:, :2], block.waypoint, atol=1e-5)
    near = block.reached > 0
    assert near.any()
    assert not near.all()
    assert (block.weight[near] == 1).all()
    assert (np.hypot(*block.waypoint[near].T) < AnalyticLabel().distance + 1e-5).all()
    assert (block.placed == block.reached).all()
    again = source.block([0, 1])
    assert all(np.array_equal(getattr(block, n), getattr(again, n)) for n in vars(block))
    assert not np.array_equal(block.waypoint, source.block([0, 2]).waypoint)


def test_the_frame_of_odometry_does_not_matter(drives):
    moved = []
    for one in drives:
        odometry = compose(np.array([5.0, -3.0, 2.0]), one.observations.odometry)
        moved.append(replace(one, observations=replace(one.observations, odometry=odometry)))
    one, other = (OwnDrives(some, SMALL).block([3]) for some in (drives, moved))
    assert np.allclose(one.waypoint, other.waypoint, atol=1e-5)
    assert np.array_equal(one.reached, other.reached)


def test_it_learns_where_targets_are(drives):
    torch.manual_seed(0)
    model = RelativeNetwork(LocalNetwork(SMALL))
    settings = replace(TUNED, max_steps=150, targets=4, warmup_steps=5, learning_rate=2e-3)
    tuned = fine_tuned(model, drives, settings, kept=0.0)
    assert tuned is not model
    assert tuned.calibration is model.calibration
    seen = drives[1].observations
    images = model.view.of(seen)
    frames = np.arange(0, 50)
    true = relative(seen.odometry[frames], seen.odometry[frames + 20])

    def error(one):
        where = one.predict(seen[frames], images[frames + 20][:, None])[1]
        return np.hypot(*(where - true)[:, :2].T).mean()

    assert error(tuned) < 0.7 * error(model)
    half = fine_tuned(model, drives, settings)
    weights = (one.network.state_dict().values() for one in (model, tuned, half))
    assert all(torch.allclose((a + b) / 2, c, atol=1e-6) for a, b, c in zip(*weights, strict=True))


def test_a_model_that_would_get_worse_stays_as_it_was(drives):
    model = RelativeNetwork(LocalNetwork(SMALL))
    ruinous = replace(TUNED, max_steps=2, learning_rate=3.0, warmup_steps=1, eval_interval=2)
    assert fine_tuned(model, drives, ruinous) is model


def test_what_it_cannot_use(drives):
    model = RelativeNetwork(LocalNetwork(SMALL))
    with pytest.raises(InputError, match="two drives at least"):
        fine_tuned(model, drives[:1])
    with pytest.raises(InputError, match="experiences"):
        fine_tuned(model, [1, 2])
    with pytest.raises(InputError, match="model"):
        fine_tuned("relative_5", drives)
    flat = [replace(d, observations=replace(d.observations, depth=None)) for d in drives]
    with pytest.raises(InputError, match="depth"):
        fine_tuned(model, flat)
