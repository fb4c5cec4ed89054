"""One map that several processes save while others read it."""

import multiprocessing
import sys
import time
from collections import Counter

import pytest

from tests.made_up_maps import Streets
from tests.topology.mapping.test_storage import grown, same
from tutorial_lib.topology.mapping.storage import load_map, save_map

WRITERS, READERS = 3, 5


def keep_saving(path, number, until, counts):
    """Save one and the same map, again and again."""
    topomap, saved = grown(1 + number), 0
    while time.monotonic() < until:
        save_map(path, topomap)
        saved += 1
    counts.put(("saved", number, saved))


def keep_reading(path, number, until, counts):
    """Read whatever is there; each must be one of the maps, in everything."""
    whole = {len(topomap): (n, topomap) for n, topomap in enumerate(map(grown, (1, 2, 3)))}
    found = Counter()
    while time.monotonic() < until:
        topomap = load_map(path, Streets())
        n, saved = whole[len(topomap)]
        assert same(topomap, saved)
        found[n] += 1
    counts.put(("read", number, dict(found)))


@pytest.mark.skipif(sys.platform == "win32", reason="nothing is forked there")
@pytest.mark.parametrize("seconds", [3, pytest.param(60, marks=pytest.mark.full)])
@pytest.mark.full
def test_every_read_is_a_whole_map_whoever_saves_it(tmp_path, seconds):
    path = tmp_path / "flat.npz"
    save_map(path, grown(1))
    fork = multiprocessing.get_context("fork")
    counts, until = fork.Queue(), time.monotonic() + seconds
    works = [(keep_saving, n) for n in range(WRITERS)] + [(keep_reading, n) for n in range(READERS)]
    processes = [
        fork.Process(target=work, args=(path, n, until, counts), daemon=True) for work, n in works
    ]
    for process in processes:
        process.start()
    said = [counts.get(timeout=60 + 3 * seconds) for _ in processes]
    for process in processes:
        process.join(60)
    assert [process.exitcode for process in processes] == [0] * len(processes)
    saves = [count for what, _, count in said if what == "saved"]
    reads = sum((Counter(count) for what, _, count in said if what == "read"), Counter())
    print(f"{sum(saves)} saves and {reads.total()} reads in {seconds} s, each read a whole map")
    assert min(saves) > 0
    assert set(reads) == set(range(WRITERS))
    assert list(tmp_path.iterdir()) == [path]
