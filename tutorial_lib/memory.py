"""Freed memory stays with the process, which makes networks faster.

By default glibc returns every large array to the system at once, and the system then has to clear
the pages of the next one: half of the time that comparing images took.
"""

import ctypes
import sys

_TRIM_THRESHOLD, _MMAP_THRESHOLD = -1, -3  # parameters of mallopt(3)
_LARGEST = 1 << 25  # bytes of an array that is kept; glibc allows no more
_KEPT = 1 << 28  # bytes


def keep_freed_memory() -> bool:
    """Let this process reuse what it freed; returns whether its C library can (glibc)."""
    if not sys.platform.startswith("linux"):
        return False
    library = ctypes.CDLL(None)
    if not hasattr(library, "gnu_get_libc_version"):
        return False
    settings = ((_MMAP_THRESHOLD, _LARGEST), (_TRIM_THRESHOLD, _KEPT))
    return all(library.mallopt(*setting) == 1 for setting in settings)
