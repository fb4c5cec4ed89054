"""The motion of round robots agrees with pymunk, in which the car drives."""

import numpy as np

from tutorial_lib.exploration.motion import move
from tutorial_lib.geometry import distance_to_segments, to_world
from tutorial_lib.world.bodies import DifferentialDrive
from tutorial_lib.world.fleet import Fleet
from tutorial_lib.world.people import Crowd
from tutorial_lib.world.placing import random_free_poses
from tutorial_lib.world.worlds import scene_of

WORLDS = ("apartment/10100/standard", "office/10101/standard")
ROBOTS, MOTIONS, SUBSTEPS = 250, 20, 150
RADIUS = DifferentialDrive.radius
ANGLES = np.arange(64) * 2 * np.pi / 64
OUTLINE = RADIUS * np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)
GRAZES = 0.001
"""Metres: pymunk's robot has corners, and may pass where a round one just touches."""


def in_pymunk(segments, poses, motions):
    """Places (N, 2) after motions (N, 3) in pymunk, and whether robots touched what stopped them.

    There a robot would slide on along a wall: its wheels stop as soon as it leaves its line.
    """
    steps = (to_world(poses, motions[:, :2]) - poses[:, :2]) / SUBSTEPS
    metres, going = np.linalg.norm(steps, axis=1), np.ones(len(poses), bool)
    towards = np.column_stack([poses[:, :2], np.arctan2(steps[:, 1], steps[:, 0])])
    fleet = Fleet(segments, OUTLINE, towards, Crowd(()))
    for substep in range(SUBSTEPS + 1):  # a velocity moves the body in the substep after
        before, speeds = fleet.poses, metres * SUBSTEPS * going * (substep < SUBSTEPS)
        fleet.substep(speeds, np.zeros(len(poses)), 1 / SUBSTEPS)
        if substep:
            off = np.linalg.norm(fleet.poses[:, :2] - before[:, :2] - steps, axis=1)
            going &= off < 1e-3 * metres + 1e-9
    return fleet.poses[:, :2], ~going


def nearest_on_the_line(segments, pose, motion):
    """Metres between a robot's middle and the nearest wall on its line."""
    shares = np.linspace(0, 1, 1000)[:, None]
    return distance_to_segments(to_world(pose, shares * motion[:2]), segments).min()


def test_10_000_motions_end_where_pymunk_ends_them():
    apart, grazing = [], 0
    for number, world in enumerate(WORLDS):
        scene, rng = scene_of(world), np.random.default_rng(number)
        segments = scene.plan.segments
        ends = segments.reshape(-1, 2)
        places = ends[rng.integers(len(ends), size=4000)] + rng.normal(0, 0.5, (4000, 2))
        poses = random_free_poses(scene, DifferentialDrive(), places, ROBOTS, rng)
        for _ in range(MOTIONS):
            motions = rng.uniform([0, -0.05, -1], [0.3, 0.05, 1], (ROBOTS, 3))
            after, stopped = move(poses, motions, segments, RADIUS)
            theirs, blocked = in_pymunk(segments, poses, motions)
            for robot in np.flatnonzero(stopped != blocked):
                gap = nearest_on_the_line(segments, poses[robot], motions[robot])
                assert abs(gap - RADIUS) < GRAZES
            gaps = np.linalg.norm(theirs - after[:, :2], axis=1)
            assert gaps[~stopped & ~blocked].max() < 1e-9
            apart.append(gaps[stopped & blocked])
            grazing += (stopped != blocked).sum()
            poses = after
    touched = np.concatenate(apart)
    assert len(touched) > 3_000
    assert grazing < 20
    # The kernel tests for contact every centimetre; nearly along a wall a millimetre lasts longer.
    assert (touched < 0.016).mean() > 0.998
    assert touched.max() < 0.05
