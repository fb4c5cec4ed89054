"""Freed memory stays with the process."""

import resource
import sys

import numpy as np
import pytest

from tutorial_lib.memory import keep_freed_memory


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere it does nothing")
def test_an_array_that_was_freed_is_reused_without_page_faults():
    assert keep_freed_memory()
    size = 1 << 20  # of 8 bytes: glibc would map and unmap each such array by itself
    np.ones(size)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_minflt
    for _ in range(20):
        np.ones(size)
    pages = 20 * 8 * size / resource.getpagesize()
    assert resource.getrusage(resource.RUSAGE_SELF).ru_minflt - before < 0.2 * pages


def test_elsewhere_nothing_happens(monkeypatch):
    monkeypatch.setattr(sys, "platform", "win32")
    assert not keep_freed_memory()
