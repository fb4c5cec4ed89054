"""Fig. 12: its rows and notes, and a run in a room with pillars that plays the office."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.conftest import in_turn, make_box, needs
from tutorial_lib.agents.remedies import REMEDIES
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.report import Options
from tutorial_lib.experiments.meng2020 import fig12, fig12_localization
from tutorial_lib.experiments.protocols import navigation, navigation_tasks
from tutorial_lib.experiments.protocols.lookalikes import Office
from tutorial_lib.experiments.protocols.navigation import Outcome, Result
from tutorial_lib.learning.threads import use_threads
from tutorial_lib.world.scene import Scene

use_threads(1)
networks = needs("waypoint_k5", "reach_k5")


def attempt_of(*endings, wormholes=0):
    """Trials of one office with those endings."""
    ending = np.array(endings)
    count = len(ending)
    outcome = Outcome(ending == "arrived", ending, np.ones(count), np.zeros(count), np.empty(0))
    none = np.zeros(count, dtype=bool)
    result = Result(outcome, (10, 20, wormholes))
    return fig12.Attempt(result, ending == "gave_up", none)


def run_with(monkeypatch, parts, options=None, settings=None):
    """Run on offices whose attempts are given."""
    monkeypatch.setattr(fig12, "for_each", lambda *_, **__: parts)
    return fig12.run(options or Options(worlds=(1, 2)), settings or fig12.Settings())


def test_a_row_for_each_choice_of_remedies_and_what_each_adds(monkeypatch):
    names = ("none", "filter", "no_filter", "all")
    good, bad = ["arrived"] * 4, ["arrived", "gave_up", "late", "stuck"]
    kinds = {"none": bad, "filter": good, "no_filter": bad, "all": good}
    parts = [
        {name: attempt_of(*kinds[name], wormholes=number + (name == "none")) for name in names}
        for number in (1, 2)
    ]
    rows, gaps = run_with(monkeypatch, parts, settings=fig12.Settings(remedies=names))
    assert [row["remedy"] for row in rows] == list(names)
    none, whole = rows[0], rows[-1]
    assert (none["trials"], none["success"], none["wormholes"]) == (8, 0.25, 5)
    assert (none["gave_up"], none["late"], none["stuck"]) == (0.25, 0.25, 0.25)
    assert (whole["success"], whole["wormholes"], whole["lost"]) == (1.0, 3, 0.0)
    assert [gap.line for gap in gaps] == [
        "filter - none: +75.0 points (+75.0 to +75.0)",
        "no_filter - all: -75.0 points (-75.0 to -75.0)",
        "all - none: +75.0 points (+75.0 to +75.0)",
    ]


def test_the_option_runs_one_choice_only(monkeypatch):
    asked = []

    def ask(work, worlds, options, settings, names, **_):
        asked.append(names)
        return [{name: attempt_of("arrived") for name in names}]

    monkeypatch.setattr(fig12, "for_each", ask)
    fig12.run(Options(worlds=(1,), remedies="no_cycles"), fig12.Settings())
    rows, _ = fig12.run(Options(worlds=(1,)), fig12.EXPERIMENT.quick_settings)
    fig12.run(Options(worlds=(1,)), fig12.Settings())
    assert asked == [("no_cycles",), ("none", "all"), REMEDIES]
    assert len(rows) == 2


def test_quick_runs_what_the_design_says():
    entry = fig12.EXPERIMENT
    assert (len(entry.worlds), len(entry.quick_worlds)) == (10, 3)
    assert (entry.settings.trials, entry.quick_settings.trials) == (50, 20)
    with pytest.raises(InputError, match="--family: meng_fig12 cannot use it"):
        entry.report(Options(family="hall"))


@pytest.fixture(scope="module")
def office():
    scene = Scene(make_box(12.0, 9.0, [(6.0, 4.5, 2.2)]))
    building = navigation_tasks.explored("room", scene, np.random.default_rng(3), 3)
    # One room, which is its own twin where a trial starts.
    return SimpleNamespace(
        building=building,
        group=np.array([0]),
        rooms=np.zeros(3, dtype=int),
        twin=np.array([True, True, False]),
    )


@pytest.mark.full
@networks
def test_the_same_trials_are_run_with_and_without_remedies(office, monkeypatch):
    monkeypatch.setattr(fig12, "make_office", lambda *_, **__: office)
    monkeypatch.setattr(fig12, "for_each", in_turn)
    monkeypatch.setattr(navigation, "GRACE", 0.0)
    few = replace(fig12.EXPERIMENT, quick_settings=fig12.Settings(2, ("none", "no_filter", "all")))
    report = few.report(Options(quick=True, worlds=(10_000,)))
    rows = {row["remedy"]: row for row in report.rows}
    assert list(rows) == ["none", "no_filter", "all"]
    for row in rows.values():
        assert row["trials"] == 2
        assert row["vertices"] > 0
        assert row["success"] + row["wrong_place"] + sum(
            row[name] for name in ("gave_up", "stuck", "late")
        ) == pytest.approx(1)
    assert rows["no_filter"]["edges"] == rows["all"]["edges"]
    assert rows["all"]["circled"] == 0


@pytest.mark.full
@networks
def test_the_filter_is_watched_along_drives_and_at_standstill(office, monkeypatch):
    monkeypatch.setattr(fig12_localization, "make_office", lambda *_, **__: office)
    monkeypatch.setattr(fig12_localization, "for_each", in_turn)
    settings = fig12_localization.Settings(robots=3, before=3.0, after=3.0, still=2.0)
    rows, notes = fig12_localization.run(Options(worlds=(10_000,)), settings)
    found = {row["case"]: row for row in rows}
    assert list(found) == list(fig12_localization.CASES)
    assert found["driven"]["right"] > 0.3
    assert found["standstill"]["changes_at_most_once"] == 1.0
    assert found["kidnapped"]["count"] == 1
    assert notes == []


# Localization by itself.


def looks(vertex, gap, sure=None, poses=None):
    vertex = np.array(vertex)
    sure = np.ones(vertex.shape) if sure is None else np.array(sure)
    poses = np.zeros((*vertex.shape, 3)) if poses is None else poses
    return fig12_localization.Looks(vertex, sure, np.array(gap, dtype=float), poses)


def test_what_counts_as_noticed_found_and_calm():
    settings = fig12_localization.Settings(robots=4, before=0.2, after=0.5, still=2.0)
    room = SimpleNamespace(kind="office", contains=lambda points: np.zeros(points.shape[:-1], bool))
    plan = SimpleNamespace(rooms=[room])
    office = Office(
        SimpleNamespace(scene=SimpleNamespace(plan=plan)), np.array([0]), np.zeros(2, dtype=int)
    )
    # Robots 1 and 3 are carried away at step 2: one finds itself at vertex 7, one keeps to 4.
    vertex = [[3, 4, 3, 4]] * 3 + [[3, -1, 3, 4], [3, 7, 3, 4], [3, 7, 3, 4], [3, 7, 3, 4]]
    gap = [[1, 1, 9, 1]] * 3 + [[1, np.inf, 9, 8], [1, 1, 9, 8], [1, 1, 9, 8], [1, 1, 9, 8]]
    still = looks([[2, 2]] * 12 + [[5, 2]] + [[2, 2]] * 7, np.ones((20, 2)))
    found = fig12_localization._measured(office, looks(vertex, gap), still, settings)
    assert found["kidnapped"]["noticed"].tolist() == [True, False]
    assert found["kidnapped"]["found"].tolist() == [True, False]
    assert found["driven"]["right"].mean() == 0.5
    assert found["standstill"]["changes"].tolist() == [2, 0]
    assert len(found["doors"]["right"]) == 0
    rows = {case: fig12_localization._row(case, [found[case]]) for case in fig12_localization.CASES}
    assert rows["kidnapped"]["noticed"] == 0.5
    assert rows["standstill"]["changes_at_most_once"] == 0.5
    assert rows["driven"]["right_if_sure"] == 0.5
    assert rows["doors"]["right"] is None
    assert rows["driven"]["noticed"] is None
    assert len({tuple(row) for row in rows.values()}) == 1


def test_a_carried_robot_comes_to_another_kind_of_room_that_is_not_its_goal():
    pairs = np.array([[start, goal] for start in range(4) for goal in range(4) if start != goal])
    poses = np.column_stack([pairs, np.zeros(len(pairs))]).astype(float)  # x is the place
    recorded = SimpleNamespace(poses=poses, first_frames=np.arange(len(pairs)))
    office = Office(
        SimpleNamespace(pairs=pairs, recorded=recorded), np.array([0, 0, 1, 2]), np.arange(4)
    )

    class Trials(SimpleNamespace):
        def __len__(self):
            return len(self.pairs)

    trials = Trials(pairs=np.array([[0, 2], [1, 3], [0, 3], [1, 2]]))
    carried = fig12_localization._elsewhere(office, trials)
    assert carried[:, 0].tolist() == [3, 2, 2, 3]
