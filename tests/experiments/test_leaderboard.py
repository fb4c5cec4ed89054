"""The leaderboard: what judges a class, and boards that can be merged, read and shown."""

import json
import re
from dataclasses import asdict, replace
from functools import cache
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from joblib import parallel_config

import tutorial_lib
from tests.conftest import make_box
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.own import MEMBERS
from tutorial_lib.experiments.common.report import Options
from tutorial_lib.experiments.leaderboard import (
    CONTESTS,
    LOCAL,
    NAVIGATION,
    SEAMS,
    Entry,
    judged,
    merged,
    page_of,
    ranked,
    read_board,
    text_of,
)
from tutorial_lib.experiments.meng2020 import table1, table2
from tutorial_lib.experiments.protocols import local_control, navigation
from tutorial_lib.world.plan_json import save_plan

TEMPLATES = Path(tutorial_lib.__file__).parent / "templates"
CLEAN = cache(local_control.clean_condition)
"""Makes the condition without noise; the same one is made once."""
SHA = "0123456789abcdef" * 4


def clean(place, count, options):
    """The condition without noise alone, whatever else the options say."""
    return {"clean": CLEAN(place, count, Options(seed=options.seed))}


def row(success=0.5, condition="clean", low=0.25, high=0.75):
    return {"condition": condition, "success": success, "low": low, "high": high}


def entry(name="mine.py:Mine", seam="controller", rows=None, fault="", **more):
    rows = [] if fault else [row()] if rows is None else rows
    given = {"experiment": LOCAL.name, "sha": SHA, "quick": True, "worlds": (20_000,)} | more
    return Entry(seam=seam, name=name, rows=rows, fault=fault, **given)


SHARES = st.one_of(st.none(), st.floats(0, 1))
ROWS = st.builds(row, st.floats(0, 1), st.sampled_from(["clean", "noise"]), SHARES, SHARES)
ENTRIES = st.one_of(
    st.builds(
        entry,
        st.sampled_from(["a.py:A", "b.py:B", "<i>.py:É"]),
        st.sampled_from(["", "controller", "predictor"]),
        st.lists(ROWS, min_size=1, max_size=3),
        quick=st.booleans(),
        worlds=st.lists(st.integers(0, 3), max_size=2).map(tuple),
    ),
    st.builds(entry, fault=st.sampled_from(["line 3: it broke", "<b>"])),
)
BOARDS = st.lists(ENTRIES, max_size=5)


@given(BOARDS, BOARDS, BOARDS)
def test_merging_is_idempotent_commutative_and_associative(first, second, third):
    both = merged([*first, *second])
    assert merged(both) == both == merged([*both, *first]) == merged([*second, *first])
    assert merged([*both, *third]) == merged([*first, *merged([*second, *third])])
    assert all(one in both for one in [*first, *second])
    assert all(one in [*first, *second] for one in both)


@given(BOARDS)
def test_a_board_is_read_as_it_was_written_and_can_be_shown(tmp_path_factory, entries):
    path = tmp_path_factory.mktemp("board") / "board.json"
    path.write_text(text_of(entries), encoding="utf-8")
    board = read_board(path)
    assert board == merged(entries)
    assert text_of(board) == path.read_text(encoding="utf-8")
    for (seam, *run), lines in ranked(board).items():
        scores = [one.score for one in lines]
        assert scores == sorted(scores, reverse=True)
        assert {one.seam for one in lines} <= {"", seam}
        assert all(one.run == (*run,) for one in lines)
    assert page_of(board).count("<tr class=") == sum(map(len, ranked(board).values()))


WRONG = {
    "experiment": ("nothing", 3, ["meng_table1"], None),
    "seam": ("wheel", None, ["planner"]),
    "name": ("", "two\nlines", "x" * 301, 5, "\ud800"),
    "sha": ("abc", SHA.upper(), None),
    "quick": (1, "yes"),
    "worlds": ("12", [True], [1.5], {}, None),
    "rows": (
        *([], {}, "rows", [1], [{}], [row() | {"more": 1}], [row(condition=None)], None),
        *([row(value)] for value in (float("nan"), float("inf"), -0.1, 1.1, "0.5", True, None)),
        *([row(low=value)] for value in (2, "0")),
    ),
    "fault": ("and a fault", "\x1b[2J", None),
}


@pytest.mark.parametrize("name", WRONG)
def test_a_field_that_cannot_be_right_is_refused_by_the_file_s_name(tmp_path, name):
    path, sound = tmp_path / "board.json", json.loads(text_of([entry()]))
    for value in WRONG[name]:
        board = {"version": 1, "entries": [sound["entries"][0] | {name: value}]}
        path.write_text(json.dumps(board))
        with pytest.raises(InputError, match=r"board\.json: no leaderboard \(.*leaderboard wrote$"):
            read_board(path)


@pytest.mark.parametrize(
    "text",
    ["", "{", "[]", "3", "null", '"x"', "{}", '{"version": 2, "entries": []}', '{"entries": []}']
    + [f'{{"version": 1, "entries": {one}}}' for one in ("3", "null", "[3]", "[[]]", "[{}]")],
)
def test_a_damaged_file_is_refused(tmp_path, text):
    path = tmp_path / "board.json"
    path.write_text(text)
    with pytest.raises(InputError, match=r"board\.json: .*; give a file that leaderboard wrote$"):
        read_board(path)


def test_the_page_ranks_own_rows_among_references_and_escapes_names():
    entries = [
        entry("<script>alert(1)</script>.py:A&B", rows=[row(0.7), row(0.5, "noise", None)]),
        entry("k5", "", [row(0.9), row(0.8, "noise")]),
        entry("random", "", [row(0.2), row(0.2, "noise")]),
        entry("other run", "", [row(1.0)], quick=False),
        entry("bad.py:Bad", fault="bad.py, line 3: <b>ValueError</b>: 'x'"),
    ]
    page = page_of(entries)
    assert "<script" not in page
    assert "&lt;script&gt;alert(1)&lt;/script&gt;.py:A&amp;B" in page
    assert "bad.py, line 3: &lt;b&gt;ValueError&lt;/b&gt;: &#39;x&#39;" in page
    places = re.findall(r"<td>(\d)</td><td>(\S+?)</td>", page)
    assert [name[:3] for _, name in places] == ["k5", "&lt", "ran"]
    assert "0.600" in page  # the mean of the cases
    assert "0.70 (0.25–0.75)" in page
    assert re.search(r"<td>0\.50\s*</td>", page)
    assert "other run" not in page
    assert "color-scheme: light dark" in page
    assert not re.search(r"(src|href)=|url\(|@import", page)
    assert "No class has a score yet" in page_of([])


def test_every_seam_is_judged_and_every_experiment_has_what_the_board_needs():
    assert set(SEAMS) == set(MEMBERS)
    for contest in CONTESTS.values():
        run = contest.experiment
        assert run.worlds
        assert run.quick_worlds
        for settings in (run.settings, run.quick_settings, run.canary):
            assert contest.names in asdict(settings)
        assert "agent" in run.accepts


def files():
    return sorted(path.stem for path in TEMPLATES.glob("[a-z]*.py"))


def test_there_is_a_short_template_for_every_seam():
    assert set(files()) == {seam.replace(" ", "_") for seam in SEAMS} | {"lifelong_explorer"}
    for name in files():
        assert (TEMPLATES / f"{name}.py").read_text(encoding="utf-8").count("\n") < 35


@pytest.fixture
def small(tmp_path, monkeypatch):
    """Navigation takes place in a room, and controllers drive under one condition."""
    save_plan(make_box(), tmp_path / "room.json")
    monkeypatch.setattr(navigation, "GRACE", 1.0)
    room = table2.Settings(places_on_map=3, trials_of_part=2)
    monkeypatch.setattr(table1, "conditions", clean)
    for seam, contest in SEAMS.items():
        if contest is NAVIGATION:
            options = replace(contest.options, map=tmp_path / "room.json")
            run = replace(contest.experiment, canary=room)
            monkeypatch.setitem(SEAMS, seam, replace(contest, experiment=run, options=options))


@pytest.mark.parametrize("name", files())
def test_a_template_is_judged(name, small):
    with parallel_config(backend="sequential"):
        found = judged(f"{TEMPLATES / name}.py:Mine", quick=True, first=True)
    assert found["seam"] == name.removeprefix("lifelong_").replace("_", " ")
    assert "fault" not in found
    assert found["experiment"] == ("race" if "lifelong" in name else SEAMS[found["seam"]].name)
    score = CONTESTS[found["experiment"]].score[0]
    assert len(found["worlds"]) == 1
    assert found["rows"]
    assert all(0 <= row[score] <= 1 for row in found["rows"])
    board = text_of([Entry(name=name, sha="", quick=True, **found)])
    assert json.loads(board)["entries"]
