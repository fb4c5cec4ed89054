"""Decisions between directions, for models with perfect perception."""

import numpy as np
import pytest

from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.experiments.protocols.directions import (
    DIFFICULTIES,
    SHORTEST,
    Decisions,
    decisions,
    regret_in,
    regret_of,
)
from tutorial_lib.exploration.bearings import DIRECTIONS
from tutorial_lib.exploration.bearings import RADIUS as REACH
from tutorial_lib.world.worlds import scene_of, world_name


@pytest.fixture(scope="module")
def scene():
    return scene_of(world_name("apartment", 10_040, signs="wayfinding"))


@pytest.fixture(scope="module")
def found(scene):
    return decisions(scene, np.random.default_rng(0), signs=True)


def test_a_decision_is_between_two_directions_at_least_and_its_rows_stand_together(found):
    counts = np.bincount(found.number)
    assert ((counts >= 2) & (counts <= DIRECTIONS)).all()
    assert (np.diff(found.number) >= 0).all()
    assert set(found.difficulty) == set(range(len(DIFFICULTIES)))
    first = np.flatnonzero(np.diff(found.number, prepend=-1))
    assert np.array_equal(np.repeat(found.difficulty[first], counts), found.difficulty)


def test_a_direction_is_traversable_and_no_better_than_straight(found):
    long = found.here[:, 0]
    assert ((long >= SHORTEST) & (long <= REACH + 1e-9)).all()
    # A goal of 5 to 10 m cannot be nearer than 2 m from an end that is at most 3 m away.
    for number, (least, most) in enumerate(DIFFICULTIES.values()):
        metres = found.metres[found.difficulty == number]
        assert metres.min() >= least - REACH - 0.5
        assert metres.max() <= most + REACH * 4


def test_the_same_seed_gives_the_same_decisions(scene, found):
    again = decisions(scene, np.random.default_rng(0), signs=True)
    assert np.array_equal(again.metres, found.metres)
    assert np.array_equal(again.goal, found.goal)
    assert not np.array_equal(
        decisions(scene, np.random.default_rng(1), signs=True).metres[:50], found.metres[:50]
    )


def test_depth_is_read_only_where_there_are_signs(scene, found):
    plain = decisions(scene, np.random.default_rng(0), signs=False)
    assert np.array_equal(plain.metres, found.metres)
    columns = (plain.here != found.here).any(axis=0)
    assert columns.sum() == 4  # here, at the end, their difference, and that to the mean
    assert not plain.here[:, columns].any()
    assert np.abs(found.goal[:, -1]).max() > 0.1


def test_each_direction_is_compared_with_the_mean_of_its_decision(found):
    """Free metres, what is read at the end, and how much that differs from the goal."""
    read = (found.here.shape[1] - 2) // 4
    from_end = slice(read, 2 * read)
    for values, compared in (
        (found.here[:, :1], found.here[:, 1:2]),
        (found.here[:, 2 + read : 2 + 2 * read], found.here[:, 2 + 3 * read :]),
        (found.goal[:, from_end], found.goal[:, 4 * read :]),
    ):
        for number in range(0, found.number[-1] + 1, 9):
            rows = found.number == number
            wanted = values[rows] - values[rows].sum(axis=0) / rows.sum()
            assert compared[rows] == pytest.approx(wanted)
            assert values[rows].shape == compared[rows].shape


def test_the_highest_score_chooses_as_by_hand():
    rng = np.random.default_rng(3)
    number = np.repeat(np.arange(40), rng.integers(2, 8, 40))
    metres, scores = rng.uniform(0, 9, len(number)), rng.random(len(number))
    level = np.repeat(rng.integers(3, size=40), np.bincount(number))
    nothing = np.zeros((len(number), 1))
    found = Decisions(number, level, metres, nothing, nothing)
    difficulty, regret = regret_in(found, scores)
    for i in range(40):
        rows = np.flatnonzero(number == i)
        chosen = rows[scores[rows].argmax()]
        assert regret[i] == metres[chosen] - metres[rows].min()
        assert difficulty[i] == level[rows[0]]
    assert not regret_in(found, -metres)[1].any()


def test_regret_is_what_the_choice_is_longer_by():
    metres = np.array([[3.0, 1.0, np.inf], [2.0, 5.0, 4.0]])
    assert regret_of(np.array([[0.9, 0.1, 1.0], [0.2, 0.9, 0.3]]), metres).tolist() == [2.0, 3.0]
    assert regret_of(-metres, metres).tolist() == [0.0, 0.0]


def test_metres_are_geodesics_from_the_end(scene):
    found = decisions(scene, np.random.default_rng(5), signs=False)
    paths = GridPaths(scene.clearance)
    nodes = np.flatnonzero(paths.largest)
    rng = np.random.default_rng(5)
    rng.choice(nodes, 150)
    goals = paths.points[rng.choice(nodes, 24)]
    reachable = paths.fields(goals, shortest=True).cost
    assert found.metres.max() <= reachable[np.isfinite(reachable)].max() + 1.0
