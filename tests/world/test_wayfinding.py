"""Signs whose colour follows the distance along the corridors."""

import colorsys
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.stats import spearmanr

from tests.conftest import make_box
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.world.floorplan import Room
from tutorial_lib.world.generators import FAMILIES, generate
from tutorial_lib.world.generators.wayfinding import PASSABLE, PITCH, SHADES, SPAN, WIDTH, Depth
from tutorial_lib.world.materials import PERIOD
from tutorial_lib.world.occupancy import clearance_grid

cached = cache(generate)
every_family = pytest.mark.parametrize("family", FAMILIES)


def accents_of(plan, plain):
    """The stripes that a plan has and its plain twin has not, by material."""
    plain = {material.name: material for material in plain.materials}
    return {
        m.name: m.stripes[len(plain[m.name].stripes) :] for m in plan.materials if m.name in plain
    }


def hue(colour):
    return colorsys.rgb_to_hsv(*(c / 255 for c in colour))[0]


@every_family
@pytest.mark.few(2)
def test_only_colours_change(family):
    plan, plain = cached(family, 40, signs="wayfinding"), cached(family, 40)
    assert np.array_equal(plan.walls, plain.walls)
    assert np.array_equal(plan.wall_offsets, plain.wall_offsets)
    assert (plan.rooms, plan.doors, plan.furniture) == (plain.rooms, plain.doors, plain.furniture)
    old = {material.name: material for material in plain.materials}
    for material in plan.materials:
        if material.name in old:
            kept = old[material.name]
            assert material.colour == kept.colour
            assert material.stripes[: len(kept.stripes)] == kept.stripes
    assert plan.look == plain.look


@every_family
def test_accents_stand_in_a_row_on_every_wall(family):
    plan = cached(family, 40, signs="wayfinding")
    accents = accents_of(plan, cached(family, 40))
    lengths = np.linalg.norm(plan.walls[:, 2:] - plan.walls[:, :2], axis=1)
    for name in {n for n in plan.wall_materials if not n.startswith("door frame")}:
        stripes = accents[name]
        mine = [i for i, n in enumerate(plan.wall_materials) if n == name]
        if lengths[mine].sum() > PITCH:
            assert stripes
        assert all(s.end - s.start <= WIDTH + 1e-3 and s.end <= PERIOD for s in stripes)
        assert all(
            s.start % PITCH <= WIDTH + 2e-3 or s.start % PITCH > PITCH - 2e-3 for s in stripes
        )
        covered = sum(s.end - s.start for s in stripes)
        assert covered <= (WIDTH / PITCH) * lengths[mine].sum() + 2 * WIDTH * len(mine)


@pytest.mark.parametrize("family", ["apartment", "office", "hall", "loop_corridor"])
@pytest.mark.few(2)
def test_the_hue_of_an_accent_follows_the_distance_from_the_root(family):
    plan = cached(family, 41, signs="wayfinding")
    accents = accents_of(plan, cached(family, 41))
    depth = Depth(plan)
    grid = clearance_grid(plan, 0.1)
    floor = grid.centres(np.argwhere(grid.clearance >= 0.25))
    root = floor[depth.at(floor).argmin()]
    distance = GridPaths(grid).fields(root, shortest=True)
    hues, far = [], []
    rooms = [room for room in plan.rooms if room.kind in ("hallway", "open")]
    for i, name in enumerate(plan.wall_materials):
        start, end = plan.walls[i].reshape(2, 2)
        length = np.linalg.norm(end - start)
        ahead = (end - start) / length
        for stripe in accents.get(name, ()):
            along = (stripe.start + stripe.end) / 2 - plan.wall_offsets[i]
            place = start + along * ahead + 0.3 * np.array([-ahead[1], ahead[0]])
            if 0.1 < along < length - 0.1 and any(room.contains(place) for room in rooms):
                metres = distance.distance(place[None])[0]
                if np.isfinite(metres):
                    hues.append(hue(stripe.colour))
                    far.append(metres)
    assert len(hues) > 20
    # Hues may pass red, where they begin anew: compare them from the root's on.
    start = hues[int(np.argmin(far))]
    up, down = np.subtract(hues, start) % 1.0, np.subtract(start, hues) % 1.0
    best = max(spearmanr(np.where(h > 0.95, h - 1, h), far).statistic for h in (up, down))
    assert best > 0.97
    most = min(np.max(np.where(h > 0.95, h - 1, h)) for h in (up, down))
    assert most < SPAN[1] + 0.02


def test_a_room_has_the_accent_of_its_door():
    plan = cached("office", 42, signs="wayfinding")
    accents = accents_of(plan, cached("office", 42))
    private = [i for i, room in enumerate(plan.rooms) if room.kind == "bathroom"]
    assert private
    for i in private:
        names = [n for n in accents if n.rsplit(" ", 1)[-1] == str(i) and n in plan.wall_materials]
        assert len({stripe.colour for n in names for stripe in accents[n]}) == 1


def test_of_several_doors_the_one_nearest_to_the_root_counts():
    plan = cached("apartment", 41, signs="wayfinding")
    depth, several = Depth(plan), 0
    for number, room in enumerate(plan.rooms):
        doors = [door for door in plan.doors if number in door.rooms]
        if room.kind not in PASSABLE and len(doors) > 1:
            middles = np.array([np.add(door.start, door.end) / 2 for door in doors])
            inside = np.mean(room.outline, axis=0)[None]
            assert depth.by_room(inside) == depth.at(middles).min()
            several += depth.at(middles).min() < depth.at(middles).max()
    assert several


def test_the_longest_path_begins_at_an_end_though_the_search_begins_in_between():
    """A hallway shaped like a V, whose lowest point is in its middle."""
    hall = replace(make_box(12.0, 3.0), rooms=(Room("hallway", ((0, 3), (6, 0), (12, 3))),))
    ends = Depth(hall).at(np.array([[0.4, 2.7], [6.0, 0.4], [11.6, 2.7]]))
    assert sorted(ends[[0, 2]]) == pytest.approx([0.0, 0.9], abs=0.05)
    assert ends[1] == pytest.approx(0.5, abs=0.05)


def test_every_door_frame_is_one_colour_of_its_own_place():
    plan = cached("office", 42, signs="wayfinding")
    frames = [m for m in plan.materials if m.name.startswith("door frame ")]
    assert len(frames) == 2 * len(plan.doors)
    assert all(not frame.stripes for frame in frames)
    assert len({frame.colour for frame in frames}) > 0.4 * len(plan.doors)


@pytest.mark.full
def test_each_world_has_hues_of_its_own_and_the_same_seed_the_same():
    one, same = (generate("maze", 40, signs="wayfinding") for _ in range(2))
    assert one.materials == same.materials
    firsts = []
    for seed in range(40, 46):
        plan = cached("maze", seed, signs="wayfinding")
        accents = accents_of(plan, cached("maze", seed))
        firsts.append(round(hue(next(s for v in accents.values() for s in v).colour), 2))
    assert len(set(firsts)) >= 4


@pytest.mark.full
def test_hues_rise_along_some_buildings_and_fall_along_others():
    rising = []
    for seed in range(40, 48):
        plan = cached("office", seed, signs="wayfinding")
        posts = [i for i, name in enumerate(plan.wall_materials) if name.startswith("door frame ")]
        colour = {material.name: material.colour for material in plan.materials}
        depths = Depth(plan).at(plan.walls[posts].reshape(-1, 2, 2).mean(axis=1))
        order = [posts[k] for k in np.argsort(depths)]
        hues = np.array([hue(colour[plan.wall_materials[i]]) for i in order])
        steps = (np.diff(hues) + 0.5) % 1.0 - 0.5  # around the circle, the short way
        assert (steps > -0.01).all() or (steps < 0.01).all()
        rising.append(steps.sum() > 0)
    assert len(set(rising)) == 2


def test_shifted_accents_are_duller_than_any_that_are_trained_on():
    for palette, (saturation, value) in SHADES.items():
        plan = cached("apartment", 43, palette, signs="wayfinding")
        accents = accents_of(plan, cached("apartment", 43, palette))
        for stripes in accents.values():
            for stripe in stripes:
                _, s, v = colorsys.rgb_to_hsv(*(c / 255 for c in stripe.colour))
                assert s == pytest.approx(saturation, abs=0.02)
                assert v == pytest.approx(value, abs=0.02)
    assert SHADES["shifted"][0] < SHADES["standard"][0] - 0.2
