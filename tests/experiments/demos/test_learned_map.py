import re
from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest
import torch
from scipy.spatial import cKDTree

from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common import agents
from tutorial_lib.experiments.demos.learned_map import SHIPPED, keep_learned, load_learned
from tutorial_lib.experiments.demos.navigation_demo import PLACES
from tutorial_lib.experiments.demos.task import choose_task
from tutorial_lib.experiments.protocols.navigation import experiences
from tutorial_lib.experiments.protocols.navigation_tasks import Building
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


@pytest.mark.full
def test_a_kept_map_is_the_one_that_was_learned(tmp_path, building, agent):
    assert load_learned(building, agents.meng(), tmp_path) is None
    kept = keep_learned(building, agent, tmp_path / "new" / "folder")
    assert kept.parent == tmp_path / "new" / "folder"
    found, file = load_learned(building, agents.meng(), tmp_path, kept.parent)
    assert file == kept
    assert set(found.graph.edges) == set(agent.topomap.graph.edges)
    assert len(found) == len(agent.topomap)


def test_a_map_of_other_networks_or_settings_is_learned_again(tmp_path, building, agent):
    file = keep_learned(building, agent, tmp_path)
    others = agents.meng(settings=MapSettings(p_edge=0.9)), agents.meng(p_sparsify=0.9)
    for other in others:
        assert load_learned(building, other, tmp_path) is None
    retrained = agents.meng()
    with torch.no_grad():
        next(retrained.reachability.network.parameters()).add_(0.01)
    assert load_learned(building, retrained, tmp_path) is None
    assert load_learned(building, agents.meng(), tmp_path) is not None
    file.write_bytes(b"damaged")
    assert load_learned(building, agents.meng(), tmp_path) is None


def seen_otherwise(building):
    """The building as other robots would have seen it, with drives as many and as long."""
    plan, (first, *drives) = building.scene.plan, building.recorded.trajectories
    red = replace(plan.materials[0], colour=(250, 0, 1))
    wall = plan.walls.copy()
    wall[0] += 0.02
    plans = {
        "another colour": replace(plan, materials=(red, *plan.materials[1:])),
        "a wall that was moved": replace(plan, walls=wall),
        "another light": replace(plan, look=replace(plan.look, gamma=1.3)),
        "another grain": replace(plan, seed=plan.seed + 1),
    }
    for words, other in plans.items():
        yield words, replace(building, scene=Scene(other))
    moved, drifted = first.poses.copy(), first.odometry.copy()
    moved[len(moved) // 2, 1] += 0.02
    drifted[-1, 0] -= 0.02
    for words, one in {
        "another pose on the way": replace(first, poses=moved),
        "another drift": replace(first, odometry=drifted),
    }.items():
        yield words, replace(building, recorded=RecordedWorld(building.scene, [one, *drives]))
    yield "fewer drives", replace(building, recorded=RecordedWorld(building.scene, drives))


def test_a_map_is_found_only_for_exactly_what_it_was_learned_from(tmp_path, building, agent):
    kept = keep_learned(building, agent, tmp_path)
    contents = kept.read_bytes()
    for words, other in seen_otherwise(building):
        assert load_learned(other, agents.meng(), tmp_path) is None, words
        file = keep_learned(other, agent, tmp_path)
        assert file != kept, words
    assert kept.read_bytes() == contents  # another's map is never removed
    assert load_learned(building, agents.meng(), tmp_path)[1] == kept
    last_bits = replace(
        building.recorded.trajectories[0], poses=building.recorded.trajectories[0].poses + 1e-11
    )
    drives = [last_bits, *building.recorded.trajectories[1:]]
    same = replace(building, recorded=RecordedWorld(building.scene, drives))
    assert load_learned(same, agents.meng(), tmp_path)[1] == kept


def test_a_map_is_named_by_its_building_in_letters_that_every_system_takes(
    tmp_path, building, agent
):
    for name, stem in {"my map: v2/final": "my-map-v2-final", "depot": "depot"}.items():
        file = keep_learned(replace(building, name=name), agent, tmp_path)
        assert re.fullmatch(rf"{stem}-[0-9a-f]{{12}}\.npz", file.name)


def test_maps_are_kept_in_the_user_s_cache(tmp_path, monkeypatch, building, agent):
    monkeypatch.setenv("TUTORIAL_CACHE", str(tmp_path / "mine"))
    file = keep_learned(building, agent)
    assert file.parent == tmp_path / "mine" / "learned_maps"
    assert load_learned(building, agents.meng())[1] == file
    monkeypatch.setenv("TUTORIAL_CACHE", str(file / "below a file"))
    with pytest.raises(InputError, match="set TUTORIAL_CACHE to a folder that you may write to"):
        keep_learned(building, agent)


@pytest.mark.full
def test_the_default_demo_comes_with_its_map():
    """That it is found is tested with the command itself (test_cli.py), where its odometry is.

    If this fails, networks, odometry or the demo's drives have changed.

    Then take the map from the folder where `python -m tutorial_lib demo --learn` says it is.
    """
    agent = agents.meng()
    task = choose_task(Scene(generate("apartment", 0)), 0, PLACES, agent)
    kept, file = load_learned(task.building, agent, SHIPPED)
    assert [one.name for one in SHIPPED.iterdir()] == [file.name]
    drives = task.building.recorded.trajectories
    measured = np.concatenate([one.odometry for one in drives])
    remembered = kept.vertices.observations[kept.alive].odometry
    # Another processor rounds the last bits differently.
    assert cKDTree(measured).query(remembered)[0].max() < 1e-9
