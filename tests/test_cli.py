import json
import os
import re
import select
import signal
import subprocess
import sys
import time

import cv2
import numpy as np
import pytest

from tests.conftest import in_turn, make_box
from tutorial_lib.cli import main
from tutorial_lib.commands import narrator
from tutorial_lib.commands.lab import lab_command
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.experiments.demos import choose_places, navigation_demo, place_people, recorder
from tutorial_lib.experiments.demos.learned_map import SHIPPED
from tutorial_lib.experiments.demos.outcome import Outcome
from tutorial_lib.experiments.robustness import plans
from tutorial_lib.files import cache_folder
from tutorial_lib.world.generators import generate
from tutorial_lib.world.plan_json import save_plan
from tutorial_lib.world.scene import Scene

OUTPUTS = ("demo.json", "demo.png", "demo.webm")


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path, tmp_path_factory, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("TUTORIAL_CACHE", str(tmp_path_factory.mktemp("cache")))


def test_the_demo_navigates_by_sight_beside_an_oracle_on_the_same_task(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(recorder, "EVERY", 10)  # fewer frames
    assert main(["demo", "--oracle"]) == 0
    saved = json.loads((tmp_path / "demo.json").read_text())
    for drive in (saved, saved["oracle"]):
        assert drive["reached"]
        assert drive["ending"].startswith("reached the goal, 0.")
        assert drive["driven"] > 0.8 * saved["geodesic"] > 4.0
    assert saved["people"] == 2
    assert 0.5 < saved["probability"] < 1.0
    assert saved["edges"] > saved["vertices"] > 20
    film = cv2.VideoCapture(str(tmp_path / "demo.webm"))
    assert film.get(cv2.CAP_PROP_FRAME_COUNT) > saved["seconds"]
    high, wide, _ = film.read()[1].shape
    assert wide > 3 * high  # two dashboards
    assert cv2.imread(str(tmp_path / "demo.png")).std() > 10
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted(OUTPUTS)
    said = capsys.readouterr().out
    (shipped,) = SHIPPED.iterdir()
    assert saved["map"] == shipped.name
    assert f"loading the learned map {shipped.name}" in said
    assert f"composed of {saved['composed_of']} of {saved['drives']} learned drives" in said
    assert saved["composed_of"] >= 2
    assert said.index("driving by the oracle") < said.index("driving by sight")
    assert said.count("reached the goal") == 2


def test_the_demo_drives_on_a_map_of_the_user_s(tmp_path, monkeypatch, capsys):
    image = np.full((160, 200), 254, np.uint8)
    image[[0, -1]] = image[:, [0, -1]] = 0
    image[60:100, 80:90] = 0
    cv2.imwrite(str(tmp_path / "hall.png"), image)
    text = "image: hall.png\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\n"
    (tmp_path / "hall.yaml").write_text(text + "occupied_thresh: 0.65\nfree_thresh: 0.196\n")
    monkeypatch.setattr(navigation_demo, "PLACES", 3)
    shipped = {file: file.read_bytes() for file in SHIPPED.iterdir()}
    code = main(["demo", "--map", "hall.yaml", "--learn"])
    saved = json.loads((tmp_path / "demo.json").read_text())
    assert saved["oracle"] is None
    assert code == (0 if saved["reached"] else 1)
    said = capsys.readouterr().out
    assert re.search(r"learning a map from \d+ of 6 drives, \d+ m, about \d+ s", said)
    assert f"hall, from open to open:\n  by sight: {saved['ending']}, after" in said
    assert re.fullmatch(r"hall-[0-9a-f]{12}\.npz", saved["map"])
    kept = cache_folder() / "learned_maps" / saved["map"]
    assert f"kept as {kept}" in said
    assert kept.exists()
    assert {file: file.read_bytes() for file in SHIPPED.iterdir()} == shipped


def test_options_that_do_not_count_are_refused_by_name(tmp_path, capsys):
    for arguments, words in {
        "--map x.yaml --family maze": "--family: the demo cannot use it beside --map",
        "--explore --learn": "--learn: the demo cannot use it with --explore",
        "--start 1,2": "--start 1,2: give x,y,heading in metres and radians",
        "--goal ballroom": "--goal: no room is called 'ballroom'; there are hallway",
        "--explore --goal ballroom": "--goal: no room is called 'ballroom'; there are",
        "--explore --start 900,0,0": "--start: at (900.00, 0.00) heading 0.00",
        "--family castle": "castle",
    }.items():
        assert main(["demo", *arguments.split()]) == 2
        assert words in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_missed_goal_sets_the_exit_code(monkeypatch, capsys):
    ending, ends = "stopped 3.0 m from the goal, believing 89.9%", ((0, 0, 0), (5, 0, 0))
    missed = Outcome(
        *(False, ending, False, 9.0, 2.0, "demo", "box 0", 0, ("open", "open"), 0, *ends),
        *(5.0, 2, 0.9, 1, 8, 2, None, 30, 60),
    )
    monkeypatch.setattr(navigation_demo, "run_demo", lambda *_, **__: missed)
    assert main(["demo"]) == 1
    said = capsys.readouterr().out
    assert "by sight: stopped 3.0 m from the goal, believing 89.9%, after 9.0 s and 2.0 m" in said
    assert "composed of 2 of 8 learned drives; the map was not kept: --learn keeps it" in said


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["demo", "--map", "nowhere.yaml"], "nowhere.yaml"),
        (["demo", "--seed", "-1"], "seed"),
        (["bench", "fleet", "--seed", "-1"], "--seed"),
        (["demo", "--map", "broken.json"], "broken.json"),
        (["demo", "--map", "tiny.json"], "no place has"),
        (["demo", "--map", "small.json"], "larger map"),
        (["experiment", "plans", "--map", "tiny.json"], "no place has"),
        (["experiment", "plans", "--map", "."], "."),
        (["bench", "fleet", "--quick", "--json", "nowhere/x.json"], "existing folder"),
        (["train", "waypoint", "--k", "sptm"], "--k sptm; give one of 0, 2, 5, direct, laser"),
        (["train", "reachability", "--k", "direct"], "give one of 0, 2, 5, laser, sptm"),
        (["experiment", "calibration", "--ablation", "rows"], "calibration has audit"),
        (["experiment", "meng_table1", "--ablation", "audit"], "meng_table1 has encoder"),
        (["experiment", "meng_fig7", "--ablation", "audit"], "meng_fig7 has none"),
        (
            ["experiment", "calibration", "--map", "small.json"],
            "--map: calibration cannot use it; its options: --worlds",
        ),
        (
            ["experiment", "meng_fig5", "--map", "small.json"],
            "--map: meng_fig5 cannot use it; its options: --worlds",
        ),
        (
            ["experiment", "meng_fig6", "--map", "small.json"],
            "--map: meng_fig6 cannot use it; its options: --worlds",
        ),
        (
            ["experiment", "meng_fig7", "--map", "small.json"],
            "--map: meng_fig7 cannot use it; its options: --worlds",
        ),
        (["bench", "reachability", "--seed", "-1"], "--seed"),
        (
            ["experiment", "plans", "--palette", "shifted"],
            "--palette: plans cannot use it; its options: --worlds A:B, --map",
        ),
        (
            ["experiment", "meng_fig9", "--agent", "x.py:A"],
            "--agent: meng_fig9 cannot use it; its options: --worlds A:B",
        ),
        (["experiment", "meng_table2", "--agent", "x.py:A"], "there is no file x.py"),
        (["build", "99_nothing"], "build: no solutions/99_nothing.py; there are 00_start_here"),
        (["experiment", "meng_table2", "--agent", "x.py"], "give FILE.py:CLASS"),
        (["experiment", "meng_table2", "--ablation", "rows"], "meng_table2 has thresholds"),
        (["bench", "raycast", "--worlds", "1:3"], "--worlds: raycast runs in no world"),
        (["bench", "fleet", "--worlds", "1:3"], "--worlds: fleet runs in a single one"),
        (["bench", "map", "--worlds", "1:3"], "--worlds: map runs in a single one"),
        (["experiment", "meng_fig4", "--worlds", "1:3"], "--worlds: meng_fig4 runs in a single"),
    ],
)
def test_wrong_input_gets_one_line_and_leaves_nothing(
    tmp_path, capsys, monkeypatch, arguments, words
):
    monkeypatch.setattr(plans, "for_each", in_turn)
    (tmp_path / "broken.json").write_text('{"schema": 1, "walls": [')
    save_plan(make_box(0.5, 0.5), tmp_path / "tiny.json")
    save_plan(make_box(1.5, 1.5), tmp_path / "small.json")
    assert main(arguments) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ")
    assert words in error
    assert error.count("\n") == 1
    assert not any((tmp_path / name).exists() for name in OUTPUTS)


@pytest.mark.parametrize("text", ["5", "5:5", "-1:3", "a:b", "9:3"])
def test_worlds_that_are_no_range_are_refused(capsys, text):
    with pytest.raises(SystemExit) as stopped:
        main(["experiment", "plans", f"--worlds={text}"])
    assert stopped.value.code == 2
    assert "give A:B" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["train", "reachability", "--k", "7"], "--k"),
        (["train", "reachability"], "--k"),
        (["train", "wisdom", "--k", "2"], "wisdom"),
        (["experiment", "meng_fig99"], "meng_fig7"),
        (["experiment", "calibration", "--ablation", "temperature"], "audit"),
        (["bench", "reachability", "--map", "small.json"], "--map"),
        (["bench", "reachability", "--ablation", "audit"], "--ablation"),
    ],
)
def test_an_unknown_choice_is_refused_with_the_known_ones(capsys, arguments, words):
    with pytest.raises(SystemExit) as stopped:
        main(arguments)
    assert stopped.value.code == 2
    assert words in capsys.readouterr().err


@pytest.mark.parametrize(
    ("command", "lines"),
    [
        (
            "experiment",
            ["meng_table2 --worlds A:B --map --palette --family --agent --odometry --drives"],
        ),
        ("bench", ["raycast\n", "fleet --worlds A:A+1\n"]),
    ],
)
def test_the_help_shows_which_experiment_takes_which_options(capsys, command, lines):
    with pytest.raises(SystemExit) as stopped:
        main([command, "--help"])
    assert stopped.value.code == 0
    shown = "\n".join(" ".join(line.split()) for line in capsys.readouterr().out.splitlines())
    for line in lines:
        assert f"\n{line}" in shown


def test_commands_that_need_no_network_are_quick_to_start():
    script = "import sys; from tutorial_lib.cli import parse; parse(['{}']); print(*sys.modules)"
    for command in ("demo", "progress"):
        done = [sys.executable, "-c", script.format(command)]
        modules = subprocess.run(done, check=True, capture_output=True, text=True).stdout.split()
        assert not {"torch", "numba", "scipy", "matplotlib"} & {*modules}


def test_the_version_is_told(capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["--version"])
    assert stopped.value.code == 0
    assert capsys.readouterr().out.strip()


def test_work_that_takes_long_is_told_again_and_again(monkeypatch, capsys):
    monkeypatch.setattr(narrator, "QUIET", 0.05)
    with narrator.Narrator() as say:
        say("counting: 5 sheep")
        time.sleep(0.4)
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].endswith("0.0 s  counting: 5 sheep")
    assert len(lines) >= 3
    assert all(line.endswith(" s  still counting") for line in lines[1:])
    time.sleep(0.2)
    assert capsys.readouterr().out == ""  # it is over


INTERRUPTED = """
import runpy, signal, sys, time
from tutorial_lib.experiments.demos.navigation_demo import agents
from tutorial_lib.viz.figures.dashboard import RolloutFilm

def stuck(*_):
    print("at work", flush=True)
    time.sleep(60)

{what} = stuck
signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored where tests run with nohup or &
runpy.run_module("tutorial_lib", run_name="__main__")
"""


@pytest.mark.skipif(os.name == "nt", reason="SIGINT reaches a process group otherwise on Windows")
@pytest.mark.parametrize(
    ("what", "arguments"), [("agents.meng", []), ("RolloutFilm.__getitem__", ["--oracle"])]
)
def test_an_interrupted_demo_leaves_nothing_behind(tmp_path, what, arguments):
    script = INTERRUPTED.format(what=what)
    with subprocess.Popen(
        [sys.executable, "-c", script, "demo", *arguments],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
    ) as running:
        try:
            assert select.select([running.stdout], [], [], 120)[0]
            assert b"at work\n" in iter(running.stdout.readline, b"")
            running.send_signal(signal.SIGINT)
            _, error = running.communicate(timeout=60)
        finally:
            running.kill()
    assert running.returncode == 130
    assert error == b"interrupted; nothing half-written was left\n"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("family", ["hall", "scanned"])
def test_experiment_plans_runs_in_the_family_asked_for(family, capsys, monkeypatch):
    monkeypatch.setattr(plans, "for_each", in_turn)
    assert main(["experiment", "plans", "--worlds", "10502:10503", "--family", family]) == 0
    (row,) = [line.split() for line in capsys.readouterr().out.splitlines() if family in line][:1]
    assert row[:4] == [family, "1", "1", "20"]
    assert float(row[4]) >= 0.9
    assert row[5] == "0"


def test_experiment_plans_gives_a_row_for_every_family(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(plans, "for_each", in_turn)
    arguments = ["experiment", "plans", "--worlds", "10500:10501", "--quick", "--json", "p.json"]
    assert main(arguments) == 0
    saved = json.loads((tmp_path / "p.json").read_text())
    assert {"name", "seed", "worlds", "quick", "seconds", "rows"} <= set(saved)
    assert saved["worlds"] == [10_500]
    assert [row["family"] for row in saved["rows"]] == list(plans.USUAL)
    for row in saved["rows"]:
        assert (row["plans"], row["valid"], row["drives"]) == (1, 1, 20)
        assert row["success"] >= 0.9
        assert row["walls_crossed"] == 0
    assert "walls_crossed" in capsys.readouterr().out


def test_bench_raycast_compares_every_method_at_every_size(tmp_path, capsys):
    assert main(["bench", "raycast", "--quick", "--json", "b.json"]) == 0
    rows = json.loads((tmp_path / "b.json").read_text())["rows"]
    assert {row["walls"] for row in rows} == {50, 120, 500, 5000}
    methods = {"pymunk", "numpy", "numba", "numba_single", "image16", "image64"}
    assert {row["method"] for row in rows} == methods
    assert len(rows) == 24
    assert all(row["frames_per_s"] > 0 for row in rows)


def test_bench_fleet_drives_the_same_trajectories_twice(tmp_path, capsys):
    assert main(["bench", "fleet", "--quick", "--json", "f.json"]) == 0
    saved = json.loads((tmp_path / "f.json").read_text())
    assert {row["method"] for row in saved["rows"]} == {"fleet", "separate"}
    assert all(row["cars"] == 256 for row in saved["rows"])
    apart = float(saved["notes"][0].split("at most ")[1].split(" m")[0])
    assert apart < 1e-6


def test_people_in_the_demo_stand_where_the_floor_is():
    scene = Scene(generate("apartment", 10_003))
    paths = GridPaths(scene.clearance)
    start, goal, rooms, _ = choose_places(scene, paths, np.random.default_rng(0))
    path = paths.fields(goal).path(start[:2])
    people = place_people(path, scene)
    assert len(rooms) == len(people) == 2
    for person in people:
        assert scene.clearance.at(person.route).min() > 0.0
        assert np.linalg.norm(person.route - start[:2], axis=1).min() > 0.5


@pytest.mark.parametrize(("user", "allowed"), [(0, True), (1000, False)])
def test_jupyterlab_opens_the_first_notebook_and_contacts_no_other_host(monkeypatch, user, allowed):
    monkeypatch.setattr(os, "geteuid", lambda: user, raising=False)
    line = lab_command(["--no-browser"])
    assert line[:3] == [sys.executable, "-m", "jupyterlab"]
    assert line[-1] == "--no-browser"
    assert "--LabApp.default_url=/lab/tree/notebooks/00_start_here.ipynb" in line
    assert "--LabApp.news_url=None" in line
    assert ("--allow-root" in line) == allowed


def test_lab_passes_the_exit_code_on(monkeypatch):
    monkeypatch.setattr(subprocess, "call", lambda command: 7 if "--port=1" in command else 0)
    assert main(["lab", "--port=1"]) == 7
