"""What an agent learns from and is sent to, out of recorded trajectories."""

import numpy as np
import pytest

from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import Experience, Goals
from tutorial_lib.learning.views import VIEWS
from tutorial_lib.world.sensors import Camera


def test_an_experience_of_each_trajectory_one_after_the_other(recorded):
    found = recorded.experiences()
    assert len(found) == len(recorded.trajectories) >= 2
    for number, one in enumerate(found):
        assert isinstance(one, Experience)
        frames = recorded.frames_of(number)
        assert (one.observations.image == recorded.observe(frames).image).all()
        assert (one.observations.laser == recorded.trajectories[number].laser).all()
        assert one.timestamps[0] == recorded.begins[number]
        if number:
            assert one.timestamps[0] == found[number - 1].timestamps[-1] + 60.0


def test_times_lead_back_to_the_poses(recorded):
    times = np.concatenate([one.timestamps for one in recorded.experiences()])
    assert (recorded.poses_at(times) == recorded.poses).all()
    some = np.array([len(times) - 1, 3, recorded.first_frames[1]])
    assert (recorded.poses_at(times[some]) == recorded.poses[some]).all()


def test_a_goal_is_one_frame_which_stands_for_its_context(recorded):
    frames = np.array([40, 90])
    first, second = recorded.goals(frames, k=2)
    assert isinstance(first, Goals)
    assert len(first) == len(second) == 1
    images = VIEWS["camera16"].render(recorded.scene, recorded.poses[frames])
    for number, goal in enumerate((first, second)):
        assert goal.contexts.shape[:2] == (1, 5)
        assert (goal.contexts == images[number]).all()
        assert (goal.observations.image == images[[number]]).all()
        assert (goal.observations.odometry == 0.0).all()
        assert goal.observations.camera == Camera()
    assert recorded.goals(frames[:1])[0].contexts.shape[1] == 11
    tall = recorded.goals(frames[:1], 1, Camera(rows=64))[0]
    assert tall.contexts.shape == (1, 3, 64, 64, 3)
    with pytest.raises(InputError, match="frames"):
        recorded.goals(np.array([10**6]))
