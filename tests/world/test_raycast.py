import numpy as np
import pymunk
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import random_walls
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.benchmarks.raycast import numpy_distances
from tutorial_lib.geometry import distance_to_segments
from tutorial_lib.world.generators import FAMILIES, generate
from tutorial_lib.world.raycast import GRID_FROM, Discs, Fan, Raycaster
from tutorial_lib.world.scene import Scene

FANS = {
    "camera": Fan(np.arctan(np.tan(np.pi / 3) * np.linspace(-0.98, 0.98, 64))),
    "circle": Fan((np.arange(96) + 0.5) * 2 * np.pi / 96 - np.pi),
    "few": Fan([-0.3, 0.0, 2.0]),
    "one": Fan([0.7]),
}


def random_poses(count, side, rng):
    return np.column_stack([rng.uniform(0, side, (count, 2)), rng.uniform(-np.pi, np.pi, count)])


def query(space, x, y, angle, reach=100.0):
    end = (x + reach * np.cos(angle), y + reach * np.sin(angle))
    hit = space.segment_query_first((x, y), end, 0.0, pymunk.ShapeFilter())
    return hit.alpha * reach if hit else np.inf


@pytest.mark.parametrize("fan", FANS.values(), ids=FANS)
@pytest.mark.parametrize("grid", [False, True])
@pytest.mark.parametrize("walls", [3, 40, 700])
def test_rays_agree_with_pymunk(fan, grid, walls):
    rng = np.random.default_rng(walls)
    segments = random_walls(walls, np.sqrt(walls), rng)
    poses = random_poses(30, np.sqrt(walls) + 1, rng)
    hits = Raycaster(segments, grid).cast(poses, fan)
    space = pymunk.Space()
    for x0, y0, x1, y1 in segments.tolist():
        space.add(pymunk.Segment(space.static_body, (x0, y0), (x1, y1), 0.0))
    for pose, distances in zip(poses, hits.distance, strict=True):
        for angle, distance in zip(fan.angles, distances, strict=True):
            expected = query(space, pose[0], pose[1], pose[2] + angle)
            if not np.isclose(distance, expected, atol=1e-6):
                # At a corner either neighbour is right: both rays pass within a hair of an end.
                ray = np.array([np.cos(pose[2] + angle), np.sin(pose[2] + angle)])
                ends = segments.reshape(-1, 2) - pose[:2]
                off = np.abs(ends @ [-ray[1], ray[0]])[ends @ ray > 0]
                assert off.min() < 1e-5


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10_000), st.integers(1, 60))
def test_both_kernels_and_numpy_agree(seed, walls):
    rng = np.random.default_rng(seed)
    segments, poses = random_walls(walls, 8, rng), random_poses(8, 10, rng)
    brute = numpy_distances(segments, poses, FANS["circle"])
    for grid in (False, True):
        hits = Raycaster(segments, grid).cast(poses, FANS["circle"])
        assert np.mean(np.isclose(hits.distance, brute, atol=1e-6)) > 0.998


@pytest.mark.parametrize("grid", [False, True])
def test_wall_and_along_say_where_the_ray_ended(grid):
    rng = np.random.default_rng(2)
    segments, poses = random_walls(60, 8, rng), random_poses(50, 8, rng)
    fan = FANS["camera"]
    hits = Raycaster(segments, grid).cast(poses, fan)
    met = np.isfinite(hits.distance)
    assert (hits.wall[~met] == -1).all()
    angles = poses[:, 2:] + fan.angles
    ends = poses[:, None, :2] + hits.distance[..., None] * np.stack(
        [np.cos(angles), np.sin(angles)], axis=-1
    )
    walls = segments[hits.wall[met]]
    run = walls[:, 2:] - walls[:, :2]
    on_wall = walls[:, :2] + run * (hits.along[met] / np.linalg.norm(run, axis=1))[:, None]
    assert np.allclose(ends[met], on_wall, atol=1e-5)


@pytest.mark.parametrize("family", FAMILIES)
def test_no_ray_escapes_a_plan(family):
    scene = Scene(generate(family, 4))
    grid = scene.clearance
    cells = np.argwhere(grid.clearance > 0.05)
    places = grid.centres(cells[np.random.default_rng(0).integers(len(cells), size=300)])
    poses = np.column_stack([places, np.zeros(len(places))])
    circle = Fan(np.linspace(-np.pi, np.pi, 720))
    assert np.isfinite(scene.caster.cast(poses, circle).distance).all()


def test_a_ray_along_a_wall_and_from_a_wall_is_harmless():
    caster = Raycaster([[0, 0, 4, 0], [4, 0, 4, 4]])
    hits = caster.cast(np.array([[-1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]), Fan([0.0]))
    assert hits.distance[0, 0] in (pytest.approx(1.0), pytest.approx(5.0))
    assert not np.isnan(hits.distance).any()


def test_one_pose_gives_what_the_batch_gives():
    rng = np.random.default_rng(3)
    for walls in (100, GRID_FROM + 100):
        caster, poses = Raycaster(random_walls(walls, 12, rng)), random_poses(40, 12, rng)
        batch = caster.cast(poses, FANS["camera"])
        for i, pose in enumerate(poses):
            single = caster.cast(pose[None], FANS["camera"])
            assert (single.distance[0] == batch.distance[i]).all()
            assert (single.wall[0] == batch.wall[i]).all()


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000))
def test_discs_cover_walls_and_respect_their_owner(seed):
    rng = np.random.default_rng(seed)
    caster = Raycaster([[-9, -9, 9, -9], [9, -9, 9, 9], [9, 9, -9, 9], [-9, 9, -9, -9]])
    poses = np.column_stack([rng.uniform(-2, 2, (4, 2)), rng.uniform(-3, 3, 4)])
    circles = np.column_stack([rng.uniform(-8, 8, (5, 2)), rng.uniform(0.1, 0.5, 5)])
    circles = circles[np.linalg.norm(circles[:, :2], axis=1) > 4]
    owners = rng.integers(-1, 4, len(circles)).astype(np.int32)
    discs = Discs(circles, owners, np.zeros((len(circles), 3), np.float32))
    fan = FANS["circle"]
    bare, hits = caster.cast(poses, fan), caster.cast(poses, fan, discs)
    for i, pose in enumerate(poses):
        for r, angle in enumerate(pose[2] + fan.angles):
            ray = np.array([np.cos(angle), np.sin(angle)])
            nearest = bare.distance[i, r]
            for (x, y, radius), owner in zip(circles, owners, strict=True):
                if owner in (-1, i):
                    centre = np.array([x, y]) - pose[:2]
                    forward, aside = centre @ ray, centre @ [-ray[1], ray[0]]
                    if forward > 0 and abs(aside) < radius:
                        nearest = min(nearest, forward - np.sqrt(radius**2 - aside**2))
            assert hits.distance[i, r] == pytest.approx(nearest, abs=1e-9)


def test_sight_is_cut_by_walls_alone():
    caster = Raycaster([[1, -1, 1, 1]])
    origins, points = np.zeros((3, 2)), np.array([[2.0, 0.0], [0.9, 0.0], [2.0, 3.0]])
    assert caster.sees(origins, points).tolist() == [False, True, True]
    assert caster.sees(origins[:1], [[1.0, 0.0]]).tolist() == [True]


def test_one_origin_may_look_at_many_points():
    caster = Raycaster([[1, -1, 1, 1]])
    points = np.column_stack([np.full(500, 0.5), np.linspace(-1, 1, 500)])
    assert caster.sees([[0.0, 0.0]], points).all()


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000))
def test_sight_by_brute_force(seed):
    rng = np.random.default_rng(seed)
    segments = random_walls(30, 6, rng)
    origins, points = rng.uniform(0, 6, (2, 40, 2))
    seen = Raycaster(segments).sees(origins, points)
    for a, b, clear in zip(origins, points, seen, strict=True):
        line = a + np.linspace(0, 1, 400)[:, None] * (b - a)
        closest = distance_to_segments(line, segments).min()
        if clear:
            assert closest > 0
        else:
            assert closest < np.linalg.norm(b - a) / 300


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Raycaster(np.zeros((3, 3))), r"segments: shape \(3, 3\)"),
        (lambda: Raycaster([[0, 0, np.nan, 1]]), "segments: nan; give finite"),
        (lambda: Fan([1.0, 0.0]), "rising"),
        (lambda: Fan([]), "angles: empty"),
        (
            lambda: Raycaster([[0, 0, 1, 1]]).cast(np.zeros((2, 2)), Fan([0.0])),
            r"poses: shape \(2, 2\)",
        ),
        (lambda: Raycaster([[0, 0, 1, 1]]).sees([[0.0, 0.0]], [1.0, 1.0, 1.0]), "points: shape"),
        (lambda: Discs(np.zeros((2, 3)), np.zeros(1, np.int32), np.zeros((2, 3))), "as many"),
    ],
)
def test_bad_input_is_named(make, words):
    with pytest.raises(InputError, match=words):
        make()


def in_a_box(*circle):
    """A room of 18 m around the origin, and a disc in it."""
    caster = Raycaster([[-9, -9, 9, -9], [9, -9, 9, 9], [9, 9, -9, 9], [-9, 9, -9, -9]])
    return caster, Discs(np.array([circle]), np.array([-1], np.int32), np.zeros((1, 3), np.float32))


@pytest.mark.parametrize("place", [(0.0, 0.0), (0.3, -0.2), (-0.1, 0.45)])
def test_a_disc_is_not_seen_from_inside(place):
    caster, discs = in_a_box(0.0, 0.0, 0.5)
    pose = np.array([[*place, 0.7]])
    bare, hits = caster.cast(pose, FANS["circle"]), caster.cast(pose, FANS["circle"], discs)
    assert (hits.distance == bare.distance).all()
    assert (hits.wall == bare.wall).all()
    assert (hits.along == bare.along).all()


@pytest.mark.parametrize("heading", [0.0, 1.2, -2.5])
def test_along_a_disc_is_counted_from_its_east_side(heading):
    caster, discs = in_a_box(2.0, 1.0, 0.5)
    poses = np.array([[0.0, 0.0, heading], [2.0, 5.0, heading], [5.0, 0.5, heading]])
    hits = caster.cast(poses, FANS["circle"], discs)
    pose, ray = np.nonzero(hits.wall == 4)
    assert np.bincount(pose).min() > 2
    angles = poses[pose, 2] + FANS["circle"].angles[ray]
    rays = np.column_stack([np.cos(angles), np.sin(angles)])
    ends = poses[pose, :2] + hits.distance[pose, ray, None] * rays - [2.0, 1.0]
    around = np.arctan2(ends[:, 1], ends[:, 0]) % (2 * np.pi)
    assert hits.along[pose, ray] == pytest.approx(0.5 * around, abs=1e-9)
