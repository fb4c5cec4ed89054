"""Agents that explore: whole episodes with the true geometry in place of the network."""

import gc
from functools import cache

import numpy as np
import pytest

from tests.made_up_maps import numbered
from tutorial_lib.agents.frontier import FrontierAgent
from tutorial_lib.agents.imitation import ImitationAgent
from tutorial_lib.agents.nts import NTSAgent, NTSSettings
from tutorial_lib.agents.oracle_explorer import OracleExplorer
from tutorial_lib.agents.random_walk import RandomWalkAgent
from tutorial_lib.errors import InputError
from tutorial_lib.exploration.episodes import (
    Episodes,
    draw_episodes,
    draw_sequence,
    exploration_world,
)
from tutorial_lib.exploration.other_scores import HistogramScores, RandomScores, ScoresOf
from tutorial_lib.exploration.task import ExplorationTask, explore, explore_on
from tutorial_lib.exploration.true_geometry import TrueGeometry
from tutorial_lib.geometry import to_world
from tutorial_lib.interfaces import ExplorationModel, ExplorerAgent
from tutorial_lib.world.noise import FORWARD, STOP
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.worlds import scene_of

COUNTS = {"easy": 3, "medium": 3, "hard": 3}


@pytest.fixture(scope="module")
def scenes():
    return {name: scene_of(name) for name in (exploration_world(s) for s in (10_100, 10_102))}


@pytest.fixture(scope="module")
def episodes(scenes):
    rng = np.random.default_rng(8)
    return Episodes.joined([draw_episodes(n, s, COUNTS, rng) for n, s in scenes.items()])


def make(name, task):
    rng, model = np.random.default_rng(2), TrueGeometry(task)
    return {
        "nts": lambda: NTSAgent(model, rng),
        "no graph": lambda: NTSAgent(model, rng, NTSSettings(use_graph=False)),
        "no score": lambda: NTSAgent(model, rng, NTSSettings(use_score=False)),
        "histogram": lambda: NTSAgent(HistogramScores(model), rng),
        "chance": lambda: NTSAgent(RandomScores(model, np.random.default_rng(3)), rng),
        "fbe": lambda: FrontierAgent(model),
        "random": lambda: RandomWalkAgent(model, rng),
        "oracle": lambda: OracleExplorer(task),
    }[name]()


def run(name, scenes, episodes, *, noise=True, limit=500):
    task = ExplorationTask(scenes, episodes, np.random.default_rng(1), noise=noise, limit=limit)
    agent = make(name, task)
    assert isinstance(agent, ExplorerAgent)
    explore(task, agent)
    return task, agent


@pytest.fixture(scope="module")
def ran(scenes, episodes):
    """Task and agent after all episodes by a kind of agent; each kind explores once."""
    return cache(lambda name: run(name, scenes, episodes))


@pytest.mark.parametrize("noise", [True, False])
@pytest.mark.full
def test_with_true_geometry_the_paper_s_agent_hardly_fails(scenes, episodes, ran, noise):
    task, agent = ran("nts") if noise else run("nts", scenes, episodes, noise=False)
    assert task.success.mean() >= 0.94
    assert task.spl.mean() >= 0.85
    assert task.collisions.mean() < 1.0
    for robot in agent.robots:
        graph = robot.memory.graph
        assert len(robot.scores) == len(robot.memory.features) == len(graph) > 0
        for node, around in enumerate(graph.edges):
            assert len(graph) == 1 or around
            for pose in around.values():
                direction = int(np.rint(np.arctan2(pose[1], pose[0]) / (np.pi / 6))) % 12
                assert (node, direction) not in graph.ghosts


@pytest.mark.full
def test_scores_pay_and_the_oracle_is_above_all(ran):
    spl = {name: ran(name)[0].spl.mean() for name in ("oracle", "nts", "no score", "fbe", "random")}
    assert spl["oracle"] > 0.95
    assert spl["oracle"] >= spl["nts"] > spl["no score"]
    assert spl["nts"] > spl["fbe"] > spl["random"]


@pytest.mark.parametrize(
    "name",
    [
        *("no graph", "no score", "fbe"),
        *(pytest.param(name, marks=pytest.mark.full) for name in ("histogram", "chance")),
    ],
)
@pytest.mark.few(2)
def test_every_variant_explores_and_every_episode_ends(name, ran):
    task, _ = ran(name)
    assert task.done.all()
    assert task.success.mean() >= 0.6


@pytest.mark.parametrize("name", ["nts", "no score", "fbe", "random"])
def test_the_same_seeds_give_the_same_actions(name, scenes, episodes):
    first, again = (run(name, scenes, episodes[:4], limit=40)[0] for _ in range(2))
    assert np.array(first.path).tobytes() == np.array(again.path).tobytes()


def reachable(thing):
    """All objects that can be reached from one by references, but for modules and classes."""
    seen, waiting = {}, [thing]
    while waiting:
        one = waiting.pop()
        if id(one) in seen or isinstance(one, type) or type(one).__name__ == "module":
            continue
        seen[id(one)] = one
        if type(one).__name__ not in ("function", "builtin_function_or_method"):
            waiting += gc.get_referents(one)
    return seen.values()


class Stranger:
    """A model of which nothing leads to the world."""

    def embed(self, observations):
        return np.zeros((len(observations), 2), np.float32)

    def explorable(self, features):
        return np.ones((len(features), 12))

    def same_node(self, sources, goals):
        return np.zeros(len(sources))

    def scores(self, sources, goals):
        return np.tile(np.arange(12) / 12, (len(sources), 1))

    def relative(self, sources, goals):
        return np.ones((len(sources), 2))

    def ranges(self, observations):
        return observations.depth


@pytest.mark.parametrize("kind", ["nts", "fbe", "random"])
def test_no_agent_can_reach_poses_or_plans(kind, scenes, episodes):
    rng, model = np.random.default_rng(0), Stranger()
    agents = {
        "nts": NTSAgent(model, rng),
        "fbe": FrontierAgent(model),
        "random": RandomWalkAgent(model, rng),
    }
    task = ExplorationTask(scenes, episodes[:3], np.random.default_rng(1))
    agent = agents[kind]
    agent.start(task.goals())
    for _ in range(30):
        task.step(agent.act(task.observe(), ~task.done))
    things = list(reachable(agent))
    assert not any(isinstance(thing, Scene | ExplorationTask | Episodes) for thing in things)
    arrays = [thing for thing in things if isinstance(thing, np.ndarray)]
    assert len(arrays) > 5
    secrets = (task.poses, task.goal_poses, episodes.starts)
    assert not any(np.shares_memory(a, secret) for a in arrays for secret in secrets)
    # An oracle does, and is named so.
    assert any(thing is task for thing in reachable(OracleExplorer(task)))
    assert any(thing is task for thing in reachable(TrueGeometry(task)))


def test_where_nothing_is_localised_there_is_a_node_at_every_look(scenes, episodes):
    task = ExplorationTask(scenes, episodes[:2], np.random.default_rng(1), limit=60)
    agent = NTSAgent(Stranger(), np.random.default_rng(0))
    explore(task, agent)
    assert all(len(robot.memory.graph) > 3 for robot in agent.robots)
    assert not task.success.any()


@pytest.mark.full
def test_an_agent_goes_on_to_more_goals(scenes):
    name, scene = next(iter(scenes.items()))
    rng = np.random.default_rng(0)
    episodes = draw_episodes(name, scene, {"medium": 6}, rng)
    goals = draw_sequence(scene, episodes.goals, 4, rng)
    task = ExplorationTask(scenes, episodes, np.random.default_rng(1))
    found = list(explore_on(task, make("no score", task), goals))
    assert len(found) == 4
    assert np.mean([success.mean() for success, _ in found[2:]]) > 0.7
    with pytest.raises(InputError, match="a RandomWalkAgent has no look_for"):
        next(explore_on(task, make("random", task), goals))


def test_what_is_remembered_is_scored_for_the_next_goal_of_each_robot(scenes, episodes):
    task = ExplorationTask(scenes, episodes[[0, 3]], np.random.default_rng(1), noise=False)
    model = TrueGeometry(task)
    agent = NTSAgent(model, np.random.default_rng(2))
    agent.start(task.goals())
    for _ in range(40):
        task.step(agent.act(task.observe(), ~task.done))
    before = [np.array(robot.scores) for robot in agent.robots]
    task.next_goals(episodes.goals[[1, 4]])
    agent.look_for(task.goals())
    goals = model.embed(task.goals())
    for robot, old, goal in zip(agent.robots, before, goals, strict=True):
        nodes = np.array(robot.memory.features)
        expected = model.scores(nodes, np.repeat(goal[None], len(nodes), axis=0))
        assert np.array_equal(robot.scores, expected)
        assert not np.allclose(robot.scores, old)


def test_a_model_with_other_directions_than_the_agent_is_refused(scenes, episodes):
    task = ExplorationTask(scenes, episodes[:2], np.random.default_rng(1))
    fine = TrueGeometry(task, directions=24, radius=2.0)
    for model, settings in (
        (fine, NTSSettings()),
        (TrueGeometry(task), NTSSettings(directions=24, radius=2.0)),
        (fine, NTSSettings(use_graph=False)),
    ):
        agent = NTSAgent(model, np.random.default_rng(2), settings)
        agent.start(task.goals())
        with pytest.raises(InputError, match="directions: "):
            agent.act(task.observe(), ~task.done)


def test_a_goal_that_was_passed_is_remembered(scenes, episodes):
    task = ExplorationTask(scenes, episodes[:1], np.random.default_rng(1), noise=False)
    agent = make("nts", task)
    agent.start(task.goals())
    for _ in range(30):
        task.step(agent.act(task.observe(), ~task.done))
    back = task.path[0] + [0.0, 0.0, 1.0]  # the place of the first node, seen another way round
    task.next_goals(back)
    agent.look_for(task.goals())
    going = agent.robots[0].destination
    assert going.ghost is None
    place = to_world(agent.robots[0].memory.graph.poses_from(0)[going.node], going.place)
    assert np.linalg.norm(place) < 0.1


def test_the_frontier_of_the_highest_score_is_chosen(scenes, episodes):
    asked = []

    class Eastward:
        def score(self, crops, here, goals, frontiers, robots):
            asked.append((frontiers, robots))
            return frontiers[:, 0]

    task = ExplorationTask(scenes, episodes[:6], np.random.default_rng(1), noise=False)
    agent = FrontierAgent(Stranger(), scorer=Eastward())
    agent.start(task.goals())
    agent.act(task.observe(), ~task.done)
    ((frontiers, robots),) = asked
    assert np.bincount(robots).max() > 1
    for robot in np.unique(robots):
        mine = frontiers[robots == robot]
        assert np.allclose(agent._targets[robot], mine[mine[:, 0].argmax(), :2])


def test_an_imitating_agent_does_what_its_policy_says():
    class Policy:
        def start(self, goals):
            return np.zeros(len(goals))

        def act(self, observations, state):
            return np.full(len(observations), FORWARD), state + 1

    agent = ImitationAgent(Policy())
    agent.start(numbered([0, 1]))
    for _ in range(3):
        assert agent.act(numbered([0, 1]), np.array([True, False])).tolist() == [FORWARD, STOP]
    assert agent._state.tolist() == [3, 3]


def test_other_scores_change_nothing_but_the_scores(scenes, episodes):
    task = ExplorationTask(scenes, episodes, np.random.default_rng(1))
    model = TrueGeometry(task)
    seen, goals = task.observe(), task.goals()
    here, there = model.embed(seen), model.embed(goals)
    other = ScoresOf(model, HistogramScores(model))
    for wrapped in (HistogramScores(model), RandomScores(model, np.random.default_rng(0)), other):
        assert isinstance(wrapped, ExplorationModel)
        source, goal = wrapped.embed(seen), wrapped.embed(goals)
        assert np.array_equal(wrapped.same_node(source, goal), model.same_node(here, there))
        assert np.array_equal(wrapped.relative(source, goal), model.relative(here, there))
        assert np.array_equal(wrapped.explorable(source), model.explorable(here))
        scores = wrapped.scores(source, goal)
        assert scores.shape == (18, 12)
        assert ((scores >= 0) & (scores <= 1 + 1e-6)).all()
    histogram = HistogramScores(model)
    same = histogram.embed(goals)
    assert np.allclose(histogram.scores(same, same), 1.0, atol=1e-5)
    assert np.allclose(
        other.scores(other.embed(seen), other.embed(goals)),
        histogram.scores(histogram.embed(seen), same),
    )
