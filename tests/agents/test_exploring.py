"""Agents that explore, step by step: choices, missed goals, and what is left when all is known."""

from types import SimpleNamespace

import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.agents.frontier import FrontierAgent
from tutorial_lib.agents.nts import NTSAgent, NTSSettings
from tutorial_lib.agents.random_walk import RandomWalkAgent
from tutorial_lib.exploration.episodes import Episodes, draw_episodes, exploration_world
from tutorial_lib.exploration.exploring_robot import Destination, ExploringRobot
from tutorial_lib.exploration.frontier import is_frontier
from tutorial_lib.exploration.graph_update import Localisation
from tutorial_lib.exploration.grid_kernels import FREE, OCCUPIED
from tutorial_lib.exploration.labels import relative_polar
from tutorial_lib.exploration.task import ExplorationTask, explore
from tutorial_lib.exploration.true_geometry import TrueGeometry
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.worlds import scene_of

WORLD = exploration_world(10_102)


class Hall:
    """A model by odometry: every place within 2 m of a node belongs to it, and a goal that is none.

    Features are the odometry; the goal's are zeros, so that it has no place. `mirage` (2,) is where
    robots believe that they see it, from more than 1.5 m.
    """

    def __init__(self, mirage=None):
        self.mirage = mirage

    def embed(self, observations):
        rows = observations.odometry.astype(np.float32)
        return np.column_stack([rows, np.ones(len(rows), np.float32) * (rows != 0).any(axis=1)])

    def explorable(self, features):
        return np.tile(np.arange(12) % 3 == 0, (len(features), 1)).astype(float)

    def same_node(self, sources, goals):
        gaps = np.linalg.norm(sources[:, :2] - goals[:, :2], axis=1)
        near = gaps < 2.0
        is_goal = goals[:, 3] == 0
        if self.mirage is not None:
            far = np.linalg.norm(sources[:, :2] - self.mirage, axis=1)
            near = np.where(is_goal, (far > 1.5) & (far < 3.0), near)
        return np.where(is_goal & (self.mirage is None), 0.0, near.astype(float))

    def scores(self, sources, goals):
        return np.tile(np.linspace(1.0, 0.0, 12), (len(sources), 1))

    def relative(self, sources, goals):
        places = goals[:, :2].astype(float)
        if self.mirage is not None:
            places = np.where(goals[:, 3:] == 0, self.mirage, places)
        return relative_polar(sources[:, :3].astype(float), places)

    def ranges(self, observations):
        return observations.depth


def in_a_hall(side=10.0, count=1):
    scene, middle = Scene(make_box(side, side)), side / 2
    starts = np.tile([middle, middle, 0.0], (count, 1))
    episodes = Episodes(("hall",) * count, starts, starts + 1.0, np.full(count, 1.4), ("",) * count)
    return ExplorationTask({"hall": scene}, episodes, np.random.default_rng(0), noise=False)


def steps(task, agent, count):
    """Act so often; yields after each action."""
    agent.start(task.goals())
    for _ in range(count):
        task.step(agent.act(task.observe(), ~task.done))
        yield


@pytest.mark.full
def test_without_a_score_every_ghost_is_as_likely_at_every_choice():
    agent = NTSAgent(Hall(), np.random.default_rng(0), NTSSettings(use_score=False))
    task = in_a_hall()
    list(steps(task, agent, 1))
    robot = agent.robots[0]
    for _ in range(2):
        robot.memory.graph.add_node([True] * 12, None, 0, [3.0, 3.0, 0.5])
        robot.scores.append(robot.rng.random(12))
    ghosts = list(robot.memory.graph.ghosts.values())
    assert len(ghosts) > 20
    chosen = [agent._choose(robot).ghost for _ in range(200 * len(ghosts))]
    counts = np.array([chosen.count(ghost) for ghost in ghosts])
    assert counts.sum() == len(chosen)
    assert np.abs(counts - 200).max() < 4.5 * np.sqrt(200)


def test_without_a_graph_the_best_of_the_explorable_directions_is_taken():
    model = Hall()
    wanted = np.linspace(0.1, 0.2, 12)
    wanted[[5, 9]] = 0.9, 0.8  # 5 is not explorable
    model.scores = lambda sources, goals: np.tile(wanted, (len(sources), 1))
    agent = NTSAgent(model, np.random.default_rng(0), NTSSettings(use_graph=False))
    task = in_a_hall()
    list(steps(task, agent, 1))
    assert agent._targets[0] == pytest.approx([0.0, -3.0], abs=1e-6)


def test_a_frontier_is_given_up_after_a_time_that_grows_with_its_distance():
    agent, task = FrontierAgent(Hall()), in_a_hall(30.0)
    list(steps(task, agent, 1))
    metres = np.linalg.norm(agent._targets[0])
    assert abs(agent._left[0] - (40 + 12 * metres)) < 6
    sensed = agent.search.sense(task.observe(), ~task.done)
    assert not len(agent._due(sensed))
    agent._left[0] = 0.0
    assert agent._due(sensed).tolist() == [0]


@pytest.mark.parametrize("returns", [False, True])
def test_a_frontier_that_was_given_up_is_closed_but_a_place_to_return_to_is_not(returns):
    agent, task = FrontierAgent(Hall()), in_a_hall(30.0)
    list(steps(task, agent, 1))
    sensed, robot = agent.search.sense(task.observe(), ~task.done), np.array([0])
    target = agent._targets.copy()
    assert is_frontier(agent.search.maps, robot, target)[0]
    before = agent.search.maps.grids.copy()
    agent._left[0], agent._returns[0] = 0.0, returns
    assert agent._due(sensed).tolist() == [0]
    assert is_frontier(agent.search.maps, robot, target)[0] == returns
    assert (agent.search.maps.grids == before).all() == returns
    # What is no frontier any more is left as it is.
    agent._targets[0] = 0.0
    before = agent.search.maps.grids.copy()
    assert agent._due(sensed).tolist() == [0]
    assert (agent.search.maps.grids == before).all()


def test_a_missed_goal_removes_no_ghost():
    agent = NTSAgent(Hall(mirage=np.array([0.0, 2.2])), np.random.default_rng(0))
    task, missed, before, ghosts = in_a_hall(16.0), 0, False, {}
    for _ in steps(task, agent, 40):
        robot, found = agent.robots[0], bool(agent.search.found[0])
        if before and not found:
            missed += 1
            assert not robot.reached
            assert robot.memory.graph.ghosts == ghosts
            destination = robot.destination
        elif missed == 1 and robot.memory.graph.ghosts == ghosts:
            assert robot.destination == destination  # it goes on to where it was going
        before, ghosts = found, dict(robot.memory.graph.ghosts)
    assert missed >= 1
    assert ghosts


def test_time_spent_on_a_goal_is_not_spent_on_a_ghost():
    agent, task = NTSAgent(Hall(), np.random.default_rng(0)), in_a_hall(14.0)
    list(steps(task, agent, 5))
    robot = agent.robots[0]
    assert robot._waited > 0
    agent.search.found[0], agent.search.places[0] = True, (-4.0, 0.0)
    for _ in range(12):
        task.step(agent.act(task.observe(), ~task.done))
        assert agent.search.found[0]
        assert robot._waited == 0
    agent.search.found[0] = False
    task.step(agent.act(task.observe(), ~task.done))
    assert robot._waited == 1


def test_a_robot_that_pursues_its_goal_closes_no_frontier():
    agent, task = FrontierAgent(Hall()), in_a_hall(12.0)
    list(steps(task, agent, 3))
    sensed = agent.search.sense(task.observe(), ~task.done)
    agent._targets[0], agent._left[0], agent.search.left[0] = sensed.odometry[0, :2], -1.0, 0.0
    agent.search.found[0] = True
    maps = agent.search.maps.grids.copy()
    assert not len(agent._due(sensed))
    assert np.array_equal(agent.search.maps.grids, maps)
    agent._left[0] = 7.0
    agent.act(task.observe(), ~task.done)
    assert agent._left[0] == 7.0
    agent.search.found[0] = False
    agent.act(task.observe(), ~task.done)
    assert agent._left[0] != 7.0


def test_pursuing_and_missing_a_goal_paints_no_walls():
    """In an open hall there is nothing occupied until the robot comes near its walls."""
    agent = FrontierAgent(Hall(mirage=np.array([0.0, 2.2])))
    task, before, missed = in_a_hall(30.0), False, 0
    for _ in steps(task, agent, 40):
        found = bool(agent.search.found[0])
        missed += before and not found
        assert not (agent.search.maps.grids == OCCUPIED).any()
        before = found
    assert missed >= 1


def test_a_robot_that_missed_its_goal_looks_before_it_compares_frontiers():
    class Eastward:
        def score(self, crops, here, goals, frontiers, robots):
            return frontiers[:, 0]

    agent = FrontierAgent(Hall(mirage=np.array([0.0, 2.2])), scorer=Eastward())
    task, before, missed = in_a_hall(30.0), False, 0
    for _ in steps(task, agent, 40):
        found = bool(agent.search.found[0])
        missed += before and not found
        assert found or before or not np.isnan(agent._targets[0]).any()
        before = found
    assert missed >= 1


@pytest.mark.parametrize("kind", ["fbe", "nts"])
def test_once_all_is_explored_the_robot_goes_on_and_looks_again(kind):
    model = Hall()
    rng = np.random.default_rng(0)
    agent = FrontierAgent(model, rng=rng) if kind == "fbe" else NTSAgent(model, rng)
    task, looked = in_a_hall(5.0), []
    model.embed, embed = lambda seen: looked.append(len(seen)) or embed(seen), model.embed
    travelled = [task.travelled[0] for _ in steps(task, agent, 160)]
    if kind == "fbe":
        assert agent._returns[0]
        assert agent.search.maps.grids[0].ravel()[
            agent.search.maps.cells(np.array([0]), agent._targets)
        ] == [FREE]
    assert travelled[-1] - travelled[79] > 3.0
    assert sum(looked[-60:]) > 3


def test_frontier_exploration_looks_where_it_has_arrived():
    agent, task = FrontierAgent(Hall()), in_a_hall(14.0)
    list(steps(task, agent, 3))
    sensed = agent.search.sense(task.observe(), ~task.done)
    agent._left[0], agent.search.left[0] = 9.0, 5.0
    for gap, looks in ((1.0, False), (0.3, True)):
        agent._returns[0] = True
        agent._targets[0] = sensed.odometry[0, :2] + [gap, 0.0]
        assert len(agent._due(sensed)) == looks
        assert np.isnan(agent.search._looked[0]).all() == looks


@pytest.fixture(scope="module")
def scenes():
    return {WORLD: scene_of(WORLD)}


AGENTS = {
    "nts": lambda model, rng: NTSAgent(model, rng),
    "no score": lambda model, rng: NTSAgent(model, rng, NTSSettings(use_score=False)),
    "no graph": lambda model, rng: NTSAgent(
        model, rng, NTSSettings(use_graph=False, use_score=False)
    ),
    "fbe": lambda model, rng: FrontierAgent(model, rng=rng),
    "random": RandomWalkAgent,
}


@pytest.mark.parametrize("kind", AGENTS)
@pytest.mark.few(2)
def test_an_episode_does_not_depend_on_its_neighbours(kind, scenes):
    episodes = draw_episodes(WORLD, scenes[WORLD], {"hard": 4}, np.random.default_rng(5))
    paths = []
    for count in (4, 1, 2):
        task = ExplorationTask(scenes, episodes[:count], np.random.default_rng(1), limit=50)
        explore(task, AGENTS[kind](TrueGeometry(task), np.random.default_rng(2)))
        steps_taken = np.array(task.path + [task.path[-1]] * (51 - len(task.path)))
        paths.append(steps_taken)
    assert np.array_equal(paths[0][:, :1], paths[1])
    assert np.array_equal(paths[0][:, :2], paths[2])


@pytest.mark.parametrize("kind", ["nts", "fbe"])
def test_without_noise_an_agent_with_true_geometry_finds_all_that_is_near(kind, scenes):
    episodes = draw_episodes(WORLD, scenes[WORLD], {"easy": 10}, np.random.default_rng(6))
    task = ExplorationTask(scenes, episodes, np.random.default_rng(1), noise=False)
    explore(task, AGENTS[kind](TrueGeometry(task), np.random.default_rng(2)))
    assert task.success.all()
    assert task.spl.mean() > 0.9


@pytest.mark.parametrize(
    ("moved", "rules", "becomes"),
    [
        (0.8, Localisation(), False),
        (1.2, Localisation(), True),
        (1.2, Localisation(nodes_at_ghosts=False), False),
    ],
)
def test_only_a_ghost_that_was_reached_away_from_its_node_becomes_one(moved, rules, becomes):
    settings = NTSSettings(localisation=rules)
    agent, robot = NTSAgent(Hall(), np.random.default_rng(0), settings), ExploringRobot(None)
    memory = robot.memory
    memory.node = memory.graph.add_node([k == 0 for k in range(12)])
    ghost = memory.graph.ghosts[0, 0]
    robot.go_to(Destination(0, memory.graph.place_of(ghost), ghost))
    memory.move(np.array([moved, 0.0, 0.0]))
    assert agent._resolve(robot) is becomes
    assert robot.destination is None
    assert not memory.graph.ghosts
    robot.go_to(Destination(0, np.zeros(2)))  # a node again
    assert not agent._resolve(robot)


def test_by_the_papers_rule_a_reached_ghost_makes_no_node_where_the_robot_is_localised():
    """In a hall of one node that reaches 3.5 m: the ghosts, 3 m away, are all inside it."""
    nodes = []
    for rules in (Localisation(), Localisation(nodes_at_ghosts=False)):
        model = Hall()
        model.same_node = lambda sources, goals: (
            (np.linalg.norm(sources[:, :2] - goals[:, :2], axis=1) < 3.5) & (goals[:, 3] > 0)
        ).astype(float)
        agent = NTSAgent(model, np.random.default_rng(0), NTSSettings(localisation=rules))
        list(steps(in_a_hall(16.0), agent, 20))
        nodes.append(len(agent.robots[0].memory.graph))
    assert nodes == [2, 1]


def test_a_goal_is_remembered_from_the_node_that_sees_it_and_from_no_other():
    agent = NTSAgent(Hall(), np.random.default_rng(0))
    agent._model.relative = lambda sources, goals: np.column_stack([0 * sources[:, 0], sources])
    memory = SimpleNamespace(features=np.array([[1.0], [2.0]], np.float32))
    agent.robots = [SimpleNamespace(memory=memory)]
    agent.search = SimpleNamespace(goals=np.zeros((1, 1), np.float32))
    for likely, node in (([0.2, 0.6], 1), ([0.9, 0.6], 0), ([0.4, 0.49], None)):
        agent._model.same_node = lambda sources, goals, likely=likely: np.array(likely)
        found = agent._recalled(0)
        assert (None if found is None else found.node) == node
        if found is not None:
            assert found.place.tolist() == [node + 1.0, 0.0]
