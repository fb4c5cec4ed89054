"""Fig. 7: how much of a trajectory is followed, against how little of it is kept."""

from dataclasses import replace

import joblib
import numpy as np
import pytest

from tests.conftest import needs
from tutorial_lib.experiments.common.report import Options
from tutorial_lib.experiments.meng2020 import fig7
from tutorial_lib.experiments.protocols import following
from tutorial_lib.learning.threads import use_threads

use_threads(1)


def columns(sparsity, covered, trajectories=6, spread=0.0):
    """A point of a curve: so much kept and followed of trajectories that are all alike, or not."""
    frames = np.full(trajectories, 200.0)
    follow = covered + spread * np.linspace(-1, 1, trajectories)
    return {
        "length": np.full(trajectories, 10.0),
        "covered": 10.0 * follow,
        "anchors": sparsity * frames,
        "stored": 2 * sparsity * frames,
        "frames": frames,
    }


def curve(points, **choices):
    return [columns(*point, **choices) for point in points]


WHERE = np.array([0, 0, 1, 1, 2, 2])
OURS = [(0.02, 0.5), (0.04, 0.7), (0.08, 0.9)]


@pytest.mark.parametrize("order", [[0, 1, 2], [2, 0, 1]])
def test_the_gap_of_two_curves_is_that_between_them(order):
    theirs = curve([(s, c - 0.1) for s, c in OURS])
    ours = [curve(OURS)[number] for number in order]
    assert fig7._between(ours, theirs, WHERE) == pytest.approx((0.1, 0.1, 0.1))
    assert fig7._between(theirs, ours, WHERE) == pytest.approx((-0.1, -0.1, -0.1))


def test_curves_are_compared_where_both_have_points():
    # From 0.04 to 0.08 ours rises from 0.7 to 0.9, theirs from 0.4 to 0.5.
    theirs = curve([(0.04, 0.4), (0.12, 0.6)])
    gap, _, _ = fig7._between(curve(OURS), theirs, WHERE)
    assert gap == pytest.approx((0.3 + 0.4) / 2, abs=1e-3)
    apart = curve([(0.2, 0.4), (0.3, 0.6)])
    assert np.isnan(fig7._between(curve(OURS), apart, WHERE)[0])


def test_the_gap_s_interval_is_that_of_worlds():
    theirs = curve([(s, c - 0.1) for s, c in OURS])
    varied = curve(OURS, spread=0.05)
    gap, low, high = fig7._between(varied, theirs, WHERE)
    assert gap == pytest.approx(0.1)
    # The worlds' gaps are 0.06, 0.1 and 0.14.
    assert 0.055 < low < 0.075
    assert 0.125 < high < 0.145
    assert fig7._between(varied, curve(OURS, spread=0.05), WHERE) == pytest.approx((0, 0, 0))


def test_a_row_is_what_was_kept_and_what_was_followed():
    some = columns(0.05, 0.8)
    some["length"] = np.array([5.0, 5.0, 10.0, 10.0, 20.0, 10.0])
    some["covered"] = np.array([5.0, 0.0, 10.0, 5.0, 20.0, 5.0])
    row = fig7._row(("meng", "k2", "clean", 0.9), some, WHERE)
    assert row["cover_rate"] == pytest.approx(45 / 60)
    # A world that is drawn again brings its length with it: 5 of 10, 15 of 20 or 25 of 30 m.
    assert 0.5 <= row["low"] < row["cover_rate"] < row["high"] <= 25 / 30
    assert (row["sparsity"], row["stored"]) == (pytest.approx(0.05), pytest.approx(0.1))
    assert row["trajectories"] == 6
    assert list(row)[:4] == ["method", "context", "condition", "threshold"]


class Keeping:
    """A guide that keeps the first frame, the last and some between, and follows half of it."""

    def __init__(self, recorded, context, odometry):
        assert odometry.drifts
        self.recorded, self.context, self.k = recorded, context, int(context[1:])

    def anchors(self, trajectory, threshold):
        frames = self.recorded.frames_of(trajectory)
        return frames[[0, round(10 * threshold), -1]]

    def follow(self, paths, noise=0.0, rng=None):
        arc = self.recorded.arc
        share = 0.25 if noise else 0.5
        return np.array([share * (arc[t[-1]] - arc[t[0]]) for t in paths]), None, None


@pytest.mark.parametrize("quick", [True, False])
def test_trajectories_are_followed_by_every_method(recorded, monkeypatch, quick):
    monkeypatch.setattr(fig7, "Guide", Keeping)
    monkeypatch.setattr(fig7, "trajectories", lambda *arguments: recorded)
    settings = fig7.QUICK if quick else fig7.Settings()
    found = fig7.run_world(10_001, Options(), settings)
    ours = (0.9, 0.99) if quick else (0.9, 0.95, 0.97, 0.99)
    theirs = (10, 30) if quick else (10, 20, 30, 40)
    methods = {("meng", p) for p in ours} | {("sptm", n) for n in theirs}
    wanted = {(m, k, "clean", p) for m, p in methods for k in ("k0", "k2", "k5")}
    wanted |= set() if quick else {("meng", "k2", "noise", p) for p in ours}
    assert set(found) == wanted
    lengths = np.array([len(one) for one in recorded.trajectories])
    metres = np.array([one.arc_length[-1] for one in recorded.trajectories])
    for (method, context, condition, chosen), some in found.items():
        assert some["frames"].tolist() == lengths.tolist()
        assert some["length"] == pytest.approx(metres)
        share = 0.25 if condition == "noise" else 0.5
        assert some["covered"] == pytest.approx(share * metres)
        kept = 1 + np.ceil((lengths - 1) / chosen) if method == "sptm" else 3
        assert some["anchors"].tolist() == (kept * np.ones(len(lengths))).tolist()
        # With context, frames 3 apart on either side; at an end only on one.
        most = some["anchors"] * (2 * int(context[1:]) + 1)
        assert (some["stored"] >= some["anchors"]).all()
        assert (some["stored"] <= most).all()
        assert context != "k0" or some["stored"].tolist() == some["anchors"].tolist()


def test_fig_7_reports_every_way_once_and_the_gaps(recorded, monkeypatch):
    monkeypatch.setattr(fig7, "Guide", Keeping)
    monkeypatch.setattr(fig7, "trajectories", lambda *arguments: recorded)
    with joblib.parallel_config(backend="sequential"):
        report = fig7.EXPERIMENT.report(Options(worlds=(10_001, 10_003)))
    keys = [(r["method"], r["context"], r["condition"], r["threshold"]) for r in report.rows]
    assert len(keys) == len(set(keys)) == 3 * 8 + 4
    for row in report.rows:
        noisy = row["condition"] == "noise"
        assert row["cover_rate"] == pytest.approx(0.25 if noisy else 0.5)
        assert row["trajectories"] == 2 * len(recorded.trajectories)
    found = {finding.what: finding for finding in report.findings}
    for context in ("k0", "k2", "k5"):
        assert f"area between meng and sptm, {context}" in found
    assert str(found["clean - noise, k2 at 0.97"]) == "+25.0 points (+25.0 to +25.0)"


@pytest.mark.full
@needs("reach_k0", "reach_k2", "reach_k5")
def test_fig_7_runs_on_a_validation_world(monkeypatch):
    for name, less in (("CARS", 6), ("_SHORTEST", 4.0), ("LENGTH", 5.0)):
        monkeypatch.setattr(following, name, less)
    few = replace(fig7.QUICK, thresholds=(0.9,), intervals=(10,), trajectories=1)
    with joblib.parallel_config(backend="sequential"):
        report = replace(fig7.EXPERIMENT, quick_settings=few).report(
            Options(worlds=(10_001,), quick=True)
        )
    assert len(report.rows) == 6
    assert all(0.0 <= row["cover_rate"] <= 1.0 for row in report.rows)
