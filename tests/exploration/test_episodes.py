"""Episodes lie in their worlds, and as far apart as they say."""

import itertools

import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.exploration.episodes import (
    DIFFICULTIES,
    SEQUENTIAL,
    SUCCESS,
    Episodes,
    draw_episodes,
    draw_sequence,
    exploration_world,
)
from tutorial_lib.world.bodies import DifferentialDrive
from tutorial_lib.world.placing import is_free
from tutorial_lib.world.scene import Scene


def test_starts_and_goals_are_free_and_as_far_apart_as_the_difficulty_says(scenes, episodes):
    assert len(episodes) == 24
    for name, scene in scenes.items():
        mine = episodes[np.flatnonzero([world == name for world in episodes.worlds])]
        assert is_free(scene, DifferentialDrive(), mine.starts).all()
        assert is_free(scene, DifferentialDrive(), mine.goals).all()
        metres = GridPaths(scene.clearance).between(mine.starts[:, :2], mine.goals[:, :2])
        assert np.allclose(metres, mine.shortest, atol=1e-6)
        for far, difficulty in zip(metres, mine.difficulty, strict=True):
            least, most = DIFFICULTIES[difficulty]
            assert least <= far < most


def test_no_start_is_so_near_that_stop_succeeds_at_once():
    """A path of 1.5 m and more may lead around a wall to a goal within a metre."""
    ends = [(x, y) for x in np.arange(1.2, 9, 1.2) for y in (0.9, 3.9, 6.9)]
    walls = [(x, y + far, 0.02) for x, y in ends for far in np.arange(0, 2.2, 0.04)]
    scene = Scene(make_box(10.0, 10.0, walls))
    drawn = draw_episodes("box", scene, {"easy": 100}, np.random.default_rng(1))
    gaps = np.linalg.norm(drawn.starts[:, :2] - drawn.goals[:, :2], axis=1)
    assert gaps.min() >= SUCCESS
    chain = draw_sequence(scene, drawn.goals, 2, np.random.default_rng(0))
    assert np.linalg.norm(chain[1, :, :2] - chain[0, :, :2], axis=1).min() >= SUCCESS


def test_the_same_seed_draws_the_same_episodes(scenes):
    name, scene = next(iter(scenes.items()))
    first, again, other = (
        draw_episodes(name, scene, {"medium": 3}, np.random.default_rng(seed)) for seed in (1, 1, 2)
    )
    assert first.starts.tobytes() == again.starts.tobytes()
    assert first.goals.tobytes() == again.goals.tobytes()
    assert not np.array_equal(first.goals, other.goals)


def test_with_and_without_signs_episodes_are_at_the_same_places(scenes):
    from tutorial_lib.world.worlds import scene_of

    plain = draw_episodes(
        "a", scene_of(exploration_world(10_101)), {"hard": 2}, np.random.default_rng(5)
    )
    signs = draw_episodes("b", list(scenes.values())[1], {"hard": 2}, np.random.default_rng(5))
    assert np.array_equal(plain.goals, signs.goals)


def test_each_goal_of_a_sequence_is_near_the_one_before(scenes, episodes):
    name, scene = next(iter(scenes.items()))
    first = episodes.goals[[world == name for world in episodes.worlds]]
    chain = draw_sequence(scene, first, 4, np.random.default_rng(0))
    assert np.array_equal(chain[0], first)
    paths = GridPaths(scene.clearance)
    for before, after in itertools.pairwise(chain):
        metres = paths.between(after[:, :2], before[:, :2])
        assert ((metres >= SEQUENTIAL[0]) & (metres < SEQUENTIAL[1])).all()


def test_what_cannot_be_is_refused(scenes, episodes):
    name, scene = next(iter(scenes.items()))
    with pytest.raises(InputError, match="difficulty: 'huge' is unknown"):
        draw_episodes(name, scene, {"huge": 1}, np.random.default_rng(0))
    with pytest.raises(InputError, match="episodes: "):
        Episodes((), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), ())
    with pytest.raises(InputError, match="as many of all"):
        Episodes(("a",), np.zeros((2, 3)), np.zeros((1, 3)), np.zeros(1), ("easy",))
