"""Files are written whole or not at all."""

import os
import stat

import numpy as np
import pytest

from tutorial_lib.errors import InputError
from tutorial_lib.files import atomic_path, check_writable, save_arrays, write_text
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


def test_what_cannot_be_written_is_refused_before(tmp_path):
    check_writable(tmp_path / "new.json")
    for path in (tmp_path, tmp_path / "none" / "new.json"):
        with pytest.raises(InputError, match="cannot be written; give a file's name"):
            check_writable(path)
