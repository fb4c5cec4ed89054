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
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.simulation import Simulation


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


@pytest.mark.parametrize("corner", [(1e12, 0.0), (0.0, -1e12), (300.0, 0.0), (np.nan, 0.0)])
def test_a_corner_far_off_the_walls_is_refused(corner):
    plan = make_box()
    outline = (*plan.rooms[0].outline, corner)
    with pytest.raises(InputError, match=r"rooms\[0\]\.outline: it is not finite, or lies off"):
        replace(plan, rooms=(Room("living", outline),))


@pytest.mark.parametrize("shift", [(20.0, 0.0), (0.0, -10.5), (-11.0, -9.0), (10.2, 0.0)])
def test_a_room_that_no_wall_is_about_is_named_before_it_is_drawn(shift):
    plan = make_box()
    outline = tuple((x + shift[0], y + shift[1]) for x, y in plan.rooms[0].outline)
    rooms = (*plan.rooms, Room("kitchen", outline))
    with pytest.raises(
        InputError, match=r"rooms\[1\]\.outline: .* off the walls, which reach from"
    ):
        check_closed(replace(plan, rooms=rooms))


@pytest.mark.parametrize("place", [1e14, -1e14, 3e7])
def test_a_plan_where_numbers_are_too_coarse_is_refused(place):
    plan = make_box()
    with pytest.raises(InputError, match=r"walls\[0\]: .*; give metres, 2e\+07 at most"):
        replace(plan, walls=plan.walls + place)


def test_a_plan_in_utm_is_as_good_as_one_at_the_origin():
    """A car drives and sees the same 5,400 km off the origin."""
    found = []
    for place in (np.zeros(2), np.array([500_000.0, 5_400_000.0])):
        plan = make_box(pillars=[(2.0, 1.5, 0.3)])
        shifted = replace(
            plan,
            walls=plan.walls + np.tile(place, 2),
            rooms=tuple(Room(r.kind, tuple(map(tuple, r.outline + place))) for r in plan.rooms),
            furniture=tuple(
                replace(f, outline=tuple(map(tuple, f.outline + place))) for f in plan.furniture
            ),
        )
        check_closed(shifted)
        simulation = Simulation(Scene(shifted), np.append(place + 1.0, 0.3)[None])
        for _ in range(30):
            simulation.step(np.array([[0.5, 0.2]]))
        seen = simulation.observe()
        found.append([simulation.poses[0] - [*place, 0.0], seen.laser, seen.image.astype(float)])
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(one, other, atol=1e-6 if one.size < 1000 else 1.0)


@pytest.mark.parametrize(("width", "fits"), [(300.0, True), (1000.0, True), (1001.0, False)])
def test_a_building_may_be_as_long_as_the_limit_says_wherever_its_walls_are(width, fits):
    walls = np.array(
        [[0, 0, 1, 0]] * 9 + [[0, 0, width, 0], [width, 0, width, 9], [width, 9, 0, 9]]
    )
    plan = make_box()
    shape = {"walls": walls, "wall_materials": (plan.wall_materials[0],) * len(walls)}
    shape |= {"wall_offsets": np.zeros(len(walls)), "furniture": ()}
    if fits:
        assert replace(plan, **shape).bounds[2] == width
    else:
        with pytest.raises(
            InputError, match=r"spans 1,001 m x 9 m, more than 1,000 m; give metres"
        ):
            replace(plan, **shape)


def test_rooms_that_lie_on_each_other_are_not_drawn_for_ever():
    plan = make_box(100.0, 100.0)
    check_closed(replace(plan, rooms=plan.rooms * 3))
    with pytest.raises(InputError, match="rooms: they overlap again and again"):
        check_closed(replace(plan, rooms=plan.rooms * 100))
