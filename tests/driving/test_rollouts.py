import numpy as np
import pytest

from tutorial_lib.driving.control.oracle import OraclePolicy
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.driving.rollouts import SETTLED, drive, geodesic_limit
from tutorial_lib.errors import InputError
from tutorial_lib.world.bodies import DifferentialDrive
from tutorial_lib.world.people import Person
from tutorial_lib.world.sensors import PanoramicCamera
from tutorial_lib.world.simulation import Sensors, Simulation

AHEAD = np.array([[2.0, 2.0, 0.0], [2.0, 4.0, 0.0], [2.0, 6.0, 0.0], [8.0, 8.0, 0.0]])


def straight(simulation, robots):
    return np.tile([0.5, 0.0], (len(robots), 1))


def drive_straight(box, **extra):
    """Near goal, far goal, goal out of reach in time, wall before the goal."""
    goals = [[3.0, 2.0], [5.0, 4.0], [9.0, 6.0], [9.99, 8.0]]
    return drive(Simulation(box, AHEAD), straight, goals, [20.0, 20.0, 2.0, 20.0], **extra)


def test_each_drive_ends_for_its_own_reason(box):
    drives = drive_straight(box)
    assert drives.reached.tolist() == [True, True, False, False]
    assert drives.collided.tolist() == [False, False, False, True]
    assert drives.seconds[2] == pytest.approx(2.0)
    # (1 - 0.3) and (3 - 0.3) metres at 0.5 m/s, and a little for gathering speed.
    assert drives.seconds[0] == pytest.approx(1.4, abs=0.5)
    assert drives.seconds[1] - drives.seconds[0] == pytest.approx(4.0, abs=0.11)
    assert drives.poses.shape == (round(drives.seconds.max() * 10) + 1, 4, 3)


def test_what_counts_as_reached_can_be_wider(box):
    wide = drive_straight(box, reached=0.8)
    assert (wide.seconds[:2] < drive_straight(box).seconds[:2]).all()
    assert wide.reached[3]  # now before the wall


def test_the_driver_is_asked_only_for_those_under_way(box):
    asked = []

    def driver(simulation, robots):
        asked.append(robots.copy())
        return straight(simulation, robots)

    goals = [[3.0, 2.0], [5.0, 4.0], [9.0, 6.0], [9.99, 8.0]]
    drives = drive(Simulation(box, AHEAD), driver, goals, 15.0)
    steps = np.array([sum(robot in robots for robots in asked) for robot in range(4)])
    assert steps.tolist() == np.round(drives.seconds * 10).tolist()
    assert asked[0].tolist() == [0, 1, 2, 3]
    assert len(set(steps)) == 4


def test_who_has_arrived_stands_still(box):
    drives = drive_straight(box)
    # 0.3 m before the goal at 0.5 m/s; it rolls to a stop and never comes to the goal.
    track = drives.poses[:, 0, 0]
    assert track[-1] == track[-10]
    assert track[-1] < 3.0


def test_actions_belong_to_the_robots_that_are_left(box):
    # Each robot is told its own number as speed; they end one after the other.
    def driver(simulation, robots):
        return np.column_stack([0.2 * (robots + 1), np.zeros(len(robots))])

    starts = np.array([[2.0, 2.0, 0.0], [2.0, 4.0, 0.0], [2.0, 6.0, 0.0]])
    drives = drive(Simulation(box, starts), driver, starts[:, :2] + [6.0, 0.0], [9.0, 6.0, 3.0])
    # Three robots, the fastest with the least time: 1.8, 2.4 and 1.8 m, and no one else's speed.
    gone = drives.poses[-1, :, 0] - 2.0
    assert gone == pytest.approx([1.8, 2.4, 1.8], abs=0.3)


def test_a_recorder_sees_what_the_driver_saw(box):
    told, kept = [], []

    def driver(simulation, robots):
        actions = np.column_stack([np.full(len(robots), 0.5), 0.01 * robots])
        told.append((simulation.poses.copy(), robots.copy(), actions))
        return actions

    def record(simulation, robots, actions):
        kept.append((simulation.poses.copy(), robots.copy(), actions))

    goals = [[3.0, 2.0], [5.0, 4.0], [9.0, 6.0], [9.99, 8.0]]
    drive(Simulation(box, AHEAD), driver, goals, 8.0, record=record)
    assert len(told) == len(kept) > 10
    for mine, theirs in zip(told, kept, strict=True):
        assert all((a == b).all() for a, b in zip(mine, theirs, strict=True))


@pytest.mark.parametrize(
    ("goals", "limit"),
    [
        ([[3.0, 3.0]], 5.0),
        ([[3.0, np.nan]] * 4, 5.0),
        ([[3.0, 3.0]] * 4, np.inf),
        ([[3.0, 3.0]] * 4, [5.0, 5.0]),
    ],
)
def test_a_drive_that_cannot_end_is_refused(box, goals, limit):
    with pytest.raises(InputError, match="drive"):
        drive(Simulation(box, AHEAD), straight, goals, limit)


def test_the_courier_acts_for_some_as_for_all(pillars):
    rng = np.random.default_rng(1)
    starts = np.column_stack([rng.uniform(1, 2, (6, 2)), rng.uniform(-3, 3, 6)])
    courier = OraclePolicy(GridPaths(pillars.clearance), rng.uniform([7, 5], [9, 9], (6, 2)))
    simulation = Simulation(pillars, starts)
    for _ in range(5):
        everybody = courier.act(simulation)
        some = np.array([4, 1])
        assert (courier.act(simulation, some) == everybody[some]).all()
        simulation.step(everybody)


def test_the_limit_is_that_of_the_geodesic(box):
    starts = [[2.0, 2.0, 0.0], [2.0, 5.0, 1.0]]
    limit = geodesic_limit(GridPaths(box.clearance), starts, [[8.0, 2.0], [5.0, 5.0]])
    assert limit == pytest.approx([6 / 0.3 + 5, 3 / 0.3 + 5], abs=0.5)


@pytest.mark.parametrize("sensors", [Sensors(with_depth=True), Sensors(camera=PanoramicCamera())])
def test_observing_some_is_observing_all_and_choosing(pillars, sensors):
    rng = np.random.default_rng(2)
    starts = np.column_stack([rng.uniform(1, 2, (5, 2)), rng.uniform(-0.5, 0.5, 5)])
    people = [Person([starts[k, :2] + [0.8, 0.0]], owner=k, radius=0.1) for k in (1, 3)]
    people.append(Person([[6.0, 1.0], [6.0, 2.0]]))
    simulation = Simulation(pillars, starts, people=people, sensors=sensors)
    for _ in range(3):
        simulation.step(rng.uniform(-0.1, 0.2, (5, 2)))
    everybody = simulation.observe()
    # Without the right viewers, robot 3's obstacle would be seen by nobody or by another.
    alone = Simulation(pillars, simulation.poses, sensors=sensors).observe()
    assert (everybody.laser[[1, 3]] != alone.laser[[1, 3]]).any(axis=1).all()
    for robots in ([3, 1], [3], [0, 2, 4], [], [4, 3, 2, 1, 0]):
        robots = np.array(robots, dtype=np.intp)
        some = simulation.observe(robots)
        assert len(some) == len(robots)
        for name, array in vars(everybody).items():
            if array is not None:
                assert (getattr(some, name) == array[robots]).all()
                assert getattr(some, name).shape == array[robots].shape


def test_without_a_camera_there_are_no_pictures(box):
    with_camera = Simulation(box, AHEAD).observe()
    without = Simulation(box, AHEAD, sensors=Sensors(camera=None)).observe()
    assert without.image.shape == (4, 0, 0, 3)
    assert without.image.dtype == np.uint8
    assert without.depth is None
    assert (without.laser == with_camera.laser).all()
    assert len(without[np.array([1, 2])]) == 2
    with pytest.raises(InputError, match="depth needs a camera"):
        Sensors(camera=None, with_depth=True)


# Who stands still for good.


def stop_and_go(simulation, robots):
    """Robot 0 never moves, 1 goes and stops for good, 2 rests twice, 3 and 4 never rest."""
    now = round(simulation.seconds, 3)
    rests = 1.0 < now < 1.9 or 3.0 < now < 3.9
    speed = [0.0, 0.5 if now < 2.0 else 0.0, 0.0 if rests else 0.5, 0.5, 0.004]
    return np.column_stack([np.array(speed)[robots], np.zeros(len(robots))])


ROWS = np.array([[1.0, y, 0.0] for y in (1.0, 3.0, 5.0, 7.0, 9.0)])
GOALS = ROWS[:, :2] + [7.0, 0.0]


def test_who_stands_still_for_good_is_done_and_who_rests_is_not(box):
    drives = drive(Simulation(box, ROWS), stop_and_go, GOALS, 16.0, settle=True)
    assert drives.reached.tolist() == [False, False, True, True, False]
    assert not drives.collided.any()
    # A step more or less than the second that they must stand still.
    assert drives.seconds[0] == pytest.approx(SETTLED, abs=0.11)
    assert drives.seconds[1] == pytest.approx(2.0 + 0.25 + SETTLED, abs=0.25)
    assert drives.seconds[4] == pytest.approx(16.0, abs=0.11)
    assert drives.seconds[2] == pytest.approx(drives.seconds[3] + 1.8, abs=0.3)


def test_unless_asked_nobody_is_given_up_for_standing_still(box):
    drives = drive(Simulation(box, ROWS), stop_and_go, GOALS, 16.0)
    assert drives.seconds[[0, 1, 4]] == pytest.approx(16.0, abs=0.11)


def test_who_has_settled_is_asked_no_more(box):
    asked = []

    def driver(simulation, robots):
        asked.append(robots.tolist())
        return stop_and_go(simulation, robots)

    drives = drive(Simulation(box, ROWS), driver, GOALS, 16.0, settle=True)
    steps = [sum(robot in robots for robots in asked) for robot in range(5)]
    assert steps == np.round(drives.seconds * 10).astype(int).tolist()


def test_who_turns_on_the_spot_does_not_stand_still(box):
    def turning(simulation, robots):
        return np.tile([0.0, 0.2], (len(robots), 1))

    simulation = Simulation(box, ROWS[:1], body=DifferentialDrive())
    drives = drive(simulation, turning, GOALS[:1], 5.0, settle=True)
    assert drives.seconds[0] == pytest.approx(5.0, abs=0.11)


def test_settling_changes_nothing_for_those_who_drive(pillars):
    rng = np.random.default_rng(1)
    starts = np.column_stack([rng.uniform(1, 2, (8, 2)), rng.uniform(-3, 3, 8)])
    goals = rng.uniform([7, 5], [9, 9], (8, 2))
    courier = OraclePolicy(GridPaths(pillars.clearance), goals)
    both = [
        drive(Simulation(pillars, starts), courier.act, goals, 30.0, settle=settle)
        for settle in (False, True)
    ]
    assert both[0].reached.sum() >= 6
    still = both[1].seconds < both[0].seconds
    assert (both[0].reached == both[1].reached).all()
    assert (both[0].collided == both[1].collided).all()
    assert not (still & both[0].reached).any()
