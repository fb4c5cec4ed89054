"""start.py, without a network and without installing anything."""

import ast
import importlib.util
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from contextlib import contextmanager, suppress
from pathlib import Path
from types import SimpleNamespace

import pytest

FILE = Path(__file__).resolve().parents[2] / "start.py"
posix_only = pytest.mark.skipif(os.name == "nt", reason="POSIX signals and links")


@pytest.fixture
def start(tmp_path, monkeypatch):
    """start.py as a module, set to an empty project in a folder with a space."""
    spec = importlib.util.spec_from_file_location("start_under_test", FILE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    project = tmp_path / "a course"
    project.mkdir()
    (project / "pyproject.toml").write_text("[project]\n")
    monkeypatch.setattr(module, "HERE", project)
    monkeypatch.setattr(module, "VENV", project / ".venv")
    monkeypatch.setattr(module, "STAMP", project / ".venv" / "stamp")
    return module


class Machine:
    """Stands in for the programs that start.py runs: venv, pip, and what is started at the end."""

    def __init__(self, start):
        self.start = start
        self.calls = []
        self.folders = []
        self.python = None  # the version of the Python in .venv
        self.codes = {}  # exit codes, by a word of the command
        self.lost = "complete"  # what is said of the packages in .venv
        self.settings = ""  # what pip says of its own
        self.asked = []  # commands of which nothing is shown
        self.answers = {}  # whether these succeed, by a word of the command

    def run(self, command, cwd=None):
        self.calls.append(command)
        self.folders.append(cwd)
        for word, code in self.codes.items():
            if word in command:
                if code == "ctrl-c":
                    raise KeyboardInterrupt
                return code
        if "venv" in command:
            self.start.VENV.mkdir(exist_ok=True)
            if "--clear" in command:
                for file in self.start.VENV.iterdir():
                    file.unlink()
            self.python = self.start.VERSION
        if any(word.startswith(".[") for word in command):
            self.lost = "complete"
        return 0

    def ask(self, *arguments):
        if self.python is None:
            return ""
        if "tutorial_lib.commands.installed" in arguments:
            return self.lost
        if "config" in arguments:
            return self.settings
        return "pip 25.0" if "pip" in arguments else self.python

    def quiet(self, command, seconds=None):
        self.asked.append((command, seconds))
        return next((found for word, found in self.answers.items() if word in command), True)

    def forget(self):
        self.calls.clear()
        self.folders.clear()
        self.asked.clear()

    @property
    def installed(self):
        return [call[-1] for call in self.calls if call[-1].startswith(".[")]

    @property
    def made(self):
        return [call for call in self.calls if "venv" in call]


@pytest.fixture
def machine(start, monkeypatch):
    made = Machine(start)
    monkeypatch.setattr(start, "run", made.run)
    monkeypatch.setattr(start, "ask", made.ask)
    monkeypatch.setattr(start, "quiet", made.quiet)
    return made


def test_the_file_is_readable_by_python_3_8_and_small():
    text = FILE.read_text(encoding="utf-8")
    tree = ast.parse(text, feature_version=(3, 8))
    assert len(text.splitlines()) <= 280
    modules = {
        a.name.split(".")[0] for n in ast.walk(tree) if isinstance(n, ast.Import) for a in n.names
    }
    modules |= {n.module for n in ast.walk(tree) if isinstance(n, ast.ImportFrom)}
    assert modules <= set(sys.stdlib_module_names)


def test_an_old_python_gets_advice(start):
    message = start.too_old((3, 8, 10, "final", 0))
    assert "needs Python 3.10 or newer, this is 3.8.10" in message
    assert "python.org" in message
    assert "start.py" in message
    assert start.too_old((3, 10, 0)) == start.too_old((3, 14, 1)) == ""


def test_the_interpreter_on_windows_and_elsewhere(start):
    venv = Path("a course") / ".venv"
    assert start.python_of(venv, windows=True).parts[-2:] == ("Scripts", "python.exe")
    assert start.python_of(venv, windows=False).parts[-2:] == ("bin", "python")


def test_the_environment_is_the_callers_with_venv_first(start, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", "/opt/ros/humble/python")
    monkeypatch.setenv("PIP_NO_INDEX", "1")
    monkeypatch.setenv("PYTHONUTF8", "0")
    found = start.environment()
    assert "PYTHONPATH" not in found
    assert found["PIP_NO_INDEX"] == "1"
    assert found["PYTHONUTF8"] == "0"
    assert found["PATH"].split(os.pathsep)[0] == str(start.python_of(start.VENV).parent)


def test_the_stamp_depends_on_dependencies_python_and_folder(start, monkeypatch, tmp_path):
    def stamp(extra="student", gpu=False):
        return tuple(start.stamp(extra, gpu))

    stamps = {stamp(), stamp("dev"), stamp(gpu=True)}
    (start.HERE / "pyproject.toml").write_text("[project]\nname = 'other'\n")
    stamps.add(stamp())
    monkeypatch.setattr(start, "VERSION", "3.99")
    stamps.add(stamp())
    monkeypatch.setattr(start, "VENV", tmp_path / "moved" / ".venv")
    stamps.add(stamp())
    assert len(stamps) == 6


def test_the_first_start_installs_and_the_second_does_not(start, machine, capsys):
    assert not start.is_ready()
    assert start.main(["setup"]) == 0
    assert len(machine.made) == len(machine.installed) == 1
    assert machine.calls[-1][-2:] == ["tutorial_lib", "compile"]
    assert "--clear" not in machine.made[0]
    assert machine.folders[-1] == start.HERE
    assert start.is_ready()
    machine.forget()
    assert start.main(["setup"]) == 0
    assert machine.calls == []
    assert "installed" in capsys.readouterr().out


def test_a_changed_pyproject_installs_again_into_the_same_venv(start, machine):
    start.setup()
    machine.forget()
    (start.HERE / "pyproject.toml").write_text("[project]\ndependencies = ['x']\n")
    assert not start.is_ready()
    start.setup()
    assert machine.made == []
    assert len(machine.installed) == 1
    assert start.is_ready()


def test_the_tests_packages_are_added_once_and_stay(start, machine):
    assert start.main(["lab"]) == start.main(["demo"]) == 0
    assert machine.installed == [".[student]"]
    assert start.main(["test"]) == start.main(["test"]) == 0
    assert machine.installed == [".[student]", ".[dev]"]
    machine.forget()
    assert start.main(["lab"]) == start.main(["test"]) == 0
    assert machine.installed == []
    (start.HERE / "pyproject.toml").write_text("[project]\ndependencies = ['x']\n")
    assert start.main(["lab"]) == 0
    assert machine.installed == [".[dev]"]  # a student's would leave old ones behind


def test_what_is_lost_is_asked_of_what_is_installed(start, machine, monkeypatch):
    extras = []
    monkeypatch.setattr(start, "lost", lambda extra: extras.append(extra) or [])
    start.setup()
    start.setup("dev")
    start.setup()
    assert extras[-1] == "dev"
    assert extras[0] == "student"


TORCH = "[project]\ndependencies = ['x', \"torch>=2.4,<2.14\"]\n"


def test_pyproject_says_the_same_to_uv(start):
    text = (FILE.parent / "pyproject.toml").read_text(encoding="utf-8")
    assert re.search(start.TORCH, text)[1] == "torch>=2.4,<2.14"
    assert f'url = "{start.CPU_INDEX}"' in text


@pytest.fixture
def linux(start, machine, monkeypatch):
    """An ordinary Linux computer, on which no torch is installed and no folder has one."""
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setattr(start.platform, "machine", lambda: "x86_64")
    (start.HERE / "pyproject.toml").write_text(TORCH)
    machine.answers = {"--no-index": False}
    return machine


def torches(machine):
    """The commands that install torch alone."""
    return [call for call in machine.calls if "torch>=2.4,<2.14" in call]


def test_on_linux_the_cpu_build_of_torch_is_installed_first(start, linux, capsys):
    start.setup()
    (torch,) = torches(linux)
    assert torch[-3:] == ["torch>=2.4,<2.14", "--index-url", start.CPU_INDEX]
    assert "--no-deps" in torch
    assert linux.calls.index(torch) < next(
        number for number, call in enumerate(linux.calls) if ".[student]" in call
    )
    (asked,) = [(call, seconds) for call, seconds in linux.asked if "index" in call]
    assert asked[0][-4:] == ["--timeout", "3", "--retries", "0"]
    assert asked[1] <= 10
    assert "CUDA" not in capsys.readouterr().out


@pytest.mark.parametrize("failing", ["answer", "installation"])
def test_without_the_cpu_index_the_usual_one_is_taken_and_said(start, linux, capsys, failing):
    if failing == "answer":
        linux.answers["index"] = False
    else:
        linux.codes = {"--index-url": 1}
    start.setup()
    assert len(torches(linux)) == (failing == "installation")
    assert linux.installed == [".[student]"]
    (line,) = [line for line in capsys.readouterr().out.splitlines() if start.CPU_INDEX in line]
    assert "taking pip's usual" in line
    assert start.is_ready()


def test_a_torch_that_is_there_or_in_a_folder_of_ones_own_is_taken(start, linux):
    linux.answers = {"--no-index": True}
    start.setup()
    assert [call[-1] for call, _ in linux.asked] == ["--no-index"]
    assert torches(linux) == []


@pytest.mark.parametrize(
    "settings",
    [
        ":env:.no-index='1'",
        "global.index-url='https://pypi.example.org/simple'",
        ":env:.cert='x'\ninstall.index-url='https://a.example.org'",
    ],
)
def test_pip_s_own_index_or_none_is_respected(start, linux, settings):
    linux.settings = settings
    start.setup()
    assert linux.asked == []
    assert torches(linux) == []


def test_another_index_beside_pip_s_usual_one_changes_nothing(start, linux):
    linux.settings = "global.extra-index-url='https://a.example.org'\nglobal.find-links='x'"
    start.setup()
    assert len(torches(linux)) == 1


@pytest.mark.parametrize(
    ("system", "processor"), [("darwin", "arm64"), ("win32", "AMD64"), ("linux", "aarch64")]
)
def test_elsewhere_the_usual_index_has_the_cpu_build(
    start, linux, monkeypatch, capsys, system, processor
):
    monkeypatch.setattr(sys, "platform", system)
    monkeypatch.setattr(start.platform, "machine", lambda: processor)
    start.setup()
    assert linux.asked == []
    assert start.main(["--gpu"]) == 2
    assert "--gpu is for Linux (x86-64)" in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [["--gpu", "demo"], ["demo", "--gpu"], ["--gpu"]])
def test_with_gpu_torch_comes_from_the_usual_index_and_stays(start, linux, arguments):
    start.setup()
    linux.forget()
    assert start.main(arguments) == 0
    assert [call[-3:] for call, _ in linux.asked] == [["uninstall", "-y", "torch"]]
    assert torches(linux) == []
    assert linux.installed == [".[student]"]
    assert "--gpu" not in linux.calls[-1]
    linux.forget()
    assert start.main(["lab"]) == start.main(["lab", "--gpu"]) == 0
    assert linux.installed == linux.asked == []
    assert start.main(["test"]) == 0
    assert linux.asked == []  # nor does more of the course bring the other


def test_pip_s_log_is_kept_only_if_it_fails(start, machine):
    log = start.VENV / "pip.log"
    machine.codes, machine.python = {".[student]": 1}, start.VERSION
    start.VENV.mkdir()
    log.write_text("much")
    with pytest.raises(SystemExit, match=r"pip\.log"):
        start.setup()
    assert log.exists()
    machine.codes = {}
    start.setup()
    assert not log.exists()


@pytest.mark.parametrize(("code", "right"), [("", True), ("raise SystemExit(1)", False)])
def test_a_quiet_command_succeeds_or_not_and_says_nothing(start, capfd, code, right):
    assert start.quiet([sys.executable, "-c", f"print(1); {code}"]) is right
    assert not start.quiet([sys.executable, "-c", "import time; time.sleep(30)"], 0.2)
    assert capfd.readouterr() == ("", "")


def test_a_venv_prepared_by_hand_is_kept(start, machine):
    start.VENV.mkdir()
    machine.python = start.VERSION
    start.setup()
    assert machine.made == []
    assert len(machine.installed) == 1


def test_a_venv_without_pip_is_completed_not_cleared(start, machine, monkeypatch):
    start.VENV.mkdir()
    machine.python = start.VERSION
    monkeypatch.setattr(start, "ask", lambda *a: "" if "pip" in a else machine.ask(*a))
    start.setup()
    assert [("--clear" in call) for call in machine.made] == [False]


@pytest.mark.parametrize("stopped", ["venv", "pip>=22.3", ".[student]"])
def test_an_interrupted_installation_is_repaired_by_the_next(start, machine, stopped):
    machine.codes = {stopped: "ctrl-c"}
    assert start.main(["demo"]) == 130
    assert start.stamped() == []
    assert not start.is_ready()
    machine.codes = {}
    assert start.main(["setup"]) == 0
    assert machine.installed
    assert start.is_ready()


def test_an_interrupted_update_is_repaired_too(start, machine):
    start.setup()
    (start.HERE / "pyproject.toml").write_text("[project]\ndependencies = ['x']\n")
    machine.codes = {".[student]": "ctrl-c"}
    assert start.main(["setup"]) == 130
    (start.HERE / "pyproject.toml").write_text("[project]\n")  # back to what once was complete
    assert not start.is_ready()


@pytest.mark.parametrize(
    ("python", "notice"), [("3.9", "is for Python 3.9"), (None, "does not run")]
)
def test_a_venv_of_another_or_a_removed_python_is_made_anew(start, machine, capsys, python, notice):
    start.setup()
    machine.forget()
    machine.python = python
    start.setup()
    assert "--clear" in machine.made[0]
    assert notice in capsys.readouterr().out
    assert start.is_ready()


def test_a_moved_folder_gets_a_new_venv(start, machine, monkeypatch, tmp_path, capsys):
    start.setup()
    machine.forget()
    old, new = start.VENV, tmp_path / "moved course"
    start.HERE.rename(new)
    monkeypatch.setattr(start, "HERE", new)
    monkeypatch.setattr(start, "VENV", new / ".venv")
    monkeypatch.setattr(start, "STAMP", new / ".venv" / "stamp")
    start.setup()
    assert "--clear" in machine.made[0]
    assert f"was made in {old}" in capsys.readouterr().out
    assert start.is_ready()


def test_a_python_without_venv_says_what_to_install(start, machine, monkeypatch):
    real = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name == "ensurepip" else real(name)
    )
    with pytest.raises(SystemExit, match=rf"sudo apt install python{start.VERSION}-venv"):
        start.setup()
    assert machine.calls == []


def test_a_failing_venv_and_a_failing_pip_are_explained_in_a_line(start, machine):
    machine.codes = {"venv": 1}
    with pytest.raises(SystemExit, match="Could not make") as error:
        start.main(["setup"])
    assert "\n" not in str(error.value)
    machine.codes = {".[student]": 1}
    with pytest.raises(SystemExit, match=r"pip\.log.*HTTPS_PROXY.*PIP_NO_INDEX=1") as error:
        start.main(["setup"])
    assert "\n" not in str(error.value)
    assert start.stamped() == []


@pytest.mark.parametrize(("free", "said"), [(0.2e9, True), (50e9, False)])
def test_a_failing_pip_on_a_full_disk_says_so(start, machine, monkeypatch, free, said):
    machine.codes = {".[student]": 1}
    monkeypatch.setattr(shutil, "disk_usage", lambda folder: SimpleNamespace(free=free))
    with pytest.raises(SystemExit) as error:
        start.main(["setup"])
    assert ("The disk has 0.2 GB free, 3.0 are needed." in str(error.value)) == said


def test_packages_that_were_deleted_are_installed_again(start, machine, capsys):
    start.setup()
    assert start.is_ready()
    machine.forget()
    machine.lost = "numpy torch"
    assert not start.is_ready()
    start.setup()
    removed, pip, course = machine.calls[:3]
    assert removed[-5:] == ["uninstall", "-q", "-y", "numpy", "torch"]
    assert "pip>=22.3" in pip
    assert ".[student]" in course
    assert "Repairing: numpy, torch" in capsys.readouterr().out
    assert machine.made == []
    assert start.is_ready()


def test_a_venv_in_which_nothing_is_left_is_filled_again(start, machine):
    start.setup()
    machine.forget()
    machine.lost = ""
    start.setup()
    assert len(machine.installed) == 1
    assert not any("uninstall" in call for call in machine.calls)


def test_packages_that_cannot_be_installed_are_named(start, machine, monkeypatch):
    monkeypatch.setattr(start, "lost", lambda extra: ["numpy"])
    with pytest.raises(SystemExit, match=r"Could not install numpy: delete .*\.venv and start"):
        start.setup()
    assert start.stamped() == []


def test_a_stamp_that_is_no_text_means_that_nothing_is_installed(start, machine):
    start.setup()
    start.STAMP.write_bytes(b"\xff\xfe\x00 no text")
    machine.forget()
    assert not start.is_ready()
    start.setup()
    assert len(machine.installed) == 1
    assert start.is_ready()


def test_a_missing_pyproject_is_named(start, machine):
    (start.HERE / "pyproject.toml").unlink()
    with pytest.raises(SystemExit, match=r"pyproject\.toml is missing: get the course again"):
        start.main(["demo"])
    assert machine.calls == []


def test_an_error_of_the_disk_is_one_line(start, machine, monkeypatch, capsys):
    start.VENV.mkdir()
    start.STAMP.mkdir()  # so it cannot be written
    assert start.main(["setup"]) == 2
    said = capsys.readouterr().out.splitlines()[-1]
    assert said.startswith("start.py: ")
    assert "GB free" in said


def test_arguments_and_exit_codes_are_passed_on(start, machine):
    machine.codes = {"pytest": 3, "tutorial_lib": 4}
    python = str(start.python_of(start.VENV))
    assert start.main(["test", "--full", "-k", "a b"]) == 3
    assert machine.calls[-1] == [python, "-m", "pytest", "--full", "-k", "a b"]
    assert machine.folders[-1] == start.HERE
    assert start.main(["demo", "--seed", "7"]) == 4
    assert machine.calls[-1] == [python, "-m", "tutorial_lib", "demo", "--seed", "7"]
    assert machine.folders[-1] is None  # demo leaves its files where the caller is
    assert start.main(["lab", "--no-browser"]) == 4
    assert machine.calls[-1][:4] == [python, "-m", "tutorial_lib", "lab"]
    assert machine.calls[-1][-1] == "--no-browser"
    assert start.main([]) == 4
    assert machine.calls[-1][2:4] == ["tutorial_lib", "lab"]


@pytest.mark.parametrize("arguments", [["fly"], ["--full"], ["setup", "torch"]])
def test_an_unknown_command_shows_the_usage(start, machine, capsys, arguments):
    assert start.main(arguments) == 2
    shown = capsys.readouterr()
    assert "usage:" in shown.err
    assert arguments[0] in shown.err
    assert shown.out == ""
    assert machine.calls == []


@pytest.mark.parametrize("flag", ["-h", "--help"])
def test_help(start, machine, capsys, flag):
    assert start.main([flag]) == 0
    shown = capsys.readouterr().out
    for name in ("usage:", "lab", "test", "demo", "setup", "--full"):
        assert name in shown
    assert machine.calls == []


def test_run_returns_the_exit_code_and_works_in_the_folder(start, tmp_path):
    code = "import os, sys; open('here', 'w').close(); sys.exit(7)"
    assert start.run([sys.executable, "-c", code], cwd=tmp_path) == 7
    assert (tmp_path / "here").exists()
    assert start.run([sys.executable, "-c", ""]) == 0


@posix_only
def test_a_child_that_was_killed_gives_the_shells_exit_code(start):
    code = "import os, signal; os.kill(os.getpid(), signal.SIGKILL)"
    assert start.run([sys.executable, "-c", code]) == 128 + signal.SIGKILL


@posix_only
def test_ask_runs_the_python_of_venv(start):
    assert start.ask("-c", "print(1)") == ""
    python = start.python_of(start.VENV)
    python.parent.mkdir(parents=True)
    python.symlink_to(sys.executable)
    assert start.ask("-c", "print('a' + 'b')") == "ab"
    assert start.ask("-c", "raise SystemExit(1)") == ""
    assert start.reason_to_rebuild() == ""
    python.unlink()
    python.symlink_to(start.HERE / "removed")
    assert start.reason_to_rebuild() == "does not run"


@contextmanager
def started(child, tmp_path):
    """A process that does what start.py's main does, its JupyterLab replaced by `child`.

    It and the child are running and have a process group of their own, which is killed in the end.
    """
    up = tmp_path / "up"
    script = f"""
import importlib.util, sys
spec = importlib.util.spec_from_file_location("start", {str(FILE)!r})
start = importlib.util.module_from_spec(spec)
spec.loader.exec_module(start)
start.setup = lambda *_: None
start.command = lambda name, rest: [sys.executable, "-c", {child!r}, {str(up)!r}]
sys.exit(start.main([]))
"""
    process = subprocess.Popen(
        [sys.executable, "-c", script], stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    try:
        deadline = time.monotonic() + 60
        while not up.exists() and process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.01)
        assert up.exists()
        yield process
    finally:
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.communicate()


WAIT = """
import os, sys, time
with open(sys.argv[1] + ".new", "w") as file:
    file.write(str(os.getpid()))
os.rename(sys.argv[1] + ".new", sys.argv[1])
time.sleep(60)
"""
ANSWER = """
import signal, sys, time
signal.signal(signal.SIGINT, lambda *_: (time.sleep(0.4), sys.exit(0)))
open(sys.argv[1], "w").close()
time.sleep(60)
"""


@posix_only
@pytest.mark.parametrize(("child", "code"), [(WAIT, 130), (ANSWER, 0)])
def test_ctrl_c_is_left_to_the_child(tmp_path, child, code):
    with started(child, tmp_path) as process:
        os.killpg(process.pid, signal.SIGINT)  # as the terminal does
        _, errors = process.communicate(timeout=60)
    assert process.returncode == code
    assert "start.py" not in errors  # the child's own traceback at most, none of ours


@contextmanager
def closed_terminal(handled):
    """SIGHUP is handled so, here and in what is started."""
    before = signal.signal(signal.SIGHUP, handled)
    try:
        yield
    finally:
        signal.signal(signal.SIGHUP, before)


@posix_only
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP"])
def test_a_stopped_start_stops_what_it_started(tmp_path, name):
    number = getattr(signal, name)
    with closed_terminal(signal.SIG_DFL), started(WAIT, tmp_path) as process:
        process.send_signal(number)
        process.communicate(timeout=50)
        assert process.returncode == 128 + number
        child = int((tmp_path / "up").read_text())
        with pytest.raises(ProcessLookupError):
            os.kill(child, 0)


@posix_only
def test_what_ignores_a_closed_terminal_goes_on_doing_so(tmp_path):
    # As nohup does.
    with closed_terminal(signal.SIG_IGN), started(WAIT, tmp_path) as process:
        process.send_signal(signal.SIGHUP)
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(timeout=0.5)
