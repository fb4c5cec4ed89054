"""Files are written whole or not at all, and what is wrong with one is named."""

import os
import stat

import numpy as np
import pytest

from tutorial_lib.errors import InputError
from tutorial_lib.files import atomic_path, check_writable, load_arrays, save_arrays, write_text

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


def test_what_cannot_be_written_is_refused_before(tmp_path):
    check_writable(tmp_path / "new.json")
    for path in (tmp_path, tmp_path / "none" / "new.json"):
        with pytest.raises(InputError, match="cannot be written; give a file's name"):
            check_writable(path)
