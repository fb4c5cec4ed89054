"""What no longer fits is found, and the canary tells whether the numbers have changed."""

from dataclasses import replace

import pytest

from tutorial_lib.cli import parse
from tutorial_lib.commands import reproduce, results
from tutorial_lib.errors import InputError
from tutorial_lib.experiments import provenance
from tutorial_lib.experiments.common.report import Options, Report
from tutorial_lib.experiments.provenance import (
    CANARY,
    CHANGED,
    CODE,
    FITS,
    MODULE,
    NETWORK,
    NETWORKS,
    PROCESSOR,
    UNKNOWN,
    changed_rows,
    made_from,
    standing_of,
)
from tutorial_lib.experiments.results_page.sources import COMMANDS, EXPERIMENTS, load_results
from tutorial_lib.experiments.results_page.templates import mark_of
from tutorial_lib.learning.threads import processor

ROWS = [{"method": "meng", "success": 0.5}, {"method": "sptm", "success": None}]
MODULE_NAME = "tutorial_lib.experiments.meng2020.fig6"
WITHOUT_CANARY = {"meng_fig4", "meng_fig11"}
"""They take hardly longer than a canary."""


@pytest.fixture
def report():
    """A result of today's code and networks."""
    card = provenance.load_card("waypoint_k2")
    origin = {
        MODULE: MODULE_NAME,
        NETWORKS: {"waypoint_k2": provenance.fingerprint_of(card)},
        CODE: provenance.code_of(MODULE_NAME),
        CANARY: ROWS,
        PROCESSOR: processor(),
    }
    return Report("meng_fig6", 0, (20_000,), False, 36.0, ROWS, made_from=origin)


def with_origin(report, **changed):
    """A result that was made from something else."""
    return replace(report, made_from=report.made_from | changed)


def test_a_result_of_today_fits(report):
    assert standing_of(report).kind == FITS
    assert mark_of(report) == ""


def test_a_network_that_was_trained_anew_is_named_first(report):
    older = with_origin(report, networks={"waypoint_k2": "another"}, code={})
    assert standing_of(older) == provenance.Standing(NETWORK, "waypoint_k2 trained anew")
    assert mark_of(older) == "; STALE: waypoint_k2 trained anew"


def test_a_network_that_is_gone_is_one_that_changed(report):
    assert standing_of(with_origin(report, networks={"waypoint_k77": "it"})).kind == NETWORK


def test_changed_code_is_named_by_its_parts_also_what_is_new_or_gone(report):
    code = dict(report.made_from[CODE])
    del code["world"]
    older = with_origin(report, code=code | {"driving": "another", "removed": "part"})
    assert standing_of(older).kind == CHANGED
    assert mark_of(older) == "; STALE: code changed in driving, removed, world"


def test_a_result_that_does_not_say_is_unknown(report):
    assert standing_of(replace(report, made_from={})).kind == UNKNOWN


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        (ROWS, ""),
        (ROWS[:1], "1 rows, not 2"),
        ([ROWS[0] | {"success": 0.75}, ROWS[1]], "row 0: success 0.5 is 0.75"),
        ([ROWS[0], ROWS[1] | {"success": 0.0}], "row 1: success None is 0.0"),
        ([ROWS[0] | {"late": 0.0}, ROWS[1]], "row 0: late None is 0.0"),
    ],
)
def test_what_differs_first_between_two_canaries(rows, words):
    assert changed_rows(ROWS, rows) == words


@pytest.mark.parametrize(
    ("success", "alike"), [(0.5, True), (0.5 * (1 + 1e-8), True), (0.5 * (1 + 1e-5), False)]
)
def test_rounding_is_no_difference_where_it_may_be_one(success, alike):
    rows = [ROWS[0] | {"success": success}, ROWS[1]]
    assert (changed_rows(ROWS, rows, provenance.ROUNDING) == "") == alike
    assert (changed_rows(ROWS, rows) == "") == (success == 0.5)


@pytest.fixture
def one_result(report, monkeypatch):
    """A course with one stored result, whose canary is known; what is written."""
    written = {}
    older = with_origin(report, code=report.made_from[CODE] | {"driving": "another"})
    stored = type(load_results())({"meng_fig6": older})
    monkeypatch.setattr(results, "EXPERIMENTS", {"meng_fig6": "experiment meng_fig6"})
    monkeypatch.setattr(results, "load_results", lambda: stored)
    monkeypatch.setattr(results, "store", lambda report, name: written.update({name: report}))
    return written


def test_changed_code_with_the_same_canary_is_noted_in_the_result(
    report, one_result, monkeypatch, capsys
):
    monkeypatch.setattr(provenance, "made_from", lambda *_: report.made_from)
    assert results.check_results() == 0
    assert one_result == {"meng_fig6": report}
    assert "meng_fig6: code changed, numbers did not" in capsys.readouterr().out


def test_a_changed_canary_asks_for_a_new_measurement(report, one_result, monkeypatch, capsys):
    now = report.made_from | {CANARY: [ROWS[0] | {"success": 0.75}, ROWS[1]]}
    monkeypatch.setattr(provenance, "made_from", lambda *_: now)
    assert results.check_results() != 0
    said = capsys.readouterr().out
    assert "meng_fig6: row 0: success 0.5 is 0.75" in said
    assert "measure again: .venv/bin/python -m tutorial_lib experiment meng_fig6 --json" in said
    assert not one_result


def test_where_the_course_is_installed_the_command_is_its_own(
    report, one_result, monkeypatch, capsys
):
    monkeypatch.setattr(provenance, "made_from", lambda *_: report.made_from | {CANARY: []})
    monkeypatch.setattr(results, "is_checkout", lambda: False)
    assert results.check_results() != 0
    said = capsys.readouterr().out
    assert "measure again: topological-navigation experiment meng_fig6 --json FILE" in said


@pytest.mark.parametrize("success", [0.5, 0.5 * (1 + 1e-8), 0.75])
def test_on_another_processor_only_the_same_rows_tell(
    report, one_result, capsys, monkeypatch, success
):
    now = report.made_from | {CANARY: [ROWS[0] | {"success": success}, ROWS[1]]}
    monkeypatch.setattr(provenance, "made_from", lambda *_: now | {PROCESSOR: "another"})
    assert (results.check_results() == 0) == (success != 0.75)
    said = f"but its canary is of another kind of processor, {processor()}"
    assert (said in capsys.readouterr().out) == (success == 0.75)


@pytest.mark.full
def test_the_canary_counts_the_networks_of_its_own_run():
    found = made_from("meng_fig5", Options())
    stored = load_results().reports["meng_fig5"].made_from
    assert set(found) == {MODULE, NETWORKS, CODE, CANARY, PROCESSOR} == set(stored)
    assert found[NETWORKS] == stored[NETWORKS]
    assert {"reach_k2", "reach_k5", "reach_laser"} <= set(found[NETWORKS])
    if stored[PROCESSOR] == found[PROCESSOR]:
        assert changed_rows(stored[CANARY], found[CANARY]) == ""


def test_what_a_stored_result_says_of_its_origin_is_whole():
    stored = load_results().reports
    origins = {name: stored[name].made_from for name in EXPERIMENTS if stored[name].made_from}
    assert len(origins) > 20
    for name, origin in origins.items():
        assert origin[MODULE].startswith("tutorial_lib.experiments."), name
        assert origin[CODE]["world"], name
        assert bool(origin[CANARY]) != (name in WITHOUT_CANARY), name


# The plan of measuring again.


def test_the_whole_course_trains_first_and_shows_last():
    steps = [step.arguments.split()[0] for step in reproduce.planned([], everything=True)]
    assert sorted(steps, key=["train", "experiment", "bench", "results", "build"].index) == steps
    assert steps.count("experiment") + steps.count("bench") == len(COMMANDS)


def test_networks_come_after_those_that_they_start_from():
    steps = [step.arguments for step in reproduce.planned([], everything=True)]
    order = [steps.index(f"train {one}") for one in ("waypoint --k 2", "waypoint --k 5")]
    order += [steps.index("train relative --k 5")]
    assert order == sorted(order)


def test_a_name_that_is_no_result_s_is_refused():
    with pytest.raises(InputError, match="meng_fig77: no result; there are plans, "):
        reproduce.planned(["meng_fig77"], everything=False)
    with pytest.raises(InputError, match="leave out one of the two"):
        reproduce.planned(["meng_fig7"], everything=True)


def test_a_plan_that_fails_goes_on_where_it_was(monkeypatch, tmp_path, capsys):
    monkeypatch.setenv("TUTORIAL_CACHE", str(tmp_path))
    codes, ran = iter([0, 1, 0, 0]), []

    def call(arguments, **_):
        ran.append(arguments[3])
        return next(codes)

    monkeypatch.setattr(reproduce.subprocess, "call", call)
    options = type(
        "Given", (), {"names": ["meng_fig6"], "all": False, "plan": False, "scheduler": ""}
    )
    with pytest.raises(InputError, match="results: failed; the same command goes on"):
        reproduce.run(options)
    assert reproduce.run(options) == 0
    assert ran == ["experiment", "results", "results", "build"]
    assert "3 commands, 0.0 h" in capsys.readouterr().out
    assert not list(tmp_path.rglob("*.json"))


def test_workers_of_a_scheduler_get_all_but_what_measures_this_machine(monkeypatch, tmp_path):
    monkeypatch.setenv("TUTORIAL_CACHE", str(tmp_path))
    ran = []
    monkeypatch.setattr(reproduce.subprocess, "call", lambda command, **_: ran.append(command[3:]))
    steps = [
        reproduce.Step(arguments)
        for arguments in ("train waypoint --k 2", "experiment plans", "bench fleet", "build")
    ]
    monkeypatch.setattr(reproduce, "planned", lambda *_, **__: steps)
    options = parse(["reproduce", "--scheduler", "tcp://a:1"])
    assert reproduce.run(options) == 0
    assert [command[-1] == "tcp://a:1" for command in ran] == [True, True, False, False]
    for command in ran[:3]:
        assert parse(command).scheduler == ("" if command[0] == "bench" else "tcp://a:1")
