"""The Gymnasium environments by name, and their observations for RL libraries."""

import re
import subprocess
import sys
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from tutorial_lib.environments import CAR, IMAGE_GOAL, FlatViews, OneImage, for_baselines
from tutorial_lib.errors import InputError

ROOT = Path(__file__).resolve().parents[1]


@pytest.mark.parametrize("name", [IMAGE_GOAL, CAR])
@pytest.mark.few(1)
def test_gymnasium_finds_them_by_name_with_the_module_in_front(name):
    script = f"""
import gymnasium, sys
print(gymnasium.make("tutorial_lib.environments:{name}", worlds=(3,)).reset(seed=0)[1])
"""
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, cwd=ROOT)
    assert run.stdout == "{'success': False, 'spl': 0.0, 'steps': 0}\n", run.stderr


def test_names_are_registered_without_loading_what_the_environments_need():
    script = "import sys, tutorial_lib.environments; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, cwd=ROOT)
    loaded = set(done.stdout.split())
    assert "gymnasium" in loaded
    assert not {"torch", "numba", "scipy", "pymunk", "tutorial_lib.exploration"} & loaded


@pytest.mark.parametrize("sensor", ["rgb", "rgbd"])
def test_flat_views_are_means_of_parts(sensor):
    plain = gymnasium.make(IMAGE_GOAL, worlds=(10_100,), sensor=sensor)
    flat = FlatViews(gymnasium.make(IMAGE_GOAL, worlds=(10_100,), sensor=sensor), 2, 24)
    seen, _ = plain.reset(seed=1)
    small, _ = flat.reset(seed=1)
    assert flat.observation_space.contains(small)
    assert {part.dtype for part in small.values()} == {np.dtype(np.float32)}
    assert {part.ndim for part in small.values()} == {1}
    assert small.keys() == seen.keys()
    for name in ("image", "goal_image"):
        for row, column in ((0, 0), (1, 23), (1, 7)):
            part = seen[name][8 * row : 8 * row + 8, 8 * column : 8 * column + 8]
            found = small[name].reshape(2, 24, 3)[row, column]
            assert found == pytest.approx(part.mean(axis=(0, 1)) / 255, abs=1e-6)
    assert (small["odometry"] == seen["odometry"]).all()
    if sensor == "rgbd":
        near = (1 / (1 + seen["depth"][16:24])).mean()
        assert small["depth"][2] == pytest.approx(near, abs=1e-6)
        assert small["goal_depth"].shape == (24,)
    assert flat.observation_space.contains(flat.step(1)[0])


def test_flat_views_of_the_car_have_its_speed_and_steering():
    flat = FlatViews(gymnasium.make(CAR, worlds=(10_100,)), rows=1, columns=8)
    flat.reset(seed=0)
    small, *_ = flat.step(np.array([1.0, -1.0], np.float32))
    assert flat.observation_space.contains(small)
    assert small["image"].shape == (24,)
    assert small["steering"] == pytest.approx([-0.32], abs=0.01)


@pytest.mark.full
def test_one_image_has_the_goal_behind_the_view():
    for name, least, rows, columns in ((IMAGE_GOAL, 36, 48, 192), (CAR, 16, 16, 64)):
        environment = gymnasium.make(name, worlds=(10_100,))
        seen, _ = environment.reset(seed=2)
        one = OneImage(environment, least)
        image, _ = one.reset(seed=2)
        assert one.observation_space.shape == (rows, columns, 6)
        assert one.observation_space.contains(image)
        assert (image[:: rows // 16, :, :3] == seen["image"]).all()
        assert (image[rows // 16 - 1 :: rows // 16, :, 3:] == seen["goal_image"]).all()


@pytest.mark.parametrize("wrap", [FlatViews, OneImage])
@pytest.mark.filterwarnings("ignore:.*different from the unwrapped version")
def test_a_wrapped_environment_keeps_gymnasium_s_contract(wrap):
    check_env(wrap(gymnasium.make(IMAGE_GOAL, worlds=(10_100,)).unwrapped), skip_render_check=True)


def test_what_does_not_fit_is_refused():
    environment = gymnasium.make(IMAGE_GOAL, worlds=(10_100,))
    for wrong, words in (
        ({"rows": 5}, "rows: 5 do not divide 16; give a divisor"),
        ({"columns": 7}, "columns: 7 do not divide 192"),
        ({"rows": 0}, "rows: 0; give"),
        ({"columns": 193}, "columns: 193; give"),
    ):
        with pytest.raises(InputError, match=words):
            FlatViews(environment, **wrong)
    with pytest.raises(InputError, match="least_rows: 0; give"):
        OneImage(environment, 0)
    for wrap in (FlatViews, OneImage):
        with pytest.raises(InputError, match="env: 3; give an Env"):
            wrap(3)
        with pytest.raises(InputError, match="env: it observes a Box; give one with image"):
            wrap(OneImage(environment))
    many = gymnasium.make_vec(IMAGE_GOAL, num_envs=2, worlds=(10_100,))
    for wrong, words in (
        ({"many": environment}, "many: .*; give an object with the method restart"),
        ({"many": many, "rows": 3}, "rows: 3 do not divide 16"),
        ({"many": many, "columns": 0}, "columns: 0; give"),
    ):
        with pytest.raises(InputError, match=words):
            for_baselines(**wrong)


# The example of README.md.


def example():
    """The one with Stable-Baselines3."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    snippets = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    (code,) = [snippet for snippet in snippets if "stable_baselines3" in snippet]
    return code


def test_the_example_has_twenty_lines_at_most():
    assert len([line for line in example().splitlines() if line]) <= 20


def test_the_example_runs(capsys):
    baselines()
    steps = re.compile(r"^STEPS = [\d_]+$", re.M)
    few, count = steps.subn("STEPS = 128", example().replace("n_steps=64", "n_steps=2"))
    assert count == 1
    exec(few, {})
    assert re.search(r"total_timesteps +\| 128 ", capsys.readouterr().out)


def baselines():
    """Stable-Baselines3, without which a test is skipped."""
    return pytest.importorskip(
        "stable_baselines3", reason="Stable-Baselines3 is not installed; it is in the extra rl"
    )


def test_many_for_baselines_are_those_of_gymnasium_and_begin_again_at_once():
    baselines()
    choice = {"num_envs": 5, "worlds": (10_100, 10_101), "reward": "shaped"}
    plain, rng = gymnasium.make_vec(IMAGE_GOAL, **choice), np.random.default_rng(0)
    many = for_baselines(gymnasium.make_vec(IMAGE_GOAL, **choice), rows=2, columns=24)
    many.seed(7)
    seen, expected = many.reset(), plain.reset(seed=7)[0]
    returns, episodes = np.zeros(5), 0
    for _ in range(30):
        assert many.observation_space["image"].shape == (2 * 24 * 3,)
        assert (seen["odometry"] == expected["odometry"].astype(np.float32)).all()
        part = expected["goal_image"][:, 8:, -8:].mean(axis=(1, 2)) / 255
        assert seen["goal_image"][:, -3:] == pytest.approx(part, abs=1e-6)
        actions = rng.choice(4, size=5, p=[0.1, 0.5, 0.2, 0.2])
        seen, rewards, over, infos = many.step(actions)
        expected, paid, ended, truncated, info = plain.step(actions)
        returns += paid
        assert (rewards == paid).all()
        assert (over == ended | truncated).all()
        assert [bool(one) for one in infos] == over.tolist()
        for robot in np.flatnonzero(over):
            told, last = infos[robot], expected["odometry"][robot].astype(np.float32)
            assert (told["terminal_observation"]["odometry"] == last).all()
            assert not seen["odometry"][robot].any()
            assert told["episode"] == {
                "r": pytest.approx(returns[robot]),
                "l": info["steps"][robot],
            }
            assert told["is_success"] == info["success"][robot]
            episodes += 1
        if over.any():
            returns[over] = 0.0
            expected = plain.unwrapped.restart(np.flatnonzero(over))
    assert episodes > 5


@pytest.mark.parametrize("name", [IMAGE_GOAL, CAR])
def test_convolutions_take_one_image(name):
    environment = OneImage(gymnasium.make(name, worlds=(10_100,)))
    learner = baselines().PPO("CnnPolicy", environment, n_steps=4, batch_size=4, n_epochs=1, seed=0)
    learner.learn(4)
    action, _ = learner.predict(environment.reset(seed=0)[0])
    assert environment.action_space.contains(action)
