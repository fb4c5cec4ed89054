from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.ndimage import distance_transform_edt

from tests.conftest import make_box
from tutorial_lib.geometry import distance_to_segments
from tutorial_lib.world.floorplan import Furniture, Room
from tutorial_lib.world.generators import FAMILIES, generate
from tutorial_lib.world.occupancy import ClearanceGrid, cells_to_blocked, clearance_grid

every_plan = pytest.mark.parametrize("family", [f for f in FAMILIES if f != "scanned"])


def exact(plan, points):
    return distance_to_segments(points, plan.segments).min(axis=1)


def anywhere(plan, count, margin=1.0):
    """Points in and around the building."""
    x0, y0, x1, y1 = plan.bounds
    low, high = (x0 - margin, y0 - margin), (x1 + margin, y1 + margin)
    return np.random.default_rng(0).uniform(low, high, (count, 2))


def in_any(outlines, points):
    return np.any([Room("open", outline).contains(points) for outline in outlines], axis=0)


@every_plan
@pytest.mark.few(2)
def test_clearance_is_the_exact_distance_within_a_cell(family):
    plan = generate(family, 51)
    grid = clearance_grid(plan)
    free = np.argwhere(grid.clearance > 0)
    points = grid.centres(free[np.random.default_rng(0).integers(len(free), size=2000)])
    error = grid.at(points) - exact(plan, points)
    assert np.abs(error).max() <= grid.resolution
    assert np.abs(error).mean() <= grid.resolution / 3


@every_plan
@pytest.mark.few(2)
def test_all_room_is_free_but_for_furniture(family):
    plan = generate(family, 52)
    grid, points = clearance_grid(plan), anywhere(plan, 3000)
    furniture = in_any([piece.outline for piece in plan.furniture], points)
    inside = in_any([room.outline for room in plan.rooms], points)
    open_floor = inside & ~furniture & (exact(plan, points) > 0.25)
    assert open_floor.sum() > 500
    assert (grid.at(points[open_floor]) > 0).all()


@every_plan
@pytest.mark.few(2)
def test_nothing_is_free_in_furniture_between_wall_faces_or_outside(family):
    plan = generate(family, 53)
    grid, points = clearance_grid(plan), anywhere(plan, 6000)
    off_the_line = exact(plan, points) > grid.resolution
    furniture = in_any([piece.outline for piece in plan.furniture], points) & off_the_line
    assert furniture.sum() > 20
    assert (grid.at(points[furniture]) == 0).all()
    inside = in_any([room.outline for room in plan.rooms], points)
    doors = np.array([(*door.start, *door.end) for door in plan.doors]).reshape(-1, 4)
    passage = distance_to_segments(points, doors).min(axis=1, initial=np.inf) < 0.1
    away = ~inside & ~passage & off_the_line
    assert (grid.at(points[away]) == 0).all()
    between = 0
    for x0, y0, x1, y1 in plan.walls:
        run = np.array([x1 - x0, y1 - y0])
        if np.hypot(*run) > 0.5:
            behind = np.array([[y1 - y0, x0 - x1], [y0 - y1, x1 - x0]]) / np.hypot(*run) * 0.05
            middle = np.array([x0, y0]) + run / 2 + behind
            behind = middle[~in_any([room.outline for room in plan.rooms], middle)]
            between += len(behind)
            assert (grid.at(behind) <= grid.resolution).all()
    assert between > (5 if family == "hall" else 20)  # most halls have no wall between rooms


@every_plan
@pytest.mark.few(2)
def test_the_free_space_goes_through_every_door(family):
    plan = generate(family, 54)
    grid = clearance_grid(plan)
    for door in plan.doors:
        middle = np.mean([door.start, door.end], axis=0)
        assert grid.at(middle) == pytest.approx(exact(plan, middle[None])[0], abs=grid.resolution)


@pytest.mark.parametrize("half", [1.0, 5.0])
def test_a_corridor_around_a_block_stays_free_and_the_block_does_not(half):
    # With a half of 5 m the block is larger than all the floor around it.
    plan = make_box(12.0, 12.0, pillars=[(6.0, 6.0, half)])
    grid = clearance_grid(plan)
    width = 6.0 - half
    inside = [[width / 2, 6.0], [6.0, width / 2], [12 - width / 2, 6.0], [6.0, 12 - width / 2]]
    assert grid.at(inside) == pytest.approx(width / 2, abs=grid.resolution)
    blocked = 6.0 + np.random.default_rng(0).uniform(-half + 0.06, half - 0.06, (200, 2))
    assert (grid.at(blocked) == 0).all()


def test_furniture_larger_than_the_floor_beside_it_is_not_taken_for_the_floor():
    flush = Furniture("stage", ((0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)), "paint")
    grid = clearance_grid(replace(make_box(4.0, 4.0), furniture=(flush,)))
    assert grid.at([[2.0, 3.5], [2.0, 1.5]]) == pytest.approx([0.5, 0.0], abs=grid.resolution)


@pytest.mark.parametrize("seed", range(60, 64))
@pytest.mark.few(2)
def test_loop_corridors_are_free_all_the_way_round(seed):
    plan = generate("loop_corridor", seed)
    grid = clearance_grid(plan)
    halls = [room for room in plan.rooms if room.kind == "hallway"]
    points = anywhere(plan, 4000, 0.0)
    inside = in_any([room.outline for room in halls], points) & (exact(plan, points) > 0.2)
    clutter = in_any([piece.outline for piece in plan.furniture], points)
    assert (grid.at(points[inside & ~clutter]) > 0).all()


@pytest.mark.parametrize("resolution", [0.02, 0.05, 0.1])
def test_the_resolution_bounds_the_error(resolution):
    plan = make_box(6.0, 4.0, pillars=[(2.03, 1.51, 0.3)])
    grid = clearance_grid(plan, resolution)
    assert grid.resolution == resolution
    cells = np.argwhere(grid.clearance > 0)
    points = grid.centres(cells)
    assert np.abs(grid.at(points) - exact(plan, points)).max() <= resolution
    area = len(cells) * resolution**2
    assert area == pytest.approx(6 * 4 - 0.6**2, abs=resolution * 2 * (20 + 2.4))


GRID = ClearanceGrid(
    np.random.default_rng(0).random((30, 50), dtype=np.float32), (-1.3, 2.7), resolution=0.1
)


def test_cells_and_centres_undo_each_other():
    cells = np.stack(np.indices((30, 50)), axis=-1)
    assert (GRID.cells(GRID.centres(cells)) == cells).all()
    assert (GRID.at(GRID.centres(cells)) == GRID.clearance).all()
    assert GRID.centres([0, 0]) == pytest.approx([-1.25, 2.75])  # the lower left cell
    assert GRID.centres([0, 49]) == pytest.approx([3.65, 2.75])  # the lower right one


@given(st.floats(-1.3, 3.69), st.floats(2.7, 5.69))
def test_a_point_lies_in_its_cell(x, y):
    centre = GRID.centres(GRID.cells([x, y]))
    assert np.abs(centre - [x, y]).max() <= GRID.resolution / 2 + 1e-9


@given(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6))
def test_a_point_off_the_grid_gets_the_nearest_cell(x, y):
    nearest = np.clip([x, y], [-1.29, 2.71], [3.69, 5.69])
    if not np.allclose(nearest, [x, y], atol=0.02):
        row, column = GRID.cells([x, y])
        if abs(x - nearest[0]) > 0.02:
            assert column == (0 if x < 0 else 49)
        if abs(y - nearest[1]) > 0.02:
            assert row == (0 if y < 3 else 29)


def test_the_number_of_threads_changes_nothing():
    cells = (np.random.default_rng(0).random((300, 400)) > 0.01).astype(np.uint8)
    before, found = cv2.getNumThreads(), []
    try:
        for threads in (1, 2, 7):
            cv2.setNumThreads(threads)
            found.append(cells_to_blocked(cells))
    finally:
        cv2.setNumThreads(before)
    assert (found[0] == found[1]).all()
    assert (found[0] == found[2]).all()
    assert found[0] == pytest.approx(distance_transform_edt(cells), abs=1e-5)
