"""Table 1, Table 2 and Fig. 8 compare the right agents, over the right worlds, with one noise."""

from functools import cache

import numpy as np
import pytest

from tests.conftest import in_turn
from tutorial_lib.experiments.common import explorers
from tutorial_lib.experiments.common.report import Options
from tutorial_lib.experiments.nts import fig8, table1, table2
from tutorial_lib.experiments.protocols import exploration
from tutorial_lib.experiments.protocols.exploration import make_world, run_agent
from tutorial_lib.exploration.graph_update import PAPER, Localisation
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.exploration.true_geometry import TrueGeometry

WORLDS = (10_100, 10_102, 10_104)
OPTIONS = Options(worlds=WORLDS)
OF = {"nts": 0.6, "fbe": 0.4, "ans_like": 0.7, "il": 0.3}
"""SPL of each agent in the first world; it rises by 0.05 from world to world."""


def made_up(world, name, sensor, *, geometry=False, noise=True, stops_itself=False, body="round"):
    """Columns of three episodes, which say what they were asked for."""
    value = OF[name] + 0.05 * WORLDS.index(world.seed[1]) - 0.1 * (sensor == "rgb")
    value += 0.02 * stops_itself - 0.03 * (not noise)
    found = dict.fromkeys(("steps", "travelled", "collisions"), np.zeros(3))
    found |= {"difficulty": np.arange(3.0), "spl": np.full(3, value)}
    return found | {"success": found["spl"] + 0.1}


@pytest.fixture
def _made_up(monkeypatch):
    for module in (table1, table2):
        monkeypatch.setattr(module, "run_agent", made_up)
        monkeypatch.setattr(module, "make_world", one_world)
        monkeypatch.setattr(module, "check_shipped", lambda agents, sensor: None)
    monkeypatch.setattr(exploration, "for_each", in_turn)


one_world = cache(make_world)


@pytest.mark.usefixtures("_made_up")
@pytest.mark.full
def test_table1_compares_within_a_sensor_and_over_worlds():
    rows, gaps = table1.run(OPTIONS, table1.Settings(1, ("nts", "fbe"), ("nts", "il")))
    lines = [gap.line for gap in gaps]
    assert "SPL, nts (rgbd) - fbe (rgbd), plain, easy: +0.200 (+0.200 to +0.200)" in lines
    assert "SPL, nts (rgb) - il (rgb), wayfinding, hard: +0.300 (+0.300 to +0.300)" in lines
    assert "SPL, nts (rgbd) - nts (rgb), plain, medium: +0.100 (+0.100 to +0.100)" in lines
    assert len(gaps) == 3 * 2 * 3
    for row in rows:
        assert row["spl"] == pytest.approx(OF[row["agent"]] + 0.05 - 0.1 * (row["sensor"] == "rgb"))
        assert row["spl_low"] == pytest.approx(row["spl"] - 0.05, abs=0.01)  # the worst world
        assert row["spl_high"] == pytest.approx(row["spl"] + 0.05, abs=0.01)


@pytest.mark.usefixtures("_made_up")
def test_table2_says_what_is_gained_where_a_difficulty_is_taken_away():
    rows, gains = table2.run(OPTIONS, table2.Settings(1, ("nts", "il")))
    lines = [gain.line for gain in gains]
    for agent in ("nts", "il"):
        assert f"{agent}, plain: no_stop - standard: +2.0 points (+2.0 to +2.0)" in lines
        assert f"{agent}, wayfinding: no_noise - standard: -3.0 points (-3.0 to -3.0)" in lines
    row = next(row for row in rows if row["condition"] == "no_noise")
    assert row["spl"] == pytest.approx(0.6 + 0.05 - 0.03)
    assert row["spl_low"] < row["spl"] < row["spl_high"]


def test_fig8_subtracts_the_other_agent_and_resamples_worlds(monkeypatch):
    def columns(item, options, settings):
        world = WORLDS.index(item[0])
        return {
            agent: {
                name: np.full((settings.goals, settings.episodes), share + 0.1 * world)
                for name in ("success", "spl")
            }
            for agent, share in {"nts": 0.6, "nts_no_graph": 0.5, "nts_no_score": 0.7}.items()
        }

    monkeypatch.setattr(fig8, "run_world", columns)
    monkeypatch.setattr(fig8, "for_each", in_turn)
    rows, _ = fig8.run(OPTIONS, fig8.Settings(2, 4, geometry=True))
    last = {row["agent"]: row for row in rows if row["goals"] == 4 and row["signs"] == "plain"}
    assert last["nts_no_graph"]["spl_gap"] == pytest.approx(0.1)
    assert last["nts_no_score"]["success_gap"] == pytest.approx(-0.1)
    # Worlds differ and goals do not: an interval over worlds is as wide for four goals.
    assert (last["nts"]["low"], last["nts"]["high"]) == pytest.approx((0.6, 0.8), abs=0.01)
    first = next(row for row in rows if (row["agent"], row["goals"]) == ("nts", 1))
    assert first["low"] == pytest.approx(last["nts"]["low"])
    assert first["high"] == pytest.approx(last["nts"]["high"])


def test_worlds_come_back_in_the_order_in_which_they_were_given(monkeypatch):
    monkeypatch.setattr(exploration, "for_each", in_turn)
    found = exploration.in_all_worlds(
        lambda item, *_: {("nts", item[1], ""): {"success": np.array([float(item[0])])}},
        OPTIONS,
        None,
        label="worlds",
    )
    for signs in ("plain", "wayfinding"):
        assert found["nts", signs, ""]["success"].tolist() == list(map(float, WORLDS))
        assert found["nts", signs, ""]["world"].tolist() == list(WORLDS)


@pytest.mark.parametrize("which", ["run_agent", "fig8"])
def test_every_agent_meets_the_same_noise_and_draws_from_another_stream(monkeypatch, which):
    made = []

    class Recorded(ExplorationTask):
        def __init__(self, scenes, episodes, rng, **options):
            made.append([rng.bit_generator.state["state"]["state"], options])
            super().__init__(scenes, episodes, rng, limit=3, **options)

    def recorded(name, task, sensor, rng, **options):
        made[-1].append(rng.bit_generator.state["state"]["state"])
        return explorers.make_explorer(name, task, sensor, rng, **options)

    module = exploration if which == "run_agent" else fig8
    monkeypatch.setattr(module, "ExplorationTask", Recorded)
    monkeypatch.setattr(module, "make_explorer", recorded)
    if which == "fig8":
        fig8.run_world((10_100, "plain"), OPTIONS, fig8.Settings(2, 1, geometry=True))
    else:
        world = make_world(10_100, "plain", 1, 0)
        for name in ("random", "fbe", "nts"):
            run_agent(world, name, "rgbd", geometry=True, noise=False, stops_itself=True)
        assert all(o["stops_itself"] and not o["noise"] for _, o, _ in made)
    assert len(made) == 3
    assert len({noise for noise, *_ in made}) == len({own for *_, own in made}) == 1
    assert made[0][0] != made[0][2]


def test_names_stand_for_the_agents_that_they_say(monkeypatch):
    world = make_world(10_100, "plain", 1, 0)
    task = ExplorationTask(world.scenes, world.episodes, np.random.default_rng(0))

    class Constant(TrueGeometry):
        def scores(self, sources, goals):
            return np.full((len(sources), 12), 0.25)

    kinds = {"nts": TrueGeometry(task), "nts_blind": Constant(task), "nts_masked": Constant(task)}
    monkeypatch.setattr(explorers, "shipped", lambda kind, sensor: kinds[kind])

    def make(name, **options):
        rng = np.random.default_rng(1)
        return explorers.make_explorer(name, task, "rgbd", rng, **{"geometry": False, **options})

    def scores(agent):
        seen = agent._model.embed(task.observe())
        return agent._model.scores(seen, agent._model.embed(task.goals()))

    for name in ("nts_blind", "nts_masked", "nts_paper"):  # theirs are another network's scores
        assert (scores(make(name)) == 0.25).all()
    assert not (scores(make("nts")) == 0.25).any()
    changed = {
        "nts_no_graph": ("use_graph", False),
        "nts_no_score": ("use_score", False),
    }
    usual = make("nts")._settings
    for name, (field, value) in changed.items():
        assert getattr(usual, field) != value
        assert getattr(make(name)._settings, field) == value
        assert vars(make(name)._settings) == {**vars(usual), field: value}
    rules = {
        "nts_masked": Localisation(),
        "nts_all_nodes": Localisation(all_nodes=True),
        "nts_by_odometry": Localisation(edges_by_odometry=True),
        "nts_no_ghost_nodes": Localisation(nodes_at_ghosts=False),
        "nts_paper": PAPER,
    }
    assert set(rules) == set(explorers.AS_IN_PAPER)
    for name, wanted in rules.items():
        assert vars(make(name)._settings) == {**vars(usual), "localisation": wanted}
    fine = make("nts_2m", geometry=True)._settings
    assert (fine.directions, fine.radius) == (24, 2.0)
