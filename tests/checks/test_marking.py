"""A class with honest, mistaken and hostile answers, marked once; and the parts of marking."""

import csv
import json
import os
import pickle
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import networkx as nx
import numpy as np
import pytest

from tutorial_lib.checks.framework import my_answers
from tutorial_lib.checks.framework.check import Result
from tutorial_lib.checks.marking import wire
from tutorial_lib.checks.marking.handed_in import Student, students_in
from tutorial_lib.checks.marking.judging import Mark
from tutorial_lib.checks.marking.reports import (
    Marked,
    lines_of,
    read_weights,
    write_csv,
    write_json,
    write_pages,
)
from tutorial_lib.checks.marking.warden import spawning
from tutorial_lib.checks.marking.worker import all_checks, judge
from tutorial_lib.cli import main
from tutorial_lib.errors import InputError
from tutorial_lib.topology import FollowerSettings, State

linux = pytest.mark.skipif(sys.platform != "linux", reason="isolation is Linux's")
EXERCISES = ("01_compose", "01_to_local", "04_move_on")
RIGHT = """import numpy as np


def to_local(pose, points):
    gap = np.asarray(points, dtype=float) - np.asarray(pose[:2])
    c, s = np.cos(pose[2]), np.sin(pose[2])
    return np.stack([c * gap[..., 0] + s * gap[..., 1], c * gap[..., 1] - s * gap[..., 0]], axis=-1)
"""
WRONG = "def to_local(pose, points):\n    return points\n"
FRAMES = """import inspect
def to_local(pose, points):
    for frame in inspect.stack():
        for name, value in frame.frame.f_locals.items():
            if hasattr(value, "reference"):
                return value.reference(pose, points)
            if name in ("right", "want", "wanted", "expected"):
                return value(pose, points) if callable(value) else value
"""
GC = """import gc
def to_local(pose, points):
    for value in gc.get_objects():
        if getattr(type(value), "__name__", "") == "Check" and value.name == "to_local":
            return value.reference(pose, points)
    for value in gc.get_objects():
        if type(value) is type(to_local) and value.__name__ == "to_local" and value is not to_local:
            return value(pose, points)
"""
WIRE = """import os, pickle, sys
class Opens:
    def __reduce__(self):
        return os.mkdir, ("OUTSIDE/pickled",)
frame = sys._getframe()
while frame:
    connection = getattr(frame.f_locals.get("self"), "connection", None)
    if connection:
        connection.send_bytes(pickle.dumps(("returned", Opens(), None)))
    frame = frame.f_back
"""
OUTLIVES = """import atexit, subprocess, threading, time
def later(name):
    time.sleep(1)
    open("OUTSIDE/" + name, "w").write("x")
threading.Thread(target=later, args=("thread",)).start()
threading.Thread(target=later, args=("daemon",), daemon=True).start()
atexit.register(later, "exit")
late = ["setsid", "sh", "-c", "sleep 2; echo x > OUTSIDE/process"]
subprocess.Popen(late, start_new_session=True)
"""
DEAF = """import signal, time
for number in range(1, 65):
    try:
        signal.signal(number, signal.SIG_IGN)
    except (OSError, ValueError):
        pass
while True:
    try:
        time.sleep(100)
    except BaseException:
        pass
"""
STOPS, RUNS, ENDS = "your code stops with", "01_to_local.py does not run", "ends its process"
CASES = {
    "right": (RIGHT, "passed", ""),
    "wrong": (WRONG, "failed", "this needs only the shift"),
    # text
    "bom": ("\ufeff" + RIGHT, "passed", ""),
    "crlf": (RIGHT.replace("\n", "\r\n"), "passed", ""),
    "tabs": (RIGHT.replace("    ", "\t"), "passed", ""),
    "latin": (b"x = 'caf\xe9'\n" + RIGHT.encode(), "failed", f"{RUNS} (SyntaxError"),
    "nul": (RIGHT + "\0", "failed", f"{RUNS} (SyntaxError"),
    "syntax": ("def to_local(:\n", "failed", f"{RUNS} (SyntaxError"),
    "empty": ("", "failed", "defines no function to_local"),
    "huge": ("x = 1\n" * 1_000_000, "failed", "more than the 4 MB"),
    # ends
    "asks": (f"{RIGHT}\nx = input('pose? ')\n", "failed", f"{RUNS} (EOFError"),
    "exits": ("import os\nprint('right: 51 of 51 pass')\nos._exit(0)\n", "failed", ENDS),
    "leaves": ("raise SystemExit(0)\n", "failed", f"{RUNS} (SystemExit"),
    "interrupts": ("def to_local(*a):\n    raise KeyboardInterrupt\n", "failed", STOPS),
    "crashes": ("import ctypes\nctypes.string_at(0)\n", "failed", ENDS),
    "recursion": ("def to_local(*a):\n    return to_local(*a)\n", "failed", "RecursionError"),
    "deaf": (DEAF, "failed", "has not ended"),
    "memory": ("x = bytearray(10**10)\n", "failed", f"{RUNS} (MemoryError"),
    # falsifies
    "result": (
        "from tutorial_lib.checks.framework.check import Result\n"
        "def to_local(*a):\n    return Result('to_local', 'passed', '')\n",
        "failed",
        "a Result came back",
    ),
    "patches the guard": (
        "from tutorial_lib.checks.framework import check, guard\n"
        "guard.limited = lambda judge, student: None\n"
        "check.Check.__call__ = lambda self, student: check.Result('to_local', 'passed', '')\n"
        "def to_local(*a):\n    return None\n",
        "failed",
        "returned nothing",
    ),
    "patches numpy": (
        "import numpy as np\nnp.allclose = np.array_equal = np.isclose = lambda *a, **k: True\n"
        + WRONG,
        "failed",
        "this needs only the shift",
    ),
    "equals all": (
        "class Equal:\n    __eq__ = lambda self, other: True\n"
        "def to_local(*a):\n    return Equal()\n",
        "failed",
        "an Equal came back",
    ),
    "frames": (FRAMES, "failed", "returned nothing"),
    "gc": (GC, "failed", ""),
    "wire": (WIRE + WRONG, "failed", "no plain data"),
    "fds": ("import os\n[os.write(fd, b'x') for fd in (3,)]\n" + WRONG, "failed", ""),
    "closes": (f"import os\nos.closerange(0, 99)\n{RIGHT}", "failed", ENDS),
    "modules": (
        "import sys\nfor name in [n for n in sys.modules if 'tutorial' in n]:\n"
        f"    sys.modules[name] = None\n{WRONG}",
        "failed",
        "this needs only the shift",
    ),
    # spoils
    "outlives": (OUTLIVES + RIGHT, "passed", ""),
    "chdir": (f"import os\nos.chdir('/')\n{RIGHT}", "passed", ""),
    "loud": (f"print('x' * 10**6)\nprint('\\x1b[2J')\n{RIGHT}", "passed", ""),
    "disk": (
        "with open('big', 'wb') as f:\n    f.write(bytes(10**8))\n",
        "failed",
        f"{RUNS} (OSError",
    ),
    "escapes": (
        "def to_local(*a):\n    raise ValueError('\\x1b[2J\\nright: 51 of 51 pass')\n",
        "failed",
        STOPS,
    ),
    "forks": ("import os\nwhile True:\n    os.fork()\n", "failed", ""),
    "deletes": (
        f"import shutil\nshutil.rmtree('OUTSIDE', ignore_errors=True)\n{RIGHT}",
        "passed",
        "",
    ),
    "reads others": (
        "def to_local(*a):\n    text = open('CLASS/right/my_answers/01_to_local.py').read()\n"
        "    exec(text, globals())\n    return globals()['to_local'](*a)\n",
        "failed",
        STOPS,
    ),
    "zz last": (RIGHT, "passed", ""),
}
ISOLATED = {"reads others"}


@pytest.fixture(scope="module")
def marked(tmp_path_factory):
    """The class, marked by the command: what it said, its code, and its documents."""
    room = tmp_path_factory.mktemp("room")
    group, outside = room / "class", room / "outside"
    outside.mkdir()
    (outside / "kept").touch()
    for name, (text, _, _) in CASES.items():
        folder = group / name / "my_answers"
        folder.mkdir(parents=True)
        data = text if isinstance(text, bytes) else text.encode()
        data = data.replace(b"OUTSIDE", bytes(outside)).replace(b"CLASS", bytes(group))
        (folder / "01_to_local.py").write_bytes(data)
    odd = group / "=odd\x1b[2J" / "my_answers"
    odd.mkdir(parents=True)
    (odd / "01_to_local (1).py").write_text(RIGHT)
    (odd / "=cmd|' calc'!A0\x1b[31m.py").write_text("")
    if os.name != "nt":
        os.mkfifo(odd / "01_compose.py")
    (odd / "01_ray_segment.py").mkdir()
    (odd / "01_bicycle_step.py").symlink_to(group / "right" / "my_answers" / "01_to_local.py")
    weights = room / "weights.txt"
    weights.write_text("to_local 3  # the first one\nothers 0.5\n")
    files = ["--csv", f"{room}/m.csv", "--json", f"{room}/m.json", "--feedback", f"{room}/pages"]
    files += ["--weights", str(weights)]
    run = subprocess.run(
        [sys.executable, "-m", "tutorial_lib", "mark", str(group), f"{room}/missing", *files],
        capture_output=True,
        text=True,
        stdin=subprocess.PIPE,
        timeout=300,
    )
    time.sleep(2.5)  # what outlives the command has had its time
    return room, run, {one["student"]: one for one in json.loads((room / "m.json").read_text())}


def exercise(document, name="01_to_local"):
    return next(one for one in document["exercises"] if one["exercise"] == name)


@linux
@pytest.mark.parametrize("name", CASES)
def test_a_class_is_marked_whatever_is_in_its_answers(marked, name):
    _, run, documents = marked
    if name in ISOLATED and "note: " in run.stderr:
        pytest.skip(run.stderr)
    found = exercise(documents[name])
    assert found["status"] == CASES[name][1], found
    assert CASES[name][2] in found["message"]
    assert len(documents[name]["exercises"]) == 51
    assert len(found["printed"]) < 6_000


@linux
def test_nothing_outlives_the_command_or_is_written_elsewhere(marked):
    room, run, _ = marked
    if "note: " not in run.stderr:
        assert [file.name for file in (room / "outside").iterdir()] == ["kept"]
    for status in Path("/proc").glob("[0-9]*/environ"):
        try:
            assert str(room) not in os.readlink(status.with_name("cwd"))
        except OSError:
            continue


@linux
def test_every_line_and_document_is_safe_to_show(marked):
    room, run, documents = marked
    assert run.returncode == 2
    assert "missing: cannot be read" in run.stderr
    assert run.stdout.count("right: 3 of 26.5 points") == 0
    assert "right: 1 of 51 pass, 50 not handed in; 3 of 28 points" in run.stdout
    assert all(c.isprintable() or c == "\n" for c in run.stdout)
    assert not any(line.startswith("right: 51") for line in run.stdout.splitlines())
    odd = next(documents[name] for name in documents if name.startswith("=odd"))
    assert "rename it 01_to_local.py" in odd["unknown_files"]["01_to_local (1).py"]
    assert "a pipe" in exercise(odd, "01_compose")["message"]
    assert "a folder" in exercise(odd, "01_ray_segment")["message"]
    assert "symbolic link" in exercise(odd, "01_bicycle_step")["message"]
    assert exercise(odd)["status"] == "not handed in"
    rows = list(csv.reader((room / "m.csv").read_text().splitlines()))
    assert not any(cell.startswith(("=", "@")) for row in rows for cell in row)
    pages = list((room / "pages").glob("*.html"))
    assert len(pages) == len(documents)
    assert "\x1b" not in "".join(page.read_text() for page in pages)


@linux
def test_without_namespaces_all_processes_are_ended_too(tmp_path):
    script = f"""
    from pathlib import Path
    from tutorial_lib.checks.marking import limits, worker
    from tutorial_lib.checks.nb01 import check_to_local
    def refuse(flags):
        raise OSError(1, "Operation not permitted")
    limits._unshare = refuse
    start = worker.Server(Path({str(tmp_path)!r}), [])
    print(start.missing)
    text = {OUTLIVES + RIGHT!r}.replace("OUTSIDE", {str(tmp_path)!r}).encode()
    print(worker.judge(check_to_local, "01_to_local.py", text, start)[0])
    text = {"print('unfinished', end='')" + chr(10) + RIGHT!r}.encode()
    print(worker.judge(check_to_local, "01_to_local.py", text, start)[1])
    """
    run = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(script)], capture_output=True, text=True, timeout=100
    )
    assert "can reach the network and write files" in run.stdout
    assert "to_local: passed" in run.stdout
    assert "unfinished" in run.stdout
    time.sleep(2.5)
    assert list(tmp_path.iterdir()) == []


def test_where_nothing_can_be_forked_each_answer_starts_anew(tmp_path, monkeypatch):
    monkeypatch.delenv("PYTHONUNBUFFERED", raising=False)  # or nothing printed is ever held back
    start, missing = spawning(tmp_path)
    assert "slower" in missing
    check = {check.name: check for check in all_checks()}["to_local"]
    result, printed = judge(check, "01_to_local.py", f"print(1, end='')\n{RIGHT}".encode(), start)
    assert result.status == "passed", result
    assert printed == "1"
    assert list(tmp_path.iterdir()) == []


def test_what_the_checks_save_can_be_marked(tmp_path, monkeypatch):
    monkeypatch.setenv(my_answers.FOLDER, str(tmp_path))
    checks = {f"{check.notebook}_{check.name}": check for check in all_checks()}
    assert len(checks) == 51
    (tmp_path / "source.py").write_text(RIGHT)
    checks["01_to_local"].use(my_answers.read(tmp_path / "source.py", "to_local"))
    (tmp_path / "source.py").unlink()
    (student,) = students_in([tmp_path], list(checks))
    assert list(student.texts) == ["01_to_local"]
    assert not student.problem


def through(value):
    return wire.FromAnswer(wire.to_check(value)).load()


VALUES = [
    (True, 2, 2.5, "text", b"bytes", None, 1j),
    [{1, 2}, frozenset({3}), {(1, 2): [3]}],
    np.float32(2.5),
    np.array(["a", "b"]),
    State.LOST,
    FollowerSettings(),
    nx.path_graph(3),
    nx.DiGraph([(1, 2, {"metres": 2.0})]),
]


@pytest.mark.parametrize("value", VALUES, ids=lambda v: type(v).__name__)
def test_plain_values_come_back_as_they_are(value):
    got = through(value)
    assert type(got) is type(value)
    if isinstance(value, nx.Graph):
        assert nx.utils.graphs_equal(got, value)
    else:
        assert np.array_equal(got, value) if isinstance(value, np.ndarray) else got == value


def test_arrays_keep_their_form_and_other_objects_their_name():
    array = np.arange(6.0).reshape(2, 3).T
    assert np.array_equal(through(array), array)
    assert through(np.array([1, None], dtype=object)).tolist() == [1, None]
    assert list(through(range(3))) == [0, 1, 2]
    assert type(through(x for x in "ab")).__name__ == "generator"
    assert through({1: 2}.values()).__class__.__name__ == "dict_values"


class Touches:
    def __init__(self, file):
        self.file = file

    def __reduce__(self):
        return Path.touch, (self.file,)


@pytest.mark.parametrize("name", ["posix.system", "builtins.eval", "numpy.ndarray"])
def test_no_bytes_of_an_answer_run_code(tmp_path, name):
    with pytest.raises(pickle.UnpicklingError, match="no plain data"):
        wire.FromAnswer(pickle.dumps(Touches(tmp_path / "file"))).load()
    module, _, attribute = name.partition(".")
    with pytest.raises(pickle.UnpicklingError, match="no plain data"):
        wire.FromAnswer(f"c{module}\n{attribute}\n.".encode()).load()
    assert not (tmp_path / "file").exists()


def hand_in(root, *names):
    for name in names:
        file = root / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("x = 1\n")


def test_the_record_of_predictions_and_scores_is_no_answer_and_no_stranger(tmp_path):
    hand_in(tmp_path, "anna/my_answers/01_compose.py", "anna/my_answers/record.json")
    (anna,) = students_in([tmp_path / "anna"], EXERCISES)
    assert list(anna.texts) == ["01_compose"]
    assert anna.unknown == {}


def test_folders_of_students_are_found_however_they_are_given(tmp_path, monkeypatch):
    hand_in(tmp_path, "class/anna/my_answers/01_compose.py", "class/anna/my_answers/older/x_v1.py")
    hand_in(tmp_path, "class/ben/01_compose.py", "class/cleo/archive/my_answers/01_to_local.py")
    hand_in(tmp_path, "other/anna/my_answers/01_to_local.py", "class/.git/config")
    (tmp_path / "class" / "dora").mkdir()
    monkeypatch.chdir(tmp_path)
    found = students_in([Path("class/")], EXERCISES)
    names = {one.name: sorted(one.texts) for one in found}
    expected = {"anna": ["01_compose"], "ben": ["01_compose"], "cleo": ["01_to_local"], "dora": []}
    assert names == expected
    assert [bool(one.problem) for one in found] == [False, False, False, True]
    assert not any(one.unknown for one in found)
    for given in ("class/anna", "class/anna/my_answers/", "class/anna/../anna/my_answers"):
        assert [one.name for one in students_in([Path(given)], EXERCISES)] == ["anna"]
    twice = students_in([Path("class/anna"), Path("other/anna")], EXERCISES)
    assert len({one.name for one in twice}) == 2
    monkeypatch.chdir("class/anna/my_answers")
    assert [one.name for one in students_in([Path()], EXERCISES)] == ["anna"]


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("01_to_local (1).py", "rename it 01_to_local.py"),
        ("01_to_local - Copy.py", "rename it 01_to_local.py"),
        ("01_TO_LOCAL.py", "rename it 01_to_local.py"),
        ("1_to_local.py", "rename it 01_to_local.py"),
        ("notes.txt", "no exercise of the course"),
    ],
)
def test_unknown_files_are_named(tmp_path, name, words):
    hand_in(tmp_path, name, "01_compose.py")
    (student,) = students_in([tmp_path], EXERCISES)
    assert words in student.unknown[name]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("to_locl 2\n", r"weights:1: there is no exercise to_locl; did you mean to_local"),
        ("to_local\n", r"weights:1: give a name and its points"),
        ("\nto_local two\n", r"weights:2: 'two' are no points"),
        ("to_local -1\n", "from 0 to"),
        ("to_local nan\n", "from 0 to"),
        ("to_local inf\n", "from 0 to"),
        ("to_local 1\n01_to_local 2\n", r"weights:2: to_local|weights:2: 01_to_local has points"),
    ],
)
def test_wrong_lines_of_weights_are_named(tmp_path, text, words):
    (tmp_path / "weights").write_text(text)
    with pytest.raises(InputError, match=words):
        read_weights(tmp_path / "weights", EXERCISES)


def test_weights_are_read(tmp_path):
    (tmp_path / "weights").write_text("\ufeff# points\nto_local = 2.5\n04_move_on: 3 # more\n")
    expected = {"01_compose": 1.0, "01_to_local": 2.5, "04_move_on": 3.0}
    assert read_weights(tmp_path / "weights", EXERCISES) == expected
    (tmp_path / "weights").write_text("to_local 2\nothers 0\n")
    expected = {"01_compose": 0.0, "01_to_local": 2.0, "04_move_on": 0.0}
    assert read_weights(tmp_path / "weights", EXERCISES) == expected


def test_reports_escape_what_students_write(tmp_path):
    picture = np.zeros((4, 6, 3), np.uint8)
    marks = [
        Mark("01_compose", "failed", "=1+1 <script>\nnext", "@printed <b>"),
        Mark("01_to_local", "passed", "Correct", "", picture),
        Mark("04_move_on", "not handed in"),
    ]
    student = Student("-anna\x1b[2J", Path("a/\x1b/my_answers"), unknown={"=x\x07.py": "why"})
    one = Marked(student, marks, {"01_compose": 1.0, "01_to_local": 2.0, "04_move_on": 1.0})
    lines = lines_of(one).split("\n")
    assert lines[0].endswith("1 of 3 pass, 1 failed, 1 not handed in; 2 of 4 points")
    assert lines[1] == "  01_compose: failed. =1+1 <script> next"
    assert all(c.isprintable() for line in lines for c in line)
    write_csv(tmp_path / "m.csv", [one])
    rows = list(csv.reader((tmp_path / "m.csv").open(newline="")))
    assert len(rows) == 5
    assert rows[1][0].startswith("'-anna")
    assert rows[1][6:] == ["'=1+1 <script>\nnext", "'@printed <b>"]
    write_json(tmp_path / "m.json", [one])
    assert json.loads((tmp_path / "m.json").read_text())[0]["points"] == 2.0
    pages = write_pages(tmp_path / "pages", [one, one])
    assert len({page.name.lower() for page in pages}) == 2
    text = pages[0].read_text()
    assert "<script>" not in text
    assert "<b>'" not in text
    assert "&lt;script&gt;" in text
    assert "data:image/png" in text
    assert isinstance(Result("x", "passed", ""), Result)


def test_files_that_cannot_be_written_are_refused_before_anything_is_judged(tmp_path, capsys):
    hand_in(tmp_path, "01_compose.py")
    begun = time.monotonic()
    assert main(["mark", str(tmp_path), "--csv", str(tmp_path / "no" / "m.csv")]) == 2
    assert main(["mark", str(tmp_path), "--feedback", str(tmp_path / "01_compose.py")]) == 2
    assert time.monotonic() - begun < 2
    assert "give a folder for the pages" in capsys.readouterr().err
