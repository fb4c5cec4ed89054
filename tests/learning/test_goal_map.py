"""The learned global goal: half-explored maps, the network, and the scorer behind its seam."""

from functools import partial

import joblib
import numpy as np
import pytest
import torch

from tutorial_lib import cli
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.exploration.frontier import CROP
from tutorial_lib.geometry import to_world
from tutorial_lib.interfaces import FrontierScorer
from tutorial_lib.learning import exploration_policies, goal_map_recipes
from tutorial_lib.learning.exploration_policies import LearnedFrontierScorer
from tutorial_lib.learning.goal_map_network import (
    FRONTIERS,
    GoalMapArchitecture,
    GoalMapNetwork,
    GoalMapObjective,
    GoalMapSource,
)
from tutorial_lib.learning.goal_map_recipes import GOAL_MAPS, goal_maps, record_maps, train_goal_map
from tutorial_lib.learning.imitation_recipes import BaselineRecipe
from tutorial_lib.learning.panorama_encoder import FEATURES, Encoded
from tutorial_lib.learning.panorama_network import PanoramaArchitecture, PanoramaNetwork
from tutorial_lib.learning.settings import Settings
from tutorial_lib.learning.weights import Card, load_card, load_network, save_network
from tutorial_lib.reading.arrays import load_arrays
from tutorial_lib.world.worlds import scene_of

torch.set_num_threads(1)
COUNTS = {"medium": 3, "hard": 5}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("maps")


@pytest.fixture(scope="module")
def seeing():
    torch.manual_seed(0)
    return PanoramaNetwork(PanoramaArchitecture("rgbd")).eval()


@pytest.fixture(scope="module")
def maps(folder, seeing):
    with joblib.parallel_config(backend="threading"):
        return goal_maps([("office", 1)], seeing, folder, COUNTS, jobs=1)


@pytest.fixture(scope="module")
def arrays(maps, folder):
    (path,) = (folder / "goal_maps").glob("*.npz")
    return load_arrays(path, ("poses", "goals", "crops", "frontiers", "remaining"))


def network_of():
    torch.manual_seed(1)
    return GoalMapNetwork(GoalMapArchitecture("rgbd")).eval()


@pytest.mark.full
def test_maps_are_half_explored_and_have_a_choice(maps, arrays):
    assert len(maps.crops) == 2 * len(arrays["poses"])  # with and without signs
    assert maps.crops.shape[1:] == (CROP, CROP)
    shares = [(maps.crops == kind).mean() for kind in range(3)]
    assert all(share > 0.01 for share in shares)
    assert (np.isfinite(maps.remaining).sum(axis=1) > 1).all()
    half = len(arrays["poses"])
    assert (maps.crops[:half] == maps.crops[half:]).all()
    assert (maps.pairs[:half] != maps.pairs[half:]).any()


def test_maps_with_one_frontier_or_none_are_left_out(seeing, monkeypatch):
    real, drawn = goal_map_recipes._looked, []

    def looked(*arguments):
        found = real(*arguments)
        if len(drawn) % 2:
            found["remaining"][:, 1:] = np.inf
        drawn.append(len(found["remaining"]))
        return found

    monkeypatch.setattr(goal_map_recipes, "_looked", looked)
    scene = scene_of("office/1/standard")
    rng = np.random.default_rng(2)
    found = record_maps(scene, "office/1/standard", seeing, {"medium": 2, "hard": 1}, rng)
    assert 0 < len(found["poses"]) <= sum(drawn[::2])
    assert (np.isfinite(found["remaining"]).sum(axis=1) > 1).all()


def test_frontiers_lie_where_free_space_ends_and_their_metres_are_geodesics(arrays):
    scene = scene_of("office/1/standard")
    paths = GridPaths(scene.clearance)
    for row in (0, len(arrays["poses"]) // 2):
        known = np.isfinite(arrays["remaining"][row])
        pose, frontiers = arrays["poses"][row], arrays["frontiers"][row, known]
        places = to_world(pose, frontiers[:, :2].astype(float))
        goals = np.broadcast_to(arrays["goals"][row, :2], places.shape)
        wanted = paths.between(places, goals)
        assert arrays["remaining"][row, known] == pytest.approx(wanted, rel=1e-3, abs=1e-3)
        assert (np.diff(frontiers[:, 2]) >= 0).all()
        inside = np.abs(frontiers[:, :2]).max(axis=1) < 4.5
        cells = np.floor(frontiers[inside, :2] / 0.1 + CROP / 2).astype(int)
        around = [
            arrays["crops"][row][y - 2 : y + 3, x - 2 : x + 3] for x, y in cells
        ]  # x runs along columns
        assert all({0, 1} <= set(np.unique(part)) for part in around)


def test_recordings_are_kept(maps, folder, seeing, monkeypatch):
    monkeypatch.setattr(goal_map_recipes, "record_maps", None)
    with joblib.parallel_config(backend="threading"):
        again = goal_maps([("office", 1)], seeing, folder, COUNTS, jobs=1)
    for name in ("crops", "frontiers", "remaining", "pairs"):
        assert np.array_equal(getattr(again, name), getattr(maps, name)), name


def test_a_few_steps_on_one_batch_lower_the_loss(maps):
    batch = GoalMapSource(maps, targets=24).block([0])
    network, objective = network_of(), GoalMapObjective()
    optimizer = torch.optim.Adam(network.parameters(), 2e-3)
    before = objective.measure(network, [batch])
    for _ in range(40):
        optimizer.zero_grad()
        objective.loss(network, batch).backward()
        optimizer.step()
    after = objective.measure(network, [batch])
    assert after["validation"] < 0.7 * before["validation"]
    assert after["nearest"] == before["nearest"]
    assert 0 <= after["top1"] <= 1


def test_a_frontier_is_read_where_it_is_on_the_map():
    """What is at x metres ahead and y to the left changes the score of the frontier there most."""
    network = network_of()
    crops, pairs = torch.ones(1, CROP, CROP, dtype=torch.uint8), torch.zeros(1, 12, 64)
    frontiers = torch.tensor([[[3.0, 0.0, 3.0], [0.0, 3.0, 3.0], [-3.0, 0.0, 3.0]]])
    changed = crops.clone()
    changed[0, 48 - 5 : 48 + 5, 78 - 5 : 78 + 5] = 2  # 3 m ahead: x runs along columns
    with torch.inference_mode():
        gap = (network(crops, frontiers, pairs) - network(changed, frontiers, pairs)).abs()[0]
    assert gap[0] > 3 * gap[1:].max()


def test_the_scorer_reads_any_number_of_frontiers_of_several_robots(seeing):
    scorer, rng = LearnedFrontierScorer(network_of(), seeing), np.random.default_rng(0)
    assert isinstance(scorer, FrontierScorer)
    crops = rng.integers(0, 3, (3, CROP, CROP)).astype(np.uint8)
    rows = rng.normal(size=(2, 3, FEATURES)).astype(np.float32)
    robots = np.array([2, 0, 2, 2, 0])
    frontiers = np.column_stack([rng.uniform(-4, 4, (5, 2)), rng.uniform(1, 6, 5)])
    together = scorer.score(crops, *rows, frontiers, robots)
    assert together.shape == (5,)
    for number, robot in enumerate(robots):
        alone = scorer.score(
            crops[[robot]], *rows[:, [robot]], frontiers[[number]], np.zeros(1, int)
        )
        assert alone == pytest.approx(together[[number]], rel=1e-4)
    with torch.inference_mode():
        encoded = (Encoded.of(torch.from_numpy(part[[0]])) for part in rows)
        pairs = seeing.directions(*encoded)[0]
        mine = torch.from_numpy(frontiers[robots == 0]).float()[None]
        remaining = 20.0 * (1.0 - scorer.network(torch.from_numpy(crops[:1]), mine, pairs)[0])
    total = frontiers[robots == 0, 2] + remaining.numpy()
    assert together[robots == 0] == pytest.approx(-total, rel=1e-4)
    assert scorer.score(crops, *rows, frontiers[:0], robots[:0]).shape == (0,)
    with pytest.raises(InputError, match="the multi-task network"):
        LearnedFrontierScorer(network_of())
    with pytest.raises(InputError, match="crops: shape"):
        scorer.score(crops[:, :90], *rows, frontiers, robots)


@pytest.mark.full
def test_it_trains_on_shipped_features_and_refuses_others(seeing, tmp_path, monkeypatch):
    weights = tmp_path / "weights"
    save_network(seeing, Card("nts_rgbd", "train nts --sensor rgbd", seeing.architecture), weights)
    for module in (goal_map_recipes, exploration_policies):
        for name, function in (("load_card", load_card), ("load_network", load_network)):
            monkeypatch.setattr(
                module,
                name,
                lambda name, function=function, **more: function(name, weights, **more),
            )
    monkeypatch.setattr(goal_map_recipes, "GoalMapSource", partial(GoalMapSource, targets=8))
    settings = Settings(max_steps=2, targets=4, warmup_steps=2, eval_interval=1)
    architecture = GoalMapArchitecture("rgbd")
    recipe = BaselineRecipe(
        "tiny", "train ans_like --sensor rgbd", architecture, settings, "nts_rgbd", 1, 1,
        {"hard": 2},
    )  # fmt: skip
    with joblib.parallel_config(backend="threading"):
        network, card = train_goal_map(recipe, tmp_path)
    save_network(network, card, weights)
    assert LearnedFrontierScorer("tiny").network.architecture == architecture
    other = PanoramaNetwork(PanoramaArchitecture("rgbd"))
    save_network(other, Card("nts_rgbd", "train nts --sensor rgbd", other.architecture), weights)
    with pytest.raises(InputError, match=r"other weights .* train ans_like --sensor rgbd"):
        LearnedFrontierScorer("tiny")


def test_recipes_and_what_is_no_sensor():
    for sensor, recipe in GOAL_MAPS.items():
        options = cli.parse(recipe.command.split())
        assert (options.name, options.sensor, recipe.start) == ("ans_like", sensor, f"nts_{sensor}")
    with pytest.raises(InputError, match="sensor 'sonar'"):
        GoalMapArchitecture("sonar")
    assert FRONTIERS > 8
