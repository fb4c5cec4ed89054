#!/usr/bin/env python3
"""Set up the course in .venv beside this file, then start it.

usage: python3 start.py [--gpu] [COMMAND] [ARGUMENTS]
  lab       open JupyterLab on the first notebook (the same without a command)
  test      run the tests, in this folder; --full adds the slow ones
  demo      run one navigation without a screen; leaves a film and a JSON in the current folder
  progress  list the exercises that are done, in every notebook
  setup     only install
  --gpu     before or after a command: on Linux (x86-64) PyTorch with CUDA, which is kept then

ARGUMENTS go to JupyterLab, pytest or the demo: start.py lab --no-browser. The first start
takes some minutes to install; later ones install nothing unless pyproject.toml has changed or
packages are missing. The first "test" adds what only the tests need.
"""

from __future__ import annotations

import hashlib
import importlib.util
import os
import platform
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

VERSION = ".".join(map(str, sys.version_info[:2]))
HERE = Path(__file__).resolve().parent
VENV = HERE / ".venv"
STAMP = VENV / "stamp"
STUDENT, DEVELOPER = "student", "dev"  # extras of pyproject.toml; the second holds the first
CPU_INDEX = "https://download.pytorch.org/whl/cpu"  # the usual index has CUDA's build for Linux
TORCH = r'"(torch\b[^"]*)"'  # what pyproject.toml requires
ANSWERS_WITHIN = 10.0  # seconds for that index
ALONE = ("progress", "setup")  # commands that take no arguments
NEEDED = 3.0  # GB of disk for an installation


def too_old(version: tuple[int, ...]) -> str:
    """The message for a Python that is too old (this file's syntax is 3.8's); otherwise empty."""
    message = (
        f"The course needs Python 3.10 or newer, this is {'.'.join(map(str, version[:3]))}: install"
        " it from https://www.python.org/downloads and run python3.10 (or newer) start.py"
    )
    return message if tuple(version[:2]) < (3, 10) else ""


def python_of(venv: Path, windows: bool = os.name == "nt") -> Path:
    """The interpreter of a virtual environment."""
    return venv / "Scripts" / "python.exe" if windows else venv / "bin" / "python"


def environment() -> dict[str, str]:
    """The caller's environment with .venv activated, without a PYTHONPATH (ROS sets one)."""
    env = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "PYTHONHOME")}
    env["VIRTUAL_ENV"] = str(VENV)
    env["PATH"] = os.pathsep.join([str(python_of(VENV).parent), env.get("PATH", os.defpath)])
    env.setdefault("PYTHONUTF8", "1")  # Windows would write θ to a file or pipe in its code page
    return env


def run(command: list[str], cwd: Path | None = None) -> int:
    """Run a command to its end and return its exit code.

    Raises:
        KeyboardInterrupt: if it was ended by Ctrl-C.
        SystemExit: if this process was told to end, by SIGTERM or as its terminal was closed.
    """
    received: list[int] = []
    children: list[subprocess.Popen] = []

    def told() -> list[int]:
        """What told to end; Ctrl-C goes to the child by itself, which may ask back (JupyterLab)."""
        return [number for number in received if number != signal.SIGINT]

    def pass_on(*signals: object) -> None:
        received.extend(signals[:1])
        for child in children if told() else ():
            child.terminate()

    numbers = [getattr(signal, name, None) for name in ("SIGINT", "SIGTERM", "SIGHUP")]
    heard = [n for n in numbers if n and signal.getsignal(n) != signal.SIG_IGN]  # nohup ignores one
    before = {number: signal.signal(number, pass_on) for number in heard}
    try:
        with subprocess.Popen(command, cwd=cwd, env=environment()) as child:
            children.append(child)
            pass_on()  # what came before there was a child
            code = child.wait()
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    if told():
        sys.exit(128 + told()[0])
    if received and code:
        raise KeyboardInterrupt
    return code if code >= 0 else 128 - code


def ask(*arguments: str) -> str:
    """What .venv's Python prints when run with these arguments; empty if it fails or is missing."""
    command = [str(python_of(VENV)), *arguments]
    try:
        done = subprocess.run(command, cwd=HERE, env=environment(), capture_output=True)
    except OSError:
        return ""
    return "" if done.returncode else done.stdout.decode(errors="replace").strip()


def stamp(extra: str, gpu: bool) -> list[str]:
    """What an installation depends on, one line each: dependencies, Python, folder, extra, torch.

    An extra or a torch for the GPU that is there already stays.
    """
    digest = hashlib.sha256(pyproject().encode()).hexdigest()
    here = stamped()[3:]
    extra = DEVELOPER if DEVELOPER in (extra, *here) else STUDENT
    return [digest, VERSION, str(VENV), extra, "gpu" if gpu or "gpu" in here else "cpu"]


def pyproject() -> str:
    """The text of pyproject.toml."""
    project = HERE / "pyproject.toml"
    if not project.is_file():
        sys.exit(f"{project} is missing: get the course again, or restore it with git checkout")
    return project.read_text(encoding="utf-8")


def stamped() -> list[str]:
    """The stamp that the last finished installation left; empty if there is none."""
    if not STAMP.is_file():
        return []
    return STAMP.read_text(encoding="utf-8", errors="replace").splitlines()


def reason_to_rebuild() -> str:
    """Why an existing .venv cannot be used; empty if it can be kept, or there is none."""
    found = ask("-c", "import sys; print('%d.%d' % sys.version_info[:2])")
    folder = "".join(stamped()[2:3])
    if found and found != VERSION:
        return f"is for Python {found}, this is {VERSION}"
    if folder and folder != str(VENV):
        return f"was made in {folder}"
    return "" if found or not VENV.exists() else "does not run"


def lost(extra: str) -> list[str]:
    """The packages that .venv should hold but does not; "all" if not even that can be found out."""
    said = ask("-m", "tutorial_lib.commands.installed", extra) or "all"
    return [] if said == "complete" else said.split()


def is_ready(extra: str = STUDENT, gpu: bool = False) -> bool:
    """Whether .venv holds what pyproject.toml asks for, and still runs."""
    wanted = stamp(extra, gpu)
    return stamped() == wanted and not reason_to_rebuild() and not lost(wanted[3])


def make_venv() -> None:
    """Make .venv unless there is one that can be kept."""
    reason = reason_to_rebuild()
    if reason:
        print(f".venv {reason}: rebuilding it.", flush=True)
    elif ask("-m", "pip", "--version"):
        return
    if not all(importlib.util.find_spec(name) for name in ("venv", "ensurepip")):
        sys.exit(f"This Python cannot make a .venv: sudo apt install python{VERSION}-venv")
    base = getattr(sys, "_base_executable", None) or sys.executable  # not .venv's own
    if run([base, "-m", "venv", *(["--clear"] if reason else []), str(VENV)]):
        sys.exit(f"Could not make {VENV}: close what uses it, delete it, and start again.")


def advice() -> str:
    """What to do when pip has failed, in one line."""
    free = shutil.disk_usage(HERE).free / 1e9
    room = "" if free >= NEEDED else f" The disk has {free:.1f} GB free, {NEEDED} are needed."
    return (
        f"pip failed; log: {VENV / 'pip.log'}.{room} Behind a proxy: set HTTPS_PROXY to"
        " http://HOST:PORT and start again. Without a network: fill a folder wheelhouse where there"
        " is one, then PIP_NO_INDEX=1 PIP_FIND_LINKS=wheelhouse python3 start.py (as pip install"
        " --no-index --find-links wheelhouse). See environment.md"
    )


def quiet(command: list[str], seconds: float | None = None) -> bool:
    """Whether a command succeeds, in time; nothing of what it says is shown."""
    try:
        done = subprocess.run(command, env=environment(), capture_output=True, timeout=seconds)
    except subprocess.TimeoutExpired:
        return False
    return done.returncode == 0


def install_cpu_torch(pip: list[str]) -> None:
    """On Linux install the CPU build of torch, unless it is there or pip was told where to look."""
    torch = re.search(TORCH, pyproject())
    own = re.search(r"\.(no-index|index-url)=", ask("-m", "pip", "config", "list"))
    if not torch or own or not has_cuda_by_default():
        return
    alone, index = [*pip, "install", "--no-deps", torch[1]], ["--index-url", CPU_INDEX]
    if quiet([*alone, "--no-index"]):  # it was there, or in a folder that pip is set to look into
        return
    asked = [*pip, "index", "versions", "torch", *index, "--timeout", "3", "--retries", "0"]
    if not quiet(asked, ANSWERS_WITHIN) or run([*alone, *index], cwd=HERE):
        print(f"No torch from {CPU_INDEX}: taking pip's usual, with CUDA 4 GB.", flush=True)


def has_cuda_by_default() -> bool:
    """Whether the usual index has torch with CUDA for this computer."""
    return sys.platform == "linux" and platform.machine() in ("x86_64", "AMD64")


def setup(extra: str = STUDENT, gpu: bool = False) -> None:
    """Make .venv and install what pyproject.toml asks for, unless all of it is there."""
    if is_ready(extra, gpu):
        return
    before, wanted = stamped(), stamp(extra, gpu)
    extra, build = wanted[3:]
    broken = [name for name in lost(before[3]) if name != "all"] if before[3:] else []
    make_venv()
    print(f"Installing into {VENV}: some minutes the first time.", flush=True)
    STAMP.write_text("", encoding="utf-8")  # an interrupted installation is not finished
    log = VENV / "pip.log"
    pip = [str(python_of(VENV)), "-m", "pip", "--disable-pip-version-check", "--log", str(log)]
    if broken:  # pip goes by a package's metadata, which may be all that is left of it
        print(f"Repairing: {', '.join(broken)}", flush=True)
        run([*pip, "uninstall", "-q", "-y", *broken], cwd=HERE)
    if run([*pip, "install", "-q", "pip>=22.3"], cwd=HERE):  # a test needs --python
        sys.exit(advice())
    if build == "cpu":
        install_cpu_torch(pip)
    elif "gpu" not in before:
        quiet([*pip, "uninstall", "-y", "torch"])
    if run([*pip, "install", "-e", f".[{extra}]"], cwd=HERE):
        sys.exit(advice())
    if lost(extra):
        sys.exit(f"Could not install {', '.join(lost(extra))}: delete {VENV} and start again.")
    print("Compiling the numerical kernels: half a minute, once.", flush=True)
    run([str(python_of(VENV)), "-m", "tutorial_lib", "compile"], cwd=HERE)
    STAMP.write_text("\n".join(wanted), encoding="utf-8")
    log.unlink(missing_ok=True)  # 31 MB that only a failure needs


def command(name: str, arguments: list[str]) -> list[str]:
    """The command line behind lab, test, demo or progress."""
    module = ["pytest"] if name == "test" else ["tutorial_lib", name]
    return [str(python_of(VENV)), "-m", *module, *arguments]


def main(arguments: list[str]) -> int:
    """Do what the command line asks for and return the exit code."""
    gpu, arguments = "--gpu" in arguments, [one for one in arguments if one != "--gpu"]
    name, rest = (arguments or ["lab"])[0], arguments[1:]
    if name in ("-h", "--help"):
        print(__doc__.strip())
        return 0
    if name not in ("lab", "test", "demo", "progress", "setup") or (name in ALONE and rest):
        print(f"Cannot do {' '.join(arguments)!r}.\n\n{__doc__.strip()}", file=sys.stderr)
        return 2
    if gpu and not has_cuda_by_default():
        print("--gpu is for Linux (x86-64); for others see environment.md", file=sys.stderr)
        return 2
    try:
        setup(DEVELOPER if name == "test" else STUDENT, gpu)
        if name != "setup":
            return run(command(name, rest), cwd=HERE if name == "test" else None)
        print("Everything is installed. Next: python3 start.py")
    except KeyboardInterrupt:
        return 130
    except OSError as error:
        free = shutil.disk_usage(HERE).free / 1e9
        print(f"start.py: {error}; check the folder and its disk ({free:.1f} GB free)")
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(too_old(sys.version_info) or main(sys.argv[1:]))
