"""Pictures of the camera taken out of panoramas, against the camera itself."""

import numpy as np
import pytest

from tutorial_lib.errors import InputError
from tutorial_lib.exploration.turned_views import pinhole, turned
from tutorial_lib.geometry import wrap
from tutorial_lib.learning.exploration_data import random_poses
from tutorial_lib.observation import Observation
from tutorial_lib.world.sensors import Camera, Laser, PanoramicCamera


@pytest.fixture(scope="module")
def looked(scenes):
    """Poses in a world, and what is observed there."""
    scene = next(iter(scenes.values()))
    poses = random_poses(scene, 40, np.random.default_rng(4))
    image, depth = PanoramicCamera().look(scene, poses)
    still = np.zeros(len(poses))
    blank = np.full((len(poses), 96), np.nan)
    return scene, poses, Observation(image, depth, blank, poses.copy(), still, still)


def test_a_turned_view_is_what_the_camera_sees_there(looked):
    scene, poses, seen = looked
    headings = np.random.default_rng(5).uniform(-np.pi, np.pi, len(poses))
    views = turned(seen, headings, with_depth=True)
    there = poses.copy()
    there[:, 2] += headings
    image, depth = Camera().look(scene, there)
    error = np.abs(views.image.astype(float) - image)
    assert np.median(error) <= 2
    assert error.mean() < 6  # a mirror image has 44
    gaps = np.abs(views.depth - depth)
    assert np.median(gaps) < 0.05
    assert np.median(np.abs(views.depth[:, ::-1] - depth)) > 0.3  # not a mirror image
    assert turned(seen, headings).depth is None
    gaps = np.abs(views.laser - Laser().scan(scene, there))
    assert np.median(gaps) < 0.02
    assert np.quantile(gaps, 0.9) < 0.3
    assert np.allclose(wrap(views.odometry[:, 2] - there[:, 2]), 0.0)
    assert np.array_equal(views.odometry[:, :2], poses[:, :2])


def test_one_heading_is_for_all(looked):
    _, poses, seen = looked
    both = turned(seen, 0.5), turned(seen, np.full(len(poses), 0.5))
    assert np.array_equal(both[0].image, both[1].image)


def test_what_has_one_colour_keeps_it():
    grey = np.full((2, 16, 192, 3), 77, np.uint8)
    assert (pinhole(grey, np.array([0.3, np.pi])) == 77).all()


def test_nothing_is_turned_into_nothing(looked):
    assert len(turned(looked[2][np.zeros(0, int)], 0.0)) == 0


def test_a_panorama_without_depth_is_refused(looked):
    seen = looked[2]
    flat = Observation(seen.image, None, seen.laser, seen.odometry, seen.speed, seen.steering)
    with pytest.raises(InputError, match="panoramas without depth"):
        turned(flat, 0.0)
