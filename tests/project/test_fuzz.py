"""Every loader, with thousands of files as nobody would write them: see `python -m tests.fuzz`."""

import os
from collections import Counter
from pathlib import Path

import numpy as np
import pytest

from tests.fuzz import __main__ as command
from tests.fuzz.outcome import ALTERED, BAD, FOREIGN, HANG, LOADED, MEMORY, REFUSED, WRONG, Target
from tests.fuzz.worker import outcomes
from tutorial_lib.errors import InputError

linux = pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="limits are Linux's")


def check(seed, cases):
    """Run cases and return how often what came of them, by loader."""
    print(f"seed {seed}")
    found = list(outcomes(seed, cases))
    print(command.tally(found))
    wrong = [one for one in found if one.verdict in BAD]
    assert not wrong, "\n".join(map(str, wrong[:20]))
    assert len(found) == cases
    return Counter((one.target, one.verdict) for one in found), {one.target for one in found}


@linux
def test_hundreds_of_files_are_loaded_as_they_were_saved_or_refused():
    count, names = check(seed=0, cases=170)
    assert len(names) == 22
    for name in names:
        assert count[name, LOADED] >= 1
        assert count[name, REFUSED] >= 1


@linux
@pytest.mark.full
def test_twenty_thousand_files_are_loaded_as_they_were_saved_or_refused():
    check(seed=int.from_bytes(os.urandom(3), "big"), cases=20_000)


# Whether it would be noticed. This module is also one of loaders.


class AnyError(ValueError):
    pass


def _make(folder):
    (folder / "file.txt").write_bytes(b"hello")


def _read(folder):
    return (folder / "file.txt").read_bytes()


def _if_altered(act):
    """A loader that does something about any other file than was saved."""

    def load(folder):
        return "whole" if (folder / "file.txt").is_file() and _read(folder) == b"hello" else act()

    return load


def _raise(error):
    raise error


def _forever():
    while True:
        pass


LOADERS = {
    "foreign": (_if_altered(lambda: _raise(AnyError("no"))), FOREIGN),
    "lines": (_if_altered(lambda: _raise(type("Own", (InputError,), {})("no"))), FOREIGN),
    "silent": (_if_altered(lambda: "something else"), WRONG),
    "memory": (_if_altered(lambda: np.ones(10**12)), MEMORY),
    "hidden": (_if_altered(lambda: _hide(MemoryError())), MEMORY),
    "good": (_if_altered(lambda: _raise(InputError("no"))), REFUSED),
    "forever": (_if_altered(_forever), HANG),
}


def _hide(error):
    try:
        raise error
    except MemoryError:
        raise InputError("damaged") from None


def targets():
    return [
        *(Target(name, _make, load, (".txt",)) for name, (load, _) in LOADERS.items()),
        Target("unsealed", _make, LOADERS["silent"][0]),
    ]


@linux
@pytest.mark.parametrize("name", [name for name in LOADERS if name != "forever"])
def test_what_goes_wrong_is_noticed(name):
    found = list(outcomes(0, 20, only=name, known=__name__))
    # Another whole file in its place is no fault that a checksum could show.
    found = [one for one in found if not one.change.startswith("replace_whole")]
    assert {one.verdict for one in found} - {LOADED} == {LOADERS[name][1]}
    assert found[0].verdict == LOADED


@linux
def test_a_file_without_a_checksum_may_say_something_else():
    assert {one.verdict for one in outcomes(0, 20, "unsealed", __name__)} == {LOADED, ALTERED}


@linux
@pytest.mark.full
def test_what_never_ends_is_stopped():
    found = list(outcomes(0, 2, only="forever", known=__name__))
    assert [one.verdict for one in found] == [LOADED, HANG]


@linux
def test_a_worker_that_never_begins_ends_the_run():
    with pytest.raises(RuntimeError, match="no worker came to its first case"):
        list(outcomes(0, 2_000, known="tests.fuzz.nothing"))


@linux
def test_the_same_seed_gives_the_same_cases(monkeypatch):
    first, again, other = (
        [(one.change, one.verdict) for one in outcomes(seed, 30, "good", __name__)]
        for seed in (1, 1, 2)
    )
    assert first == again != other


def test_the_command_prints_a_tally_and_what_went_wrong(monkeypatch, capsys):
    from tests.fuzz.outcome import Outcome

    found = [Outcome("map", "flip", REFUSED), Outcome("map", "cut", WRONG, seconds=1.25)]
    monkeypatch.setattr(command, "outcomes", lambda *_: iter(found))
    assert command.main(["--cases", "2", "--seed", "5"]) == 1
    printed = capsys.readouterr().out
    assert printed.startswith("seed 5\ncase 1: Outcome(target='map', change='cut'")
    assert printed.splitlines()[-2].split() == ["map", *"0010001", "1.25", "0"]
    monkeypatch.setattr(command, "outcomes", lambda *_: iter(found[:1]))
    assert command.main([]) == 0
