import errno
import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import make_box
from tutorial_lib.errors import InputError
from tutorial_lib.files import atomic_path
from tutorial_lib.world.floorplan import Door, Furniture
from tutorial_lib.world.generators import FAMILIES, generate
from tutorial_lib.world.plan_json import load_plan, plan_from_json, plan_to_json, save_plan

TABLE = Furniture("table", ((4.0, 4.0), (6.0, 4.0), (5.0, 5.5)), "paint")
PLAN = replace(make_box(), furniture=(TABLE,), doors=(Door((2.0, 0.0), (3.0, 0.0), (0, 0)),))
TEXT = plan_to_json(PLAN)
GONE = object()


def altered(path, value):
    """The plan's JSON with one field set to something else, or gone."""
    entry = root = json.loads(TEXT)
    *parents, last = path
    for key in parents:
        entry = entry[key]
    if value is GONE:
        del entry[last]
    elif isinstance(entry, list) and last == len(entry):
        entry.append(value)
    else:
        entry[last] = value
    return json.dumps(root)


def paths(value, path=()):
    """The paths to all fields of a JSON document."""
    pairs = value.items() if isinstance(value, dict) else enumerate(value)
    for key, item in pairs:
        yield (*path, key)
        if isinstance(item, dict | list):
            yield from paths(item, (*path, key))


@pytest.mark.parametrize("palette", ["standard", "shifted"])
@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.few(2)
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


@given(st.lists(st.floats(-200, 200), min_size=20, max_size=20, unique=True))
def test_every_digit_of_every_number_comes_back(numbers):
    walls, offsets = np.add(PLAN.walls, np.reshape(numbers[:16], (4, 4)) / 99), np.array(numbers)
    plan = replace(PLAN, walls=walls, wall_offsets=offsets[16:])
    again = plan_from_json(plan_to_json(plan))
    assert again.walls.tobytes() == plan.walls.tobytes()
    assert again.wall_offsets.tobytes() == plan.wall_offsets.tobytes()


def fails_midway(self, data):
    with open(self, "wb") as file:
        file.write(data[: len(data) // 2])
    raise OSError(errno.ENOSPC, "No space left on device")


def fails(*_):
    raise KeyboardInterrupt


@pytest.mark.parametrize(
    ("owner", "name", "failure", "error"),
    [(Path, "write_bytes", fails_midway, InputError), (os, "replace", fails, KeyboardInterrupt)],
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
    (("look", "gamma"), 0.1, r"look\.gamma: 0\.1"),
    (("look", "noise"), 65, r"look\.noise: 65"),
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
    with pytest.raises(InputError, match=r"here: damaged, or not JSON .*cut off"):
        plan_from_json(TEXT[:length], "here")


def test_files_that_cannot_be_read_are_named(tmp_path):
    (tmp_path / "binary.json").write_bytes(b"\xff\xfe\x00{")
    for name in ("absent.json", "binary.json", "."):
        with pytest.raises(InputError, match=r"cannot be read|no such file"):
            load_plan(tmp_path / name)


def test_a_wall_so_far_away_that_no_grid_can_hold_it_is_refused(tmp_path):
    file = tmp_path / "plan.json"
    file.write_text(altered(("walls", 0, "from", 0), 1e7))
    with pytest.raises(InputError, match="walls"):
        load_plan(file)
