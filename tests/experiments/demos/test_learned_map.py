from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest
import torch
from scipy.spatial import cKDTree

from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.demos.learned_map import FOLDER, keep_learned, load_learned
from tutorial_lib.experiments.demos.navigation_demo import PLACES
from tutorial_lib.experiments.protocols.navigation import experiences
from tutorial_lib.experiments.protocols.navigation_tasks import Building, explored
from tutorial_lib.topology import MapSettings
from tutorial_lib.world.generators import generate
from tutorial_lib.world.scene import Scene


@pytest.fixture(scope="module")
def building(recorded):
    paths = GridPaths(recorded.scene.clearance)
    pairs = np.array(list(permutations(range(3), 2)))[: len(recorded.trajectories)]
    return Building("office 1", recorded.scene, paths, np.zeros((3, 2)), recorded, pairs)


@pytest.fixture(scope="module")
def agent(building):
    agent = agents.meng()
    agent.learn(list(experiences(building, [0, 1])))
    return agent


def test_a_kept_map_is_the_one_that_was_learned(tmp_path, building, agent):
    assert load_learned(building, agents.meng(), tmp_path) is None
    file = keep_learned(building, agent, tmp_path)
    assert file.parent == tmp_path
    kept = load_learned(building, agents.meng(), tmp_path)
    assert set(kept.graph.edges) == set(agent.topomap.graph.edges)
    assert len(kept) == len(agent.topomap)


def test_a_map_of_other_networks_settings_or_trajectories_is_learned_again(
    tmp_path, building, agent
):
    file = keep_learned(building, agent, tmp_path)
    others = agents.meng(settings=MapSettings(p_edge=0.9)), agents.meng(p_sparsify=0.9)
    for other in others:
        assert load_learned(building, other, tmp_path) is None
    retrained = agents.meng()
    with torch.no_grad():
        next(retrained.reachability.network.parameters()).add_(0.01)
    assert load_learned(building, retrained, tmp_path) is None
    shorter = RecordedWorld(building.scene, building.recorded.trajectories[:-1])
    assert load_learned(replace(building, recorded=shorter), agents.meng(), tmp_path) is None
    assert load_learned(replace(building, name="office 2"), agents.meng(), tmp_path) is None
    assert load_learned(building, agents.meng(), tmp_path) is not None
    file.write_bytes(b"damaged")
    assert load_learned(building, agents.meng(), tmp_path) is None


def test_a_map_takes_the_place_of_older_ones_of_its_building(tmp_path, building, agent):
    older = tmp_path / "office-1-0123456789ab.npz"
    others = [tmp_path / name for name in ("office-12-0123456789ab.npz", "office-1-by_hand.npz")]
    for file in (older, *others):
        file.write_bytes(b"some map")
    kept = keep_learned(building, agent, tmp_path)
    assert sorted(tmp_path.iterdir()) == sorted([kept, *others])


def test_the_default_demo_comes_with_its_map():
    """If this fails, networks or odometry have changed: python -m tutorial_lib demo --learn."""
    scene = Scene(generate("apartment", 0))
    building = explored("apartment 0", scene, np.random.default_rng(0), PLACES)
    kept = load_learned(building, agents.meng(), FOLDER)
    assert kept is not None
    measured = np.concatenate([one.odometry for one in building.recorded.trajectories])
    remembered = kept.vertices.observations[kept.alive].odometry
    # Another processor rounds the last bits differently.
    assert cKDTree(measured).query(remembered)[0].max() < 1e-9
