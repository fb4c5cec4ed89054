"""What the process of an answer may take and reach."""

from __future__ import annotations

import ctypes
import os
import signal
import struct
import sys
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from tutorial_lib.checks.framework import guard

with suppress(ImportError):
    import resource  # not on Windows

PROCESSOR = int(guard.SECONDS) + 1
"""Seconds of the processor's time that an answer may take, its file's first line included."""
DISK = 16_000_000
"""Bytes of a file, and where the files of an answer lie in memory of all of them."""
PROCESSES = 16
"""Processes and threads beside those that its user has."""
_DEVICES = ("null", "zero", "full", "random", "urandom")
_IMPORTED = {
    Path(p).resolve() for p in (sys.base_prefix, sys.prefix, *sys.path) if os.path.isdir(p)
}
_NEEDED = sorted(path for path in _IMPORTED if not _IMPORTED.intersection(path.parents))
"""Folders from which an answer imports."""
_NEW_MOUNTS, _NEW_IPC, _NEW_USER, _NEW_PROCESSES, _NEW_NETWORK = (
    0x00020000, 0x08000000, 0x10000000, 0x20000000, 0x40000000,
)  # fmt: skip
_READ_ONLY, _NO_SUID, _NO_DEVICES, _DETACH = 1, 2, 4, 2
_BIND, _RECURSIVE, _PRIVATE = 1 << 12, 1 << 14, 1 << 18
_MOUNT_SETATTR, _CAPSET, _RECURSIVELY, _HERE = 442, {"x86_64": 126, "aarch64": 91}, 0x8000, -100
_PARENT_DEATH, _SUBREAPER, _NO_NEW_PRIVILEGES = 1, 36, 38


def limit_process() -> None:
    """Limit this process from now on; what it starts has the same limits, each for itself."""
    guard.limit_memory()
    if "resource" not in globals():
        return
    limits = {"CPU": PROCESSOR, "FSIZE": DISK, "CORE": 0}
    if sys.platform == "linux":
        limits["AS"] = resource.getrlimit(resource.RLIMIT_AS)[0]
        limits["NPROC"] = _threads_of_user() + PROCESSES
    for name, limit in limits.items():
        _at_most(getattr(resource, f"RLIMIT_{name}"), limit)


def _at_most(which: int, limit: int) -> None:
    hard = resource.getrlimit(which)[1]
    limit = limit if hard == resource.RLIM_INFINITY else min(limit, hard)
    with suppress(OSError, ValueError):
        resource.setrlimit(which, (limit, limit))


def _threads_of_user() -> int:
    """Threads of this process's user, which all count."""
    user, count = os.getuid(), 0
    for status in Path("/proc").glob("[0-9]*/status"):
        with suppress(OSError, ValueError):
            lines = dict(line.split(":", 1) for line in status.read_text().splitlines())
            count += int(lines["Threads"]) * (int(lines["Uid"].split()[0]) == user)
    return count


class Isolation:
    """Namespaces of Linux: no network, nothing to write but a folder in memory, no other process.

    Attributes:
        missing: what this system does not allow, in words; empty if nothing.
    """

    def __init__(self, folder: Path, hidden: Iterable[Path]) -> None:
        """Enter them, so far as the system allows it.

        Args:
            folder: stays writable; what it held is covered.
            hidden: folders that answers have no business with; they look empty.
        """
        self.entered, self.missing, self._root = False, "", os.getuid() == 0
        try:
            self._enter(folder, hidden)
        except OSError as error:
            words = f"this system gives answers no network and files of their own ({error})"
            self.missing = f"{words}: they can reach the network and write files"
        self.entered = not self.missing

    def _enter(self, folder: Path, hidden: Iterable[Path]) -> None:
        user, group = os.getuid(), os.getgid()
        _unshare(_NEW_MOUNTS | _NEW_IPC | _NEW_NETWORK | (0 if self._root else _NEW_USER))
        if not self._root:
            Path("/proc/self/setgroups").write_text("deny")
            Path("/proc/self/uid_map").write_text(f"{user} {user} 1")
            Path("/proc/self/gid_map").write_text(f"{group} {group} 1")
        _mount("none", "/", "", _RECURSIVE | _PRIVATE)
        for place in hidden:
            _mount("none", place, "tmpfs", _READ_ONLY)
        for place in _closed(_NEEDED) if self._root else ():
            _keep_only([path for path in _NEEDED if place in path.parents], place, folder)
        _keep_only([Path("/dev", name) for name in _DEVICES], Path("/dev"), folder)
        attributes = struct.pack("QQQQ", _READ_ONLY, 0, 0, 0)
        _call(_libc().syscall, _MOUNT_SETATTR, _HERE, b"/", _RECURSIVELY, attributes, 32)
        _mount("none", folder, "tmpfs", _NO_SUID | _NO_DEVICES, f"size={DISK},mode=755")

    def separate(self) -> None:
        """Give the next child of this process a namespace of processes: all end with it."""
        if self.entered:
            with suppress(OSError):
                _unshare(_NEW_PROCESSES)

    def close(self, number: int) -> None:
        """In that child: give up all rights but those of an ordinary user, of this number."""
        if self.entered and os.getpid() == 1:
            with suppress(OSError):  # not within a container: /proc then names all processes
                _unshare(_NEW_MOUNTS)  # the warden still has to see them
                _mount("proc", Path("/proc"), "proc", _READ_ONLY | _NO_SUID | _NO_DEVICES)
        if self._root and self.entered:
            os.setgroups([])
            os.setresgid(number, number, number)
            os.setresuid(number, number, number)
        elif self.entered and os.uname().machine in _CAPSET:
            header, none = struct.pack("Ii", 0x20080522, 0), bytes(24)
            _call(_libc().syscall, _CAPSET[os.uname().machine], header, none)
        prctl(_NO_NEW_PRIVILEGES, 1)


def _closed(paths: Iterable[Path]) -> list[Path]:
    """The outermost folders on the way to `paths` that only their owner may enter."""
    found: dict[Path, None] = {}
    for path in paths:
        ways = [place for place in reversed(path.parents) if not place.stat().st_mode & 0o001]
        found |= dict.fromkeys(ways[:1])
    return list(found)


def _keep_only(paths: Iterable[Path], place: Path, folder: Path) -> None:
    """Hide all that lies in a folder but some of it, with the help of an empty folder."""
    _mount("none", folder, "tmpfs", 0)
    held = {folder / str(number): path for number, path in enumerate(paths) if path.exists()}
    for hold, path in held.items():
        hold.mkdir() if path.is_dir() else hold.touch()
        _mount(str(path), hold, "", _BIND | _RECURSIVE)
    _mount("none", place, "tmpfs", 0, "mode=755")
    for hold, path in held.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.mkdir() if hold.is_dir() else path.touch()
        _mount(str(hold), path, "", _BIND | _RECURSIVE)
    _call(_libc().umount2, os.fsencode(folder), _DETACH)


def adopt() -> None:
    """Be the parent of all that children of this process leave behind."""
    prctl(_SUBREAPER, 1)


def end_with_parent() -> None:
    """Be killed when the parent ends."""
    prctl(_PARENT_DEATH, signal.SIGKILL)


def prctl(option: int, value: int) -> None:
    """Set an attribute of this process; Linux only."""
    _libc().prctl(option, value, 0, 0, 0)


def _unshare(flags: int) -> None:
    _call(_libc().unshare, flags)


def _mount(source: str, target: Path | str, kind: str, flags: int, data: str = "") -> None:
    words = (os.fsencode(source), os.fsencode(target), kind.encode())
    _call(_libc().mount, *words, ctypes.c_ulong(flags), data.encode())


def _libc() -> ctypes.CDLL:
    return ctypes.CDLL(None, use_errno=True)


def _call(function: ctypes._FuncPointer, *arguments: object) -> None:
    if function(*arguments) < 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
