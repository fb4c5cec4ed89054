"""Scanned worlds: like maps that robots recorded, and as good to drive in as the others."""

from dataclasses import replace
from functools import cache

import cv2
import numpy as np
import pytest

from tutorial_lib.world.generators import generate, scanned
from tutorial_lib.world.generators.rectilinear import DoesNotFit
from tutorial_lib.world.occupancy import check_closed, clearance_grid
from tutorial_lib.world.plan_json import plan_from_json, plan_to_json

SEEDS = range(40, 46)
cached = cache(generate)
every_seed = pytest.mark.parametrize("seed", SEEDS)


def free_share_of_largest(plan):
    """The share of the floor on which the car fits that hangs together."""
    grid = clearance_grid(plan)
    fits = (grid.clearance >= 0.15).astype(np.uint8)
    _, _, stats, _ = cv2.connectedComponentsWithStats(fits, connectivity=4)
    return stats[1:, cv2.CC_STAT_AREA].max() / fits.sum()


@every_seed
@pytest.mark.few(2)
def test_most_of_the_floor_hangs_together(seed):
    plan = cached("scanned", seed)
    check_closed(plan)
    assert free_share_of_largest(plan) > 0.75
    assert {room.kind for room in plan.rooms} == {"open"}
    assert (plan.family, plan.seed) == ("scanned", seed)


@every_seed
def test_walls_are_ragged(seed):
    walls = cached("scanned", seed).walls
    length = np.linalg.norm(walls[:, 2:] - walls[:, :2], axis=1)
    assert np.median(length) < 0.5
    assert length.max() > 0.1


def test_buildings_lie_at_angles():
    walls = [cached("scanned", seed).walls.reshape(-1, 2).astype(np.float32) for seed in SEEDS]
    angles = [cv2.minAreaRect(ends)[2] % 90 for ends in walls]
    assert sum(2 < angle < 88 for angle in angles) >= 4


def test_a_scan_that_falls_apart_is_drawn_again():
    plan = generate("hall", 41)
    halves = replace(plan, walls=np.concatenate([plan.walls, _across(plan)]), **_more(plan))
    with pytest.raises(DoesNotFit):
        scanned(halves, ("scanned", 40), np.random.default_rng(0), "standard")


def _across(plan):
    """A wall through the middle of a plan, along y."""
    ends = plan.walls.reshape(-1, 2)
    (x0, y0), (x1, y1) = ends.min(axis=0), ends.max(axis=0)
    middle = (x0 + x1) / 2 + 0.07
    return np.array([[middle, y0, middle, y1]])


def _more(plan):
    """Material and offset of one more wall."""
    return {
        "wall_materials": (*plan.wall_materials, plan.wall_materials[0]),
        "wall_offsets": np.append(plan.wall_offsets, 0.0),
    }


def test_resolutions_angles_and_buildings_differ():
    plans = [cached("scanned", seed) for seed in SEEDS]
    assert len({len(plan.walls) for plan in plans}) == len(plans)
    areas = [plan.area for plan in plans]
    assert max(areas) > 1.5 * min(areas)


def test_same_seed_same_bytes_and_a_round_trip():
    text = plan_to_json(generate("scanned", 41))
    assert text == plan_to_json(cached("scanned", 41))
    assert plan_to_json(plan_from_json(text)) == text


def test_the_shifted_palette_changes_only_the_look():
    plain, shifted = cached("scanned", 42), generate("scanned", 42, palette="shifted")
    assert np.array_equal(plain.walls, shifted.walls)
    assert plain.rooms == shifted.rooms
    assert shifted.look.palette == "shifted"
    assert 6.0 <= shifted.look.noise <= 12.0
