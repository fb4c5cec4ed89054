"""The command: a faulty class costs its own entry only, and boards are merged."""

import json

import cv2
import numpy as np
import pytest

from tutorial_lib.cli import main
from tutorial_lib.commands import leaderboard as command
from tutorial_lib.experiments import leaderboard
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.own import load_own, or_fault
from tutorial_lib.experiments.common.report import Fault
from tutorial_lib.experiments.demos.recorder import FILM_RATE
from tutorial_lib.experiments.failures import Trip
from tutorial_lib.experiments.leaderboard import Contest, read_board
from tutorial_lib.experiments.meng2020.table1 import Settings
from tutorial_lib.world.simulation import checked_actions

CLASS = """
import numpy as np

class Mine:
    def __init__(self):
        {init}
    def act(self, observations, waypoints):
        {act}
"""
GOOD = CLASS.format(init="pass", act="return np.full((3, 2), 0.5)")
FOR_EVER = "while True: waypoints = 0"
ALL = "x = []\n        while True: x.append(bytes(10**7))"
FAULTY = {
    "syntax error": ("class Mine(\n", "own.py, line 1: SyntaxError"),
    "wrong class": (GOOD.replace("Mine", "Another"), "own.py has no Mine"),
    "missing method": (GOOD.replace("act(", "drive("), "has the methods of no component"),
    "raises in __init__": (
        CLASS.format(init="1 / 0", act="pass"),
        "own.py, line 6: ZeroDivisionError",
    ),
    "raises in act": (CLASS.format(init="pass", act="1 / 0"), "own.py, line 8: ZeroDivisionError"),
    "returns None": (CLASS.format(init="pass", act="return None"), "actions: None"),
    "NaN": (CLASS.format(init="pass", act="return np.full((3, 2), np.nan)"), "actions: nan"),
    "wrong shape": (CLASS.format(init="pass", act="return np.ones(3)"), "actions: shape (3,)"),
    "endless loop": (
        CLASS.format(init="pass", act=FOR_EVER),
        "own.py, line 8: TimeUp: not done after 0.5 seconds; does a loop never end?",
    ),
    "all memory": (CLASS.format(init="pass", act=ALL), "own.py, line 9: MemoryError"),
}
"""What is in the file, and what is said of it."""


TRIPS = [
    Trip(
        "apartment/10000/standard",
        np.array([4.0, 4.0, 0.0]),
        np.array([[2.0, 2.0, 0.0], [2.5, 2.0, 0.0], [2.0 + metres, 2.0, 0.1]]),
        seconds=1.0,
        panorama=True,
    )
    for metres in (2.0, 1.0, 1.5)
]


def row(name, success, low=None, high=None):
    shares = {"success": success, "low": low, "high": high}
    return {"controller": name, "condition": "clean", **shares}


def fake(options, settings):
    """An experiment of one action."""
    known = {"k5": row("k5", 0.9, 0.8, 1.0), "random": row("random", 0.1)}
    rows = [known[name] for name in settings.controllers]
    if not options.agent:
        return rows, []

    def drive():
        _, part = load_own(options.agent, ["controller"])
        return float(checked_actions(part.act(None, np.zeros((3, 2))), 3).mean())

    mine = or_fault(options.agent, drive)
    return (rows, [mine]) if isinstance(mine, Fault) else ([*rows, row("custom", mine)], [])


@pytest.fixture
def board(tmp_path, monkeypatch):
    """Runs the command on a class by that experiment, in this process; returns code and board."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("TUTORIAL_CACHE", str(tmp_path / "cache"))
    entry = Experiment("fake", fake, (1, 2), (1,), Settings(), Settings(), Settings(1))
    contest = Contest(
        *(entry, "controllers", "controller", ("condition",)),
        *(("success", "low", "high"), ("k5", "random")),
        lambda world, options, settings: iter(TRIPS),
    )
    monkeypatch.setitem(leaderboard.SEAMS, "controller", contest)
    monkeypatch.setitem(leaderboard.CONTESTS, "fake", contest)
    monkeypatch.setattr(command, "apart", command.limited)
    monkeypatch.setattr(command, "MEMORY", 2e8)
    for name in ("SECONDS", "WAITING", "MEMORY"):
        monkeypatch.setattr(command.guard, name, getattr(command.guard, name))

    def run(text, *options):
        (tmp_path / "own.py").write_text(text)
        code = main(["leaderboard", "--agent", "own.py:Mine", "--quick", *options])
        return code, read_board(tmp_path / "leaderboard.json")

    return run


@pytest.mark.parametrize("fault", FAULTY)
def test_a_faulty_class_gets_an_entry_and_a_line(board, fault, tmp_path, monkeypatch, capsys):
    text, words = FAULTY[fault]
    if fault == "endless loop":  # others need less, but must not wait for a busy machine
        monkeypatch.setattr(command, "FIRST", 0.5)
    code, entries = board(text)
    assert code == 2
    (entry,) = entries
    assert words in entry.fault
    assert entry.name == "own.py:Mine"
    assert entry.sha
    said = capsys.readouterr().err
    assert f"error: own.py:Mine: {entry.fault}" in said
    assert "Traceback" not in said
    assert "own.py:Mine" in (tmp_path / "leaderboard.html").read_text()


def test_what_cannot_be_judged_is_refused_before_anything_is_written(monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    for where in ("own.py:Mine", "own.py", "Mine", ":"):
        assert main(["leaderboard", "--agent", where]) == 2
        said = capsys.readouterr().err
        assert said.startswith(f"error: --agent {where}: ")
        assert said.endswith("give FILE.py:CLASS\n")
    assert not list(tmp_path.iterdir())
    (tmp_path / "own.py").write_text(GOOD)
    assert main(["leaderboard", "--agent", "own.py:Mine", "--film", "worst.gif"]) == 2
    assert "--film: worst.gif; a film's name ends in .webm" in capsys.readouterr().err
    assert [file.name for file in tmp_path.iterdir()] == ["own.py"]


def test_references_run_once_and_a_second_class_costs_its_own_run(board, capsys, monkeypatch):
    assert board(FAULTY["raises in act"][0])[0] == 2
    code, entries = board(GOOD)
    assert code == 0
    assert sorted(one.name for one in entries) == ["k5", "own.py:Mine", "own.py:Mine", "random"]
    out, err = capsys.readouterr()
    assert out.splitlines() == [
        "controller: fake, success",
        "  1  0.900  k5",
        "  2  0.500  own.py:Mine  <- you",
        "  3  0.100  random",
        "worst failure: 2.2 m from its goal in apartment/10000/standard, see leaderboard.webm",
    ]
    film = cv2.VideoCapture("leaderboard.webm")
    assert film.get(cv2.CAP_PROP_FRAME_COUNT) == len(TRIPS[0].poses) + round(2 * FILM_RATE)
    assert err.count("fake: k5, random") == 1
    monkeypatch.setattr(Contest, "refer", None)  # is not called
    code, entries = board(GOOD.replace("0.5", "0.95"))
    assert code == 0
    assert len(entries) == 5
    assert "  1  0.950  own.py:Mine  <- you" in capsys.readouterr().out


@pytest.mark.full
def test_a_class_that_ends_its_process_is_said_so(tmp_path):
    (tmp_path / "own.py").write_text(CLASS.format(init="import os; os._exit(3)", act="pass"))
    found = command.apart(5.0, f"{tmp_path / 'own.py'}:Mine", True, True)
    assert found == {"fault": "its process ended itself or was killed (exit code 3)"}


@pytest.mark.full
def test_a_process_has_limits_too_and_one_that_does_not_stop_is_killed(tmp_path, monkeypatch):
    (tmp_path / "own.py").write_text(CLASS.format(init=FOR_EVER, act="pass"))
    where = f"{tmp_path / 'own.py'}:Mine"
    found = command.apart(1.0, where, True, True)
    assert "own.py, line 6: TimeUp: not done after 1 seconds" in found["fault"]
    monkeypatch.setattr(command, "START", 0.1)
    found = command.apart(0.1, where, True, True)
    assert "whatever is done to end it" in found["fault"]


FIELDS = {"experiment": "", "seam": "", "sha": "", "quick": True, "worlds": [], "rows": []}


def test_boards_are_merged_in_any_order_and_a_damaged_one_changes_nothing(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    faults = [{**FIELDS, "name": name, "fault": "it broke"} for name in "ab"]
    for one in faults:
        text = json.dumps({"version": 1, "entries": [one]})
        (tmp_path / f"{one['name']}.json").write_text(text)
    (tmp_path / "bad.json").write_text("{}")
    merge = ["leaderboard", "--merge"]
    assert main([*merge, "b.json", "a.json", "--board", "ba.json", "--page", "ba.html"]) == 0
    assert "2 entries in ba.json, shown by ba.html" in capsys.readouterr().out
    assert main([*merge, "a.json"]) == main([*merge, "b.json"]) == main([*merge, "a.json"]) == 0
    before = (tmp_path / "leaderboard.json").read_bytes()
    assert before == (tmp_path / "ba.json").read_bytes()
    assert (tmp_path / "leaderboard.html").read_bytes() == (tmp_path / "ba.html").read_bytes()
    capsys.readouterr()
    for wrong in ("bad.json", "none.json"):
        assert main([*merge, "a.json", wrong]) == 2
        assert wrong in capsys.readouterr().err
    assert main([*merge, "a.json", "--board", "bad.json"]) == 2
    assert main([*merge, "a.json", "--page", "none/page.html"]) == 2
    assert main([*merge, "a.json", "--page", "leaderboard.json"]) == 2
    assert (tmp_path / "leaderboard.json").read_bytes() == before
    assert (tmp_path / "bad.json").read_text() == "{}"
    assert not list(tmp_path.glob(".*"))


def test_a_template_is_printed_as_it_is(capsys):
    assert main(["leaderboard", "--template", "planner"]) == 0
    printed = capsys.readouterr().out
    assert printed == (command.FOLDER / "planner.py").read_text(encoding="utf-8")
    assert "class Mine" in printed


@pytest.mark.parametrize(
    "arguments", [[], ["--agent", "a.py:A", "--merge", "b.json"], ["--template", "wheel"]]
)
def test_one_thing_is_asked_at_a_time(arguments, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["leaderboard", *arguments])
    assert ended.value.code == 2
    assert "--template" in capsys.readouterr().err
