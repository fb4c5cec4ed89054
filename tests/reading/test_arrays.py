"""Arrays on disk: what is wrong with a file is named, and none is larger than it may be."""

import io
import zipfile

import numpy as np
import pytest

from tests.test_files import ARRAYS, same
from tutorial_lib.errors import InputError
from tutorial_lib.files import save_arrays
from tutorial_lib.reading.arrays import load_arrays
from tutorial_lib.reading.limits import MAX_ARRAYS, MAX_MEMBERS


@pytest.fixture
def path(tmp_path):
    return tmp_path / "some.npz"


def refused(path, words, **options):
    with pytest.raises(InputError) as error:
        load_arrays(path, ARRAYS, advice="record it again", **options)
    assert str(error.value).startswith(f"{path}: ")
    assert str(error.value).endswith("; record it again")
    assert words in str(error.value)
    return True


def test_a_missing_file_is_named(path):
    assert refused(path, "there is no such file")
    assert refused(path.parent, "cannot be read (it is a folder)")


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


# Sizes.


def archive(*members, size=None):
    """An `.npz` file of members (name, shape, bytes); `size` is what its table says of each."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as file:
        for name, shape, data in members:
            head = io.BytesIO()
            form = {"descr": "<f8", "fortran_order": False, "shape": shape}
            np.lib.format.write_array_header_1_0(head, form)
            file.writestr(f"{name}.npy", head.getvalue() + data)
        for member in file.infolist():
            member.file_size = member.file_size if size is None else size
    return out.getvalue()


def test_an_archive_made_by_hand_is_read(path):
    path.write_bytes(archive(("poses", (2,), np.arange(2.0).tobytes())))
    assert same(load_arrays(path, ["poses"]), {"poses": np.arange(2.0)})


@pytest.mark.parametrize("shape", [(1,), (3,), (10**15,), (2, 2), (2**62, 4), (0,), ()])
def test_an_array_that_is_not_as_large_as_its_header_says_is_refused(path, shape):
    path.write_bytes(archive(("poses", shape, bytes(16))))
    assert refused(path, "damaged, or not an .npz file")


def test_what_is_too_large_unpacked_is_refused_before_it_is_unpacked(path, monkeypatch):
    members = ("poses", (2,), bytes(16)), ("more", (2,), bytes(16))
    path.write_bytes(archive(*members, size=300 * 10**6))
    monkeypatch.setattr(zipfile.ZipFile, "open", None)
    assert refused(path, "its arrays would have 600 MB, more than the 512 MB that they may have")
    assert MAX_ARRAYS == 512 * 10**6


def test_an_archive_of_too_many_arrays_is_not_listed(path, monkeypatch):
    members = [(str(number), (0,), b"") for number in range(MAX_MEMBERS + 1)]
    path.write_bytes(archive(*members))
    monkeypatch.setattr(zipfile, "ZipFile", None)
    assert refused(path, f"{MAX_MEMBERS + 1} arrays, more than the {MAX_MEMBERS}")


def test_two_arrays_of_one_name_are_refused(path):
    with pytest.warns(UserWarning, match="Duplicate name"):
        data = archive(("poses", (1,), bytes(8)), ("poses", (1,), bytes(8)))
    path.write_bytes(data)
    assert refused(path, "two arrays of one name")


@pytest.mark.parametrize("method", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA, 9, 93, 99])
def test_arrays_that_can_be_unpacked_without_bound_are_refused_before(path, monkeypatch, method):
    data = bytearray(archive(("poses", (2,), bytes(16))))
    for mark, place in ((b"PK\x03\x04", 8), (b"PK\x01\x02", 10)):
        start = data.index(mark) + place
        data[start : start + 2] = method.to_bytes(2, "little")
    path.write_bytes(data)
    monkeypatch.setattr(zipfile.ZipFile, "open", None)
    assert refused(path, f"'poses.npy' is compressed by method {method}; only stored and deflated")
