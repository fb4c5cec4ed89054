from dataclasses import replace

import networkx as nx
import numpy as np
import pytest

from tests.conftest import make_box
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.geometry import arc_length
from tutorial_lib.world.floorplan import Room
from tutorial_lib.world.generators import FAMILIES, generate
from tutorial_lib.world.occupancy import ClearanceGrid
from tutorial_lib.world.scene import Scene

GOAL = np.array([8.5, 8.5])


@pytest.fixture
def paths(pillars):
    return GridPaths(pillars.clearance)


def test_in_an_empty_room_the_geodesic_is_nearly_the_straight_line(box):
    paths = GridPaths(box.clearance)
    points = np.random.default_rng(0).uniform(0.6, 9.4, (200, 2))
    straight = np.linalg.norm(points - GOAL, axis=1)
    measured = paths.fields(GOAL, shortest=True).distance(points)
    assert (measured >= straight - 1e-9).all()
    # Sixteen directions are at most 2.8% too long, and either end up to 0.07 m off its node.
    assert (measured <= 1.028 * straight + 0.29).all()


@pytest.mark.parametrize("shortest", [True, False])
def test_costs_are_those_of_networkx(pillars, shortest):
    paths = GridPaths(pillars.clearance, clearance=0.6)
    fields = paths.fields(GOAL, shortest=shortest)
    weights = (paths._geodesic if shortest else paths._comfortable).tocoo()
    graph = nx.Graph()
    graph.add_weighted_edges_from(
        zip(weights.row.tolist(), weights.col.tolist(), weights.data.tolist(), strict=True)
    )
    source = int(paths.nearest(GOAL)[0])
    expected = nx.single_source_dijkstra_path_length(graph, source)
    assert len(expected) > 1000
    costs = [expected.get(node, np.inf) for node in range(len(paths.points))]
    assert np.allclose(fields.cost[0], costs)


def test_every_edge_keeps_its_clearance(paths, pillars):
    head, tail, length = paths._edges
    middle = (paths.points[head] + paths.points[tail]) / 2
    assert pillars.clearance.at(middle).min() > 0.1
    assert np.allclose(length, np.linalg.norm(paths.points[head] - paths.points[tail], axis=1))
    assert pillars.caster.sees(paths.points[head], paths.points[tail]).all()


def test_paths_are_as_long_as_promised_and_cross_no_wall(paths, pillars):
    fields = paths.fields(GOAL, shortest=True)
    for start in np.random.default_rng(1).uniform(1.0, 9.0, (30, 2)):
        if pillars.clearance.at(start) < 0.3:
            continue
        path = fields.path(start)
        assert (path[0] == start).all()
        assert (path[-1] == GOAL).all()
        # The path cuts the corners from either end to its node.
        promised = fields.distance(start[None])[0]
        assert promised - 0.3 <= arc_length(path)[-1] <= promised + 1e-9
        assert pillars.caster.sees(path[:-1], path[1:]).all()


def test_comfortable_paths_are_longer_and_keep_farther_off(pillars):
    paths = GridPaths(pillars.clearance)
    start = np.array([1.5, 3.0])
    shortest = paths.fields([9.0, 3.9], shortest=True).path(start)
    comfortable = paths.fields([9.0, 3.9]).path(start)
    assert arc_length(comfortable)[-1] >= arc_length(shortest)[-1] - 1e-9
    assert pillars.clearance.at(comfortable).min() > pillars.clearance.at(shortest).min() + 0.1


def test_many_goals_at_once_give_what_single_goals_give(paths):
    goals = np.array([[1.0, 1.0], [9.0, 9.0], [1.0, 9.0]])
    points = np.random.default_rng(2).uniform(0.7, 9.3, (30, 2))
    together = paths.fields(goals)
    for number, goal in enumerate(goals):
        alone = paths.fields(goal).distance(points)
        assert np.allclose(together.distance(points, np.full(30, number)), alone)


def test_waypoints_are_on_the_path_in_sight_and_within_reach(paths, pillars):
    fields = paths.fields(np.stack([GOAL, [1.0, 9.0]]))
    points = paths.points[np.random.default_rng(3).integers(len(paths.points), size=60)]
    goals = np.arange(60) % 2
    waypoints = fields.waypoints(points, goals, pillars.caster, 2.0)
    assert pillars.caster.sees(points, waypoints).all()
    assert (np.linalg.norm(waypoints - points, axis=1) <= 2.01).all()
    before, after = fields.distance(points, goals), fields.distance(waypoints, goals)
    assert (after[before > 0.3] < before[before > 0.3]).all()
    near = np.linalg.norm(points - fields.goals[goals], axis=1) < 1.5
    for i in np.flatnonzero(near & pillars.caster.sees(points, fields.goals[goals])):
        assert np.allclose(waypoints[i], fields.goals[goals[i]])


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.few(2)
def test_lengths_without_paths_are_the_same_to_the_last_bit(family):
    paths, rng = GridPaths(Scene(generate(family, 7)).clearance), np.random.default_rng(4)
    goals = paths.points[rng.integers(len(paths.points), size=6)]
    goals[3:] += rng.uniform(-0.04, 0.04, (3, 2))  # beside a node
    found, fields = paths.metres_to(goals), paths.fields(goals, shortest=True)
    for number, metres in enumerate(found):
        expected = fields.distance(paths.points, number)
        assert metres.tobytes() == expected.tobytes()
    assert paths.metres_to(goals[4]).tobytes() == found[4].tobytes()


def test_a_goal_near_a_wall_counts_its_whole_path(box):
    fields = GridPaths(box.clearance).fields([9.9, 5.0], shortest=True)
    assert fields.distance([[5.0, 5.0]])[0] == pytest.approx(4.9, abs=0.15)


def test_what_lies_behind_a_wall_cannot_be_reached():
    # Two rooms, and no door between them.
    one, other = make_box(4.0, 4.0), make_box(6.0, 6.0)
    apart = replace(
        one,
        walls=np.concatenate([one.walls, other.walls + 4.2]),
        wall_materials=one.wall_materials * 2,
        wall_offsets=np.zeros(8),
        rooms=(one.rooms[0], Room("office", ((4.2, 4.2), (10.2, 4.2), (10.2, 10.2), (4.2, 10.2)))),
    )
    scene = Scene(apart)
    paths = GridPaths(scene.clearance)
    fields = paths.fields([5.0, 5.0])
    assert np.isinf(fields.distance([[1.0, 1.0]])[0])
    # As the crow flies these two are 0.9 m apart.
    assert np.isinf(paths.fields([4.5, 4.5]).distance([[3.7, 3.7]])[0])
    assert np.isfinite(fields.distance([[9.2, 9.1]])[0])
    with pytest.raises(InputError, match="no path from"):
        fields.path([1.0, 1.0])
    reached = np.isfinite(paths.metres_to([5.0, 5.0])[0])
    largest = paths.largest
    assert (reached == largest).all()
    assert largest[paths.nearest([5.0, 5.0])[0]]
    assert not largest[paths.nearest([1.0, 1.0])[0]]


@pytest.mark.parametrize("goal", [[5.0, np.nan], [-3.0, 5.0], [3.0, 3.0]])
def test_a_goal_that_is_not_free_is_refused(paths, goal):
    for measure in (paths.fields, paths.metres_to):
        with pytest.raises(InputError, match=r"goals: .*(not in free space|give finite)"):
            measure(goal)


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.few(2)
def test_each_plan_hangs_together(family):
    scene = Scene(generate(family, 12))
    paths = GridPaths(scene.clearance, 0.25)
    assert paths.largest.mean() > 0.99


def cells_crossed(down, right):
    """All cells that a step from (0, 0) crosses, or passes by at a corner."""
    share = np.linspace(0, 1, 501)[:, None]
    beside = 0.05 * np.array([-right, down]) / np.hypot(down, right)
    line = np.concatenate([share * [down, right] + beside, share * [down, right] - beside])
    return {tuple(cell) for cell in np.rint(line).astype(int).tolist()}


def test_an_edge_crosses_free_cells_alone_and_none_is_left_out():
    free = np.random.default_rng(5).random((14, 17)) < 0.7
    clearance = np.zeros((28, 34), np.float32)
    clearance[::2, ::2] = free
    paths = GridPaths(ClearanceGrid(clearance, (0.0, 0.0), 0.05), clearance=0.5)
    cells = np.argwhere(free)
    number = {tuple(cell): n for n, cell in enumerate(cells.tolist())}
    steps = [(d, r) for d in range(-2, 3) for r in range(-2, 3) if np.gcd(d, r) == 1]
    assert len(steps) == 16
    expected = {
        (number[row, column], number[row + down, column + right])
        for row, column in number
        for down, right in steps
        if all((row + d, column + r) in number for d, r in cells_crossed(down, right))
    }
    head, tail, _ = paths._edges
    found = list(zip(head.tolist(), tail.tolist(), strict=True))
    assert sorted([*found, *((b, a) for a, b in found)]) == sorted(expected)


def test_the_dislike_of_walls_grows_with_the_square_of_their_closeness():
    # In the middle of a corridor 0.6 m wide, walls are half as far off as is comfortable.
    paths = GridPaths(Scene(make_box(10.0, 0.6)).clearance, comfort=0.6, caution=4.0)
    middle = paths.clearance.max()
    assert middle == pytest.approx(0.3, abs=0.04)
    felt = paths.fields([9.0, 0.3]).distance([[1.0, 0.3]])[0]
    assert felt / 8.0 == pytest.approx(1 + 4 * (1 - middle / 0.6) ** 2, rel=0.02)


def test_a_waypoint_is_the_last_place_before_the_first_that_is_hidden():
    scene, reach, again = Scene(generate("apartment", 3)), 12.0, 0
    paths, rng = GridPaths(scene.clearance), np.random.default_rng(6)
    places = paths.points[paths.largest]
    starts, goals = places[rng.integers(len(places), size=(2, 150))]
    fields, number = paths.fields(goals), np.arange(150)
    found = fields.waypoints(starts, number, scene.caster, reach)
    for goal, start, waypoint in zip(number, starts, found, strict=True):
        path = fields.path(start, goal)
        metres = np.linalg.norm(np.diff(path, axis=0), axis=1).cumsum()
        seen = scene.caster.sees(np.tile(start, (len(path) - 1, 1)), path[1:])
        seen &= metres <= reach
        last = len(seen) if seen.all() else int(seen.argmin())
        assert np.allclose(waypoint, path[last])
        again += seen[last:].any()
    assert again > 3  # of the paths come into sight again
