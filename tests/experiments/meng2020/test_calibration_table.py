"""The calibration experiment: which estimators predict what, and how the table comes about."""

import json
import sys
from dataclasses import replace
from types import SimpleNamespace

import joblib
import numpy as np
import pytest

from tests.conftest import needs
from tests.learning.test_reach_batches import made_up
from tests.learning.test_training import PoseView
from tutorial_lib.driving.data.rollout_outcomes import RolloutOutcomes
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.report import Options, Report
from tutorial_lib.experiments.meng2020 import calibration
from tutorial_lib.experiments.protocols import (
    estimators,
    geometry_bound,
    reachability,
)
from tutorial_lib.experiments.protocols.estimators import Estimator
from tutorial_lib.experiments.protocols.reachability import Queries, Sizes, examine, far_pairs
from tutorial_lib.geometry import to_local, wrap
from tutorial_lib.learning.calibration import auc, brier, reliability
from tutorial_lib.learning.networks import Architecture
from tutorial_lib.topology.similarity import ImageSimilarity
from tutorial_lib.world.visibility import mutual_overlap

IMAGE = Estimator(ImageSimilarity(), "k0", 0)
WEIGHTS = ("reach_k0", "reach_k2", "reach_k5", "reach_laser", "sptm")


@pytest.fixture(scope="module")
def paths(recorded):
    return GridPaths(recorded.scene.clearance)


# Estimators.


def test_each_estimator_has_its_weights_its_controller_and_its_context(monkeypatch):
    def named(name):
        k = {"reach_k0": 0, "reach_k5": 5, "sptm": 0}.get(name, 2)
        return SimpleNamespace(name=name, architecture=Architecture(k, outputs="reachability"))

    monkeypatch.setattr(estimators, "ReachabilityNetwork", named)
    found = estimators.estimators(calibration.Settings().estimators)
    assert isinstance(found.pop("image").reachability, ImageSimilarity)
    assert {name: (j.reachability.name, j.controller, j.k) for name, j in found.items()} == {
        "k0": ("reach_k0", "k0", 0),
        "k2": ("reach_k2", "k2", 2),
        "k5": ("reach_k5", "k5", 5),
        "laser": ("reach_laser", "laser", 2),
        "sptm": ("sptm", "k2", 0),
    }
    assert list(estimators.estimators(("sptm", "image"))) == ["sptm", "image"]


@needs(*WEIGHTS)
@pytest.mark.full
def test_each_estimator_s_network_has_the_context_that_it_is_given(recorded):
    frames = np.array([40, 90])
    for name, estimator in estimators.estimators(calibration.Settings().estimators[:5]).items():
        assert estimator.reachability.architecture.k == estimator.k, name
        probability = estimator.predict(recorded, recorded.observe(frames), frames + 5)
        assert ((probability > 0) & (probability < 1)).all()
        assert estimator.reachability.calibration.raw != (-1.0, 1.0) or name == "sptm"


@pytest.mark.parametrize("at_once", [1, 7, 1024])
def test_each_pair_is_predicted_by_itself(recorded, monkeypatch, at_once):
    monkeypatch.setattr(estimators, "_AT_ONCE", at_once)
    starts, targets = (
        np.random.default_rng(0).integers(len(recorded.poses), size=(2, 30)) // 40 * 40
    )
    seen = recorded.observe(starts)
    together = IMAGE.predict(recorded, seen, targets)
    there = recorded.observe(targets).image
    for pair in range(30):
        prepared = ImageSimilarity().prepare(there[[pair]][:, None])
        alone = ImageSimilarity().probability(seen[pair], prepared)
        assert together[pair] == pytest.approx(alone[0])
    rows, columns = np.array([3, 3, 9]), np.array([0, 5, 5])
    prepared = IMAGE.targets(recorded, targets)
    predicted = IMAGE.query_all(seen, prepared, rows, columns)
    wanted = ImageSimilarity().probability(seen[rows], prepared[columns])
    assert predicted == pytest.approx(wanted)


def test_targets_are_shown_in_their_context_as_the_network_views_them(recorded):
    fake = SimpleNamespace(view=PoseView(), prepare=lambda contexts: contexts)
    frames = np.array([100, 0, 700])
    shown = Estimator(fake, "k2", 2).targets(recorded, frames)
    assert (shown[:, :, 0, :, 0] == recorded.poses[recorded.context(frames, 2)]).all()


# Pairs.


def test_far_pairs_are_far_apart_and_see_nothing_of_each_other(recorded, paths):
    rng = np.random.default_rng(0)
    starts, targets = far_pairs(recorded, paths, 60, rng)
    assert 20 < len(starts) == len(targets) <= 60
    first, second = recorded.poses[starts], recorded.poses[targets]
    assert (mutual_overlap(recorded.scene.caster, first, second) < 0.1).all()
    for start, target in list(zip(first, second, strict=True))[::6]:
        field = paths.fields(target[:2], shortest=True)
        assert field.distance(start[None, :2])[0] > 5.0
    assert len(np.unique(starts)) > 0.8 * len(starts)
    again = far_pairs(recorded, paths, 60, np.random.default_rng(0))
    assert np.array_equal(again[0], starts)
    assert np.array_equal(again[1], targets)


def test_the_sizes_are_those_that_the_design_promises():
    assert calibration.QUICK.sizes.targets * 5 * 10 == 8_000
    assert calibration.QUICK.sizes.anchors * (calibration.QUICK.sizes.anchors - 1) <= 20_000
    assert calibration.Settings().sizes.far * len(calibration.WORLDS) >= 20_000
    assert set(calibration.QUICK.estimators) | {"geometry"} == {
        "k2",
        "k5",
        "sptm",
        "image",
        "geometry",
    }


def test_geometry_gets_where_the_target_is_what_is_seen_of_it_and_how_tight_it_is(recorded):
    rolled_out = made_up(recorded, 6, 0).pairs
    found = geometry_bound.features(recorded, rolled_out)
    assert found.shape == (len(rolled_out), 10)
    clearance = recorded.scene.clearance
    for row, start, target, overlap in zip(
        found, rolled_out.starts, rolled_out.targets, rolled_out.overlap, strict=True
    ):
        goal = recorded.poses[target]
        ahead, aside = to_local(start, goal[:2])
        assert row[:5] == pytest.approx(
            [
                np.hypot(*(goal - start)[:2]),
                abs(np.arctan2(aside, ahead)),
                abs(wrap(goal[2] - start[2])),
                ahead,
                aside,
            ]
        )
        assert row[5] == recorded.scene.caster.sees(start[None, :2], goal[None, :2])[0]
        assert row[6:8] == pytest.approx(clearance.at(np.array([start[:2], goal[:2]])))
        assert (row[8:] == overlap).all()


def test_geometry_foretells_what_depends_on_geometry(recorded, monkeypatch):
    learnt = [made_up(recorded, 60, seed) for seed in range(2)]
    learnt = [replace(o, reached=o.pairs.geodesic < 2.0) for o in learnt]
    monkeypatch.setattr(geometry_bound, "record_outcomes", lambda *arguments: [0, 1])
    monkeypatch.setattr(geometry_bound, "load_outcomes", lambda file, recipe: learnt[file])
    monkeypatch.setattr(geometry_bound, "recorded_worlds_of", lambda *arguments: [recorded] * 2)
    model = geometry_bound.fitted("k2", (200, 201))
    others = made_up(recorded, 40, 7).pairs
    others = others.subset(others.seen)
    predicted = model.predict_proba(geometry_bound.features(recorded, others))[:, 1]
    assert auc(predicted, others.geodesic < 2.0) > 0.95


def test_without_scikit_learn_there_is_no_bound_and_that_is_reported(monkeypatch):
    monkeypatch.setitem(sys.modules, "sklearn.ensemble", None)
    with pytest.raises(InputError, match=r"scikit-learn; pip install -e '\.\[test\]'"):
        geometry_bound.fitted("k2")


# One world.


class Knowing:
    """Recognizes recorded pictures: sure of frames up to so many ahead on the same trajectory."""

    def __init__(self, recorded, reach):
        self.recorded, self.reach = recorded, reach
        image = recorded.observe(np.arange(len(recorded.poses))).image
        self.frame = {}  # before it sets out, a car sees the same as at first
        for number, picture in enumerate(image):
            self.frame.setdefault(picture.tobytes(), number)

    def prepare(self, contexts):
        return np.array([self.frame[picture[0].tobytes()] for picture in contexts])

    def probability(self, observations, prepared):
        here = np.array([self.frame[picture.tobytes()] for picture in observations.image])
        own = self.recorded.first[here] == self.recorded.first[prepared]
        return np.where(own & (prepared >= here) & (prepared - here <= self.reach), 0.995, 0.5)


@pytest.fixture
def asker(recorded, paths, monkeypatch):
    """Queries an estimator that knows all frames up to 25 ahead; notes what is driven."""
    driven = []

    def roll_out(world, rolled_out, controller, all_of_them=False):
        assert world is recorded
        assert controller == "k0"
        assert all_of_them
        driven.append(rolled_out)
        ends = np.arange(len(rolled_out)) % 3 > 0
        return RolloutOutcomes(rolled_out, ends | True, ends, ~ends, np.zeros(len(rolled_out)))

    monkeypatch.setattr(reachability, "_driven", roll_out)

    def made(reach=25):
        estimator = Estimator(Knowing(recorded, reach), "k0", 0)
        return Queries(recorded, paths, estimator, np.random.default_rng(0)), driven

    return made


def pairs_of(recorded, rolled_out):
    """Frames of the starts and targets of pairs."""
    match = (recorded.poses[None] == rolled_out.starts[:, None]).all(axis=2)
    return match.argmax(axis=1), rolled_out.targets


def test_consecutive_anchors_are_driven_where_the_sparsifier_was_sure(recorded, asker):
    asking, driven = asker()
    found = asking.consecutive(12)
    (rolled_out,) = driven
    assert len(found) == len(rolled_out) == 12
    assert (found == (np.arange(12) % 3 > 0)).all()
    starts, targets = pairs_of(recorded, rolled_out)
    assert ((starts - recorded.first[starts]) % 25 == 0).all()
    last = targets == recorded.last[targets]
    assert (targets - starts)[~last].tolist() == [25] * (~last).sum()
    assert len({(s, t) for s, t in zip(starts, targets, strict=True)}) == 12


def test_some_of_all_pairs_that_would_be_edges_are_driven(recorded, asker):
    asking, driven = asker()
    frames = np.arange(7, len(recorded.poses), 20)
    once = np.unique(recorded.poses, axis=0, return_index=True)[1]
    frames = frames[np.isin(frames, once)]  # where a car stands still, one frame is like the next
    every = {
        (first, second)
        for first in frames.tolist()
        for second in frames.tolist()
        if recorded.first[first] == recorded.first[second] and 0 < second - first <= 25
    }
    asking.edges(frames, 10**6)
    asking.edges(frames, 8)
    found = [
        set(zip(*(part.tolist() for part in pairs_of(recorded, rolled_out)), strict=True))
        for rolled_out in driven
    ]
    assert found[0] == every
    assert len(found[1]) == 8
    assert found[1] < found[0]


def test_where_nothing_is_sure_nothing_is_driven(asker, recorded):
    asking, driven = asker(reach=-1)
    assert asking.edges(np.arange(0, 400, 40), 5).shape == (0,)
    assert asking.consecutive(5).shape == (0,)
    assert driven == []


@pytest.fixture(scope="module")
def world():
    """One small world, examined by two that are the same estimator."""
    patch = pytest.MonkeyPatch()
    patch.setattr(reachability, "estimators", lambda names: dict.fromkeys(names, IMAGE))
    patch.setattr(reachability, "_CARS", 4)
    model = SimpleNamespace(predict_proba=lambda x: np.column_stack([1 - x[:, 8], x[:, 8]]))
    sizes = Sizes(targets=4, far=30, anchors=8, edges=2, consecutive=2)
    found = examine(10_001, ("image", "twin"), {"k0": model}, sizes, 3)
    patch.undo()
    return found


@pytest.mark.full
def test_a_world_is_examined_from_every_side(world):
    one = world["image"]
    assert set(one) == {"predicted", "reached", "seen", "bound", "far", "consecutive", "edges"}
    count = len(one["predicted"])
    assert 10 < count <= 20
    for name in ("reached", "seen", "bound"):
        assert one[name].shape == (count,)
    for name in ("predicted", "far", "bound"):
        assert ((one[name] >= 0) & (one[name] <= 1)).all()
    assert set(one["reached"]) <= {0.0, 1.0}
    assert 0 < len(one["far"]) <= 30
    assert len(one["edges"]) <= 2
    assert len(one["consecutive"]) <= 2


@pytest.mark.full
def test_all_estimators_get_the_same_queries(world):
    for name, values in world["image"].items():
        assert np.array_equal(values, world["twin"][name]), name


# The table.


def part(seed, count=60):
    """What one world may give."""
    rng = np.random.default_rng(seed)
    predicted = rng.random(count) ** 0.3
    some = {"predicted": predicted, "reached": (rng.random(count) < predicted).astype(float)}
    some |= {"seen": rng.random(count) < 0.6, "bound": rng.random(count)}
    some["far"] = rng.random(30)
    return some | {
        k: rng.integers(2, size=5 + seed).astype(float) for k in ("consecutive", "edges")
    }


def test_a_row_tells_how_right_an_estimator_was():
    parts = [part(seed) for seed in range(4)]
    row = calibration.estimator_row("k2", parts)
    every = {key: np.concatenate([p[key] for p in parts]) for key in parts[0]}
    predicted, reached = every["predicted"][every["seen"]], every["reached"][every["seen"]]
    assert (row["estimator"], row["pairs"]) == ("k2", len(predicted))
    assert row["auc"] == auc(predicted, reached)
    assert row["brier"] == brier(predicted, reached)
    assert row["ece"] == reliability(predicted, reached).ece
    assert row["geometry_auc"] == auc(every["bound"][every["seen"]], reached)
    assert row["precision_mix"] == pytest.approx(reached[predicted > 0.99].mean())
    assert row["sure_mix"] == (predicted > 0.99).sum() > 3
    assert row["precision_map"] == pytest.approx(every["edges"].mean())
    assert row["precision_consecutive"] == pytest.approx(every["consecutive"].mean())
    assert (row["sure_map"], row["sure_consecutive"]) == (26, 26)
    assert row["far_above_09"] == pytest.approx((every["far"] > 0.9).mean())
    assert row["far"] == 120
    for key in ("auc", "ece", "precision_mix", "precision_map", "precision_consecutive"):
        assert row[f"{key}_low"] <= row[key] <= row[f"{key}_high"], key
    assert len(row["predicted"]) == len(row["measured"]) == 10
    assert np.diff(row["predicted"]).min() >= 0


def test_where_nobody_was_sure_there_is_no_precision():
    parts = [part(seed) for seed in range(2)]
    for p in parts:
        p["predicted"], p["edges"] = 0.9 * p["predicted"], np.empty(0)
    row = calibration.estimator_row("image", parts)
    assert row["precision_mix"] is row["precision_mix_low"] is row["precision_map"] is None
    assert row["sure_mix"] == row["sure_map"] == 0


def test_geometry_has_a_row_of_its_own_with_the_same_columns():
    parts = [part(seed) for seed in range(3)]
    like = calibration.estimator_row("k2", parts)
    row = calibration.geometry_row(parts, like)
    assert list(row) == list(like)
    assert row["estimator"] == "geometry"
    assert row["auc"] == row["geometry_auc"] == like["geometry_auc"]
    assert row["pairs"] == like["pairs"]
    assert row["far_above_09"] is None
    report = Report("calibration", 0, (1,), True, 1.0, [like, row])
    assert "geometry" in report.as_text()
    json.dumps(report.as_dict(), allow_nan=False)


@pytest.mark.parametrize("quick", [True, False])
@pytest.mark.few(1)
def test_the_experiment_has_a_row_for_every_estimator(monkeypatch, quick):
    fitted, examined = [], []

    def examine(world, names, bounds, sizes, seed, family):
        assert not family
        examined.append((world, sizes, seed))
        assert set(bounds) == set(fitted)
        return {name: part(world % 7) for name in names}

    monkeypatch.setattr(calibration, "fitted", lambda name, seeds: fitted.append(name))
    monkeypatch.setattr(calibration, "examine", examine)
    with joblib.parallel_config(backend="sequential"):
        report = calibration.EXPERIMENT.report(
            Options(worlds=(10_001, 10_003), seed=5, quick=quick)
        )
    settings = calibration.QUICK if quick else calibration.Settings()
    names, sizes = settings.estimators, settings.sizes
    assert [row["estimator"] for row in report.rows] == [*names, "geometry"]
    assert fitted == [name for name in names if name not in ("sptm", "image")]
    assert examined == [(10_001, sizes, 5), (10_003, sizes, 5)]
    assert (report.worlds, report.quick, report.seed) == ((10_001, 10_003), quick, 5)
    json.dumps(report.as_dict(), allow_nan=False)


@pytest.mark.full
@needs("reach_k2", "reach_k5", "sptm")
def test_the_experiment_runs_on_a_validation_world(monkeypatch):
    model = SimpleNamespace(predict_proba=lambda x: np.column_stack([1 - x[:, 8], x[:, 8]]))
    monkeypatch.setattr(calibration, "fitted", lambda controller, seeds: model)
    monkeypatch.setattr(reachability, "_CARS", 6)
    small = Sizes(targets=10, far=60, anchors=12, edges=2, consecutive=2)
    few = replace(calibration.QUICK, sizes=small)
    with joblib.parallel_config(backend="sequential"):
        report = replace(calibration.EXPERIMENT, quick_settings=few).report(
            Options(worlds=(10_001,), quick=True)
        )
    assert [row["estimator"] for row in report.rows] == ["k2", "k5", "sptm", "image", "geometry"]
    for row in report.rows[:4]:
        assert 10 <= row["pairs"] <= 50
        assert 0.0 <= row["ece"] <= 1.0
        assert row["far"] > 10
    assert "geometry" in report.as_text()
