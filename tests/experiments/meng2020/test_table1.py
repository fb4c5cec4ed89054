"""Table I: the same episodes for all controllers, and a readable report."""

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import in_turn
from tutorial_lib.cli import main
from tutorial_lib.driving.control.smoothed import SHARE
from tutorial_lib.driving.data.episodes import Episodes
from tutorial_lib.driving.rollouts import Rollouts
from tutorial_lib.experiments.benchmarks import control
from tutorial_lib.experiments.common.report import Options
from tutorial_lib.experiments.meng2020 import table1, table1_smoothing
from tutorial_lib.experiments.meng2020.table1 import controllers
from tutorial_lib.experiments.protocols import local_control
from tutorial_lib.learning.estimators import WaypointNetwork
from tutorial_lib.learning.policies import by_smoothed_waypoints, by_waypoints
from tutorial_lib.world.generators import generate
from tutorial_lib.world.plan_json import save_plan
from tutorial_lib.world.visibility import mutual_overlap

WORLD = 10_001
CONTROLLERS = {"direct", "k0", "k2", "k5", "laser", "random", "oracle"}
CONDITIONS = {"clean", "noise", "obstacles", "shifted"}


@pytest.fixture(scope="module")
def course():
    return local_control.conditions(WORLD, 12, Options())


@pytest.fixture(scope="module", autouse=True)
def _alone():
    """Other processes would take longer to start than these few episodes take."""
    with pytest.MonkeyPatch.context() as patch:
        for module in (table1, table1_smoothing):
            patch.setattr(module, "for_each", in_turn)
        yield


@pytest.fixture(scope="module")
def report():
    """Two worlds with few episodes."""
    few = replace(table1.EXPERIMENT, quick_settings=table1.Settings(episodes=3))
    return few.report(Options(worlds=(10_000, 10_001), quick=True))


@pytest.mark.full
def test_every_controller_has_a_row_for_every_condition(report):
    keys = [(row["controller"], row["condition"]) for row in report.rows]
    assert len(keys) == len(set(keys)) == len(CONTROLLERS) * len(CONDITIONS)
    assert set(keys) == {(name, condition) for name in CONTROLLERS for condition in CONDITIONS}
    for row in report.rows:
        assert row["low"] <= row["success"] <= row["high"]
        assert row["success_or_overlap"] >= row["success"]
        assert row["episodes"] == 6
    assert json.loads(json.dumps(report.as_dict()))["worlds"] == [10_000, 10_001]
    assert "oracle - k5, clean" in report.as_text()


@pytest.mark.full
def test_all_conditions_share_their_starts_and_targets(course):
    clean = course["clean"].episodes
    for name in ("noise", "shifted"):
        assert (course[name].episodes.starts == clean.starts).all()
        assert (course[name].episodes.targets == clean.targets).all()
    seen = [course[name].episodes.recorded.scene.plan for name in ("clean", "shifted")]
    assert (seen[0].segments == seen[1].segments).all()
    assert not np.array_equal(seen[0].atlas, seen[1].atlas)
    assert course["noise"].noise == pytest.approx(1 / 3)
    owners = [person.owner for person in course["obstacles"].people]
    assert np.bincount(owners).tolist() == [local_control.OBSTACLES] * len(
        course["obstacles"].episodes
    )


@pytest.mark.full
def test_the_clean_course_alone_is_the_same(course):
    alone = local_control.clean_condition(WORLD, 12, Options()).episodes
    assert (alone.starts == course["clean"].episodes.starts).all()
    assert (alone.targets == course["clean"].episodes.targets).all()


@pytest.mark.full
def test_a_random_controller_and_an_oracle_bracket_the_others(course):
    clean = course["clean"]
    reached = {
        name: local_control.attempt(clean, make_policy)["reached"].mean()
        for name, make_policy in controllers((0, WORLD)).items()
    }
    assert reached["oracle"] >= 0.9
    assert reached["random"] <= 0.4
    assert reached["k5"] >= 0.7
    assert reached["random"] < reached["k2"]


def test_the_same_seed_gives_the_same_outcome(course):
    noisy = course["noise"]
    both = [
        local_control.attempt(noisy, controllers((0, WORLD))["k2"])["reached"] for _ in range(2)
    ]
    assert (both[0] == both[1]).all()


@pytest.mark.full
def test_smoothing_compares_each_controller_with_itself(monkeypatch):
    parts = []

    def kept(*given, label):
        parts[:] = in_turn(*given, label=label)
        return parts

    monkeypatch.setattr(table1_smoothing, "for_each", kept)
    settings = table1_smoothing.Settings(controllers=("k0",), shares=(1.0, 0.1), episodes=6)
    rows, gains = table1_smoothing.run(Options(worlds=(10_000, 10_001)), settings)
    assert [(row["controller"], row["share"]) for row in rows] == [("k0", 1.0), ("k0", 0.1)]
    assert len(parts) == 2
    for row in rows:
        reached = np.concatenate([part["k0", row["share"]] for part in parts])
        assert row["episodes"] == len(reached) == 12
        assert row["success"] == pytest.approx(reached.mean())
    (gain,) = gains
    assert gain.what == "k0: 0.1 - 1"
    assert gain.value == pytest.approx(rows[1]["success"] - rows[0]["success"])


@pytest.mark.full
def test_with_a_share_of_1_c_has_no_memory():
    settings = table1_smoothing.Settings(controllers=("k0",), shares=(1.0,), episodes=6)
    options = Options(worlds=(WORLD,), family="hall")
    found = table1_smoothing.run_world(WORLD, options, settings)["k0", 1.0]
    condition = local_control.clean_condition(WORLD, 6, options)
    usual = by_waypoints(WaypointNetwork("waypoint_k0"))
    assert (found == local_control.attempt(condition, usual)["reached"]).all()
    assert condition.episodes.recorded.scene.plan.family == "hall"


@pytest.mark.full
def test_c_of_table_1_smooths_its_waypoints(course):
    for name in ("k0", "k2", "k5"):
        predictor = WaypointNetwork(f"waypoint_{name}")
        found, smoothed, plain = (
            course["clean"].run(policy).poses
            for policy in (
                controllers((0, WORLD))[name],
                by_smoothed_waypoints(predictor, SHARE),
                by_waypoints(predictor),
            )
        )
        assert np.array_equal(found, smoothed)
        assert not np.array_equal(found, plain)


def test_the_odometry_that_smoothing_needs_drifts(course):
    class Straight:
        def act(self, observations, robots):
            begun.append(observations.odometry)
            moved.append(observations.odometry - begun[0][robots])
            return np.tile([0.5, 0.0], (len(robots), 1))

    begun, moved = [], []
    course["clean"].run(lambda simulation, recorded, frames: Straight())
    assert np.hypot(*moved[5][:, :2].T).max() > 0.02
    assert np.abs(moved[5][:, 2]).max() > 0.0  # straight ahead, and yet it seems to have turned


def test_a_map_stands_in_place_of_worlds(capsys):
    assert main(["experiment", "meng_table1", "--map", "depot.yaml", "--worlds", "3:5"]) == 2
    assert "--map" in capsys.readouterr().err


@pytest.mark.full
def test_a_map_has_no_shifted_palette_and_is_named(tmp_path):
    plan = generate("apartment", 10_012)
    save_plan(plan, tmp_path / "flat.json")
    few = replace(table1.EXPERIMENT, quick_settings=table1.Settings(map_episodes=2))
    made = few.report(Options(quick=True, map=tmp_path / "flat.json"))
    assert made.map == "flat.json"
    assert {row["condition"] for row in made.rows} == CONDITIONS - {"shifted"}


def test_an_ablation_belongs_to_its_experiment(capsys):
    assert main(["experiment", "plans", "--ablation", "smoothing"]) == 2
    assert "--ablation smoothing: plans has none" in capsys.readouterr().err


def test_the_benchmark_of_control_shows_where_the_time_goes():
    few = replace(control.EXPERIMENT, quick_settings=control.Settings(fleets=(1, 3), rounds=4))
    rows = few.report(Options(quick=True)).rows
    assert {(row["cars"], row["stage"]) for row in rows} == {
        (cars, stage) for cars in (1, 3) for stage in (*control.STAGES, "plain", "all")
    }
    for cars in (1, 3):
        shares = [
            row["share"] for row in rows if row["cars"] == cars and row["stage"] in control.STAGES
        ]
        assert sum(shares) == pytest.approx(1.0)


def test_matched_is_what_saw_its_target_s_view_before_it_ended(recorded):
    frame = int(recorded.first[0]) + 60
    goal, poses = recorded.poses[frame], recorded.poses
    overlaps = mutual_overlap(recorded.scene.caster, poses, np.broadcast_to(goal, poses.shape))
    assert overlaps[frame].min() > 0.99
    one = int(np.flatnonzero((overlaps.max(axis=1) > 0.75) & (overlaps.min(axis=1) < 0.65))[0])
    far = int(overlaps.max(axis=1).argmin())
    # At the goal: in the last step, when touching something, too late, never; seen by one only.
    track = poses[
        [
            [far, far, far, far, far, far],
            [far, far, far, far, one, frame],
            [frame, frame, far, far, one, far],
            [frame, frame, frame, far, one, far],
        ]
    ]
    ended = Rollouts(
        np.array(["late", "collided", "late", "late", "late", "reached"]),
        np.array([False, True, False, False, False, False]),
        np.full(6, 0.2),
        track,
    )
    none = np.zeros(6)
    episodes = Episodes(recorded, poses[[far] * 6], np.full(6, frame), none, none + 9.0)
    matched = local_control.Condition(episodes, []).matched(ended)
    assert matched.tolist() == [True, False, False, False, False, True]


def test_noise_differs_from_world_to_world_and_seed_to_seed():
    pairs = [(10_000, 0), (10_001, 0), (10_000, 1)]
    assert len({local_control.seeds_of(place, seed) for place, seed in pairs}) == 3
    assert local_control.seeds_of("room.json", 3) == local_control.seeds_of("room.json", 3)
