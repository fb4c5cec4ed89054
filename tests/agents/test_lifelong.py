"""A robot's life in a building: walls correct it, it recalls every look, and notices a carry."""

import numpy as np
import pytest

from tutorial_lib.agents.frontier import FrontierAgent
from tutorial_lib.agents.lifelong import LifelongAgent, LifelongSettings
from tutorial_lib.agents.lifelong.islands import Island, Islands
from tutorial_lib.agents.looks import Looks, not_at
from tutorial_lib.agents.scan_corrected import ScanCorrected
from tutorial_lib.agents.track import Track
from tutorial_lib.agents.walls import goes_on, match_walls
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.race.runners import Forgetting
from tutorial_lib.exploration.episodes import Episodes, draw_sequence, exploration_world
from tutorial_lib.exploration.ghost_graph import GhostGraph
from tutorial_lib.exploration.graph_update import GraphUpdate, Memory
from tutorial_lib.exploration.labels import panorama_ranges
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.exploration.true_geometry import TrueGeometry
from tutorial_lib.se2 import relative, wrap
from tutorial_lib.world.worlds import scene_of

WORLD = exploration_world(10_100)
SCENE = scene_of(WORLD)


def pairs(count, rng, metres=0.8):
    """Poses (2, N, 3) near each other, in sight, headings drawn."""
    paths = GridPaths(SCENE.clearance)
    free = paths.points[paths.largest & (paths.clearance > 0.4)]
    first = free[rng.integers(len(free), size=count)]
    gaps = np.linalg.norm(free[:, None] - first, axis=2)
    second = np.array([free[rng.choice(np.flatnonzero(gap < metres))] for gap in gaps.T])
    turned = rng.uniform(-np.pi, np.pi, (2, count, 1))
    return np.concatenate([np.stack([first, second]), turned], axis=2)


def ranges_at(poses):
    return panorama_ranges(SCENE, poses)


def test_walls_say_where_a_robot_is_in_a_node_whatever_its_odometry_says_of_its_heading():
    rng = np.random.default_rng(0)
    nodes, robots = pairs(200, rng)
    true = relative(nodes, robots)
    guesses = true + np.column_stack([rng.normal(0, 0.3, (200, 2)), rng.uniform(-2.5, 2.5, 200)])
    found = match_walls(ranges_at(nodes), ranges_at(robots), guesses)
    accepted = np.isfinite(found[:, 0])
    gaps = relative(true[accepted], found[accepted])
    right = (np.hypot(gaps[:, 0], gaps[:, 1]) < 0.3) & (np.abs(gaps[:, 2]) < np.deg2rad(10))
    assert accepted.mean() > 0.6
    assert right.mean() > 0.95


def test_what_is_seen_goes_on_as_a_robot_moves_and_does_not_where_it_was_carried():
    rng = np.random.default_rng(1)
    before, after = pairs(200, rng, metres=0.6)
    motions = relative(before, after) + rng.normal(0, [0.03, 0.03, 0.03], (200, 3))
    assert np.quantile(goes_on(ranges_at(before), ranges_at(after), motions), 0.02) > 0.75
    elsewhere = after[rng.permutation(200)]
    far = np.linalg.norm(elsewhere[:, :2] - after[:, :2], axis=1) > 1.5
    shares = goes_on(ranges_at(before[far]), ranges_at(elsewhere[far]), motions[far])
    assert (shares < 0.75).mean() > 0.95


def life(maker, visits=3, carried=(), count=4, noise=True):
    """Success (V, N) of visits, and the agent."""
    rng = np.random.default_rng(4)
    paths = GridPaths(SCENE.clearance)
    free = paths.points[paths.largest]
    places = free[rng.integers(len(free), size=count)]
    first = np.column_stack([places, rng.uniform(-np.pi, np.pi, count)])
    goals = draw_sequence(SCENE, first, visits + 1, rng, (3.0, 8.0))[1:]
    lengths = paths.between(first[:, :2], goals[0][:, :2])
    episodes = Episodes((WORLD,) * count, first, goals[0], lengths, ("",) * count)
    task = ExplorationTask({WORLD: SCENE}, episodes, rng, noise=noise)
    agent, found = maker(TrueGeometry(task)), []
    agent.start(task.goals())
    for visit, poses in enumerate(goals):
        if visit in carried:
            task.carry(goals[visit - 2])
        if visit:
            task.next_goals(poses)
            agent.look_for(task.goals())
        while not task.done.all():
            task.step(agent.act(task.observe(), ~task.done))
        found.append(task.success)
    return np.array(found), agent


def lifelong(**changed):
    return lambda model: LifelongAgent(model, np.random.default_rng(0), LifelongSettings(**changed))


@pytest.mark.full
def test_a_robot_that_is_not_carried_has_one_graph_and_one_that_is_joins_two():
    success, agent = life(lifelong())
    assert success.mean() > 0.7
    assert not any(islands.left for islands in agent.islands)
    count = [len(robot.memory.graph) for robot in agent.robots]
    _, carried = life(lifelong(), carried=(2,))
    joined = [not islands.left for islands in carried.islands]
    assert np.mean(joined) >= 0.75
    grown = [len(robot.memory.graph) for robot in carried.robots]
    assert all(
        now >= before // 2 for now, before, one in zip(grown, count, joined, strict=True) if one
    )
    for robot, looks in zip(carried.robots, carried.looks, strict=True):
        assert len(robot.scores) == len(robot.memory.features) == len(robot.memory.graph)
        assert len(looks) >= len(robot.memory.graph)


@pytest.mark.full
def test_a_robot_that_does_not_relocate_begins_no_other_graph():
    _, agent = life(lifelong(relocates=False), carried=(2,))
    assert not any(islands.left for islands in agent.islands)


def test_a_goal_that_was_passed_is_recalled_from_a_look_that_no_node_has():
    looks, model = Looks(), ByPlace()
    looks.keep(np.zeros(3), np.array([0.0], np.float32))
    looks.keep(np.array([0.5, 0.0, np.pi / 2]), np.array([4.0], np.float32))
    places = looks.places(model, np.array([4.5], np.float32), 0.5)
    assert np.allclose(places, [[0.5, 0.5]])  # ahead of the look, which looked left
    assert not len(looks.places(model, np.array([9.0], np.float32), 0.5))
    assert not len(not_at(places, np.array([0.5, 0.4])))
    assert len(not_at(places, np.array([3.0, 0.4]))) == 1
    whole = Looks()
    whole.absorb(looks, np.array([1.0, 0.0, np.pi / 2]))
    assert np.allclose(whole.places(model, np.array([4.5], np.float32), 0.5), [[0.5, 0.5]])


class ByPlace:
    """A model of a corridor: features are places along it."""

    def same_node(self, sources, goals):
        return (np.abs(sources - goals)[:, 0] < 1.0).astype(float)

    def relative(self, sources, goals):
        return np.column_stack([np.zeros(len(sources)), np.abs(goals - sources)[:, 0]])

    def explorable(self, features):
        return np.tile(np.arange(12) == 0, (len(features), 1)).astype(float)


def walked(poses):
    """A graph with a node at each of these poses, its looks and its track."""
    memory, looks, track = Memory(), Looks(), Track()
    update = GraphUpdate(ByPlace(), 0.5, 0.5)
    for number, pose in enumerate(poses):
        track.move(relative(poses[0], pose))
        memory.move(track.pose)
        features = np.array([[10.0 * number]], np.float32)
        update.add_nodes([memory], features, ranges_at(pose[None]))
        looks.keep(track.pose, features[0])
        track.correct(ranges_at(pose[None])[0])
    return Island(memory, looks, [np.zeros(12) for _ in poses], track)


def test_graphs_are_joined_where_two_looks_agree_and_keep_their_geometry():
    rng = np.random.default_rng(3)
    old, new = pairs(3, rng)[0], pairs(2, rng)[0]
    left, here = walked(old), walked(new)
    islands = Islands(ByPlace(), 0.5)
    islands.leave(left)
    seen, features = ranges_at(old[2:])[0], np.array([20.2], np.float32)  # where it is in truth
    assert islands.recognise(here.track.pose, seen, features) is None  # one look is not enough
    found = islands.recognise(here.track.pose, seen, features)
    assert (found.island, found.node) == (0, 2)
    joined = islands.join(found, here)
    assert not islands.left
    assert len(joined.memory.graph) == len(joined.scores) == len(joined.memory.features) == 5
    assert len(joined.looks) == 5
    # Within either graph nothing has moved, and the robot is where it was recognised.
    poses = joined.memory.graph.poses_from(2)
    assert np.allclose(relative(poses[3], poses[4]), relative(new[0], new[1]))
    assert np.allclose(relative(poses[0], poses[1]), relative(old[0], old[1]))
    frame = np.array([joined.memory.pose_of(node) for node in range(5)])
    assert np.allclose(frame[:3, :2], relative(old[0], old)[:, :2])
    assert np.abs(frame[4, :2] - relative(old[0], old[2])[:2]).max() < 0.1
    assert np.allclose(joined.looks.poses[4], joined.track.pose)
    assert np.allclose(joined.memory.offset, found.pose)


def test_a_graph_that_is_absorbed_keeps_its_ghosts_under_other_numbers():
    first, second = GhostGraph(), GhostGraph()
    first.add_node([True, *[False] * 11])
    second.add_node([*[False] * 3, True, *[False] * 8])
    assert first.absorb(second, 0, 0, [8.0, 0.0, np.pi]) == 1
    assert first.ghosts.keys() == {(1, 3)}  # the other stands where the first's ghost was
    assert np.allclose(first.edges[0][1], [8.0, 0.0, np.pi])
    assert np.allclose(first.metres_from(0), [0.0, 8.0])


def test_a_robot_that_closes_loops_knows_its_heading_where_odometry_does_not():
    """Odometry turns with every step; nodes passed again say where the robot really is."""

    truth, pose = pairs(1, np.random.default_rng(6), 0.5)[:, 0]
    features = np.zeros((1, 1), np.float32)

    def headings(matcher):
        update, memory = GraphUpdate(ByPlace(), 0.5, 0.5, matcher=matcher), Memory()
        update.update([memory], features, ranges_at(truth[None]))
        memory.move(np.add(relative(truth, pose), [0.2, 0.0, 0.6]))
        update.update([memory], features, ranges_at(pose[None]))
        return abs(wrap(memory.offset[2] - relative(truth, pose)[2]))

    assert headings(None) > 0.5
    assert headings(match_walls) < 0.1


def task_at(pose):
    episodes = Episodes((WORLD,), pose[None], pose[None], np.array([1.0]), ("",))
    return ExplorationTask({WORLD: SCENE}, episodes, np.random.default_rng(0))


def test_corrected_odometry_is_nearer_to_the_truth():
    seen = []

    class Spy(FrontierAgent):
        def act(self, observations, running):
            seen.append(observations.odometry.copy())
            return super().act(observations, running)

    def off(wrapped):
        seen.clear()
        rng = np.random.default_rng(5)
        task, errors = task_at(pairs(1, rng)[0, 0]), []
        task._limit = 400
        agent = Spy(TrueGeometry(task))
        agent = ScanCorrected(agent) if wrapped else agent
        agent.start(task.goals())
        start = task.poses[0].copy()
        for step in range(240):
            task.done[:] = False
            agent.act(task.observe(), ~task.done)
            true = relative(start, task.poses[0])
            errors.append(abs(wrap(seen[-1][0, 2] - true[2])))
            task.step(np.array([2 if step % 40 < 36 else 1]))  # it spins, and so it drifts
        return float(np.mean(errors[120:]))

    assert off(wrapped=True) < 0.5 * off(wrapped=False)


def test_an_agent_that_forgets_begins_anew_with_each_goal():
    started = []

    class Agent:
        def start(self, goals):
            started.append(goals)

        def act(self, observations, running):
            return running

    agent = Forgetting(Agent())
    agent.start("first")
    agent.look_for("second")
    assert started == ["first", "second"]


def test_a_carry_needs_a_pose_for_every_robot():
    task = task_at(pairs(1, np.random.default_rng(0))[0, 0])
    with pytest.raises(InputError, match="poses"):
        task.carry(np.zeros((2, 3)))
