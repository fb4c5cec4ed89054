"""Table II: buildings, trials, how they end, agents of the user, and the comparison."""

import json
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from tests.conftest import in_turn, make_box, needs
from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.agents.oracle import OracleNavigation
from tutorial_lib.cli import main
from tutorial_lib.driving.data.demonstrations import SHORTEST
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.driving.metrics import REACHED
from tutorial_lib.driving.rollouts import STUCK
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.common.own import guarded
from tutorial_lib.experiments.common.report import Options
from tutorial_lib.experiments.meng2020 import table2
from tutorial_lib.experiments.protocols import drives as drive_choices
from tutorial_lib.experiments.protocols import navigation
from tutorial_lib.experiments.protocols.navigation import (
    GRACE,
    NEAR,
    TIMES,
    attempt,
    edge_lengths,
    experiences,
    goals_of,
    navigate,
    vertex_poses,
)
from tutorial_lib.experiments.protocols.navigation_tasks import (
    ROOMY,
    Trials,
    draw_trials,
    facing,
    make_building,
    spread_places,
)
from tutorial_lib.experiments.protocols.thresholds import Thresholds
from tutorial_lib.interfaces import Agent, Experience, Navigation
from tutorial_lib.learning.estimators import ReachabilityNetwork, WaypointNetwork
from tutorial_lib.learning.networks import Architecture, LocalNetwork
from tutorial_lib.learning.threads import use_threads
from tutorial_lib.learning.views import VIEWS
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.placing import is_free
from tutorial_lib.world.plan_json import save_plan
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera
from tutorial_lib.world.simulation import STEP, Simulation

use_threads(1)
PILLARS = [(3.0, 3.0, 0.5), (6.5, 4.0, 0.3), (5.0, 7.5, 0.8)]
networks = needs("waypoint_k5", "reach_k5", "sptm")


@pytest.fixture(scope="module")
def plan(tmp_path_factory):
    """A file with a room with pillars."""
    path = tmp_path_factory.mktemp("plans") / "room.json"
    save_plan(make_box(pillars=PILLARS), path)
    return path


@pytest.fixture(scope="module")
def building(plan):
    return make_building(plan, seed=0, count=3)


@pytest.fixture(scope="module")
def trials(building):
    return draw_trials(building, 10, np.random.default_rng(1))


# Buildings.


def test_a_building_has_a_trajectory_for_every_ordered_pair_of_places(building):
    assert building.name == "room.json"
    pairs = [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)]
    assert [tuple(pair) for pair in building.pairs.tolist()] == pairs
    for (start, goal), drive in zip(building.pairs, building.recorded.trajectories, strict=True):
        assert len(drive) >= SHORTEST
        assert np.linalg.norm(drive.poses[0, :2] - building.places[start]) < 0.3
        assert np.linalg.norm(drive.poses[-1, :2] - building.places[goal]) < REACHED + 0.1
        # It starts in the direction of its path.
        far = np.linalg.norm(drive.poses[:, :2] - drive.poses[0, :2], axis=1)
        ahead = drive.poses[np.argmax(far > 1.0), :2] - drive.poses[0, :2]
        heading = drive.poses[0, 2]
        assert np.array([np.cos(heading), np.sin(heading)]) @ ahead > 0.8


def test_the_same_seed_gives_the_same_building(building, plan):
    again, other = make_building(plan, seed=0, count=3), make_building(plan, seed=5, count=3)
    assert (again.places == building.places).all()
    assert (again.recorded.poses == building.recorded.poses).all()
    assert (
        other.recorded.poses.shape != building.recorded.poses.shape
        or (other.recorded.poses != building.recorded.poses).any()
    )


@pytest.mark.parametrize("seed", [0, 1])
def test_each_place_is_as_far_from_those_before_as_can_be(seed):
    paths = GridPaths(Scene(make_box(pillars=PILLARS)).clearance)
    places = spread_places(paths, 5, np.random.default_rng(seed))
    roomy = paths.points[paths.largest & (paths.clearance >= ROOMY)]
    assert len(np.unique(places, axis=0)) == 5
    assert (paths.clearance[paths.nearest(places)[0]] >= ROOMY).all()
    far = np.stack(
        [paths.between(roomy, np.tile(place, (len(roomy), 1))) for place in places]
    )  # (5, K)
    for number in range(1, 5):
        nearest = far[:number].min(axis=0)
        here = np.linalg.norm(roomy - places[number], axis=1).argmin()
        assert nearest[here] == pytest.approx(nearest.max(), abs=0.05)


def test_a_world_without_room_for_so_many_places_is_refused():
    paths = GridPaths(Scene(make_box(1.2, 1.2)).clearance)
    count = int(paths.largest.sum()) + 1
    with pytest.raises(InputError, match=f"count: the world has no room for {count} places; give"):
        spread_places(paths, count, np.random.default_rng(0))


def test_cars_look_along_the_way_unless_something_is_there():
    scene = Scene(make_box(pillars=PILLARS))
    paths = GridPaths(scene.clearance)
    places = np.array([[1.0, 1.0], [9.0, 1.0], [1.0, 9.0]])
    pairs = np.array([[0, 1], [0, 2], [1, 0]])
    poses = facing(scene, paths, places, pairs)
    assert poses[:, :2] == pytest.approx(places[pairs[:, 0]], abs=0.1)
    assert poses[:, 2] == pytest.approx([0.0, np.pi / 2, np.pi], abs=0.5)
    assert is_free(scene, BicycleCar(), poses).all()


def test_a_car_looks_aside_where_it_would_stand_in_a_pillar():
    scene = Scene(make_box(pillars=PILLARS))
    paths, places = GridPaths(scene.clearance), np.array([[2.24, 2.7], [9.0, 3.0]])
    path = paths.fields(places[1:]).path(places[0])
    ahead = path[np.linalg.norm(path - path[0], axis=1).searchsorted(1.0)] - path[0]
    along = np.array([[*places[0], np.arctan2(ahead[1], ahead[0])]])
    assert not is_free(scene, BicycleCar(), along)[0]
    (pose,) = facing(scene, paths, places, np.array([[0, 1]]))
    assert pose[:2] == pytest.approx(places[0], abs=0.1)
    assert is_free(scene, BicycleCar(), pose[None])[0]
    assert abs(pose[2] - along[0, 2]) == pytest.approx(0.4)


# Trials.


def test_trials_start_near_a_recorded_trajectory_and_end_at_its_goal(building, trials):
    assert len(trials) == 10
    first = building.recorded.first_frames
    number = {tuple(pair): n for n, pair in enumerate(building.pairs.tolist())}
    for trial, pair in enumerate(trials.pairs.tolist()):
        recorded = building.recorded.poses[first[number[tuple(pair)]]]
        gap = np.linalg.norm(trials.starts[trial, :2] - recorded[:2])
        assert 0 < gap <= 1.0
        assert (
            np.linalg.norm(trials.goal_poses[trial, :2] - building.places[pair[1]]) < REACHED + 0.1
        )
        drive = trials.recorded.trajectories[trial]
        assert (drive.poses[0] == trials.starts[trial]).all()
        assert (drive.poses[-1] == trials.goal_poses[trial]).all()
        assert trials.seconds[trial] == pytest.approx(0.1 * (len(drive) - 1))
    counts = np.bincount([number[tuple(pair)] for pair in trials.pairs.tolist()], minlength=6)
    assert counts.max() - counts.min() <= 2
    assert counts.min() >= 1


def test_trials_are_drawn_by_their_seed(building, trials):
    again = draw_trials(building, 10, np.random.default_rng(1))
    assert (again.starts == trials.starts).all()
    assert (again.pairs == trials.pairs).all()
    other = draw_trials(building, 10, np.random.default_rng(2))
    assert not np.array_equal(other.starts, trials.starts)


def test_a_goal_is_one_image_as_seen_from_there(trials):
    view = VIEWS["camera16"]
    goals = goals_of(trials, view, 5)
    assert len(goals) == 10
    for trial, goal in enumerate(goals):
        assert goal.contexts.shape == (1, 11, 16, 64, 3)
        there = view.render(trials.recorded.scene, trials.goal_poses[[trial]])
        assert (goal.observations.image == there).all()
        assert (goal.contexts == there).all()
    with pytest.raises(InputError, match="images: 'film'; give one or clip"):
        goals_of(trials, view, 5, "film")


def test_a_clip_shows_the_end_of_a_drive_to_the_goal(trials):
    view = VIEWS["camera16"]
    goals = goals_of(trials, view, 5, "clip")
    assert len(goals) == 10
    for trial, goal in enumerate(goals):
        assert goal.contexts.shape == (1, 11, 16, 64, 3)
        there = view.render(trials.recorded.scene, trials.goal_poses[[trial]])
        assert (goal.observations.image == there).all()
        assert (goal.contexts[0, 5] == there[0]).all()
        # Nothing comes after the end of a trajectory.
        assert (goal.contexts[0, 6:] == there[0]).all()
        assert (goal.contexts[0, 0] != there[0]).any()


# What was sensed, and where that was.


def test_experiences_are_the_trajectories_one_after_the_other(building):
    found = list(experiences(building))
    begins = building.recorded.begins
    assert len(found) == len(begins) == 6
    assert begins[0] == 0.0
    last = -np.inf
    for number, (one, drive) in enumerate(zip(found, building.recorded.trajectories, strict=True)):
        assert len(one.observations) == len(one.timestamps) == len(drive)
        assert one.timestamps[0] == begins[number] > last
        last = one.timestamps[-1]
        assert one.observations.odometry == pytest.approx(drive.odometry)
        assert (one.observations.laser == drive.laser).all()
        assert one.observations.depth is None
    (some,) = experiences(building, [4])
    assert (some.timestamps == found[4].timestamps).all()
    assert (some.observations.image == found[4].observations.image).all()


def test_an_experience_needs_a_time_for_each_frame(building):
    seen = next(experiences(building)).observations
    for count, times in ((3, 2), (1, 1), (0, 0)):
        with pytest.raises(InputError, match=f"experience: {count} observations, {times} timest"):
            Experience(seen[np.arange(count)], np.arange(times) * 0.1)


class Anything:
    """RE that says yes to everything."""

    def prepare(self, contexts):
        return np.asarray(contexts)

    def probability(self, observations, prepared):
        return np.ones(len(prepared))


def test_edges_are_as_long_as_the_path_between_their_vertices(building):
    topomap, frames = TopoMap(Anything()), []
    first = building.recorded.first_frames
    for number, one in enumerate(experiences(building)):
        if number not in (1, 4):
            continue
        kept = np.array([0, 37, 80, len(one.timestamps) - 1])
        frames += (first[number] + kept).tolist()
        topomap.make_vertices(
            one.observations[kept],
            kept[:, None],
            one.timestamps[kept],
            np.full(4, number),
            np.arange(4),
        )
    poses = building.recorded.poses[frames]
    assert vertex_poses(building, topomap) == pytest.approx(poses)
    assert edge_lengths(building, topomap).shape == (0,)
    for source, target in ((0, 3), (7, 4), (2, 6), (1, 0), (5, 2)):
        topomap.connect(source, target, 0.5)
    lengths = edge_lengths(building, topomap)
    for (source, target), length in zip(topomap.graph.edges, lengths, strict=True):
        path = building.paths.fields(poses[[target], :2], shortest=True)
        assert length == pytest.approx(path.distance(poses[[source], :2])[0])
    assert lengths.max() > 5 > lengths.min()
    topomap.remove([0])
    assert len(edge_lengths(building, topomap)) == 3


# How trials end.


class Scripted:
    """A navigation in which all robots take one action, and arrive or give up on schedule."""

    def __init__(self, count, action=(0.0, 0.0), arrive=None, give_up=None):
        self.arrived, self.given_up = np.zeros(count, bool), np.zeros(count, bool)
        self.action, self.step = np.asarray(action, dtype=float), 0
        self.arrive, self.give_up, self.queried = arrive or {}, give_up or {}, []

    def act(self, observations, robots):
        assert len(observations) == len(robots)
        self.step += 1
        self.queried.append(robots.tolist())
        for robot in robots:
            self.arrived[robot] = self.step >= self.arrive.get(int(robot), np.inf)
            self.given_up[robot] = self.step >= self.give_up.get(int(robot), np.inf)
        return np.tile(self.action, (len(robots), 1))


def at_goals(building, aside, turned, seconds=1.0):
    """Trials that start so far to the left of their goals (N,), and turned (N,) from them."""
    frames = np.full(len(aside), building.recorded.first[0] + 60)
    goals = building.recorded.poses[frames]
    starts = goals.copy()
    starts[:, 0] -= np.sin(goals[:, 2]) * aside
    starts[:, 1] += np.cos(goals[:, 2]) * aside
    starts[:, 2] += turned
    long = np.full(len(aside), seconds)
    return Trials(np.zeros((len(aside), 2), int), starts, building.recorded, frames, long)


def test_a_declared_arrival_is_checked_by_position_and_heading(building):
    aside = np.array([0.0, 0.45, 0.55, 0.0, 0.0, 0.0])
    turned = np.array([0.0, 0.0, 0.0, 1.0, 1.1, 2 * np.pi - 0.3])
    trials = at_goals(building, aside, turned)
    navigation = Scripted(6, arrive=dict.fromkeys(range(6), 3))
    outcome = navigate(building, trials, lambda _: navigation)
    assert outcome.ending.tolist() == ["arrived"] * 6
    assert outcome.success.tolist() == [True, True, False, True, False, True]
    assert outcome.wrong.tolist() == [False, False, True, False, True, False]
    assert outcome.gap == pytest.approx(aside, abs=1e-9)
    assert outcome.seconds == pytest.approx(np.full(6, 0.3))
    assert outcome.poses.shape == (4, 6, 3)
    assert isinstance(navigation, Navigation)


def test_trials_end_one_by_one(building):
    trials = replace(
        at_goals(building, np.zeros(4), np.zeros(4)), seconds=np.array([1, 1, 1, -14.0])
    )
    navigation = Scripted(4, arrive={0: 5}, give_up={1: 2, 0: 5})
    outcome = navigate(building, trials, lambda _: navigation)
    assert outcome.ending.tolist() == ["arrived", "gave_up", "late", "late"]
    assert outcome.seconds == pytest.approx([0.5, 0.2, TIMES + GRACE, GRACE - 28.0])
    assert outcome.success.tolist() == [True, False, False, False]
    assert not outcome.wrong.any()
    assert navigation.queried[1] == [0, 1, 2, 3]
    assert navigation.queried[2] == [0, 2, 3]
    assert navigation.queried[5] == [2, 3]
    assert navigation.queried[-1] == [2]


def test_to_be_near_is_not_to_have_arrived(building):
    outcome = navigate(
        building, at_goals(building, np.zeros(1), np.zeros(1)), lambda _: Scripted(1)
    )
    assert not outcome.success[0]
    assert outcome.gap[0] < NEAR


def test_a_robot_that_pushes_against_a_wall_is_stuck(building):
    trials = at_goals(building, np.zeros(2), np.zeros(2), seconds=30.0)
    outcome = navigate(building, trials, lambda _: Scripted(2, action=(0.5, 0.0), arrive={1: 4}))
    assert outcome.ending.tolist() == ["stuck", "arrived"]
    assert not outcome.success[0]
    # It has touched the wall for so long at a stretch, and not a step longer.
    alone, stretch, steps = Simulation(building.scene, trials.starts[:1]), 0, 0
    while stretch < STUCK / STEP:
        alone.step([[0.5, 0.0]])
        stretch, steps = (stretch + 1 if alone.touching[0] else 0), steps + 1
    assert outcome.seconds[0] == pytest.approx(STEP * steps)
    assert len(outcome.poses) == steps + 1
    # A robot that is done stands still while the others drive on.
    assert np.ptp(outcome.poses[20:, 1], axis=0).max() < 1e-6
    assert outcome.gap[1] == pytest.approx(
        np.linalg.norm(outcome.poses[4, 1, :2] - trials.goal_poses[1, :2])
    )


class ToAndFro(Scripted):
    """Ahead and back again, each for `turn` steps."""

    turn = 15

    def act(self, observations, robots):
        gear = 1.0 if self.step // self.turn % 2 == 0 else -1.0
        return gear * super().act(observations, robots)


def test_only_touching_at_a_stretch_is_to_be_stuck(building):
    trials = at_goals(building, np.zeros(1), np.zeros(1), seconds=30.0)
    alone, track = Simulation(building.scene, trials.starts), [trials.starts]
    while not alone.touching[0]:
        track.append(alone.poses)
        alone.step([[0.5, 0.0]])
    trials = replace(trials, starts=track[-1])
    outcome = navigate(building, trials, lambda _: ToAndFro(1, action=(0.5, 0.0)))
    # It touches the wall again and again, together for much longer than it may at a stretch.
    alone, touched = Simulation(building.scene, trials.starts), []
    for step in range(400):
        alone.step([[0.5 if step // 15 % 2 == 0 else -0.5, 0.0]])
        touched.append(alone.touching[0])
    assert STEP * sum(touched) > 2 * STUCK
    assert outcome.ending.tolist() == ["late"]


class Mapped:
    """An agent with a map over two recorded trajectories, which gives up at once."""

    def __init__(self, edges):
        self.edges, self.topomap = edges, TopoMap(Anything())

    def learn(self, experiences):
        for number, one in enumerate(experiences[:2]):
            kept = np.arange(0, len(one.timestamps), 20)
            some = np.full(len(kept), number)
            self.topomap.make_vertices(
                one.observations[kept], kept[:, None], one.timestamps[kept], some, 0 * some
            )
        for source, target in self.edges:
            self.topomap.connect(source, target, 0.5)

    def start(self, goals):
        return Scripted(len(goals), give_up=dict.fromkeys(range(len(goals)), 1))


def test_edges_of_five_metres_and_more_are_wormholes(building):
    trials, found = at_goals(building, np.zeros(1), np.zeros(1)), Mapped([])
    found.learn(list(experiences(building)))
    count = len(found.topomap)
    agent = Mapped([(0, target) for target in range(1, count)])
    result = attempt(building, trials, agent)
    lengths = edge_lengths(building, agent.topomap)
    assert ((lengths > 2.6) & (lengths < 4.9)).sum() > 2
    assert (lengths > 5.1).sum() > 1
    assert result.size == (count, count - 1, (lengths > 5.0).sum())
    assert result.outcome.ending.tolist() == ["gave_up"]


def test_an_oracle_arrives_everywhere_in_time(building, trials):
    made = []

    def start(simulation):
        assert (simulation.poses == trials.starts).all()
        made.append(OracleNavigation(simulation, building.paths, trials.goal_poses))
        return made[0]

    outcome = navigate(building, trials, start)
    assert (outcome.ending == "arrived").all()
    assert outcome.success.mean() >= 0.9
    assert (outcome.seconds < trials.seconds + 3).all()
    assert not made[0].given_up.any()


# Agents of the user's own.

WHOLE = """
import numpy as np


class Mine:
    def learn(self, experiences):
        self.learned = len(experiences)

    def start(self, goals):
        assert self.learned == 6
        return Walk(len(goals))


class Walk:
    def __init__(self, count):
        self.arrived, self.given_up = np.zeros((2, count), bool)
        self.steps = 0

    def act(self, observations, robots):
        self.steps += 1
        self.given_up[robots] = self.steps >= 3
        return np.zeros((len(robots), 2))
"""


@pytest.fixture
def own(tmp_path):
    """Writes a user's file; returns the option that names a class in it."""

    def write(text, name="Mine", file="own.py"):
        (tmp_path / file).write_text(text)
        return f"{tmp_path / file}:{name}"

    return write


def test_robots_have_the_body_of_their_building(building, trials):
    bodies, small = [], BicycleCar(wheelbase=0.2)

    def start(simulation):
        bodies.append(simulation.body)
        over = np.ones(len(simulation), bool)
        return SimpleNamespace(
            act=lambda seen, robots: np.zeros((len(robots), 2)), arrived=~over, given_up=over
        )

    for one in (building, replace(building, body=small)):
        navigation.navigate(one, trials, start)
    assert bodies == [BicycleCar(), small]


NARROW = Camera(field_of_view=float(np.deg2rad(90.0)))


@pytest.fixture
def untrained(monkeypatch):
    """Networks that learned nothing, in place of those for a camera of 90 degrees; their names."""
    named = []

    def made(kind, outputs, name):
        named.append(name)
        return kind(LocalNetwork(Architecture(5, view="camera16_90", outputs=outputs)).eval())

    for kind, outputs in ((WaypointNetwork, "waypoint"), (ReachabilityNetwork, "reachability")):
        monkeypatch.setattr(agents, kind.__name__, partial(made, kind, outputs))
    return named


def test_robots_look_through_the_camera_of_their_building(building, trials, untrained, monkeypatch):
    narrow, scene = replace(building, camera=NARROW), building.scene
    (seen,) = (one.observations for one in experiences(narrow, [2]))
    there = building.recorded.poses[building.recorded.frames_of(2)]
    assert (seen.image == NARROW.look(scene, there)[0]).all()
    assert seen.camera == NARROW
    monkeypatch.setattr(navigation, "TIMES", 0.0)
    monkeypatch.setattr(navigation, "GRACE", 0.3)
    agent, met = agents.random_agent(np.random.default_rng(0), NARROW), []
    start = type(agent).start

    def noted(self, goals):
        met.extend(goals)
        return start(self, goals)

    monkeypatch.setattr(type(agent), "start", noted)
    # Its network refuses images of another camera.
    assert len(attempt(narrow, trials, agent).outcome.success) == len(met) == len(trials)
    shown = np.concatenate([goal.contexts[:, 5] for goal in met])
    assert (shown == NARROW.look(scene, trials.goal_poses)[0]).all()
    assert all(goal.observations.camera == NARROW for goal in met)
    with pytest.raises(InputError, match="camera"):
        attempt(building, trials, agents.random_agent(np.random.default_rng(0), NARROW))


def test_agents_load_the_networks_that_were_trained_for_the_camera(untrained, own):
    usual = ["waypoint_k5", "reach_k5"]
    agents.meng(NARROW)
    agents.remedied("all", NARROW)
    agents.random_agent(np.random.default_rng(0), NARROW)
    text = "class Mine:\n    def plan(self, *_): ...\n"
    agents.custom(own(text), NARROW)
    narrow = [f"{name}_90" for name in usual]
    assert untrained == [*narrow, *narrow, narrow[0], *narrow]
    untrained.clear()
    agents.sptm(NARROW)
    assert untrained == ["sptm_90", *narrow]
    untrained.clear()
    agents.sptm()
    agents.meng(Camera())
    assert untrained == ["sptm", *usual, *usual]


def test_a_network_that_is_missing_is_named_with_the_command_that_trains_it():
    agents.check_trained(Camera())
    camera = Camera(field_of_view=float(np.deg2rad(91.0)))
    for make, command in (
        (agents.check_trained, "train waypoint --k 5 --degrees 91"),
        (agents.meng, "train waypoint --k 5 --degrees 91"),
        (agents.sptm, "train reachability --k sptm --degrees 91"),
    ):
        with pytest.raises(InputError, match=f"91 degrees; train it: .*tutorial_lib {command}$"):
            make(camera)


def test_a_whole_agent_of_the_user_is_compared(building, trials, own):
    where = own(WHOLE)
    agent = agents.custom(where)
    assert isinstance(agent, Agent)
    found = guarded(where, attempt, building, trials, agent)
    assert (found.outcome.ending == "gave_up").all()
    assert found.outcome.seconds == pytest.approx(np.full(10, 0.3))
    assert found.size is None


@networks
@pytest.mark.parametrize(
    ("kind", "methods"),
    [
        ("planner", ["plan"]),
        ("localizer", ["localize"]),
        ("reachability", ["prepare", "probability"]),
    ],
)
def test_a_component_of_the_user_replaces_ours(own, kind, methods):
    text = "class Mine:\n" + "".join(f"    def {name}(self, *_): ...\n" for name in methods)
    agent = agents.custom(own(text))
    assert isinstance(agent, MengAgent)
    piece = agent.planner.localizer if kind == "localizer" else getattr(agent, kind)
    assert type(piece).__name__ == "Mine"
    if kind == "reachability":
        assert agent.topomap.vertices.reachability is piece


def test_another_file_of_the_same_name_is_another_class(own, tmp_path):
    (tmp_path / "there").mkdir()
    one = agents.custom(own(WHOLE))
    two = agents.custom(
        own(WHOLE + "\n    two = True\n", "Walk2", "there/own.py").replace("Walk2", "Mine")
    )
    assert type(one) is not type(two)


@pytest.mark.parametrize(
    ("where", "words"),
    [
        ("my_agent.py", "give FILE.py:CLASS, as in my_agent.py:MyPlanner"),
        (":Mine", "give FILE.py:CLASS"),
        ("my_agent.py:", "give FILE.py:CLASS"),
        ("my_agent.py:1+1", "give FILE.py:CLASS"),
        ("my_agent.py:Mine", "there is no file my_agent.py"),
    ],
)
def test_an_agent_is_a_file_and_a_class(where, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=f"--agent {where.replace('+', '.')}: {words}"):
        agents.custom(where)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x = 1\n", "own.py has no Mine$"),
        (
            "class Mine:\n    def drive(self): ...\n",
            "has the methods of no component .agent: learn, start",
        ),
        ("class Mine:\n    def learn(self): ...\n", "has the methods of no component"),
        ("class Mine:\n    def prepare(self): ...\n", "reachability: prepare, probability"),
        (
            "class Mine:\n    def __init__(self):\n        x = 1\n        raise KeyError('abc')\n",
            "own.py, line 4: KeyError: 'abc'$",
        ),
        (
            "class Mine:\n    def __init__(self, size): ...\n",
            r"Mine is made without arguments, but takes \(size\)",
        ),
        ("import numpy\n\nclass Mine\n    x = 1\n", "own.py, line 3: SyntaxError: "),
        ("\n\nimport no_such_module_at_all\n", "own.py, line 3: ModuleNotFoundError: No module"),
        ("x = 1\n1 / 0\n", "own.py, line 2: ZeroDivisionError"),
        ("Mine = 5\n", "Mine is 5; give the class itself, or a function"),
    ],
)
def test_a_file_with_a_fault_is_reported(own, text, words):
    where = own(text)
    with pytest.raises(InputError, match=words) as error:
        agents.custom(where)
    assert str(error.value).startswith(f"--agent {where}: ")


def test_a_file_that_is_no_python_is_named(own):
    where = own("class Mine: ...", file="own.txt")
    with pytest.raises(InputError, match=r"own\.txt is no Python file; its name ends in \.py"):
        agents.custom(where)


def changed(text, old, new):
    assert text.count(old) == 1
    return text.replace(old, new)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("self.learned = len(experiences)", "experiences[99]", "own.py, line 7: IndexError: "),
        ("return Walk(len(goals))", "raise ValueError('no')", "own.py, line 11: ValueError: no$"),
        ("return np.zeros((len(robots), 2))", "return robots.x", "own.py, line 22: AttributeError"),
        (
            "return np.zeros((len(robots), 2))",
            "return np.zeros((7, 2))",
            r"actions: \(7, 2\); give \(M, 2\), a row for each of 10 robots$",
        ),
        (
            "return np.zeros((len(robots), 2))",
            "return np.zeros((10, 3))",
            r"actions: shape \(10, 3\); give real numbers of shape \(M, 2\)$",
        ),
        (
            "return np.zeros((len(robots), 2))",
            "return np.full((10, 2), np.nan)",
            r"own\.py, line 19, after act: actions: nan; give finite numbers",
        ),
        (
            "return np.zeros((len(robots), 2))",
            "return 'left'",
            r"actions: 'left'; give real numbers",
        ),
        ("return np.zeros((len(robots), 2))", "return None", r"actions: None; give real numbers"),
        (
            "return Walk(len(goals))",
            "return None",
            "navigation: None; give an object",
        ),
        (
            "self.arrived, self.given_up",
            "self.arrived, self.x",
            "give an object that has arrived and",
        ),
        ("np.zeros((2, count), bool)", "np.zeros((2, 3), bool)", "10 in the simulation, 3 in the"),
        ("np.zeros((2, count), bool)", "np.full((2, count), 0.5)", r"arrived: 0\.5; give True"),
    ],
)
def test_an_agent_that_fails_in_the_comparison_is_reported(building, trials, own, old, new, words):
    where = own(changed(WHOLE, old, new))
    agent = agents.custom(where)
    with pytest.raises(InputError, match=words) as error:
        guarded(where, attempt, building, trials, agent)
    assert str(error.value).startswith(f"--agent {where}: ")


@pytest.mark.parametrize(
    "wrong", ["0.5", "[0.5, 0.0]", "[[0.5, 0.0]]", "np.zeros((len(robots), 1))"]
)
def test_one_action_for_all_robots_is_reported(building, trials, own, wrong):
    where = own(changed(WHOLE, "return np.zeros((len(robots), 2))", f"return {wrong}"))
    with pytest.raises(InputError, match=r"--agent .*: actions: .* \(M, 2\)"):
        guarded(where, attempt, building, trials, agents.custom(where))


def test_a_file_that_exits_is_reported(building, trials, own):
    with pytest.raises(InputError, match=r"--agent .*own\.py, line 3: SystemExit: 3$"):
        agents.custom(own("import sys\n\nsys.exit(3)\n"))
    where = own(changed(WHOLE, "return Walk(len(goals))", "raise SystemExit('enough')"))
    with pytest.raises(InputError, match=r"--agent .*own\.py, line 11: SystemExit: enough$"):
        guarded(where, attempt, building, trials, agents.custom(where))


@networks
def test_a_planner_after_the_interface_is_good_enough(building, own):
    text = (
        "from tutorial_lib.topology.planner import Plan\n\n\n"
        "class Mine:\n"
        "    def plan(self, observation, goals, topomap, excluded=()):\n"
        "        return Plan(refusal='no path')\n"
    )
    agent = agents.custom(own(text))
    agent.learn(list(experiences(building))[:1])
    trials = at_goals(building, np.zeros(1), np.zeros(1))
    navigation = agent.start(goals_of(trials, VIEWS["camera16"], 5))
    seen = next(experiences(building)).observations[0]
    assert navigation.act(seen, np.array([0])).shape == (1, 2)


def test_a_guarded_error_is_reported_and_a_result_returned(own):
    where = own(WHOLE)
    assert guarded(where, lambda a, b: a + b, 1, 2) == 3

    def refuse():
        raise InputError("localizer: returned (3,)")

    with pytest.raises(InputError, match=r"--agent .*own.py:Mine: localizer: returned \(3,\)$"):
        guarded(where, refuse)
    with pytest.raises(KeyboardInterrupt):
        guarded(where, lambda: (_ for _ in ()).throw(KeyboardInterrupt))


def test_a_wrong_agent_is_reported_before_any_rollout(monkeypatch, own, capsys):
    def never(*_, **__):
        raise AssertionError("it was driven")

    monkeypatch.setattr(table2, "make_building", never)
    monkeypatch.setattr(table2, "for_each", never)
    for where in ("nowhere.py:Mine", own("class Mine\n")):
        assert main(["experiment", "meng_table2", "--quick", "--agent", where]) == 2
        error = capsys.readouterr().err
        assert f"--agent {where}: " in error
        assert "Traceback" not in error
    assert main(["experiment", "plans", "--agent", own(WHOLE)]) == 2
    assert (
        "--agent: plans cannot use it; its options: --worlds A:B, --map" in capsys.readouterr().err
    )


# The comparison.


@networks
@pytest.mark.full
def test_all_methods_are_compared_on_the_same_trials(plan, own, monkeypatch):
    settings = table2.Settings(places_on_map=3, trials_of_part=2)
    few = replace(table2.EXPERIMENT, quick_settings=settings)
    monkeypatch.setattr(navigation, "GRACE", 1.0)
    monkeypatch.setattr(table2, "for_each", in_turn)
    report = few.report(Options(quick=True, map=plan, agent=own(WHOLE), drives="1"))
    rows = {row["method"]: row for row in report.rows}
    assert list(rows) == ["meng", "sptm", "random", "oracle", "custom"]
    for row in rows.values():
        assert row["world"] == "room.json"
        assert (row["family"], row["area"], row["trials"]) == ("box", 100, 2)
        assert 0.0 <= row["low"] <= row["success"] <= row["high"] <= 1.0
        assert (
            sum(row[name] for name in ("success", "wrong_place", "gave_up", "stuck", "late")) == 1
        )
    assert rows["oracle"]["success"] == 1.0
    assert rows["meng"]["success"] >= 0.5
    assert rows["custom"]["gave_up"] == 1.0
    for name in ("meng", "sptm"):
        assert 0 < rows[name]["vertices"] < rows[name]["images"]
        assert rows[name]["edges"] >= rows[name]["vertices"] - 6
        assert rows[name]["wormholes"] <= rows[name]["edges"]
    assert rows["random"]["vertices"] is rows["oracle"]["edges"] is None
    assert report.map == "room.json"
    assert json.loads(json.dumps(report.as_dict()))["worlds"] == []
    found = {finding.what: finding.value for finding in report.findings}
    assert found["oracle, all worlds"] == 1.0
    assert found["meng - custom"] == pytest.approx(found["meng, all worlds"])
    assert "edges are no wormholes" in "\n".join(report.notes)


@networks
@pytest.mark.parametrize(
    ("drives", "p_edge", "s_shortcut"),
    [
        ("", 0.99, 0.99),
        ("tour", 0.8, 0.95),
        pytest.param("0.4", 0.9, 0.97, marks=pytest.mark.full),
        pytest.param("continuous", 0.8, 0.95, marks=pytest.mark.full),
    ],
)
@pytest.mark.few(2)
def test_maps_of_a_part_of_the_drives_have_its_thresholds(
    plan, monkeypatch, drives, p_edge, s_shortcut
):
    chosen = {"0.4": Thresholds(0.9, 0.97), "tour": Thresholds(0.8, 0.95)}
    few = table2.Settings(places_on_map=3, trials=2, thresholds=chosen)
    met = {}

    def attempt(building, trials, agent, images):
        met[type(agent).__name__] = agent
        nothing = np.zeros(len(trials))
        ending = np.full(len(trials), "late")
        outcome = navigation.Outcome(nothing > 0, ending, nothing, nothing, nothing)
        return navigation.Result(outcome, (1, 1, 0))

    monkeypatch.setattr(table2, "attempt", attempt)
    monkeypatch.setattr(table2, "part_of", lambda whole, *_: whole)
    monkeypatch.setattr(drive_choices, "toured", lambda whole: whole)
    monkeypatch.setattr(table2, "for_each", in_turn)
    monkeypatch.setattr(navigation, "GRACE", 0.0)
    experiment = replace(table2.EXPERIMENT, settings=few)
    report = experiment.report(Options(map=plan, drives=drives))
    assert met["MengAgent"].settings.p_edge == p_edge
    assert met["SPTMAgent"].s_shortcut == s_shortcut
    driven = [one for one in report.findings if one.what.startswith("trials on a recorded drive")]
    assert len(driven) == (not drives)
    assert "hardly test composing" in " ".join(report.notes) or drives


def test_a_single_place_is_shared_out_by_method_and_many_by_world(monkeypatch):
    shared = []

    def together(place, options, settings, each):
        shared.append((place, each is table2.for_each))
        return place

    monkeypatch.setattr(table2, "_together", together)
    monkeypatch.setattr(table2, "for_each", in_turn)
    monkeypatch.setattr(table2, "_notes", lambda *_: ())
    monkeypatch.setattr(table2, "_row", lambda *_: {})
    for worlds in ((7,), (8, 9)):
        with pytest.raises(AttributeError):  # there are no results
            table2.run(Options(worlds=worlds), table2.Settings())
    assert shared == [(7, True), (8, False), (9, False)]


def test_robots_record_and_navigate_with_a_body_of_the_users(plan, own, monkeypatch):
    where = own(
        "from tutorial_lib.world import BicycleCar\n\n\ndef Mine():\n    return BicycleCar(0.2)"
    )
    settings = table2.Settings(places_on_map=3, trials=2)
    options = Options(map=plan, robot=where)
    building, whole, _ = table2.task_of(plan, options, settings)
    assert building.body == whole.body == BicycleCar(0.2)
    usual = table2.task_of(plan, replace(options, robot=""), settings)[1]
    assert usual.body == BicycleCar()
    assert not np.array_equal(usual.recorded.poses, whole.recorded.poses)
    monkeypatch.setattr(table2, "_together", lambda *given: given[3])
    monkeypatch.setattr(table2, "_notes", lambda *_: ())
    monkeypatch.setattr(table2, "_row", lambda *_: {})
    with pytest.raises(InputError, match=r"^--robot .*: there is no file nowhere\.py"):
        table2.run(replace(options, robot="nowhere.py:Mine"), settings)
    assert building.camera == whole.camera == Camera()
    where = own(
        "from tutorial_lib.world import BicycleCar, Camera\n\n\ndef Mine():\n"
        f"    return BicycleCar(0.2), Camera(field_of_view={NARROW.field_of_view})"
    )
    building, narrow, _ = table2.task_of(plan, replace(options, robot=where), settings)
    assert building.camera == narrow.camera == NARROW
    assert np.array_equal(narrow.recorded.poses, whole.recorded.poses)
    monkeypatch.setattr(agents, "NETWORKS", ("reach_k5",))
    with pytest.raises(InputError, match=r"train reachability --k 5 --degrees 90$"):
        table2.run(replace(options, robot=where), settings)


def test_a_map_has_ten_places_in_a_quick_run_too():
    quick = table2.EXPERIMENT.quick_settings
    assert (quick.places, quick.places_on_map, quick.trials) == (6, 10, 40)
