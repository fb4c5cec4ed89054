"""The task: motion and its noise, walls, how episodes end, and what agents are shown."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import make_box, random_walls
from tutorial_lib.errors import InputError
from tutorial_lib.exploration.episodes import Episodes
from tutorial_lib.exploration.motion import EXACT, move
from tutorial_lib.exploration.task import ExplorationTask, explore_on
from tutorial_lib.geometry import distance_to_segments, relative
from tutorial_lib.world.bodies import DifferentialDrive
from tutorial_lib.world.noise import FORWARD, LEFT, RIGHT, STOP
from tutorial_lib.world.raycast import Raycaster
from tutorial_lib.world.scene import Scene

RADIUS = DifferentialDrive.radius


def in_a_hall(count, goal=(20.0, 20.0, 0.0), **options):
    """Robots in the middle of a large empty room."""
    scene = Scene(make_box(40.0, 40.0))
    starts, goals = np.tile([20.0, 20.0, 0.3], (count, 1)), np.tile(goal, (count, 1))
    far = np.linalg.norm(starts[:, :2] - goals[:, :2], axis=1)
    episodes = Episodes(("hall",) * count, starts, goals, far, ("",) * count)
    return ExplorationTask({"hall": scene}, episodes, np.random.default_rng(0), **options)


def test_noise_has_the_measured_statistics():
    degrees = np.pi / 180
    expected = {
        FORWARD: ([0.245, 0, 0.0086], [0.001384, 0, 0]),
        LEFT: ([0, 0.02, 11.2 * degrees], [0, 0.02, 0.20 * degrees]),
        RIGHT: ([0, -0.02, -11.1 * degrees], [0, -0.02, 0.015 * degrees]),
    }
    for action, (mean, error) in expected.items():
        task = in_a_hall(4000)
        before = task.poses
        task.step(np.full(4000, action))
        motion = relative(before, task.poses)
        assert np.allclose(motion.mean(axis=0), mean, atol=3e-4)
        read = task.observe().odometry - motion
        assert np.allclose(read.mean(axis=0), error, atol=3e-4)
        assert read.std(axis=0)[:2] == pytest.approx(0.0026, abs=3e-4)
        assert motion[:, 2].std() < 0.6 * degrees


def test_noise_has_both_peaks_of_each_mixture_with_their_weights():
    degrees, task = np.pi / 180, in_a_hall(4000)
    before = task.poses
    task.step(np.full(4000, LEFT))
    turned = relative(before, task.poses)[:, 2] / degrees
    assert turned.std() == pytest.approx(np.hypot(0.3, 0.3), rel=0.05)
    # Two peaks 0.6 degrees apart are flatter than one, of which this were 3.
    assert ((turned - turned.mean()) ** 4).mean() / turned.var() ** 2 == pytest.approx(2.5, abs=0.2)
    motions, errors = [], []
    for _ in range(12):
        before, read = task.poses, task.odometry
        task.step(np.full(4000, FORWARD))
        motions.append(relative(before, task.poses))
        errors.append((relative(read, task.odometry) - motions[-1])[:, 0])
    motion, error = np.concatenate(motions), np.concatenate(errors)
    assert motion[:, 2].std() == pytest.approx(np.hypot(0.004, 0.0039), rel=0.03)
    assert motion[:, 0].std() == pytest.approx(0.004, rel=0.03)
    # 84% at 1.0 mm and 16% at 3.8 mm are skewed.
    means, weights = np.array([0.0010, 0.0038]), np.array([0.84, 0.16])
    far = means - weights @ means
    assert error.mean() == pytest.approx(weights @ means, rel=0.03)
    assert error.var() == pytest.approx(0.0025**2 + weights @ far**2, rel=0.03)
    assert ((error - error.mean()) ** 3).mean() == pytest.approx(weights @ far**3, rel=0.5)


def roll(task, choose, steps):
    """What robots do and read, by step: poses and odometry."""
    rows = []
    for step in range(steps):
        task.step(choose(step))
        rows.append(np.concatenate([task.poses, task.odometry], axis=1))
    return np.array(rows)


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**32 - 1), st.integers(1, 4))
@pytest.mark.full
def test_a_robot_moves_as_it_does_without_the_others(seed, fewer):
    actions = np.random.default_rng(seed).integers(1, 4, (130, 5))
    actions[actions[:, 4] == 1, 4] = STOP  # the last one stops at some time
    together = roll(in_a_hall(5), lambda step: actions[step], 130)
    alone = roll(in_a_hall(fewer), lambda step: actions[step, :fewer], 130)
    assert np.array_equal(together[:, :fewer], alone)
    assert len(np.unique(in_one_step(7), axis=0)) == 7


def in_one_step(count):
    return roll(in_a_hall(count), lambda step: np.full(count, FORWARD), 1)[0]


def test_one_that_is_done_keeps_all_that_is_counted():
    task = in_a_hall(2, (20.3, 20.0, 0))
    task.step([FORWARD, FORWARD])
    task.step([STOP, FORWARD])
    names = ("travelled", "collisions", "steps", "odometry", "poses", "spl", "success")
    before = {name: np.array(getattr(task, name)) for name in names}
    seen = task.observe()
    for _ in range(60):
        task.step([FORWARD, LEFT])
        task.step([FORWARD, FORWARD])
    for name in names:
        assert np.array_equal(getattr(task, name)[0], before[name][0]), name
    assert (task.steps[1], task.travelled[1] > 2.0) == (122, True)
    again = task.observe()
    assert np.array_equal(again.image[0], seen.image[0])
    assert np.array_equal(again.odometry[0], seen.odometry[0])


def test_from_a_pocket_the_path_begins_at_the_nearest_place_of_the_rest():
    """Four pillars with gaps that no robot passes: a place to stand, and no path from it."""
    pillars = [(20 + x, 20 + y, 0.35) for x in (-0.8, 0, 0.8) for y in (-0.8, 0, 0.8) if x or y]
    scene = Scene(make_box(40.0, 40.0, pillars))
    starts = np.array([[20.0, 20.0, 0.0], [26.0, 20.0, 0.0]])
    goals = np.array([[28.0, 20.0, 0.0]] * 2)
    episodes = Episodes(("hall",) * 2, starts, goals, np.array([8.0, 2.0]), ("",) * 2)
    task = ExplorationTask({"hall": scene}, episodes, np.random.default_rng(0), noise=False)
    task.next_goals(goals)
    task.poses = goals.copy()
    task.step([STOP, STOP])
    assert task.success.all()
    assert np.isfinite(task.spl).all()
    assert 8.0 < task._shortest[0] < 10.0
    assert task._shortest[1] == pytest.approx(2.0, abs=0.1)
    with pytest.raises(InputError, match=r"goals: shape \(1, 3\); give \(2, 3\)"):
        task.next_goals(goals[:1])
    with pytest.raises(InputError, match="goals: no path leads to"):
        task.next_goals(np.array([[20.0, 20.0, 0.0]] * 2))
    assert np.array_equal(task.goal_poses, goals)


def test_without_noise_actions_and_odometry_are_exact():
    task = in_a_hall(3, noise=False)
    for action in ([FORWARD, LEFT, RIGHT], [LEFT, FORWARD, FORWARD], [FORWARD] * 3):
        task.step(action)
    assert np.allclose(task.observe().odometry, relative(task.episodes.starts, task.poses))
    assert np.allclose(task.travelled, [0.5, 0.5, 0.5])
    assert np.allclose(EXACT[FORWARD], [0.25, 0, 0])


@settings(max_examples=60)
@given(st.integers(0, 2**32 - 1))
def test_no_step_passes_a_wall_or_enters_one(seed):
    rng = np.random.default_rng(seed)
    walls = np.concatenate([random_walls(12, 6.0, rng), [(-1, -1, 7, -1), (7, -1, 7, 7)]])
    poses = np.column_stack([rng.uniform(0, 6, (40, 2)), rng.uniform(-3, 3, 40)])
    free = distance_to_segments(poses[:, :2], walls).min(axis=1) > RADIUS
    poses = poses[free]
    caster = Raycaster(walls)
    for _ in range(6):
        motions = np.column_stack(
            [
                rng.uniform(0, 0.3, len(poses)),
                rng.normal(0, 0.05, len(poses)),
                rng.uniform(-1, 1, len(poses)),
            ]
        )
        after, stopped = move(poses, motions, walls, RADIUS)
        assert caster.sees(poses[:, :2], after[:, :2]).all()
        gap = distance_to_segments(after[:, :2], walls).min(axis=1)
        assert (gap >= RADIUS - 1e-9).all()
        whole = np.linalg.norm(motions[:, :2], axis=1)
        moved = np.linalg.norm(after[:, :2] - poses[:, :2], axis=1)
        assert np.allclose(moved[~stopped], whole[~stopped])
        assert (gap[stopped] < RADIUS + 0.011).all()  # it went on until contact
        poses = after


def test_a_robot_at_a_wall_can_leave_it():
    walls = np.array([(0.0, 0.0, 10.0, 0.0)])
    poses = np.array(
        [
            [5.0, RADIUS - 0.05, np.pi / 2],
            [5.0, RADIUS - 0.05, 0.0],
            [5.0, RADIUS - 0.05, -np.pi / 2],
        ]
    )
    after, stopped = move(poses, np.tile([0.25, 0, 0], (3, 1)), walls, RADIUS)
    assert stopped.tolist() == [False, False, True]
    assert np.allclose(after[:2, :2], [[5.0, RADIUS + 0.2], [5.25, RADIUS - 0.05]])
    assert np.allclose(after[2], poses[2])


def test_stop_ends_an_episode_and_succeeds_within_a_metre():
    for goal, reached in (((20.9, 20.0, 0), True), ((21.1, 20.0, 0), False)):
        task = in_a_hall(2, goal)
        task.step([STOP, LEFT])
        assert task.done.tolist() == [True, False]
        assert task.success.tolist() == [reached, False]
        before = task.poses
        task.step([FORWARD, FORWARD])
        assert np.array_equal(task.poses[0], before[0])  # one that is done stays
        assert task.steps.tolist() == [1, 2]


def test_spl_is_shortest_over_travelled():
    task = in_a_hall(2, (21.0, 20.0, 0), noise=False)
    task.step([FORWARD, FORWARD])
    for _ in range(8):
        task.step([STOP, FORWARD])
    assert task.success[0]
    assert task.spl[0] == 1.0
    assert task.spl[1] == 0.0
    task = in_a_hall(1, (20.5, 20.0, 0), noise=False)
    for action in (FORWARD, FORWARD, *(LEFT,) * 18, FORWARD, FORWARD, STOP):
        task.step([action])
    assert task.spl[0] == pytest.approx(0.5)


def test_an_episode_always_ends():
    task = in_a_hall(3, limit=7)
    for _ in range(7):
        assert not task.done.any()
        task.step([LEFT, RIGHT, FORWARD])
    assert task.done.all()
    assert not task.success.any()
    assert len(task.path) == 8


def test_without_the_stop_action_an_episode_ends_near_the_goal():
    task = in_a_hall(1, (21.5, 20.46, 0), noise=False, stops_itself=True)
    steps = 0
    while not task.done.all():
        task.step([FORWARD])
        steps += 1
    assert task.success.all()
    assert steps == 3


def test_agents_are_shown_pictures_and_odometry_only(scenes, episodes):
    task = ExplorationTask(scenes, episodes, np.random.default_rng(0))
    seen, goals = task.observe(), task.goals()
    assert seen.image.shape == (24, 16, 192, 3)
    assert seen.depth.shape == (24, 192)
    assert np.isnan(seen.laser).all()
    assert not seen.odometry.any()  # relative to the start, wherever that is
    assert not goals.odometry.any()
    blind = ExplorationTask(scenes, episodes, np.random.default_rng(0), sensor="rgb")
    assert blind.observe().depth is None
    assert blind.goals().depth is None
    assert np.array_equal(blind.observe().image, seen.image)
    seen.odometry[:], seen.image[:] = 5.0, 0  # an agent's copy is its own
    assert task.observe().image.any()
    assert not task.observe().odometry.any()


def test_the_same_seed_gives_the_same_bytes(scenes, episodes):
    rolled = []
    for _ in range(2):
        task = ExplorationTask(scenes, episodes, np.random.default_rng(4))
        rng = np.random.default_rng(5)
        for _ in range(15):
            task.step(rng.choice([FORWARD, FORWARD, LEFT, RIGHT], size=len(task)))
        seen = task.observe()
        rolled.append(task.poses.tobytes() + seen.odometry.tobytes() + seen.image.tobytes())
    assert rolled[0] == rolled[1]


def test_other_goals_start_where_the_robot_stands():
    task = in_a_hall(1, (20.2, 20.0, 0), noise=False)

    class Forward:
        def start(self, goals):
            self.left = 2

        def look_for(self, goals):
            self.left = 4

        def act(self, observations, running):
            self.left -= 1
            return np.array([FORWARD if self.left >= 0 else STOP])

    goals = np.array([[[20.2, 20.0, 0]], [[21.4, 20.4, 0]], [[30.0, 30.0, 0]]])
    found = list(explore_on(task, Forward(), goals))
    assert [bool(success[0]) for success, _ in found] == [True, True, False]
    assert found[1][1][0] == pytest.approx(0.98, abs=0.03)
    assert task.steps[0] == 5


def test_wrong_input_is_refused(scenes, episodes):
    rng = np.random.default_rng(0)
    with pytest.raises(InputError, match="give these scenes"):
        ExplorationTask({}, episodes, rng)
    with pytest.raises(InputError, match="sensor: 'sonar'"):
        ExplorationTask(scenes, episodes, rng, sensor="sonar")
    task = ExplorationTask(scenes, episodes, rng)
    for actions in (np.full(24, 4), np.zeros(3, int), np.full(24, -1)):
        with pytest.raises(InputError, match=r"actions: .*give whole numbers"):
            task.step(actions)
