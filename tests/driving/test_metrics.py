import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tutorial_lib.driving.metrics import AHEAD, REACHED, STRAYED, covered, spl
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import compose


def line(points, step=0.05):
    """Points every `step` metres along a broken line."""
    points = np.asarray(points, dtype=float)
    miles = np.concatenate([[0.0], np.hypot(*np.diff(points, axis=0).T).cumsum()])
    at = np.append(np.arange(0.0, miles[-1], step), miles[-1])
    return np.stack([np.interp(at, miles, column) for column in points.T], axis=1)


LOOP = [[0, 0], [6, 0], [6, 4], [3, 4], [3, -4]]  # crosses itself at (3, 0)


def test_a_robot_that_follows_to_the_end_has_covered_all():
    path = line(LOOP)
    assert covered(path, path) == pytest.approx(6 + 4 + 3 + 8)
    assert covered(LOOP, path) == pytest.approx(21.0)
    poses = np.column_stack([path, np.ones(len(path))])
    assert covered(poses, poses) == pytest.approx(21.0)


def test_the_end_counts_from_where_a_target_is_reached():
    path, near, far = [[0, 0], [5, 0]], 5 - REACHED + 0.01, 5 - REACHED - 0.05
    assert covered(path, line([[0, 0], [near, 0]])) == 5.0
    assert covered(path, line([[0, 0], [far, 0]])) == pytest.approx(far, abs=0.02)


@pytest.mark.parametrize("aside", [0.0, 0.5, -0.95])
def test_beside_the_path_is_on_it(aside):
    track = line([[0, aside], [5, aside]])
    assert covered([[0, 0], [9, 0]], track) == pytest.approx(5.0, abs=0.03)


def test_a_robot_that_strays_has_covered_what_was_before():
    track = line([[0, 0], [4, 0], [4, STRAYED + 0.1], [4, 0], [9, 0]])
    assert covered([[0, 0], [9, 0]], track) == pytest.approx(4.0, abs=0.05)


def test_nothing_counts_after_a_collision():
    path = line([[0, 0], [8, 0]], step=0.1)
    assert covered(path, path, collided_at=30) == pytest.approx(3.0, abs=0.03)
    assert covered(path, path, collided_at=0) == 0.0


def test_a_short_cut_at_a_crossing_gets_no_farther():
    # Straight on where the path comes back to, and then along its end.
    track = line([[0, 0], [3, 0], [3, -4]])
    assert covered(LOOP, track) == pytest.approx(3.0, abs=STRAYED + 0.1)
    # A robot that takes the loop crosses its own path unharmed.
    assert covered(LOOP, line(LOOP)) == pytest.approx(21.0)


def test_a_turn_on_the_spot_may_be_cut_short():
    there_and_back = [[0, 0], [0.6, 0.2], [0, 0.4], [0.6, 0.6], [-8, 0.6]]
    track = line([[0, 0], [0, 0.6], [-8, 0.6]])
    length = np.hypot(*np.diff(there_and_back, axis=0).T).sum()
    assert length - 8.6 < AHEAD
    assert covered(there_and_back, track) == pytest.approx(length)


def test_the_other_lane_of_a_hairpin_is_elsewhere():
    path = [[0, 0], [10, 0], [10, 0.8], [0, 0.8]]
    there = line([[0, 0], [4, 0]])
    across = line([[4, 0], [4, 0.8], [0, 0.8]])
    assert covered(path, np.concatenate([there, across])) == pytest.approx(4.0, abs=0.1)


def test_driving_back_loses_nothing_and_gains_nothing():
    there, back = line([[0, 0], [4, 0]]), line([[4, 0], [3.2, 0]])
    assert covered([[0, 0], [9, 0]], np.concatenate([there, back])) == pytest.approx(4.0, abs=0.03)
    on = np.concatenate([there, back, line([[3.2, 0], [6, 0]])])
    assert covered([[0, 0], [9, 0]], on) == pytest.approx(6.0, abs=0.03)


def test_a_robot_at_the_start_has_covered_nothing():
    assert covered([[0, 0], [9, 0]], [[0, 0]] * 20) == 0.0


def test_a_robot_that_starts_elsewhere_never_followed():
    assert covered([[0, 0], [9, 0]], line([[0, 3], [9, 3]])) == 0.0


def test_a_path_of_one_point_is_covered_by_being_there():
    assert covered([[1, 1]], [[1, 1.1]]) == 0.0


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_it_is_the_same_wherever_the_world_lies(seed):
    rng = np.random.default_rng(seed)
    path = np.cumsum(rng.normal(0.3, 0.5, (12, 2)), axis=0)
    track = line(path) + np.cumsum(rng.normal(0, 0.02, (len(line(path)), 2)), axis=0)
    found = covered(path, track)
    assert 0.0 <= found <= np.hypot(*np.diff(path, axis=0).T).sum() + 1e-9
    moved = [compose([5.0, -2.0, 1.0], np.column_stack([p, p[:, 0]])) for p in (path, track)]
    assert covered(*moved) == pytest.approx(found, abs=0.05)
    # More of the track can only cover more.
    assert covered(path, track[: len(track) // 2]) <= found + 1e-9


@pytest.mark.parametrize(
    ("path", "track", "words"),
    [
        (np.zeros((0, 2)), [[0, 0]], "path: empty"),
        ([[0, 0]], np.zeros((0, 2)), "track: empty"),
        ([0, 0], [[0, 0]], "path: shape .2,."),
        ([[0], [1]], [[0, 0]], "path: shape .2, 1."),
        ([[0, 0], [np.nan, 1]], [[0, 0]], "path: .* finite"),
        ([[0, 0]], [[0, np.inf]], "track: .* finite"),
    ],
)
def test_what_is_no_path_is_refused(path, track, words):
    with pytest.raises(InputError, match=words):
        covered(path, track)


@pytest.mark.parametrize("metres", [np.inf, np.nan, -1.0])
def test_success_is_not_weighted_by_what_is_no_length(metres):
    with pytest.raises(InputError, match=r"shortest: .*give finite numbers from 0"):
        spl([1, 0], [2.0, metres], [1.0, 1.0])
    with pytest.raises(InputError, match=r"travelled: .*give finite numbers from 0"):
        spl([1, 0], [2.0, 2.0], [metres, 1.0])
    with pytest.raises(InputError, match=r"success: 2.0; give finite numbers from 0 to 1"):
        spl([1, 2], [2.0, 2.0], [2.0, 2.0])
    assert spl([1, 1], [0.0, 3.0], [0.0, 4.0]).tolist() == [1.0, 0.75]
