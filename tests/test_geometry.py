import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from tutorial_lib.geometry import (
    compose,
    distance_to_segments,
    inverse,
    relative,
    to_local,
    to_world,
    wrap,
)

coordinate = st.floats(-50, 50)
pose = st.tuples(coordinate, coordinate, st.floats(-3.1, 3.1)).map(np.array)
point = st.tuples(coordinate, coordinate).map(np.array)


def matrix(p):
    cos, sin = np.cos(p[2]), np.sin(p[2])
    return np.array([[cos, -sin, p[0]], [sin, cos, p[1]], [0, 0, 1]])


def same_pose(a, b):
    return np.allclose(a[:2], b[:2], atol=1e-8) and abs(wrap(a[2] - b[2])) < 1e-8


@given(st.floats(-1e4, 1e4))
def test_wrap_lands_in_the_half_open_turn_and_keeps_the_direction(angle):
    wrapped = wrap(angle)
    assert -np.pi <= wrapped < np.pi
    assert np.isclose(np.exp(1j * wrapped), np.exp(1j * angle), atol=1e-8)


@given(pose, point)
def test_local_and_world_undo_each_other(p, q):
    assert np.allclose(to_world(p, to_local(p, q)), q, atol=1e-9)


@given(pose, pose)
def test_compose_is_the_product_of_matrices(a, b):
    assert np.allclose(matrix(compose(a, b)), matrix(a) @ matrix(b), atol=1e-9)


@given(pose, pose)
def test_relative_undoes_compose(a, b):
    assert same_pose(relative(a, compose(a, b)), b)


@given(pose, pose, pose)
def test_compose_is_associative(a, b, c):
    assert same_pose(compose(compose(a, b), c), compose(a, compose(b, c)))


@given(pose)
def test_inverse_gives_the_identity(p):
    assert same_pose(compose(p, inverse(p)), np.zeros(3))


def test_batches_give_what_single_poses_give():
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(2, 7, 3))
    for function in (compose, relative):
        assert np.allclose(function(a, b), [function(*pair) for pair in zip(a, b, strict=True)])


def test_distance_to_segments_by_brute_force():
    rng = np.random.default_rng(1)
    points, segments = rng.normal(size=(20, 2)), rng.normal(size=(10, 4))
    share = np.linspace(0, 1, 2001)[:, None, None]
    along = segments[:, :2] + share * (segments[:, 2:] - segments[:, :2])
    brute = np.linalg.norm(points[:, None, None] - along.transpose(1, 0, 2), axis=-1).min(axis=2)
    assert np.allclose(distance_to_segments(points, segments), brute, atol=2e-3)
