"""A disk may be full at any moment: one line says so, and what was whole stays so.

A process of its own mounts a small disk in memory that only it sees (Linux; no rights needed where
users may make namespaces), works until it is full, makes room, and works again.
"""

import ctypes
import os
import sys
from functools import cache

import pytest

from tests.jobs import JOBS, check_whole, forks, quietly, temporaries

SIZE = 16 << 20
"""Bytes of the disk."""
NEW_USER, NEW_MOUNTS = 0x10000000, 0x00020000  # of unshare(2)
PATIENCE = 900.0
FREE = {
    "train": (0, 30_000, 1 << 20, 3 << 20),
    "demo": (0, 70_000, 150_000, 400_000),
    "experiment": (0, 100, 4_000),
    "build": (0, 4_000, 30_000, 100_000),
    "save": (0, 100, 3_000, 4_200, 9_000),
}
"""Bytes left on the disk, twenty times."""


def own_disk(folder):
    """Mount a disk on a folder that only this process sees."""
    libc, user, group = ctypes.CDLL(None, use_errno=True), os.getuid(), os.getgid()
    if libc.unshare(NEW_USER | NEW_MOUNTS):
        raise OSError(ctypes.get_errno(), "unshare")
    maps = ("setgroups", "deny"), ("uid_map", f"0 {user} 1"), ("gid_map", f"0 {group} 1")
    for name, text in maps:
        with open(f"/proc/self/{name}", "w") as file:
            file.write(text)
    options = f"size={SIZE}".encode()
    if libc.mount(b"tmpfs", os.fsencode(folder), b"tmpfs", 0, options):
        raise OSError(ctypes.get_errno(), "mount")


def fill(path, free):
    """Fill a disk but for some bytes, as far as pages allow."""
    found = os.statvfs(path.parent)
    room = found.f_bavail * found.f_frsize
    with path.open("wb") as file:
        file.write(bytes(max(room - free, 0)))


def contents(folder):
    """Bytes by name."""
    return {p.name: p.read_bytes() for p in folder.rglob("*") if p.is_file() and p.name != "filler"}


def try_disk(folder, answers):
    """Say whether such a disk can be had."""
    try:
        own_disk(folder)
        answers.put("")
    except OSError as error:
        answers.put(str(error))


def on_full_disk(name, folder, free, answers):
    """Do a job, then on a full disk again, then with room again; what is left each time."""
    own_disk(folder)
    assert quietly(name, folder)[0] == 0
    before = contents(folder)
    if name == "train" and free < 1 << 20:
        for path in (folder / "work").rglob("*.npz"):
            path.unlink()  # so that it records again
    fill(folder / "filler", free)
    code, said = quietly(name, folder)
    (folder / "filler").rename(folder / ".filler.tmp")
    whole, left = check_whole(folder), len(temporaries(folder)) - 1
    (folder / ".filler.tmp").unlink()
    after = contents(folder)
    changed = [key for key, data in before.items() if after.get(key, b"") != data]
    again = quietly(name, folder)[0]
    answers.put((code, said, whole, left, changed, again, check_whole(folder)))


@cache
def hindrance(folder):
    """Why no disk can be had here; empty if one can."""
    if not sys.platform.startswith("linux"):
        return "Linux only"
    context = forks()
    answers = context.Queue()
    process = context.Process(target=try_disk, args=(folder, answers))
    process.start()
    return answers.get(timeout=PATIENCE)


@pytest.mark.full
@pytest.mark.parametrize(("name", "free"), [(name, free) for name in JOBS for free in FREE[name]])
def test_a_full_disk_leaves_what_was_whole(name, free, tmp_path):
    if reason := hindrance(tmp_path):
        pytest.skip(f"no disk of its own: {reason}")
    context = forks()
    answers = context.Queue()
    process = context.Process(target=on_full_disk, args=(name, tmp_path, free, answers))
    process.start()
    process.join(PATIENCE)
    code, said, whole, left, changed, again, at_last = answers.get(timeout=10)
    last = said.replace("\r", "\n").splitlines()[-1:]
    print(f"{name}, {free} bytes free: code {code}, changed {changed}, {last}")
    assert code in (0, 2)
    assert left == 0
    if code:
        assert last[0].startswith("error: ")
        assert "MB free" in last[0] or "disk space" in last[0]
        results = (".webm", ".png", ".json", ".ipynb", ".safetensors")
        assert name == "build" or not [key for key in changed if key.endswith(results)]
    assert again == 0
    gone = set(whole) - set(at_last)
    assert all(file.endswith(".pt") for file in gone)  # a checkpoint, when training is over
