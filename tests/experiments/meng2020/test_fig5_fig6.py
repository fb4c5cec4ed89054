"""Trajectories that are followed again by their anchors, as in Figs. 5 and 6."""

import json
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import joblib
import numpy as np
import pytest
from scipy.stats import spearmanr

from tests.conftest import make_trajectory, needs
from tutorial_lib.experiments.common.report import Options
from tutorial_lib.experiments.meng2020 import fig5, fig6
from tutorial_lib.experiments.protocols import following
from tutorial_lib.experiments.protocols.following import Guide, trajectories
from tutorial_lib.geometry import wrap
from tutorial_lib.learning.threads import use_threads
from tutorial_lib.topology.following.transitions import State
from tutorial_lib.topology.similarity import ImageSimilarity

use_threads(1)


# Trajectories.


@pytest.fixture
def record(box, monkeypatch):
    """Makes the cars of a world drive the given metres, each along a line."""

    def start(*lengths):
        made = [make_trajectory([(1.0, 1.0), (1.0 + metres, 1.0)]) for metres in lengths]
        monkeypatch.setattr(following, "scene_of", lambda name: box)
        monkeypatch.setattr(following, "demonstrate", lambda *arguments: made)

    return start


def lengths_of(recorded):
    return sorted(round(one.arc_length[-1], 6) for one in recorded.trajectories)


def test_trajectories_are_those_of_about_15_metres(record):
    record(11.9, 13.0, 16.0, 24.5, 18.0, 32.0, 5.0)
    some = trajectories(10_001, 3, np.random.default_rng(0))
    assert lengths_of(some) == [11.0, 14.0, 16.0]
    assert len(trajectories(10_001, 99, np.random.default_rng(0)).trajectories) == 5


def test_where_all_are_short_the_longest_are_taken(record):
    record(6.0, 11.0, 8.0)
    assert lengths_of(trajectories(10_001, 2, np.random.default_rng(0))) == [6.0, 9.0]


def test_trajectories_begin_once_the_cars_are_under_way(record):
    record(16.0)
    (one,) = trajectories(10_001, 1, np.random.default_rng(0)).trajectories
    assert one.poses[0] == pytest.approx([1.0 + following.UNDER_WAY, 1.0, 0.0])


def test_every_frame_belongs_to_one_trajectory(recorded):
    count = len(recorded.trajectories)
    frames = [recorded.frames_of(number) for number in range(count)]
    assert np.concatenate(frames).tolist() == list(range(len(recorded.poses)))
    assert [len(some) for some in frames] == [len(one) for one in recorded.trajectories]


# Guides.


class Sure:
    """A `Reachability` that is always sure."""

    def prepare(self, pictures):
        return np.zeros(len(pictures))

    def probability(self, observations, prepared):
        return np.full(len(observations), 0.999)


def guide_of(recorded, context, reachability):
    guide = Guide(recorded, context)
    guide.__dict__["reachability"] = reachability  # before it is loaded
    return guide


def test_anchors_are_those_of_the_sparsifier_and_more_of_them_the_higher_the_threshold(recorded):
    guide, frames = guide_of(recorded, "k0", ImageSimilarity()), recorded.frames_of(2)
    seen = recorded.observe(frames)
    prepared, counts = ImageSimilarity().prepare(seen.image[:, None]), []
    for threshold in (0.75, 0.9, 0.97):
        anchors = guide.anchors(2, threshold)
        assert (anchors[0], anchors[-1]) == (frames[0], frames[-1])
        for first, last in pairwise(anchors - frames[0]):
            ahead = np.arange(first + 1, min(last + 2, len(frames)))
            alike = ImageSimilarity().probability(seen[np.full(len(ahead), first)], prepared[ahead])
            assert (alike[: last - first] > threshold).all() or last == first + 1
            assert last == len(frames) - 1 or alike[-1] <= threshold
        counts.append(len(anchors))
    assert counts[0] < counts[1] < counts[2]


def test_pictures_of_anchors_have_their_context(recorded):
    guide, frames = guide_of(recorded, "k2", Sure()), np.array([50, 0, 300])
    pictures = guide.images(frames)
    assert pictures.shape == (3, 5, 16, 64, 3)
    for number in range(5):
        shown = recorded.observe(recorded.context(frames, 2)[:, number]).image
        assert (pictures[:, number] == shown).all()


@pytest.fixture(scope="module")
def followed(recorded):
    """Two trajectories, each 10th frame an anchor, followed with an RE that is always sure."""
    guide = guide_of(recorded, "k2", Sure())
    shortest = np.argsort([len(one) for one in recorded.trajectories])[:2]
    paths = [recorded.frames_of(number)[::10] for number in sorted(shortest)]
    return paths, guide.follow(paths)


def test_by_many_anchors_a_trajectory_is_followed(recorded, followed):
    paths, (metres, tracks, record) = followed
    assert metres.shape == (2,)
    assert tracks.shape[1:] == (2, 3)
    length = [recorded.arc[path[-1]] - recorded.arc[path[0]] for path in paths]
    assert (metres <= np.array(length) + 1e-6).all()
    assert metres.sum() > 0.6 * sum(length)
    for robot, path in enumerate(paths):
        assert tracks[0, robot] == pytest.approx(recorded.poses[path[0]])
        if metres[robot] == pytest.approx(length[robot]):
            gap = recorded.poses[path[-1], :2] - tracks[:, robot, :2]
            assert np.hypot(*gap.T).min() < 0.3
    assert len(record.active) == len(tracks) - 1
    assert record.active[0].max() <= 1
    assert record.active.max() > 5


def test_noise_is_drawn_by_its_seed(recorded, followed):
    paths = [followed[0][0][:4]]
    guide = guide_of(recorded, "k0", Sure())
    one, two, other, quiet = (
        guide.follow(paths, noise, np.random.default_rng(seed))[1]
        for noise, seed in ((1 / 3, 0), (1 / 3, 0), (1 / 3, 1), (0.0, 0))
    )
    assert np.array_equal(one, two)
    assert not np.array_equal(one, other)
    assert not np.array_equal(one, quiet)


# Fig. 5.


@pytest.fixture
def planted(recorded, monkeypatch):
    """Guides that keep given frames of each trajectory, in the office."""

    def plant(kept):
        class Planted:
            def __init__(self, world, context):
                assert world is recorded

            def anchors(self, trajectory, threshold):
                assert threshold == 0.99
                frames = recorded.frames_of(trajectory)
                return frames[kept(len(frames))]

        monkeypatch.setattr(fig5, "Guide", Planted)
        monkeypatch.setattr(fig5, "trajectories", lambda *arguments: recorded)

    return plant


def run_fig5():
    with joblib.parallel_config(backend="sequential"):
        return fig5.EXPERIMENT.report(Options(worlds=(10_001, 10_003)))


def test_gaps_are_measured_between_anchors_but_not_to_the_end(recorded, planted):
    planted(lambda frames: np.array([0, 12, 30, 31, frames - 1]))
    found = fig5.run_world(10_001, Options(), fig5.Settings())
    assert list(found) == ["k2", "k5", "laser"]
    gaps, anchors, frames = found["k5"]
    assert anchors == 5 * len(recorded.trajectories)
    assert frames == len(recorded.poses)
    wanted = []
    for number in range(len(recorded.trajectories)):
        track = recorded.poses[recorded.frames_of(number)]
        for first, last in ((0, 12), (12, 30), (30, 31)):
            steps = np.hypot(*np.diff(track[first : last + 1, :2], axis=0).T)
            driven = np.cumsum(np.hypot(*np.diff(track[first:, :2], axis=0).T))
            metre = first + 1 + int(np.searchsorted(driven, fig5.Settings.ahead - 1e-9))
            room = recorded.scene.clearance.at(track[first + 1 : metre + 1, :2])
            turned = np.abs(wrap(np.diff(track[first : metre + 1, 2])))
            wanted.append((steps.sum(), room.min(), turned.sum()))
    assert gaps == pytest.approx(np.array(wanted), abs=1e-9)


def test_fig_5_has_a_row_for_each_controller(recorded, planted):
    planted(lambda frames: np.append(np.arange(0, frames - 1, 7), frames - 1))
    report = run_fig5()
    assert [row["context"] for row in report.rows] == ["k2", "k5", "laser"]
    for row in report.rows:
        assert 0.0 < row["sparsity"] < 1 / 6
        assert 0.05 < row["metres"] < 7 * 0.09
        for name in ("with_clearance", "with_turn"):
            assert -1.0 <= row[f"{name}_low"] <= row[name] <= row[f"{name}_high"] <= 1.0
    json.dumps(report.as_dict(), allow_nan=False)


def test_fig_5_counts_all_anchors(recorded, planted):
    planted(lambda frames: np.array([0, 12, 30, 31, frames - 1]))
    row = run_fig5().rows[0]
    assert row["anchors"] == 2 * 5 * len(recorded.trajectories)
    assert row["sparsity"] == pytest.approx(row["anchors"] / (2 * len(recorded.poses)))


@pytest.mark.full
def test_a_world_may_have_no_gaps(recorded, planted, monkeypatch):
    planted(lambda frames: np.array([0, frames - 1]))
    none = fig5.run_world(10_001, Options(), fig5.Settings())
    planted(lambda frames: np.append(np.arange(0, frames - 1, 7), frames - 1))
    some = fig5.run_world(10_001, Options(), fig5.Settings())
    monkeypatch.setattr(fig5, "run_world", lambda world, *_: none if world == 10_003 else some)
    assert run_fig5().rows[0]["metres"] == pytest.approx(some["k2"][0][:, 0].mean())


@pytest.mark.full
def test_correlations_are_of_ranks(monkeypatch):
    rng = np.random.default_rng(0)
    metres, clearance = rng.integers(1, 9, size=(2, 50)).astype(float)
    gaps = np.column_stack([metres, np.exp(clearance), -np.exp(metres)])
    found = dict.fromkeys(fig5.Settings.contexts, (gaps, 50, 500))
    monkeypatch.setattr(fig5, "run_world", lambda world, *_: found)
    for row in run_fig5().rows:
        assert row["with_clearance"] == pytest.approx(spearmanr(metres, clearance).statistic)
        assert row["with_turn"] == row["with_turn_low"] == pytest.approx(-1.0)


# Fig. 6.


def test_fig_6_numbers_nine_places_of_one_trajectory(box, monkeypatch):
    lines = [make_trajectory([(1.0, 1.0), (1.0 + metres, 1.0)]) for metres in (7.0, 22.0, 40.0)]
    steps, chosen = 60, []

    class Planted:
        def __init__(self, world, context):
            chosen.append((world.trajectories, context))

        def anchors(self, trajectory, threshold):
            return np.array([0, 50, 200])

        def follow(self, paths):
            tracks = np.zeros((steps + 1, 1, 3))
            tracks[:, 0, 0] = np.arange(steps + 1)
            active = np.repeat([-1, 0, 1, 2], [4, 16, 20, 20])[:, None]
            state = np.where(active < 0, State.SEARCH, State.FOLLOW)
            probability = np.where(active < 0, np.nan, 0.9)  # none while searching or lost
            record = SimpleNamespace(active=active, state=state, probability=probability)
            return np.array([20.0]), tracks, record

    monkeypatch.setattr(fig6, "demonstrate", lambda *arguments: lines)
    monkeypatch.setattr(fig6, "scene_of", lambda name: box)
    monkeypatch.setattr(fig6, "Guide", Planted)
    report = fig6.EXPERIMENT.report(Options(worlds=(10_001,)))
    use_threads(1)
    ((recorded, context),) = chosen
    (one,) = recorded  # the one that is nearest to 23 m once it is under way
    assert one.arc_length[-1] == pytest.approx(20.0, abs=0.06)
    assert np.array_equal(one.poses[-1], lines[1].poses[-1])
    assert context == "k5"
    assert report.worlds == (10_001,)
    assert [row["place"] for row in report.rows] == list(range(1, 10))
    seconds = [row["seconds"] for row in report.rows]
    assert seconds == sorted(set(seconds))
    assert (seconds[0], seconds[-1]) == (pytest.approx(0.4), pytest.approx(5.9))
    for row in report.rows:
        step = round(row["seconds"] / 0.1)
        assert row["x"] == step  # where it was when this was decided
        assert row["active"] == (0 if step < 20 else 1 if step < 40 else 2)
        assert (row["state"], row["anchors"], row["probability"]) == ("follow", 3, 0.9)
    assert "20.0 of 20.0 m followed by 3 of 401 frames" in report.notes[0]
    json.dumps(report.as_dict(), allow_nan=False)


# With trained weights.


@pytest.mark.full
@needs("reach_k2", "reach_k5", "reach_laser")
def test_fig_5_runs_on_a_validation_world(monkeypatch):
    monkeypatch.setattr(following, "CARS", 4)
    few = replace(fig5.EXPERIMENT, settings=fig5.Settings(trajectories=1))
    with joblib.parallel_config(backend="sequential"):
        report = few.report(Options(worlds=(10_001,)))
    assert [row["context"] for row in report.rows] == ["k2", "k5", "laser"]
    assert all(0.0 < row["sparsity"] < 1.0 for row in report.rows)


@pytest.mark.full
@needs("reach_k5")
def test_fig_6_runs_on_a_validation_world(monkeypatch):
    monkeypatch.setattr(fig6, "CARS", 4)
    monkeypatch.setattr(fig6, "use_threads", lambda count: None)  # for one robot, one is best
    short = replace(fig6.EXPERIMENT, settings=fig6.Settings(length=6.0))
    report = short.report(Options(worlds=(10_001,)))
    assert len(report.rows) == fig6.Settings.places
    assert {row["state"] for row in report.rows} <= {state.name.lower() for state in State}
