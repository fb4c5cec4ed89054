"""Classes of one's own: what each seam needs is said, and a fault costs only one's own rows."""

import json
import sys
from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import joblib
import numpy as np
import pytest

from tests.conftest import in_turn, make_box
from tutorial_lib.cli import main
from tutorial_lib.commands import experiment
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.common.agents import SEAMS, custom
from tutorial_lib.experiments.common.own import MEMBERS, guarded, load_own, load_robot
from tutorial_lib.experiments.common.report import Options
from tutorial_lib.experiments.meng2020 import table1, table2
from tutorial_lib.experiments.meng2020.table2 import METHODS
from tutorial_lib.experiments.nts import table1 as nts_table1
from tutorial_lib.experiments.protocols import exploration, local_control, navigation
from tutorial_lib.experiments.registry import EXPERIMENTS
from tutorial_lib.world.bodies import BicycleCar, DifferentialDrive
from tutorial_lib.world.plan_json import save_plan
from tutorial_lib.world.sensors import Camera

CONTROLLER = """
from tutorial_lib.driving import RMPController


class Mine:
    def __init__(self):
        self.usual = RMPController()

    def act(self, observations, waypoints):
        return self.usual.act(observations, waypoints)
"""
PREDICTOR = """
from tutorial_lib.learning import WaypointNetwork


class Mine:
    def __init__(self):
        self.usual = WaypointNetwork("waypoint_k2")
        self.view, self.k = self.usual.view, self.usual.k

    def prepare(self, contexts):
        return self.usual.prepare(contexts)

    def predict(self, observations, targets):
        return self.usual.predict(observations, targets)
"""
LOCAL = """
from tutorial_lib.learning import DirectNetwork


class Mine:
    def __init__(self):
        self.usual = DirectNetwork("direct_k2")
        self.view, self.k = self.usual.view, self.usual.k

    def prepare(self, contexts):
        return self.usual.prepare(contexts)

    def act(self, observations, targets):
        return self.usual.act(observations, targets)
"""
EXPLORER = """
import numpy as np


class Mine:
    def start(self, goals):
        self.rng = np.random.default_rng(0)

    def act(self, observations, running):
        return self.rng.integers(1, 4, len(observations))
"""
SAME = {
    "predictor": (PREDICTOR, "k2"),
    "local": (LOCAL, "direct"),
    "controller": (CONTROLLER, "k5"),
}
"""Classes that do what a row of Table I does."""


@pytest.fixture
def own(tmp_path):
    """Writes a user's file; returns the option that names its class."""

    def write(text):
        (tmp_path / "own.py").write_text(text)
        return f"{tmp_path / 'own.py'}:Mine"

    return write


@pytest.mark.parametrize("seam", MEMBERS)
def test_a_class_is_what_its_members_make_it(own, seam):
    assert load_own(own(class_of(MEMBERS[seam])), [seam])[0] == seam


def test_a_whole_system_is_no_part_of_another_one(own):
    for whole, part in (("explorer", "controller"), ("agent", "explorer")):
        both = MEMBERS[part] | MEMBERS[whole]
        with pytest.raises(InputError, match=f"is an {whole}, with .*compares what is a {part}$"):
            load_own(own(class_of(both)), [part])


def test_what_cannot_be_made_without_arguments_is_told_so(own):
    for text, words in (
        ("class Mine:\n    def __init__(self, weights): ...\n", r"takes \(weights\); give them"),
        ("Mine = 3\n", "Mine is 3; give the class itself"),
    ):
        with pytest.raises(InputError, match=words):
            load_own(own(text), ["explorer"])


def class_of(members):
    """A class with these members, whose methods take what is said."""
    lines = (
        f"    {name} = 0\n" if takes is None else f"    def {name}(self, {takes}): ...\n"
        for name, takes in members.items()
    )
    return f"class Mine:\n{''.join(lines)}"


@pytest.mark.parametrize("seam", MEMBERS)
@pytest.mark.parametrize(
    ("change", "words"), [("fewer", "is called"), ("more", "is called"), ("none", "is 0; make it")]
)
def test_a_method_that_cannot_be_called_as_it_will_be_is_refused_by_name(
    own, seam, change, words, monkeypatch
):
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # files of one second and size
    for name, takes in MEMBERS[seam].items():
        if takes is not None:
            fewer = ", ".join(["*", *takes.split(", ")[1:], "view=0"])
            wrong = {"fewer": fewer, "more": f"{takes}, floor", "none": None}[change]
            where = own(class_of(MEMBERS[seam] | {name: wrong}))
            with pytest.raises(InputError, match=f"{name} of this {seam} {words}"):
                load_own(where, [seam])


@pytest.mark.parametrize(("seam", "member"), [("explorer", "look_for"), ("reachability", "embed")])
def test_a_method_that_is_not_needed_is_checked_where_there_is_one(own, seam, member):
    with pytest.raises(InputError, match=f"{member} of this {seam} is called with"):
        load_own(own(class_of(MEMBERS[seam] | {member: "*, now=0"})), [seam])


WRAPPED = """
from functools import wraps


def with_speed(method):
    @wraps(method)
    def call(self, *arguments):
        return method(self, 0.5, *arguments)

    return call


class Mine:
    @with_speed
    def act(self, speed, observations, waypoints): ...
"""
DYNAMIC = """
class Any:
    def __getattr__(self, name):
        return self

    def __call__(self, *_): ...


class Mine:
    act = Any()
"""


@pytest.mark.parametrize("text", [WRAPPED, DYNAMIC])
def test_methods_of_another_making_are_taken(own, text):
    assert load_own(own(text), ["controller"])[0] == "controller"


def test_a_class_may_take_more_than_it_is_given_and_use_modules_beside_it(
    own, tmp_path, monkeypatch
):
    monkeypatch.setattr("sys.path", [*sys.path])
    (tmp_path / "beside_it.py").write_text("LIMIT = 0.6\n")
    text = "from beside_it import LIMIT\n\n\nclass Mine:\n    limit = LIMIT\n"
    where = own(text + "    def plan(self, *all, least=LIMIT): ...\n")
    assert load_own(where, ["planner"])[1].limit == 0.6


def test_a_wrong_class_is_told_what_each_seam_needs(own):
    where = own("class Mine:\n    view = 0\n    def predict(self, *_): ...\n")
    for load, seams in ((table1.custom, table1.SEAMS), (custom, SEAMS)):
        with pytest.raises(InputError) as error:
            load(where)
        words = str(error.value)
        for seam in seams:
            assert f"{seam}: {', '.join(MEMBERS[seam])}" in words
        assert words.endswith("; as predictor it lacks k, prepare")
    with pytest.raises(InputError, match=r"no component \(explorer: start, act\)$"):
        load_own(where, ["explorer"])


def test_controllers_and_predictors_drive_a_whole_system_too(own):
    assert type(custom(own(CONTROLLER)).controller).__name__ == "Mine"
    assert type(custom(own(PREDICTOR)).predictor).__name__ == "Mine"


@pytest.fixture(scope="module")
def clean():
    """What makes the condition without noise; the same one is made once."""
    made = cache(local_control.clean_condition)
    return lambda place, count, options: made(place, count, Options(seed=options.seed))


@pytest.fixture
def few(clean, monkeypatch):
    """Table I of one small world and one condition, with the rows that are compared here."""
    every = table1.controllers

    def some(seed):
        return {name: every(seed)[name] for name in ("direct", "k2", "k5")}

    monkeypatch.setattr(table1, "for_each", in_turn)
    monkeypatch.setattr(table1, "controllers", some)
    monkeypatch.setattr(table1, "conditions", lambda *given: {"clean": clean(*given)})
    return replace(table1.EXPERIMENT, quick_settings=table1.Settings(episodes=4))


@pytest.mark.parametrize("seam", SAME)
@pytest.mark.few(1)
def test_a_part_of_ones_own_has_a_row_of_table_1(own, few, seam):
    text, twin = SAME[seam]
    report = few.report(Options(worlds=(10_001,), quick=True, agent=own(text)))
    rows = {(row.pop("controller"), row["condition"]): row for row in report.rows}
    assert not report.failed
    mine, other = rows["custom", "clean"], rows[twin, "clean"]
    assert mine["paper"] is None
    for name in set(mine) - {"paper"}:
        assert mine[name] == other[name], name
    assert any(gap.what == "k5 - custom, clean" for gap in report.findings)


def test_a_fault_in_table_1_costs_its_own_rows_only(own, few, capsys):
    where = own(CONTROLLER.replace("return self.usual.act(observations", "return self.us.act(obs"))
    report = few.report(Options(worlds=(10_001,), quick=True, agent=where))
    assert {row["controller"] for row in report.rows} == {"direct", "k2", "k5"}
    assert report.failed
    said = f"--agent {where}: own.py, line 10: AttributeError: 'Mine' object has no attribute 'us'"
    assert said in report.notes
    assert f"error: {said}; the other rows go on" in capsys.readouterr().err
    assert said in json.loads(json.dumps(report.as_dict()))["notes"]


@pytest.mark.few(1)
def test_what_is_refused_after_it_was_returned_is_said_of_the_method_that_returned_it(own, few):
    text = CONTROLLER.replace("return self", "return float('nan') * self")
    report = few.report(Options(worlds=(10_001,), quick=True, agent=own(text)))
    assert f"--agent {own(text)}: own.py, line 9, after act: actions: nan; give" in str(
        report.notes[-1]
    )


def test_what_the_library_refuses_before_any_method_was_called_names_no_line(own):
    where = own(CONTROLLER)
    part = load_own(where, ["controller"])[1]

    def refuse():
        raise InputError("demo: the map is too small")

    with pytest.raises(InputError, match=r":Mine: demo: the map is too small$"):
        guarded(where, refuse)
    part.usual = SimpleNamespace(act=lambda *_: None)
    assert part.act(None, None) is None
    with pytest.raises(InputError, match=r":Mine: own.py, line 9, after act: demo: the map is"):
        guarded(where, refuse)
    load_own(where, ["controller"])
    with pytest.raises(InputError, match=r":Mine: demo: the map is too small$"):
        guarded(where, refuse)


def test_an_error_of_the_library_that_a_method_met_names_the_line(own):
    text = """
from tutorial_lib.interfaces import Plan


class Mine:
    def plan(self, *_):
        return Plan(probabilities=(float("nan"),))
"""
    where = own(text)
    part = load_own(where, ["planner"])[1]
    with pytest.raises(InputError, match=r":Mine: own.py, line 7: probabilities: nan; give"):
        guarded(where, part.plan)


BODY = """
import math; from tutorial_lib.world import BicycleCar, Camera, DifferentialDrive


class Mine(DifferentialDrive): ...


def small():
    return BicycleCar(wheelbase=0.2)


def wrong():
    return BicycleCar(wheelbase=-1.0)


def number():
    return 3


def narrow():
    return BicycleCar(), Camera(field_of_view=math.radians(90))


def odd():
    return BicycleCar(), Camera(field_of_view=1.5)


def sharp():
    return BicycleCar(), Camera(rows=64)


def blind():
    return BicycleCar(), None


def three():
    return BicycleCar(), Camera(), 3
"""


def test_a_body_of_ones_own_is_what_a_class_or_a_function_makes(own):
    file = own(BODY).removesuffix("Mine")
    body, camera = load_robot(f"{file}Mine")
    assert isinstance(body, DifferentialDrive)
    assert camera == Camera()
    assert load_robot(f"{file}small") == (BicycleCar(wheelbase=0.2), Camera())
    narrow = Camera(field_of_view=float(np.deg2rad(90.0)))
    assert load_robot(f"{file}narrow") == (BicycleCar(), narrow)
    for name, words in (
        ("wrong", r"own\.py, line 13: wheelbase: -1\.0; give one real number above 0"),
        ("number", "made 3; give what makes a BicycleCar or a DifferentialDrive"),
        ("none", "own.py has no none"),
        ("odd", r"camera: 85\.9437 degrees; give a field_of_view of whole degrees"),
        ("sharp", "rows=64.*differ from the usual one in its field_of_view alone"),
        ("blind", "camera: None; give a Camera"),
        ("three", "made .*; give what makes .*, or a pair of such a body and a Camera"),
    ):
        with pytest.raises(InputError, match=rf"^--robot .*own\.py:{name}: .*{words}"):
            load_robot(f"{file}{name}")


@pytest.mark.full
def test_an_explorer_of_ones_own_is_compared_and_a_fault_costs_its_own_rows_only(own, monkeypatch):
    monkeypatch.setattr(exploration, "for_each", in_turn)
    settings = nts_table1.Settings(1, ("oracle",), (), geometry=True)
    rows, notes = nts_table1.run(Options(worlds=(10_100,), agent=own(EXPLORER)), settings)
    agents = [row["agent"] for row in rows]
    assert agents.count("custom") == agents.count("oracle") == 6
    assert {row["sensor"] for row in rows} == {"rgbd"}
    mine = [row for row in rows if row["agent"] == "custom"]
    assert all(row["spl"] <= row["success"] for row in mine)
    assert np.mean([row["success"] for row in mine]) < 1.0
    where = own(EXPLORER.replace("self.rng.integers", "self.r.integers"))
    rows, notes = nts_table1.run(Options(worlds=(10_100,), agent=where), settings)
    assert {row["agent"] for row in rows} == {"oracle"}
    assert [note for note in notes if "own.py, line 10: AttributeError" in str(note)]


@pytest.mark.full
def test_a_fault_in_table_2_costs_its_own_rows_only_and_is_the_exit_code(
    own, tmp_path, monkeypatch, capsys
):
    save_plan(make_box(), tmp_path / "room.json")
    monkeypatch.setattr(navigation, "GRACE", 1.0)
    monkeypatch.setattr(table2, "for_each", in_turn)
    settings = table2.Settings(places_on_map=3, trials=2, trials_of_part=2)
    few = replace(table2.EXPERIMENT, quick_settings=settings)
    monkeypatch.setitem(experiment.EXPERIMENTS, "meng_table2", few)
    where = own("class Mine:\n    def learn(self, experiences): ...\n    start = None\n")
    command = ["experiment", "meng_table2", "--quick", "--map", str(tmp_path / "room.json")]
    assert main([*command, "--agent", where]) == 2
    out, err = capsys.readouterr()
    assert all(
        f" {name} " in line for name, line in zip(METHODS, out.splitlines()[2:6], strict=True)
    )
    assert " custom " not in out
    assert f"--agent {where}: TypeError: 'NoneType' object is not callable" in out
    assert "the other rows go on" in err
    assert f" {float(table2.QUICK_DRIVES):g} " in out  # a part of the drives, where agents differ


TAKING = [
    one
    for experiment in EXPERIMENTS.values()
    for one in (experiment, *experiment.ablations.values())
    if "agent" in one.accepts
]


@pytest.mark.parametrize("experiment", TAKING, ids=lambda experiment: experiment.name)
def test_a_class_that_cannot_be_loaded_is_refused_before_any_work(experiment, monkeypatch):
    def work(*_):
        raise AssertionError("work was begun")

    monkeypatch.setattr(joblib.Parallel, "__call__", work)
    for given, said in (("nofile.py:Mine", "there is no file"), ("mine.txt", "FILE.py:CLASS")):
        with pytest.raises(InputError, match=said):
            experiment.report(Options(agent=given, quick=True))
