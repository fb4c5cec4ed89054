"""Where the data of reachability comes from, is kept, and ends: in weights with a calibration."""

from dataclasses import replace
from functools import partial

import joblib
import numpy as np
import pytest
import torch

from tests.learning.test_reach_batches import made_up
from tutorial_lib import cli
from tutorial_lib.commands import train as train_command
from tutorial_lib.driving.data.demonstrations import record_demonstrations
from tutorial_lib.driving.data.rollout_outcomes import load_outcomes, save_outcomes
from tutorial_lib.driving.data.trajectories import load_trajectories
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.meng2020 import calibration_audit
from tutorial_lib.experiments.protocols import geometry_bound
from tutorial_lib.learning import mining, outcome_data, reach_recipes, recipes
from tutorial_lib.learning.calibration import Calibration, auc, reliability, sigmoid
from tutorial_lib.learning.estimators import ReachabilityNetwork
from tutorial_lib.learning.mining import HardNegativeMining, mined_outcomes
from tutorial_lib.learning.networks import Architecture, LocalNetwork
from tutorial_lib.learning.outcome_data import kept_outcomes, recipe_of, record_outcomes
from tutorial_lib.learning.reach_batches import LabelledWorld, OutcomeSource, ProximitySource
from tutorial_lib.learning.reach_recipes import REACHABILITY, SPTM
from tutorial_lib.learning.training import Settings
from tutorial_lib.learning.weights import load_card, load_network, save_network
from tutorial_lib.world.worlds import training_world

torch.set_num_threads(1)  # so small are they here that two threads are slower
WORLD, CONTROLLER = "office/1/standard", "waypoint_k0"


@pytest.fixture(scope="module")
def outcomes(recorded):
    return made_up(recorded, 10, 0)


class Recorder:
    """Finds the same outcomes each time, and counts."""

    def __init__(self, outcomes):
        self.outcomes, self.times = outcomes, 0

    def __call__(self):
        self.times += 1
        return self.outcomes


# Files that are there are kept.


def test_outcomes_that_are_there_are_kept(tmp_path, outcomes):
    path, record = tmp_path / "some.npz", Recorder(outcomes)
    first = kept_outcomes(path, "recipe", record)
    assert record.times == 1
    assert first is outcomes
    before = path.stat()
    again = kept_outcomes(path, "recipe", record)
    assert record.times == 1
    assert (path.stat().st_mtime_ns, path.stat().st_ino) == (before.st_mtime_ns, before.st_ino)
    assert np.array_equal(again.reached, outcomes.reached)
    assert np.array_equal(again.pairs.starts, outcomes.pairs.starts)


@pytest.mark.parametrize("size", [0, 40, 3000])
def test_a_damaged_file_is_recorded_again(tmp_path, outcomes, size):
    path, record = tmp_path / "some.npz", Recorder(outcomes)
    save_outcomes(path, outcomes, "recipe")
    whole = path.read_bytes()
    assert size < len(whole)
    path.write_bytes(whole[:size])
    kept_outcomes(path, "recipe", record)
    assert record.times == 1
    assert path.read_bytes() == whole


def test_outcomes_of_another_recipe_are_recorded_again(tmp_path, outcomes):
    path, record = tmp_path / "some.npz", Recorder(outcomes)
    save_outcomes(path, outcomes.subset(np.array([0])), "another recipe")
    assert kept_outcomes(path, "recipe", record) is outcomes
    assert len(load_outcomes(path, "recipe")) == len(outcomes)
    with pytest.raises(InputError, match="another recipe"):
        load_outcomes(path, "another recipe")


def test_a_recording_that_fails_leaves_the_file_as_it_was(tmp_path, outcomes):
    path = tmp_path / "some.npz"
    save_outcomes(path, outcomes, "another recipe")
    before = path.read_bytes()

    def stopped():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        kept_outcomes(path, "recipe", stopped)
    assert path.read_bytes() == before


def test_a_recipe_names_controller_weights_and_sizes():
    base = ("waypoint_k0", 3, 2)
    others = [("laser_k2", 3, 2), ("waypoint_k0", 4, 2), ("waypoint_k0", 3, 4)]
    assert len({recipe_of(*which) for which in (base, *others)}) == 4
    assert load_card("waypoint_k0").sha256[:16] in recipe_of("waypoint_k0", 3, 2)


@pytest.fixture
def driven(monkeypatch):
    """Records in which worlds a controller drives pairs."""
    noted, outcomes_in = [], outcome_data.outcomes_in

    def noting(recorded, world, controller, targets):
        noted.append(world)
        return outcomes_in(recorded, world, controller, targets)

    monkeypatch.setattr(outcome_data, "outcomes_in", noting)
    return noted


@pytest.mark.full
def test_a_world_is_recorded_once_and_again_where_something_changed(tmp_path, driven):
    def record(targets=1):
        (path,) = record_outcomes([WORLD], CONTROLLER, targets, 1, tmp_path, jobs=1)
        return path

    path = record()
    whole = path.read_bytes()
    outcomes = load_outcomes(path, recipe_of(CONTROLLER, 1, 1))
    (path_of_trajectories,) = record_demonstrations([WORLD], 1, 0, tmp_path / "demonstrations", 1)
    frames = sum(len(trajectory) for trajectory in load_trajectories(path_of_trajectories))
    assert 0 < len(outcomes) <= 5
    assert outcomes.pairs.targets.max() < frames
    assert not (outcomes.reached & outcomes.collided).any()
    assert record().read_bytes() == whole
    assert driven == [WORLD]
    path.write_bytes(whole[:999])
    assert record().read_bytes() == whole  # what was damaged is the same again
    assert driven == [WORLD] * 2
    record(targets=2)
    assert len(load_outcomes(path, recipe_of(CONTROLLER, 2, 1))) > len(outcomes)
    assert driven == [WORLD] * 3


@pytest.mark.full
def test_outcomes_belong_to_their_demonstrations(tmp_path, driven):
    for cars in (1, 2):
        record_outcomes([WORLD], CONTROLLER, 1, cars, tmp_path, jobs=1)
    assert driven == [WORLD] * 2


# Mined pairs.


@pytest.fixture
def network():
    torch.manual_seed(0)
    return LocalNetwork(Architecture(0, "pair", outputs="reachability")).eval()


@pytest.mark.full
def test_a_search_s_outcomes_are_kept_for_these_weights(tmp_path, recorded, network, monkeypatch):
    searched = []

    def find(self, reachability, world, paths, rng):
        searched.append(reachability)
        return made_up(world, 1, 3).pairs, 99

    monkeypatch.setattr(HardNegativeMining, "find", find)
    once = partial(mined_outcomes, ReachabilityNetwork(network), CONTROLLER, [recorded], tmp_path)
    (first,) = once(jobs=1)
    (again,) = once(jobs=1)
    assert len(searched) == 1
    assert np.array_equal(first.reached, again.reached)
    (path,) = (tmp_path / "mined" / CONTROLLER).iterdir()
    assert path.name == "office-1-standard.npz"
    once(mining=HardNegativeMining(pairs=7), jobs=1)
    assert len(searched) == 2
    with torch.no_grad():
        network.heads.bias += 0.5
    once(mining=HardNegativeMining(pairs=7), jobs=1)
    assert len(searched) == 3


def test_every_world_is_searched_and_none_is_lost(recorded, network, monkeypatch, tmp_path):
    labelled = [LabelledWorld(recorded, made_up(recorded, 1, seed)) for seed in range(5)]
    mined = [made_up(recorded, 1, 10 + seed) for seed in range(5)]

    def search(reachability, controller, trajectories, work, jobs):
        assert len(trajectories) == 5
        assert controller == "waypoint_k2"
        return mined

    monkeypatch.setattr(reach_recipes, "mined_outcomes", search)
    recipe = REACHABILITY["2"]
    taught = reach_recipes.with_mined(labelled, network, recipe, tmp_path, 1)
    assert [entry.outcomes for entry in taught] == [entry.outcomes for entry in labelled]
    assert [entry.mined for entry in taught] == mined


# Calibration.


@pytest.mark.full
def test_a_calibration_is_fitted_and_measured_on_what_can_be_seen(recorded, network, monkeypatch):
    labelled = [LabelledWorld(recorded, made_up(recorded, 250, seed)) for seed in range(2)]
    predicted, label = [], []

    def logits(reachability, world, starts, targets):
        # Knows how it ends, but is not sure enough; of what is not seen it knows nothing.
        outcomes = labelled[len(predicted)].outcomes
        seen = outcomes.pairs.seen
        assert np.array_equal(starts, outcomes.pairs.starts[seen])
        assert np.array_equal(targets, outcomes.pairs.targets[seen])
        label.append(outcomes.reached[seen])
        rng = np.random.default_rng(len(predicted))
        predicted.append(1.5 * (label[-1] - 0.5) + rng.normal(0.0, 1.0, len(starts)))
        return predicted[-1]

    monkeypatch.setattr(reach_recipes, "all_logits", logits)
    mend, measured = reach_recipes.calibrate(ReachabilityNetwork(network), labelled)
    every, came_true = np.concatenate(predicted), np.concatenate(label)
    assert len(every) > 500
    for method, probability in (("raw", sigmoid(every)), ("isotonic", mend(every))):
        wanted = reliability(probability, came_true).ece
        assert measured[f"ece_{method}"] == pytest.approx(wanted, abs=1e-3)
    assert measured["ece_isotonic"] < 0.05
    assert measured["auc"] == pytest.approx(auc(every, came_true), abs=1e-3)
    # Two normal distributions 1.5 apart: the right logit is 1.5 times what is predicted.
    assert measured["temperature"] == pytest.approx(2 / 3, rel=0.2)
    assert set(measured) >= {"offset", "ece_temperature"}


# Recipes.


def test_each_network_learns_from_the_pairs_of_its_own_controller():
    for k, recipe in REACHABILITY.items():
        assert recipe.command == f"train reachability --k {k}"
        assert recipe.name == ("reach_laser" if k == "laser" else f"reach_k{k}")
        theirs = load_card(recipe.controller).architecture
        assert recipe.architecture == replace(theirs, outputs="reachability")
    assert (SPTM.name, SPTM.architecture.k) == ("sptm", 0)
    assert SPTM.command == "train reachability --k sptm"
    names = [recipe.name for recipe in (*REACHABILITY.values(), SPTM)]
    paths = [path for r in (*REACHABILITY.values(), SPTM) for path in r.checkpoints(recipes.WORK)]
    assert len(set(names)) == 5
    assert len(set(paths)) == 9


def test_worlds_are_used_for_one_thing_only():
    taught = range(reach_recipes.FIRST_WORLD, reach_recipes.FIRST_WORLD + reach_recipes.WORLDS)
    control = range(max(recipe.worlds for recipe in recipes.WAYPOINT.values()))
    parts = [control, taught, geometry_bound.FITTED, calibration_audit.WORLDS]
    unseen = [reach_recipes.STOPPING, reach_recipes.CALIBRATING]
    every = [seed for part in (*parts, *unseen) for seed in part]
    assert len(set(every)) == len(every)
    for seed in (seed for part in parts for seed in part):
        training_world(seed)  # or it is refused
    assert all(10_000 <= seed < 20_000 for part in unseen for seed in part)


@pytest.fixture
def tiny(tmp_path, monkeypatch, recorded):
    """The command trains a tiny network on made-up outcomes, in a folder of the test's."""
    entry = LabelledWorld(recorded, made_up(recorded, 12, 0))
    mined = made_up(recorded, 3, 1)
    short = Settings(max_steps=4, targets=2, eval_interval=2)
    architecture = Architecture(0, outputs="reachability")
    recipe = replace(
        REACHABILITY["0"], architecture=architecture, first=short, second=replace(short, seed=1)
    )
    monkeypatch.setitem(REACHABILITY, "0", recipe)
    monkeypatch.setitem(train_command.NETWORKS["reachability"], "0", recipe)
    sptm = replace(SPTM, settings=short)
    monkeypatch.setitem(train_command.NETWORKS["reachability"], "sptm", sptm)
    requested = []

    def labelled_worlds(recipe, worlds, work, jobs):
        requested.append(worlds)
        return [entry, entry]

    monkeypatch.setattr(reach_recipes, "labelled_worlds", labelled_worlds)
    monkeypatch.setattr(reach_recipes, "recorded_worlds_of", lambda *arguments: [recorded])
    monkeypatch.setattr(reach_recipes, "mined_outcomes", lambda *a, **k: [mined, mined])
    monkeypatch.setattr(
        reach_recipes, "OutcomeSource", partial(OutcomeSource, worlds=2, targets=16)
    )
    monkeypatch.setattr(
        reach_recipes, "ProximitySource", partial(ProximitySource, worlds=2, targets=4)
    )
    monkeypatch.setattr(recipes, "WORK", tmp_path / "work")
    monkeypatch.setattr(train_command, "PROJECT", tmp_path)
    monkeypatch.setattr(
        train_command, "save_network", lambda *both: save_network(*both, tmp_path / "weights")
    )
    (tmp_path / "work").mkdir()
    return requested


def test_the_command_trains_in_two_stages_calibrates_and_saves(tiny, tmp_path, capsys):
    with joblib.parallel_config(backend="threading"):
        assert cli.main(["train", "reachability", "--k", "0"]) == 0
    assert "reach_k0.safetensors" in capsys.readouterr().out
    folder = tmp_path / "weights"
    card, network = load_card("reach_k0", folder), load_network("reach_k0", folder)
    assert network.architecture == Architecture(0, outputs="reachability")
    assert card.command == "train reachability --k 0"
    assert card.recipe["controller"] == load_card("waypoint_k0").sha256
    assert card.recipe["mined"][0] > 0  # the second stage had them
    assert (card.recipe["first"]["seed"], card.recipe["second"]["seed"]) == (0, 1)
    assert {"validation", "auc", "ece_raw", "ece_isotonic"} <= set(card.validation)
    mend = Calibration(**card.calibration)
    assert len(mend.raw) > 2
    assert list((tmp_path / "work").iterdir()) == []  # what is finished would be found again
    assert [len(worlds) for worlds in tiny] == [80, 12, 24]
    before = (folder / "reach_k0.safetensors").read_bytes()
    assert cli.main(["train", "reachability", "--k", "0"]) == 0
    assert (folder / "reach_k0.safetensors").read_bytes() == before


def test_sptm_s_network_is_trained_by_the_same_command(tiny, tmp_path):
    assert cli.main(["train", "reachability", "--k", "sptm"]) == 0
    card = load_card("sptm", tmp_path / "weights")
    assert card.recipe["apart"] == [20, 100]
    assert Calibration(**card.calibration)(np.array([0.3])) == pytest.approx(sigmoid([0.3]))


def test_a_search_is_made_side_by_side_with_the_weights_it_was_given(recorded, network, tmp_path):
    search = HardNegativeMining(frames=6, pairs=2, far_occluded=0, threshold=0.0)
    with joblib.parallel_config(backend="threading"):
        (found,) = mined_outcomes(
            ReachabilityNetwork(network), CONTROLLER, [recorded], tmp_path, search, jobs=1
        )
    assert len(found) <= 2
    logits = mining.all_logits(
        ReachabilityNetwork(network), recorded, found.pairs.starts, found.pairs.targets
    )
    assert (sigmoid(logits) > 0.0).all()


def test_of_far_occluded_pairs_the_surest_are_kept_and_none_is_driven(recorded, network):
    reachability = ReachabilityNetwork(network)
    paths, rng = GridPaths(recorded.scene.clearance), np.random.default_rng
    every, _ = HardNegativeMining(frames=40, pairs=0, far_occluded=9_999, threshold=0.0).find(
        reachability, recorded, paths, rng(3)
    )
    some, queries = HardNegativeMining(frames=40, pairs=3, far_occluded=5, threshold=0.0).find(
        reachability, recorded, paths, rng(3)
    )
    assert 5 < len(every) < queries
    assert every.far_and_occluded.all()
    assert some.far_and_occluded.sum() == 5
    assert (~some.far_and_occluded).sum() == 3
    assert (np.diff(some.targets) >= 0).all()

    def logits(pairs):
        return mining.all_logits(reachability, recorded, pairs.starts, pairs.targets)

    surest = np.sort(logits(every))[-5:]
    kept = some.subset(some.far_and_occluded)
    assert np.sort(logits(kept)) == pytest.approx(surest, abs=1e-4)
