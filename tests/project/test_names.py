"""Old names do not come back: identifiers and coined nouns that have a word in the field."""

import re
import subprocess
from pathlib import Path

import pytest

PROJECT = Path(__file__).resolve().parents[2]
PLACES = ("tutorial_lib", "tests", "solutions/*.py", "README.md", "environment.md")

# Each is split by a bar, or this file would find itself.
WORDS = (
    "OracleCour|ier", "[Cc]ou|riers?", "Pil|ot", "pil|ots?", "[Jj]our|neys?", "MapJour|ney",
    "OracleJour|ney", "set_|out", "Wandering|Agent", "wan|derers?", "rmp_|moves", "grid|path",
    "[Jj]itt|er(?:s|ed)?", "[Ee]rr|ands?", "Tra|ils?", "tra|ils?", "She|lf",
    "laid_|out", "in_each_|world", "each_|world", "cont|enders", "Drive|Panel",
    "Drive|Controller", "map_|rules", "shu|n(?:s|ned)?", "pati|ently", "puni|shed", "warm_|up",
    "rate_|at", "most_probable_|way", "hope|less", "less|ons?", "looked_|around",
)  # fmt: skip
DEFINED = (
    "Out|comes", "Jud|ges?", "Ask|ed", "sear|ched", "ra|ce", "suf|fer", "gam|ble", "pru|ne",
    "map|ped", "to|ld", "by_|hand", "clo|ser", "cour|ier", "look_|around",
)  # fmt: skip
"""Ordinary words, old only as the name of a class, a function or a module."""
PATTERNS = {
    **{word.replace("|", ""): r"\b" + word.replace("|", "") + r"\b" for word in WORDS},
    **{
        f"def {word.replace('|', '')}": rf"\b(?:def|class|import) {word.replace('|', '')}\b"
        for word in DEFINED
    },
    "a method `some`": r"\.so" + r"me\(",
    "tests of robots as persons": r"def test_" + r"who_",
}
ALLOWED = (
    ("tutorial_lib/weights/", "warm_" + "up", "cards of trained networks"),
    ("tutorial_lib/weights/", '"err' + 'ands"', "cards of trained networks"),
    ("tutorial_lib/learning/reach_batches.py", '"err' + 'ands"', "a key of the cards"),
    ("tutorial_lib/learning/mining.py", "hope" + "less=", "part of recipes of files on disk"),
    ("tests/learning/test_reach_batches.py", '"err' + 'ands"', "a key of the cards"),
    ("solutions/03_reachability.py", "'err" + "ands'", "a key of the cards"),
    ("tutorial_lib/topology/mapping/storage.py", '"tra' + 'ils"', "a key of map files"),
    ("tests/topology/mapping/test_storage.py", '"tra' + 'ils"', "a key of map files"),
    ("tutorial_lib/experiments/", '"err' + 'ands"', "a column of a report"),
    ("tests/experiments/", '"err' + 'ands"', "a column of a report"),
    ("tutorial_lib/results/", '"err' + 'ands"', "a column of a report"),
)
"""Beginning of a path, text that may stay in its lines, and why."""


def found(path, text):
    """Names in a file, each with its line."""
    # A search that begins with a letter is quick; most files have nothing that it finds.
    inside = {n: old for n, old in PATTERNS.items() if re.search(old.removeprefix(r"\b"), text)}
    lines = []
    for number, line in enumerate(text.splitlines(), 1):
        for beginning, stays, _ in ALLOWED:
            if path.startswith(beginning):
                line = line.replace(stays, "")
        names = [name for name, pattern in inside.items() if re.search(pattern, line)]
        lines += [f"{path}:{number}: {name}" for name in names]
    return lines


KEPT = ("tutorial_lib/experiments/demos/maps/",)
"""Files of a user's format, in which old names stay."""


def texts():
    """Paths and texts of the files under version control."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--", *PLACES], cwd=PROJECT, capture_output=True, check=True
    )
    for path in filter(None, listed.stdout.decode().split("\0")):
        try:
            if not path.startswith(KEPT):
                yield path, (PROJECT / path).read_text(encoding="utf-8")
        except (UnicodeDecodeError, FileNotFoundError):
            continue  # not a text, or removed just now


def test_old_names_do_not_come_back():
    if not (PROJECT / ".git").exists():
        pytest.skip("no list of files: this is not a clone")
    files = dict(texts())
    assert len(files) > 200
    assert [line for path, text in files.items() for line in found(path, text)] == []


@pytest.mark.parametrize("name", [word for word in WORDS if not re.search(r"[\[(?]", word)])
def test_a_planted_name_is_found(name):
    old = name.replace("|", "")
    assert found("tests/some.py", f"one\nx = {old}(2)\n") == [f"tests/some.py:2: {old}"]
    assert found("tests/some.py", f"an{old}ed = 1\n") == []


def test_ordinary_words_are_none():
    text = "mapped = searched; the judge told it closer; prune edges; vary; errs; some(1); who is"
    assert found("tests/some.py", text) == []
    planted = "def to" + "ld(x):\nclass Out" + "comes:\npairs.so" + "me(3)\ndef test_" + "who_is():"
    assert len(found("tests/some.py", planted)) == 4


def test_what_is_allowed_is_allowed_there_only():
    line = 'row["err' + 'ands"]'
    assert found("tutorial_lib/learning/reach_batches.py", line) == []
    assert len(found("tutorial_lib/cli.py", line)) == 1
