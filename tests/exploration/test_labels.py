"""Labels of panoramas, against brute force."""

import networkx as nx
import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.exploration.bearings import bearing_of, column_bearings, column_of
from tutorial_lib.exploration.episodes import exploration_world
from tutorial_lib.exploration.explorable import CLEARANCE, DETOUR, explorable
from tutorial_lib.exploration.labels import (
    MAX_DISTANCE,
    PanoramaLabels,
    connected,
    direction_ends,
    panorama_ranges,
)
from tutorial_lib.geometry import to_world
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.worlds import scene_of


@pytest.fixture(scope="module")
def scene():
    return scene_of(exploration_world(10_100))


@pytest.fixture(scope="module")
def labels(scene):
    paths, rng = GridPaths(scene.clearance), np.random.default_rng(0)
    places = paths.points[rng.choice(np.flatnonzero(paths.largest), 60)]
    return PanoramaLabels(scene, np.column_stack([places, rng.uniform(-3, 3, 60)]))


@pytest.fixture(scope="module")
def pairs():
    rng = np.random.default_rng(1)
    return rng.integers(60, size=800), rng.integers(60, size=800)


def test_connected_is_line_of_sight_within_three_metres(scene, labels, pairs):
    sources, goals = pairs
    start, end = labels.poses[sources, :2], labels.poses[goals, :2]
    metres = np.linalg.norm(end - start, axis=1)
    seen = scene.caster.sees(start, end) & (metres <= 3.0)
    found = labels.connected(sources, goals)
    assert seen.sum() > 50
    assert not found[metres > 3.0].any()
    assert found[seen].mean() > 0.99  # columns are 2 degrees wide
    assert (found == seen).mean() > 0.98


def test_connected_takes_the_largest_depth_about_the_direction():
    ranges = np.full((3, 192), 1.0)
    ranges[1, 95:97] = 2.5
    ranges[2, 90:92] = 2.5  # more than 2.5 degrees off
    assert connected(ranges, np.zeros(3), np.full(3, 2.0)).tolist() == [False, True, False]
    assert connected(ranges, np.full(3, np.pi), np.full(3, 0.9)).all()  # about the seam
    assert not connected(np.full((1, 192), 9.0), np.zeros(1), np.array([3.01])).any()


def test_a_goal_is_visible_one_column_beside_its_direction_and_no_farther():
    for beside in range(-3, 4):
        ranges, column = np.full((1, 192), 2.0), int(column_of(0.3, 192))
        ranges[0, column + beside] = 5.0
        assert connected(ranges, np.array([0.3]), np.array([2.5]))[0] == (abs(beside) <= 1)


def test_relative_places_lead_to_the_goals(labels, pairs):
    sources, goals = pairs
    bearing, metres = labels.relative(sources, goals).T
    ahead = metres[:, None] * np.stack([np.cos(bearing), np.sin(bearing)], axis=1)
    assert np.allclose(to_world(labels.poses[sources], ahead), labels.poses[goals, :2])


def test_scores_are_geodesics_from_the_ends(scene, labels, pairs):
    sources, goals = (rows[:40] for rows in pairs)
    metres = labels.metres(sources, goals)
    paths = GridPaths(scene.clearance)
    ends = labels.ends[sources]
    for direction in range(12):
        alone = paths.between(ends[:, direction], labels.poses[goals, :2])
        assert np.allclose(metres[:, direction], alone)
    assert np.allclose(
        metres[:, 12], paths.between(labels.poses[sources, :2], labels.poses[goals, :2])
    )
    assert np.allclose(
        labels.scores(sources, goals), np.maximum(1 - metres[:, :12] / MAX_DISTANCE, 0)
    )


def test_ends_are_the_farthest_traversable_points_in_a_straight_line(scene, labels):
    for pose, ends, lengths in zip(labels.poses[:20], labels.ends, labels.lengths, strict=False):
        for direction in range(12):
            angle = pose[2] + direction * np.pi / 6
            ahead, steps = np.array([np.cos(angle), np.sin(angle)]), 0
            while (
                steps < 30 and scene.clearance.at(pose[:2] + (steps + 1) * 0.1 * ahead) >= CLEARANCE
            ):
                steps += 1
            assert lengths[direction] == pytest.approx(0.1 * steps)
            assert np.allclose(ends[direction], pose[:2] + 0.1 * steps * ahead)


def brute_explorable(ranges, directions=12, radius=3.0, cell=0.1):
    """The same map and steps, with networkx."""
    bearings = column_bearings(len(ranges))
    near = ranges < np.inf
    hits = (ranges * np.stack([np.cos(bearings), np.sin(bearings)]))[:, near].T / cell
    half = int(np.ceil(1.05 * radius / cell)) + 1
    free = {
        (i, j)
        for i in range(-half, half + 1)
        for j in range(-half, half + 1)
        if not len(hits) or (np.hypot(*(hits - (j, i)).T) >= CLEARANCE / cell).all()
    } | {(0, 0)}
    graph, empty = nx.Graph(), nx.Graph()
    square = {(i, j) for i in range(-half, half + 1) for j in range(-half, half + 1)}
    for cells, into in ((free, graph), (square, empty)):
        for i, j in cells:
            for down, right in [(0, 1), (1, 0), (1, 1), (1, -1), (1, 2), (2, 1), (2, -1), (1, -2)]:
                between = {
                    (0, 1): [],
                    (1, 0): [],
                    (1, 1): [(0, 1), (1, 0)],
                    (1, -1): [(0, -1), (1, 0)],
                    (1, 2): [(0, 1), (1, 1)],
                    (1, -2): [(0, -1), (1, -1)],
                    (2, 1): [(1, 0), (1, 1)],
                    (2, -1): [(1, 0), (1, -1)],
                }[down, right]
                path = [(i + down, j + right), *((i + a, j + b) for a, b in between)]
                if all(step in cells for step in path):
                    into.add_edge((i, j), (i + down, j + right), weight=np.hypot(down, right))
    far = nx.single_source_dijkstra_path_length(graph, (0, 0)) if (0, 0) in graph else {}
    straight = nx.single_source_dijkstra_path_length(empty, (0, 0))
    found = []
    for bearing in bearing_of(np.arange(directions), directions):
        end = (round(radius * np.sin(bearing) / cell), round(radius * np.cos(bearing) / cell))
        found.append(far.get(end, np.inf) / straight[end])
    return np.array(found)


def test_explorable_against_networkx(labels):
    for number in range(0, 60, 20):
        share = brute_explorable(labels.ranges[number])
        clear = np.abs(share - DETOUR) > 0.004  # whole lengths are rounded by less
        assert clear.sum() >= 8
        assert (labels.explorable[number] == (share <= DETOUR))[clear].all()


def test_explorable_in_a_corridor_is_along_it():
    scene = Scene(make_box(12.0, 1.4))
    ranges = panorama_ranges(scene, np.array([[6.0, 0.7, 0.0], [6.0, 0.7, np.pi / 3]]))
    found = explorable(ranges)
    assert np.flatnonzero(found[0]).tolist() == [0, 6]
    assert np.flatnonzero(found[1]).tolist() == [4, 10]
    # A panorama in the middle of a large room has all directions, at any radius that fits.
    middle = panorama_ranges(Scene(make_box()), np.array([[5.0, 5.0, 0.3]]))
    assert explorable(middle).all()
    assert explorable(middle, 24, 2.0).shape == (1, 24)
    assert not explorable(middle, 12, 5.6)[0, [0, 3, 6, 9]].any()


@pytest.mark.parametrize("gap", [2.9, 3.01, 3.05, 3.15])
def test_a_wall_at_which_no_robot_can_stand_is_not_explorable(gap):
    # The wall is to the left of the first robot, and ahead of the second.
    scene = Scene(make_box(20.0, 20.0))
    ranges = panorama_ranges(scene, np.array([[10.0, 20.0 - gap, 0.0], [20.0 - gap, 10.0, 0.0]]))
    found = explorable(ranges)
    assert np.flatnonzero(~found[0]).tolist() == [3]
    assert np.flatnonzero(~found[1]).tolist() == [0]


def test_a_wall_that_leaves_room_for_a_robot_is_explorable():
    ranges = panorama_ranges(Scene(make_box(20.0, 20.0)), np.array([[16.75, 10.0, 0.0]]))
    assert explorable(ranges).all()


def test_turning_the_source_turns_its_labels(scene, labels):
    turned = labels.poses[:10] + np.array([0, 0, np.pi / 6 * 4])
    ranges = panorama_ranges(scene, turned)
    assert (explorable(ranges) == np.roll(labels.explorable[:10], -4, axis=1)).mean() > 0.97
    ends, _ = direction_ends(scene, turned)
    assert np.allclose(ends, np.roll(labels.ends[:10], -4, axis=1))


def test_the_paper_s_label_leaves_hardly_any_node_without_a_direction(labels):
    assert 0.1 < labels.explorable.mean() < 0.6
    assert (labels.explorable.sum(axis=1) == 0).mean() < 0.12
    assert labels.rooms.shape == (60,)
    assert labels.end_rooms.shape == (60, 12)
