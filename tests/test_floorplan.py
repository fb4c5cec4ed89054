import errno
import json
import os
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from conftest import make_box
from hypothesis import given, settings
from hypothesis import strategies as st

from tutorial_lib.errors import InputError
from tutorial_lib.files import atomic_path
from tutorial_lib.world.floorplan import Door, FloorPlan, Furniture, Room
from tutorial_lib.world.generators import FAMILIES, generate
from tutorial_lib.world.occupancy import check_closed
from tutorial_lib.world.plan_json import load_plan, plan_from_json, plan_to_json, save_plan

TABLE = Furniture("table", ((4.0, 4.0), (6.0, 4.0), (5.0, 5.5)), "paint")
PLAN = replace(make_box(), furniture=(TABLE,), doors=(Door((2.0, 0.0), (3.0, 0.0), (0, 0)),))
TEXT = plan_to_json(PLAN)
GONE = object()


def without(plan, walls):
    """The plan without some of its walls."""
    keep = np.setdiff1d(np.arange(len(plan.walls)), walls)
    names = tuple(plan.wall_materials[i] for i in keep)
    offsets = plan.wall_offsets[keep]
    return replace(plan, walls=plan.walls[keep], wall_materials=names, wall_offsets=offsets)


def altered(path, value):
    """The plan's JSON with one field set to something else, or gone."""
    entry = root = json.loads(TEXT)
    *way, last = path
    for key in way:
        entry = entry[key]
    if value is GONE:
        del entry[last]
    elif isinstance(entry, list) and last == len(entry):
        entry.append(value)
    else:
        entry[last] = value
    return json.dumps(root)


def paths(value, way=()):
    """The ways to all fields of a JSON document."""
    pairs = value.items() if isinstance(value, dict) else enumerate(value)
    for key, item in pairs:
        yield (*way, key)
        if isinstance(item, dict | list):
            yield from paths(item, (*way, key))


@pytest.mark.parametrize("palette", ["standard", "shifted"])
@pytest.mark.parametrize("family", FAMILIES)
def test_a_saved_plan_comes_back_byte_for_byte(family, palette, tmp_path):
    plan, file = generate(family, 31, palette), tmp_path / "plan.json"
    save_plan(plan, file)
    loaded = load_plan(file)
    assert plan_to_json(loaded) == plan_to_json(plan) == file.read_text(encoding="utf-8")
    assert (loaded.walls == plan.walls).all()
    assert (loaded.wall_offsets == plan.wall_offsets).all()
    for name in ("family", "seed", "wall_materials", "materials", "rooms", "doors", "furniture"):
        assert getattr(loaded, name) == getattr(plan, name)
    assert loaded.look == plan.look
    assert (loaded.atlas == plan.atlas).all()


def fails_midway(self, text, **_):
    with open(self, "w", encoding="utf-8") as file:
        file.write(text[: len(text) // 2])
    raise OSError(errno.ENOSPC, "No space left on device")


def fails(*_):
    raise KeyboardInterrupt


@pytest.mark.parametrize(
    ("owner", "name", "failure", "error"),
    [(Path, "write_text", fails_midway, OSError), (os, "replace", fails, KeyboardInterrupt)],
    ids=["disk full", "interrupted"],
)
@pytest.mark.parametrize("old", [None, "the old plan"])
def test_a_save_that_fails_leaves_the_folder_as_it_was(
    owner, name, failure, error, old, tmp_path, monkeypatch
):
    file = tmp_path / "plan.json"
    if old:
        file.write_text(old)
    monkeypatch.setattr(owner, name, failure)
    with pytest.raises(error):
        save_plan(PLAN, file)
    monkeypatch.undo()
    assert [f.read_text() for f in tmp_path.iterdir()] == ([old] if old else [])


def test_a_file_changes_only_when_it_is_complete(tmp_path):
    file = tmp_path / "notes.txt"
    file.write_text("old")
    with atomic_path(file) as temporary:
        temporary.write_text("new")
        assert temporary.suffix == ".txt"
        assert file.read_text() == "old"
    assert {f.name: f.read_text() for f in tmp_path.iterdir()} == {"notes.txt": "new"}


FACTS = [
    (("schema",), 2, r"schema: 2; .*schema 1"),
    (("schema",), GONE, r"has no 'schema'"),
    (("family",), 3, r"family: 3; give text"),
    (("seed",), 1.5, r"seed: 1\.5"),
    (("seed",), -1, r"seed: -1"),
    (("walls",), {}, r"walls: \{\}; give a list"),
    (("walls",), [], r"walls: .*three"),
    (("walls", 3, "from"), [0.0], r"walls\[3\]\.from: \[0\.0\]; give 2 numbers"),
    (("walls", 3, "from", 1), float("nan"), r"walls\[3\]\.from\[1\]: nan"),
    (("walls", 3, "to", 0), float("inf"), r"walls\[3\]\.to\[0\]: inf"),
    (("walls", 3, "to", 0), 10**400, r"walls\[3\]\.to\[0\]: 1000"),
    (("walls", 3, "to", 0), "4", r"walls\[3\]\.to\[0\]: '4'"),
    (("walls", 3, "to", 0), True, r"walls\[3\]\.to\[0\]: True"),
    (("walls", 1, "offset"), GONE, r"walls\[1\]: has no 'offset'"),
    (("walls", 1, "offset"), None, r"walls\[1\]\.offset: None"),
    (("walls", 2, "material"), "gold", r"walls\[2\]\.material: 'gold'"),
    (("walls", 2, "to"), [10.0, 10.0], r"walls\[2\]: has no length"),
    (("walls", 2), 7, r"walls\[2\]: 7; give a mapping"),
    (("furniture", 0, "material"), "gold", r"furniture\[0\]\.material: 'gold'"),
    (("furniture", 0, "outline"), [[0, 0], [1, 1]], r"furniture\[0\]\.outline: .*three corners"),
    (("furniture", 0, "outline", 1), [4, 4], r"furniture\[0\]\.outline: .*corner"),
    (("rooms", 0, "kind"), "spa", r"rooms\[0\]\.kind: 'spa'"),
    (("rooms", 0, "outline", 1, 0), None, r"rooms\[0\]\.outline\[1\]\[0\]: None"),
    (("rooms",), [], r"rooms: there are none"),
    (("doors", 0, "rooms"), [0, 1], r"doors\[0\]\.rooms: \(0, 1\)"),
    (("doors", 0, "rooms"), [-1, 0], r"doors\[0\]\.rooms: \(-1, 0\)"),
    (("doors", 0, "rooms"), [0], r"doors\[0\]\.rooms: \[0\]"),
    (("doors", 0, "to"), [2.1, 0.0], r"doors\[0\]: .*0\.3 m"),
    (("materials", 0, "colour"), [1, 2, 256], r"'paint': colour: \(1, 2, 256\)"),
    (("materials", 0, "colour"), [1, 2, 2.5], r"materials\[0\]\.colour\[2\]: 2\.5"),
    (("materials", 0, "stripes", 1, 2), -1, r"stripes\[1\]\.colour: \(-1,"),
    (("materials", 0, "stripes", 1, 3), 0.5, r"materials\[0\]\.stripes\[1\]\[3\]: 0\.5"),
    (("materials", 0, "stripes", 1, 1), 25.7, r"stripes\[1\]: runs from 1\.0 to 25\.7 m"),
    (("materials", 0, "stripes", 1, 1), 1.0, r"stripes\[1\]: runs from 1\.0 to 1\.0 m"),
    (("materials", 1), json.loads(TEXT)["materials"][0], r"materials: two have the same name"),
    (("look", "palette"), "sepia", r"look\.palette: 'sepia'"),
    (("look", "gamma"), 0.1, r"look: gamma 0\.1"),
    (("look", "noise"), 65, r"look: .*noise 65"),
    (("look", "floor", 0), 300, r"look\.floor: \(300,"),
    (("look",), GONE, r"has no 'look'"),
]


@pytest.mark.parametrize(("path", "value", "words"), FACTS, ids=[words for *_, words in FACTS])
def test_a_malformed_field_is_named(path, value, words, tmp_path):
    file = tmp_path / "plan.json"
    file.write_text(altered(path, value))
    with pytest.raises(InputError, match=words):
        load_plan(file)


ODDITIES = st.sampled_from([None, True, -1, 0, 0.5, 10**400, float("nan"), "", "x", [], [0], {}])


@settings(max_examples=300, deadline=None)
@given(st.sampled_from(list(paths(json.loads(TEXT)))), ODDITIES | st.just(GONE))
def test_any_one_wrong_field_is_read_or_refused_but_never_a_crash(path, value):
    try:
        plan = plan_from_json(altered(path, value))
    except InputError:
        return
    assert plan_to_json(plan_from_json(plan_to_json(plan))) == plan_to_json(plan)
    assert np.isfinite(plan.atlas).all()


@settings(max_examples=50, deadline=None)
@given(st.integers(0, len(TEXT.rstrip()) - 1))
def test_a_file_cut_off_anywhere_is_refused(length):
    with pytest.raises(InputError, match="here: is no JSON .*cut off"):
        plan_from_json(TEXT[:length], "here")


def test_files_that_cannot_be_read_are_named(tmp_path):
    (tmp_path / "binary.json").write_bytes(b"\xff\xfe\x00{")
    for name in ("absent.json", "binary.json", "."):
        with pytest.raises(InputError, match="cannot be read"):
            load_plan(tmp_path / name)


def test_a_wall_so_far_away_that_no_grid_can_hold_it_is_refused(tmp_path):
    file = tmp_path / "plan.json"
    file.write_text(altered(("walls", 0, "from", 0), 1e7))
    with pytest.raises(InputError, match="walls"):
        load_plan(file)


def test_the_open_room_is_named_and_the_loose_end_shown(tmp_path):
    left, right = make_box(), make_box()
    shifted = right.walls + [20.0, 0.0, 20.0, 0.0]
    outline = tuple((x + 20.0, y) for x, y in right.rooms[0].outline)
    two = FloorPlan(
        "two",
        0,
        np.concatenate([left.walls, shifted]),
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
def test_a_plan_without_one_of_its_walls_is_open_and_the_hint_is_near(family):
    plan = generate(family, 32)
    length = np.hypot(*(plan.walls[:, 2:] - plan.walls[:, :2]).T)
    for wall in np.random.default_rng(0).choice(np.flatnonzero(length > 0.5), 5, replace=False):
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
