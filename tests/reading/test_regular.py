"""Only regular files of a sane size are opened, and nothing else is waited for."""

import os
import sys

import pytest

from tutorial_lib.errors import InputError
from tutorial_lib.reading.limits import MEGABYTE
from tutorial_lib.reading.regular import open_regular, read_bytes, read_text

POSIX = pytest.mark.skipif(sys.platform == "win32", reason="has no pipes and devices as files")


def refused(path, words, limit=100):
    with pytest.raises(InputError) as error:
        read_bytes(path, limit, "do this")
    message = str(error.value)
    assert message.startswith(f"{path}: ")
    assert message.endswith("; do this")
    assert words in message
    return True


def test_bytes_are_read_up_to_the_limit(tmp_path):
    path = tmp_path / "some"
    path.write_bytes(b"x" * 100)
    assert read_bytes(path, 100) == b"x" * 100
    with open_regular(path, 100) as file:
        assert file.read(3) == b"xxx"
    assert refused(path, "more than the 9.9e-05 MB", limit=99)


def test_a_link_to_a_file_is_followed(tmp_path):
    (tmp_path / "file").write_bytes(b"abc")
    (tmp_path / "link").symlink_to(tmp_path / "file")
    assert read_bytes(tmp_path / "link", 10) == b"abc"


def test_what_is_no_file_is_named(tmp_path):
    assert refused(tmp_path, "it is a folder")
    assert refused(tmp_path / "none", "there is no such file")
    (tmp_path / "file").touch()
    assert refused(tmp_path / "file" / "in", "cannot be read")
    with pytest.raises(InputError, match="cannot be read"):
        read_bytes(tmp_path / "a\0b", 10)


@POSIX
def test_pipes_devices_and_links_to_them_are_not_opened(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for name, where in (("a", tmp_path / "pipe"), ("b", "/dev/zero"), ("c", "/dev/null")):
        (tmp_path / name).symlink_to(where)
        assert refused(tmp_path / name, "no regular file but a device or a pipe")
    assert refused(tmp_path / "pipe", "no regular file but a device or a pipe")
    (tmp_path / "circle").symlink_to(tmp_path / "circle")
    assert refused(tmp_path / "circle", "cannot be read")


@POSIX
def test_a_huge_file_is_refused_unread(tmp_path):
    path = tmp_path / "huge"
    path.touch()
    os.truncate(path, 10**12)  # none of which is on the disk
    assert refused(path, "it has 1,000,000.0 MB, more than the 2 MB", limit=2 * MEGABYTE)


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="of Linux")
def test_a_file_that_says_it_is_empty_is_not_read_for_ever():
    assert refused("/proc/self/smaps", "more than", limit=50)


def test_text_is_utf_8_whatever_its_line_ends(tmp_path):
    path = tmp_path / "some.txt"
    path.write_bytes("größer\r\nals\n".encode())
    assert read_text(path) == "größer\nals\n"
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match=r"some\.txt: cannot be read \(no UTF-8 text.*; do it$"):
        read_text(path, advice="do it")
