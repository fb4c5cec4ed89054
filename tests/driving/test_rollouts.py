import numpy as np
import pytest

from tutorial_lib.driving.control.oracle import OraclePolicy
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.driving.rollouts import (
    SETTLED,
    STUCK,
    NavigationEnds,
    ReachGoals,
    geodesic_limit,
    rollout,
)
from tutorial_lib.errors import InputError
from tutorial_lib.world.bodies import DifferentialDrive
from tutorial_lib.world.people import Person
from tutorial_lib.world.sensors import PanoramicCamera
from tutorial_lib.world.simulation import Sensors, Simulation

AHEAD = np.array([[2.0, 2.0, 0.0], [2.0, 4.0, 0.0], [2.0, 6.0, 0.0], [8.0, 8.0, 0.0]])


class Straight:
    """A policy: everybody straight ahead; it notes for which robots."""

    def __init__(self):
        self.queried = []

    def act(self, observations, robots):
        assert len(observations) == len(robots)
        self.queried.append(robots.copy())
        return np.tile([0.5, 0.0], (len(robots), 1))


def drive_straight(box, **extra):
    """Near goal, far goal, goal out of reach in time, wall before the goal."""
    goals = [[3.0, 2.0], [5.0, 4.0], [9.0, 6.0], [9.99, 8.0]]
    ends = ReachGoals(goals, [20.0, 20.0, 2.0, 20.0], **extra)
    return rollout(Simulation(box, AHEAD), Straight(), ends)


def test_each_rollout_ends_for_its_own_reason(box):
    rollouts = drive_straight(box)
    assert rollouts.reached.tolist() == [True, True, False, False]
    assert rollouts.collided.tolist() == [False, False, False, True]
    assert rollouts.seconds[2] == pytest.approx(2.0)
    # (1 - 0.3) and (3 - 0.3) metres at 0.5 m/s, and a little for gathering speed.
    assert rollouts.seconds[0] == pytest.approx(1.4, abs=0.5)
    assert rollouts.seconds[1] - rollouts.seconds[0] == pytest.approx(4.0, abs=0.11)
    assert rollouts.poses.shape == (round(rollouts.seconds.max() * 10) + 1, 4, 3)


def test_what_counts_as_reached_can_be_wider(box):
    wide = drive_straight(box, reached=0.8)
    assert (wide.seconds[:2] < drive_straight(box).seconds[:2]).all()
    assert wide.reached[3]  # now before the wall


def test_the_policy_acts_only_for_robots_under_way(box):
    policy = Straight()
    goals = [[3.0, 2.0], [5.0, 4.0], [9.0, 6.0], [9.99, 8.0]]
    rollouts = rollout(Simulation(box, AHEAD), policy, ReachGoals(goals, 15.0))
    steps = np.array([sum(robot in robots for robots in policy.queried) for robot in range(4)])
    assert steps.tolist() == np.round(rollouts.seconds * 10).tolist()
    assert policy.queried[0].tolist() == [0, 1, 2, 3]
    assert len(set(steps)) == 4


def test_a_robot_that_has_arrived_stands_still(box):
    rollouts = drive_straight(box)
    # 0.3 m before the goal at 0.5 m/s; it rolls to a stop and never comes to the goal.
    track = rollouts.poses[:, 0, 0]
    assert track[-1] == track[-10]
    assert track[-1] < 3.0


def test_actions_belong_to_the_robots_that_are_left(box):
    # Each robot's speed is its own number; they end one after the other.
    class ByNumber:
        def act(self, observations, robots):
            return np.column_stack([0.2 * (robots + 1), np.zeros(len(robots))])

    starts = np.array([[2.0, 2.0, 0.0], [2.0, 4.0, 0.0], [2.0, 6.0, 0.0]])
    ends = ReachGoals(starts[:, :2] + [6.0, 0.0], [9.0, 6.0, 3.0])
    rollouts = rollout(Simulation(box, starts), ByNumber(), ends)
    # Three robots, the fastest with the least time: 1.8, 2.4 and 1.8 m, and no one else's speed.
    gone = rollouts.poses[-1, :, 0] - 2.0
    assert gone == pytest.approx([1.8, 2.4, 1.8], abs=0.3)


def test_a_recorder_sees_what_the_policy_saw(box):
    acted, kept = [], []

    class Noting:
        def act(self, observations, robots):
            actions = np.column_stack([np.full(len(robots), 0.5), 0.01 * robots])
            acted.append((simulation.poses.copy(), robots.copy(), observations, actions))
            return actions

    def record(simulation, robots, observations, actions):
        kept.append((simulation.poses.copy(), robots.copy(), observations, actions))

    goals = [[3.0, 2.0], [5.0, 4.0], [9.0, 6.0], [9.99, 8.0]]
    simulation = Simulation(box, AHEAD)
    rollout(simulation, Noting(), ReachGoals(goals, 8.0), record)
    assert len(acted) == len(kept) > 10
    for mine, other in zip(acted, kept, strict=True):
        assert mine[2] is other[2]
        assert all((mine[i] == other[i]).all() for i in (0, 1, 3))


@pytest.mark.parametrize(
    ("goals", "limit"),
    [
        ([[3.0, 3.0]], 5.0),
        ([[3.0, np.nan]] * 4, 5.0),
        ([[3.0, 3.0]] * 4, np.inf),
        ([[3.0, 3.0]] * 4, [5.0, 5.0]),
    ],
)
def test_a_rollout_that_cannot_end_is_refused(box, goals, limit):
    with pytest.raises(InputError, match=r"(goals|limit): "):
        rollout(Simulation(box, AHEAD), Straight(), ReachGoals(goals, limit))


@pytest.mark.parametrize("actions", [np.zeros((3, 2)), np.full((4, 2), np.nan), np.zeros(4)])
def test_actions_that_are_none_are_refused(box, actions):
    policy = Straight()
    policy.act = lambda observations, robots: actions
    with pytest.raises(InputError, match=r"actions: .*(4 robots|finite|\(M, 2\))"):
        rollout(Simulation(box, AHEAD), policy, ReachGoals(AHEAD[:, :2], 5.0))


def test_the_oracle_acts_for_some_as_for_all(pillars):
    rng = np.random.default_rng(1)
    starts = np.column_stack([rng.uniform(1, 2, (6, 2)), rng.uniform(-3, 3, 6)])
    simulation, goals = Simulation(pillars, starts), rng.uniform([7, 5], [9, 9], (6, 2))
    oracle = OraclePolicy(simulation, GridPaths(pillars.clearance), goals)
    for _ in range(5):
        everybody = oracle.act(simulation.observe(), np.arange(6))
        some = np.array([4, 1])
        assert (oracle.act(simulation.observe(some), some) == everybody[some]).all()
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
    # Without the right viewers, robot 3's obstacle would be seen by no robot or by another.
    alone = Simulation(pillars, simulation.poses, sensors=sensors).observe()
    assert (everybody.laser[[1, 3]] != alone.laser[[1, 3]]).any(axis=1).all()
    for robots in ([3, 1], [3], [0, 2, 4], [], [4, 3, 2, 1, 0]):
        robots = np.array(robots, dtype=np.intp)
        some = simulation.observe(robots)
        assert len(some) == len(robots)
        assert (some.body, some.camera) == (simulation.body, sensors.camera)
        for name, array in vars(everybody).items():
            if isinstance(array, np.ndarray):
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


# Robots that stand still for good.


class StopAndGo:
    """Robot 0 never moves, 1 goes and stops for good, 2 rests twice, 3 and 4 never rest."""

    def __init__(self):
        self.queried = []

    def act(self, observations, robots):
        now = round(0.1 * len(self.queried), 3)
        self.queried.append(robots.tolist())
        rests = 1.0 < now < 1.9 or 3.0 < now < 3.9
        speed = [0.0, 0.5 if now < 2.0 else 0.0, 0.0 if rests else 0.5, 0.5, 0.004]
        return np.column_stack([np.array(speed)[robots], np.zeros(len(robots))])


ROWS = np.array([[1.0, y, 0.0] for y in (1.0, 3.0, 5.0, 7.0, 9.0)])
GOALS = ROWS[:, :2] + [7.0, 0.0]


def test_a_robot_that_stands_still_for_good_is_done_and_one_that_rests_is_not(box):
    rollouts = rollout(Simulation(box, ROWS), StopAndGo(), ReachGoals(GOALS, 16.0, settle=True))
    assert rollouts.reached.tolist() == [False, False, True, True, False]
    assert not rollouts.collided.any()
    # A step more or less than the second that they must stand still.
    assert rollouts.seconds[0] == pytest.approx(SETTLED, abs=0.11)
    assert rollouts.seconds[1] == pytest.approx(2.0 + 0.25 + SETTLED, abs=0.25)
    assert rollouts.seconds[4] == pytest.approx(16.0, abs=0.11)
    assert rollouts.seconds[2] == pytest.approx(rollouts.seconds[3] + 1.8, abs=0.3)


def test_rests_do_not_add_up(box):
    resting = Straight()
    resting.act = lambda observations, robots: np.array([[next(speeds), 0.0]])
    speeds = iter(([0.5] * 8 + [0.0] * 8) * 40)
    ends = ReachGoals(GOALS[:1], 60.0, settle=True)
    rollouts = rollout(Simulation(box, ROWS[:1]), resting, ends)
    assert rollouts.reached[0]
    moved = np.abs(np.diff(rollouts.poses[:, 0], axis=0)).max(axis=1) > 1e-4
    assert (~moved).sum() > 2 * SETTLED / 0.1


def test_without_settle_no_rollout_ends_for_standing_still(box):
    rollouts = rollout(Simulation(box, ROWS), StopAndGo(), ReachGoals(GOALS, 16.0))
    assert rollouts.seconds[[0, 1, 4]] == pytest.approx(16.0, abs=0.11)


def test_a_robot_that_has_settled_acts_no_more(box):
    policy = StopAndGo()
    rollouts = rollout(Simulation(box, ROWS), policy, ReachGoals(GOALS, 16.0, settle=True))
    steps = [sum(robot in robots for robots in policy.queried) for robot in range(5)]
    assert steps == np.round(rollouts.seconds * 10).astype(int).tolist()


def test_a_robot_that_turns_in_place_does_not_stand_still(box):
    turning = Straight()
    turning.act = lambda observations, robots: np.tile([0.0, 0.2], (len(robots), 1))
    simulation = Simulation(box, ROWS[:1], body=DifferentialDrive())
    rollouts = rollout(simulation, turning, ReachGoals(GOALS[:1], 5.0, settle=True))
    assert rollouts.seconds[0] == pytest.approx(5.0, abs=0.11)


def test_settling_changes_nothing_for_robots_that_drive(pillars):
    rng = np.random.default_rng(1)
    starts = np.column_stack([rng.uniform(1, 2, (8, 2)), rng.uniform(-3, 3, 8)])
    goals = rng.uniform([7, 5], [9, 9], (8, 2))
    paths, both = GridPaths(pillars.clearance), []
    for settle in (False, True):
        simulation = Simulation(pillars, starts)
        ends = ReachGoals(goals, 30.0, settle=settle)
        both.append(rollout(simulation, OraclePolicy(simulation, paths, goals), ends))
    assert both[0].reached.sum() >= 6
    still = both[1].seconds < both[0].seconds
    assert (both[0].reached == both[1].reached).all()
    assert (both[0].collided == both[1].collided).all()
    assert not (still & both[0].reached).any()


class Declares:
    """A navigation whose robots stand or drive ahead, and declare something after so many steps."""

    def __init__(self, arrive, give_up, speeds):
        self.after = np.array([arrive, give_up], dtype=float)
        self.speeds, self.steps = np.array(speeds), 0
        self.arrived, self.given_up = np.zeros((2, len(speeds)), bool)

    def act(self, observations, robots):
        self.steps += 1
        self.arrived[:], self.given_up[:] = self.steps >= self.after
        return np.column_stack([self.speeds[robots], np.zeros(len(robots))])


def test_a_navigation_ends_as_it_declares_or_stuck_or_late(box):
    starts = [[2.0, y, 0.0] for y in (2.0, 4.0, 6.0)] + [[9.2, 8.0, 0.0]]
    never = np.inf
    navigation = Declares([3, never, never, never], [never, 5, never, never], [0, 0, 0, 0.5])
    found = rollout(Simulation(box, starts), navigation, NavigationEnds(navigation, 6.0))
    assert found.ending.tolist() == ["arrived", "gave_up", "late", "stuck"]
    assert found.seconds[:3] == pytest.approx([0.3, 0.5, 6.0], abs=0.11)
    assert STUCK < found.seconds[3] < 6.0
    again = Declares([never] * 4, [never] * 4, [0] * 4)
    limits = NavigationEnds(again, [0.2, 0.4, 0.6, 0.8])
    found = rollout(Simulation(box, starts), again, limits)
    assert found.seconds == pytest.approx([0.2, 0.4, 0.6, 0.8], abs=0.11)
    for wrong in (np.nan, -1.0, "soon"):
        with pytest.raises(InputError, match="limit: "):
            NavigationEnds(again, wrong)
    with pytest.raises(InputError, match=r"limit: shape \(2,\); give seconds for 4 robots"):
        rollout(Simulation(box, starts), again, NavigationEnds(again, [1.0, 2.0]))


def test_a_navigation_is_of_as_many_robots_as_the_simulation(box):
    simulation = Simulation(box, [[2.0, 2.0, 0.0], [2.0, 4.0, 0.0]])
    for count in (1, 3):
        other = Declares([3] * count, [np.inf] * count, [0] * count)
        with pytest.raises(InputError, match=f"robots: 2 in the simulation, {count} in the"):
            rollout(simulation, other, NavigationEnds(other, 6.0))


def test_a_navigation_that_has_arrived_does_not_begin_again(box):
    navigation = Declares([3, 3], [np.inf, np.inf], [0, 0])
    starts = [[2.0, 2.0, 0.0], [2.0, 4.0, 0.0]]
    first = rollout(Simulation(box, starts), navigation, NavigationEnds(navigation, 6.0))
    assert first.ending.tolist() == ["arrived", "arrived"]
    with pytest.raises(InputError, match="navigation: arrived before it begins; start a new one"):
        rollout(Simulation(box, starts), navigation, NavigationEnds(navigation, 6.0))


def test_a_navigation_may_give_up_before_it_begins(box):
    navigation = Declares([np.inf, np.inf], [0, 0], [0, 0])
    navigation.given_up[:] = True
    simulation = Simulation(box, [[2.0, 2.0, 0.0], [2.0, 4.0, 0.0]])
    found = rollout(simulation, navigation, NavigationEnds(navigation, 6.0))
    assert found.ending.tolist() == ["gave_up", "gave_up"]


def test_the_navigation_that_is_watched_is_the_one_that_drives(box):
    simulation = Simulation(box, [[2.0, 2.0, 0.0]])
    drives, watched = Declares([3], [9], [0]), Declares([3], [9], [0])
    with pytest.raises(InputError, match=r"policy: .* is another navigation than `ends` watches"):
        rollout(simulation, drives, NavigationEnds(watched, 6.0))
    assert np.array_equal(simulation.poses, [[2.0, 2.0, 0.0]])


class Own:
    """Ends after a step as it is told to."""

    def __init__(self, endings):
        self.endings = endings

    def after_step(self, simulation, seconds, before):
        return self.endings


@pytest.mark.parametrize(
    ("endings", "message"),
    [
        (None, "after_step: None; give a Mapping"),
        ([("over", [True, True])], "after_step: .* give a Mapping"),
        ({"": [True, True]}, "after_step: an ending ''; give it a name"),
        ({3: [True, True]}, "after_step: an ending 3; give it a name"),
        ({"over": None}, "after_step: over: None; give truth values"),
        ({"over": [0.5, 1.0]}, "after_step: over: 0.5; give True or False"),
        ({"over": [True]}, r"after_step: over: shape \(1,\); give truth values of shape \(2,\)"),
    ],
)
def test_endings_are_names_with_truth_values_of_each_robot(box, endings, message):
    simulation = Simulation(box, [[2.0, 2.0, 0.0], [2.0, 4.0, 0.0]])
    with pytest.raises(InputError, match=message):
        rollout(simulation, OnlyActs(), Own(endings))


def test_endings_may_have_long_names(box):
    simulation = Simulation(box, [[2.0, 2.0, 0.0], [2.0, 4.0, 0.0]])
    names = {"came as far as the kitchen": [1, 0], "came as far as the kitchen door": [0, 1]}
    assert rollout(simulation, OnlyActs(), Own(names)).ending.tolist() == list(names)


@pytest.mark.parametrize("name", ["arrived", "given_up"])
@pytest.mark.parametrize("value", [[False], ["no", "no"], None])
def test_what_a_navigation_declares_are_truth_values_of_each_robot(box, name, value):
    simulation = Simulation(box, [[2.0, 2.0, 0.0], [2.0, 4.0, 0.0]])
    navigation = Declares([9, 9], [9, 9], [0, 0])
    ends = NavigationEnds(navigation, 6.0)
    setattr(navigation, name, value)
    with pytest.raises(InputError, match=f"^{name}: "):
        ends.after_step(simulation, np.zeros(2), simulation.poses)


def test_what_never_declares_anything_is_no_navigation():
    with pytest.raises(InputError, match="give an object that has arrived and given_up"):
        NavigationEnds(OnlyActs(), 6.0)


class Late(Declares):
    """It knows of its robots from the first step on."""

    def __init__(self):
        super().__init__([1, 1], [np.inf, np.inf], [0, 0])
        self.arrived = None

    def act(self, observations, robots):
        self.arrived = np.zeros(2, dtype=bool) if self.arrived is None else self.arrived
        return super().act(observations, robots)


class Wrapped:
    """Hands on all that it does not have itself."""

    def __init__(self, inner):
        self.inner = inner

    def __getattr__(self, name):
        return getattr(self.inner, name)

    def act(self, observations, robots):
        return self.inner.act(observations, robots)


@pytest.mark.parametrize("make", [Late, lambda: Wrapped(Declares([1, 1], [9, 9], [0, 0]))])
def test_navigations_may_begin_late_and_be_wrapped(box, make):
    simulation, navigation = Simulation(box, [[2.0, 2.0, 0.0], [2.0, 4.0, 0.0]]), make()
    found = rollout(simulation, navigation, NavigationEnds(navigation, 6.0))
    assert found.ending.tolist() == ["arrived", "arrived"]


class OnlyActs:
    """A policy that declares nothing."""

    def act(self, observations, robots):
        return np.zeros((len(robots), 2))
