"""Which trip a demo shows, in which part of a plan, and which drives it learns."""

import types

import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.demos import navigate_once
from tutorial_lib.experiments.demos import task as tasks
from tutorial_lib.experiments.demos.ends import parse_end
from tutorial_lib.experiments.demos.navigation_demo import run_demo
from tutorial_lib.experiments.demos.routes import LEARNED
from tutorial_lib.experiments.demos.sureness import STEP, recognised_from, sureness
from tutorial_lib.experiments.demos.task import PART, RECOGNISED, SURE, choose_task
from tutorial_lib.experiments.protocols.navigation import FACING
from tutorial_lib.geometry import wrap
from tutorial_lib.learning.estimators import ReachabilityNetwork, WaypointNetwork
from tutorial_lib.learning.networks import Architecture, LocalNetwork
from tutorial_lib.world.generators import generate
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera


@pytest.fixture(scope="module")
def agent():
    return agents.meng()


@pytest.fixture(scope="module")
def flat():
    return Scene(generate("apartment", 0))


@pytest.fixture(scope="module")
def usual(flat, agent):
    return choose_task(flat, 0, 6, agent)


def gaps(drive, pose):
    """Metres from all frames of a drive to a pose's place."""
    return np.linalg.norm(drive.poses[:, :2] - pose[:2], axis=1)


@pytest.mark.full
def test_no_drive_leads_all_along_the_trip_but_two_do_together(usual):
    start, goal = usual.trial.starts[0], usual.trial.goal_poses[0]
    first, last, *others = usual.building.recorded.trajectories
    assert gaps(first, start).min() < 0.5 < 2.0 < gaps(first, goal).min()
    assert gaps(last, goal).min() < 0.5 < 2.0 < gaps(last, start).min()
    apart = np.linalg.norm(first.poses[:, None, :2] - last.poses[None, :, :2], axis=2)
    turned = np.abs(wrap(first.poses[:, None, 2] - last.poses[None, :, 2]))
    together = ((apart < 0.4) & (turned < 0.4)).any(axis=1)
    assert 10 * 0.1 * together.sum() > 10  # some metres, at a frame each decimetre
    for drive in others:  # none of the rest does it alone
        assert max(gaps(drive, start).min(), gaps(drive, goal).min()) > 0.5


@pytest.mark.full
def test_the_budget_of_drives_is_kept(usual):
    metres = sum(one.arc_length[-1] for one in usual.building.recorded.trajectories)
    assert 0.5 * LEARNED < metres <= LEARNED
    assert len(usual.building.pairs) < usual.recorded == 30


@pytest.mark.full
def test_a_demo_in_a_large_hall_takes_place_in_a_part_where_re_is_sure(agent):
    plan = generate("hall", 102)  # on its open floor a drive's probability is 0.02
    scene = Scene(plan)
    task = choose_task(scene, 102, 6, agent)
    x0, y0, x1, y1 = task.bounds
    assert max(x1 - x0, y1 - y0) <= PART + 1e-9
    poses = np.concatenate([task.building.recorded.poses, task.trial.recorded.poses])[:, :2]
    assert (poses > [x0 - 0.1, y0 - 0.1]).all()
    assert (poses < [x1 + 0.1, y1 + 0.1]).all()
    along = sureness(task.building, agent)[:2]
    assert sum(np.log(one).sum() for one in along) > -5.0


@pytest.mark.full
def test_trips_of_which_re_is_sure_come_first_then_those_of_the_right_length(usual, monkeypatch):
    whole = usual.building
    lengths = np.array([one.arc_length[-1] for one in whole.recorded.trajectories])
    fits, count = np.ones(len(lengths), bool), len(lengths)
    monkeypatch.setattr(tasks, "ROOMS_AWAY", 0)
    monkeypatch.setattr(tasks, "doors_between", lambda plan: np.zeros((len(plan.rooms),) * 2))
    sure = np.full(count, SURE)
    assert tasks._trips(whole, fits, sure)[0] == np.abs(lengths - tasks.TRIP).argmin()
    sure[:] = 0.1
    sure[3] = 0.5
    assert tasks._trips(whole, fits, sure)[0] == 3
    fits[3] = False
    assert 3 not in tasks._trips(whole, fits, sure)


@pytest.mark.full
def test_a_trip_leads_between_rooms_asked_for(flat, agent):
    start, goal = parse_end("--start", "bedroom 3"), parse_end("--goal", "kitchen")
    task = choose_task(flat, 0, 3, agent, start=start, goal=goal)
    assert task.rooms == ("bedroom 3", "kitchen")


@pytest.mark.full
def test_a_trip_leads_between_poses_asked_for(flat, agent, usual):
    x, y, heading = usual.trial.starts[0].tolist()
    goal = usual.trial.goal_poses[0].tolist()
    ends = (f"{x!r},{y!r},{heading!r}", ",".join(map(repr, goal)))
    asked = {
        name: parse_end(f"--{name}", text)
        for name, text in zip(("start", "goal"), ends, strict=True)
    }
    task = choose_task(flat, 1, 3, agent, **asked)
    assert task.trial.starts[0].tolist() == [x, y, heading]
    arrived = task.trial.goal_poses[0]
    assert np.linalg.norm(arrived[:2] - goal[:2]) < 0.45
    assert abs(wrap(arrived[2] - goal[2])) < FACING  # within which an arrival is right
    with pytest.raises(InputError, match=r"--goal: 0\.\d m from the start; choose places 3 m"):
        choose_task(flat, 1, 4, agent, start=asked["start"], goal=parse_end("--goal", ends[0]))


def test_a_goal_that_faces_out_of_a_corner_is_refused(agent):
    with pytest.raises(InputError, match=r"--goal: no room to arrive at .* turn it"):
        choose_task(Scene(make_box(8.0, 6.0)), 0, 4, agent, goal=parse_end("--goal", "0.5,3,0"))


def test_places_outside_the_part_widen_it():
    scene = Scene(make_box(80.0, 8.0))
    paths = GridPaths(scene.clearance)
    rng = np.random.default_rng(0)
    part, bounds = tasks._part_of(scene, paths, np.array([[20.0, 4.0]]), rng)
    assert bounds.tolist() == pytest.approx([5.0, 0.0, 35.0, 8.0])
    assert len(part.points) < len(paths.points)
    both = np.array([[10.0, 4.0], [60.0, 4.0]])
    part, bounds = tasks._part_of(scene, paths, both, rng)
    assert bounds[0] == pytest.approx(2.0)
    assert bounds[2] == pytest.approx(68.0)


class SureFrom:
    """RE that is sure from given numbers of the observations, and of nothing else."""

    def __init__(self, places):
        self.places = places

    def prepare(self, contexts):
        return np.zeros(len(contexts))

    def probability(self, observations, prepared):
        del observations
        return np.where(np.isin(np.arange(len(prepared)), self.places), 0.96, 0.94)


def test_a_goal_is_recognised_from_places_near_it_unless_from_elsewhere(usual, agent):
    building, goal = usual.building, usual.trial.goal_poses[0]
    frames = np.concatenate(
        [building.recorded.frames_of(i)[::STEP] for i in range(len(building.pairs))]
    )
    gaps = np.linalg.norm(building.recorded.poses[frames, :2] - goal[:2], axis=1)
    near, far = np.argsort(gaps)[:3], gaps.argmax()
    for places, expected in ((near, 3), (near[:2], 2), ([*near, far], 0), ([], 0)):
        sure = types.SimpleNamespace(predictor=agent.predictor, reachability=SureFrom(places))
        assert recognised_from(building, usual.trial, sure) == expected


def test_the_first_trip_whose_goal_is_recognised_well_is_taken_else_the_best(
    usual, agent, monkeypatch
):
    """Trip n can be driven unless it is trip 1, and is recognised from `counts[n]` places."""
    asked = []

    def chosen(*counts):
        def recognised(building, trial, _):
            asked.append(trial)
            return counts[trial]

        asked[:] = []
        monkeypatch.setattr(tasks, "recognised_from", recognised)
        ends, sure = (None, np.nan), np.ones(len(usual.building.pairs))
        rng = np.random.default_rng(0)
        return tasks._first_trip(usual.building, range(len(counts)), *ends, sure, agent, rng)

    monkeypatch.setattr(tasks, "_trial", lambda whole, number, *_: None if number == 1 else number)
    monkeypatch.setattr(tasks, "learned", lambda whole, number, *_: f"drives of {number}")
    assert chosen(2, 9, RECOGNISED, 9) == ("drives of 2", 2)
    assert asked == [0, 2]
    assert chosen(1, 0, 3, 2) == ("drives of 2", 2)
    assert asked == [0, 2, 3]
    assert chosen(0, 9) == ("drives of 0", 0)
    monkeypatch.setattr(tasks, "_trial", lambda *_: None)
    assert chosen(9, 9) is None


@pytest.mark.parametrize(
    ("goal", "words"),
    [([1.0, 2.0], r"goal: .*\(3,\)"), ([1e3, 0.0, 0.0], "outside all rooms")],
)
def test_a_goal_that_cannot_be_had_is_refused(flat, goal, words):
    with pytest.raises(InputError, match=words):
        navigate_once(flat, 0, 4, goal)


def test_a_task_is_chosen_and_shown_through_the_camera_that_was_given():
    narrow = Camera(field_of_view=float(np.deg2rad(90.0)))
    seen_by = [
        LocalNetwork(Architecture(5, view="camera16_90", outputs=outputs)).eval()
        for outputs in ("waypoint", "reachability")
    ]
    parts = WaypointNetwork(seen_by[0]), RMPController(), ReachabilityNetwork(seen_by[1])
    agent = MengAgent(predictor=parts[0], controller=parts[1], reachability=parts[2])
    scene = Scene(make_box(pillars=[(3.0, 3.0, 0.5), (6.5, 4.0, 0.3)]))
    # Its networks refuse images of another camera.
    task = choose_task(scene, 0, 2, agent, camera=narrow)
    assert task.building.camera == narrow
    sharp = Camera(rows=64, columns=192, field_of_view=narrow.field_of_view)
    assert (task.image == sharp.look(scene, task.trial.goal_poses)[0][0]).all()


def test_a_body_that_is_too_large_is_named(tmp_path):
    path = tmp_path / "fat.py"
    path.write_text(
        "from tutorial_lib.world import BicycleCar\n\n\n"
        "def fat():\n    return BicycleCar(wheelbase=1.0, length=1.4, width=1.2)\n"
    )
    with pytest.raises(InputError, match=r"inside a wall.*; or a smaller body in --robot .*:fat"):
        run_demo(generate("apartment", 0), 0, tmp_path, robot=f"{path}:fat")
    assert not list(tmp_path.glob("demo.*"))
