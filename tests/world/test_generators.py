import os
import subprocess
import sys
from collections import Counter
from functools import cache

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tutorial_lib.errors import InputError
from tutorial_lib.geometry import distance_to_segments, to_local
from tutorial_lib.world.generators import FAMILIES, area_limits, generate
from tutorial_lib.world.generators.furniture import FURNISHING, SIZES
from tutorial_lib.world.generators.palette import COLOURS, FEATURES, FURNITURE, WALLS
from tutorial_lib.world.generators.rectilinear import DoesNotFit, inset, outline_of
from tutorial_lib.world.generators.stock import LOOSE
from tutorial_lib.world.materials import PERIOD
from tutorial_lib.world.occupancy import check_closed, clearance_grid
from tutorial_lib.world.plan_json import plan_from_json, plan_to_json

SEEDS = range(40, 46)
DRAWN = [family for family in FAMILIES if family != "scanned"]
EVERY = [(family, seed) for family in DRAWN for seed in SEEDS]

every_plan = pytest.mark.parametrize(("family", "seed"), EVERY)
every_family = pytest.mark.parametrize("family", DRAWN)
cached = cache(generate)


def rectangle(x0, y0, x1, y1):
    return ((x0, y0), (x1, y0), (x1, y1), (x0, y1))


def inside(outline, points):
    """Whether each point is inside a polygon, by crossing number."""
    x, y = np.asarray(points).T
    odd = np.zeros(len(x), dtype=bool)
    for (x0, y0), (x1, y1) in zip(outline, (*outline[1:], outline[0]), strict=True):
        if y0 != y1:
            odd ^= ((y0 > y) != (y1 > y)) & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))
    return odd


def neighbours(plan):
    """For each room the kinds of the rooms behind its doors."""
    kinds = [set() for _ in plan.rooms]
    for one, two in (door.rooms for door in plan.doors):
        kinds[one].add(plan.rooms[two].kind)
        kinds[two].add(plan.rooms[one].kind)
    return kinds


def properly_cross(segments):
    """(S, S) whether two segments cut one another in a point inside both."""
    start, end = segments[:, None, :2], segments[:, None, 2:]
    other = segments[None]

    def side(point):
        along, offset = end - start, point - start
        return along[..., 0] * offset[..., 1] - along[..., 1] * offset[..., 0]

    apart = (side(other[..., :2]) * side(other[..., 2:])) < -1e-12
    return apart & apart.T


def lie_on_one_another(segments):
    """(S, S) whether two different segments share more than a point."""
    low = np.minimum(segments[:, :2], segments[:, 2:])
    high = np.maximum(segments[:, :2], segments[:, 2:])
    flat = (high - low) < 1e-9
    shared = np.minimum(high[:, None], high) - np.maximum(low[:, None], low)
    found = np.zeros((len(segments), len(segments)), dtype=bool)
    for axis in (0, 1):
        same_line = (
            flat[:, None, axis] & flat[:, axis] & (abs(low[:, None, axis] - low[:, axis]) < 1e-9)
        )
        found |= same_line & (shared[..., 1 - axis] > 1e-9)
    np.fill_diagonal(found, False)
    return found


def assert_drivable(plan):
    """The car's free floor is one patch, and every room has a square metre of it."""
    grid = clearance_grid(plan, 0.05)
    wide = (grid.clearance >= 0.25).astype(np.uint8)
    count, labels, stats, _ = cv2.connectedComponentsWithStats(wide, connectivity=8)
    patches = [i for i in range(1, count) if stats[i, cv2.CC_STAT_AREA] * 0.05**2 >= 0.02]
    assert len(patches) == 1
    floor = grid.centres(np.argwhere(labels == patches[0]))
    for room in plan.rooms:
        assert inside(room.outline, floor).sum() * 0.05**2 >= 1.0


@every_plan
def test_area(family, seed):
    least, most = area_limits(family)
    assert least <= cached(family, seed).area <= most


@every_family
def test_areas_spread(family):
    areas = [cached(family, seed).area for seed in SEEDS]
    assert max(areas) - min(areas) > 60.0


@every_plan
def test_car_gets_everywhere(family, seed):
    assert_drivable(cached(family, seed))


@every_plan
def test_every_room_is_reached_through_doors(family, seed):
    plan = cached(family, seed)
    reached = {0}
    for _ in plan.rooms:
        reached |= {room for door in plan.doors if reached & set(door.rooms) for room in door.rooms}
    assert reached == set(range(len(plan.rooms)))


@every_family
def test_room_graphs_have_loops(family):
    plans = (cached(family, seed) for seed in range(40, 60))
    assert any(len(plan.doors) >= len(plan.rooms) for plan in plans)


@every_plan
def test_walls_form_closed_loops(family, seed):
    plan = cached(family, seed)
    check_closed(plan)
    assert set(Counter(map(tuple, plan.walls.reshape(-1, 2))).values()) == {2}


@every_plan
def test_no_segments_cross_or_coincide(family, seed):
    segments = cached(family, seed).segments
    assert not properly_cross(segments).any()
    assert not lie_on_one_another(segments).any()


@every_plan
def test_faces_follow_the_rooms_outlines(family, seed):
    plan = cached(family, seed)
    length = np.abs(plan.walls[:, 2:] - plan.walls[:, :2]).sum(axis=1)
    outlines = [np.asarray(room.outline) for room in plan.rooms]
    perimeter = sum(np.abs(o - np.roll(o, -1, axis=0)).sum() for o in outlines)
    openings = 2 * sum(door.width for door in plan.doors)
    posts = np.array([name == "door frame" for name in plan.wall_materials])
    assert length[~posts].sum() == pytest.approx(perimeter - openings, abs=0.01)
    assert posts.sum() == 2 * len(plan.doors)
    thickest = 0.2001 if family == "hall" else 0.1401
    assert ((length[posts] > 0.0999) & (length[posts] < thickest)).all()


@every_plan
def test_strips_run_on_around_each_room(family, seed):
    plan = cached(family, seed)
    assert (plan.wall_offsets >= 0).all()
    assert (plan.wall_offsets < PERIOD).all()
    for room in plan.rooms:
        run = 0.0
        for start, end in zip(room.outline, (*room.outline[1:], room.outline[0]), strict=True):
            here = np.flatnonzero((plan.walls[:, :2] == start).all(axis=1))
            towards = [
                i for i in here if np.dot(plan.walls[i, 2:] - start, np.subtract(end, start)) > 0
            ]
            assert len(towards) == 1
            gap = (plan.wall_offsets[towards[0]] - run + PERIOD / 2) % PERIOD - PERIOD / 2
            assert abs(gap) < 2e-3
            run += abs(end[0] - start[0]) + abs(end[1] - start[1])


@every_plan
def test_doors(family, seed):
    plan = cached(family, seed)
    for door in plan.doors:
        assert 0.8999 <= door.width <= 1.1001
        one, two = door.rooms
        assert one != two
        (x0, y0), (x1, y1) = door.start, door.end
        normal = np.array([y1 - y0, x0 - x1]) / door.width
        middle = np.array([(x0 + x1) / 2, (y0 + y1) / 2])
        ahead, behind = middle + 0.3 * normal, middle - 0.3 * normal
        outlines = plan.rooms[one].outline, plan.rooms[two].outline
        assert [[bool(inside(o, [p])[0]) for p in (ahead, behind)] for o in outlines] in (
            [[True, False], [False, True]],
            [[False, True], [True, False]],
        )
        corners = np.concatenate([np.asarray(outline) for outline in outlines])
        along = distance_to_segments(corners, [[x0, y0, x1, y1]])
        assert along.min() >= 0.1


@every_plan
@pytest.mark.few(2)
def test_furniture_leaves_doors_and_walls_alone(family, seed):
    plan = cached(family, seed)
    corners = [np.asarray(piece.outline) for piece in plan.furniture]
    for door in plan.doors:
        heading = np.arctan2(door.end[1] - door.start[1], door.end[0] - door.start[0])
        for outline in corners:
            local = to_local([*door.start, heading], outline)
            low, high = local.min(axis=0), local.max(axis=0)
            beside = high[0] < 0.0 or low[0] > door.width
            assert beside or high[1] < -0.85 or low[1] > 0.85
    for number, outline in enumerate(corners):
        assert distance_to_segments(outline, plan.walls).min() > 0.019
        assert sum(bool(inside(room.outline, outline).all()) for room in plan.rooms) == 1
        for other in corners[:number]:
            assert not inside(other, outline).any()
            assert not inside(outline, other).any()


@pytest.mark.parametrize("seed", SEEDS)
def test_apartments_make_sense(seed):
    plan = cached("apartment", seed)
    kinds = [room.kind for room in plan.rooms]
    assert {"hallway", "living", "kitchen", "bedroom", "bathroom"} <= set(kinds)
    limits = {"bathroom": (4, 10), "bedroom": (9, 22), "kitchen": (8, 20), "living": (20, 45)}
    for room, beside in zip(plan.rooms, neighbours(plan), strict=True):
        low, high = limits.get(room.kind, (0, 500))
        assert low <= room.area <= high
        if room.kind in ("bedroom", "bathroom", "living"):
            assert "hallway" in beside
        if room.kind == "bathroom":
            assert beside == {"hallway"}
        if room.kind == "bedroom":
            assert not beside & {"bathroom", "bedroom"}
        if room.kind == "kitchen":
            assert "living" in beside


@every_plan
def test_no_room_is_a_slit(family, seed):
    narrowest = 1.19 if family == "maze" else 1.39
    for room in cached(family, seed).rooms:
        limit = narrowest if room.kind == "hallway" or family == "maze" else 1.6
        sides = np.abs(np.asarray(room.outline) - np.roll(room.outline, -1, axis=0)).sum(axis=1)
        if len(room.outline) == 4:
            assert sides.min() >= limit


def signature(plan, room):
    """All that is in a room as seen from its first corner, looking along the first wall."""
    outline = np.asarray(room.outline)
    ahead = outline[1] - outline[0]
    frame = [*outline[0], np.arctan2(ahead[1], ahead[0])]

    def local(points):
        return (to_local(frame, points).round(3) + 0.0).ravel()

    on = distance_to_segments(plan.walls[:, :2], np.hstack([outline, np.roll(outline, -1, 0)]))
    ours = (on.min(axis=1) < 1e-9) & np.array([n != "door frame" for n in plan.wall_materials])
    walls = [
        (*local(plan.walls[i].reshape(2, 2)), plan.wall_materials[i], plan.wall_offsets[i])
        for i in np.flatnonzero(ours)
    ]
    pieces = [
        (*local(piece.outline), piece.kind, piece.material)
        for piece in plan.furniture
        if inside(room.outline, piece.outline[:1])[0]
    ]
    return frozenset(walls), frozenset(pieces)


@pytest.mark.parametrize("seed", SEEDS)
def test_symmetric_offices_have_rooms_exactly_alike(seed):
    plan = cached("symmetric_office", seed)
    for kind, least in (("office", 2), ("hallway", 2)):
        alike = Counter(signature(plan, room) for room in plan.rooms if room.kind == kind)
        assert alike.most_common(1)[0][1] >= least
    assert len({signature(plan, room) for room in plan.rooms}) >= 4


@every_family
def test_same_seed_same_bytes(family):
    assert plan_to_json(generate(family, 40)) == plan_to_json(cached(family, 40))
    assert plan_to_json(generate(family, np.int64(40))) == plan_to_json(cached(family, 40))
    texts = {plan_to_json(cached(family, seed)) for seed in SEEDS}
    assert len(texts) == len(SEEDS)


def test_same_bytes_in_another_process():
    code = (
        "import sys, hashlib\n"
        "from tutorial_lib.world.generators import FAMILIES, generate\n"
        "from tutorial_lib.world.plan_json import plan_to_json\n"
        "text = ''.join(plan_to_json(generate(family, 41)) for family in FAMILIES)\n"
        "sys.stdout.buffer.write(text.encode())\n"
    )
    environment = os.environ | {"PYTHONHASHSEED": "12345"}
    other = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, check=True
    )
    here = "".join(plan_to_json(cached(family, 41)) for family in FAMILIES)
    assert other.stdout.decode() == here


@every_family
@pytest.mark.few(2)
def test_shifted_palette_changes_only_the_look(family):
    plain, shifted = cached(family, 42), generate(family, 42, palette="shifted")
    for name in ("walls", "wall_offsets"):
        assert np.array_equal(getattr(plain, name), getattr(shifted, name))
    for name in ("rooms", "doors", "furniture", "wall_materials"):
        assert getattr(plain, name) == getattr(shifted, name)
    assert plan_to_json(shifted) == plan_to_json(generate(family, 42, palette="shifted"))
    for one, two in zip(plain.materials, shifted.materials, strict=True):
        assert one.name == two.name
        assert one.colour != two.colour
    assert shifted.look.palette == "shifted"
    assert 0.7 <= shifted.look.gamma <= 0.8 or 1.3 <= shifted.look.gamma <= 1.5
    assert 6.0 <= shifted.look.noise <= 12.0
    assert plain.look.noise < 6.0
    assert shifted.look.floor != plain.look.floor
    assert shifted.look.ceiling != plain.look.ceiling


def test_shifted_hues_are_none_of_the_standard_ones():
    standard = [hues for (hues, _, _), _ in COLOURS.values()]
    for _, ((low, high), _, _) in COLOURS.values():
        assert all(high < least or most < low for least, most in standard)


def test_the_walls_of_halls_are_sparse():
    plan = cached("hall", 43)
    for material in plan.materials:
        if material.name.startswith("hall"):
            features = [s for s in material.stripes if s.end - s.start > 0.031]
            assert len(features) < 2 * PERIOD  # fields of colour; there are frames as well


def test_halls_have_open_space():
    grids = [clearance_grid(cached("hall", seed)) for seed in SEEDS]
    wide = [(grid.clearance > 1.0).sum() / (grid.clearance > 0).sum() for grid in grids]
    assert np.mean(wide) > 0.3
    homes = [clearance_grid(cached("apartment", seed)) for seed in SEEDS]
    assert np.mean([(g.clearance > 1.0).sum() / (g.clearance > 0).sum() for g in homes]) < 0.1


@pytest.mark.parametrize("family", [family for family in DRAWN if family != "hall"])
def test_walls_are_full_of_features(family):
    plan = cached(family, 43)
    for name in set(plan.wall_materials) - {"door frame"}:
        (material,) = (m for m in plan.materials if m.name == name)
        features = [s for s in material.stripes if s.end - s.start > 0.031 or "bath" not in name]
        assert len(features) >= PERIOD / 0.8
        assert max(s.end for s in features) > PERIOD - 1.0
        middles = np.sort([(s.start + s.end) / 2 for s in features])
        assert np.diff(middles).max() < 2.5


def test_every_use_and_piece_is_in_the_tables():
    assert FURNISHING.keys() <= WALLS.keys()
    assert SIZES.keys() | LOOSE.keys() | {"rack", "pillar"} == FURNITURE.keys()
    strips = [*WALLS.values(), *FURNITURE.values()]
    assert {name for strip in strips for name in strip.features} == FEATURES.keys()
    names = {colour for feature in FEATURES.values() for colour in feature.colours}
    names |= {feature.frame for feature in FEATURES.values() if feature.frame}
    names |= {colour for strip in strips for colour in strip.base}
    assert names <= COLOURS.keys()


@every_family
def test_json_round_trip(family):
    text = plan_to_json(cached(family, 44))
    assert plan_to_json(plan_from_json(text)) == text


@given(family=st.sampled_from(DRAWN), seed=st.integers(0, 9_999))
@settings(max_examples=12, deadline=None, derandomize=True)
def test_any_seed(family, seed):
    plan = generate(family, seed)
    least, most = area_limits(family)
    assert least <= plan.area <= most
    check_closed(plan)
    assert_drivable(plan)
    assert not properly_cross(plan.segments).any()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("castle", 1), "family: 'castle'; give apartment, office"),
        ((3, 1), "family: 3; give apartment"),
        (("office", -1), "seed: -1; give one whole number from 0 on"),
        (("office", 1.5), "seed: 1.5; give one whole number"),
        (("office", "1"), "seed: '1'; give one whole number"),
        (("office", True), "seed: True; give one whole number"),
        (("office", 1, "neon"), "palette: 'neon'; give standard or shifted"),
        (("office", 1, "standard", "any", "arrows"), "signs: 'arrows'; give plain or wayfinding"),
    ],
)
def test_bad_input(arguments, message):
    with pytest.raises(InputError, match=message) as error:
        generate(*arguments)
    assert "\n" not in str(error.value)


def test_outline_of_rectangles():
    assert outline_of([(0, 0, 2, 1)]) == rectangle(0, 0, 2, 1)
    corner = outline_of([(0, 0, 2, 1), (0, 1, 1, 3)])
    assert corner == ((0, 0), (2, 0), (2, 1), (1, 1), (1, 3), (0, 3))
    assert inset(corner, 0.1) == (
        (0.1, 0.1),
        (1.9, 0.1),
        (1.9, 0.9),
        (0.9, 0.9),
        (0.9, 2.9),
        (0.1, 2.9),
    )


@pytest.mark.parametrize(
    "rects",
    [
        [(0, 0, 3, 1), (0, 2, 3, 3), (0, 0, 1, 3), (2, 0, 3, 3)],
        [(0, 0, 1, 1), (2, 0, 3, 1)],
    ],
)
def test_outline_refuses_holes_and_pieces(rects):
    with pytest.raises(DoesNotFit):
        outline_of(rects)


# Large ones.


@pytest.mark.parametrize("family", ["apartment", "office", "loop_corridor", "hall"])
@pytest.mark.parametrize("seed", [7])
@pytest.mark.few(2)
def test_large_plans_are_large_and_as_good(family, seed):
    plan = generate(family, seed, size="large")
    least, most = area_limits(family, "large")
    assert least <= plan.area <= most
    check_closed(plan)
    assert_drivable(plan)
    assert not properly_cross(plan.segments).any()
    assert (plan.family, plan.seed) == (family, seed)
    assert plan_to_json(plan) == plan_to_json(generate(family, seed, size="large"))
    assert plan_to_json(plan) != plan_to_json(cached(family, seed))


def test_the_usual_size_is_any_of_them():
    assert plan_to_json(generate("office", 40, size="any")) == plan_to_json(cached("office", 40))
    areas = [cached("office", seed).area for seed in SEEDS]
    assert max(areas) > area_limits("office", "large")[1]


@pytest.mark.full
def test_large_plans_differ_in_area():
    areas = [generate("office", seed, size="large").area for seed in range(5)]
    assert np.ptp(areas) > 40


@pytest.mark.parametrize("size", ["huge", "", 3, "Large"])
def test_a_size_that_does_not_exist_is_refused(size):
    with pytest.raises(InputError, match=f"size: {size!r}; give any or large"):
        generate("office", 1, size=size)
