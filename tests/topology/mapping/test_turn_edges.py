"""Scans find places that were passed looking another way; colours tell those alike apart."""

from dataclasses import replace

import networkx as nx
import numpy as np
import pytest

from tests.conftest import make_box
from tests.made_up_maps import table_map
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.trajectories import Trajectory
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import compose, relative, wrap
from tutorial_lib.topology.mapping.anchors import Anchors
from tutorial_lib.topology.mapping.export import export_graphml
from tutorial_lib.topology.mapping.scan_matching import (
    agreement,
    likely_rotations,
    match_scans,
)
from tutorial_lib.topology.mapping.storage import load_map, save_map
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.topology.mapping.turn_edges import (
    Turns,
    TurnSettings,
    _apart,
    _sights,
    add_turns,
    colour_correlation,
)
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import Camera, Laser, full_circle

PILLARS = [(3.0, 3.0, 0.5), (6.5, 4.0, 0.3), (5.0, 7.5, 0.8)]


@pytest.fixture(scope="module")
def scene():
    return Scene(make_box(pillars=PILLARS))


def scans(scene, poses):
    return Laser().scan(scene, np.asarray(poses, dtype=float))


@pytest.mark.parametrize("turn", [np.pi, -2.0, 1.3])
def test_a_scan_is_found_again_from_another_heading(scene, turn):
    here = np.array([[4.5, 5.2, 0.4], [8.0, 2.0, -1.0]])
    there = compose(here, [0.3, -0.2, turn])
    first, second = scans(scene, here), scans(scene, there)
    alike, rotations = likely_rotations(first, second, 1.0)
    assert alike[[0, 1], [0, 1]].min() > 0.6
    starts = np.zeros((2, 2, 3))
    starts[:, :, 2] = rotations[[0, 1], [0, 1]]
    poses, scores = match_scans(first, second, starts)
    assert poses[:, :2] == pytest.approx(np.array([[0.3, -0.2]] * 2), abs=0.05)
    assert np.abs(wrap(poses[:, 2] - turn)).max() < 0.03
    assert scores.min() > 0.95


def test_rotations_smaller_than_the_least_are_not_looked_at(scene):
    first = scans(scene, [[4.5, 5.2, 0.4]])
    _, rotations = likely_rotations(first, scans(scene, [[4.5, 5.2, 0.6]]), 1.0)
    assert np.abs(wrap(rotations)).min() >= 1.0


def test_scans_of_different_places_contradict_each_other(scene):
    first, second = scans(scene, [[4.5, 5.2, 0.4]]), scans(scene, [[1.5, 8.5, 0.4]])
    assert agreement(first, first, np.zeros((1, 3)))[0] == 1.0
    assert agreement(first, second, np.zeros((1, 3)))[0] < 0.7
    far = np.full_like(first, 10.0)  # nothing in sight
    assert np.isnan(agreement(first, far, np.zeros((1, 3)))[0])


def test_the_scan_that_agrees_less_counts():
    """A round room seen from its middle, and with a recess on one side."""
    round_room, recess = np.full((1, 96), 3.0), np.full((1, 96), 3.0)
    recess[0, :32] = 6.0
    # Nothing that the first one shows is missing in the second, but a third of it is in front.
    for first, second in ((round_room, recess), (recess, round_room)):
        assert agreement(first, second, np.zeros((1, 3)))[0] == pytest.approx(2 / 3, abs=0.03)


def test_colours_are_compared_where_both_drives_saw_the_wall():
    rng = np.random.default_rng(0)
    points = np.column_stack([np.linspace(0, 4, 40), np.ones(40)])
    colours, others = rng.uniform(0, 255, (2, 40, 3))
    pose = np.array([1.0, 2.0, np.pi])
    there = relative(pose, np.column_stack([points, np.zeros(40)]))[:, :2]
    assert colour_correlation((points, colours), (there, colours), pose) == pytest.approx(1.0)
    assert abs(colour_correlation((points, colours), (there, others), pose)) < 0.4
    far = np.add(there, [30.0, 0.0])
    assert np.isnan(colour_correlation((points, colours), (far, colours), pose))
    assert np.isnan(colour_correlation((points, colours), (np.empty((0, 2)), colours[:0]), pose))


class Blind:
    """RE that reaches nothing."""

    def prepare(self, contexts):
        return np.asarray(contexts)[:, 0]

    def probability(self, observations, prepared):
        return np.zeros(len(observations))


def along(scene, poses, begin, camera=None):
    """Anchors at poses (N, 3) of one drive, whose odometry has an origin of its own."""
    poses = np.asarray(poses, dtype=float)
    count, rest = len(poses), np.zeros(len(poses))
    odometry = relative(np.add(poses[:1], [0.7, 0.1, 0.2]), poses)
    laser = scans(scene, poses).astype(np.float32)
    times = begin + np.arange(count) * 1.0
    drive = Trajectory("", 0, poses, odometry, laser, rest, rest, np.zeros((count, 2)), times)
    seen = RecordedWorld(scene, [drive]).observe(np.arange(count), camera or Camera())
    return Anchors(seen, np.zeros((count, 1)), times)


def learned(scene, *drives, settings=None, painted=None):
    """A map of drives without an edge of RE, and the numbers of turns that were added."""
    topomap, added = TopoMap(Blind()), []
    for number, poses in enumerate(drives):
        anchors = along(scene if number < 1 or painted is None else painted, poses, 100.0 * number)
        count = len(anchors)
        path = topomap.make_vertices(
            *anchors.subset(np.arange(count)), np.full(count, number), np.arange(count)
        )
        topomap.paths.append(path.tolist())
        added.append(add_turns(topomap, anchors, path, settings))
    return topomap, added


THERE = [[x, 5.2, 0.0] for x in np.arange(2.0, 8.0, 1.0)]
BACK = [[x, 5.4, np.pi] for x in np.arange(7.2, 1.5, -1.0)]


def test_a_drive_there_and_one_back_are_joined_by_turning_both_ways(scene):
    topomap, added = learned(scene, THERE, BACK)
    assert added[0] == 0
    assert added[1] == topomap.graph.number_of_edges() >= 8
    x = np.array([pose[0] for pose in THERE + BACK])
    for source, target, edge in topomap.graph.edges(data=True):
        assert (source < 6) != (target < 6)
        assert abs(x[source] - x[target]) < 1.0
        assert abs(abs(edge["turn"]) - np.pi) < 0.1
        assert edge["probability"] == 0.95
        assert topomap.graph.has_edge(target, source)


@pytest.mark.parametrize("heading", [2.0, -2.0])
def test_a_turn_leads_from_one_heading_to_the_other_to_its_own_side(scene, heading):
    across = np.array([np.cos(heading), np.sin(heading), 0.0])
    other = [[5.0, 5.2, heading] + far * across for far in (-1.0, 0.0, 1.0)]
    topomap, added = learned(scene, THERE, other)
    assert added[1] >= 2
    headings = np.array([pose[2] for pose in [*THERE, *other]])
    for source, target, edge in topomap.graph.edges(data=True):
        assert abs(wrap(edge["turn"] - (headings[target] - headings[source]))) < 0.1


def test_of_the_vertices_around_those_that_agree_best_are_turned_to(scene):
    """The whole map is near enough, but only one vertex may be compared, and only one joined."""
    few = TurnSettings(candidates=1, most=1, reach=9.0, agreement=0.3, colours=1e-9)
    topomap, added = learned(scene, THERE, BACK, settings=few)
    x = np.array([pose[0] for pose in THERE + BACK])
    assert added[1] >= 2
    assert all(abs(x[source] - x[target]) < 1.0 for source, target in topomap.graph.edges)


@pytest.mark.parametrize(("reach", "joined"), [(0.2, False), (0.4, True)])
def test_places_are_joined_up_to_the_reach(scene, reach, joined):
    """Vertices of the two drives are 0.28 m from each other."""
    _, added = learned(scene, THERE, BACK, settings=TurnSettings(reach=reach))
    assert (added[1] > 0) == joined


def test_of_headings_alike_the_one_with_the_best_score_is_kept():
    poses = np.array([[0, 0, 2.0], [0, 0, 2.1], [0, 0, -2.0], [0, 0, -2.2], [0, 0, 0.0]])
    turns = Turns(np.zeros(5, int), np.arange(5), poses, np.array([0.96, 0.99, 0.97, 0.96, 0.955]))
    assert _apart(turns, TurnSettings()).vertices.tolist() == [1, 2, 4]
    assert _apart(turns, TurnSettings(most=2)).vertices.tolist() == [1, 2]


@pytest.mark.parametrize("degrees", [60.0, 90.0, 120.0])
def test_only_colours_near_by_are_compared(scene, degrees):
    camera = Camera(field_of_view=float(np.deg2rad(degrees)))
    anchors = along(scene, [[0.5, 5.2, 0.0], [0.6, 5.2, 0.0]], 0.0, camera)
    points, colours = _sights(anchors.observations, 0, np.array([0]))
    laser = np.asarray(anchors.observations.laser[0])
    ahead = laser[np.abs(full_circle(len(laser))) < camera.field_of_view / 2]
    assert (ahead >= 5.0).any()
    assert len(points) == len(colours) == (ahead < 5.0).sum() > 0
    assert np.linalg.norm(points, axis=1).max() < 5.0


def test_drives_that_look_the_same_way_are_not(scene):
    _, added = learned(scene, THERE, [[x, 5.4, 0.1] for x in np.arange(2.2, 8.0, 1.0)])
    assert added == [0, 0]


def test_where_the_walls_have_other_colours_it_is_another_place(scene):
    box = make_box(pillars=PILLARS)
    rng, paint = np.random.default_rng(0), box.materials[0]
    stripes = [
        replace(one, colour=tuple(rng.integers(0, 255, 3).tolist())) for one in paint.stripes
    ]
    painted = Scene(replace(box, materials=(replace(paint, stripes=tuple(stripes)),)))
    assert learned(scene, THERE, BACK, painted=painted)[1] == [0, 0]


def test_what_is_joined_already_is_not_turned_to():
    topomap = table_map(np.zeros((2, 2)), 2)
    assert topomap.connect_by_turn(0, 1, 0.8, np.pi + 0.01)
    assert topomap.graph.edges[0, 1]["turn"] == pytest.approx(0.01 - np.pi)
    assert not topomap.connect_by_turn(0, 1, 0.9, 1.0)
    assert not topomap.connect_by_turn(1, 1, 0.9, 1.0)
    # To drive there replaces the turn, for better or worse.
    topomap.connect(0, 1, 0.7, driven=1)
    assert topomap.graph.edges[0, 1]["probability"] == 0.7
    assert "turn" not in topomap.graph.edges[0, 1]
    assert not topomap.connect_by_turn(0, 1, 0.9, 1.0)


def test_turns_are_saved_with_the_map(scene, tmp_path):
    topomap, _ = learned(scene, THERE, BACK)
    save_map(tmp_path / "map.npz", topomap)
    loaded = load_map(tmp_path / "map.npz", Blind())
    assert list(loaded.graph.edges(data="turn")) == list(topomap.graph.edges(data="turn"))
    export_graphml(tmp_path / "map.graphml", topomap)
    drawn = nx.read_graphml(tmp_path / "map.graphml")
    assert nx.get_edge_attributes(drawn, "turn")


def test_settings_that_make_no_sense_are_refused():
    with pytest.raises(InputError, match="turns: p_turn = 0"):
        TurnSettings(p_turn=0.0)
