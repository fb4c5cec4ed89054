"""Files are written whole or not at all, and what is wrong with one is named."""

import errno
import os
import stat
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from tutorial_lib.errors import InputError
from tutorial_lib.files import (
    atomic_path,
    atomic_paths,
    check_writable,
    load_arrays,
    make_folder,
    save_arrays,
    sweep,
    write_files,
    write_text,
)

ARRAYS = {"poses": np.arange(6.0).reshape(2, 3), "names": np.array(["a", "b"]), "one": np.array(1)}


def same(one, other):
    assert list(one) == list(other)
    for name, array in one.items():
        assert array.dtype == other[name].dtype
        assert array.shape == other[name].shape
        assert (array == other[name]).all()
    return True


@pytest.fixture
def path(tmp_path):
    return tmp_path / "some.npz"


@pytest.mark.parametrize("compressed", [False, True])
@pytest.mark.parametrize("version", [None, 1, 3])
def test_arrays_are_read_as_they_were_saved(path, compressed, version):
    save_arrays(path, ARRAYS, version=version, compressed=compressed)
    assert same(load_arrays(path, ARRAYS, version=version), ARRAYS)
    assert [file.name for file in path.parent.iterdir()] == ["some.npz"]


def test_any_program_can_read_them(path):
    save_arrays(path, ARRAYS, version=2)
    with np.load(path) as file:
        assert same(dict(file), {"version": np.array(2), **ARRAYS})


def test_compressed_arrays_are_smaller(path):
    sizes = []
    for compressed in (False, True):
        save_arrays(path, {"zeros": np.zeros(1000)}, compressed=compressed)
        sizes.append(path.stat().st_size)
    assert sizes[1] < sizes[0] / 10


def test_saving_twice_gives_the_same_bytes(path):
    save_arrays(path, ARRAYS, version=1)
    first = path.read_bytes()
    save_arrays(path, ARRAYS, version=1)
    assert path.read_bytes() == first


@pytest.mark.parametrize("compressed", [False, True])
@pytest.mark.parametrize("error", [OSError, KeyboardInterrupt])
def test_a_save_that_fails_leaves_the_old_file_and_nothing_else(
    path, monkeypatch, compressed, error
):
    save_arrays(path, ARRAYS, version=1)

    def fail(file, **_):
        file.write(b"half a file")
        raise error

    monkeypatch.setattr(np, "savez_compressed" if compressed else "savez", fail)
    with pytest.raises(error):
        save_arrays(path, {"poses": np.zeros(9)}, version=1, compressed=compressed)
    assert same(load_arrays(path, ARRAYS, version=1), ARRAYS)
    assert [file.name for file in path.parent.iterdir()] == ["some.npz"]


def refused(path, words, **options):
    with pytest.raises(InputError) as error:
        load_arrays(path, ARRAYS, advice="record it again", **options)
    assert str(error.value).startswith(f"{path}: ")
    assert str(error.value).endswith("; record it again")
    assert words in str(error.value)
    return True


def test_a_missing_file_is_named(path):
    assert refused(path, "there is no such file")
    assert refused(path.parent, "there is no such file")


@pytest.mark.parametrize("compressed", [False, True])
def test_a_truncated_file_is_refused(path, compressed):
    save_arrays(path, ARRAYS, version=1, compressed=compressed)
    whole = path.read_bytes()
    for size in [*range(0, len(whole), 13), len(whole) - 1]:
        path.write_bytes(whole[:size])
        assert refused(path, "damaged, or not an .npz file", version=1)


def test_a_byte_that_flipped_is_refused_or_harmless(path):
    save_arrays(path, ARRAYS, version=1)
    whole, count = path.read_bytes(), 0
    places = range(0, len(whole), 5)
    for place in places:
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 0x55]) + whole[place + 1 :])
        try:
            assert same(load_arrays(path, ARRAYS, version=1), ARRAYS)
        except InputError:
            assert refused(path, "some.npz: ", version=1)
            count += 1
    assert count > len(places) / 2


@pytest.mark.parametrize("content", [b"", b"hello", b"PK\x03\x04", b"\x93NUMPY", b"\x80\x04K*."])
def test_what_is_no_archive_of_arrays_is_refused(path, content):
    path.write_bytes(content)
    assert refused(path, "damaged, or not an .npz file")


def test_a_single_array_is_refused(path):
    with path.open("wb") as file:
        np.save(file, np.zeros(3))
    assert refused(path, "damaged, or not an .npz file")


@pytest.mark.parametrize("name", ["poses", "version", "extra"])
def test_an_array_of_objects_is_never_unpickled(path, name):
    np.savez(path, **{"version": np.array(1), **ARRAYS, name: np.array([{"a": 1}], dtype=object)})
    assert refused(path, "damaged, or not an .npz file", version=1)


@pytest.mark.parametrize("name", list(ARRAYS))
def test_an_array_that_is_missing_is_named(path, name):
    save_arrays(path, {key: array for key, array in ARRAYS.items() if key != name}, version=1)
    assert refused(path, f"damaged ({name!r} is missing)", version=1)


@pytest.mark.parametrize("version", [0, 2, 10])
def test_another_version_is_refused(path, version):
    save_arrays(path, ARRAYS, version=version)
    assert refused(path, f"of version {version}; this program reads version 1", version=1)


@pytest.mark.parametrize("version", [None, [1, 1], "one", 1.0, True, []])
def test_what_is_no_version_is_refused(path, version):
    stamp = {} if version is None else {"version": np.array(version)}
    np.savez(path, **stamp, **ARRAYS)
    assert refused(path, "damaged, or not a file of version 1", version=1)


def test_without_advice_there_is_none(path):
    with pytest.raises(InputError, match=r"there is no such file$"):
        load_arrays(path, ())


def test_text_is_written_whole_or_not_at_all(tmp_path, monkeypatch):
    path = tmp_path / "some.txt"
    write_text(path, "größer")
    assert path.read_text(encoding="utf-8") == "größer"
    assert stat.S_IMODE(path.stat().st_mode) == 0o644 or os.name == "nt"
    with pytest.raises(UnicodeEncodeError):
        write_text(path, "half \ud800 a text")
    assert path.read_text(encoding="utf-8") == "größer"
    assert [file.name for file in tmp_path.iterdir()] == ["some.txt"]


def test_a_temporary_path_has_the_same_suffix(path):
    with atomic_path(path) as temporary:
        assert temporary.suffix == ".npz"
        assert temporary.parent == path.parent
        assert not path.exists()
    assert path.exists()


DISK = [errno.ENOSPC, errno.EFBIG, errno.EIO, errno.EDQUOT]


def full(owner, name, monkeypatch, code, half=True):
    """Let a function fail as a full disk does, after half of what it writes."""

    def fail(path, *data):
        if half:
            with open(path, "wb") as file:
                file.write(b"half")
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(owner, name, fail)


@pytest.mark.parametrize("code", DISK)
@pytest.mark.parametrize(
    ("owner", "name", "half"), [(Path, "write_bytes", True), (os, "fsync", False)]
)
def test_a_full_disk_is_one_line_with_the_file_and_the_room(
    tmp_path, monkeypatch, owner, name, half, code
):
    path = tmp_path / "some.txt"
    write_text(path, "old")
    with monkeypatch.context() as patch:
        full(owner, name, patch, code, half)
        for act in (lambda: write_text(path, "new"), lambda: check_writable(path)):
            with pytest.raises(InputError) as error:
                act()
            said = str(error.value)
            assert said.startswith(
                f"{path}: cannot be written ({os.strerror(code)}); its disk has "
            )
            assert said.endswith(" MB free: make room there, and start again")
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_what_is_shorter_than_it_should_be_takes_no_place(tmp_path, monkeypatch):
    path = tmp_path / "some.bin"
    write_files({path: b"old"})
    whole = Path.write_bytes
    monkeypatch.setattr(Path, "write_bytes", lambda file, data: whole(file, data[:-1]))
    with pytest.raises(InputError, match=r"some\.bin: cannot be written \(not all of it"):
        write_files({path: b"newer"})
    assert path.read_bytes() == b"old"


def test_files_that_belong_together_are_written_together(tmp_path, monkeypatch):
    one, two = tmp_path / "one.txt", tmp_path / "two.bin"
    write_files({one: b"1", two: b"2"})
    settled = []

    def full_at_last(number):
        settled.append(number)
        if len(settled) == 2:
            raise OSError(errno.ENOSPC, "full")

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", full_at_last)
        with pytest.raises(InputError, match=r"one\.txt, .*two\.bin: cannot be written \(full\)"):
            write_files({one: b"3", two: b"4"})
    assert (one.read_bytes(), two.read_bytes()) == (b"1", b"2")
    with suppress(KeyError), atomic_paths(one, two) as (first, second):
        first.write_bytes(b"5")
        second.write_bytes(b"6")
        raise KeyError
    assert (one.read_bytes(), two.read_bytes()) == (b"1", b"2")
    write_files({one: b"7", two: b"8"})
    assert (one.read_bytes(), two.read_bytes()) == (b"7", b"8")
    assert len(list(tmp_path.iterdir())) == 2


def test_an_error_of_the_work_in_between_stays_what_it_is(tmp_path):
    with pytest.raises(FileNotFoundError, match="elsewhere"), atomic_path(tmp_path / "a.txt"):
        (tmp_path / "elsewhere").read_text()
    assert list(tmp_path.iterdir()) == []


def test_a_missing_folder_is_one_line(tmp_path):
    with pytest.raises(InputError, match=r"a\.txt: cannot be written .* existing folder"):
        write_text(tmp_path / "none" / "a.txt", "text")


DAY = 24 * 3600


def test_temporary_files_of_killed_runs_are_swept_after_a_day(tmp_path):
    with atomic_path(tmp_path / "flat.npz") as temporary:
        names = [
            temporary.name,
            ".demo-a_b3c4d5.tmp.webm",
            ".rows.x-abcdefgh.tmp",
            "..-12345678.tmp",
        ]
        others = [
            "flat.npz",
            ".flat-12345678.npz",
            "flat-12345678.tmp.npz",
            ".flat.tmp.npz",
            ".tmp",
        ]
        for name in (*names, *others):
            (tmp_path / name).write_text("some")
            os.utime(tmp_path / name, (0, time.time() - DAY + 60))
        (tmp_path / ".folder-12345678.tmp").mkdir()
        os.utime(tmp_path / ".folder-12345678.tmp", (0, 0))
        sweep(tmp_path)
        assert len(list(tmp_path.iterdir())) == len(names) + len(others) + 1
        for name in (*names, *others):
            os.utime(tmp_path / name, (0, time.time() - DAY - 60))
        sweep(tmp_path)
        left = {file.name for file in tmp_path.iterdir()}
        assert left == {*others, ".folder-12345678.tmp"}
        temporary.write_text("flat")
    sweep(tmp_path / "missing")


@pytest.mark.parametrize(
    "act",
    [
        lambda folder: write_text(folder / "new.txt", "text"),
        lambda folder: save_arrays(folder / "new.npz", ARRAYS),
        lambda folder: check_writable(folder / "new.txt"),
        make_folder,
    ],
)
def test_whatever_writes_to_a_folder_sweeps_it(tmp_path, act):
    left = tmp_path / ".old-12345678.tmp.pt"
    left.write_text("half")
    os.utime(left, (0, 0))
    act(tmp_path)
    assert not left.exists()


def test_what_cannot_be_written_is_refused_before(tmp_path):
    check_writable(tmp_path / "new.json")
    for path in (tmp_path, tmp_path / "none" / "new.json"):
        with pytest.raises(InputError, match="cannot be written; give a file's name"):
            check_writable(path)
