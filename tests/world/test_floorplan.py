from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import make_box
from tutorial_lib.errors import InputError
from tutorial_lib.world.floorplan import FloorPlan, Room
from tutorial_lib.world.generators import FAMILIES, generate
from tutorial_lib.world.occupancy import check_closed
from tutorial_lib.world.plan_json import load_plan, save_plan


def without(plan, walls):
    """The plan without some of its walls."""
    keep = np.setdiff1d(np.arange(len(plan.walls)), walls)
    names = tuple(plan.wall_materials[i] for i in keep)
    offsets = plan.wall_offsets[keep]
    return replace(plan, walls=plan.walls[keep], wall_materials=names, wall_offsets=offsets)


def test_the_open_room_is_named_and_the_loose_end_shown(tmp_path):
    left, right = make_box(), make_box()
    moved = right.walls + np.array([20.0, 0.0, 20.0, 0.0])
    outline = tuple((x + 20.0, y) for x, y in right.rooms[0].outline)
    two = FloorPlan(
        "two",
        0,
        np.concatenate([left.walls, moved]),
        ("paint",) * 8,
        np.zeros(8),
        left.materials,
        (left.rooms[0], Room("kitchen", outline)),
    )
    check_closed(two)
    save_plan(without(two, [6]), tmp_path / "open.json")  # its upper wall
    with pytest.raises(InputError, match=r"rooms\[1\] \(kitchen\): .*\((20|30)\.00, 10\.00\)"):
        load_plan(tmp_path / "open.json")


@pytest.mark.parametrize("family", FAMILIES)
def test_a_plan_without_one_of_its_outer_walls_is_open_and_the_hint_is_there(family):
    plan = generate(family, 32)
    length = np.hypot(*(plan.walls[:, 2:] - plan.walls[:, :2]).T)
    low, high = plan.walls[:, :2] == plan.bounds[:2], plan.walls[:, 2:] == plan.bounds[:2]
    outer = np.flatnonzero((low & high).any(axis=1) & (length > 0.5))
    for wall in outer:
        with pytest.raises(InputError, match="is not closed") as caught:
            check_closed(without(plan, [wall]))
        ends = [f"({x:.2f}, {y:.2f})" for x, y in plan.walls[wall].reshape(2, 2)]
        assert any(end in str(caught.value) for end in ends)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000), st.integers(3, 12), st.booleans())
def test_area_and_contains_agree_with_opencv(seed, corners, clockwise):
    rng = np.random.default_rng(seed)
    angles = np.sort(rng.uniform(0, 2 * np.pi, corners))[:: -1 if clockwise else 1]
    radii = rng.uniform(1, 6, (corners, 1))
    star = radii * np.stack([np.cos(angles), np.sin(angles)], axis=1) + rng.uniform(-3, 3, 2)
    room, contour = Room("open", tuple(map(tuple, star.tolist()))), star.astype(np.float32)
    assert room.area == pytest.approx(cv2.contourArea(contour), rel=1e-4, abs=1e-4)
    points = np.round(rng.uniform(-8, 8, (10, 20, 2)), 1)
    points[0, 0] = star.mean(axis=0)
    depth = [cv2.pointPolygonTest(contour, p, True) for p in points.reshape(-1, 2).tolist()]
    depth = np.reshape(depth, (10, 20))
    clear = np.abs(depth) > 1e-4
    assert (room.contains(points) == (depth > 0))[clear].all()
    assert room.contains(points[3, 4]) == room.contains(points)[3, 4]


def test_segments_are_the_walls_and_then_the_sides_of_the_furniture():
    plan = generate("apartment", 33)
    walls, count = len(plan.walls), len(plan.segments)
    assert count == walls + sum(len(piece.outline) for piece in plan.furniture)
    assert plan.segment_materials.shape == plan.segment_offsets.shape == (count,)
    assert (plan.segments[:walls] == plan.walls).all()
    assert (plan.segment_offsets[:walls] == plan.wall_offsets).all()
    names = [plan.materials[i].name for i in plan.segment_materials]
    assert tuple(names[:walls]) == plan.wall_materials
    at = walls
    for piece in plan.furniture:
        side = slice(at, at + len(piece.outline))
        assert plan.segments[side, :2].tolist() == [list(corner) for corner in piece.outline]
        assert (plan.segments[side, 2:] == np.roll(plan.segments[side, :2], -1, axis=0)).all()
        assert set(names[side]) == {piece.material}
        length = np.hypot(*(plan.segments[side, 2:] - plan.segments[side, :2]).T)
        assert plan.segment_offsets[side] == pytest.approx(np.append(0, np.cumsum(length)[:-1]))
        at = side.stop
    assert make_box().segments.shape == (4, 4)


@pytest.mark.parametrize(("width", "height"), [(480.0, 480.0), (1e300, 4.0), (205.0, 205.0)])
def test_a_plan_whose_grid_has_no_room_in_memory_is_refused(width, height):
    with pytest.raises(InputError, match=r"walls"):
        make_box(width, height)


def test_a_long_building_is_no_large_one():
    assert make_box(480.0, 80.0).area == 480.0 * 80.0


@pytest.mark.parametrize("corner", [(1e300, 0.0), (0.0, -1e300), (300.0, 0.0), (np.nan, 0.0)])
def test_a_corner_far_off_the_walls_is_refused(corner):
    plan = make_box()
    outline = (*plan.rooms[0].outline, corner)
    with pytest.raises(InputError, match=r"rooms\[0\]\.outline: a corner is not finite or more"):
        replace(plan, rooms=(Room("living", outline),))


def test_rooms_that_lie_on_each_other_are_not_drawn_for_ever():
    plan = make_box(100.0, 100.0)
    check_closed(replace(plan, rooms=plan.rooms * 3))
    with pytest.raises(InputError, match="rooms: they overlap again and again"):
        check_closed(replace(plan, rooms=plan.rooms * 100))
