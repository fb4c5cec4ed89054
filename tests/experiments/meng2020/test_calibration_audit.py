"""The audit of pairs that are labelled without a rollout, and the benchmark of reachability."""

import json
from itertools import pairwise

import joblib
import numpy as np
import pytest

from tests.conftest import needs
from tutorial_lib.driving.data.reachability_pairs import FAR, draw_reachability_pairs
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.experiments.benchmarks import reachability
from tutorial_lib.experiments.common.report import Options
from tutorial_lib.experiments.meng2020 import calibration, calibration_audit

BOUNDS = [5.0, 6.0, 7.0, 8.0, 10.0, 12.0, 15.0, 20.0, None]


def run_audit(monkeypatch, run_world, **options):
    monkeypatch.setattr(calibration_audit, "recorded_worlds_of", lambda *arguments: [])
    monkeypatch.setattr(calibration_audit, "run_world", run_world)
    with joblib.parallel_config(backend="sequential"):
        return calibration.EXPERIMENT.report(Options(ablation="audit", **options))


def by_lot(world, options, settings):
    """Metres and outcomes that differ from world to world."""
    rng, count = np.random.default_rng([options.seed, world]), settings.pairs
    metres = np.concatenate([rng.uniform(5.0, 30.0, count - 8), [5, 6.5, 7, 8.1, 11, 13, 15, 20]])
    return metres, (rng.random(count) < 0.2).astype(float)


def test_the_audit_counts_arrivals_by_distance(monkeypatch):
    report = run_audit(monkeypatch, by_lot, worlds=(216, 220, 230), seed=4)
    settings = calibration_audit.Settings()
    parts = [by_lot(world, Options(seed=4), settings) for world in (216, 220, 230)]
    metres, reached = (np.concatenate(column) for column in zip(*parts, strict=True))
    assert [(r["from_m"], r["to_m"]) for r in report.rows[:-1]] == list(pairwise(BOUNDS))
    for row in report.rows:
        most = np.inf if row["to_m"] is None else row["to_m"]
        inside = (metres >= row["from_m"]) & (metres < most)
        assert row["errands"] == inside.sum()
        assert row["reached"] == pytest.approx(reached[inside].mean())
        assert row["low"] <= row["reached"] <= row["high"]
    every = report.rows[-1]
    assert (every["from_m"], every["to_m"], every["errands"]) == (
        5.0,
        None,
        3 * settings.pairs,
    )
    assert sum(row["errands"] for row in report.rows[:-1]) == every["errands"]
    assert (report.name, report.worlds) == ("audit", (216, 220, 230))
    json.dumps(report.as_dict(), allow_nan=False)


def test_the_audit_is_smaller_where_it_must_be_quick(monkeypatch):
    calls = []

    def run_world(world, options, settings):
        calls.append((world, settings.pairs))
        return by_lot(world, options, settings)

    run_audit(monkeypatch, run_world, quick=True)
    assert [world for world, _ in calls] == list(calibration_audit.WORLDS)
    assert {count for _, count in calls} == {21}
    assert calibration_audit.Settings().pairs * len(calibration_audit.WORLDS) > 2_000


def test_where_no_pair_is_so_far_apart_the_audit_has_no_share(monkeypatch):
    report = run_audit(monkeypatch, lambda *arguments: (np.full(5, 6.5), np.ones(5)))
    json.dumps(report.as_dict(), allow_nan=False)
    assert report.rows[0]["reached"] is None
    assert report.rows[1]["reached"] == 1.0


@pytest.mark.full
def test_the_audit_rolls_out_far_occluded_pairs_and_no_others(recorded, monkeypatch):
    monkeypatch.setattr(calibration_audit, "recorded_worlds_of", lambda *arguments: [recorded])
    rolled_out, roll_out_pairs = [], calibration_audit.roll_out_pairs

    def run(world, pairs, policy, all_of_them=False):
        assert all_of_them
        rolled_out.append(pairs)
        return roll_out_pairs(world, pairs, policy, all_of_them=all_of_them)

    monkeypatch.setattr(calibration_audit, "roll_out_pairs", run)
    metres, reached = calibration_audit.run_world(
        216, Options(), calibration_audit.Settings(pairs=3)
    )
    (pairs,) = rolled_out
    assert pairs.far_and_occluded.all()
    assert metres.tolist() == pairs.geodesic.tolist()
    assert len(metres) == len(reached) == 3
    assert metres.min() > FAR
    assert set(reached) <= {0.0, 1.0}
    # They are among the usual pairs.
    paths, rng = GridPaths(recorded.scene.clearance), np.random.default_rng([0, 216])
    drawn = draw_reachability_pairs(recorded, paths, 6, rng)
    assert set(metres) <= set(drawn.geodesic)


# The benchmark.


def test_the_benchmark_adds_up_what_its_processes_do(monkeypatch):
    calls = []

    def measure(world, seed, settings):
        calls.append((world, seed, settings.targets, settings.anchors))
        cached = settings.anchors**2, 0.5
        return {"rollouts": (settings.targets, 2.0), "cached": cached, "plain": (100, 4.0)}

    monkeypatch.setattr(reachability, "measure", measure)
    with joblib.parallel_config(backend="sequential"):
        report = reachability.EXPERIMENT.report(Options(worlds=(20_007,), seed=3))
    rows = {row["what"]: row for row in report.rows}
    settings = reachability.Settings()
    targets, anchors = settings.targets, settings.anchors
    assert rows["rollouts"]["count"] == 2 * targets
    assert rows["rollouts"]["per_s"] == pytest.approx(2 * targets / 2.0)
    assert rows["cached"]["per_s"] == pytest.approx(2 * anchors**2 / 0.5)
    assert rows["plain"]["per_s"] == pytest.approx(50.0)
    assert rows["cached"]["over_plain"] == pytest.approx(2 * anchors**2 / 0.5 / 50.0)
    assert rows["rollouts"]["over_plain"] is rows["plain"]["over_plain"] is None
    # Both warm up, and then each has its own pairs.
    assert {world for world, *_ in calls} == {20_007}
    assert calls[-2:] == [(20_007, 3, targets, anchors), (20_007, 4, targets, anchors)]
    json.dumps(report.as_dict(), allow_nan=False)
    assert "over_plain" in report.as_text()


@needs("reach_k2")
@pytest.mark.full
def test_the_benchmark_measures_rollouts_and_queries(monkeypatch):
    monkeypatch.setattr(reachability, "_BATCH", 32)
    few = reachability.Settings(cars=3, targets=2, anchors=12, plain=64)
    found = reachability.measure(10_001, 0, few)
    assert set(found) == {"rollouts", "cached", "plain"}
    assert 0 < found["rollouts"][0] <= 10
    assert found["cached"][0] == 144
    assert found["plain"][0] == 64
    assert all(seconds > 0 for _, seconds in found.values())
