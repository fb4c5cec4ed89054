"""The follower in simulated worlds, with oracles that know where everything is."""

from dataclasses import replace

import numpy as np
import pytest

from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.geometry import relative, to_local
from tutorial_lib.learning.estimators import WaypointNetwork
from tutorial_lib.learning.threads import use_threads
from tutorial_lib.topology.following.anchor_paths import AnchorPaths
from tutorial_lib.topology.following.follower import Follower
from tutorial_lib.topology.mapping.sparsify import sparsify
from tutorial_lib.world.noise import WheelOdometry
from tutorial_lib.world.simulation import Simulation
from tutorial_lib.world.visibility import mutual_overlap

use_threads(1)
FAR, TURNED, SHARED = 2.0, np.deg2rad(60.0), 0.3


class OracleReachability:
    """Sure of what is within 2 m, in sight and seen from much the same side."""

    def __init__(self, scene):
        self.scene = scene

    def prepare(self, poses):
        return poses

    def probability(self, observations, prepared):
        here = observations.depth
        gap = relative(here, prepared)
        good = self.scene.caster.sees(here[:, :2], prepared[:, :2])
        good &= np.linalg.norm(gap[:, :2], axis=1) < FAR
        good &= np.abs(gap[:, 2]) < TURNED
        good &= mutual_overlap(self.scene.caster, here, prepared, rays=40).min(axis=1) > SHARED
        return np.where(good, 0.99, 0.05)


class OraclePredictor:
    """Tells the farthest point in sight of the geodesic to each of some places."""

    def __init__(self, scene, poses):
        self.scene, self.poses = scene, poses
        self.fields = GridPaths(scene.clearance, clearance=0.2).fields(poses[:, :2])

    def predict(self, observations, targets):
        here = observations.depth
        caster = self.scene.caster
        points = self.fields.waypoints(here[:, :2], targets, caster, 3.0)
        near = np.linalg.norm(self.poses[targets, :2] - here[:, :2], axis=1) < 1.0
        points = np.where(near[:, None], self.poses[targets, :2], points)
        overlaps = mutual_overlap(caster, here, self.poses[targets], rays=40)
        return to_local(here, points), overlaps


def with_poses(simulation, robots):
    """Observations in which the oracles find the poses: as depth, which nothing else uses."""
    return replace(simulation.observe(robots), depth=simulation.poses[robots])


class Trial:
    """A fleet, each robot on its own trajectory, with oracles or the given predictor."""

    def __init__(self, recorded, seed=0):
        self.recorded, self.scene = recorded, recorded.scene
        self.first = recorded.first_frames
        self.reachability = OracleReachability(self.scene)
        self.anchors = [self.sparsified(first) for first in self.first]
        frames = np.concatenate(self.anchors)
        self.poses = recorded.poses[frames]
        self.simulation = Simulation(
            self.scene,
            recorded.poses[self.first],
            odometry_noise=WheelOdometry(),
            rng=np.random.default_rng(seed),
        )
        self.frames = frames

    def sparsified(self, first):
        """Frames of a trajectory's anchors."""
        frames = np.arange(first, self.recorded.last[first] + 1)
        poses = self.recorded.poses[frames]
        seen = replace(self.recorded.observe(frames), depth=poses)
        return first + sparsify(self.reachability, seen, poses, 0.95)

    def begin(self, predictor=None):
        """Set out, by oracle waypoints or those of a network."""
        if predictor is None:
            predictor, targets = OraclePredictor(self.scene, self.poses), np.arange(len(self.poses))
        else:
            contexts = self.recorded.poses[self.recorded.context(self.frames, 2)]
            targets = predictor.prepare(predictor.view.render(self.scene, contexts))
        lengths = [len(anchors) for anchors in self.anchors]
        paths = AnchorPaths.end_to_end(targets, self.reachability.prepare(self.poses), lengths)
        parts, starts = (predictor, RMPController(), self.reachability), np.zeros(len(lengths), int)
        self.follower = Follower(paths, *parts, starts=starts)
        self.tracks = [self.simulation.poses]
        return self

    def go(self, seconds):
        """Drive on, or until all are done or lost."""
        for _ in range(round(seconds * 10)):
            robots = np.flatnonzero(~self.follower.memory.over)
            if not len(robots):
                break
            actions = np.zeros((len(self.simulation), 2))
            actions[robots] = self.follower.act(with_poses(self.simulation, robots), robots)
            self.simulation.step(actions)
            self.tracks.append(self.simulation.poses)
        return self


@pytest.fixture(scope="module")
def under_way(recorded):
    """Rollouts without their first metres, in which cars turn round."""
    return RecordedWorld(
        recorded.scene, [trajectory.since(2.0) for trajectory in recorded.trajectories]
    )


@pytest.fixture(scope="module", params=["oracle", "network"])
def trial(request, under_way):
    """All trajectories are followed to the end, by oracle waypoints or by those of k = 2."""
    predictor = WaypointNetwork("waypoint_k2") if request.param == "network" else None
    return Trial(under_way).begin(predictor).go(120)


def test_most_follow_a_trajectory_by_its_anchors_to_the_end(trial):
    assert trial.follower.memory.over.all()
    assert trial.follower.memory.done.mean() >= 0.5
    kept = sum(map(len, trial.anchors))
    assert kept < 0.1 * len(trial.recorded.poses)


def test_a_robot_that_declares_to_have_arrived_has(trial):
    goals = trial.recorded.poses[trial.recorded.last[trial.first]]
    here = relative(goals, trial.simulation.poses)[trial.follower.memory.done]
    assert np.linalg.norm(here[:, :2], axis=1).max() < 0.5
    assert np.abs(here[:, 2]).max() < TURNED


def test_no_robot_goes_back_along_the_path(trial):
    record = trial.follower.log()
    assert (np.diff(record.visited, axis=0) >= 0).all()
    assert (record.active >= record.visited).all()


@pytest.mark.full
def test_the_same_seed_makes_the_same_tracks(under_way):
    one, two, other = (Trial(under_way, seed).begin().go(10).tracks for seed in (0, 0, 1))
    assert np.array_equal(one, two)
    assert not np.array_equal(one, other)


@pytest.mark.parametrize(
    "origin", [[90.0, -40.0, 2.0], pytest.param([0.0, 0.0, -3.0], marks=pytest.mark.full)]
)
@pytest.mark.full
def test_only_motions_by_odometry_matter_and_not_where_it_began(under_way, origin):
    one, elsewhere = Trial(under_way).begin(), Trial(under_way).begin()
    elsewhere.simulation.odometry = np.tile(origin, (len(elsewhere.simulation), 1))
    first, second = (np.stack(trial.go(20).tracks) for trial in (one, elsewhere))
    assert first[-1] == pytest.approx(second[-1], abs=1e-6)
    assert (one.follower.log().state == elsewhere.follower.log().state).all()
