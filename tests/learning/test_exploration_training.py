"""Losses of the multi-task network, its training, and the command."""

from dataclasses import replace

import joblib
import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from tests.learning.test_training import Killed, killed_when_saved
from tutorial_lib import cli
from tutorial_lib.commands import train as train_command
from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import ExplorationModel
from tutorial_lib.learning import exploration_recipes, recipes
from tutorial_lib.learning.calibration import Calibration
from tutorial_lib.learning.exploration_data import panorama_worlds
from tutorial_lib.learning.exploration_losses import (
    PanoramaObjective,
    _position,
    best_chosen,
    depth_loss,
    listwise_loss,
    pair_losses,
    predictions,
    score_loss,
    seen_losses,
)
from tutorial_lib.learning.exploration_model import LearnedExploration
from tutorial_lib.learning.exploration_recipes import NTS, NtsRecipe, calibrate_connection
from tutorial_lib.learning.panorama_batches import PanoramaSource
from tutorial_lib.learning.panorama_encoder import FEATURES, Encoded
from tutorial_lib.learning.panorama_network import PanoramaArchitecture, PanoramaNetwork
from tutorial_lib.learning.settings import Settings
from tutorial_lib.learning.training import train
from tutorial_lib.learning.weights import load_card, load_network, save_network
from tutorial_lib.observation import Observation

torch.set_num_threads(1)
INF = float("inf")


@pytest.fixture(scope="module")
def worlds(tmp_path_factory):
    folder = tmp_path_factory.mktemp("worlds")
    with joblib.parallel_config(backend="threading"):
        return panorama_worlds([("office", 1), ("apartment", 3)], folder, 24, jobs=1)


@pytest.fixture(scope="module")
def batch(worlds):
    return PanoramaSource(worlds, worlds=2, targets=2, vary=False).block([0])


@pytest.fixture(scope="module")
def seen(worlds):
    """What robots observe at places of the office."""
    still = np.zeros(24)
    depth = worlds[0].depth.astype(float)
    laser = np.full((24, 96), np.nan)
    return Observation(worlds[0].images["plain"], depth, laser, np.zeros((24, 3)), still, still)


def network_of(sensor="rgbd", blind=False):
    torch.manual_seed(0)
    return PanoramaNetwork(PanoramaArchitecture(sensor, blind))


# Losses.


def test_scores_cost_ten_times_their_squared_error_where_a_direction_is():
    metres = torch.tensor([[4.0, 30.0, INF], [INF, INF, 10.0]])
    perfect = torch.tensor([[0.8, 0.0, 0.3], [0.9, 0.1, 0.5]])
    assert score_loss(perfect, metres).item() == pytest.approx(0.0, abs=1e-10)
    assert score_loss(perfect + 0.1, metres).item() == pytest.approx(10 * 0.01, rel=1e-4)
    assert score_loss(perfect, torch.full((2, 3), INF)).item() == 0.0


@given(st.lists(st.floats(0.0, 18.0), min_size=2, max_size=12))
def test_the_order_costs_nothing_when_it_is_that_of_the_distances(metres):
    metres = torch.tensor([[*metres, INF]])
    right = torch.where(metres.isfinite(), -metres / 0.5, 7.0)
    assert listwise_loss(right, metres).item() == pytest.approx(0.0, abs=1e-4)
    assert listwise_loss(right + 3.0, metres).item() == pytest.approx(0.0, abs=1e-4)
    assert listwise_loss(torch.zeros_like(metres), metres).item() >= -1e-6
    assert listwise_loss(0.5 * right, metres).isfinite()


def test_the_order_is_the_divergence_of_two_distributions():
    metres, logits = torch.tensor([[1.0, 2.0, INF, 1.5]]), torch.tensor([[0.3, -0.2, 9.0, 1.1]])
    wanted = np.exp([-2.0, -4.0, -3.0]) / np.exp([-2.0, -4.0, -3.0]).sum()
    found = np.exp([0.3, -0.2, 1.1]) / np.exp([0.3, -0.2, 1.1]).sum()
    divergence = (wanted * np.log(wanted / found)).sum()
    assert listwise_loss(logits, metres).item() == pytest.approx(divergence, rel=1e-4)


def test_a_single_direction_is_no_choice():
    metres = torch.tensor([[INF, 2.0, INF], [INF, INF, INF]])
    logits = torch.randn(2, 3, requires_grad=True)
    loss = listwise_loss(logits, metres)
    loss.backward()
    assert loss.item() == 0.0
    assert logits.grad.isfinite().all()


def test_a_place_costs_its_metres_from_the_true_one():
    """Two goals of a node: 2 m ahead of it, and 0.75 m off at the left end of the bin at 90 deg."""
    label = {
        "direction": torch.tensor([0, 3, 5]),
        "offset": torch.tensor([0.0, 1.0, 0.0]),
        "nearness": torch.tensor([1 / 3, 0.75, 0.0]),
    }
    inside, bearing = torch.tensor([True, True, False]), np.deg2rad(105.0)
    there = torch.tensor([[2.0, 0.0], [0.75 * np.cos(bearing), 0.75 * np.sin(bearing)]])
    assert _position(there.float(), label, inside).item() == pytest.approx(2 * 0.1)
    beside = there.float() + torch.tensor([[0.0, 3.0], [0.0, 0.0]])
    assert _position(beside, label, inside).item() == pytest.approx(3.0 + 0.1, abs=0.01)


def test_what_is_no_choice_does_not_count_in_the_mean():
    metres, logits = torch.tensor([[1.0, 2.0], [INF, 2.0]]), torch.tensor([[0.0, 1.0], [3.0, 0.2]])
    assert listwise_loss(logits, metres) == listwise_loss(logits[:1], metres[:1]) > 0.5


def test_depth_costs_by_its_ratio():
    depth = torch.tensor([[1.0, 4.0]])
    assert depth_loss(depth.log(), depth).item() == 0.0
    loss = depth_loss((1.1 * depth).log(), depth).item()
    assert loss == pytest.approx(0.5 * np.log(1.1), rel=1e-4)


def test_the_best_choice_is_judged_by_its_metres():
    metres = np.array([[1.0, 1.4, 3.0], [INF, 2.0, 1.0], [INF, INF, 1.0], [INF, INF, INF]])
    scores = np.array([[0.1, 0.9, 0.2], [0.9, 0.8, 0.1], [0.9, 0.1, 0.1], [0.0, 0.0, 0.0]])
    right = best_chosen(scores, metres)
    assert right[:2].tolist() == [1.0, 0.0]
    assert np.isnan(right[2:]).all()


# Training.


@pytest.mark.parametrize(
    ("sensor", "blind"),
    [("rgb", False), pytest.param("rgbd", False, marks=pytest.mark.full), ("rgbd", True)],
)
@pytest.mark.few(1)
def test_a_few_steps_on_one_batch_lower_every_loss(batch, sensor, blind):
    network, objective = network_of(sensor, blind), PanoramaObjective()
    optimizer = torch.optim.Adam(network.parameters(), 2e-3)
    before = losses_of(network, batch)
    measured = objective.measure(network, [batch])
    for _ in range(20):
        optimizer.zero_grad()
        objective.loss(network, batch).backward()
        optimizer.step()
    after = losses_of(network, batch)
    assert [name for name in before if after[name] >= before[name]] == []
    wanted = sum(after.values())
    again = objective.measure(network, [batch])
    assert ("depth_error" in again) == (sensor == "rgb")
    if sensor == "rgb":
        assert again["depth_error"] < measured["depth_error"]
    else:
        assert again["validation"] == pytest.approx(wanted, rel=1e-4)


@torch.inference_mode()
def losses_of(network, batch):
    found = predictions(network, batch)
    losses = seen_losses(found.seen, batch) | pair_losses(found.compared, batch, found.pairs)
    return {name: loss.item() for name, loss in losses.items()}


def test_gradients_are_finite_and_reach_every_weight(batch):
    for sensor in ("rgb", "rgbd"):
        network = network_of(sensor)
        PanoramaObjective().loss(network, batch).backward()
        for name, value in network.named_parameters():
            assert value.grad is not None, name
            assert value.grad.isfinite().all(), name
            assert value.grad.abs().max() > 0, name


def test_training_resumes_to_the_same_weights(worlds, tmp_path, monkeypatch):
    source = PanoramaSource(worlds, worlds=2, targets=2)
    validation = [PanoramaSource(worlds, worlds=1, targets=2, vary=False).block([9])]
    settings = Settings(max_steps=4, targets=2, warmup_steps=2, eval_interval=2)
    architecture, objective = PanoramaArchitecture("rgbd"), PanoramaObjective()
    whole, progress = train(architecture, source, validation, settings, objective=objective)
    path = tmp_path / "state.pt"
    arguments = (architecture, source, validation, settings, path)
    with monkeypatch.context() as patched:
        killed_when_saved(patched)
        with pytest.raises(Killed):
            train(*arguments, objective=objective)
    resumed, again = train(*arguments, objective=objective)
    assert again == progress
    for name, value in whole.state_dict().items():
        assert torch.equal(resumed.state_dict()[name], value), name
    with pytest.raises(InputError, match="another training"):
        train(PanoramaArchitecture("rgbd", True), *arguments[1:], objective=objective)


def test_connections_are_calibrated_by_temperature_and_offset(batch):
    network = network_of()
    network.of_pair.weight.data *= 30.0
    calibration, measured = calibrate_connection(network, [batch])
    with torch.inference_mode():
        logits = predictions(network, batch).compared.connection.numpy().astype(float)
    line = logits / measured["temperature"] + measured["offset"]
    assert calibration(logits) == pytest.approx(1 / (1 + np.exp(-line)), abs=1e-2)
    assert measured["ece_temperature"] <= measured["ece_raw"] + 0.02


# Behind the interface.


@pytest.mark.parametrize("sensor", ["rgb", "rgbd"])
def test_what_is_embedded_once_is_as_good_as_computed_anew(seen, sensor):
    network = network_of(sensor)
    model = LearnedExploration(network)
    assert isinstance(model, ExplorationModel)
    rows = model.embed(seen)
    assert rows.shape == (24, FEATURES)
    assert rows.dtype == np.float32
    images, depth = torch.from_numpy(seen.image), torch.from_numpy(seen.depth).float()
    with torch.inference_mode():
        encoded = network.encode(images, depth)
        direct = network.compare(encoded, encoded.rows(torch.arange(23, -1, -1)))
        openings = network.seen(encoded).explorable
    close = {"rel": 1e-4, "abs": 1e-5}
    assert model.scores(rows, rows[::-1]) == pytest.approx(direct.scores.numpy(), **close)
    together = model.same_node(rows, rows[::-1].copy())
    assert together == pytest.approx(direct.connection.sigmoid().numpy(), **close)
    assert model.explorable(rows) == pytest.approx(openings.sigmoid().numpy(), **close)
    assert model.embed(seen[3]) == pytest.approx(rows[[3]], rel=1e-3, abs=1e-4)
    many = model.scores(rows.repeat(6, axis=0), np.tile(rows[::-1], (6, 1)))
    assert many.shape == (144, 12)


def test_relative_poses_are_within_the_node(seen):
    model = LearnedExploration(network_of())
    rows = model.embed(seen)
    found = model.relative(rows, rows[::-1].copy())
    assert found.shape == (24, 2)
    assert (np.abs(found[:, 0]) <= np.pi).all()
    assert ((found[:, 1] >= 0) & (found[:, 1] <= 3)).all()
    with torch.inference_mode():
        pairs = (Encoded.of(torch.from_numpy(part)) for part in (rows, rows[::-1].copy()))
        compared = model.network.compare(*pairs)
    best = compared.direction.argmax(1)
    offset = compared.offset[torch.arange(24), best].numpy()
    bearing = np.deg2rad(30) * best.numpy() + np.deg2rad(15) * offset
    assert np.cos(found[:, 0] - bearing) == pytest.approx(np.ones(24), abs=1e-6)
    assert found[:, 1] == pytest.approx(3.0 * (1 - compared.nearness.numpy()), abs=1e-4)


def test_ranges_are_measured_or_predicted(seen):
    assert (LearnedExploration(network_of("rgbd")).ranges(seen) == seen.depth).all()
    blind = replace(seen, depth=None)
    predicted = LearnedExploration(network_of("rgb")).ranges(blind)
    assert predicted.shape == (24, 192)
    assert (predicted > 0).all()
    for ask in ("ranges", "embed"):
        with pytest.raises(InputError, match="network for rgb"):
            getattr(LearnedExploration(network_of("rgbd")), ask)(blind)


def test_no_panoramas_and_no_pairs_are_no_error(seen):
    for sensor in ("rgb", "rgbd"):
        model = LearnedExploration(network_of(sensor))
        rows = model.embed(seen[:0])
        assert rows.shape == (0, FEATURES)
        assert model.scores(rows, rows).shape == (0, 12)
        assert model.relative(rows, rows).shape == (0, 2)
        assert model.same_node(rows, rows).shape == (0,)
        assert model.ranges(seen[:0]).shape == (0, 192)


def test_pairs_need_as_many_goals_as_sources(seen):
    model = LearnedExploration(network_of())
    rows = model.embed(seen)
    with pytest.raises(InputError, match="24 sources, 23 goals"):
        model.scores(rows, rows[:23])


# Recipes and the command.


@pytest.fixture
def tiny(tmp_path, monkeypatch):
    """The command trains a tiny network, and all files are in a folder of the test's."""
    settings = Settings(max_steps=4, targets=2, warmup_steps=2, eval_interval=2)
    recipe = NtsRecipe(
        "tiny",
        "train nts --sensor rgb",
        PanoramaArchitecture("rgb"),
        settings,
        worlds=1,
        validation_worlds=1,
        panoramas=12,
    )
    monkeypatch.setitem(NTS, ("rgb", ""), recipe)

    def small(recorded, **given):
        return PanoramaSource(recorded, **{**given, "worlds": 2, "targets": 2})

    monkeypatch.setattr(exploration_recipes, "PanoramaSource", small)
    monkeypatch.setattr(recipes, "WORK", tmp_path / "work")
    monkeypatch.setattr(train_command, "PROJECT", tmp_path)
    folder = tmp_path / "weights"
    monkeypatch.setattr(train_command, "save_network", lambda *both: save_network(*both, folder))
    return recipe


@pytest.mark.full
def test_the_command_trains_saves_and_goes_on_where_it_was_stopped(tiny, tmp_path, capsys):
    folder = tmp_path / "weights"
    with joblib.parallel_config(backend="threading"):
        assert cli.main(["train", "nts", "--sensor", "rgb"]) == 0
        assert "tiny.safetensors" in capsys.readouterr().out
        before = (folder / "tiny.safetensors").read_bytes()
        assert cli.main(["train", "nts", "--sensor", "rgb"]) == 0
        assert (folder / "tiny.safetensors").read_bytes() == before
    card = load_card("tiny", folder)
    assert card.architecture == tiny.architecture
    assert card.recipe["worlds"] == 1
    assert {"top1_hard_plain", "connection_auc", "ece_temperature", "depth_error"} <= set(
        card.validation
    )
    network = load_network("tiny", folder, PanoramaNetwork)
    calibration = Calibration(**card.calibration)
    assert LearnedExploration(network, calibration).sensor == "rgb"
    with pytest.raises(InputError, match="PanoramaNetwork where a LocalNetwork is needed"):
        load_network("tiny", folder)


def test_every_recipe_is_its_own_and_small():
    kinds = ("", "blind", "masked")
    assert set(NTS) == {(sensor, kind) for sensor in ("rgb", "rgbd") for kind in kinds}
    assert len({recipe.name for recipe in NTS.values()}) == 6
    for (sensor, kind), recipe in NTS.items():
        assert recipe.architecture == PanoramaArchitecture(sensor, kind == "blind")
        assert recipe.masked == (kind == "masked")
        options = cli.parse(recipe.command.split())
        assert (options.name, options.sensor, options.kind) == ("nts", sensor, kind)
    usual = NTS["rgbd", ""]
    changed = {"name": usual.name, "command": usual.command, "masked": False}
    assert replace(NTS["rgbd", "masked"], **changed) == usual  # by the same recipe
    assert exploration_recipes.FIRST_STOPPING >= 10_000


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["nts"], "--sensor"),
        (["nts", "--sensor", "lidar"], "rgbd"),
        (["nts", "--k", "2", "--sensor", "rgb"], "--k"),
        (["waypoint", "--k", "2", "--blind"], "--blind"),
        (["nts", "--sensor", "rgb", "--blind", "--masked"], "not allowed with"),
    ],
)
def test_options_of_other_networks_are_refused(capsys, arguments, words):
    with pytest.raises(SystemExit) as stopped:
        cli.main(["train", *arguments])
    assert stopped.value.code == 2
    assert words in capsys.readouterr().err
