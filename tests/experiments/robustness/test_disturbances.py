"""Disturbances move robots as declared, and are counted correctly."""

import json
from dataclasses import replace

import joblib
import numpy as np
import pytest

from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.experiments.common.report import Options
from tutorial_lib.experiments.protocols import following, moves
from tutorial_lib.experiments.protocols.following import UNDER_WAY, trajectories
from tutorial_lib.experiments.protocols.moves import (
    Disturbance,
    carried,
    in_the_way,
    pushed,
    turned,
)
from tutorial_lib.experiments.robustness import disturbances
from tutorial_lib.geometry import relative
from tutorial_lib.topology.following.transitions import State
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.placing import is_free
from tutorial_lib.world.simulation import Simulation


@pytest.fixture(scope="module")
def recorded():
    return trajectories(10_013, 5, np.random.default_rng(0))


@pytest.mark.parametrize(
    ("move", "gap", "angle"),
    [(pushed, moves.ASIDE, 0.0), (turned, 0.0, moves.TURNED)],
)
@pytest.mark.full
def test_cars_are_moved_as_far_as_said_to_where_there_is_room(recorded, move, gap, angle):
    rng, moved = np.random.default_rng(1), 0
    for frame in range(0, len(recorded.poses), 40):
        here = recorded.poses[frame]
        there = move(recorded, frame, here, rng)
        if there is None:
            continue
        moved += 1
        apart = relative(here, there)
        assert np.linalg.norm(apart[:2]) == pytest.approx(gap, abs=1e-9)
        assert abs(apart[2]) == pytest.approx(angle, abs=1e-9)
        assert is_free(recorded.scene, BicycleCar(), there[None])[0]
        assert recorded.scene.caster.sees(here[None, :2], there[None, :2])[0]
    assert moved > 5


def test_a_kidnapped_robot_sees_nothing_of_its_own_trajectory(recorded):
    rng = np.random.default_rng(2)
    frame = int(recorded.first[-1])
    there = carried(recorded, frame, recorded.poses[frame], rng)
    own = recorded.poses[frame : recorded.last[frame] + 1, :2]
    assert np.linalg.norm(own - there[:2], axis=1).min() > 4.0
    assert not recorded.scene.caster.sees(np.tile(there[:2], (len(own), 1)), own).any()


def test_with_a_single_trajectory_no_robot_can_be_kidnapped(recorded):
    alone = RecordedWorld(recorded.scene, recorded.trajectories[:1])
    assert carried(alone, 0, alone.poses[0], np.random.default_rng(0)) is None


def test_people_cross_the_trajectory_where_there_is_room(recorded):
    rng, long = np.random.default_rng(3), 0
    for frame in range(0, len(recorded.poses), 40):
        person = in_the_way(recorded, frame, 7, rng)
        assert person.owner == 7
        assert (recorded.scene.clearance.at(person.route) >= 0).all()
        across = relative(recorded.poses[frame], np.c_[person.route, [0.0, 0.0]])
        assert np.abs(across[:, 0]).max() < 1e-9
        assert across[0, 1] <= 0.0 <= across[1, 1]
        long += np.ptp(across[:, 1]) > 1.0
    assert long > 5


def test_a_robot_is_moved_once_when_it_passes(recorded):
    frames = np.array([recorded.first[0] + 30, recorded.last[0]])
    disturbance = Disturbance(recorded, frames, turned, np.random.default_rng(0))
    simulation = Simulation(recorded.scene, np.repeat(recorded.poses[:1], 2, axis=0))
    disturbance(simulation, np.array([0, 1]))
    assert disturbance.step.tolist() == [-1, -1]
    simulation.place([0], recorded.poses[[frames[0]]])
    for _ in range(2):
        disturbance(simulation, np.array([0, 1]))
    assert disturbance.step.tolist() == [1, -1]
    apart = relative(recorded.poses[frames[0]], simulation.poses[0])
    assert abs(apart[2]) == pytest.approx(moves.TURNED)


def test_every_robot_counts_and_time_runs_from_the_disturbance_on():
    success = np.array([True, False, False, False])
    state = np.full((100, 4), State.FOLLOW)
    state[80:, 1] = State.LOST
    state[30:, 2] = State.LOST  # before it came to where it would have been disturbed
    found = disturbances._outcomes(success, state, np.array([0, 40, -1, 60]))
    assert found["finished"].tolist() == [1.0, 0.0, 0.0, 0.0]
    assert found["disturbed"].tolist() == [1.0, 1.0, 0.0, 1.0]
    assert found["lost"].tolist() == [0.0, 1.0, 1.0, 0.0]
    assert found["soon"].tolist() == [0.0, 1.0, 0.0, 0.0]
    assert found["seconds"][1] == pytest.approx(4.0)
    late = disturbances._outcomes(success, state, np.array([0, 29, -1, 60]))
    assert late["soon"].tolist() == [0.0, 0.0, 0.0, 0.0]
    row = disturbances._row("carried", [found, late])
    assert (row["trajectories"], row["disturbed"]) == (8, 6)
    assert row["finished"] == 0.25
    assert row["soon"] == pytest.approx(1 / 6)
    assert row["lost"] == 0.5


def test_trajectories_begin_under_way(recorded):
    assert len(recorded.trajectories) == 5
    for drive in recorded.trajectories:
        assert drive.arc_length[-1] >= 10.0 - 0.1
        assert drive.timestamps[0] > UNDER_WAY / 0.9


@pytest.mark.full
def test_disturbances_run_on_a_validation_world(monkeypatch):
    for name, less in (("CARS", 8), ("LENGTH", 10.0), ("GRACE", 0.0)):
        monkeypatch.setattr(following, name, less)
    few = replace(disturbances.EXPERIMENT, settings=disturbances.Settings(trajectories=2))
    with joblib.parallel_config(backend="sequential"):
        report = few.report(Options(worlds=(10_001,)))
    rows = {row["disturbance"]: row for row in report.rows}
    assert list(rows) == ["none", "pushed", "turned", "carried", "person"]
    assert rows["none"]["trajectories"] == 2
    for row in rows.values():
        assert row["trajectories"] <= 2
        if row["trajectories"]:
            assert row["finished"] + row["lost"] <= 1.0
    kidnapped = rows["carried"]
    assert kidnapped["disturbed"] <= 2  # there is not always a place for it
    assert kidnapped["finished"] <= 1 - kidnapped["disturbed"] / 2  # one that was not may
    assert rows["none"]["finished"] is not None
    json.dumps(report.as_dict(), allow_nan=False)
