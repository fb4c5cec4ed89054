import errno
import json
import os
import re
import select
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.conftest import in_turn, make_box
from tutorial_lib.cli import main
from tutorial_lib.commands import demo
from tutorial_lib.commands.lab import lab_arguments
from tutorial_lib.course import CHECKOUT, cache_folder
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.benchmarks import fleet, raycast
from tutorial_lib.experiments.demos import navigation_demo, place_people, recorder
from tutorial_lib.experiments.demos.learned_map import SHIPPED
from tutorial_lib.experiments.demos.outcome import Outcome
from tutorial_lib.experiments.registry import BENCHMARKS, EXPERIMENTS
from tutorial_lib.experiments.robustness import plans
from tutorial_lib.world.generators import generate
from tutorial_lib.world.plan_json import save_plan
from tutorial_lib.world.scene import Scene


def end_at_once(*_):
    """A worker that ends, as one that the system kills."""
    import os

    os._exit(9)


OUTPUTS = ("demo.json", "demo.png", "demo.webm")


@pytest.fixture(autouse=True)
def _in_a_folder_of_its_own(tmp_path, tmp_path_factory, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("TUTORIAL_CACHE", str(tmp_path_factory.mktemp("cache")))


def test_the_demo_navigates_by_sight_beside_an_oracle_on_the_same_task(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(recorder, "EVERY", 20)  # fewer frames
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
    assert film.get(cv2.CAP_PROP_FRAME_COUNT) > saved["seconds"] / 2
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


def save_hall(folder):
    """A ROS map of a hall of 10 x 8 m with a block in it."""
    image = np.full((160, 200), 254, np.uint8)
    image[[0, -1]] = image[:, [0, -1]] = 0
    image[60:100, 80:90] = 0
    cv2.imwrite(str(folder / "hall.png"), image)
    text = "image: hall.png\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\n"
    (folder / "hall.yaml").write_text(text + "occupied_thresh: 0.65\nfree_thresh: 0.196\n")
    return folder / "hall.yaml"


@pytest.mark.full
def test_the_demo_drives_on_a_map_of_the_user_s(tmp_path, monkeypatch, capsys):
    save_hall(tmp_path)
    monkeypatch.setattr(navigation_demo, "PLACES", 3)
    monkeypatch.setattr(recorder, "EVERY", 20)
    shipped = {file: file.read_bytes() for file in SHIPPED.iterdir()}
    code = main(["demo", "--map", "hall.yaml", "--learn"])
    saved = json.loads((tmp_path / "demo.json").read_text())
    assert saved["oracle"] is None
    assert code == (0 if saved["reached"] else 1)
    said = capsys.readouterr().out
    assert re.search(r"learning a map from \d+ (of \d+ )?drives, \d+ m, about \d+ s", said)
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
        "--explore --robot mine.py:small": "--robot: the demo cannot use it with --explore",
        "--robot mine.py:small": "--robot mine.py:small: there is no file mine.py",
        "--life --agent mine.py:Planner": "--agent: the demo cannot use it with --life",
        "--agent mine.py:Planner": "--agent mine.py:Planner: there is no file mine.py",
        "--start 1,2": "--start 1,2: give x,y,heading in metres and radians",
        "--start=": "--start : give x,y,heading in metres and radians, or a room",
        "--goal ballroom": "--goal: no room is called 'ballroom'; there are hallway",
        "--explore --goal ballroom": "--goal: no room is called 'ballroom'; there are",
        "--explore --start 900,0,0": "--start: at (900.00, 0.00) heading 0.00",
        "--family castle": "castle",
    }.items():
        assert main(["demo", *arguments.split()]) == 2
        assert words in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


OWN = """from tutorial_lib.topology import DijkstraPlanner

class Whole:
    def __init__(self):
        self.learn = self.start = print

class Planner(DijkstraPlanner):
    def plan(self, *arguments):
        print("mine plans")
        return super().plan(*arguments)

class Faulty:
    def plan(self, *arguments):
        return 1 / 0
"""


def test_a_whole_agent_is_not_filmed(tmp_path, capsys):
    (tmp_path / "mine.py").write_text(OWN)
    assert main(["demo", "--agent", "mine.py:Whole"]) == 2
    assert "mine.py:Whole: a whole agent, whose plans the film cannot" in capsys.readouterr().err


@pytest.mark.full
def test_a_planner_of_ones_own_is_filmed_on_the_usual_task(tmp_path, capsys):
    (tmp_path / "mine.py").write_text(OWN)
    assert main(["demo"]) == 0
    usual = json.loads((tmp_path / "demo.json").read_text())
    assert main(["demo", "--agent", "mine.py:Planner"]) == 0
    said = capsys.readouterr().out
    assert "mine plans" in said
    assert "by sight, with mine.py:Planner: reached the goal" in said
    assert json.loads((tmp_path / "demo.json").read_text()) == usual
    assert main(["demo", "--agent", "mine.py:Faulty"]) == 2
    assert "--agent mine.py:Faulty: mine.py, line 14: ZeroDivisionError" in capsys.readouterr().err
    assert json.loads((tmp_path / "demo.json").read_text()) == usual


def test_a_missed_goal_sets_the_exit_code(monkeypatch, capsys):
    ending, ends = "stopped 3.0 m from the goal, believing 89.9%", ((0, 0, 0), (5, 0, 0))
    missed = Outcome(
        *(False, ending, False, 9.0, 2.0, "demo", "box 0", 0, ("open", "open"), 0, *ends),
        *(5.0, "BicycleCar()", "Camera()", 2, 0.9, 1, 8, 2, None, 30, 60),
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
        (["demo", "--region", "1,2"], "--region: is that of a map's file; give --map"),
        (
            ["experiment", "plans", "--region", "1,2"],
            "--region: is that of a map's file; give --map",
        ),
        (["demo", "--map", "small.json", "--region", "1,2"], "small.json is no ROS map"),
        (["bench", "fleet", "--quick", "--json", "nowhere/x.json"], "existing folder"),
        (["train", "waypoint", "--k", "sptm"], "--k sptm; give one of 0, 2, 5, direct, laser"),
        (["train", "reachability", "--k", "direct"], "give one of 0, 2, 5, laser, sptm"),
        (["experiment", "calibration", "--ablation", "smoothing"], "calibration has audit"),
        (["experiment", "meng_table1", "--ablation", "audit"], "meng_table1 has smoothing"),
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
        (["build", "--students", "--slides", "x"], "build: --students writes no slides; give"),
        (["build", "99_nothing"], "build: no solutions/99_nothing.py; there are 00_start_here"),
        (["experiment", "meng_table2", "--agent", "x.py"], "give FILE.py:CLASS"),
        (["experiment", "meng_table2", "--ablation", "smoothing"], "meng_table2 has thresholds"),
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


@pytest.mark.parametrize("text", ["1", "1,2,3", "a,b"])
def test_a_region_that_is_none_is_refused(capsys, text):
    for command in (["demo"], ["experiment", "plans"]):
        with pytest.raises(SystemExit) as stopped:
            main([*command, "--map", "map.yaml", "--region", text])
        assert stopped.value.code == 2
        assert "give x0,y0,x1,y1 or x,y in metres" in capsys.readouterr().err


def two_rooms(folder):
    """A ROS map of rooms of 4 x 3 m and 6 x 4 m left of the origin, whose picture was moved."""
    image = np.full((100, 260), 205, np.uint8)
    image[10:70, 10:90] = image[10:90, 100:220] = 254
    cv2.imwrite(str(folder / "site.png"), image)
    text = "image: /elsewhere/site.png\nresolution: 0.05\norigin: [-13, 0, 0]\nnegate: 0\n"
    (folder / "site.yaml").write_text(text + "occupied_thresh: 0.65\nfree_thresh: 0.196\n")


@pytest.mark.parametrize(
    ("region", "area"),
    [("-12,3", 12.0), ("-5,3", 24.0), ("-8.001,0,0,9", 24.0), ("-13,2,-8,4.1", 4 * 2.1)],
)
def test_a_region_is_chosen_from_the_command_line_and_notices_are_lines(
    tmp_path, monkeypatch, capsys, region, area
):
    def make_plan(*arguments, **choice):
        found.append(real(*arguments, **choice))
        return found[-1]

    found, real = [], plans.make_plan
    monkeypatch.setattr(plans, "make_plan", make_plan)
    monkeypatch.setattr(plans, "for_each", in_turn)
    two_rooms(tmp_path)
    assert main(["experiment", "plans", "--map", "site.yaml", "--region", region]) == 0
    assert {round(plan.area, 6) for plan in found} == {area}
    said = capsys.readouterr()
    assert said.err == (
        "note: site.yaml: image: '/elsewhere/site.png' is not there; took 'site.png' beside it\n"
    )
    assert f"region: {region.replace(',', ', ')}" in said.out


def test_the_demo_drives_in_the_region_that_was_chosen(tmp_path, monkeypatch, capsys):
    def run_demo(plan, *_, **__):
        areas.append(plan.area)
        raise InputError("that is enough")

    areas = []
    monkeypatch.setattr(navigation_demo, "run_demo", run_demo)
    two_rooms(tmp_path)
    for region in ([], ["--region", "-12,3"]):
        assert main(["demo", "--map", "site.yaml", *region]) == 2
    assert areas == pytest.approx([36.0, 12.0])
    assert capsys.readouterr().err.count("note: site.yaml") == 2


@pytest.mark.parametrize(
    "error",
    [
        MemoryError(),
        MemoryError("Unable to allocate 7.28 TiB for an array"),
        RuntimeError("[enforce fail] DefaultCPUAllocator: can't allocate memory: you tried"),
        cv2.error("OpenCV(5.0.0) error: (-4:Insufficient memory) Failed to allocate 9 bytes"),
    ],
)
def test_memory_that_ran_out_is_one_line(monkeypatch, capsys, error):
    def fail(*_, **__):
        raise error

    monkeypatch.setattr(plans, "for_each", fail)
    assert main(["experiment", "plans"]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"error: memory ran out ({type(error).__name__}:")
    assert said.endswith("; close other programs, or give a smaller map or fewer worlds\n")
    assert said.count("\n") == 1


def test_a_fault_of_the_library_keeps_its_traceback(monkeypatch):
    def fail(*_, **__):
        raise RuntimeError("a fault")

    monkeypatch.setattr(plans, "for_each", fail)
    with pytest.raises(RuntimeError, match="a fault"):
        main(["experiment", "plans"])


@pytest.mark.full
def test_a_worker_that_the_system_ended_is_one_line(capsys, monkeypatch):
    monkeypatch.setattr(plans, "examine", end_at_once)
    assert main(["experiment", "plans", "--worlds", "10500:10501", "--family", "maze"]) == 2
    said = capsys.readouterr().err
    assert said.startswith("error: plans: a worker process was ended from outside")
    assert said.count("\n") == 1


PIPED = """
import sys
from tutorial_lib import cli
from tutorial_lib.commands import progress
from tutorial_lib.commands.demo import Narrator

def run(options):
    with Narrator() as say:
        for number in range(10_000):
            say(f"line {number}")
    return 0

progress.run = run
sys.exit(cli.main(["progress", *sys.argv[1:]]))
"""


@pytest.mark.skipif(os.name == "nt", reason="pipes end otherwise on Windows")
@pytest.mark.parametrize(
    ("arguments", "lines", "merged"),
    [([], 1, False), ([], 1, True), ([], 0, True), (["--help"], 0, False)],
)
@pytest.mark.parametrize("unbuffered", ["", "1"])
@pytest.mark.few(2)
def test_a_reader_that_ends_early_is_no_full_disk(
    arguments, lines, merged, unbuffered, monkeypatch
):
    monkeypatch.setenv("PYTHONUNBUFFERED", unbuffered)
    with subprocess.Popen(
        [sys.executable, "-c", PIPED, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT if merged else subprocess.PIPE,
    ) as running:
        for _ in range(lines):
            assert b"line 0" in running.stdout.readline()
        running.stdout.close()
        said = b"" if merged else running.stderr.read()
        code = running.wait(60)
    # argparse itself says nothing of help that it cannot print at once.
    assert code == (0 if arguments and unbuffered else 141)
    assert said == b""


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="there is no full device")
def test_a_full_disk_is_still_one():
    with open("/dev/full", "w") as full:
        command = [sys.executable, "-c", PIPED]
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True)
    assert done.stderr.startswith("error: [Errno 28] No space left")
    assert done.stderr.splitlines()[0].endswith("check the folder and the disk space")


def test_another_pipe_that_is_closed_is_an_error(capsys, monkeypatch):
    def fail(*_, **__):
        raise BrokenPipeError(errno.EPIPE, "Broken pipe")

    monkeypatch.setattr(plans, "for_each", fail)
    assert main(["experiment", "plans"]) == 2
    assert "Broken pipe" in capsys.readouterr().err


@pytest.mark.parametrize("text", ["5", "5:5", "-1:3", "a:b", "9:3"])
def test_worlds_that_are_no_range_are_refused(capsys, text):
    with pytest.raises(SystemExit) as stopped:
        main(["experiment", "plans", f"--worlds={text}"])
    assert stopped.value.code == 2
    assert "give A:B" in capsys.readouterr().err


@pytest.mark.parametrize("last", [100_001, 10**20])
def test_too_many_worlds_are_refused(capsys, last):
    with pytest.raises(SystemExit):
        main(["experiment", "plans", f"--worlds=0:{last}"])
    assert "give at most 100,000 worlds" in capsys.readouterr().err


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
    monkeypatch.setattr(demo, "QUIET", 0.05)
    with demo.Narrator() as say:
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
from tutorial_lib.experiments.demos import navigation_demo
from tutorial_lib.viz.figures.dashboard import RolloutFilm

def stuck(*_):
    print("at work", flush=True)
    time.sleep(60)

navigation_demo.PLACES = 3
{what} = stuck
signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored where tests run with nohup or &
runpy.run_module("tutorial_lib", run_name="__main__")
"""


@pytest.mark.skipif(os.name == "nt", reason="SIGINT reaches a process group otherwise on Windows")
@pytest.mark.parametrize(
    ("what", "arguments", "ends_it"),
    [
        ("navigation_demo.agents.meng", [], signal.SIGINT),
        ("navigation_demo.agents.meng", [], signal.SIGTERM),
        ("RolloutFilm.__getitem__", ["--oracle"], signal.SIGINT),
    ],
)
@pytest.mark.full
def test_an_interrupted_demo_leaves_nothing_behind(
    tmp_path, tmp_path_factory, what, arguments, ends_it
):
    script = INTERRUPTED.format(what=what)
    hall = save_hall(tmp_path_factory.mktemp("hall"))
    with subprocess.Popen(
        [sys.executable, "-c", script, "demo", "--map", hall, *arguments],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        start_new_session=True,
    ) as running:
        try:
            assert select.select([running.stdout], [], [], 120)[0]
            assert b"at work\n" in iter(running.stdout.readline, b"")
            running.send_signal(ends_it)
            _, error = running.communicate(timeout=60)
        finally:
            running.kill()
    assert running.returncode == 130
    assert error.startswith(b"interrupted; no file is half-written. ")
    assert error.count(b"\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def few_drives(monkeypatch):
    """The experiment on plans in this process, with ten drives in each of them."""
    few = plans.Settings(goals=10)
    entry = replace(plans.EXPERIMENT, settings=few, quick_settings=few)
    monkeypatch.setitem(EXPERIMENTS, "plans", entry)
    monkeypatch.setattr(plans, "for_each", in_turn)


@pytest.mark.usefixtures("few_drives")
@pytest.mark.parametrize("family", ["hall", "scanned"])
@pytest.mark.few(1)
def test_experiment_plans_runs_in_the_family_asked_for(family, capsys):
    assert main(["experiment", "plans", "--worlds", "10502:10503", "--family", family]) == 0
    (row,) = [line.split() for line in capsys.readouterr().out.splitlines() if family in line][:1]
    assert row[:4] == [family, "1", "1", "10"]
    assert float(row[4]) >= 0.9
    assert row[5] == "0"


@pytest.mark.full
@pytest.mark.usefixtures("few_drives")
def test_experiment_plans_gives_a_row_for_every_family(tmp_path, capsys):
    arguments = ["experiment", "plans", "--worlds", "10500:10501", "--quick", "--json", "p.json"]
    assert main(arguments) == 0
    saved = json.loads((tmp_path / "p.json").read_text())
    assert {"name", "seed", "worlds", "quick", "seconds", "rows"} <= set(saved)
    assert saved["worlds"] == [10_500]
    assert [row["family"] for row in saved["rows"]] == list(plans.USUAL)
    for row in saved["rows"]:
        assert (row["plans"], row["valid"], row["drives"]) == (1, 1, 10)
        assert row["success"] >= 0.9
        assert row["walls_crossed"] == 0
    assert "walls_crossed" in capsys.readouterr().out


def test_bench_raycast_compares_every_method_at_every_size(tmp_path, monkeypatch):
    brief = replace(raycast.EXPERIMENT, quick_settings=raycast.Settings(seconds=0.02))
    monkeypatch.setitem(BENCHMARKS, "raycast", brief)
    assert main(["bench", "raycast", "--quick", "--json", "b.json"]) == 0
    rows = json.loads((tmp_path / "b.json").read_text())["rows"]
    assert {row["walls"] for row in rows} == {50, 120, 500, 5000}
    methods = {"pymunk", "numpy", "numba", "numba_single", "image16", "image64"}
    assert {row["method"] for row in rows} == methods
    assert len(rows) == 24
    assert all(row["frames_per_s"] > 0 for row in rows)


@pytest.mark.full
def test_bench_fleet_drives_the_same_trajectories_twice(tmp_path, monkeypatch):
    brief = replace(fleet.EXPERIMENT, quick_settings=fleet.Settings(rounds=3))
    monkeypatch.setitem(BENCHMARKS, "fleet", brief)
    assert main(["bench", "fleet", "--quick", "--json", "f.json"]) == 0
    saved = json.loads((tmp_path / "f.json").read_text())
    assert {row["method"] for row in saved["rows"]} == {"fleet", "separate"}
    assert all(row["cars"] == 256 for row in saved["rows"])
    apart = float(saved["notes"][0].split("at most ")[1].split(" m")[0])
    assert apart < 1e-6


def test_people_in_the_demo_stand_where_the_floor_is():
    scene = Scene(generate("apartment", 10_003))
    paths = GridPaths(scene.clearance)
    start, goal = paths.points[paths.largest][[0, -1]]
    people = place_people(paths.fields(goal).path(start), scene)
    assert len(people) == 2
    for person in people:
        assert scene.clearance.at(person.route).min() > 0.0
        assert np.linalg.norm(person.route - start, axis=1).min() > 0.5


@pytest.mark.parametrize(("user", "allowed"), [(0, True), (1000, False)])
def test_jupyterlab_opens_the_first_notebook_and_contacts_no_other_host(monkeypatch, user, allowed):
    monkeypatch.setattr(os, "geteuid", lambda: user, raising=False)
    line = lab_arguments(Path("a course"), ["--no-browser"])
    assert line[-1] == "--no-browser"
    assert "--ServerApp.root_dir=a course" in line
    assert "--LabApp.default_url=/lab/tree/notebooks/00_start_here.ipynb" in line
    assert "--LabApp.news_url=None" in line
    assert ("--allow-root" in line) == allowed


def test_given_arguments_of_jupyterlab_go_before_the_course_s():
    line = lab_arguments(Path("a course"), ["--ServerApp.root_dir=other", "--port=1"])
    assert [a for a in line if "root_dir" in a] == ["--ServerApp.root_dir=other"]
    assert "--LabApp.news_url=None" in line


def jupyterlab_that(monkeypatch, end):
    """JupyterLab replaced by one that ends at once; the arguments that it gets."""
    started = []
    monkeypatch.setattr("jupyterlab.labapp.main", lambda line: started.append(line) or end())
    monkeypatch.setenv("JUPYTER_CONFIG_PATH", "mine")
    return started


def test_lab_passes_the_exit_code_on(monkeypatch):
    started = jupyterlab_that(monkeypatch, lambda: sys.exit(7))
    with pytest.raises(SystemExit) as ended:
        main(["lab", "--port=1"])
    assert ended.value.code == 7
    assert started[0][-1] == "--port=1"


def test_lab_closed_by_its_user_is_no_error(monkeypatch):
    started = jupyterlab_that(monkeypatch, lambda: None)
    assert main(["lab"]) == 0
    assert f"--ServerApp.root_dir={CHECKOUT}" in started[0]


def test_lab_brings_its_settings_behind_the_user_s(monkeypatch):
    jupyterlab_that(monkeypatch, lambda: None)
    main(["lab"])
    mine, ours = os.environ["JUPYTER_CONFIG_PATH"].split(os.pathsep)
    assert mine == "mine"
    (file,) = Path(ours, "labconfig").glob("*.json")
    (settings,) = json.loads(file.read_text()).values()
    assert settings == {"fetchNews": "false", "checkForUpdates": False}
