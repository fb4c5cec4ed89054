"""The task for cars: waypoints, pymunk, the budget, and what agents are shown."""

import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.agents.nts import NTSAgent
from tutorial_lib.agents.oracle_explorer import OracleExplorer
from tutorial_lib.errors import InputError
from tutorial_lib.exploration.car_task import CAR, STEPS_EACH, CarTask, turned_to_fit
from tutorial_lib.exploration.episodes import Episodes
from tutorial_lib.exploration.motion import FORWARD_METRES
from tutorial_lib.exploration.task import ExplorationTask, explore
from tutorial_lib.exploration.true_geometry import TrueGeometry
from tutorial_lib.world.placing import is_free
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.simulation import STEP

STOPS = [np.nan, np.nan]


def in_a_hall(count, goal=(20.0, 20.0, 0.0), **options):
    """Cars in the middle of a large empty room."""
    scene = Scene(make_box(40.0, 40.0))
    starts, goals = np.tile([20.0, 20.0, 0.3], (count, 1)), np.tile(goal, (count, 1))
    far = np.linalg.norm(starts[:, :2] - goals[:, :2], axis=1)
    episodes = Episodes(("hall",) * count, starts, goals, far, ("",) * count)
    return CarTask({"hall": scene}, episodes, np.random.default_rng(0), **options)


def test_a_waypoint_takes_as_long_as_an_action_and_as_far_ahead():
    assert STEPS_EACH * STEP * CAR.max_speed == pytest.approx(FORWARD_METRES)
    task = in_a_hall(1, noise=False)
    for _ in range(4):
        task.step([[3.0, 0.0]])
    before = task.poses
    task.step([[3.0, 0.0]])
    assert np.linalg.norm(task.poses[0, :2] - before[0, :2]) == pytest.approx(0.25, abs=0.005)
    assert task.steps.tolist() == [5]
    assert task.travelled[0] == pytest.approx(np.linalg.norm(task.poses[0, :2] - 20.0), abs=1e-3)


def test_metres_to_and_fro_are_driven_as_well():
    task = in_a_hall(1, noise=False)
    for waypoint in (1.0, 1.0, -0.15, -0.15):
        task.step([[waypoint, 0.0]])
    path = np.array(task.path)[:, 0, :2]
    assert task.travelled[0] > np.linalg.norm(np.diff(path, axis=0), axis=1).sum() + 0.001
    assert len(path) == 5


def test_a_car_that_stops_brakes_and_ends_its_episode():
    for goal, reached in (((20.9, 20.3, 0), True), ((23.0, 20.0, 0), False)):
        task = in_a_hall(2, goal)
        task.step([[1.0, 0.0]] * 2)
        task.step([STOPS, [1.0, 0.0]])
        assert task.done.tolist() == [True, False]
        assert task.success.tolist() == [reached, False]
        rest = task.poses[0]
        task.step([[1.0, 0.0]] * 2)
        assert (task.poses[0] == rest).all()
        assert task.steps.tolist() == [2, 3]


def test_agents_are_shown_what_they_see_in_the_round_robot_and_the_body(scenes, episodes):
    task = CarTask(scenes, episodes, np.random.default_rng(0))
    round_one = ExplorationTask(scenes, episodes, np.random.default_rng(0)).observe()
    seen, stays = task.observe(), ~task.turned
    assert (seen.image[stays] == round_one.image[stays]).all()
    assert (seen.depth[stays] == round_one.depth[stays]).all()
    assert seen.body == CAR
    assert np.isfinite(seen.laser).all()
    assert task.goals().body is None
    task.step(np.tile([1.0, 0.2], (len(task), 1)))
    moved = task.observe()
    assert (moved.speed > 0).any()
    assert (moved.odometry != 0).any()


def test_odometry_drifts_unless_there_is_no_noise(scenes, episodes):
    for noise in (True, False):
        task = CarTask(scenes, episodes, np.random.default_rng(0), noise=noise)
        for _ in range(10):
            task.step(np.tile([1.0, 0.0], (len(task), 1)))
        gone = np.linalg.norm(task.poses[:, :2] - task.path[0][:, :2], axis=1)
        off = np.abs(np.linalg.norm(task.odometry[:, :2], axis=1) - gone)
        assert (off.max() > 1e-3) == noise


def test_a_car_that_does_not_fit_is_turned_as_little_as_need_be():
    scene = Scene(make_box())
    poses = np.array([[0.2, 5.0, np.pi - 0.1], [5.0, 5.0, 1.0], [5.0, 0.2, -1.2]])
    fitting = turned_to_fit(scene, poses)
    assert is_free(scene, CAR, fitting).all()
    assert (fitting[:, :2] == poses[:, :2]).all()
    assert fitting[1, 2] == 1.0
    turned = np.abs(np.angle(np.exp(1j * (fitting - poses)[:, 2])))
    for row in (0, 2):
        assert 0 < turned[row] < np.pi / 2
        nearer = poses[[row, row]] + [
            [0, 0, turned[row] - np.pi / 18],
            [0, 0, np.pi / 18 - turned[row]],
        ]
        assert not is_free(scene, CAR, nearer).any()
    with pytest.raises(InputError, match=r"the car does not fit at \(0.05, 5.00\)"):
        turned_to_fit(scene, np.array([[0.05, 5.0, 0.0]]))


@pytest.mark.full
def test_the_agents_of_the_round_robot_find_goals_with_the_car(scenes, episodes):
    found = []
    for make in (
        OracleExplorer,
        lambda task: NTSAgent(TrueGeometry(task), np.random.default_rng(1)),
    ):
        task = CarTask(scenes, episodes, np.random.default_rng(0))
        explore(task, make(task))
        found.append(task)
        travelled = task.travelled[task.success]
        assert (travelled > task.episodes.shortest[task.success] - 1.0).all()
        assert task.spl.max() <= 1.0
    oracle, nts = found
    assert oracle.success.all()
    assert oracle.spl.mean() > 0.8
    assert nts.success.mean() > 0.8
    assert nts.collisions.sum() <= 2


def test_the_same_seed_gives_the_same_bytes(scenes, episodes):
    rolled = []
    for seed in (4, 4, 5):
        task, rng = CarTask(scenes, episodes, np.random.default_rng(seed)), np.random.default_rng(6)
        for _ in range(5):
            task.step(rng.normal(size=(len(task), 2)))
        rolled.append(task.poses.tobytes() + task.odometry.tobytes())
    assert rolled[0] == rolled[1] != rolled[2]


def test_wrong_waypoints_are_refused():
    task = in_a_hall(2)
    for waypoints in ([0, 1], [[1.0, 0.0]], [[np.inf, 0.0], [1.0, 0.0]], [["a", 0.0], [1.0, 0.0]]):
        with pytest.raises(InputError, match="waypoints: "):
            task.step(waypoints)
    assert task.steps.tolist() == [0, 0]
