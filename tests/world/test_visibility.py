import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tests.conftest import make_box, random_walls
from tutorial_lib.geometry import distance_to_segments
from tutorial_lib.world.raycast import Raycaster
from tutorial_lib.world.visibility import FIELD_OF_VIEW, OFF_THE_WALL, RAYS, mutual_overlap

ROOM = Raycaster(make_box().segments)
CLUTTER = Raycaster(
    np.concatenate(
        [make_box().segments, random_walls(12, 10.0, np.random.default_rng(5)).clip(0.1, 9.9)]
    )
)


def random_poses(count, seed):
    rng = np.random.default_rng(seed)
    return np.column_stack([rng.uniform(0.5, 9.5, (count, 2)), rng.uniform(-np.pi, np.pi, count)])


def meets(start, direction, wall):
    """The share of `direction` after which a line from `start` meets a wall, inf for never."""
    x0, y0, x1, y1 = wall
    matrix = np.array([[direction[0], x0 - x1], [direction[1], y0 - y1]])
    if abs(np.linalg.det(matrix)) < 1e-12:
        return np.inf
    share, along = np.linalg.solve(matrix, [x0 - start[0], y0 - start[1]])
    return share if share >= 0 and 0 <= along <= 1 else np.inf


def brute_share(walls, viewer, other, field, rays):
    """The share of a viewer's points that another sees, one at a time."""
    count = 0
    for ray in range(rays):
        angle = viewer[2] - field / 2 + field * (ray + 0.5) / rays
        direction = np.array([np.cos(angle), np.sin(angle)])
        distance = min(meets(viewer[:2], direction, wall) for wall in walls)
        if np.isfinite(distance):
            point = viewer[:2] + (distance - OFF_THE_WALL) * direction
            line = point - other[:2]
            bearing = np.angle(np.exp(1j * (np.arctan2(line[1], line[0]) - other[2])))
            blocked = any(meets(other[:2], line, wall) < 1 for wall in walls)
            count += abs(bearing) <= field / 2 and not blocked
    return count / rays


@pytest.mark.parametrize(("field", "rays"), [(FIELD_OF_VIEW, RAYS), (1.2, 37)])
@pytest.mark.few(1)
def test_overlap_is_what_brute_force_counts(field, rays):
    rng = np.random.default_rng(7)
    first = random_poses(12, 8)
    second = random_poses(12, 9)
    second[:8] = first[:8] + rng.normal(0, [0.8, 0.8, 0.4], (8, 3))  # pairs that share a lot
    second[:, :2] = second[:, :2].clip(0.2, 9.8)
    for poses in (first, second):
        assert distance_to_segments(poses[:, :2], CLUTTER.segments).min() > OFF_THE_WALL
    brute = [
        [brute_share(CLUTTER.segments, *pair, field, rays) for pair in ((a, b), (b, a))]
        for a, b in zip(first, second, strict=True)
    ]
    found = mutual_overlap(CLUTTER, first, second, field, rays)
    assert np.allclose(found, brute, atol=1e-9)
    assert (found > 0.3).sum() > 4
    assert (found < 1).any()


def test_rays_that_leave_the_world_count_as_unseen():
    caster = Raycaster([[3.0, -1.0, 3.0, 1.0]])
    pose = np.array([[0.0, 0.0, 0.0]])
    half = np.arctan2(1.0, 3.0)
    assert mutual_overlap(caster, pose, pose) == pytest.approx(2 * half / FIELD_OF_VIEW, abs=0.02)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000))
@example(52)  # its fourth pose is 4 cm from a wall, with the field's right end behind it
def test_a_view_holds_all_of_itself(seed):
    poses = random_poses(5, seed)
    for caster in (ROOM, CLUTTER):
        assert (mutual_overlap(caster, poses, poses) == 1).all()


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000), st.floats(-np.pi, np.pi))
def test_a_turn_on_the_spot_leaves_the_common_part_of_the_field_of_view(seed, turn):
    pose = random_poses(1, seed)
    common = max(0.0, 1 - abs(turn) / FIELD_OF_VIEW)
    found = mutual_overlap(CLUTTER, pose, pose + np.array([0, 0, turn]))
    assert np.allclose(found, common, atol=1.5 / RAYS)


def test_back_to_back_and_on_two_sides_of_a_wall_nothing_is_shared():
    first = np.array([[4.9, 5.0, np.pi], [3.0, 5.0, 0.0], [3.0, 5.0, 0.0]])
    second = np.array([[5.1, 5.0, 0.0], [7.0, 5.0, np.pi], [7.0, 5.0, 0.0]])
    divided = Raycaster(np.concatenate([ROOM.segments, [[5.0, 0.0, 5.0, 10.0]]]))
    assert (mutual_overlap(ROOM, first[:1], second[:1]) == 0).all()
    assert (mutual_overlap(divided, first, second) == 0).all()
    assert (mutual_overlap(ROOM, first[1:], second[1:]) > 0).any()


def test_the_closer_view_sees_less():
    far, near = [[1.0, 5.0, 0.0]], [[9.0, 5.0, 0.0]]
    ((far_in_near, near_in_far),) = mutual_overlap(ROOM, far, near)
    assert near_in_far == 1
    assert 0.1 < far_in_near < 0.5


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000))
def test_overlaps_are_shares_and_change_sides_with_the_poses(seed):
    first, second = random_poses(20, seed), random_poses(20, seed + 1)
    found = mutual_overlap(CLUTTER, first, second)
    assert found.shape == (20, 2)
    assert found.dtype == np.float64
    assert ((found >= 0) & (found <= 1)).all()
    assert np.allclose(found * RAYS, np.round(found * RAYS))
    assert (mutual_overlap(CLUTTER, second, first) == found[:, ::-1]).all()


def test_a_batch_gives_what_single_pairs_give():
    first, second = random_poses(30, 1), random_poses(30, 2)
    batch = mutual_overlap(CLUTTER, first, second)
    for pair in zip(first, second, batch, strict=True):
        assert (mutual_overlap(CLUTTER, *pair[:2])[0] == pair[2]).all()
    assert mutual_overlap(CLUTTER, np.zeros((0, 3)), np.zeros((0, 3))).shape == (0, 2)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000), st.floats(-3, 3), st.floats(-50, 50))
def test_overlap_does_not_depend_on_where_the_world_lies(seed, turn, shift):
    first, second = random_poses(4, seed), random_poses(4, seed + 1)
    cos, sin = np.cos(turn), np.sin(turn)
    matrix = np.array([[cos, sin], [-sin, cos]])
    moved = Raycaster((ROOM.segments.reshape(-1, 2) @ matrix + shift).reshape(-1, 4))
    poses = [np.column_stack([p[:, :2] @ matrix + shift, p[:, 2] + turn]) for p in (first, second)]
    same = mutual_overlap(ROOM, first, second)
    assert np.allclose(mutual_overlap(moved, *poses), same, atol=1.5 / RAYS)
