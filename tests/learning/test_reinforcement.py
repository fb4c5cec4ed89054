"""Policies that learn by reinforcement: what they see, how they act, and how they are trained."""

import sys
from dataclasses import replace

import numpy as np
import pytest
import torch

from tutorial_lib import cli
from tutorial_lib.commands import train as train_command
from tutorial_lib.errors import InputError
from tutorial_lib.exploration.bearings import DIRECTIONS
from tutorial_lib.exploration.episodes import DIFFICULTIES, draw_episodes, exploration_world
from tutorial_lib.exploration.task import ExplorationTask
from tutorial_lib.interfaces import ExplorerAgent
from tutorial_lib.learning.panorama_network import PanoramaNetwork
from tutorial_lib.learning.reinforcement_environment import PolicyEnvironments
from tutorial_lib.learning.reinforcement_network import (
    LearnedReinforcement,
    ReinforcementArchitecture,
    ReinforcementNetwork,
)
from tutorial_lib.learning.reinforcement_training import (
    REINFORCEMENT,
    PPOSettings,
    Unseen,
    train_reinforcement,
)
from tutorial_lib.learning.reinforcement_views import RADII, PolicyViews
from tutorial_lib.learning.weights import load_card, load_network, save_network
from tutorial_lib.world.noise import LEFT, RIGHT, STOP
from tutorial_lib.world.worlds import scene_of

torch.set_num_threads(1)
WORLD = exploration_world(10_100)
TINY = PPOSettings(
    first=24, steps=48, worlds=1, each=1, rollout=4, batch=24, epochs=1, interval=24,
    unseen=(10_000,), episodes=1,
)  # fmt: skip


@pytest.fixture(scope="module")
def scene():
    return scene_of(WORLD)


@pytest.fixture(scope="module")
def pairs():
    return load_network("nts_rgbd", wanted=PanoramaNetwork)


def task_of(scene, count=2, **options):
    rng = np.random.default_rng(0)
    episodes = draw_episodes(WORLD, scene, {"easy": count}, rng)
    return ExplorationTask({WORLD: scene}, episodes, rng, **options)


def untrained(maps):
    torch.manual_seed(0)
    return ReinforcementNetwork(ReinforcementArchitecture(maps))


# What they see.


def test_they_see_the_goal_by_the_multi_task_network(scene, pairs):
    task = task_of(scene)
    goals, seen = task.goals(), task.observe()
    views = PolicyViews(2, pairs, maps=False)
    views.begin(np.array([1, 0]), goals.image[::-1], goals.depth[::-1])
    parts = views.see(np.arange(2), seen.image, seen.depth, seen.odometry)
    assert {name: part.shape[1] for name, part in parts.items()} == views.sizes
    with torch.inference_mode():
        ours, others = (
            pairs.encode(torch.from_numpy(one.image), torch.from_numpy(one.depth).float())
            for one in (seen, goals)
        )
        hidden, pooled, _ = pairs.directions(ours, others)
    assert parts["directions"] == pytest.approx(hidden.flatten(1).numpy(), abs=1e-4)
    assert parts["whole"] == pytest.approx(pooled.numpy(), abs=1e-4)


def seen_from(views, odometry, depth):
    image = np.zeros((len(odometry), 16, 192, 3), np.uint8)
    parts = views.see(
        np.arange(len(odometry)), image, np.full((len(odometry), 192), depth), odometry
    )
    return parts["map"].reshape(len(odometry), 2 * DIRECTIONS, len(RADII), 3)


def test_maps_turn_with_the_robot_and_remember_what_it_visited(pairs):
    views = PolicyViews(2, pairs, maps=True)
    here = np.array([[0.05, 0.125, 0.0]] * 2)
    free, occupied, visited = np.moveaxis(seen_from(views, here, 2.3), -1, 0)
    assert free[:, :, RADII.index(1.7)].all()
    assert not occupied[:, :, RADII.index(1.7)].any()
    assert occupied[:, :, RADII.index(2.3)].mean() > 0.6
    assert not (free + occupied)[:, :, RADII.index(3.8)].any()
    assert not visited.any()  # only where it stands, and no cell is that near
    # Both drive 0.8 m ahead, and one turns to its left there: it has come from its left.
    there = here + np.array([[0.8, 0.0, 0.0], [0.8, 0.0, np.pi / 2]])
    visited = seen_from(views, there, 2.3)[:, :, RADII.index(0.8), 2]
    behind, left = (np.flatnonzero(one).tolist() for one in visited)
    # Two cells of a direction: the sixth direction is behind the robot, the third to its left.
    assert (behind, left) == ([12, 13], [6, 7])
    views.begin(np.array([0]), np.zeros((1, 16, 192, 3), np.uint8), np.ones((1, 192)))
    after = seen_from(views, there, 0.3)
    assert not after[0, :, 1:].any()
    assert after[1, left, 1, 2].all()


def test_an_episode_begins_without_what_was_done_before(scene, pairs):
    task = task_of(scene)
    goals, seen = task.goals(), task.observe()
    views = PolicyViews(2, pairs, maps=False)
    views.begin(np.arange(2), goals.image, goals.depth)
    before = views.see(np.arange(2), seen.image, seen.depth, seen.odometry)
    views.acted(np.array([LEFT, RIGHT]))
    views.begin(np.array([0]), goals.image[1:], goals.depth[1:])
    parts = views.see(np.arange(2), seen.image, seen.depth, seen.odometry)
    assert parts["before"].argmax(axis=1).tolist() == [STOP, RIGHT]
    assert np.abs(parts["whole"] - before["whole"]).max(axis=1).round(4).astype(bool).tolist() == [
        True,
        False,
    ]


# How they act.


@pytest.mark.parametrize("maps", [False, True])
def test_every_part_of_what_it_sees_counts(maps, pairs):
    network, rng = untrained(maps), np.random.default_rng(1)
    sizes = PolicyViews(1, pairs, maps=maps).sizes
    assert ("map" in sizes) == maps
    parts = {
        name: torch.from_numpy(rng.random((3, size), np.float32)) for name, size in sizes.items()
    }
    with torch.inference_mode():
        logits = network(parts)
        for name in sizes:
            other = network(parts | {name: 1 - parts[name]})
            assert (other - logits).abs().max() > 1e-4, name


def test_actions_are_drawn_with_their_probabilities(scene, pairs):
    network = untrained(maps=False)
    with torch.no_grad():
        network.choose.weight.zero_()
        network.choose.bias.copy_(torch.tensor([0.1, 0.6, 0.3, 1e-12]).log())
    task = task_of(scene, 40)
    agent = LearnedReinforcement(network, pairs, np.random.default_rng(2))
    assert isinstance(agent, ExplorerAgent)
    agent.start(task.goals())
    running, drawn = np.arange(40) < 30, []
    for _ in range(30):
        drawn.append(agent.act(task.observe(), running))
    assert not np.array(drawn)[:, 30:].any()  # those whose episodes are over stop
    shares = np.bincount(np.array(drawn)[:, :30].ravel(), minlength=4) / 900
    assert shares == pytest.approx([0.1, 0.6, 0.3, 0.0], abs=0.05)
    again = LearnedReinforcement(network, pairs, np.random.default_rng(2))
    again.start(task.goals())
    assert (again.act(task.observe(), running) == drawn[0]).all()
    assert not again.act(task.observe(), np.zeros(40, bool)).any()


def test_robots_without_depth_are_refused(scene, pairs):
    agent = LearnedReinforcement(untrained(maps=False), pairs, np.random.default_rng(0))
    with pytest.raises(InputError, match="give the robot a depth camera"):
        agent.start(task_of(scene, sensor="rgb").goals())


@pytest.mark.parametrize(
    "wrong", [{"maps": 1}, {"maps": True, "sensor": "rgb"}, {"maps": True, "kind": "imitation"}]
)
def test_no_other_network_is_built(wrong):
    with pytest.raises(InputError, match="give a reinforcement network true or false, and rgbd"):
        ReinforcementArchitecture(**wrong)


# How they are trained.


def test_environments_pay_less_and_begin_again_where_they_are_told(pairs):
    many = PolicyEnvironments(1, 2, pairs, maps=True)
    assert many.num_envs == 12
    assert many.difficulty == ["easy"] * 4 + ["medium"] * 4 + ["hard"] * 4
    seen, _ = many.reset(seed=3)
    assert all(
        many.single_observation_space[name].shape == part[0].shape for name, part in seen.items()
    )
    acting = np.full(12, LEFT)
    acting[[1, 6]] = STOP
    seen, rewards, ended, truncated, info = many.step(acting)
    assert np.flatnonzero(ended).tolist() == [1, 6]
    assert not truncated.any()
    assert seen["before"].argmax(axis=1).tolist() == acting.tolist()
    assert rewards[1] == pytest.approx(-0.0001)  # a step costs 0.001; a tenth of it is paid
    assert info["steps"].tolist() == [1] * 12
    after = many.restart(np.array([1, 6]))
    changed = np.abs(after["whole"] - seen["whole"]).max(axis=1) > 1e-4
    assert np.flatnonzero(changed).tolist() == [1, 6]
    assert after["before"].argmax(axis=1)[[0, 1, 6]].tolist() == [LEFT, STOP, STOP]


def test_episodes_end_near_the_goal_until_a_stop_is_asked_for(pairs):
    many = PolicyEnvironments(1, 1, pairs, maps=False)
    assert all(part.stops_itself for part in many._parts)
    many.reset(seed=0)
    many.ask_for_stop()
    many.reset()
    for part in many._parts:
        part._task.carry(part._task.goal_poses)
    assert not many.step(np.full(6, LEFT))[2].any()
    _, rewards, ended, _, info = many.step(np.full(6, STOP))
    assert ended.all()
    assert info["success"].all()
    assert (rewards > 0.5).all()


def test_rates_fall_at_the_end():
    settings = PPOSettings(learning_rate=1e-3)
    rates = [settings.learning_rate_at(left) for left in (1.0, 0.5, 0.2, 0.0)]
    assert rates == pytest.approx([1e-3, 1e-3, 5e-4, 0.0])


def test_recipes_learn_in_a_hundred_worlds_and_none_of_them_is_a_validation_world(pairs):
    assert REINFORCEMENT.keys() == {"target_rl", "map_rl"}
    for name, recipe in REINFORCEMENT.items():
        assert recipe.name == f"{name}_rgbd"
        assert recipe.command == f"train {name} --sensor rgbd"
        assert recipe.architecture.maps == (name == "map_rl")
        assert 6 * recipe.settings.worlds >= 100
        assert 10_000 <= min(recipe.settings.unseen) <= max(recipe.settings.unseen) < 20_000
    parts = PolicyEnvironments(3, 1, pairs, maps=False)._parts
    worlds = [world for part in parts for world in part._drawn._worlds]
    assert sorted(worlds) == list(range(18))


def test_training_says_which_extra_it_needs(monkeypatch, tmp_path, capsys):
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    with pytest.raises(InputError, match=r'pip install "\.\[rl\]"'):
        train_reinforcement(REINFORCEMENT["target_rl"], tmp_path)
    assert cli.main(["train", "map_rl", "--sensor", "rgbd"]) == 2
    assert '".[rl]"' in capsys.readouterr().err


@pytest.mark.parametrize("name", ["target_rl", "map_rl"])
def test_the_command_trains_a_policy_that_runs_without_the_extra(
    name, pairs, monkeypatch, tmp_path
):
    pytest.importorskip("stable_baselines3", reason="it is in the extra rl")
    monkeypatch.setitem(REINFORCEMENT, name, replace(REINFORCEMENT[name], settings=TINY))
    monkeypatch.setattr(train_command, "PROJECT", tmp_path)
    monkeypatch.setattr(train_command, "save_network", lambda *both: save_network(*both, tmp_path))
    assert cli.main(["train", name, "--sensor", "rgbd"]) == 0
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    network = load_network(f"{name}_rgbd", tmp_path, ReinforcementNetwork)
    assert network.architecture.maps == (name == "map_rl")
    card = load_card(f"{name}_rgbd", tmp_path)
    assert [row["steps"] for row in card.recipe["curve"]] == [24, 48, 72, 72]
    last = card.recipe["curve"][-1]
    mean = sum(last[f"success_{level}"] for level in DIFFICULTIES) / 3
    assert card.validation == {**last, "validation": pytest.approx(1 - mean, abs=1e-4)}
    found = Unseen(TINY, pairs).measured(network, stops_itself=False)
    assert found.keys() == {f"{k}_{d}" for k in ("success", "spl") for d in DIFFICULTIES}
    assert -6 < network.choose.bias[STOP] < 0
