"""Answers to the exercises of notebook 10: wrong ones, with words of their message, and right ones.

The check must say the docstring; answers called right must pass.
"""

import itertools
import math

import numpy as np
from scipy.optimize import minimize

from tutorial_lib.checks.nb10 import fit
from tutorial_lib.geometry import compose, inverse, relative, to_world, wrap

DEGREES = np.pi / 180


def _grid(sides, steps):
    """All pushes of a grid."""
    ends = [np.arange(-side, side + 1) * step for side, step in zip(sides, steps, strict=True)]
    return np.array(list(itertools.product(*ends)))


def _best(node, seen, poses):
    return poses[fit(node, seen, poses).argmax()]


# match


def match__right_with_three_grids(node, seen, guess):
    pose = _best(node, seen, guess + _grid((4, 4, 4), (0.15, 0.15, 5 * DEGREES)))
    pose = _best(node, seen, pose + _grid((3, 3, 3), (0.05, 0.05, 1.5 * DEGREES)))
    return _best(node, seen, pose + _grid((2, 2, 2), (0.02, 0.02, 0.5 * DEGREES)))


def match__right_in_the_robot_s_frame(node, seen, guess):
    """The window is turned with the robot."""
    pose, pushes = guess, _grid((2, 2, 2), (0.3, 0.3, 10 * DEGREES))
    for level in range(5):
        pose = _best(node, seen, compose(pose, pushes / 2**level))
    return pose


def match__right_from_the_best_of_many_starts(node, seen, guess):
    starts = guess + _grid((3, 3, 3), (0.18, 0.18, 6 * DEGREES))
    order = np.argsort(-fit(node, seen, starts))[:2]
    ends = [
        minimize(lambda pose: -fit(node, seen, pose[None])[0], starts[i], method="Nelder-Mead").x
        for i in order
    ]
    return _best(node, seen, np.array(ends))


def match__right_by_closest_points(node, seen, guess):
    """Points onto the lines between the node's points, without `fit`."""
    bearings = np.pi - (np.arange(len(seen)) + 0.5) * 2 * np.pi / len(seen)
    rays = np.stack([np.cos(bearings), np.sin(bearings)], axis=1)
    walls, points = node[:, None] * rays, (seen[:, None] * rays)[seen < 7]
    along = np.roll(walls, -1, axis=0) - walls
    real = (np.linalg.norm(along, axis=1) < 0.8) & (node < 8)
    walls, along = walls[real], along[real] / np.linalg.norm(along[real], axis=1)[:, None]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    best, most = guess, -1.0
    for turn in (-0.1, 0.1):
        pose = guess + np.array([0, 0, turn])
        for reach in np.geomspace(0.9, 0.1, 12):
            moved = to_world(pose, points)
            gaps = np.linalg.norm(moved[:, None] - walls, axis=2)
            near = gaps.argmin(axis=1)
            used = gaps.min(axis=1) < reach
            if used.sum() < 10:
                break
            normal = across[near[used]]
            arm = moved[used] - pose[:2]
            rows = np.column_stack([normal, normal[:, 1] * arm[:, 0] - normal[:, 0] * arm[:, 1]])
            off = ((moved[used] - walls[near[used]]) * normal).sum(axis=1)
            pose = pose - np.linalg.lstsq(rows, off, rcond=1e-3)[0]
        share = fit(node, seen, pose[None])[0]
        if share > most:
            best, most = pose, share
    return best


def match__right_with_turned_headings_wrapped(node, seen, guess):
    pose = guess
    for metres, turn in ((0.2, 8), (0.1, 4), (0.05, 2), (0.02, 1)):
        pose = _best(node, seen, pose + _grid((3, 3, 2), (metres, metres, turn * DEGREES)))
    return np.array([*pose[:2], wrap(pose[2])])


def match__quarters_of_a_metre(node, seen, guess):
    """and smaller steps"""
    return _best(node, seen, guess + _grid((2, 2, 8), (0.25, 0.25, 2 * DEGREES)))


def match__fine_places_coarse_headings(node, seen, guess):
    """the place is right, the heading isn't"""
    return _best(node, seen, guess + _grid((10, 10, 2), (0.05, 0.05, 10 * DEGREES)))


def match__degrees_by_thirds(node, seen, guess):
    """are your steps in radians"""
    pose, steps = guess, np.array([0.5, 0.5, 15]) / 3
    for level in range(3):
        pose = _best(node, seen, pose + _grid((3, 3, 3), steps / 3**level))
    return pose


def match__far_away(node, seen, guess):
    """stay near the guess"""
    pose = _best(node, seen, guess + _grid((12, 12, 12), (0.25, 0.25, 15 * DEGREES)))
    for level in range(1, 5):
        pose = _best(node, seen, pose + _grid((2, 2, 2), (0.25, 0.25, 10 * DEGREES)) / 2**level)
    return pose


def match__with_the_fit(node, seen, guess):
    """return the pose alone"""
    pose = match__right_with_three_grids(node, seen, guess)
    return pose, fit(node, seen, pose[None])[0]


_DRAWS = np.random.default_rng(3)  # of few poses, so that two answers are seldom near each other


def match__drawn(node, seen, guess):
    """called again with the same arguments"""
    pushes = _DRAWS.uniform(-1, 1, (2, 3)) * [0.6, 0.6, 20 * DEGREES]
    return _best(node, seen, guess + pushes)


# accept


def _ring(turns):
    """Pushes by half a metre, in these directions."""
    return 0.5 * np.stack([np.cos(turns), np.sin(turns), 0 * turns], axis=1)


def accept__right_with_steps_of_three_degrees(node, seen, guess, pose):
    if np.linalg.norm(pose[:2] - guess[:2]) > 1.0 or abs(wrap(pose[2] - guess[2])) > np.pi / 6:
        return False
    around = pose + _ring(np.arange(120) * np.pi / 60)
    here = fit(node, seen, pose[None])[0]
    return bool(here > 0.7 and (here - fit(node, seen, around) > 0.15).all())


def accept__right_pose_by_pose(node, seen, guess, pose):
    off = relative(guess, pose)
    near = math.hypot(off[0], off[1]) <= 1 and math.cos(off[2]) >= math.cos(math.radians(30))
    here = float(fit(node, seen, np.array([pose]))[0])
    slides = False
    for degrees in range(0, 360, 5):
        x, y = 0.5 * math.cos(math.radians(degrees)), 0.5 * math.sin(math.radians(degrees))
        there = float(fit(node, seen, np.array([[pose[0] + x, pose[1] + y, pose[2]]]))[0])
        slides = slides or there > 0.85 * here
    return near and here >= 0.75 and not slides


def accept__right_by_lines(node, seen, guess, pose):
    """On each line, the better of both ends."""
    gap = relative(guess, pose)
    if not (np.linalg.norm(gap[:2]) <= 1.0 and np.abs(wrap(gap[2])) <= 30 * DEGREES):
        return np.False_
    (here,) = fit(node, seen, pose[None])
    better = []
    for turn in np.linspace(0, np.pi, 36, endpoint=False):
        along = np.array([-0.5, 0.5])[:, None] * [np.cos(turn), np.sin(turn), 0]
        better.append(fit(node, seen, pose + along).max())
    return here >= 0.72 and max(better) <= here - 0.12


def accept__right_with_turns_as_well(node, seen, guess, pose):
    near = np.hypot(*(pose - guess)[:2]) < 1.0 and abs(wrap((pose - guess)[2])) < 30 * DEGREES
    pushes = _ring(np.linspace(0, 2 * np.pi, 73)[:72])
    pushes = np.concatenate([pushes, [[0, 0, 20 * DEGREES], [0, 0, -20 * DEGREES]]])
    here, there = fit(node, seen, pose[None])[0], fit(node, seen, pose + pushes).max()
    return bool(near and here > 0.75 and there < here - 0.1)


def accept__right_with_a_finer_look_around_the_best(node, seen, guess, pose):
    near, here, around = _parts(node, seen, guess, pose, count=16)
    best = np.deg2rad(22.5) * around.argmax()
    finer = best + np.deg2rad(np.arange(-12, 13))
    slides = fit(node, seen, pose + _ring(finer)).max() > here - 0.1
    return bool(all(near) and here >= 0.75 and not slides)


def accept__right_along_the_axis(node, seen, guess, pose):
    """By the direction that most wall points see their neighbours in."""
    near, here, around = _parts(node, seen, guess, pose, count=8)
    bearings = np.pi - (np.arange(len(node)) + 0.5) * 2 * np.pi / len(node)
    points = node[:, None] * np.stack([np.cos(bearings), np.sin(bearings)], axis=1)
    steps = np.diff(points, axis=0)[np.hypot(*np.diff(points, axis=0).T) < 0.8]
    doubled = 2 * np.arctan2(steps[:, 1], steps[:, 0])
    axis = 0.5 * np.arctan2(np.sin(doubled).sum(), np.cos(doubled).sum())
    along = fit(node, seen, pose + _ring(axis + np.array([0.0, np.pi])))
    return bool(all(near) and here >= 0.75 and max(*around, *along) < here - 0.1)


def _parts(node, seen, guess, pose, count=72):
    """Whether it is near the guess, the fit, and the fits around."""
    gap = relative(guess, pose)
    near = np.hypot(gap[0], gap[1]) <= 1.0, abs(wrap(gap[2])) <= 30 * DEGREES
    around = pose + _ring(np.arange(count) * 2 * np.pi / count)
    return near, fit(node, seen, pose[None])[0], fit(node, seen, around)


def accept__not_wrapped(node, seen, guess, pose):
    """headings of 179 and -179 degrees"""
    _, here, around = _parts(node, seen, guess, pose)
    gap = pose - guess
    near = np.hypot(gap[0], gap[1]) <= 1.0 and abs(gap[2]) <= 30 * DEGREES
    return bool(near and here >= 0.75 and around.max() < here - 0.1)


def accept__thirty_six_directions(node, seen, guess, pose):
    """does it lie between two of your directions?"""
    near, here, around = _parts(node, seen, guess, pose, count=36)
    return bool(all(near) and here >= 0.75 and around.max() < here - 0.1)


def accept__number(node, seen, guess, pose):
    """return True or False"""
    return fit(node, seen, pose[None])[0]


def accept__one_pose(node, seen, guess, pose):
    """poses (P, 3)"""
    return bool(fit(node, seen, pose) >= 0.75)


# correct


def correct__right_with_compose(node, pose, odometry):
    return compose(compose(node, pose), inverse(odometry))


def correct__right_by_hand(node, pose, odometry):
    turn = node[2] + pose[2] - odometry[2]
    c, s = math.cos(node[2]), math.sin(node[2])
    x = node[0] + c * pose[0] - s * pose[1]
    y = node[1] + s * pose[0] + c * pose[1]
    c, s = math.cos(turn), math.sin(turn)
    return np.array([x - c * odometry[0] + s * odometry[1], y - s * odometry[0] - c * odometry[1],
                     turn])  # fmt: skip


def correct__right_with_matrices(node, pose, odometry):
    def matrix(x, y, turn):
        return np.array(
            [[np.cos(turn), -np.sin(turn), x], [np.sin(turn), np.cos(turn), y], [0, 0, 1]]
        )

    found = matrix(*node) @ matrix(*pose) @ np.linalg.inv(matrix(*odometry))
    return np.array([found[0, 2], found[1, 2], np.arctan2(found[1, 0], found[0, 0])])


def correct__right_with_complex_numbers(node, pose, odometry):
    turn = node[2] + pose[2] - odometry[2] + 2 * np.pi
    place = complex(*node[:2]) + np.exp(1j * node[2]) * complex(*pose[:2])
    place -= np.exp(1j * turn) * complex(*odometry[:2])
    return np.array([place.real, place.imag, turn])


def correct__other_side(node, pose, odometry):
    """goes before the odometry"""
    return compose(inverse(odometry), compose(node, pose))


def correct__heading_only(node, pose, odometry):
    """the place is off, too"""
    return np.array([0.0, 0.0, wrap(node[2] + pose[2] - odometry[2])])


def correct__list(node, pose, odometry):
    """a list came back"""
    return compose(compose(node, pose), inverse(odometry)).tolist()
