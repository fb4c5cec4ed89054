"""The second visit, with a map of the first one and with an explorer behind it."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.conftest import in_turn
from tutorial_lib.agents.returning import ReturningAgent, ReturnSettings, visit
from tutorial_lib.agents.votes import agreeing, supports
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.explorers import make_explorer
from tutorial_lib.experiments.common.report import Options
from tutorial_lib.experiments.nts import second_visit
from tutorial_lib.experiments.protocols.visits import PASSED, Recorder, draw_return, learned_from
from tutorial_lib.exploration.episodes import (
    Episodes,
    draw_episodes,
    draw_sequence,
    exploration_world,
)
from tutorial_lib.exploration.task import ExplorationTask, explore, explore_on
from tutorial_lib.exploration.turned_views import turned
from tutorial_lib.geometry import wrap
from tutorial_lib.interfaces import HERE, Plan
from tutorial_lib.topology.following.transitions import State
from tutorial_lib.topology.mapping.growing_batch import GrowingBatch
from tutorial_lib.world.noise import LEFT, RIGHT, STOP
from tutorial_lib.world.worlds import scene_of

WORLD = exploration_world(10_100)
COUNTS = {"passed": 3, "elsewhere": 1}
FEW = ReturnSettings(headings=4, losses=2)


@pytest.fixture(scope="module")
def explored():
    """A world, the run of a robot in it, and its true path."""
    name, scene = WORLD, scene_of(WORLD)
    rng = np.random.default_rng(2)
    first = draw_episodes(name, scene, {"medium": 1}, rng)
    goals = draw_sequence(scene, first.goals, 3, rng)
    task = ExplorationTask({name: scene}, first, rng)
    recorder = Recorder(make_explorer("nts", task, "rgbd", rng, geometry=True))
    assert all(reached.all() for reached, _ in explore_on(task, recorder, goals))
    return name, scene, recorder.run, np.concatenate(task.path)


@pytest.fixture(scope="module")
def memory(explored):
    """What the agent of Meng 2020 learns of it."""
    return learned_from(explored[2])


@pytest.fixture(scope="module")
def trials(explored):
    """Episodes of the second visit."""
    name, scene, _, path = explored
    return draw_return(name, scene, path, COUNTS, np.random.default_rng(1))


def task_of(explored, episodes):
    name, scene, *_ = explored
    return ExplorationTask({name: scene}, episodes, np.random.default_rng(7))


def test_a_visit_shows_the_path_there_and_the_path_back(explored):
    there, back = visit(explored[2], 0)
    assert len(there.observations) == len(back.observations) < len(explored[2])
    places, reverse = (one.observations.odometry for one in (there, back))
    assert np.array_equal(places[:, :2], reverse[::-1, :2])
    assert np.allclose(np.abs(wrap(places[:, 2] - reverse[::-1, 2])), np.pi)
    assert (np.linalg.norm(np.diff(places[:, :2], axis=0), axis=1) > 0.1).all()
    assert back.timestamps[0] > there.timestamps[-1]
    assert visit(explored[2][:1], 0) == []


def test_trials_start_where_the_robot_passed_and_goals_are_there_or_nowhere_near(explored, trials):
    episodes, kinds = trials
    path = explored[3][:, None, :2]
    for places, passed in ((episodes.starts, kinds != ""), (episodes.goals, kinds == "passed")):
        gaps = np.linalg.norm(path - places[:, :2], axis=2).min(axis=0)
        assert (gaps[passed] <= PASSED).all()
        assert (gaps[~passed] >= 2.0).all()
    assert (episodes.shortest >= 3.0).all()
    nothing = explored[3][:1]
    with pytest.raises(InputError, match=r"passed no place 3\.0 m from a goal"):
        draw_return(*explored[:2], nothing, COUNTS, np.random.default_rng(1))


def test_memory_leads_to_places_that_the_robot_passed(explored, memory, trials):
    episodes, kinds = trials
    task = task_of(explored, episodes[np.flatnonzero(kinds == "passed")])
    agent = ReturningAgent(memory, settings=FEW)
    explore(task, agent)
    assert task.success.mean() > 0.6
    assert (agent.recalled > 0).all()
    assert task.spl.mean() > 0.5


@pytest.mark.full
def test_the_explorer_takes_over_where_nothing_is_remembered(explored, memory, trials):
    episodes, kinds = trials
    task = task_of(explored, episodes)
    rng = np.random.default_rng(3)
    agent = second_visit.make_method("both", memory, task, rng, geometry=True)
    explore(task, agent)
    assert task.success.all()
    assert (agent.recalled[kinds == "passed"] > 0).any()
    away = kinds == "elsewhere"
    assert agent.recalled[away].mean() < agent.recalled[~away].mean()


def test_a_robot_that_neither_remembers_nor_explores_stops(explored, memory, trials):
    episodes, kinds = trials
    task = task_of(explored, episodes[np.flatnonzero(kinds == "elsewhere")])
    explore(task, ReturningAgent(memory, settings=FEW))
    assert task.done.all()
    assert not task.success.any()
    assert (task.steps < 300).all()


def test_a_robot_that_is_done_is_left_alone(explored, memory, trials):
    episodes: Episodes = trials[0]
    task = task_of(explored, episodes)
    agent = ReturningAgent(memory, settings=FEW)
    agent.start(task.goals())
    running = np.arange(len(episodes)) % 2 == 0
    actions = agent.act(task.observe(), running)
    assert (actions[~running] == 0).all()
    assert all(agent.plans[i] is None for i in np.flatnonzero(~running))


def test_an_explorer_of_another_kind_is_refused(memory):
    with pytest.raises(InputError, match=r"explorer: .* give an NTSAgent"):
        ReturningAgent(memory, memory)


class Plans:
    """Plans as given, one for each call; then none."""

    def __init__(self, *plans):
        self.plans, self.asked = list(plans), []

    def plan(self, observation, goals, topomap, excluded=()):
        self.asked.append(set(excluded))
        return self.plans.pop(0) if self.plans else Plan(refusal="none left")


def begun(explored, memory, trials, *plans, explorer=None):
    """An agent on one trial whose planner returns `plans`, after its first action."""
    task = task_of(explored, trials[0][np.array([0])])
    planner = Plans(*plans)
    agent = ReturningAgent(
        replace(memory, planner=planner), explorer, ReturnSettings(headings=1, losses=2, pause=5)
    )
    agent._memory.topomap = memory.topomap
    # Its plans are not checked: they are the same whatever is excluded.
    agent._memory.find_path = lambda seen, goals, excluded: planner.plan(
        seen, goals, None, excluded
    )
    agent.start(task.goals())
    return task, agent, planner, agent.act(task.observe(), ~task.done)


def some_path(memory):
    return tuple(int(v) for v in memory.topomap.alive[:3])


@pytest.mark.parametrize(
    ("active", "edge"), [(0, (HERE, 0)), (1, (0, 1)), (2, (1, 2)), (3, (1, 2))]
)
def test_what_could_not_be_passed_is_excluded_from_the_next_plan(
    explored, memory, trials, active, edge
):
    path = some_path(memory)
    plan = Plan(path, 0, (0.9,) * 4)
    task, agent, planner, _ = begun(explored, memory, trials, plan, plan)
    assert agent.plans[0] is plan
    agent._aims[:] = np.nan
    agent.follower.memory.active[0] = active
    agent.follower.memory.state[0] = State.LOST
    assert agent.act(task.observe(), ~task.done) != STOP
    assert agent.plans[0] is None
    agent.act(task.observe(), ~task.done)
    source, target = (v if v == HERE else path[v] for v in edge)
    assert (source, target) in planner.asked[-1]
    assert agent.plans[0] is plan


def test_after_so_many_losses_a_robot_alone_stops(explored, memory, trials):
    plan = Plan(some_path(memory), 0, (0.9,) * 4)
    task, agent, planner, _ = begun(explored, memory, trials, *[plan] * 9)
    actions = []
    while not actions or actions[-1] != STOP:
        if agent.plans[0] is not None:
            agent._aims[:] = np.nan
            agent.follower.memory.state[0] = State.LOST
        actions += list(agent.act(task.observe(), ~task.done))
        assert len(actions) < 20
    assert len(planner.asked) == FEW.losses
    assert actions[-2] == LEFT


def test_only_without_an_explorer_the_map_says_when_a_robot_has_arrived(explored, memory, trials):
    plan = Plan(some_path(memory), 0, (0.9,) * 4)
    for explorer in (None, "nts"):
        task = task_of(explored, trials[0][np.array([0])])
        made = explorer and make_explorer(
            explorer, task, "rgbd", np.random.default_rng(0), geometry=True
        )
        task, agent, _, _ = begun(explored, memory, trials, plan, explorer=made)
        agent._aims[:] = np.nan
        agent.follower.memory.state[0] = State.DONE
        action = agent.act(task.observe(), ~task.done)
        assert (action == STOP) == (explorer is None)
        assert (agent.plans[0] is None) == (explorer is not None)


def test_a_robot_faces_the_view_in_which_its_path_begins_and_turns_where_the_map_does(
    explored, memory, trials
):
    plan = Plan(some_path(memory), 0, (0.9,) * 4)
    task, agent, _, _ = begun(explored, memory, trials, plan)
    for aside, action in ((0.5, LEFT), (-0.5, RIGHT)):
        agent._aims[0] = task.odometry[0, 2] + aside
        assert agent.act(task.observe(), ~task.done) == action
    for angle, action in ((2.0, LEFT), (-2.0, RIGHT)):
        agent._aims[:] = np.nan
        agent._turns[0] = {1: angle}
        agent.follower.memory.active[0], agent.follower.memory.state[0] = 1, State.TURN
        agent.follower.act = lambda seen, robots: None
        assert agent.act(task.observe(), ~task.done) == action
    for _ in range(agent._settings.turning + 1):
        agent.act(task.observe(), ~task.done)
        agent._aims[:] = np.nan
    assert agent.plans[0] is None


def test_a_robot_may_turn_for_long_at_each_turn_of_its_path(explored, memory, trials):
    """At two turns of one path, and on the next path after one on which it was lost."""
    plan = Plan(some_path(memory), 0, (0.9,) * 4)
    task, agent, _, _ = begun(explored, memory, trials, plan, plan)
    memory = agent.follower.memory
    memory.waypoints[0] = 1.0, 0.0
    seen, robots = turned(task.observe(), 0.0), np.array([0])
    for state, actions in ((State.TURN, 30), (State.FOLLOW, 1), (State.TURN, 41)):
        agent.follower.act = lambda seen, robots, state=state: memory.state.fill(state)
        for _ in range(actions):
            assert agent.plans[0] is plan
            agent._go_on(seen, robots)
    assert agent.plans[0] is None
    agent.act(task.observe(), ~task.done)
    for _ in range(39):
        assert agent.plans[0] is plan
        agent._go_on(seen, robots)


def test_a_place_is_where_several_views_agree():
    view = np.array([0, 1, 2, 0])
    places = np.array([[0.0, 0.0], [0.5, 0.0], [0.4, 0.3], [8.0, 0.0]])
    weights = np.array([0.7, 0.8, 0.9, 0.99])
    same = supports(view, places, np.zeros(4), weights)
    assert same == pytest.approx([2.4, 2.4, 2.4, 0.99])
    turned_away = supports(view, places, np.array([0.0, 2.0, 0.1, 0.0]), weights)
    assert turned_away == pytest.approx([1.6, 0.8, 1.6, 0.99])


def test_of_a_view_s_votes_only_the_best_one_supports_a_place():
    places = np.array([[0.0, 0.0], [0.3, 0.0], [0.6, 0.0]])
    same = supports(np.array([0, 0, 1]), places, np.zeros(3), np.array([0.7, 0.9, 0.8]))
    assert same == pytest.approx([1.7, 1.7, 1.7])


class _Rows:
    """Observations of vertices, of which only the odometry counts."""

    def __init__(self, odometry):
        self.odometry = np.asarray(odometry, float)

    def __getitem__(self, rows):
        return _Rows(self.odometry[rows])


def test_votes_turn_each_view_back_into_the_robot_s_frame():
    """Vertex i looks along headings[i], and is seen in view i: all say the robot looks along 0."""

    class Map:
        headings = np.array([0.0, np.pi / 2, np.pi])
        vertices = SimpleNamespace(
            into=lambda views, view, vertices: np.where(vertices == 3, 0.9, 0.8),
            observations=_Rows([[0, 0, 0], [0, 0, np.pi / 2], [0, 0, np.pi], [9, 0, 0]]),
        )

        def __len__(self):
            return 4

        def nearby(self, views, candidates):
            return np.array([[0, 3], [1, 3], [2, 3]])

    found = agreeing(Map(), None, Map.headings)
    assert found == [{0}, {1}, {2}]


def test_a_robot_that_no_view_is_sure_of_is_nowhere():
    class Map(list):
        vertices = SimpleNamespace(
            into=lambda views, view, vertices: np.full(len(vertices), 0.3),
            observations=GrowingBatch(),
        )

        def nearby(self, views, candidates):
            return np.array([[0], [0]])

    assert agreeing(Map([0]), None, np.zeros(2)) == [set(), set()]


def test_the_gain_is_of_both_over_the_other_method():
    worlds = np.repeat([1, 2], 3)
    columns = {"world": worlds, "goals": np.full(6, PASSED)}
    for method, success in (("both", 1.0), ("memory", 0.5), ("explorer", 0.25)):
        columns[f"success_{method}"] = np.full(6, success)
        columns |= {f"{name}_{method}": np.zeros(6) for name in ("spl", "steps", "recalled")}
    rows = {m: second_visit._row(columns, m, "plain", "all") for m in ("memory", "explorer")}
    assert rows["memory"]["gain"] == pytest.approx(0.5)
    assert rows["explorer"]["gain"] == pytest.approx(0.75)


def test_all_methods_meet_the_same_noise(monkeypatch):
    states = []

    class Recorded(ExplorationTask):
        def __init__(self, scenes, episodes, rng, **options):
            states.append(rng.bit_generator.state["state"]["state"])
            super().__init__(scenes, episodes, rng, limit=3, **options)

    monkeypatch.setattr(second_visit, "ExplorationTask", Recorded)
    monkeypatch.setattr(second_visit, "learned_from", lambda run: SimpleNamespace(topomap=[0]))
    monkeypatch.setattr(
        second_visit,
        "draw_return",
        lambda name, scene, path, counts, rng: (
            draw_episodes(name, scene, {"easy": 1}, np.random.default_rng(0)),
            np.array(["passed"]),
        ),
    )
    monkeypatch.setattr(second_visit, "make_method", lambda *_, **__: Still())
    settings = second_visit.Settings(1, 1, geometry=True)
    second_visit.run_world((10_100, "plain"), Options(worlds=(10_100,)), settings)
    assert len(states) == 1 + len(second_visit.METHODS)
    assert len(set(states[1:])) == 1


class Still:
    """An agent that stops at once."""

    def start(self, goals):
        pass

    def act(self, observations, running):
        return np.full(len(running), STOP)


@pytest.mark.full
def test_the_experiment_compares_three_methods_on_the_same_trials(monkeypatch):
    monkeypatch.setattr(second_visit, "for_each", in_turn)
    settings = second_visit.Settings(3, 1, geometry=True)
    rows, notes = second_visit.run(Options(worlds=(10_100,)), settings)
    keys = [(row["method"], row["signs"], row["goals"]) for row in rows]
    assert len(set(keys)) == len(keys) == 3 * 2 * 3
    for row in rows:
        assert row["trials"] == (2 if row["goals"] == "all" else 1)
        assert (row["gain"] is None) == (row["method"] == "both")
        assert (row["recalled"] is None) == (row["method"] == "explorer")
    assert "actions" in notes[0]
