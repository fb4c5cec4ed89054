"""The Gymnasium environment."""

import json
import warnings
from dataclasses import replace

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from tests.conftest import make_box
from tutorial_lib.environments import IMAGE_GOAL as NAME
from tutorial_lib.errors import InputError
from tutorial_lib.exploration.environment import ImageGoalNavigation
from tutorial_lib.exploration.episodes import DIFFICULTIES, exploration_world
from tutorial_lib.exploration.top_view import FLOOR, GOAL, PATH, ROBOT, SIDE, SOLID, top_view
from tutorial_lib.world.noise import FORWARD, LEFT, STOP
from tutorial_lib.world.plan_json import save_plan
from tutorial_lib.world.scene import Scene

PLAN = make_box(9.0, 5.0, [(3.0, 2.5, 0.4)])


@pytest.mark.parametrize(
    "choice",
    [
        {"worlds": (10_100,), "render_mode": "rgb_array"},
        {"worlds": (10_100,), "sensor": "rgb", "render_mode": "top_view"},
        {"plan": PLAN, "render_mode": "top_view"},
    ],
)
@pytest.mark.few(1)
def test_gymnasium_s_checker_is_content(choice):
    environment = gymnasium.make(NAME, **choice)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(environment.unwrapped)


def test_the_same_seed_and_actions_give_the_same_episode():
    rolled = []
    for _ in range(2):
        environment = gymnasium.make(NAME, worlds=(10_100, 10_101), difficulty="hard")
        seen, _ = environment.reset(seed=11)
        states = [seen["goal_image"]]
        for action in (FORWARD, LEFT, FORWARD, FORWARD):
            seen, *_ = environment.step(action)
            states += [seen["image"], seen["odometry"], seen["depth"]]
        rolled.append(states)
    assert all(np.array_equal(a, b) for a, b in zip(*rolled, strict=True))
    other, _ = environment.reset(seed=12)
    assert not np.array_equal(other["goal_image"], states[0])


def test_stop_terminates_with_the_spl_as_reward():
    environment = gymnasium.make(NAME, worlds=(10_100,), difficulty="easy")
    environment.reset(seed=0)
    _, reward, terminated, truncated, info = environment.step(STOP)
    assert (reward, terminated, truncated) == (0.0, True, False)  # 1 m away at least
    assert info == {"success": False, "spl": 0.0, "steps": 1}


def test_an_episode_is_truncated_after_500_steps():
    environment = gymnasium.make(NAME, worlds=(10_100,)).unwrapped
    environment.reset(seed=0)
    for step in range(500):
        _, _, terminated, truncated, info = environment.step(LEFT)
        assert not terminated
        assert truncated == (step == 499)
    assert info["steps"] == 500


def test_nothing_that_is_returned_says_where_the_robot_or_the_goal_is():
    environment = gymnasium.make(NAME, worlds=(10_100,))
    seen, info = environment.reset(seed=0)
    assert set(seen) == {"image", "goal_image", "depth", "goal_depth", "odometry"}
    assert set(info) == {"success", "spl", "steps"}
    assert not seen["odometry"].any()


def test_the_reward_is_the_spl_once_and_nothing_else_pays():
    environment = gymnasium.make(NAME, worlds=(10_100,), noise=False).unwrapped
    environment.reset(seed=3)
    task = environment._task
    task.poses = task.goal_poses.copy()  # a robot at its goal
    rewards = [environment.step(action)[1] for action in (LEFT, LEFT, STOP)]
    assert rewards == [0.0, 0.0, 1.0]
    with pytest.raises(InputError, match="the episode is over; call reset"):
        environment.step(STOP)
    environment.reset(seed=3)
    for wrong in (np.array([1]), 1.5, 4, None):
        with pytest.raises(InputError, match=r"action: .*; give one whole number"):
            environment.step(wrong)
    assert environment.step(LEFT)[1:4] == (0.0, False, False)


def test_nothing_is_done_before_reset():
    environment = gymnasium.make(NAME, worlds=(10_100,), render_mode="rgb_array").unwrapped
    for call in (environment.render, lambda: environment.step(LEFT)):
        with pytest.raises(InputError, match="call reset first"):
            call()
    seen, _ = environment.reset(seed=0)
    assert np.array_equal(environment.render(), seen["image"])


# Plans of one's own.


@pytest.fixture
def files(tmp_path):
    """The same room as a saved plan, a HouseExpo map and a ROS map."""
    save_plan(PLAN, tmp_path / "plan.json")
    outline = {"verts": [[0, 0], [9, 0], [9, 5], [0, 5]], "id": "room"}
    (tmp_path / "house.json").write_text(json.dumps(outline))
    cells = np.full((54, 94), 254, np.uint8)
    cells[[0, 1, -2, -1]] = cells[:, [0, 1, -2, -1]] = 0
    (tmp_path / "room.pgm").write_bytes(b"P5 94 54 255\n" + cells.tobytes())
    (tmp_path / "ros.yaml").write_text(
        "image: room.pgm\nresolution: 0.1\norigin: [0, 0, 0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.2\n"
    )
    return tmp_path


@pytest.mark.parametrize("name", ["plan.json", "house.json", "ros.yaml"])
def test_episodes_take_place_in_a_map_of_one_s_own(files, name):
    environment = gymnasium.make(NAME, plan=str(files / name)).unwrapped
    for seed in range(3):
        environment.reset(seed=seed)
        task = environment._task
        for x, y, _ in (task.poses[0], task.goal_poses[0]):
            assert 0.0 < x < 9.4
            assert 0.0 < y < 5.4
        assert 3.0 <= task.episodes.shortest[0] < 5.0
    assert environment._task.scenes.keys() == {"plan"}


def test_a_plan_and_its_file_are_the_same_world(files):
    seen = []
    for plan in (PLAN, files / "plan.json"):
        environment = gymnasium.make(NAME, plan=plan)
        observation, _ = environment.reset(seed=4)
        seen.append([observation["image"], observation["goal_image"]])
        seen[-1].append(environment.step(FORWARD)[0]["image"])
    assert all(np.array_equal(a, b) for a, b in zip(*seen, strict=True))


def test_a_plan_that_does_not_do_is_refused(tmp_path):
    per_wall = ("walls", "wall_materials", "wall_offsets")
    open_room = replace(PLAN, **{name: getattr(PLAN, name)[1:] for name in per_wall})
    for plan, words in (
        (tmp_path / "none.yaml", "none.yaml"),
        ("house.stl", "unknown kind of map"),
        (5, "plan: of type int; give the name of a map's file or a FloorPlan"),
        (open_room, "is not closed"),
    ):
        with pytest.raises(InputError, match=words):
            gymnasium.make(NAME, plan=plan)
    for beside in ({"worlds": (3,)}, {"signs": "wayfinding"}):
        with pytest.raises(InputError, match=r"plan: .* leave worlds and signs out"):
            gymnasium.make(NAME, plan=PLAN, **beside)
    small = gymnasium.make(NAME, plan=make_box(2.0, 2.0), difficulty="hard")
    with pytest.raises(InputError, match="no hard one fits into this world"):
        small.reset(seed=0)


# Options of an episode.


def test_options_choose_the_difficulty_and_the_world_of_one_episode():
    environment = gymnasium.make(NAME, worlds=(10_100, 10_101)).unwrapped
    for difficulty, (low, high) in DIFFICULTIES.items():
        environment.reset(seed=1, options={"difficulty": difficulty, "world": 10_103})
        episodes = environment._task.episodes
        assert low <= episodes.shortest[0] < high
        assert episodes.worlds == (exploration_world(10_103),)
    environment.reset(seed=1, options={})
    assert environment._task.episodes.difficulty == ("medium",)
    assert environment._task.episodes.worlds != (exploration_world(10_103),)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"dificulty": "easy"}, "options: 'dificulty' is unknown; use one of difficulty, world"),
        ({"difficulty": "huge"}, "options: difficulty: 'huge' is unknown; use one of easy, medium"),
        ({"world": -1}, "options: world"),
        ({"world": "office"}, "options: world"),
        ("easy", "options: 'easy'; give a dict"),
    ],
)
def test_an_unknown_option_is_refused_by_name(options, words):
    environment = gymnasium.make(NAME, worlds=(10_100,)).unwrapped
    with pytest.raises(InputError, match=words):
        environment.reset(options=options)


def test_a_plan_has_no_other_world():
    environment = gymnasium.make(NAME, plan=PLAN).unwrapped
    environment.reset(options={"difficulty": "easy"})
    with pytest.raises(InputError, match="options: 'world' is unknown; use one of difficulty"):
        environment.reset(options={"world": 3})


# From above.


def shown(image, colour):
    """Middle (x, y) in metres of all that has a colour in the top view of `PLAN`."""
    rows, columns = np.nonzero((image == colour).all(axis=-1))
    pixel = 9.2 / SIDE  # the plan and two cells on either side
    return np.array([columns.mean() + 0.5, len(image) - rows.mean() - 0.5]) * pixel - 0.1


def test_the_view_from_above_shows_walls_goal_robot_and_path():
    environment = gymnasium.make(NAME, plan=PLAN, render_mode="top_view", noise=False).unwrapped
    environment.reset(seed=1)
    task = environment._task
    for action in 6 * (FORWARD,):
        environment.step(action)
    image = environment.render()
    assert image.dtype == np.uint8
    assert image.shape == (round(SIDE * 5.2 / 9.2), SIDE, 3)
    assert shown(image, GOAL) == pytest.approx(task.goal_poses[0, :2], abs=0.05)
    assert shown(image, ROBOT) == pytest.approx(task.poses[0, :2], abs=0.08)
    inside = image[round(len(image) / 2), round(SIDE * 3.1 / 9.2)]
    assert tuple(inside) == SOLID
    drawn = (image == PATH).all(axis=-1).sum() * (9.2 / SIDE) ** 2
    assert drawn == pytest.approx(0.08 * (task.travelled[0] - 0.18), abs=0.03)
    # Whoever is shown it cannot tell from the observations that it was.
    assert set(environment._observe()) == {"image", "goal_image", "depth", "goal_depth", "odometry"}


def test_the_view_from_above_is_as_the_robot_stands():
    scene = Scene(PLAN)
    ahead = top_view(scene, [np.array([6.0, 2.0, np.pi / 2])], np.array([1.0, 1.0, 0.0]))
    column, row = round(6.1 * SIDE / 9.2), len(ahead) - round(2.1 * SIDE / 9.2)
    assert tuple(ahead[row - 6, column]) == FLOOR  # its nose, up
    assert tuple(ahead[row + 6, column]) == ROBOT


def test_wrong_input_is_refused():
    with pytest.raises(InputError, match="sensor: 'sonar' is unknown"):
        gymnasium.make(NAME, sensor="sonar")
    with pytest.raises(InputError, match="signs: 'neon' is unknown"):
        gymnasium.make(NAME, signs="neon")
    with pytest.raises(InputError, match="difficulty: 'huge' is unknown"):
        gymnasium.make(NAME, worlds=(10_100,), difficulty="huge")
    with pytest.raises(InputError, match="reward: 'money' is unknown; use one of spl, shaped"):
        gymnasium.make(NAME, reward="money")
    with pytest.raises(InputError, match="noise: 2"):
        gymnasium.make(NAME, noise=2)
    with pytest.raises(InputError, match="render_mode: 'human' is unknown"):
        ImageGoalNavigation(render_mode="human")
    for worlds in ((), 5, ("a",), (1.7,), (-1,)):
        with pytest.raises(InputError, match=r"worlds: .* give seeds"):
            gymnasium.make(NAME, worlds=worlds)
