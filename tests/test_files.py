"""Files are written whole or not at all."""

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
    make_folder,
    save_arrays,
    sweep,
    write_files,
    write_text,
)
from tutorial_lib.reading.arrays import load_arrays

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


POSIX = pytest.mark.skipif(os.name == "nt", reason="has no such rights, or links")


@POSIX
@pytest.mark.parametrize("mask", [0o022, 0o077, 0o002, 0o000, 0o027])
def test_a_new_file_gets_the_rights_that_the_umask_leaves(tmp_path, mask):
    before = os.umask(mask)
    try:
        write_text(tmp_path / "a.txt", "new")
        write_files({tmp_path / "b.bin": b"1", tmp_path / "c.bin": b"2"})
        check_writable(tmp_path / "a.txt")
    finally:
        os.umask(before)
    for name in ("a.txt", "b.bin", "c.bin"):
        assert stat.S_IMODE((tmp_path / name).stat().st_mode) == 0o666 & ~mask


@POSIX
@pytest.mark.parametrize("mode", [0o600, 0o664, 0o640, 0o444])
def test_a_file_keeps_its_rights(tmp_path, mode):
    path = tmp_path / "a.txt"
    path.write_text("old")
    path.chmod(mode)
    write_text(path, "new")
    assert path.read_text() == "new"
    assert stat.S_IMODE(path.stat().st_mode) == mode


@POSIX
def test_a_protected_file_is_refused_before_the_work(tmp_path):
    (tmp_path / "a.txt").touch(0o444)
    with pytest.raises(InputError, match=r"a\.txt: is protected"):
        check_writable(tmp_path / "a.txt")


@POSIX
def test_a_link_stays_one_and_what_it_leads_to_is_replaced(tmp_path):
    (tmp_path / "there").mkdir()
    path, target = tmp_path / "a.txt", tmp_path / "there" / "b.txt"
    (tmp_path / "between").symlink_to("there/b.txt")
    path.symlink_to("between")
    for text in ("new", "newer"):  # it leads nowhere at first
        check_writable(path)
        write_text(path, text)
        assert path.is_symlink()
        assert os.readlink(path) == "between"
        assert target.read_text() == text
        assert not target.is_symlink()
        assert [file.name for file in (tmp_path / "there").iterdir()] == ["b.txt"]


@POSIX
def test_what_leads_to_no_file_is_refused(tmp_path):
    (tmp_path / "circle").symlink_to("circle")
    (tmp_path / "folder").symlink_to(tmp_path)
    (tmp_path / "device").symlink_to(os.devnull)
    os.mkfifo(tmp_path / "pipe")
    for name in ("circle", "folder", "device", "pipe"):
        for act in (check_writable, lambda path: write_text(path, "text")):
            with pytest.raises(InputError, match=f"{name}: cannot be written; give a file's name"):
                act(tmp_path / name)
    assert (tmp_path / "circle").is_symlink()
    assert not Path(os.devnull).is_file()
