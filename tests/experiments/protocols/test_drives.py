"""Which drives agents learn, which trials those cover, and harder trials."""

from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.protocols import drives
from tutorial_lib.experiments.protocols.drives import (
    driven,
    driven_trials,
    parse_drives,
    part_of,
    passed_goals,
    tour,
    toured,
)
from tutorial_lib.experiments.protocols.navigation_tasks import draw_trials, explored
from tutorial_lib.experiments.protocols.trial_choices import chosen_trials, with_turned_goals
from tutorial_lib.geometry import wrap
from tutorial_lib.world.scene import Scene

PILLARS = [(3.0, 3.0, 0.5), (6.5, 4.0, 0.3), (5.0, 7.5, 0.8)]


@pytest.fixture(scope="module")
def building():
    return explored("room", Scene(make_box(pillars=PILLARS)), np.random.default_rng(0), 4)


@pytest.fixture(scope="module")
def trials(building):
    return draw_trials(building, 12, np.random.default_rng(1))


@pytest.fixture(scope="module")
def continuous(building):
    return toured(building)


@pytest.mark.parametrize(
    ("text", "found"), [("0.2", "0.2"), ("1.0", "1"), ("tour", "tour"), ("", "")]
)
def test_drives_are_a_share_or_a_tour(text, found):
    assert parse_drives(text) == found


@pytest.mark.parametrize("text", ["0", "1.5", "-0.2", "nan", "all"])
def test_other_drives_are_refused(text):
    with pytest.raises(InputError, match="--drives"):
        parse_drives(text)


def test_a_tour_leads_through_all_places_and_back(building):
    part = part_of(building, "tour", 0)
    assert part.pairs.tolist() == tour(4).tolist()
    for pair, drive in zip(part.pairs, part.recorded.trajectories, strict=True):
        ends = building.places[pair]
        assert np.linalg.norm(drive.poses[[0, -1], :2] - ends, axis=1).max() < 0.5
    assert len(part.recorded.poses) < len(building.recorded.poses)


def test_a_share_of_the_drives_is_the_same_each_time_and_grows(building):
    half, most = part_of(building, "0.5", 0), part_of(building, "0.75", 0)
    assert (len(half.pairs), len(most.pairs)) == (6, 9)
    pairs = {tuple(pair) for pair in most.pairs.tolist()}
    assert {tuple(pair) for pair in half.pairs.tolist()} < pairs
    assert part_of(building, "0.5", 0).pairs.tolist() == half.pairs.tolist()
    assert part_of(building, "0.5", 1).pairs.tolist() != half.pairs.tolist()
    assert part_of(building, "", 0) is building
    with pytest.raises(InputError, match=r"--drives 0\.01: none of 12 is left"):
        part_of(building, "0.01", 0)


@pytest.mark.full
def test_a_continuous_drive_passes_all_places_in_one_recording(building, continuous):
    (drive,) = continuous.recorded.trajectories
    passed = [np.linalg.norm(drive.poses[:, :2] - place, axis=1).min() for place in building.places]
    assert max(passed) < 0.5
    steps = np.linalg.norm(np.diff(drive.poses[:, :2], axis=0), axis=1)
    assert steps.max() < 0.1  # nobody carried it
    assert np.abs(wrap(np.diff(drive.poses[:, 2]))).max() < 0.2
    separate = part_of(building, "tour", 0)
    length = sum(one.arc_length[-1] for one in separate.recorded.trajectories)
    assert drive.arc_length[-1] > 0.8 * length


def test_a_car_that_does_not_come_through_is_reported(building, monkeypatch):
    monkeypatch.setattr(drives, "demonstrate_on", lambda *_: None)
    with pytest.raises(InputError, match="did not come through"):
        toured(building)


def test_a_trial_is_driven_if_one_drive_passes_its_start_and_then_its_goal(building, trials):
    assert driven(building, trials, 0.5, np.pi / 3).mean() > 0.8
    own = [
        (building.pairs == pair).all(axis=1).argmax() for pair in trials.pairs
    ]  # the drive of each trial's pair
    for trial, drive in list(enumerate(own))[:4]:
        one = trials.subset(np.array([trial]))
        recorded = building.recorded.trajectories[drive]
        only = replace(building, recorded=RecordedWorld(building.scene, [recorded]))
        back = replace(recorded, poses=recorded.poses[::-1].copy())
        only_back = replace(building, recorded=RecordedWorld(building.scene, [back]))
        assert driven(only, one, 0.5, np.pi)[0]
        # The goal comes before the start.
        assert not driven(only_back, one, 0.5, np.pi)[0]
        assert not driven(only, one, 0.5, 0.0)[0]


def test_a_goal_is_passed_if_some_drive_looks_at_it_as_it_was_taken(building, trials):
    every = passed_goals(building, trials, "", 0)
    assert every.mean() > 0.8
    assert (every >= driven_trials(building, trials, "", 0)).all()
    away = looking(building, float(trials.goal_poses[0, 2] + np.pi))
    assert passed_goals(looking(building, float(trials.goal_poses[0, 2])), trials, "", 0)[0]
    assert not passed_goals(away, trials, "", 0)[0]


@pytest.mark.full
def test_goals_that_the_continuous_drive_passes_are_judged_by_that_drive(
    building, continuous, trials, monkeypatch
):
    wanted = passed_goals(continuous, trials, "", 0)
    made = {building: continuous}
    monkeypatch.setattr(drives, "toured", lambda whole: made.pop(whole))
    assert (passed_goals(building, trials, "continuous", 0) == wanted).all()
    assert not made


def looking(building, heading):
    """The building with drives on which the robot looks one way all the time."""
    drives = [
        replace(one, poses=np.column_stack([one.poses[:, :2], np.full(len(one), heading)]))
        for one in building.recorded.trajectories
    ]
    return replace(building, recorded=RecordedWorld(building.scene, drives))


def test_turned_goals_are_at_the_same_places_but_look_another_way(trials):
    turned = with_turned_goals(trials)
    gap = np.linalg.norm(turned.goal_poses[:, :2] - trials.goal_poses[:, :2], axis=1)
    assert gap.max() < 0.7
    other = np.abs(wrap(turned.goal_poses[:, 2] - trials.goal_poses[:, 2]))
    assert np.median(other) > 0.5
    assert (turned.starts == trials.starts).all()


def test_trials_may_start_anywhere(building):
    rng = np.random.default_rng(2)
    found = chosen_trials(building, 10, rng, "anywhere", "")
    gaps = np.linalg.norm(found.starts[:, None, :2] - building.places, axis=2).min(axis=1)
    assert gaps.max() > 1.0
    usual = chosen_trials(building, 10, np.random.default_rng(2), "", "")
    gaps = np.linalg.norm(usual.starts[:, None, :2] - building.places, axis=2).min(axis=1)
    assert gaps.max() < 1.2
