"""A map at which one tampers, with true perception in a room with pillars."""

from copy import deepcopy
from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.agents.ltvn import LTVNAgent
from tutorial_lib.errors import InputError
from tutorial_lib.experiments import draw_trials, explored, image_poses
from tutorial_lib.experiments.demos import tampering
from tutorial_lib.experiments.demos.tampering import ADD, CUT, DOOR, RUN, TamperedMap
from tutorial_lib.experiments.protocols.lifelong import (
    TrueModel,
    deep_experiences,
    score_map,
)
from tutorial_lib.topology import SamplingRules, joined_map, undone
from tutorial_lib.viz import presses
from tutorial_lib.viz.canvas import colours
from tutorial_lib.world.people import Person
from tutorial_lib.world.scene import Scene


@pytest.fixture(scope="module")
def building():
    scene = Scene(make_box(15.0, 9.0, [(4.5, 4.5, 2.2), (10.5, 4.5, 2.2)]))
    return explored("room", scene, np.random.default_rng(3), 4)


@pytest.fixture(scope="module")
def queries(building):
    return draw_trials(building, 6, np.random.default_rng(5))


@pytest.fixture(scope="module")
def learned(building):
    perfect = TrueModel(building.scene)
    made = LTVNAgent(model=perfect, rules=SamplingRules(support=0.0))
    made.learn(deep_experiences(building, perfect))
    return made


@pytest.fixture
def agent(building, learned):
    """An agent with a map of its own; what it begins as is built once."""
    return deepcopy(learned, {id(building.scene): building.scene})


@pytest.fixture
def tampered(building, agent, queries, monkeypatch):
    monkeypatch.setattr(tampering, "BLOCK", 4)
    door = [Person([[7.5, 4.5]], speed=0.0)]
    return TamperedMap(building, agent, queries, door, first=100)


@pytest.mark.full
def test_a_block_takes_the_next_queries_past_the_door_as_it_is(tampered, agent, monkeypatch):
    run, calls = tampering.run_queries, []

    def spy(building, trials, agent, fleet, first, people):
        calls.append((trials.starts[:, 0].tolist(), fleet, first, len(people)))
        return run(building, trials, agent, fleet, first, people)

    monkeypatch.setattr(tampering, "run_queries", spy)
    tampered.press(RUN)
    tampered.press(DOOR)
    assert "shut" in tampered.text
    assert " of your" not in tampered.text
    tampered.press(ADD)
    tampered.press(RUN)
    left = int(agent.sampled.graph.has_edge(*tampered.added[0]))
    assert tampered.text.endswith(f"; {left} of your 1 added ones are left.")
    tampered.press(DOOR)
    assert not tampered.shut
    x = tampered._queries.starts[:, 0].tolist()
    assert calls == [(x[:4], 4, 100, 0), ([*x[4:], *x[:2]], 4, 104, 1)]
    assert [block.shut for block in tampered.blocks] == [False, True]
    assert [block.pruned for block in tampered.blocks][-1] == len(agent.upkeep.pruned)
    arrived = round(4 * tampered.blocks[0].success)
    assert arrived >= 3


@pytest.mark.full
def test_the_edge_that_is_driven_most_is_cut_and_comes_back(tampered, agent):
    tampered.press(RUN)
    driven = [event.edge for event in agent.upkeep.events if event.kind == "success"]
    most = max(map(driven.count, driven))
    tampered.press(CUT)
    (edge,) = tampered.cut
    assert driven.count(edge) == most
    assert f"driven {most} times" in tampered.text
    assert not agent.sampled.graph.has_edge(*edge)
    assert edge in agent.upkeep.pruned
    agent.upkeep.begin(100 + agent.maintenance.returns)
    assert agent.sampled.graph.has_edge(*edge)


@pytest.mark.full
def test_an_added_edge_joins_places_far_apart_and_all_can_be_undone(building, tampered, agent):
    before = dict(agent.sampled.graph.edges)
    tampered.press(ADD)
    (edge,) = tampered.added
    graph, poses = agent.sampled.graph, image_poses(building, agent)
    assert edge not in before
    assert np.hypot(*(poses[edge[0]] - poses[edge[1]])[:2]) > 5.0
    assert graph.edges[edge] in before.values()  # it looks like one of the others
    tampered.press(CUT)
    assert dict(undone(graph, agent.upkeep.events).edges) == before


def test_buttons_show_the_map_the_door_and_the_blocks(tampered):
    panel = presses(tampered)
    assert tuple(panel.buttons) == (RUN, DOOR, CUT, ADD)
    still = panel.picture.value
    panel.buttons[DOOR].click()
    assert panel.picture.value != still
    assert "shut" in panel.line.value
    shut = tampered.render()
    panel.buttons[DOOR].click()
    door = [(one == colours.PERSON).all(axis=2).sum() for one in (shut, tampered.render())]
    assert door[0] > door[1] > 0
    assert "image/png" in panel._repr_mimebundle_()


def test_what_it_cannot_work_with_is_named(building, agent, queries, tampered):
    with pytest.raises(InputError, match="name: 'jump'"):
        tampered.press("jump")
    few = queries.subset(np.arange(3))
    with pytest.raises(InputError, match="queries: 3; give 4 or more"):
        TamperedMap(building, agent, few, [])
    with pytest.raises(InputError, match="agent: has no map that mends itself"):
        TamperedMap(building, replace(agent, maintenance=None), queries, [])


@pytest.mark.full
def test_a_score_counts_vertices_and_arrivals_and_leaves_the_map_as_it_is(building, agent, queries):
    before = dict(agent.sampled.graph.edges)
    found = score_map(building, queries, agent.sampled)
    assert (found.vertices, found.edges) == (len(agent.sampled.graph), len(before))
    assert (found.queries, found.arrived >= 5) == (6, True)
    assert dict(agent.sampled.graph.edges) == before
    nothing = joined_map(agent.sampled.pool, agent.sampled.rules, [0], [])
    assert score_map(building, queries, nothing).arrived < found.arrived


def test_a_map_of_chosen_vertices_is_the_one_that_sampling_makes(agent):
    made = agent.sampled
    edges = [(a, b) for a, b, back in made.graph.edges(data="reverse") if not back]
    again = joined_map(made.pool, made.rules, list(made.graph), edges)
    assert set(again.graph.edges) == set(made.graph.edges)
    assert again.unused.isdisjoint(again.graph)
    with pytest.raises(InputError, match="edges: one leads from or to an image that is no vertex"):
        joined_map(made.pool, made.rules, [0], [(0, 1)])
