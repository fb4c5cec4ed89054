"""Local maps, paths through them, and frontiers."""

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import make_box, random_walls
from tutorial_lib.exploration.frontier import (
    all_frontiers,
    crops,
    is_frontier,
    nearest_frontiers,
)
from tutorial_lib.exploration.grid_kernels import (
    FREE,
    OCCUPIED,
    STRAIGHT,
    UNKNOWN,
    path_length,
    spread,
)
from tutorial_lib.exploration.labels import panorama_ranges
from tutorial_lib.exploration.local_map import RESOLUTION, LocalMaps
from tutorial_lib.exploration.local_policy import LocalPolicy, find_paths
from tutorial_lib.geometry import compose, distance_to_segments
from tutorial_lib.world.noise import FORWARD, LEFT, RIGHT
from tutorial_lib.world.raycast import Raycaster
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.sensors import PanoramicCamera

ONE = np.array([0])


def seen_from(pose, scene, maps=None, at=None):
    """A map of one robot after looking from `pose`; its odometry starts there."""
    maps = LocalMaps(1) if maps is None else maps
    at = np.zeros(3) if at is None else np.asarray(at, dtype=float)
    maps.observe(ONE, at[None], panorama_ranges(scene, np.atleast_2d(pose)))
    return maps


def kinds(maps, points):
    """The kinds of the cells at points (M, 2)."""
    return maps.grids[0].ravel()[maps.cells(np.zeros(len(points), int), np.asarray(points))]


@settings(max_examples=40)
@given(st.integers(0, 2**32 - 1))
def test_spread_is_dijkstra(seed):
    rng = np.random.default_rng(seed)
    cost = rng.choice([0, 1, 1, 1, 2, 3, 8], (14, 14)).astype(np.uint8)
    start = int(rng.integers(196))
    length, parent = np.empty(196, np.int32), np.empty(196, np.int32)
    assert spread(cost, start, np.zeros((14, 14), np.uint8), length, parent) == -1
    graph = nx.DiGraph()
    graph.add_node(start)
    for cell in range(196):
        i, j = divmod(cell, 14)
        if not cost[i, j] and cell != start:
            continue
        for down in range(-2, 3):
            for right in range(-2, 3):
                metres = {1: 29, 2: 41, 5: 65}.get(down**2 + right**2)
                if metres is None or not (0 <= i + down < 14 and 0 <= j + right < 14):
                    continue
                half = (int(np.trunc(down / 2)), int(np.trunc(right / 2)))
                if metres == 41:
                    between = [(down, 0), (0, right)]
                elif metres == 65:
                    between = [half, (down - half[0], right - half[1])]
                else:
                    between = []
                cells = [(i + down, j + right), *((i + a, j + b) for a, b in between)]
                if all(cost[at] for at in cells):
                    to = int(cost[i + down, j + right])
                    graph.add_edge(cell, (i + down) * 14 + j + right, weight=metres * to)
    expected = nx.single_source_dijkstra_path_length(graph, start)
    assert {c: length[c] for c in range(196) if length[c] >= 0} == expected
    for cell in expected:
        if cell != start:
            step = graph[int(parent[cell])][cell]["weight"]
            assert length[cell] == length[parent[cell]] + step


def test_a_map_has_free_floor_walls_and_what_was_not_seen():
    scene = Scene(make_box(4.0, 4.0, [(3.0, 2.0, 0.2)]))
    maps = seen_from([2.0, 2.0, 0.0], scene)
    assert (kinds(maps, [(0, 0), (0.6, 0.0), (-1.8, 1.8), (0, -1.7)]) == FREE).all()
    assert (kinds(maps, [(0.85, 0.0), (-2.02, 0.3), (0.5, 2.02)]) == OCCUPIED).all()
    assert (kinds(maps, [(1.5, 0.0), (-3.0, 0.0)]) == UNKNOWN).all()
    turned = seen_from([2.0, 2.0, 1.0], scene, at=[0, 0, 1.0])
    assert (turned.grids == maps.grids).mean() > 0.98


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_a_map_agrees_with_the_raycaster(seed):
    """What is marked free is in sight and near; what is occupied is at a wall."""
    rng = np.random.default_rng(seed)
    walls = np.concatenate([random_walls(6, 6.0, rng), Scene(make_box(6.0, 6.0)).plan.segments])
    pose = np.array([3.0, 3.0, rng.uniform(-3, 3)])
    if distance_to_segments(pose[None, :2], walls).min() < 0.3:
        return
    caster, camera = Raycaster(walls), PanoramicCamera()
    ranges = caster.cast(pose[None], camera.fan).distance[:, ::-1]
    maps = LocalMaps(1, 9.0, 2.5)
    maps.observe(ONE, pose[None], ranges)
    for kind in (FREE, OCCUPIED):
        cells = np.flatnonzero(maps.grids[0].ravel() == kind)
        middles = maps.centres(np.zeros(len(cells), int), cells)
        far = np.linalg.norm(middles - pose[:2], axis=1)
        assert far.max(initial=0.0) < 2.5 + 0.15
        if kind == OCCUPIED:
            gaps = distance_to_segments(middles, walls).min(axis=1)
            assert (gaps < 0.12).mean() > 0.8  # walls are drawn on between two rays
        else:
            assert len(cells) > 30
            clear = distance_to_segments(middles, walls).min(axis=1) > 0.15
            sees = caster.sees(np.tile(pose[:2], (len(middles), 1)), middles)
            assert sees[clear].mean() > 0.94  # rays between two columns may graze an edge
            assert (maps.grids[0] == FREE).sum() > 0.9 * 100 * visible_area(ranges[0], 2.3)


def visible_area(ranges, reach):
    """Square metres in sight within `reach`."""
    return (np.pi / len(ranges)) * (np.minimum(ranges, reach) ** 2).sum()


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_a_path_s_length_is_that_of_its_steps_whatever_they_cost(seed):
    rng = np.random.default_rng(seed)
    cost = rng.choice([0, 1, 1, 1, 3, 8], (12, 12)).astype(np.uint8)
    start = int(rng.integers(144))
    length, parent = np.empty(144, np.int32), np.empty(144, np.int32)
    spread(cost, start, np.zeros((12, 12), np.uint8), length, parent)
    steps = nx.DiGraph()
    steps.add_node(start)
    for cell in np.flatnonzero(parent >= 0).tolist():
        (i, j), (k, m) = divmod(cell, 12), divmod(int(parent[cell]), 12)
        steps.add_edge(int(parent[cell]), cell, weight=np.hypot(i - k, j - m))
    assert nx.is_arborescence(steps)
    expected = nx.single_source_dijkstra_path_length(steps, start)
    for cell, metres in expected.items():
        assert path_length(parent, cell, 12) == pytest.approx(metres)
        assert length[cell] >= 29 * metres - 0.2 * len(expected)  # no cell costs less than 1


def test_a_frontier_s_metres_do_not_count_walls_more_than_once():
    """Through a passage of six cells, all of which are near a wall and cost three times as much."""
    maps = LocalMaps(1)
    grid = maps.grids[0]
    grid[41:49, 44:65] = OCCUPIED
    grid[42:48, 45:65] = FREE
    grid[35:55, 65:80] = FREE
    here, mouth = (maps.centres(ONE, np.array([45 * 90 + column])) for column in (47, 65))
    for search in (nearest_frontiers, all_frontiers):
        found = search(maps, ONE, np.column_stack([here, [0.0]]))
        assert len(found.metres)
        assert (found.places[:, 0] > mouth[0, 0] - 0.1).all()
        least = np.linalg.norm(mouth - here) + np.linalg.norm(found.places - mouth, axis=1)
        assert (np.abs(found.metres - least) < 0.12 * least + 0.15).all()


def test_what_is_seen_now_replaces_what_was_seen_before():
    maps = seen_from([2.0, 2.0, 0.0], Scene(make_box(4.0, 4.0, [(3.0, 2.0, 0.2)])))
    seen_from([2.0, 2.0, 0.0], Scene(make_box(4.0, 4.0)), maps)
    assert (kinds(maps, [(0.85, 0.0), (1.5, 0.0)]) == FREE).all()


def test_a_map_moves_with_its_robot_and_keeps_what_is_near():
    scene = Scene(make_box(30.0, 4.0))
    maps, before = LocalMaps(1), None
    for x in np.arange(0.0, 20.0, 0.5):
        seen_from([3.0 + x, 2.0, 0.0], scene, maps, [x, 0.0, 0.0])
        middle = maps.corners[0] + maps.grids.shape[1] / 2 * RESOLUTION
        assert np.abs(middle - [x, 0.0]).max() < 1.3
        assert (kinds(maps, [(x + 1.0, 0.0), (x - min(x, 2.5), 0.0)]) == FREE).all()
        assert (kinds(maps, [(x, 2.03), (x, -2.03)]) == OCCUPIED).all()
        cells = maps.corners[0] / RESOLUTION
        assert np.allclose(cells, np.rint(cells))  # by whole cells
        before = x
    assert before > 15


def test_a_path_goes_around_a_wall_and_ends_at_the_target():
    scene = Scene(make_box(6.0, 6.0, [(3.0, 3.0, 0.6)]))
    maps = seen_from([1.5, 3.0, 0.0], scene)
    seen_from([3.0, 1.2, 0.0], scene, maps, [1.5, -1.8, 0.0])
    target = np.array([[3.0, 0.0]])
    ahead, ends = find_paths(maps, ONE, np.zeros((1, 3)), target)
    assert np.allclose(ends, target)
    assert ahead[0, 1] < -0.2  # by the side that was seen to be free


def test_a_path_to_where_none_leads_ends_as_near_as_possible():
    maps = seen_from([1.5, 1.5, 0.0], Scene(make_box(3.0, 3.0)))
    _, ends = find_paths(maps, ONE, np.zeros((1, 3)), np.array([[2.6, 0.0]]))
    assert 1.0 < ends[0, 0] < 1.4
    assert abs(ends[0, 1]) < 0.3


def test_the_policy_drives_to_its_target_without_touching_anything():
    from tutorial_lib.exploration.motion import EXACT, move

    scene = Scene(make_box(6.0, 6.0, [(3.0, 3.0, 0.5), (1.2, 4.5, 0.3)]))
    start, target = np.array([1.0, 1.0, 2.0]), np.array([5.0, 5.0])
    pose, odometry = start[None], np.array([[1.0, 1.0, 2.0]])
    maps = LocalMaps(1)
    policy = LocalPolicy(maps)
    for _ in range(90):
        maps.observe(ONE, odometry, panorama_ranges(scene, pose))
        actions, left = policy.act(ONE, odometry, target[None])
        assert actions[0] in (FORWARD, LEFT, RIGHT)
        if left[0] < 0.3:
            break
        pose, stopped = move(pose, EXACT[actions], scene.plan.segments, 0.18)
        odometry = pose
        assert not stopped.any()
    assert np.linalg.norm(pose[0, :2] - target) < 0.3


def test_the_nearest_frontier_is_where_the_known_floor_ends():
    scene = Scene(make_box(20.0, 3.0))
    maps = LocalMaps(1, 16.0, 3.0)
    seen_from([5.0, 1.5, 0.0], scene, maps)
    found = nearest_frontiers(maps, ONE, np.zeros((1, 3)))
    assert found.robots.tolist() == [0]
    assert 2.3 < abs(found.places[0, 0]) < 3.2
    assert is_frontier(maps, ONE, found.places).all()
    every = all_frontiers(maps, ONE, np.zeros((1, 3)))
    assert every.metres.min() == pytest.approx(found.metres[0])
    assert {np.sign(x) for x in every.places[:, 0]} == {-1.0, 1.0}
    maps.close(ONE, found.places)
    assert not is_frontier(maps, ONE, found.places).any()
    closed = seen_from([2.0, 1.5, 0.0], Scene(make_box(4.0, 3.0)), LocalMaps(1, 16.0, 3.0))
    assert len(nearest_frontiers(closed, ONE, np.zeros((1, 3))).robots) == 0


def test_a_place_that_is_closed_keeps_what_was_seen_of_it():
    maps = LocalMaps(2)
    maps.grids[:, 40:45, 45], maps.grids[:, 46, 40:50] = FREE, OCCUPIED
    before = maps.grids.copy()
    maps.close(np.array([1]), np.array([[0.05, 0.05]]))  # the cell (45, 45)
    assert (maps.grids[0] == before[0]).all()
    rows, columns = np.nonzero(maps.grids[1] != before[1])
    assert (before[1, rows, columns] == UNKNOWN).all()
    assert (maps.grids[1, rows, columns] == OCCUPIED).all()
    assert (rows.min(), rows.max(), columns.min(), columns.max()) == (42, 48, 42, 48)


def test_frontiers_shrink_until_a_building_is_known(scenes, episodes):
    name, scene = next(iter(scenes.items()))
    start = episodes.starts[0]
    maps, pose = LocalMaps(1, 40.0, 3.0), np.zeros(3)
    for _ in range(60):
        maps.observe(ONE, pose[None], panorama_ranges(scene, compose(start, pose)[None]))
        found = nearest_frontiers(maps, ONE, pose[None])
        if not len(found.robots):
            break
        ahead = find_paths(maps, ONE, pose[None], found.places)[0][0]
        if np.linalg.norm(ahead - pose[:2]) < 0.15:
            maps.close(ONE, found.places)
        pose = np.array([*ahead, 0.0])
    assert name
    known = (maps.grids[0] == FREE).sum() * RESOLUTION**2
    assert known > 0.6 * (scene.clearance.clearance > 0).mean() * np.prod(
        np.array(scene.clearance.clearance.shape) * 0.05
    )


def actions_at(*headings):
    """What a robot does that stands in the open at these headings (deg), one after the other."""
    maps = LocalMaps(1)
    maps.grids[:] = FREE
    policy, target = LocalPolicy(maps), np.array([[2.0, 0.0]])
    poses = [np.array([[0.0, 0.0, np.deg2rad(heading)]]) for heading in headings]
    return [int(policy.act(ONE, pose, target)[0][0]) for pose in poses]


def test_a_robot_that_turned_too_far_goes_ahead_rather_than_back():
    assert actions_at(-30, 15) == [LEFT, FORWARD]
    assert actions_at(30, -15) == [RIGHT, FORWARD]
    assert actions_at(-30, -15) == [LEFT, LEFT]
    assert actions_at(-30, 40) == [LEFT, RIGHT]


def test_a_robot_that_did_not_get_on_turns_three_times_before_it_tries_again():
    assert actions_at(-1, -1, -1, -1, -1, -1) == [FORWARD, LEFT, LEFT, LEFT, FORWARD, LEFT]


def test_beyond_the_map_a_crop_is_unknown():
    maps = LocalMaps(1)
    maps.grids[:] = FREE
    crop = crops(maps, ONE, np.array([[4.0, 0.0, 0.0]]), 64)[0]  # 4.5 m from the middle it ends
    assert (crop[:, :37] == FREE).all()
    assert (crop[:, 37:] == UNKNOWN).all()


def test_crops_turn_with_the_robot():
    scene = Scene(make_box(6.0, 3.0))
    maps = seen_from([2.0, 1.5, 0.0], scene)
    ahead = crops(maps, ONE, np.zeros((1, 3)), 64)[0]
    left = crops(maps, ONE, np.array([[0.0, 0.0, np.pi / 2]]), 64)[0]
    assert ahead.shape == (64, 64)
    assert (np.rot90(ahead, 1) == left).mean() > 0.97 or (np.rot90(ahead, -1) == left).mean() > 0.97
    assert (ahead[:, 10] == UNKNOWN).all()  # behind the wall in the robot's back
    assert (ahead[20:44, 32:60] == FREE).mean() > 0.9
    assert STRAIGHT == 29
