"""What an agent gets leads to no pose, no floor plan, no geodesic and no goal's position."""

import gc
from dataclasses import replace
from types import CodeType, FunctionType, ModuleType, SimpleNamespace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from tests.conftest import make_box, needs
from tutorial_lib.agents.oracle import OracleNavigation
from tutorial_lib.driving.control.composed import RandomWaypoints
from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.trajectories import Trajectory
from tutorial_lib.driving.geodesics import DistanceFields, GridPaths
from tutorial_lib.experiments.common import agents, explorers
from tutorial_lib.experiments.common.report import Options
from tutorial_lib.experiments.meng2020 import (
    fig7,
    fig8,
    fig9,
    fig10,
    fig11,
    fig13,
    table2,
    table2_thresholds,
)
from tutorial_lib.experiments.protocols import exploration, following, navigation
from tutorial_lib.experiments.protocols.navigation import attempt, experiences, navigate
from tutorial_lib.experiments.protocols.navigation_tasks import (
    Building,
    Trials,
    draw_trials,
    explored,
)
from tutorial_lib.experiments.protocols.odometry import NAVIGATING, RECORDING, Odometry
from tutorial_lib.experiments.robustness import disturbances, faults
from tutorial_lib.exploration.episodes import Episodes
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.exploration.true_geometry import TrueGeometry
from tutorial_lib.geometry import relative, to_local
from tutorial_lib.learning.estimators import ReachabilityNetwork, WaypointNetwork
from tutorial_lib.learning.threads import use_threads
from tutorial_lib.topology.planner import DijkstraPlanner
from tutorial_lib.world.fields import Field
from tutorial_lib.world.fleet import Fleet
from tutorial_lib.world.floorplan import FloorPlan
from tutorial_lib.world.noise import FORWARD, LEFT, DriftingOdometry, NoNoise
from tutorial_lib.world.raycast import Raycaster
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.simulation import Simulation

PILLARS = [(3.0, 3.0, 0.5), (6.5, 4.0, 0.3), (5.0, 7.5, 0.8)]
FORBIDDEN = (
    FloorPlan,
    Scene,
    Raycaster,
    Field,
    Simulation,
    Fleet,
    GridPaths,
    DistanceFields,
    RecordedWorld,
    Trajectory,
    Building,
    Trials,
    ExplorationTask,
    Episodes,
    TrueGeometry,
)
use_threads(1)
networks = needs("waypoint_k5", "reach_k5", "sptm")


@pytest.fixture(scope="module")
def building():
    """A room with pillars, and trajectories between four places in it."""
    scene = Scene(make_box(pillars=PILLARS))
    return explored("room", scene, np.random.default_rng(3), 4)


@pytest.fixture(scope="module")
def trials(building):
    return draw_trials(building, 12, np.random.default_rng(1))


def reachable(*roots):
    """All that references lead to from `roots`.

    Modules and classes, which all code shares, are not followed: an agent could import anything,
    but nothing there says which world it is in.
    """
    found, due = {}, list(roots)
    while due:
        one = due.pop()
        if id(one) in found or isinstance(one, ModuleType | type | CodeType):
            continue
        found[id(one)] = one
        if isinstance(one, FunctionType):
            due += [one.__closure__, one.__defaults__, one.__kwdefaults__, one.__dict__]
        elif isinstance(one, np.ndarray):
            due += [one.base, *(one.ravel().tolist() if one.dtype == object else [])]
        else:
            due += gc.get_referents(one)
    return list(found.values())


class TruePoses:
    """Finds poses of robots that went somewhere, in the world's frame or from their starts."""

    def __init__(self, *tracks):
        """Of tracks (T, 3)."""
        whole = [track for track in tracks if len(track) > 1]
        since = [relative(track[0], track) for track in whole]
        moved = np.concatenate([one[np.linalg.norm(one[:, :2], axis=1) > 0.2] for one in since])
        self._tree = cKDTree(np.concatenate([*tracks, moved])[:, :2])
        self._numbers = np.unique(np.concatenate([*tracks, moved])[:, :2])
        odd = np.abs(self._numbers * 1000 - np.rint(self._numbers * 1000)) > 1e-6
        self._numbers = self._numbers[odd]  # a round number may be anything

    def among(self, objects):
        """The arrays and numbers that are true poses."""
        return [one for one in objects if self._is_in(one)]

    def _is_in(self, one):
        if isinstance(one, float):
            return bool(np.isin(one, self._numbers))
        if not isinstance(one, np.ndarray) or one.dtype.kind != "f" or not one.size:
            return False
        if np.isin(one, self._numbers).any():
            return True
        if one.ndim == 0 or one.shape[-1] not in (2, 3):
            return False
        rows = one.reshape(-1, one.shape[-1])[:, :2]
        rows = rows[np.isfinite(rows).all(axis=1)]
        return bool((self._tree.query(rows)[0] < 1e-6).any())


class Hoarder:
    """Keeps all that it is given, and drives at random for a while."""

    def __init__(self, steps=60):
        self.steps, self.given, self.rmp = steps, [], RMPController()
        self.waypoints = RandomWaypoints(np.random.default_rng(0))

    def learn(self, experiences):
        self.given.append(experiences)

    def start(self, goals):
        self.given.append(goals)
        self.arrived, self.given_up = np.zeros((2, len(goals)), dtype=bool)
        return self

    def act(self, observations, robots):
        self.given.append((observations, robots))
        self.steps -= 1
        self.given_up[:] = self.steps <= 0
        waypoints, _ = self.waypoints.predict(observations, robots)
        return self.rmp.act(observations, waypoints)


def true_poses(building, trials, outcome):
    recorded = [one.poses for one in building.recorded.trajectories]
    shown = [one.poses for one in trials.recorded.trajectories]
    places = [np.array([[*place, 0.0]]) for place in building.places]
    return TruePoses(*recorded, *shown, *outcome.poses.swapaxes(0, 1), *places)


def leaks(building, trials, outcome, *given):
    """What is reachable from there, and must not be."""
    found = reachable(*given)
    forbidden = [one for one in found if isinstance(one, FORBIDDEN)]
    return forbidden + true_poses(building, trials, outcome).among(found)


def test_nothing_that_an_agent_is_given_leads_to_a_pose_or_to_the_world(building, trials):
    agent = Hoarder()
    outcome = attempt(building, trials, agent).outcome
    assert len(agent.given) == 2 + 60
    found = {type(one).__name__ for one in reachable(agent)}
    assert {"Experience", "Goals", "Observation", "ndarray"} <= found
    assert leaks(building, trials, outcome, agent) == []


@networks
@pytest.mark.parametrize("name", ["meng", "sptm", "random"])
def test_nor_does_anything_that_the_agents_keep(building, trials, name, monkeypatch):
    monkeypatch.setattr(navigation, "GRACE", 4.0)
    make = {
        "meng": agents.meng,
        "sptm": agents.sptm,
        "random": lambda: agents.random_agent(np.random.default_rng(0)),
    }
    agent, kept, few = make[name](), [], trials.subset(np.arange(6))
    agent.learn(list(experiences(building, range(4))))
    goals = navigation.goals_of(few, agent.predictor.view, 5)

    def start(_):
        kept.append(agent.start(goals))
        return kept[0]

    outcome = navigate(building, replace(few, seconds=np.zeros(6)), start)
    assert outcome.seconds.max() == pytest.approx(4.0)
    assert leaks(building, few, outcome, agent, kept, goals) == []


@pytest.mark.full
@needs("laser_k2", "reach_laser")
def test_networks_that_look_at_the_laser_find_its_scans_in_the_contexts(building, trials):
    predictor, reachability = WaypointNetwork("laser_k2"), ReachabilityNetwork("reach_laser")
    agent = agents.meng(predictor=predictor, reachability=reachability, p_sparsify=0.999)
    agent.learn(list(experiences(building, range(2))))
    goals = navigation.goals_of(trials.subset(np.arange(2)), predictor.view, predictor.k)
    planner = DijkstraPlanner(candidates=2, least=0.0, p_query=0.0, p_goal=0.0)
    seen = next(experiences(building)).observations[5]
    assert len(agent.topomap) > planner.candidates
    for goal in goals:
        assert np.isnan(goal.observations.laser).all()
        assert np.isfinite(goal.contexts).all()
        assert 0.0 < planner.plan(seen, goal, agent.topomap).probability <= 1.0
    actions = agent.start(goals[:1]).act(seen, np.array([0]))
    assert np.isfinite(actions).all()


def test_what_leads_there_is_found(building, trials):
    kept, few = [], trials.subset(np.arange(2))

    def start(simulation):
        kept.append(OracleNavigation(simulation, building.paths, few.goal_poses))
        return kept[0]

    outcome = navigate(building, few, start)
    found = {type(one) for one in leaks(building, few, outcome, kept)}
    assert {Scene, Simulation, GridPaths, FloorPlan, Raycaster, np.ndarray} <= found
    poses, place = true_poses(building, few, outcome), few.goal_poses[0]
    hidden = [
        lambda: place,
        {"goal": [place[:2]]},
        place[::-1],
        float(place[0]),
        few.recorded.trajectories[0].poses[5:9],
        relative(few.starts[:1], few.goal_poses[:1]),
    ]
    for one in hidden:
        assert poses.among(reachable(one))


@pytest.mark.parametrize("drifts", [True, False])
def test_only_exact_odometry_holds_true_poses(building, trials, drifts):
    odometry = Odometry(drifts, (4,))
    rng = np.random.default_rng(3)
    other, agent = explored("room", building.scene, rng, 4, odometry), Hoarder()
    outcome = attempt(other, trials, agent).outcome
    learned, _, *seen = agent.given
    poses = true_poses(other, trials, outcome)
    assert bool(poses.among(reachable(learned))) != drifts
    assert bool(poses.among(reachable(seen))) != drifts


def test_drift_follows_from_the_seed():
    for use in (RECORDING, NAVIGATING):
        noises = [Odometry(seed=seed).noise(use) for seed in ((2, 5), (2, 5), (2, 6))]
        one, again, other = (noise.measure(np.ones((4, 3)), None) for noise in noises)
        assert one.tobytes() == again.tobytes()
        assert (one != other).all()
    both = [Odometry().noise(use).measure(np.ones((4, 3)), None) for use in (1, 2)]
    assert (both[0] != both[1]).all()
    exact = Odometry(drifts=False).noise(RECORDING).measure(np.ones((4, 3)), None)
    assert (exact == 1.0).all()


def test_what_is_observed_is_the_same_again_byte_for_byte(building, trials):
    def seen(seed):
        odometry = Odometry(seed=(seed,))
        made = explored("room", building.scene, np.random.default_rng(3), 2, odometry)
        agent = Hoarder(20)
        attempt(made, trials, agent)
        parts = [one.observations for one in agent.given[0]] + [one for one, _ in agent.given[2:]]
        return b"".join(part.odometry.tobytes() for part in parts)

    assert seen(1) == seen(1)
    assert seen(1) != seen(2)


class ByOdometry(Hoarder):
    """Drives to where a goal's odometry is."""

    def start(self, goals):
        self.goals = np.concatenate([goal.observations.odometry for goal in goals])
        return super().start(goals)

    def act(self, observations, robots):
        left = to_local(observations.odometry, self.goals[robots, :2])
        self.arrived[robots] = np.linalg.norm(left, axis=1) < 0.3
        return self.rmp.act(observations, left)


class AtRandom(Hoarder):
    """Drives at random and declares arrival after a random time."""

    def start(self, goals):
        self.due = np.random.default_rng(7).integers(50, 400, len(goals))
        return super().start(goals)

    def act(self, observations, robots):
        actions = super().act(observations, robots)
        self.arrived[:] = 400 - self.steps >= self.due
        return actions


@pytest.mark.full
def test_odometry_alone_leads_to_the_goal_no_more_often_than_chance(building, monkeypatch):
    trials = draw_trials(building, 40, np.random.default_rng(2))
    by_odometry = attempt(building, trials, ByOdometry()).outcome.success
    at_random = attempt(building, trials, AtRandom(400)).outcome.success
    assert by_odometry.mean() <= at_random.mean() <= 0.1

    def of_the_photographer(trials, view, k, images):
        goals = fair(trials, view, k, images)
        for goal, frame in zip(goals, trials.goals, strict=True):
            object.__setattr__(goal, "observations", trials.recorded.observe(np.array([frame])))
        return goals

    fair = navigation.goals_of
    monkeypatch.setattr(navigation, "goals_of", of_the_photographer)
    # As it would be, were the odometry of who took the goal image handed over.
    assert attempt(building, trials, ByOdometry()).outcome.success.mean() > 0.2


class Uninformed:
    """In place of the networks of exploration: it knows of no goal, and keeps what it is given."""

    def __init__(self):
        self.given = []

    def embed(self, observations):
        self.given.append(observations)
        return np.zeros((len(observations), 5), np.float32)

    def ranges(self, observations):
        return observations.depth

    def explorable(self, features):
        return np.ones((len(features), 12))

    def same_node(self, sources, goals):
        return np.zeros(len(sources))

    def relative(self, sources, goals):
        return np.ones((len(sources), 2))

    def scores(self, sources, goals):
        return np.tile(np.arange(12) / 12, (len(sources), 1))

    def score(self, crops, here, goals, frontiers, robots):
        self.given.append((crops, here, goals, frontiers, robots))
        return np.linspace(0.0, 1.0, len(frontiers))

    def start(self, goals):
        self.given.append(goals)
        return np.zeros(len(goals), int)

    def act(self, observations, state):
        self.given.append(observations)
        return np.where(state % 3, FORWARD, LEFT), state + 1


@pytest.fixture(scope="module")
def explored_world():
    return exploration.make_world(10_100, "wayfinding", 1, 0)


@pytest.mark.parametrize(
    "name",
    [one for one in (*explorers.AGENTS["rgbd"], *explorers.BY_REINFORCEMENT) if one != "oracle"],
)
def test_no_explorer_is_given_or_keeps_what_leads_to_a_pose_or_to_the_world(
    name, explored_world, monkeypatch
):
    models, shipped = {}, explorers.shipped

    def uninformed(kind, sensor):
        if kind in explorers.BY_REINFORCEMENT:  # a network, and the one that it reads
            return shipped(kind, sensor)
        return models.setdefault(kind, Uninformed())

    monkeypatch.setattr(explorers, "shipped", uninformed)
    task = ExplorationTask(
        explored_world.scenes, explored_world.episodes, np.random.default_rng(1), limit=40
    )
    agent = explorers.make_explorer(name, task, "rgbd", np.random.default_rng(2), geometry=False)
    agent.start(task.goals())
    while not task.done.all():
        task.step(agent.act(task.observe(), ~task.done))
    assert task.travelled.max() > 1.0
    found = reachable(agent, models)
    assert any(isinstance(one, np.ndarray) for one in found)
    assert [one for one in found if isinstance(one, FORBIDDEN)] == []
    poses = TruePoses(*np.array(task.path).swapaxes(0, 1), *task.goal_poses[:, None])
    assert poses.among(found) == []


def test_an_explorer_that_is_an_oracle_is_found(explored_world):
    task = ExplorationTask(explored_world.scenes, explored_world.episodes, np.random.default_rng(1))
    for name in ("oracle", "nts"):
        agent = explorers.make_explorer(name, task, "rgbd", np.random.default_rng(2), geometry=True)
        agent.start(task.goals())
        found = {type(one) for one in reachable(agent)}
        assert {Scene, ExplorationTask, Episodes, FloorPlan} <= found
        poses = TruePoses(*task.goal_poses[:, None], np.cumsum(np.ones((9, 3)), axis=0))
        assert poses.among(reachable(agent))


class Caught(Exception):  # noqa: N818 - what was asked for
    """Raised instead of making a building or following."""


@pytest.mark.parametrize("kind", ["drifting", "exact"])
@pytest.mark.parametrize(
    ("module", "maker"),
    [
        (table2, "make_building"),
        (table2_thresholds, "make_building"),
        (fig8, "make_building"),
        (fig9, "make_building"),
        (fig10, "make_building"),
        (fig13, "make_building"),
        (faults, "make_building"),
        (fig7, "Odometry"),
        (disturbances, "Odometry"),
    ],
    ids=lambda value: getattr(value, "__name__", value),
)
def test_the_option_reaches_the_robots(module, maker, kind, monkeypatch):
    def ask(*given, drifts=None, **_):
        raise Caught(given[0] if drifts is None else drifts)

    monkeypatch.setattr(module, maker, ask)
    nothing = SimpleNamespace(trajectories=())
    monkeypatch.setattr(module, "trajectories", lambda *_: nothing, raising=False)
    with pytest.raises(Caught) as asked:
        module.run_world(10_001, Options(odometry=kind), module.EXPERIMENT.settings)
    assert asked.value.args == (kind == "drifting",)
    assert "odometry" in module.EXPERIMENT.accepts


@networks
@pytest.mark.parametrize(
    ("odometry", "kind"), [((), DriftingOdometry), ((Odometry(drifts=False),), NoNoise)]
)
def test_robots_that_follow_have_the_odometry_of_their_guide(building, odometry, kind, monkeypatch):
    def ask(*_, odometry_noise, **__):
        raise Caught(odometry_noise)

    monkeypatch.setattr(following, "Simulation", ask)
    guide = following.Guide(building.recorded, "k5", *odometry)
    with pytest.raises(Caught) as asked:
        guide.follow([np.array([0, 20])])
    assert isinstance(asked.value.args[0], kind)


def test_the_option_reaches_the_robots_of_fig11(monkeypatch):
    def ask(*_, drifts):
        raise Caught(drifts)

    monkeypatch.setattr(fig11, "make_building", ask)
    monkeypatch.setattr(fig11, "use_threads", lambda _: None)
    with pytest.raises(Caught, match="False"):
        fig11.run(Options((10_001,), odometry="exact"), fig11.EXPERIMENT.settings)
