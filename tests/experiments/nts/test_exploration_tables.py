"""Table 1, Table 2 and Fig. 8 with the true geometry in place of the networks, on few episodes."""

import re
from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import in_turn
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.benchmarks import explore
from tutorial_lib.experiments.common import explorers
from tutorial_lib.experiments.common.report import Options
from tutorial_lib.experiments.nts import fig8, table1, table2
from tutorial_lib.experiments.protocols import exploration
from tutorial_lib.experiments.protocols.exploration import make_world, measures, run_agent
from tutorial_lib.exploration.episodes import DIFFICULTIES, draw_episodes
from tutorial_lib.exploration.task import ExplorationTask

WORLDS = (10_100, 10_102)
OPTIONS, ONE_WORLD = Options(worlds=WORLDS), Options(worlds=WORLDS[:1])
KEYS = ("agent", "sensor", "signs", "difficulty")


@pytest.fixture(autouse=True)
def _alone(monkeypatch):
    for module in (exploration, fig8):
        monkeypatch.setattr(module, "for_each", in_turn)


@pytest.mark.full
def test_table1_has_a_row_for_each_agent_signs_and_difficulty():
    agents = ("nts", "fbe", "oracle")
    settings = table1.Settings(1, agents, (), geometry=True)
    rows, notes = table1.run(OPTIONS, settings)
    keys = [tuple(row[key] for key in KEYS) for row in rows]
    assert len(set(keys)) == len(keys) == 3 * 2 * 3
    assert {key[0] for key in keys} == set(agents)
    for row in rows:
        assert row["episodes"] == 2
        assert 0 <= row["spl"] <= row["success"] <= 1
        assert row["success_125"] <= row["success_250"] <= row["success"]
        if row["agent"] == "oracle":
            assert row["success"] == 1.0
        paper = table1.PAPER.get((row["agent"], "rgbd"))
        assert (row["paper_success"] is None) == (paper is None)
    assert len(notes) == 2 * 3  # nts against fbe
    again, _ = table1.run(OPTIONS, table1.Settings(1, ("oracle",), (), geometry=True))
    assert again == [row for row in rows if row["agent"] == "oracle"]


@pytest.mark.full
def test_table1_has_the_same_episodes_with_a_car():
    settings = table1.Settings(1, ("nts", "il", "oracle"), ("nts",), geometry=True)
    cars, notes = table1.run(replace(ONE_WORLD, body="car"), settings)
    assert {(row["agent"], row["sensor"]) for row in cars} == {("nts", "rgbd"), ("oracle", "rgbd")}
    assert all(row["paper_success"] is None for row in cars)  # its robot is no car
    assert re.fullmatch(r"\d of 3 cars were turned at their starts", notes[-1])
    bodies, _ = table1.run(ONE_WORLD, replace(settings, rgbd=("oracle",), rgb=()))
    assert {row["body"] for row in cars} == {"car"}
    assert {row["body"] for row in bodies} == {"round"}
    oracles = [row for row in cars if row["agent"] == "oracle"]
    for car, body in zip(oracles, bodies, strict=True):
        assert [car[key] for key in KEYS] == [body[key] for key in KEYS]
        assert car["success"] == body["success"] == 1.0
        assert 0.5 < car["spl"] < body["spl"]  # its curves are longer


def test_agents_meet_the_same_episodes_and_the_same_with_and_without_signs():
    plain, signs = (make_world(10_100, kind, 2, 0) for kind in ("plain", "wayfinding"))
    assert np.array_equal(plain.episodes.starts, signs.episodes.starts)
    assert np.array_equal(plain.episodes.goals, signs.episodes.goals)
    oracle = [run_agent(world, "oracle", "rgbd") for world in (plain, signs)]
    assert np.array_equal(oracle[0]["travelled"], oracle[1]["travelled"])
    assert oracle[0]["difficulty"].tolist() == [0, 0, 1, 1, 2, 2]


def test_measures_are_means_over_the_episodes():
    found = {
        "success": np.array([1.0, 0.0, 1.0, 1.0]),
        "spl": np.array([1.0, 0.0, 0.5, 0.5]),
        "steps": np.array([100.0, 500.0, 200.0, 300.0]),
        "collisions": np.zeros(4),
    }
    row = measures(found, np.array([0, 0, 1, 1]))
    assert (row["success"], row["spl"]) == (0.75, 0.5)
    assert (row["success_125"], row["success_250"]) == (0.25, 0.5)
    assert (row["success_low"], row["success_high"]) == (0.5, 1.0)
    alone = measures(found, np.zeros(4))
    assert alone["spl"] == 0.5
    assert alone["spl_low"] is None


@pytest.mark.full
def test_table2_takes_away_the_stop_and_the_noise():
    settings = table2.Settings(1, ("nts",), geometry=True)
    rows, notes = table2.run(OPTIONS, settings)
    assert {row["condition"] for row in rows} == set(table2.CONDITIONS)
    assert {row["difficulty"] for row in rows} == {*DIFFICULTIES, "overall"}
    assert len(rows) == 2 * 3 * 4
    success = {
        (row["signs"], row["condition"]): row["success"]
        for row in rows
        if row["difficulty"] == "overall"
    }
    for signs in ("plain", "wayfinding"):
        assert success[signs, "no_stop"] >= success[signs, "standard"]
    assert all(row["episodes"] == 6 for row in rows if row["difficulty"] == "overall")
    assert len(notes) == 4


@pytest.mark.full
def test_fig8_counts_the_goals_up_to_each_number():
    rows, _ = fig8.run(ONE_WORLD, fig8.Settings(2, 3, geometry=True))
    keys = [(row["agent"], row["signs"], row["goals"]) for row in rows]
    assert len(set(keys)) == len(keys) == 3 * 2 * 3
    for row in rows:
        assert row["episodes"] == 2
        if row["agent"] == "nts":
            assert row["success_gap"] == row["spl_gap"] == 0.0
    nts = {row["goals"]: row for row in rows if row["agent"] == "nts" and row["signs"] == "plain"}
    total = np.cumsum([nts[count]["success_this"] for count in (1, 2, 3)]) / [1, 2, 3]
    assert np.allclose([nts[count]["success"] for count in (1, 2, 3)], total)


def test_agents_without_their_weights_are_refused_before_anything_is_run(monkeypatch, tmp_path):
    monkeypatch.setattr(explorers, "FOLDER", tmp_path)
    for module in (table1, table2, fig8):
        monkeypatch.setattr(module, "run_world", None)
        with pytest.raises(InputError, match="_rgbd: its weights are not there"):
            module.run(OPTIONS, module.Settings())
    with pytest.raises(InputError, match=r"train nts --sensor rgb --blind"):
        explorers.shipped("nts_blind", "rgb")
    explorers.check_shipped(("oracle",), "rgbd")
    (tmp_path / "nts_rgbd.safetensors").touch()
    with pytest.raises(InputError, match=r"nts_masked_rgbd: .* train nts --sensor rgbd --masked"):
        explorers.check_shipped(("nts_paper",), "rgbd")


def test_every_agent_that_needs_no_network_can_be_made_and_no_other_name():
    world = make_world(10_100, "plain", 1, 0)
    task = ExplorationTask(world.scenes, world.episodes, np.random.default_rng(0))
    rng = np.random.default_rng(1)
    for name in explorers.WITH_GEOMETRY:
        explorers.make_explorer(name, task, "rgbd", rng, geometry=True).start(task.goals())
    with pytest.raises(InputError, match="agent: 'ant' is unknown"):
        explorers.make_explorer("ant", task, "rgbd", rng, geometry=True)
    for name in ("ans_like", "il"):  # they are networks, which nothing stands in for
        with pytest.raises(InputError, match=f"agent: '{name}' is unknown here"):
            explorers.make_explorer(name, task, "rgbd", rng, geometry=True)
    with pytest.raises(InputError, match="sensor: 'sonar' is unknown"):
        explorers.make_explorer("nts", task, "sonar", rng, geometry=False)
    with pytest.raises(InputError, match="ask for at least one"):
        draw_episodes("box", next(iter(world.scenes.values())), {"easy": 0}, rng)


def test_the_benchmark_counts_the_steps_of_robots_under_way():
    settings = explore.Settings(episodes=6, steps=4, warmup_steps=1, threads=1)
    rows, _ = explore.run(replace(OPTIONS, worlds=(10_100,)), settings)
    assert [row["agent"] for row in rows[:4]] == ["nts", "fbe", "random", "oracle"]
    for row in rows:
        assert row["episodes"] == 6
        assert 0 < row["steps"] <= 24
        assert row["running"] == row["steps"] / 4
        assert row["steps_per_s"] > 0
