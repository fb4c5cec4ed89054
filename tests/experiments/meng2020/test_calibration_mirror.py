"""Calibration with and without a mirror: the same weights, each look calibrated for itself."""

import json

import joblib
import numpy as np
import pytest

from tests.conftest import needs
from tests.learning.test_reach_batches import made_up
from tutorial_lib.experiments.common.report import Options
from tutorial_lib.experiments.meng2020 import calibration, calibration_mirror
from tutorial_lib.learning.reach_batches import LabelledWorld
from tutorial_lib.learning.weights import digest_of, load_network

NAMES = tuple(calibration.Settings().estimators[:4])


@pytest.fixture
def worlds(recorded, monkeypatch):
    """One office in place of all validation worlds."""
    asked = []

    def labelled_worlds(recipe, names, work, jobs):
        asked.append((recipe.name, names))
        return [LabelledWorld(recorded, made_up(recorded, 15, 0))]

    monkeypatch.setattr(calibration_mirror, "labelled_worlds", labelled_worlds)
    return asked


@needs("reach_k0", "reach_k2", "reach_k5", "reach_laser")
def test_one_look_and_two_are_of_the_same_weights(worlds, recorded):
    frames = np.arange(0, 200, 5)
    for name in NAMES:
        found = calibration_mirror.with_looks(name, calibration_mirror.Settings())
        assert list(found) == [1, 2]
        one, two = (estimator.reachability for estimator in found.values())
        assert (one.architecture.mirror, two.architecture.mirror) == (False, True)
        shipped = digest_of(load_network(f"reach_{name}"))
        assert digest_of(one.network) == digest_of(two.network) == shipped
        seen = recorded.observe(frames)
        logits = [e.reachability.logits(seen, e.targets(recorded, frames)) for e in found.values()]
        assert np.abs(np.subtract(*logits)).max() > 0.01
        assert one.calibration != two.calibration
        assert {estimator.controller for estimator in found.values()} == {name}
    assert [name for name, _ in worlds] == [f"reach_{name}" for name in NAMES]


@needs("reach_k2")
def test_a_row_for_each_number_of_looks(worlds, monkeypatch):
    def examine(world, every, bounds, sizes, seed, family):
        assert bounds == {"k2": "the bound of k2"}
        found = {}
        for (name, looks), estimator in every.items():
            assert estimator.reachability.architecture.mirror == (looks == 2)
            rng = np.random.default_rng(world)
            likely = rng.random(50) < 0.2 / looks
            found[name, looks] = {
                "predicted": rng.random(40),
                "reached": (rng.random(40) < 0.5).astype(float),
                "bound": rng.random(40),
                "seen": np.arange(40) % 4 > 0,
                "far": np.where(likely, 0.95, 0.1),
                "consecutive": np.ones(3),
                "edges": np.ones(2),
            }
        return found

    monkeypatch.setattr(calibration_mirror, "examine_these", examine)
    monkeypatch.setattr(calibration_mirror, "fitted", lambda name: f"the bound of {name}")
    with joblib.parallel_config(backend="sequential"):
        options = Options(ablation="mirror", worlds=(20_000, 20_001), quick=True)
        report = calibration.EXPERIMENT.report(options)
    assert [(row["estimator"], row["looks"]) for row in report.rows] == [("k2", 1), ("k2", 2)]
    parts = [np.random.default_rng(world).random(50) for world in (20_000, 20_001)]
    for row in report.rows:
        share = (np.concatenate(parts) < 0.2 / row["looks"]).mean()
        assert (row["far_above_09"], row["far"]) == (pytest.approx(share), 100)
        assert row["pairs"] == 60
    assert report.notes == ("each calibrated anew, in 24 validation worlds",)
    json.dumps(report.as_dict(), allow_nan=False)
