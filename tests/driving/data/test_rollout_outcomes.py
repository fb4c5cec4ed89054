"""Rollout outcomes: each pair's rollout ends as it would alone, and outcomes are kept on disk."""

from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.conftest import make_trajectory
from tutorial_lib.driving.control.oracle import OraclePolicy
from tutorial_lib.driving.data import rollout_outcomes as module
from tutorial_lib.driving.data.reachability_pairs import (
    ReachabilityPairs,
    draw_reachability_pairs,
    reachability_pairs,
)
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.rollout_outcomes import (
    RolloutOutcomes,
    load_outcomes,
    roll_out_pairs,
    save_outcomes,
)
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.driving.rollouts import SETTLED, ReachGoals, rollout
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import to_local
from tutorial_lib.world.sensors import Camera
from tutorial_lib.world.simulation import Sensors, Simulation

COLUMNS = [field.name for field in fields(ReachabilityPairs)]
ENDS = [field.name for field in fields(RolloutOutcomes)][1:]


class Homing:
    """Straight to the target, whatever is in between; it knows where the robots are."""

    def __init__(self, simulation, recorded, frames):
        self.simulation, self.goals = simulation, recorded.poses[frames]

    def act(self, observations, robots):
        ahead = to_local(self.simulation.poses[robots], self.goals[robots, :2])
        turn = np.clip(np.arctan2(ahead[:, 1], ahead[:, 0]), -0.45, 0.45)
        return np.column_stack([np.full(len(robots), 0.5), turn])


class Asleep:
    """Stands still."""

    def __init__(self, simulation, recorded, frames):
        pass

    def act(self, observations, robots):
        return np.zeros((len(robots), 2))


@pytest.fixture(scope="module")
def world(pillars):
    """Trajectories around pillars."""
    lines = [(1.0, 1.0), (9.0, 1.0), (9.0, 5.5), (2.0, 5.5)], [(1.0, 9.0), (9.0, 9.0)]
    return RecordedWorld(pillars, [make_trajectory(line) for line in lines])


@pytest.fixture(scope="module")
def pairs(world):
    drawn = draw_reachability_pairs(
        world, GridPaths(world.scene.clearance), 13, np.random.default_rng(0)
    )
    return drawn.subset(np.flatnonzero(~drawn.far_and_occluded)[:60])


@pytest.fixture(scope="module")
def outcomes(world, pairs):
    return roll_out_pairs(world, pairs, Homing)


@pytest.fixture(scope="module")
def hidden(recorded):
    """`ReachabilityPairs` in an office, of which some are far and occluded."""
    paths = GridPaths(recorded.scene.clearance)
    drawn = draw_reachability_pairs(recorded, paths, 40, np.random.default_rng(1))
    some = np.concatenate(
        [np.flatnonzero(drawn.far_and_occluded)[:8], np.flatnonzero(~drawn.far_and_occluded)[:8]]
    )
    return drawn.subset(np.random.default_rng(0).permutation(some))


def same(one, two):
    columns = [(one.pairs, two.pairs, name) for name in COLUMNS]
    columns += [(one, two, name) for name in ENDS]
    for mine, theirs, name in columns:
        mine, theirs = getattr(mine, name), getattr(theirs, name)
        assert mine.dtype == theirs.dtype, name
        assert np.array_equal(mine, theirs), name


# How rollouts end.


@pytest.mark.full
def test_each_rollout_ends_as_if_its_robot_were_alone(world, pairs, outcomes):
    ends = np.array([outcomes.reached, outcomes.collided]).T
    assert len(np.unique(ends, axis=0)) == 3  # reached, touched, and neither
    goals = world.poses[pairs.targets, :2]
    for number in range(len(pairs)):
        simulation = Simulation(world.scene, pairs.starts[[number]])
        policy = Homing(simulation, world, pairs.targets[[number]])
        limit = pairs.geodesic[number] / 0.3 + 5.0
        alone = rollout(simulation, policy, ReachGoals(goals[[number]], limit, settle=True))
        assert outcomes.reached[number] == alone.reached[0]
        assert outcomes.collided[number] == alone.collided[0]
        assert outcomes.seconds[number] == alone.seconds[0]
    assert outcomes.driven.all()
    assert outcomes.pairs is pairs


@pytest.mark.parametrize("fleet", [1, 7, 60])
@pytest.mark.full
def test_the_size_of_the_fleet_changes_nothing(world, pairs, outcomes, monkeypatch, fleet):
    sent = []

    def make_policy(simulation, recorded, frames):
        sent.append(len(frames))
        return Homing(simulation, recorded, frames)

    monkeypatch.setattr(module, "FLEET", fleet)
    same(roll_out_pairs(world, pairs, make_policy), outcomes)
    assert max(sent) <= fleet
    assert sum(sent) == len(pairs)


def test_far_occluded_pairs_are_driven_on_request_only(recorded, hidden):
    sent = []

    def make_policy(simulation, recorded, frames):
        sent.extend(frames.tolist())
        return Asleep(simulation, recorded, frames)

    some = roll_out_pairs(recorded, hidden, make_policy)
    assert 0 < hidden.far_and_occluded.sum() < len(hidden)
    assert sorted(sent) == sorted(hidden.targets[~hidden.far_and_occluded].tolist())
    assert (some.driven == ~hidden.far_and_occluded).all()
    for name in ("reached", "collided", "seconds"):
        assert not getattr(some, name)[~some.driven].any()
    assert (some.seconds[some.driven] > 0).all()
    sent.clear()
    every = roll_out_pairs(recorded, hidden, make_policy, all_of_them=True)
    assert sorted(sent) == sorted(hidden.targets.tolist())
    assert every.driven.all()
    for name in ("reached", "collided", "seconds"):
        assert (getattr(every, name)[some.driven] == getattr(some, name)[some.driven]).all()


def test_a_robot_at_rest_is_soon_given_up_and_has_reached_only_where_it_is(recorded, hidden):
    found = roll_out_pairs(recorded, hidden, Asleep, all_of_them=True)
    gap = np.hypot(*(hidden.starts - recorded.poses[hidden.targets])[:, :2].T)
    assert (found.reached == (gap < 0.3)).all()
    assert found.seconds.max() <= SETTLED + 0.15
    assert not found.collided.any()


def test_an_oracle_arrives(recorded, hidden):
    def make_policy(simulation, recorded, frames):
        paths = GridPaths(recorded.scene.clearance)
        return OraclePolicy(simulation, paths, recorded.poses[frames, :2])

    found = roll_out_pairs(recorded, hidden, make_policy, all_of_them=True)
    assert found.reached.mean() >= 0.85
    assert (found.seconds <= hidden.limit + 0.1).all()


def test_robots_carry_the_camera_that_they_are_given(world, pairs):
    seen = []

    class Looking(Asleep):
        def act(self, observations, robots):
            seen.append(observations.image.shape[1:])
            return super().act(observations, robots)

    two = pairs.subset(np.array([0, 1]))
    roll_out_pairs(world, two, Looking)
    usual = set(seen)
    seen.clear()
    roll_out_pairs(world, two, Looking, Camera(rows=64))
    assert usual == {(Sensors().camera.rows, 64, 3)} != set(seen) == {(64, 64, 3)}


def test_no_pairs_have_no_outcomes(world, pairs):
    none = pairs.subset(np.array([], dtype=int))
    found = roll_out_pairs(world, none, Asleep)
    assert len(found) == 0
    assert found.seconds.shape == (0,)


@pytest.mark.parametrize("numbers", [np.array([5, 2, 2]), np.arange(60) % 7 == 0])
def test_a_subset_of_outcomes_keeps_its_pairs(outcomes, numbers):
    numbers = numbers[: len(outcomes)]
    some = outcomes.subset(numbers)
    for name in COLUMNS:
        wanted = getattr(outcomes.pairs, name)[numbers]
        assert np.array_equal(getattr(some.pairs, name), wanted)
    for name in ENDS:
        assert np.array_equal(getattr(some, name), getattr(outcomes, name)[numbers])


# On disk.


def made_up(count, seed=0):
    """Outcomes that anything may have led to."""
    rng = np.random.default_rng(seed)
    pairs = ReachabilityPairs(
        rng.normal(size=(count, 3)),
        np.sort(rng.integers(9, size=count)),
        rng.random((count, 2)),
        rng.uniform(0.0, 40.0, count),
    )
    reached = rng.random(count) < 0.5
    collided = ~reached & (rng.random(count) < 0.3)
    return RolloutOutcomes(
        pairs, rng.random(count) < 0.6, reached, collided, rng.uniform(0, 9, count)
    )


@given(st.integers(0, 30), st.integers(0, 100), st.text(max_size=20))
def test_what_is_saved_is_loaded(tmp_path_factory, count, seed, recipe):
    recipe = recipe.replace("\0", "")  # numpy strips it from the end of a string
    path = tmp_path_factory.mktemp("saved") / "some.npz"
    some = made_up(count, seed)
    save_outcomes(path, some, recipe)
    same(load_outcomes(path, recipe), some)


def test_saving_twice_gives_the_same_bytes(tmp_path):
    for name in ("one.npz", "two.npz"):
        save_outcomes(tmp_path / name, made_up(20), "recipe")
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "two.npz").read_bytes()
    assert len(list(tmp_path.iterdir())) == 2


@pytest.fixture
def saved(tmp_path):
    path = tmp_path / "some.npz"
    save_outcomes(path, made_up(20), "recipe")
    return path


@pytest.mark.parametrize("recipe", ["", "recipes", "Recipe", "recipe 2"])
def test_outcomes_of_another_recipe_are_refused(saved, recipe):
    with pytest.raises(InputError, match=r"some\.npz: outcomes of another recipe; delete the file"):
        load_outcomes(saved, recipe)


def test_a_file_cut_off_anywhere_is_refused(saved):
    whole = saved.read_bytes()
    for size in [*range(0, len(whole), 11), len(whole) - 1]:
        saved.write_bytes(whole[:size])
        with pytest.raises(InputError, match=r"some\.npz: damaged, or not .*; record it again"):
            load_outcomes(saved, "recipe")


def test_a_flipped_byte_is_reported_or_harmless(saved):
    whole, refused = saved.read_bytes(), 0
    places = range(0, len(whole), 9)
    for place in places:
        saved.write_bytes(whole[:place] + bytes([whole[place] ^ 0x55]) + whole[place + 1 :])
        try:
            same(load_outcomes(saved, "recipe"), made_up(20))
        except InputError:
            refused += 1
    assert refused > len(places) / 2


# None means that the column is missing.
MISSING = [({name: None}, rf"damaged \('{name}.*record") for name in (*COLUMNS, *ENDS)]
LENGTHS = [
    ({name: np.zeros((21, *shape))}, "columns differ in length")
    for name, shape in (("starts", (3,)), ("targets", ()), ("reached", ()), ("seconds", ()))
]
RANGES = [
    ({"starts": np.full((20, 3), np.nan)}, "starts: holds a number that is not within"),
    ({"starts": np.full((20, 3), 1e300)}, "starts: holds"),
    ({"targets": np.full(20, -1)}, "targets: holds a number that is not within 0 to 1e"),
    ({"targets": np.zeros(20)}, r"damaged \(targets: float64 of shape \(20,\)\)"),
    ({"overlap": np.full((20, 2), 1.5)}, "overlap: holds"),
    ({"overlap": np.zeros((20, 3))}, "damaged .overlap"),
    ({"geodesic": np.full(20, np.nan)}, "geodesic: holds"),
    ({"reached": np.zeros(20, int)}, "damaged .reached: int64"),
    ({"collided": np.full(20, "no")}, "damaged .collided: <U2"),
    ({"driven": np.zeros((20, 1), bool)}, "damaged .driven"),
    ({"seconds": np.full(20, -0.1)}, "seconds: holds"),
    ({"seconds": np.zeros(20, complex)}, "damaged .seconds: complex128"),
]
NO_COLUMN = ({"seconds": np.array(0.0)}, "damaged .*record it again")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        *MISSING,
        *LENGTHS,
        *RANGES,
        NO_COLUMN,
        ({"version": np.array(2)}, "of version 2; this program reads version 1; record it"),
        ({"version": None}, "damaged"),
        ({"recipe": None}, "damaged"),
        ({"version": np.array([1, 1])}, "damaged"),
        ({"version": np.array("one")}, "damaged"),
    ],
)
def test_a_file_with_a_fault_is_refused(saved, change, words):
    with np.load(saved) as file:
        arrays = {**file, **change}
    np.savez(saved, **{name: array for name, array in arrays.items() if array is not None})
    with pytest.raises(InputError, match=words) as caught:
        load_outcomes(saved, "recipe")
    assert "some.npz" in str(caught.value)


@pytest.mark.parametrize("content", [b"", b"hello", b"PK\x03\x04", b"\x93NUMPY"])
def test_what_is_no_file_of_ours_is_refused(saved, content):
    saved.write_bytes(content)
    with pytest.raises(InputError, match=r"some\.npz: damaged"):
        load_outcomes(saved, "recipe")


def test_a_missing_file_and_one_of_objects_are_refused(tmp_path):
    with pytest.raises(InputError, match="no such file; record it"):
        load_outcomes(tmp_path / "none.npz", "recipe")
    with pytest.raises(InputError, match=r"it is a folder.*; record it"):
        load_outcomes(tmp_path, "recipe")
    np.savez(tmp_path / "bad.npz", version=np.array({"a": 1}, dtype=object))
    with pytest.raises(InputError, match="damaged"):
        load_outcomes(tmp_path / "bad.npz", "recipe")


def test_a_save_that_fails_leaves_the_old_file_and_nothing_else(saved, monkeypatch):
    before = saved.read_bytes()

    def full(file, **arrays):
        file.write(b"half a file")
        raise OSError("no space left")

    monkeypatch.setattr(np, "savez", full)
    with pytest.raises(OSError, match="no space"):
        save_outcomes(saved, made_up(50), "recipe")
    assert saved.read_bytes() == before
    assert list(saved.parent.iterdir()) == [saved]


def test_a_whole_world_is_kept_and_found_again(tmp_path, world, outcomes):
    save_outcomes(tmp_path / "world.npz", outcomes, "k2 and so on")
    kept = load_outcomes(tmp_path / "world.npz", "k2 and so on")
    same(kept, outcomes)
    pairs = reachability_pairs(
        world, GridPaths(world.scene.clearance), kept.pairs.starts, kept.pairs.targets
    )
    assert pairs.overlap == pytest.approx(kept.pairs.overlap)
    assert pairs.geodesic == pytest.approx(kept.pairs.geodesic)
