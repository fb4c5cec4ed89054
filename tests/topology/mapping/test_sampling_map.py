"""Maps by sampling, from a model that knows where made-up images were taken."""

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import logm

from tutorial_lib.errors import InputError
from tutorial_lib.observation import Observation
from tutorial_lib.se2 import compose, relative, wrap
from tutorial_lib.topology.maintenance import Maintenance, MaintenanceRules
from tutorial_lib.topology.mapping.depth_agreement import depth_agreement
from tutorial_lib.topology.mapping.expansion import expanded
from tutorial_lib.topology.mapping.image_pool import ImagePool, length, support
from tutorial_lib.topology.mapping.sampling_map import (
    SamplingRules,
    build,
    is_connectable,
    is_mergeable,
    supported_pairs,
)
from tutorial_lib.world import generate
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera

angles = st.floats(-3.1, 3.1)


class Knows:
    """Images are poses, in the odometry; a pair is reachable ahead, within 3 m and 60 degrees."""

    view, k = None, 0

    def __init__(self, wormholes=()):
        self.wormholes = wormholes

    def prepare(self, contexts):
        return contexts[:, 0]

    def predict(self, observations, targets):
        seen = relative(observations.odometry, targets)
        ahead = (np.abs(np.arctan2(seen[:, 1], seen[:, 0])) < 1.1) | (np.hypot(*seen.T[:2]) < 0.3)
        reachable = ahead & (np.hypot(*seen.T[:2]) < 3.0) & (np.abs(seen[:, 2]) < 1.1)
        found = np.where(reachable, 0.95, 0.02)
        for source, target in self.wormholes:
            same = (observations.odometry == source).all(1) & (targets == target).all(1)
            found[same], seen[same] = 0.99, (1.0, 0.0, 0.0)
        return found, seen


def pool_of(poses, drives=None, wormholes=()):
    poses = np.asarray(poses, dtype=float)
    none = np.zeros(len(poses))
    seen = Observation(
        np.zeros((len(poses), 1, 1, 3), np.uint8), None, none[:, None], poses, none, none
    )
    drives = np.zeros(len(poses), int) if drives is None else np.asarray(drives)
    pool = ImagePool(Knows(wormholes))
    pool.add(seen, poses[:, None], drives, np.arange(len(poses)))
    return pool


def corridor(count=40, apart=0.4):
    """Drives there and back along a line."""
    there = np.column_stack([apart * np.arange(count), np.zeros(count), np.zeros(count)])
    back = np.add(there[::-1], [0.1, 0.2, np.pi])
    return np.concatenate([there, back])


RULES = SamplingRules(support=0.0)


@given(st.floats(-5, 5), st.floats(-5, 5), angles)
def test_length_is_the_norm_of_the_matrix_logarithm(x, y, turn):
    c, s = np.cos(turn), np.sin(turn)
    matrix = np.array([[c, -s, x], [s, c, y], [0.0, 0.0, 1.0]])
    assert length(np.array([x, y, turn])) == pytest.approx(
        np.linalg.norm(logm(matrix)), rel=1e-5, abs=1e-6
    )


@given(st.floats(-5, 5), st.floats(-5, 5), angles)
def test_length_back_is_the_same(x, y, turn):
    there = np.array([x, y, turn])
    back = relative(there, np.zeros(3))
    assert length(there) == pytest.approx(length(back), abs=1e-6)


def test_thresholds_of_both_operators():
    seen = np.array([[0.5, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0], [1.0, 0.0, 1.0]])
    yes = np.ones(4, bool)
    assert is_mergeable(yes, seen, 0.6).tolist() == [True, False, False, False]
    assert is_connectable(yes, seen, 2.5).tolist() == [True, True, False, True]
    assert is_connectable(yes, seen, 2.5, most_turn=0.9).tolist() == [True, True, False, False]
    assert not is_mergeable(~yes, seen, 9.0).any()
    assert not is_connectable(~yes, seen, 9.0).any()


@pytest.mark.parametrize("order", ["uniform", "farthest first"])
@pytest.mark.parametrize("seed", range(3))
def test_a_map_is_sparse_and_leads_everywhere(order, seed):
    pool = pool_of(corridor())
    made = build(pool, SamplingRules(support=0.0, order=order), np.random.default_rng(seed))
    graph, poses = made.graph, corridor()
    assert len(graph) < 30
    accepted = supported_pairs(pool, made.rules)
    for source, target, edge in graph.edges(data=True):
        pair = (target, source) if edge["reverse"] else (source, target)
        assert accepted[pair]
        assert edge["length"] == pytest.approx(length(pool.waypoints[pair]))
        assert edge["cost"] == pytest.approx(edge["length"] * (4.0 if edge["reverse"] else 1.0))
        assert edge["waypoint"] == pytest.approx(relative(poses[source], poses[target]))
    metres = np.where(accepted, length(pool.waypoints), np.inf)
    vertices = made.vertices
    assert metres[np.ix_(vertices, vertices)].min() >= made.rules.merge
    # What was left out is redundant, or has nothing to be joined to.
    for image in set(range(len(pool))) - set(graph) - made.unused:
        assert made.mergeable_with(image, vertices)
    for image in made.unused:
        assert not made.edges_with(image, vertices)
    assert nx.number_weakly_connected_components(graph) == 1
    assert nx.is_strongly_connected(graph)  # in reverse, if need be


@settings(max_examples=30)
@given(st.integers(0, 10**6))
def test_merging_is_idempotent(seed):
    """Building again from a map's own images keeps all of them."""
    poses = corridor(20)
    made = build(pool_of(poses), RULES, np.random.default_rng(seed))
    again = build(pool_of(poses[made.vertices]), RULES, np.random.default_rng(seed + 1))
    assert len(again.graph) == len(made.graph)


def test_the_same_seed_builds_the_same_map():
    one, other = (build(pool_of(corridor()), RULES, np.random.default_rng(7)) for _ in range(2))
    assert list(one.graph.edges(data=True)) == list(other.graph.edges(data=True))


def test_without_reverse_all_edges_lead_ahead():
    made = build(
        pool_of(corridor()), SamplingRules(support=0.0, reverse=None), np.random.default_rng(0)
    )
    assert not any(edge["reverse"] for *_, edge in made.graph.edges(data=True))
    assert not nx.is_strongly_connected(made.graph)


def test_neighbours_do_not_support_a_wormhole():
    poses = corridor()
    wormhole = (poses[2], poses[30])
    pool = pool_of(poses, wormholes=[wormhole])
    plain = supported_pairs(pool, RULES)
    assert plain[2, 30]
    assert support(pool, plain)[2, 30] == 0.0
    supported = supported_pairs(pool, SamplingRules(support=0.5))
    assert not supported[2, 30]
    assert supported[2, 5]


def test_a_pool_asks_about_images_that_look_alike_first():
    class Embeds(Knows):
        asked = 0

        def embed(self, observations):
            x = observations.odometry[:, 0]
            return np.stack([np.cos(x / 16), np.sin(x / 16)], axis=-1)[:, None].astype(np.float32)

        def embed_targets(self, targets):
            return np.stack([np.cos(targets[:, 0] / 16), np.sin(targets[:, 0] / 16)], -1)[
                :, None, None
            ]

        def predict(self, observations, targets):
            self.asked += len(targets)
            return super().predict(observations, targets)

    poses = corridor(80)
    known = pool_of(poses)
    pool, none = ImagePool(Embeds()), np.zeros(160)
    seen = Observation(np.zeros((160, 1, 1, 3), np.uint8), None, none[:, None], poses, none, none)
    pool.add(seen, poses[:, None], np.zeros(160, int), np.arange(160))
    assert pool.model.asked == 160 * 64
    near = known.reachable > 0.5
    assert (pool.reachable[near] > 0.5).mean() > 0.9


def cut(graph, between):
    """Take out all vertices within a stretch of the corridor."""
    poses = corridor()
    gone = [v for v in graph if between[0] < poses[v, 0] < between[1]]
    graph.remove_nodes_from(gone)
    return gone


def test_unused_images_bridge_a_gap_and_only_the_path_is_kept():
    made = build(pool_of(corridor()), RULES, np.random.default_rng(0))
    gone = cut(made.graph, (5.0, 9.0))
    made.unused |= set(gone)
    poses = corridor()
    ahead = [v for v in made.graph if abs(wrap(poses[v, 2])) < 1]
    here, there = min(ahead, key=lambda v: poses[v, 0]), max(ahead, key=lambda v: poses[v, 0])
    assert not nx.has_path(made.graph, here, there)
    upkeep = Maintenance(made.graph, MaintenanceRules(), 4.0, 0.04)
    before, unused = set(made.graph), set(made.unused)
    assert expanded(made, upkeep, here, {there})
    path = nx.shortest_path(made.graph, here, there)
    new = set(made.graph) - before
    assert new
    assert new <= set(path)
    assert made.unused == unused - new
    assert {event.kind for event in upkeep.events} == {"vertex", "joined"}
    off = Maintenance(made.graph, MaintenanceRules(expand=False), 4.0, 0.04)
    cut(made.graph, (5.0, 9.0))
    assert not expanded(made, off, here, {there})


def test_a_pruned_edge_returns_where_no_other_path_is_left():
    made = build(pool_of(corridor()), RULES, np.random.default_rng(0))
    path = nx.shortest_path(made.graph, *list(made.vertices[[0, -1]]))
    upkeep = Maintenance(made.graph, MaintenanceRules(returns=0, expand=False), 4.0, 0.04)
    cut_edges = [e for e in made.graph.edges if (e[0] <= path[1]) != (e[1] <= path[1])]
    for edge in cut_edges:
        upkeep.prune_edge(edge)
    assert expanded(made, upkeep, path[0], {path[-1]})
    returned = [event.edge for event in upkeep.events if event.kind == "returned"]
    assert 1 <= len(returned) < len(cut_edges)


def test_depths_agree_at_the_true_pose_and_not_elsewhere():
    scene = Scene(generate("apartment", 3))
    rng, camera = np.random.default_rng(0), Camera()
    free = np.argwhere(scene.clearance.clearance > 0.6)
    cells = free[rng.choice(len(free), 40)]
    starts = np.column_stack([scene.clearance.centres(cells), rng.uniform(-np.pi, np.pi, 40)])
    offsets = np.column_stack(
        [rng.uniform(0.1, 0.4, 40), rng.uniform(-0.2, 0.2, 40), rng.uniform(-0.3, 0.3, 40)]
    )
    targets = compose(starts, offsets)
    depths = [camera.look(scene, poses)[1] for poses in (starts, targets)]
    bearings = camera.fan.angles[::-1]
    right = depth_agreement(*depths, offsets, bearings)
    wrong = depth_agreement(depths[0], np.roll(depths[1], 7, axis=0), offsets, bearings)
    assert np.median(right) > 0.95
    assert np.median(wrong) < 0.7


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"reachable": 1.2}, "reachable"),
        ({"connect": 0.5}, "merge: 0.7 m, connect"),
        ({"order": "any"}, "order"),
        ({"reverse": 0.5}, "reverse"),
    ],
)
def test_rules_are_checked(changed, words):
    with pytest.raises(InputError, match=f"^{words}"):
        SamplingRules(**changed)
