import subprocess
import sys
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tutorial_lib.driving.data.trajectories import (
    Trajectory,
    load_trajectories,
    save_trajectories,
)
from tutorial_lib.errors import InputError

ARRAYS = [field.name for field in fields(Trajectory)][2:]


def make(length, seed=0, beams=6, world="maze/2/standard"):
    rng = np.random.default_rng(seed)
    return Trajectory(
        world,
        seed,
        rng.normal(size=(length, 3)),
        rng.normal(size=(length, 3)),
        rng.uniform(0, 10, (length, beams)).astype(np.float32),
        rng.normal(size=length),
        rng.normal(size=length),
        rng.normal(size=(length, 2)),
        np.arange(length) * 0.1,
    )


def same(one, two):
    assert (one.world, one.seed) == (two.world, two.seed)
    for name in ARRAYS:
        mine, theirs = getattr(one, name), getattr(two, name)
        assert mine.dtype == theirs.dtype
        assert mine.shape == theirs.shape
        assert mine.tobytes() == theirs.tobytes()


@given(st.lists(st.integers(1, 40), max_size=5), st.integers(1, 8))
def test_what_is_saved_is_loaded(tmp_path_factory, lengths, beams):
    path = tmp_path_factory.mktemp("saved") / "some.npz"
    some = [make(n, seed, beams, f"maze/{seed}/standard") for seed, n in enumerate(lengths)]
    save_trajectories(path, some)
    loaded = load_trajectories(path)
    assert len(loaded) == len(some)
    for one, two in zip(some, loaded, strict=True):
        same(one, two)


def test_saving_twice_gives_the_same_bytes(tmp_path):
    for name in ("one.npz", "two.npz"):
        save_trajectories(tmp_path / name, [make(5), make(9, 1)])
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "two.npz").read_bytes()


def test_the_file_has_exactly_the_name_it_was_given(tmp_path):
    save_trajectories(tmp_path / "plain", [make(3)])
    assert [file.name for file in tmp_path.iterdir()] == ["plain"]
    assert len(load_trajectories(tmp_path / "plain")) == 1


def test_different_lasers_do_not_mix(tmp_path):
    with pytest.raises(InputError, match="beams"):
        save_trajectories(tmp_path / "a.npz", [make(3), make(3, beams=7)])
    assert list(tmp_path.iterdir()) == []


def test_arc_length_counts_reversing_too():
    poses = np.array([[0, 0, 0], [3, 4, 1], [0, 0, 2.0], [0, 0, 3]])
    assert replace(make(4), poses=poses).arc_length.tolist() == [0, 5, 10, 10]
    assert make(1).arc_length.tolist() == [0]


@pytest.mark.parametrize(("metres", "first"), [(0, 0), (4.9, 1), (5.0, 1), (5.1, 2), (10.0, 2)])
def test_the_rest_of_a_trajectory_begins_where_so_much_was_driven(metres, first):
    poses = np.array([[0, 0, 0], [3, 4, 1], [0, 0, 2.0], [0, 0, 3]])
    whole = replace(make(4), poses=poses)
    same(whole.since(metres), replace(whole, **{n: getattr(whole, n)[first:] for n in ARRAYS}))


@pytest.mark.parametrize("metres", [-0.1, 10.1, np.nan])
def test_there_is_no_rest_of_a_trajectory_that_is_too_short(metres):
    poses = np.array([[0, 0, 0], [3, 4, 1], [0, 0, 2.0], [0, 0, 3]])
    with pytest.raises(InputError, match=r"metres: .*give one real number from 0 to 10"):
        replace(make(4), poses=poses).since(metres)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"poses": np.zeros((5, 2))}, r"poses: shape \(5, 2\) where \(T, 3\)"),
        ({"laser": np.zeros(5, np.float32)}, r"laser: shape \(5,\) where \(T, B\)"),
        ({"laser": np.zeros((5, 6))}, "laser: type float64"),
        ({"speed": np.zeros(4)}, "speed: 4 rows where poses has 5"),
        ({"steering": np.full(5, np.nan)}, "steering: .* not finite"),
        ({"actions": np.full((5, 2), np.inf)}, "actions: .* not finite"),
        ({"timestamps": np.zeros(5)}, "timestamps: not increasing"),
    ],
)
def test_a_trajectory_is_sound(change, words):
    with pytest.raises(InputError, match=words):
        replace(make(5), **change)


def test_a_trajectory_has_a_frame():
    with pytest.raises(InputError, match="without a frame"):
        make(0)


# What a file may have wrong. None means that the array is missing.
FAULTS = [
    ({"version": np.array(2)}, "version 1"),
    ({"version": None}, "version 1"),
    ({"version": np.array([1, 1])}, "version 1"),
    ({"version": np.array("one")}, "version 1"),
    ({"laser": None}, "'laser' is missing"),
    ({"offsets": None}, "'offsets' is missing"),
    ({"offsets": np.array([0, 5])}, "offsets"),
    ({"offsets": np.array([0, 5, 15])}, "offsets"),
    ({"offsets": np.array([1, 5, 14])}, "offsets"),
    ({"offsets": np.array([0, 14, 14])}, "offsets"),
    ({"offsets": np.array([0, 20, 14])}, "offsets"),
    ({"offsets": np.array([0.0, 5.0, 14.0])}, "offsets"),
    ({"offsets": np.array(14)}, "offsets"),
    ({"offsets": np.zeros(0, int)}, "offsets"),
    ({"world": np.array(["a"])}, "world"),
    ({"world": np.array([1, 2])}, "world"),
    ({"seed": np.array([0.0, 1.0])}, "seed"),
    ({"seed": np.array([0])}, "seed"),
    ({"poses": np.full((14, 3), np.nan)}, "poses: .* not finite"),
    ({"poses": np.zeros((14, 3), int)}, "poses: type int64"),
    ({"poses": np.array(0.0)}, "offsets|poses"),
    ({"speed": np.zeros(13)}, "speed: 13 rows"),
    ({"odometry": np.zeros((14, 3), complex)}, "odometry: type complex"),
    ({"actions": np.zeros((14, 2, 1))}, "actions: shape"),
    ({"timestamps": np.arange(14.0)[::-1].copy()}, "timestamps"),
]


@pytest.mark.parametrize(("change", "words"), FAULTS)
def test_a_file_with_a_fault_is_refused(tmp_path, change, words):
    path = tmp_path / "some.npz"
    save_trajectories(path, [make(5), make(9, 1)])
    with np.load(path) as file:
        arrays = {**file, **change}
    np.savez(path, **{name: array for name, array in arrays.items() if array is not None})
    with pytest.raises(InputError, match=words) as caught:
        load_trajectories(path)
    assert "some.npz" in str(caught.value)
    assert "record it again" in str(caught.value)


def test_a_file_cut_off_anywhere_is_refused(tmp_path):
    path = tmp_path / "some.npz"
    save_trajectories(path, [make(5), make(9, 1)])
    whole = path.read_bytes()
    for size in [*range(0, len(whole), 7), len(whole) - 1]:
        path.write_bytes(whole[:size])
        with pytest.raises(InputError, match=r"some\.npz"):
            load_trajectories(path)


@pytest.mark.full
def test_a_flipped_byte_is_reported_or_harmless(tmp_path):
    path = tmp_path / "some.npz"
    some = [make(5), make(9, 1)]
    save_trajectories(path, some)
    whole = path.read_bytes()
    refused = 0
    for place in range(0, len(whole), 3):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 0x55]) + whole[place + 1 :])
        try:
            loaded = load_trajectories(path)
        except InputError:
            refused += 1
            continue
        for one, two in zip(some, loaded, strict=True):
            same(one, two)
    assert refused > len(whole) / 3 / 2


@pytest.mark.parametrize("content", [b"", b"hello", b"PK\x03\x04", b"\x93NUMPY"])
def test_what_is_no_file_of_ours_is_refused(tmp_path, content):
    (tmp_path / "some.npz").write_bytes(content)
    with pytest.raises(InputError, match="damaged, or not"):
        load_trajectories(tmp_path / "some.npz")


def test_an_array_of_objects_is_never_unpickled(tmp_path):
    path = tmp_path / "some.npz"
    np.savez(path, version=np.array(1), world=np.array([{"a": 1}], dtype=object))
    with pytest.raises(InputError, match="damaged, or not"):
        load_trajectories(path)
    np.save(tmp_path / "one.npy", np.zeros(3))
    with pytest.raises(InputError, match="damaged, or not"):
        load_trajectories(tmp_path / "one.npy")


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(InputError, match="no such file"):
        load_trajectories(tmp_path / "none.npz")
    with pytest.raises(InputError, match=r"it is a folder.*; delete the file and record it again"):
        load_trajectories(tmp_path)


KILLED = """
import sys, numpy as np
sys.path.insert(0, {tests!r})
from tests.driving.data.test_trajectories import make
from tutorial_lib.driving.data import trajectories
def stuck(file, **arrays):
    file.write(b"half a file")
    file.flush()
    print("writing", flush=True)
    import time; time.sleep(60)
trajectories.np.savez = stuck
trajectories.save_trajectories({path!r}, [make(50)])
"""


def test_a_save_that_is_killed_leaves_the_old_file(tmp_path):
    path = tmp_path / "some.npz"
    save_trajectories(path, [make(5)])
    before = path.read_bytes()
    tests = str(Path(__file__).parents[3])
    script = KILLED.format(tests=tests, path=str(path))
    process = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE)
    assert process.stdout.readline() == b"writing\n"
    process.kill()
    process.wait()
    process.stdout.close()
    assert path.read_bytes() == before
    assert len(load_trajectories(path)) == 1


def test_a_save_that_fails_leaves_the_old_file_and_nothing_else(tmp_path, monkeypatch):
    path = tmp_path / "some.npz"
    save_trajectories(path, [make(5)])
    before = path.read_bytes()

    def full(file, **arrays):
        file.write(b"half a file")
        raise MemoryError("no room left")

    monkeypatch.setattr(np, "savez", full)
    with pytest.raises(MemoryError, match="no room"):
        save_trajectories(path, [make(50)])
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]
