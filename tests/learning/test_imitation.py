"""Behaviour cloning: the expert, its recording, the recurrent policy and its recipe."""

from dataclasses import replace
from functools import partial

import joblib
import numpy as np
import pytest
import torch

from tutorial_lib import cli
from tutorial_lib.commands import train as train_command
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.exploration.motion import EXACT, move
from tutorial_lib.interfaces import RecurrentPolicy
from tutorial_lib.learning import imitation_data, imitation_recipes, recipes
from tutorial_lib.learning.exploration_policies import LearnedImitation
from tutorial_lib.learning.imitation_data import (
    ARRIVED,
    STEPS,
    WINDOW,
    ImitationSource,
    expert_actions,
    expert_episodes,
)
from tutorial_lib.learning.imitation_network import (
    MEMORY,
    ImitationArchitecture,
    ImitationNetwork,
    ImitationObjective,
)
from tutorial_lib.learning.imitation_recipes import IMITATION, BaselineRecipe
from tutorial_lib.learning.panorama_encoder import FEATURES
from tutorial_lib.learning.panorama_network import PanoramaArchitecture, PanoramaNetwork
from tutorial_lib.learning.settings import Settings
from tutorial_lib.learning.weights import Card, load_card, load_network, save_network
from tutorial_lib.observation import Observation
from tutorial_lib.world.bodies import DifferentialDrive
from tutorial_lib.world.noise import FORWARD, LEFT, RIGHT, STOP
from tutorial_lib.world.sensors import PanoramicCamera
from tutorial_lib.world.worlds import scene_of

torch.set_num_threads(1)
COUNTS = {"easy": 3, "medium": 3, "hard": 4}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("imitation")


@pytest.fixture(scope="module")
def episodes(folder):
    with joblib.parallel_config(backend="threading"):
        return expert_episodes([("office", 1)], folder, COUNTS, jobs=1)[0]


def network_of(sensor="rgbd"):
    torch.manual_seed(0)
    return ImitationNetwork(ImitationArchitecture(sensor))


def test_the_expert_turns_drives_and_stops(box):
    goals = np.array([[5.0, 5.0], [5.0, 5.0], [5.0, 5.0], [5.0, 5.0]])
    fields = GridPaths(box.clearance).fields(goals)
    poses = np.array([[2.0, 5.0, 0.0], [2.0, 5.0, -1.0], [2.0, 5.0, 1.0], [4.5, 5.0, 1.0]])
    assert expert_actions(box, fields, poses).tolist() == [FORWARD, LEFT, RIGHT, STOP]


def test_the_expert_reaches_its_goals_without_noise():
    scene = scene_of("office/1/standard")
    paths = GridPaths(scene.clearance)
    rng = np.random.default_rng(0)
    places = paths.points[rng.choice(np.flatnonzero(paths.largest), 40)]
    poses, goals = np.column_stack([places[:20], np.zeros(20)]), places[20:]
    fields = paths.fields(goals)
    near = fields.distance(poses[:, :2], np.arange(20)) < 10
    for _ in range(160):
        actions = expert_actions(scene, fields, poses)
        radius = DifferentialDrive.radius
        poses, _ = move(poses, EXACT[actions], scene.plan.segments, radius)
    gap = np.linalg.norm(poses[:, :2] - goals, axis=1)
    assert (gap[near] < ARRIVED).mean() > 0.85


def test_episodes_begin_at_rest_and_end_where_the_expert_stops(episodes):
    assert episodes.poses.shape == (10, STEPS, 3)
    assert (episodes.previous[:, 0] == STOP).all()
    assert (episodes.previous[:, 1:] != STOP).all()
    last = episodes.length - 1
    over = episodes.length < STEPS
    assert over.mean() > 0.7
    gap = np.linalg.norm(episodes.poses[np.arange(10), last, :2] - episodes.goals[:, :2], axis=1)
    assert (gap[over] < ARRIVED + 5 * 0.25).all()
    for row in np.flatnonzero(over):
        stops = np.flatnonzero(episodes.actions[row, : episodes.length[row]] == STOP)
        assert 1 <= len(stops) <= 5
        assert stops[0] == episodes.length[row] - 5


def test_some_actions_are_not_the_expert_s(episodes):
    mine = np.arange(STEPS - 1) < episodes.length[:, None] - 6
    wrong = (episodes.previous[:, 1:] != episodes.actions[:, :-1])[mine].mean()
    assert 0.03 < wrong < 0.16


def test_recordings_are_kept(episodes, folder, monkeypatch):
    monkeypatch.setattr(imitation_data, "record_expert", None)
    with joblib.parallel_config(backend="threading"):
        again = expert_episodes([("office", 1)], folder, COUNTS, jobs=1)[0]
    for name in ("poses", "actions", "previous", "length", "goals"):
        assert np.array_equal(getattr(again, name), getattr(episodes, name)), name


def test_a_batch_shows_what_was_seen_before_each_action(episodes):
    source = ImitationSource([episodes], worlds=1, targets=6, vary=False)
    batch = source.block([0])
    assert batch.images.shape == (6, WINDOW, 16, 192, 3)
    assert batch.used[:, 0].all()
    looks = [PanoramicCamera().look(scene, episodes.goals)[0] for scene in episodes.scenes.values()]
    goals = np.concatenate(looks)
    for image in batch.goal_images:
        assert (goals == image).all(axis=(1, 2, 3)).any()
    # One picture after a turn to the left is the one before, moved to the right.
    group, step = np.argwhere((batch.previous[:, 1:] == LEFT) & batch.used[:, 1:])[0]
    before, after = (batch.images[group, i].astype(float) for i in (step, step + 1))
    gaps = [np.abs(np.roll(before, shift, axis=1) - after).mean() for shift in (-6, 0, 6)]
    assert gaps[2] < gaps[1]
    assert gaps[2] < gaps[0]
    again = source.block([0])
    assert (again.images == batch.images).all()
    assert (batch.targets(slice(1, 3)).actions == batch.actions[1:3]).all()


def test_steps_after_the_end_of_an_episode_are_not_learned_from(episodes):
    short = replace(episodes, length=np.full_like(episodes.length, 3))
    batch = ImitationSource([short], worlds=1, targets=2).block([0])
    assert batch.used[:, :3].all()
    assert not batch.used[:, 3:].any()
    network, objective = network_of("rgbd"), ImitationObjective()
    other = replace(batch, actions=np.where(batch.used, batch.actions, 3 - batch.actions))
    assert (other.actions != batch.actions).any()
    assert objective.loss(network, other) == objective.loss(network, batch)


@pytest.mark.parametrize("sensor", ["rgb", "rgbd"])
@pytest.mark.few(1)
def test_a_few_steps_on_one_batch_lower_the_loss(episodes, sensor):
    batch = ImitationSource([episodes], worlds=1, targets=2, vary=False).block([0])
    network, objective = network_of(sensor), ImitationObjective()
    optimizer = torch.optim.Adam(network.parameters(), 2e-3)
    before = objective.measure(network, [batch])
    for _ in range(12):
        optimizer.zero_grad()
        objective.loss(network, batch).backward()
        optimizer.step()
    after = objective.measure(network, [batch])
    assert after["validation"] < 0.85 * before["validation"]
    assert 0 <= after["stops"] <= 1


def test_step_by_step_is_the_same_as_all_at_once(episodes):
    """The policy carries in its state what the sequence has in its memory."""
    batch = ImitationSource([episodes], worlds=1, targets=2, vary=False).block([0])
    network = network_of().eval()
    policy = LearnedImitation(network)
    assert isinstance(policy, RecurrentPolicy)
    still, laser = np.zeros(2), np.full((2, 96), np.nan)

    def observed(image, depth):
        return Observation(image, depth, laser, np.zeros((2, 3)), still, still)

    state = policy.start(observed(batch.goal_images, batch.goal_depth))
    assert state.shape == (2, FEATURES + MEMORY + 1)
    actions = []
    for step in range(5):
        seen = observed(batch.images[:, step], batch.depth[:, step])
        chosen, state = policy.act(seen, state)
        actions.append(chosen)
    previous = torch.from_numpy(np.stack([np.zeros(2, int), *actions[:-1]], axis=1))
    with torch.inference_mode():
        encode = network.pairs.encode
        images, depth = batch.tensor("images")[:, :5], batch.tensor("depth")[:, :5]
        seen = encode(images.flatten(0, 1), depth.flatten(0, 1))
        goals = encode(batch.tensor("goal_images"), batch.tensor("goal_depth"))
        logits, memory = network(seen, goals.rows(torch.tensor([0] * 5 + [1] * 5)), previous)
    assert (logits.argmax(-1).numpy() == np.stack(actions, axis=1)).all()
    assert state[:, FEATURES:-1] == pytest.approx(memory[0].numpy(), rel=1e-3, abs=1e-5)
    assert (state[:, -1] == actions[-1]).all()


@pytest.fixture
def tiny(tmp_path, monkeypatch):
    """The command trains a tiny policy, which starts from untrained weights of the test's."""
    folder = tmp_path / "weights"
    torch.manual_seed(3)
    begun = PanoramaNetwork(PanoramaArchitecture("rgb"))
    save_network(begun, Card("start", "train nts --sensor rgb", begun.architecture), folder)
    settings = Settings(max_steps=2, targets=2, warmup_steps=2, eval_interval=1)
    recipe = BaselineRecipe(
        "tiny", "train il --sensor rgb", ImitationArchitecture("rgb"), settings, "start", 1, 1,
        {"easy": 1},
    )  # fmt: skip
    monkeypatch.setitem(IMITATION, "rgb", recipe)
    monkeypatch.setattr(recipes, "WORK", tmp_path / "work")
    monkeypatch.setattr(train_command, "PROJECT", tmp_path)
    monkeypatch.setattr(train_command, "save_network", lambda *both: save_network(*both, folder))
    source = partial(ImitationSource, worlds=2)
    monkeypatch.setattr(imitation_recipes, "ImitationSource", source)
    for name, function in (("load_card", load_card), ("load_network", load_network)):
        monkeypatch.setattr(
            imitation_recipes,
            name,
            lambda name, function=function, **more: function(name, folder, **more),
        )
    return begun


@pytest.mark.full
def test_the_command_trains_from_the_multi_task_network(tiny, tmp_path):
    folder = tmp_path / "weights"
    with joblib.parallel_config(backend="threading"):
        assert cli.main(["train", "il", "--sensor", "rgb"]) == 0
    network = load_network("tiny", folder, ImitationNetwork)
    assert LearnedImitation(network).sensor == "rgb"
    assert load_card("tiny", folder).recipe["start"] == load_card("start", folder).sha256
    # Two small steps away from where it started.
    one, two = (n.encoder.strip.linear.weight for n in (tiny, network.pairs))
    assert 0 < (one - two).abs().max() < 0.02
    assert 2 * sum(value.numel() for value in network.parameters()) < 1_000_000


def test_recipes_and_what_is_no_sensor(capsys):
    for sensor, recipe in IMITATION.items():
        options = cli.parse(recipe.command.split())
        assert (options.name, options.sensor, recipe.start) == ("il", sensor, f"nts_{sensor}")
    with pytest.raises(SystemExit):
        cli.main(["train", "il", "--sensor", "rgb", "--blind"])
    assert "--blind" in capsys.readouterr().err
    with pytest.raises(InputError, match="sensor 'sonar'"):
        ImitationArchitecture("sonar")
