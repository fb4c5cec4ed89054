"""What an experiment runs on, with which settings, and which options it refuses."""

from dataclasses import replace
from pathlib import Path

import pytest

from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.experiment import Experiment
from tutorial_lib.experiments.common.report import Options
from tutorial_lib.experiments.registry import BENCHMARKS, EXPERIMENTS

WORLDS = (10, 11, 12)
EVERYTHING = {
    "worlds": Options(worlds=(3, 4)),
    "map": Options(map=Path("depot.yaml")),
    "palette": Options(palette="shifted"),
    "agent": Options(agent="mine.py:Mine"),
    "odometry": Options(odometry="exact"),
    "family": Options(family="hall"),
    "drives": Options(drives="tour"),
    "starts": Options(starts="anywhere"),
    "goals": Options(goals="turned"),
    "remedies": Options(remedies="no_filter"),
    "goal-images": Options(goal_images="clip"),
    "body": Options(body="car"),
    "robot": Options(robot="mine.py:Mine"),
}
OPTIONAL = {
    *("map", "palette", "family", "agent", "odometry", "drives", "starts", "goals", "remedies"),
    "goal-images",
    "body",
    "robot",
}
NOTED = {
    "palette": "palette: shifted",
    "odometry": "odometry: exact",
    "family": "family: hall",
    "starts": "starts: anywhere",
    "goals": "goals: turned",
    "remedies": "remedies: no_filter",
    "robot": "robot: mine.py:Mine",
}


def run(options, settings):
    """Rows that show what the experiment was given."""
    return [{"worlds": options.worlds, "settings": settings}], ["a note"]


def never(options, settings):
    raise AssertionError("it was run")


def make(**changed):
    given = {"run": run, "worlds": WORLDS, "quick_worlds": WORLDS[:2]}
    return Experiment("trial", **(given | {"settings": 60, "quick_settings": 6} | changed))


@pytest.mark.parametrize(
    ("experiment", "options", "worlds", "settings"),
    [
        (make(), Options(), WORLDS, 60),
        (make(), Options(quick=True), WORLDS[:2], 6),
        (make(), Options(quick=True, worlds=(3, 4, 5)), (3, 4, 5), 6),
        (make(quick_worlds=()), Options(quick=True), WORLDS, 6),
        (make(quick_settings=None), Options(quick=True), WORLDS[:2], 60),
        (make(worlds=(7,), quick_worlds=()), Options(), (7,), 60),
        (make(worlds=(7,), quick_worlds=()), Options(worlds=(8,)), (8,), 60),
        (make(worlds=(), quick_worlds=()), Options(), (), 60),
        (make(accepts=frozenset({"map"})), EVERYTHING["map"], (), 60),
    ],
)
def test_an_experiment_runs_on_its_worlds_with_its_settings(experiment, options, worlds, settings):
    report = experiment.report(replace(options, seed=5))
    assert report.rows == [{"worlds": worlds, "settings": settings}]
    assert (report.name, report.seed, report.worlds, report.quick) == (
        "trial",
        5,
        worlds,
        options.quick,
    )
    assert report.notes == ("a note",)
    assert report.map == ("depot.yaml" if options.map else "")
    assert 0.0 <= report.seconds < 5.0


@pytest.mark.parametrize("name", sorted(OPTIONAL))
def test_an_option_is_taken_where_it_is_declared_and_refused_elsewhere(name):
    report = make(accepts=frozenset({name})).report(EVERYTHING[name])
    own = [f"custom: {EVERYTHING[name].agent}"] if name == "agent" else []
    assert report.notes == (*own, "a note", *([NOTED[name]] if name in NOTED else []))
    others = frozenset(OPTIONAL) - {name}
    with pytest.raises(InputError, match=f"--{name}: trial cannot use it; its options: --worlds"):
        replace(make(accepts=others), run=never).report(EVERYTHING[name])


@pytest.mark.parametrize(
    ("changed", "options", "words"),
    [
        ({}, Options(seed=-1), "--seed: -1; give a whole number"),
        ({}, Options(ablation="size"), "--ablation size: trial has none"),
        ({"worlds": ()}, Options(worlds=(3,)), "--worlds: trial runs in no world; leave it out"),
        ({"worlds": (7,)}, Options(worlds=(3, 4)), r"--worlds: trial runs in a single one; .*A\+1"),
        ({}, Options(map=Path("x"), worlds=(3,)), "--map: .*leave out --worlds"),
        ({}, Options(map=Path("x"), palette="shifted"), "--palette: .*leave out --map"),
        ({}, Options(region=(1.0, 2.0)), "--region: .*give --map"),
    ],
)
def test_what_would_have_no_effect_is_refused_before_anything_is_run(changed, options, words):
    experiment = make(accepts=frozenset({"map", "palette"}), run=never, **changed)
    with pytest.raises(InputError, match=words):
        experiment.report(options)


def test_an_ablation_has_its_own_worlds_settings_and_options():
    size = Experiment("by_size", run, (1, 2), settings=3)
    whole = make(run=never, accepts=frozenset({"map"}), ablations={"size": size})
    report = whole.report(Options(ablation="size", quick=True))
    assert (report.name, report.worlds, report.quick) == ("by_size", (1, 2), True)
    assert report.rows == [{"worlds": (1, 2), "settings": 3}]
    with pytest.raises(InputError, match="--map: by_size cannot use it"):
        whole.report(Options(ablation="size", map=Path("depot.yaml")))
    with pytest.raises(InputError, match="--ablation shape: trial has size"):
        whole.report(Options(ablation="shape"))


ENTRIES = {**EXPERIMENTS, **BENCHMARKS}
ABLATIONS = {
    f"{name} {key}": ablation
    for name, entry in ENTRIES.items()
    for key, ablation in entry.ablations.items()
}


@pytest.mark.parametrize("entry", [*ENTRIES.values(), *ABLATIONS.values()], ids=lambda e: e.name)
def test_every_entry_declares_settings_and_worlds_of_its_own(entry):
    assert type(entry.settings).__name__ == "Settings"
    assert "Attributes:" in type(entry.settings).__doc__
    assert isinstance(entry.quick_settings, type(entry.settings) | None)
    assert entry.quick_settings != entry.settings
    assert set(entry.quick_worlds) <= set(entry.worlds)
    assert entry.accepts <= OPTIONAL
    for name in OPTIONAL - entry.accepts:
        with pytest.raises(InputError, match=f"^--{name}: {entry.name} cannot use it"):
            replace(entry, run=never).report(EVERYTHING[name])


def test_commands_and_their_ablations_are_those_of_the_design():
    assert list(BENCHMARKS) == ["raycast", "fleet", "control", "reachability", "map", "explore"]
    figures = {f"meng_fig{number}" for number in (4, 5, 6, 7, 8, 9, 10, 11, 12, 13)}
    tables = {"plans", "meng_table1", "meng_table2", "calibration", "disturbances", "faults"}
    nts = {"nts_wayfinding", "nts_scores", "nts_table1", "nts_table2", "nts_fig8", "nts_figs"}
    nts |= {"nts_second_visit"}
    ltvn = {"ltvn_label", "ltvn_model", "ltvn_lifelong", "ltvn_spurious", "ltvn_change"}
    ltvn |= {"ltvn_finetune", "ltvn_size"}
    assert set(EXPERIMENTS) == figures | tables | nts | ltvn | {"race"}
    assert set(ABLATIONS) == {
        "meng_table1 smoothing",
        "meng_table2 goal_images",
        "meng_table2 thresholds",
        "meng_fig12 localization",
        "calibration audit",
        "nts_table1 geometry",
        "nts_table2 geometry",
        "nts_fig8 geometry",
        "nts_figs geometry",
        "nts_second_visit geometry",
        "nts_table1 rules",
        "nts_table2 rl",
        "nts_fig8 exact",
        "ltvn_lifelong meng",
        "ltvn_lifelong parts",
        "race car",
        "race carried",
        "race changed",
        "race exact",
        "race ingredients",
        "race toured",
    }
