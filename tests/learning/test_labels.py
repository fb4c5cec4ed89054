import numpy as np
import pytest

from tests.conftest import make_box, make_trajectory
from tests.world.test_visibility import brute_share
from tutorial_lib.driving.data.perturbation import (
    PAPER_PERTURBATION,
    TRAINING_PERTURBATION,
    perturbed,
)
from tutorial_lib.geometry import to_local, to_world
from tutorial_lib.learning import waypoint_pairs
from tutorial_lib.learning.labels import (
    CANDIDATES,
    CLEARANCE,
    in_clear_sight,
    label,
    waypoint_labels,
)
from tutorial_lib.learning.waypoint_pairs import draw_waypoint_pairs
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.placing import is_free
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.visibility import FIELD_OF_VIEW, RAYS, mutual_overlap

BLOCK = Scene(make_box(pillars=[(5.0, 5.0, 2.0)]))  # a block from (3, 3) to (7, 7)
AROUND = make_trajectory([(2.0, 2.0), (8.0, 2.0), (8.0, 7.0)]).poses  # 6 m ahead, 5 m to the left


def gap_of_line(walls, start, end):
    """Metres between a line and the nearest wall, sampled every 4 mm."""
    count = max(2, int(np.hypot(*(end - start)) / 0.004))
    points = start + np.linspace(0, 1, count)[:, None, None] * (end - start)
    along = walls[:, 2:] - walls[:, :2]
    share = ((points - walls[:, :2]) * along).sum(-1) / (along**2).sum(1)
    foot = walls[:, :2] + share.clip(0, 1)[..., None] * along
    return np.hypot(*np.moveaxis(points - foot, -1, 0)).min()


def farthest_by_trying(walls, start, track, source, target):
    """The farthest candidate in the clear; None without one, "either" where it hangs on a hair."""
    if target <= source:
        return track[target, :2]
    for part in range(CANDIDATES, 0, -1):
        place = track[round(source + part / CANDIDATES * (target - source)), :2]
        gap = gap_of_line(walls, start[:2], place)
        if abs(gap - CLEARANCE) < 0.004:
            return "either"
        if gap > CLEARANCE:
            return place
    return None


@pytest.fixture(scope="module")
def near(recorded):
    """Starts beside the trajectories of an office, with the frames they go from and to.

    Farther apart than the pairs that are learnt from, so that many are hidden from each other.
    """
    rng = np.random.default_rng(4)
    targets = rng.integers(len(recorded.poses), size=45)
    sources = recorded.frame_at(targets, rng.uniform(-6.0, 1.0, 45))
    starts, _ = perturbed(recorded.scene, recorded.poses[sources], PAPER_PERTURBATION, rng)
    return starts, sources, targets


def test_waypoints_are_what_brute_force_finds(recorded, near):
    starts, sources, targets = near
    track, walls = recorded.poses, recorded.scene.plan.segments
    found, there = waypoint_labels(recorded.scene.caster, starts, track, sources, targets)
    compared, not_the_target = 0, 0
    for n, (start, source, target) in enumerate(zip(starts, sources, targets, strict=True)):
        wanted = farthest_by_trying(walls, start, track, source, target)
        if isinstance(wanted, str):
            continue
        compared += 1
        assert there[n] == (wanted is not None)
        if wanted is not None:
            assert to_world(start, found[n]) == pytest.approx(wanted, abs=1e-9)
            not_the_target += not np.allclose(wanted, track[target, :2])
    assert compared > 0.9 * len(starts)
    assert not_the_target > 5


def test_a_labelled_waypoint_is_in_sight_and_the_target_is_it_where_that_is_so(recorded, near):
    starts, sources, targets = near
    caster, track = recorded.scene.caster, recorded.poses
    found, there = waypoint_labels(caster, starts, track, sources, targets)
    places = to_world(starts, found)
    ahead = targets > sources
    assert caster.sees(starts[ahead & there, :2], places[ahead & there]).all()
    clear = in_clear_sight(caster, starts[:, :2], track[targets, :2])
    assert places[clear] == pytest.approx(track[targets[clear], :2], abs=1e-9)


def test_a_target_behind_is_its_own_waypoint_even_out_of_sight():
    starts = AROUND[[150, 20, 20]] + [0.0, 0.2, 0.3]
    found, there = waypoint_labels(
        BLOCK.caster, starts, AROUND, np.array([150, 20, 20]), np.array([20, 0, 20])
    )
    assert there.all()
    assert not BLOCK.caster.sees(starts[:1, :2], AROUND[20:21, :2])[0]
    assert found == pytest.approx(to_local(starts, AROUND[[20, 0, 20], :2]))
    assert found[1, 0] < -0.9


def test_along_a_corridor_the_target_itself_is_the_waypoint():
    corridor, track = Scene(make_box(12.0, 2.0)), make_trajectory([(0.5, 1.0), (11.5, 1.0)]).poses
    rng = np.random.default_rng(0)
    sources = rng.integers(0, 150, 40)
    targets = sources + rng.integers(1, 60, 40)
    starts, _ = perturbed(corridor, track[sources], PAPER_PERTURBATION, rng)
    found, there = waypoint_labels(corridor.caster, starts, track, sources, targets)
    assert there.all()
    assert to_world(starts, found) == pytest.approx(track[targets, :2], abs=1e-9)


def test_behind_a_corner_the_waypoint_is_the_last_place_before_it_hides():
    # The path is 11 m long: candidates lie 11/16 m apart. The corner (7, 3) hides what is above
    # y = 3.2 on the second leg, and 10/16 of its length end at (8, 2.875).
    target = len(AROUND) - 1
    found, there = waypoint_labels(
        BLOCK.caster, AROUND[:1], AROUND, np.array([0]), np.array([target])
    )
    assert there.all()
    assert found[0] == pytest.approx([6.0, 0.875], abs=0.026)  # to the nearest frame


def test_where_the_trajectory_is_hidden_altogether_there_is_no_waypoint():
    start = np.array([[5.0, 8.0, 0.0]])  # on the other side of the block
    _, there = waypoint_labels(BLOCK.caster, start, AROUND, np.array([0]), np.array([80]))
    assert not there[0]


@pytest.mark.parametrize(("gap", "clear"), [(0.05, False), (0.07, True), (-0.05, False)])
def test_a_clear_line_keeps_off_walls_on_either_side(gap, clear):
    below, above = 3.0 - gap, 7.0 + gap
    starts = np.array([[2.0, below], [2.0, above], [8.0, below], [8.0, above]])
    ends = np.array([[8.0, below], [8.0, above], [2.0, below], [2.0, above]])
    assert in_clear_sight(BLOCK.caster, starts, ends).tolist() == [clear] * 4
    nested = in_clear_sight(BLOCK.caster, starts.reshape(2, 2, 2), ends.reshape(2, 2, 2))
    assert nested.shape == (2, 2)


def test_labels_are_what_their_definitions_say():
    starts = np.array([[2.0, 2.0, 3.0], [2.0, 2.0, 0.2], [2.0, 8.0, -0.5]])
    goals = np.array([[2.5, 2.0, -3.0], [6.0, 1.0, 0.0], [2.0, 6.0, -1.5]])
    waypoints = np.arange(6.0).reshape(3, 2)
    found = label(BLOCK.caster, starts, goals, waypoints)
    assert (found.waypoint == waypoints).all()
    assert found.heading == pytest.approx([2 * np.pi - 6.0, -0.2, -1.0])
    for row, start, goal in zip(found.overlap, starts, goals, strict=True):
        brute = [
            brute_share(BLOCK.plan.segments, *pair, FIELD_OF_VIEW, RAYS)
            for pair in ((start, goal), (goal, start))
        ]
        assert row == pytest.approx(brute, abs=0.011)
    # The one that looks from farther back holds more of the other's view.
    assert found.overlap[1, 1] > found.overlap[1, 0] + 0.1


def drawn(recorded, seed=0, k=2):
    return draw_waypoint_pairs(
        recorded, 60, 4, k, TRAINING_PERTURBATION, np.random.default_rng(seed)
    )


def frames_of(recorded, poses):
    """The frame at which each pose (N, 3) was recorded."""
    same = (recorded.poses == poses[:, None]).all(axis=2)
    assert same.any(axis=1).all()
    return same.argmax(axis=1)


def test_pairs_lie_along_one_trajectory(recorded):
    pairs = drawn(recorded)
    assert pairs.starts.shape == (60, 4, 3)
    goals = frames_of(recorded, pairs.goals)
    assert (recorded.first[pairs.sources] == recorded.first[goals][:, None]).all()
    ahead = recorded.arc[goals][:, None] - recorded.arc[pairs.sources]
    frame = np.diff(recorded.poses[:, :2], axis=0)
    frame = np.hypot(*frame.T)[np.diff(recorded.first) == 0].max()
    assert -1.0 - frame <= ahead.min() < -0.8
    assert 2.8 < ahead.max() <= 3.0
    # Seen from the source, the start is where the perturbation put it: at its side.
    aside = to_local(recorded.poses[pairs.sources], pairs.starts[..., :2])
    assert aside[..., 0] == pytest.approx(0.0, abs=1e-9)
    assert 0.1 < np.abs(aside[..., 1]).mean() < 0.4


def test_pairs_to_learn_from_start_where_a_car_can_stand(recorded):
    pairs = drawn(recorded)
    good = pairs.starts[pairs.valid]
    assert pairs.valid.mean() > 0.9
    assert is_free(recorded.scene, BicycleCar(), good).all()
    sources = recorded.poses[pairs.sources[pairs.valid]]
    assert recorded.scene.caster.sees(good[:, :2], sources[:, :2]).all()


def test_pairs_without_a_place_to_start_or_go_are_not_learnt_from(recorded, monkeypatch):
    def half(scene, poses, perturbation, rng):
        return poses.copy(), np.arange(len(poses)) % 2 == 0

    def third(caster, starts, track, sources, targets):
        found, _ = waypoint_labels(caster, starts, track, sources, targets)
        return found, np.arange(len(starts)) % 3 > 0

    monkeypatch.setattr(waypoint_pairs, "perturbed", half)
    monkeypatch.setattr(waypoint_pairs, "waypoint_labels", third)
    number = np.arange(240)
    assert (drawn(recorded).valid.ravel() == ((number % 2 == 0) & (number % 3 > 0))).all()


def test_labels_of_pairs_belong_to_their_starts_and_targets(recorded):
    pairs = drawn(recorded)
    starts, goals = pairs.starts.reshape(-1, 3), np.repeat(pairs.goals, 4, axis=0)
    sources, targets = pairs.sources.ravel(), np.repeat(frames_of(recorded, pairs.goals), 4)
    caster = recorded.scene.caster
    wanted, there = waypoint_labels(caster, starts, recorded.poses, sources, targets)
    assert (pairs.labels.waypoint == wanted).all()
    assert not pairs.valid.ravel()[~there].any()
    turned = np.angle(np.exp(1j * (goals[:, 2] - starts[:, 2])))
    assert np.exp(1j * pairs.labels.heading) == pytest.approx(np.exp(1j * turned))
    assert (pairs.labels.overlap == mutual_overlap(caster, starts, goals)).all()


@pytest.mark.parametrize("k", [0, 2, 5])
def test_contexts_of_pairs_are_the_frames_around_the_target(recorded, k):
    pairs = drawn(recorded, k=k)
    assert pairs.contexts.shape == (60, 2 * k + 1, 3)
    assert (pairs.contexts[:, k] == pairs.goals).all()
    for frame, poses in zip(frames_of(recorded, pairs.goals), pairs.contexts, strict=True):
        first, last = recorded.first[frame], recorded.last[frame]
        track = recorded.poses[first : last + 1]
        around = np.clip(frame - first + 3 * np.arange(-k, k + 1), 0, last - first)
        assert (poses == track[around]).all()


def test_the_same_seed_draws_the_same_pairs(recorded):
    one, two, other = drawn(recorded), drawn(recorded), drawn(recorded, seed=1)
    for name in ("starts", "sources", "goals", "contexts", "valid"):
        assert getattr(one, name).tobytes() == getattr(two, name).tobytes()
        assert getattr(one, name).shape == getattr(other, name).shape
    assert one.labels.waypoint.tobytes() == two.labels.waypoint.tobytes()
    assert (one.starts != other.starts).any()
