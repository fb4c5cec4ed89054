"""The Gymnasium environments by name, and their observations for RL libraries."""

import re
import subprocess
import sys
from pathlib import Path

import gymnasium
import numpy as np
import pytest

from tutorial_lib.environments import CAR, IMAGE_GOAL, FlatViews, OneImage
from tutorial_lib.errors import InputError

ROOT = Path(__file__).resolve().parents[1]


@pytest.mark.parametrize("name", [IMAGE_GOAL, CAR])
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
    pytest.importorskip("stable_baselines3", reason="Stable-Baselines3 is in the extra rl")
    steps = re.compile(r"^STEPS = [\d_]+$", re.M)
    few = steps.sub("STEPS = 256", example()).replace(", 100, ", ", 2, ")
    assert few.count("STEPS = 256") == 1
    exec(few, {})
    before, after = capsys.readouterr().out.splitlines()
    assert before.startswith("before: reward ")
    assert after.startswith("after: reward ")


@pytest.mark.parametrize("name", [IMAGE_GOAL, CAR])
def test_convolutions_take_one_image(name):
    baselines = pytest.importorskip(
        "stable_baselines3", reason="Stable-Baselines3 is in the extra rl"
    )
    environment = OneImage(gymnasium.make(name, worlds=(10_100,)))
    learner = baselines.PPO("CnnPolicy", environment, n_steps=4, batch_size=4, n_epochs=1, seed=0)
    learner.learn(4)
    action, _ = learner.predict(environment.reset(seed=0)[0])
    assert environment.action_space.contains(action)
