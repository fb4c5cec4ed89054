"""Panoramas, their labels, and the groups that the multi-task network learns from."""

import colorsys
from dataclasses import fields, replace

import joblib
import numpy as np
import pytest

from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.exploration.labels import PanoramaLabels, explorable
from tutorial_lib.geometry import relative
from tutorial_lib.learning import exploration_data
from tutorial_lib.learning.exploration_data import (
    FARTHEST,
    SHORTEST,
    PanoramaWorld,
    labels_of,
    panorama_worlds,
    random_poses,
    room_numbers,
    training_plan,
    unseen_plan,
)
from tutorial_lib.learning.panorama_batches import (
    GROUP,
    PanoramaBatch,
    PanoramaSource,
    batch_of,
    draw_groups,
    mirrored,
    recoloured,
)
from tutorial_lib.world.worlds import scene_of

PLAN, COUNT = ("office", 1), 30
NAMES = [field.name for field in fields(PanoramaBatch)]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("panoramas")


@pytest.fixture(scope="module")
def world(folder):
    with joblib.parallel_config(backend="threading"):
        return panorama_worlds([PLAN], folder, COUNT, jobs=1)[0]


@pytest.fixture(scope="module")
def scene():
    return scene_of("office/1/standard")


def same(one, two):
    return all(np.array_equal(getattr(one, name), getattr(two, name)) for name in NAMES)


def test_plans_of_training_are_mixed_and_those_of_validation_are_not():
    families = [training_plan(seed)[0] for seed in range(48)]
    assert {families.count(name) for name in ("scanned", "maze", "hall")} == {2}
    assert families.count("apartment") == 24
    assert {unseen_plan(seed)[0] for seed in range(10_000, 10_020)} == {"apartment", "office"}


def test_places_are_free_and_anywhere(scene):
    poses = random_poses(scene, 400, np.random.default_rng(0))
    assert scene.clearance.at(poses[:, :2]).min() > 0.15
    assert len(np.unique(room_numbers(scene.plan, poses[:, :2]))) > 5
    assert np.histogram(poses[:, 2], 4, (-np.pi, np.pi))[0].min() > 70


@pytest.mark.full
def test_metres_are_geodesics_from_the_ends_to_the_goal(scene, world):
    paths, labels = GridPaths(scene.clearance), PanoramaLabels(scene, world.poses)
    for source, goal in ((0, 5), (7, 3), (12, 29)):
        goals = np.broadcast_to(world.poses[goal, :2], (12, 2))
        wanted = paths.between(labels.ends[source], goals)
        wanted[labels.lengths[source] < SHORTEST] = np.inf
        far = paths.between(world.poses[[source], :2], world.poses[[goal], :2])
        wanted = wanted if far <= FARTHEST else np.full(12, np.inf)
        assert world.metres[source, goal] == pytest.approx(wanted, rel=2e-3, abs=0.01)
        if far <= FARTHEST:
            assert world.far[source, goal] == pytest.approx(far[0], rel=2e-3)
    assert np.isfinite(world.metres).any(axis=-1).mean() > 0.5


def test_pairs_that_are_too_far_apart_have_no_metres(scene, world, monkeypatch):
    monkeypatch.setattr(exploration_data, "FARTHEST", 4.0)
    found = labels_of(scene, world.poses)
    near = world.far <= 4.0
    assert near.any()
    assert (np.isfinite(world.far) & ~near).any()
    assert (np.isfinite(found["far"]) == near).all()
    assert np.isinf(found["metres"][~near]).all()
    assert (found["metres"][near] == world.metres[near]).all()


def test_connected_places_are_near_and_in_sight(scene, world):
    source, goal = np.nonzero(world.connected)
    gap = np.linalg.norm(world.poses[source, :2] - world.poses[goal, :2], axis=1)
    assert gap.max() <= 3.0
    assert world.connected.diagonal().all()
    clear = scene.caster.sees(world.poses[source, :2], world.poses[goal, :2])
    assert clear.mean() > 0.9  # within 5 degrees of it something farther is seen
    near = np.linalg.norm(world.poses[:, None, :2] - world.poses[:, :2], axis=-1) <= 3.0
    hidden = near & ~world.connected
    assert hidden.any()


def test_rooms_are_those_of_the_plan(scene, world):
    labels = PanoramaLabels(scene, world.poses)
    assert (world.explorable == labels.explorable).all()
    assert (world.kinds == labels.end_rooms).all()
    for number, room in enumerate(scene.plan.rooms):
        assert (room.contains(world.poses[:, :2]) == (world.room == number)).all()
    outside = np.array([[-99.0, -99.0]])
    assert room_numbers(scene.plan, outside).tolist() == [-1]
    assert (world.room != -1).all()  # so that an end in no room is in nobody's


def test_both_kinds_of_signs_show_the_same_places(world):
    assert set(world.images) == {"plain", "wayfinding"}
    plain, signs = world.images["plain"], world.images["wayfinding"]
    assert plain.shape == signs.shape == (COUNT, 16, 192, 3)
    differs = (plain != signs).any(axis=-1).mean()
    assert 0.02 < differs < 0.6


@pytest.mark.full
def test_a_recording_is_kept_and_a_damaged_one_made_again(world, folder, monkeypatch):
    (path,) = (folder / "panoramas").glob("*.npz")
    before = path.read_bytes()
    with joblib.parallel_config(backend="threading"):
        monkeypatch.setattr(exploration_data, "labels_of", None)
        again = panorama_worlds([PLAN], folder, COUNT, jobs=1)[0]
        monkeypatch.undo()
        path.write_bytes(before[:1000])
        mended = panorama_worlds([PLAN], folder, COUNT, jobs=1)[0]
    for name in ("poses", "metres", "connected", "room"):
        assert np.array_equal(getattr(world, name), getattr(again, name)), name
        assert np.array_equal(getattr(world, name), getattr(mended, name)), name
    assert np.array_equal(world.images["plain"], mended.images["plain"])


# Groups.


def test_a_group_is_near_its_first_panorama_and_has_each_once():
    rng = np.random.default_rng(0)
    places = rng.uniform(0, 30, (300, 2))
    far = np.linalg.norm(places[:, None] - places, axis=-1)
    groups = draw_groups(far, 50, rng)
    assert groups.shape == (50, GROUP)
    assert all(len(set(group)) == GROUP for group in groups.tolist())
    for columns, metres in ((slice(1, 4), 4.0), (slice(4, 6), 8.0), (slice(6, 8), 12.0)):
        assert (far[groups[:, :1], groups[:, columns]] <= metres).mean() > 0.95
    assert (far[groups[:, :1], groups[:, 6:]] > 8.0).mean() > 0.2


def test_a_place_with_no_neighbours_still_has_a_group():
    far = np.where(np.eye(GROUP, dtype=bool), 0.0, np.inf)
    groups = draw_groups(far, 5, np.random.default_rng(0))
    assert all(len(set(group)) == GROUP for group in groups.tolist())


def test_labels_of_a_batch_belong_to_its_pairs(world):
    groups = draw_groups(world.far, 6, np.random.default_rng(1))
    batch = batch_of(world, "plain", groups)
    seen = relative(world.poses[groups][:, :, None], world.poses[groups][:, None])
    bearing = np.arctan2(seen[..., 1], seen[..., 0])
    bearings = (batch.direction + 0.5 * batch.offset) * np.deg2rad(30.0)
    turn = np.cos(bearings - bearing)
    assert turn == pytest.approx(np.ones_like(turn), abs=1e-6)
    assert (np.abs(batch.offset) <= 1.0).all()
    distance = np.linalg.norm(seen[..., :2], axis=-1)
    near = batch.nearness > 0
    assert 3.0 * (1 - batch.nearness[near]) == pytest.approx(distance[near], abs=1e-5)
    assert not batch.used[:, range(GROUP), range(GROUP)].any()
    assert batch.far[batch.used].max() <= 12.0
    group, source, goal = np.argwhere(batch.used)[17]
    one, two = groups[group, source], groups[group, goal]
    assert batch.metres[group, source, goal] == pytest.approx(world.metres[one, two])
    same_room = (world.rooms[one] == world.room[two]).astype(float)
    assert batch.same_room[group, source, goal].tolist() == same_room.tolist()


def test_pairs_index_labels_and_panoramas(world):
    batch = batch_of(world, "plain", draw_groups(world.far, 3, np.random.default_rng(1)))
    pairs, sources, goals = (index.numpy() for index in batch.pairs())
    group, source, goal = np.nonzero(batch.used)
    assert (batch.direction.ravel()[pairs] == batch.direction[group, source, goal]).all()
    images = batch.images.reshape(-1, 16, 192, 3)
    assert (images[sources] == batch.images[group, source]).all()
    assert (images[goals] == batch.images[group, goal]).all()


def test_a_mirror_exchanges_left_and_right(world):
    batch = batch_of(world, "plain", draw_groups(world.far, 4, np.random.default_rng(1)))
    which = np.array([True, False, True, False])
    seen = mirrored(batch, which)
    assert same(mirrored(seen, which), batch)
    for name in NAMES:
        assert np.array_equal(getattr(seen, name)[~which], getattr(batch, name)[~which])
    # Labels that follow from depth are those of the mirrored depth.
    depth = seen.depth[0].astype(float)
    assert (explorable(depth) == seen.explorable[0]).mean() > 0.99
    bearings, was = ((b.direction + 0.5 * b.offset)[which] * 30.0 for b in (seen, batch))
    assert np.cos(np.deg2rad(bearings + was)) == pytest.approx(np.ones(bearings.shape), abs=1e-6)


def test_other_colours_keep_the_differences_of_hues():
    rng = np.random.default_rng(0)
    hues = rng.random((200, 2))
    turned = []
    for pair in hues:
        colours = [[255 * c for c in colorsys.hsv_to_rgb(hue, 0.8, 0.9)] for hue in pair]
        changed = recoloured(np.rint(colours).astype(np.uint8)[None], rng)[0] / 255
        turned.append([colorsys.rgb_to_hsv(*colour)[0] for colour in changed])

    def gap(pairs):
        difference = np.abs(np.diff(pairs, axis=1)[:, 0])
        return np.minimum(difference, 1 - difference)

    assert np.abs(gap(np.array(turned)) - gap(hues)).mean() < 0.04
    shift = (np.array(turned)[:, 0] - hues[:, 0]) % 1
    assert shift.std() > 0.2  # the colours themselves are others


def test_blocks_depend_on_their_seed_alone(world):
    source = PanoramaSource([world], worlds=3, targets=4)
    assert same(source.block([0, 1]), source.block([0, 1]))
    assert not same(source.block([0, 1]), source.block([0, 2]))
    assert len(source.block([0, 1]).images) == 12
    part = source.block([0, 1]).targets(slice(2, 5))
    assert same(part, replace(part))
    assert part.images.shape[:2] == (3, GROUP)


def test_a_masked_source_has_scores_of_unconnected_pairs_only(world):
    usual, masked = (PanoramaSource([world], worlds=3, targets=4, masked=m) for m in (False, True))
    one, other = (source.block([0, 1]) for source in (usual, masked))
    assert same(replace(other, metres=one.metres), one)
    connected = one.connected > 0
    assert 0.1 < connected[one.used].mean() < 0.9
    assert np.isinf(other.metres[connected]).all()
    assert np.array_equal(other.metres[~connected], one.metres[~connected])
    assert usual.recipe != masked.recipe  # an interrupted training does not go on as the other
    assert "scores" not in usual.recipe  # the checkpoints there are stay its own


def test_variation_changes_images_and_never_what_is_stored(world):
    before = {signs: images.copy() for signs, images in world.images.items()}
    PanoramaSource([world], worlds=4, targets=8).block([0])
    for signs, images in world.images.items():
        assert np.array_equal(images, before[signs])


def test_labels_can_be_pickled_between_processes(scene):
    poses = random_poses(scene, 5, np.random.default_rng(0))
    arrays = labels_of(scene, poses)
    assert set(arrays) == {field.name for field in fields(PanoramaWorld)} - {"depth", "images"}
    assert arrays["metres"].dtype == np.float16
