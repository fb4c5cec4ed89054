"""Trips that missed their goals, of each experiment that judges a class of one's own."""

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from tutorial_lib.experiments import failures
from tutorial_lib.experiments.common.report import Options
from tutorial_lib.experiments.leaderboard import EXPLORING, LOCAL, VISITS
from tutorial_lib.world.simulation import STEP
from tutorial_lib.world.worlds import scene_of

WORLD = 10_000
IDLE = """
import numpy as np
from tutorial_lib.world.noise import STOP

class Mine:
    def start(self, goals):
        pass
    def look_for(self, goals):
        pass
    def act(self, observations, running):
        return np.full(len(running), STOP)
"""

PARKED = """
import numpy as np

class Mine:
    def act(self, observations, waypoints):
        return np.zeros((len(waypoints), 2))
"""


@pytest.fixture
def idle(tmp_path):
    """A robot that stops where it stands."""
    (tmp_path / "idle.py").write_text(IDLE)
    return f"{tmp_path / 'idle.py'}:Mine"


@pytest.mark.parametrize("contest", [EXPLORING, VISITS], ids=lambda contest: contest.name)
def test_trips_of_robots_that_stop_at_once_are_as_long_as_nothing(contest, idle):
    settings = replace(contest.experiment.canary, **{contest.names: ()})
    options = Options(worlds=(WORLD,), agent=idle)
    trips = list(contest.failures(WORLD, options, settings))
    count = settings.lives * settings.visits if contest is VISITS else 3 * settings.episodes
    assert len(trips) == count
    for trip in trips:
        assert len(trip.poses) == 2
        assert trip.gap > 1.0  # else it had been there
        assert scene_of(trip.world).clearance.at(trip.poses[:, :2]).min() > 0
        again = failures.Trip.read(json.loads(json.dumps(trip.stored)))
        assert again.stored == trip.stored


def test_visits_missed_one_after_another_begin_where_the_last_ended(idle):
    settings = replace(VISITS.experiment.canary, agents=(), lives=1, visits=3)
    options = Options(worlds=(WORLD,), agent=idle)
    trips = list(VISITS.failures(WORLD, options, settings))
    assert len(trips) == 3
    assert all(np.array_equal(a.poses[-1], b.poses[0]) for a, b in pairwise(trips))
    assert len({tuple(trip.goal) for trip in trips}) == 3


def test_a_car_that_stands_still_misses_all_targets_when_its_time_is_over(tmp_path):
    (tmp_path / "parked.py").write_text(PARKED)
    settings = replace(LOCAL.experiment.canary, episodes=6)
    options = Options(worlds=(20_000,), agent=f"{tmp_path / 'parked.py'}:Mine")
    trips = list(LOCAL.failures(20_000, options, settings))
    assert len(trips) == 6
    for trip in trips:
        assert not trip.panorama
        assert np.ptp(trip.poses[:, :2], axis=0).max() < 0.01
        assert trip.gap > 0.3
        assert trip.seconds == pytest.approx(STEP * (len(trip.poses) - 1))


def test_a_film_shows_the_first_and_the_last_pose():
    poses = np.array([[2.0, 2.0, 0.0], [3.0, 2.0, 0.0], [3.0, 3.0, 1.0]])
    trip = failures.Trip("apartment/10000/standard", np.array([4.0, 4.0, 0.0]), poses, 1.0, False)
    frames = list(failures.film_of(trip, "Mine"))
    assert len({frame.shape for frame in frames}) == 1
    assert frames[0].shape[0] % 2 == frames[0].shape[1] % 2 == 0
    assert not np.array_equal(frames[0], frames[1])
    assert np.array_equal(frames[2], frames[-1])
