import json
from itertools import permutations

import numpy as np
import pytest

from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.demos.learned_map import FOLDER, keep_learned, load_learned
from tutorial_lib.experiments.demos.navigation_demo import PLACES
from tutorial_lib.experiments.protocols.navigation import experiences
from tutorial_lib.experiments.protocols.navigation_tasks import Building, explored
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
    keep_learned(building, agent, tmp_path)
    assert load_learned(building, agents.meng(p_sparsify=0.9), tmp_path) is None
    (origin,) = tmp_path.glob("*.origin.json")
    kept = json.loads(origin.read_text())
    for key in kept:
        origin.write_text(json.dumps(kept | {key: "another"}))
        assert load_learned(building, agents.meng(), tmp_path) is None
    origin.write_text(json.dumps(kept))
    assert load_learned(building, agents.meng(), tmp_path) is not None
    next(tmp_path.glob("*.npz")).write_bytes(b"damaged")
    assert load_learned(building, agents.meng(), tmp_path) is None


def test_the_default_demo_comes_with_its_map():
    """If this fails, networks or odometry have changed: python -m tutorial_lib demo --learn."""
    scene = Scene(generate("apartment", 0))
    building = explored("apartment 0", scene, np.random.default_rng(0), PLACES)
    kept = load_learned(building, agents.meng(), FOLDER)
    assert kept is not None
    measured = {row.tobytes() for one in building.recorded.trajectories for row in one.odometry}
    assert {row.tobytes() for row in kept.vertices.observations[kept.alive].odometry} <= measured
