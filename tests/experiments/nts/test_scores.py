"""The first choice of scores: decisions, regret, colours, and the table."""

from functools import cache

import numpy as np
import pytest

from tests.conftest import in_turn
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.experiments.common.report import Options
from tutorial_lib.experiments.nts import scores
from tutorial_lib.experiments.nts.scores import SCORES, Settings, choices
from tutorial_lib.exploration.labels import PanoramaLabels
from tutorial_lib.learning.exploration_data import random_poses
from tutorial_lib.world.worlds import scene_of

WORLD = "office/1/standard"
KEYS = ("score", "sensor", "signs", "pairs", "difficulty")
SMALL = Settings(places=20, goals=6, sensors=("rgbd",))


class Perfect:
    """Scores by the true distances in the office, or the same ones for all directions."""

    def __init__(self, blind):
        self.blind = blind

    def embed(self, seen):
        return np.arange(len(seen), dtype=np.float32)[:, None]

    def scores(self, sources, goals):
        scene = scene_of(WORLD)
        poses = random_poses(scene, 26, np.random.default_rng([0, scene.plan.seed]))
        source, goal = (rows[:, 0].astype(int) for rows in (sources, goals))
        metres = PanoramaLabels(scene, poses).metres(source, goal)[:, :-1]
        return np.zeros_like(metres) if self.blind else np.nan_to_num(-metres, neginf=-99.0)


@pytest.fixture
def perfect(monkeypatch):
    """Nothing is loaded: F_S knows all distances, and the blind network none."""
    monkeypatch.setattr(scores, "shipped", lambda kind, sensor: Perfect("blind" in kind))
    monkeypatch.setattr(scores, "check_shipped", lambda agents, sensor: None)


@pytest.mark.full
def test_decisions_are_those_of_the_difficulties_with_a_choice(perfect):
    found = choices(WORLD, 0, SMALL)
    assert set(np.unique(found.difficulty)) == {0, 1, 2}
    assert found.connected[found.difficulty == 0].mean() > 0.5
    assert not found.connected[found.difficulty == 2].any()  # farther away than a node reaches
    assert set(found.regret) == {("rgbd", score) for score in SCORES}
    for regret in found.regret.values():
        assert regret.shape == found.difficulty.shape
        assert (regret >= 0).all()
    assert found.regret["rgbd", "semantic"].max() == 0.0
    assert found.regret["rgbd", "random"].mean() > 0.5
    scene = scene_of(WORLD)
    poses = random_poses(scene, 26, np.random.default_rng([0, scene.plan.seed]))
    far = np.concatenate(
        [
            GridPaths(scene.clearance).between(poses[:20, :2], np.tile(poses[i, :2], (20, 1)))
            for i in range(20, 26)
        ]
    )
    assert 0.8 * ((far >= 1.5) & (far < 10)).sum() <= len(found.difficulty)


@pytest.mark.full
def test_the_table_has_each_row_once_and_gains_are_paired(perfect, monkeypatch):
    monkeypatch.setattr(scores, "for_each", in_turn)
    monkeypatch.setattr(scores, "exploration_world", lambda seed, signs: WORLD)
    monkeypatch.setattr(scores, "choices", cache(choices))
    rows, _ = scores.run(Options(worlds=(20_000, 20_001)), SMALL)
    keys = [tuple(row[key] for key in KEYS) for row in rows]
    # In this office all that is easy is in sight: between unconnected places nothing is easy.
    assert len(set(keys)) == len(keys) == 5 * 1 * 2 * (2 + 3)
    assert [row["pairs"] for row in rows[: 5 * (2 + 3)]] == ["unconnected"] * 10 + ["all"] * 15
    for row in rows:
        assert row["low"] <= row["top1"] <= row["high"]
        if row["score"] == "semantic":
            assert (row["top1"], row["regret"], row["gain"]) == (1.0, 0.0, None)
        else:
            assert row["gain"] == pytest.approx(1.0 - row["top1"])
            assert row["gain_low"] <= row["gain"] <= row["gain_high"]


@pytest.mark.full
def test_f_s_is_judged_where_it_is_asked(perfect, monkeypatch):
    """Between places of one node it may be wrong: those decisions count only among all."""
    monkeypatch.setattr(scores, "for_each", in_turn)
    monkeypatch.setattr(scores, "exploration_world", lambda seed, signs: WORLD)
    made = choices(WORLD, 0, SMALL)
    made.connected[::2] = False  # or else all that is easy would be in sight
    made.regret["rgbd", "semantic"][:] = np.where(made.connected, 2.0, 0.0)
    monkeypatch.setattr(scores, "choices", lambda *given: made)
    rows, _ = scores.run(Options(worlds=(20_000, 20_001)), SMALL)
    found = {
        row["pairs"]: row
        for row in rows
        if (row["score"], row["signs"], row["difficulty"]) == ("semantic", "plain", "easy")
    }
    assert (found["unconnected"]["top1"], found["unconnected"]["regret"]) == (1.0, 0.0)
    easy = made.difficulty == 0
    assert found["all"]["top1"] == pytest.approx(1 - made.connected[easy].mean())
    assert found["all"]["decisions"] == 2 * easy.sum()
    assert found["unconnected"]["decisions"] == 2 * (easy & ~made.connected).sum() > 0


@pytest.mark.full
def test_the_blind_scores_are_compared_with_depth_only(perfect):
    found = choices(WORLD, 0, Settings(places=6, goals=3, sensors=("rgb", "rgbd")))
    without = {score for sensor, score in found.regret if sensor == "rgb"}
    assert without == {*SCORES} - {"blind", "masked"}
    assert set(scores.scores_of("rgbd")) == set(SCORES)


@pytest.mark.full
def test_only_decisions_between_two_directions_count(perfect, monkeypatch):
    """Where a direction must be free for 2.9 m, many places have a single one, or none."""
    monkeypatch.setattr(scores, "SHORTEST", 2.9)
    scene = scene_of(WORLD)
    poses = random_poses(scene, 26, np.random.default_rng([0, scene.plan.seed]))
    labels = PanoramaLabels(scene, poses)
    source, goal = (index.ravel() for index in np.indices((20, 6)))
    metres = labels.metres(source, goal + 20)
    directions = np.isfinite(np.where(labels.lengths[source] >= 2.9, metres[:, :-1], np.inf)).sum(1)
    possible = (metres[:, -1] >= 1.5) & (metres[:, -1] < 10.0)
    assert (possible & (directions == 1)).any()
    found = choices(WORLD, 0, SMALL)
    assert len(found.difficulty) == (possible & (directions > 1)).sum() > 0
    assert all(np.isfinite(regret).all() for regret in found.regret.values())
