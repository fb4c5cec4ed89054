"""The race: lives of several goals, in which somebody may carry the robot elsewhere."""

import json

import numpy as np
import pytest

from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.experiments.common.report import CAR, Options
from tutorial_lib.experiments.protocols.visits import shown
from tutorial_lib.experiments.race import runners, ten_visits
from tutorial_lib.experiments.race.runners import FIELD, INGREDIENTS, RUNNERS, TOURED
from tutorial_lib.experiments.race.ten_visits import (
    APART,
    CHANGED,
    STAYS,
    Settings,
    draw_lives,
    run,
)
from tutorial_lib.exploration.episodes import exploration_world
from tutorial_lib.world.worlds import scene_of

WORLD = 10_000


def test_goals_are_as_far_apart_as_said_and_the_same_for_all():
    scene = scene_of(exploration_world(WORLD))
    settings = Settings(lives=2, visits=3)
    goals, carries = draw_lives(scene, settings, np.random.default_rng(1))
    again, _ = draw_lives(scene, settings, np.random.default_rng(1))
    assert np.array_equal(goals, again)
    assert goals.shape == carries.shape == (3, 2, 3)
    paths = GridPaths(scene.clearance)
    starts = np.concatenate([carries[:1], goals[:-1]])
    for first, second in [*zip(starts, goals, strict=True), *zip(carries, goals, strict=True)]:
        metres = paths.between(first[:, :2], second[:, :2])
        assert ((APART[0] - 0.5 < metres) & (metres < APART[1] + 0.5)).all()


@pytest.mark.full
def test_a_goal_behind_a_wall_was_not_passed():
    scene = scene_of(exploration_world(WORLD))
    paths = GridPaths(scene.clearance)
    free = paths.points[paths.largest]
    rng = np.random.default_rng(0)
    chosen = free[rng.choice(len(free), 60, replace=False)]
    tracks = np.stack([np.column_stack([chosen, np.zeros(60)])])
    here = ten_visits._nearest(paths, tracks, tracks[0])
    assert np.allclose(here, 0.0)
    gaps = np.linalg.norm(free[:, None] - chosen, axis=2)
    pairs = [(i, np.flatnonzero((gap > 0.5) & (gap < 1.0))) for i, gap in enumerate(gaps.T)]
    for i, near in pairs[:20]:
        for place in free[near][:6]:
            goal = np.array([[*place, 0.0]])
            (found,) = ten_visits._nearest(paths, tracks[:, [i]], goal)
            (metres,) = paths.between(chosen[[i]], place[None])
            assert np.isinf(found) == (metres > 1.5)
    assert np.isinf(ten_visits._nearest(paths, tracks[:0], tracks[0])).all()


def test_lives_have_rows_and_a_faulty_agent_costs_its_own_only(tmp_path):
    (tmp_path / "mine.py").write_text(
        "class Broken:\n    def start(self, goals):\n        pass\n"
        "    def act(self, observations, running):\n        return 1 / 0\n"
    )
    settings = Settings(("combined", "nts_forgets"), lives=2, visits=2, carried=(1,))
    options = Options(worlds=(WORLD,), agent=f"{tmp_path / 'mine.py'}:Broken")
    rows, notes = run(options, settings)
    json.dumps(rows)
    assert [(row["agent"], row["visits"]) for row in rows] == [
        ("combined", "1-3"),
        ("combined", "1-10"),
        ("nts_forgets", "1-3"),
        ("nts_forgets", "1-10"),
    ]
    assert all(row["goals"] == 4 and row["carried"] == 2 for row in rows)
    assert rows[0]["gap"] == 0.0
    assert rows[0]["again"] is not None
    assert rows[2]["again"] is None  # nobody watches an agent that has no islands
    assert any("line 5" in note and "ZeroDivisionError" in note for note in notes)


def test_all_who_run_are_known():
    assert set(FIELD) | set(INGREDIENTS) | set(TOURED) <= RUNNERS.keys()


def test_the_same_lives_are_lived_where_the_building_stays_and_where_it_changes():
    settings = Settings(("oracle",), lives=2, visits=5, changes=1)
    rows, _ = run(Options(worlds=(WORLD + 7, WORLD + 2)), settings)  # no detours in the second
    stays, changes = ([r for r in rows if r["building"] == kind] for kind in (STAYS, CHANGED))
    assert [row["visits"] for row in stays] == [row["visits"] for row in changes] == ["1-3", "1-10"]
    for row in rows:
        assert row["goals"] == 2 * (3 if row["visits"] == "1-3" else 5)
        assert row["success"] == 1.0
        assert row["gap"] == 0.0
    assert abs(changes[1]["steps"] - stays[1]["steps"]) > 1  # by other doors


@pytest.mark.parametrize("name", ["oracle", "random_forgets"])
def test_bounds_of_the_race(name):
    rows, _ = run(Options(worlds=(WORLD,)), Settings((name,), lives=4, visits=2))
    (row,) = [row for row in rows if row["visits"] == "1-10"]
    assert row["success"] == 1.0 if name == "oracle" else row["success"] < 0.8


def test_a_guide_shows_a_building_for_as_long_as_said():
    name = exploration_world(WORLD)
    scene = scene_of(name)

    def guide(task):
        return RUNNERS["oracle"](task, None, np.random.default_rng(0))

    run, again = (shown(name, scene, guide, 150, np.random.default_rng(3)) for _ in range(2))
    assert len(run) == 150  # several goals, one after another
    assert all(np.array_equal(a.image, b.image) for a, b in zip(run, again, strict=True))
    path = np.concatenate([seen.odometry for seen in run])
    assert np.hypot(*np.diff(path[:, :2], axis=0).T).sum() > 15.0


@pytest.mark.full
def test_a_robot_that_was_shown_a_building_and_explores_finds_what_its_map_has_not(monkeypatch):
    monkeypatch.setattr(runners, "SHOWN", 40)  # next to nothing
    rows, _ = run(Options(worlds=(WORLD,)), Settings(("meng_toured", "meng_explores"), 3, 2))
    plans, explores = (row["success"] for row in rows if row["visits"] == "1-10")
    assert explores > plans


def test_a_car_lives_too():
    rows, _ = run(Options(worlds=(WORLD,)), Settings(("oracle",), lives=2, visits=2, body=CAR))
    (row,) = [row for row in rows if row["visits"] == "1-10"]
    assert row["success"] == 1.0
    assert row["drift"] > 0.0


@pytest.mark.full
@pytest.mark.parametrize("name", ["meng_toured", "sptm_toured", "ltvn_toured", "meng_explored"])
def test_robots_that_were_shown_a_building_know_it(name, monkeypatch):
    monkeypatch.setattr(runners, "SHOWN", 200)
    rows, _ = run(Options(worlds=(WORLD,)), Settings((name,), lives=2, visits=2))
    (row,) = [row for row in rows if row["visits"] == "1-10"]
    assert row["goals"] == 4
    assert row["steps"] < 500  # none looks for a goal that its map has not
