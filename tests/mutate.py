"""Does a test notice when the code is wrong? Makes small wrong changes, one at a time.

    python -m tests.mutate                 # all of them
    python -m tests.mutate --only follower # those whose file or description has this in it
    python -m tests.mutate --list

Works on a copy of the project. A change is *killed* when the tests that belong to it fail, and has
*survived* when they pass; it is *stale* when its old text does not stand in the file once, and
*broken* when pytest did not get as far as a test. Ends with 1 when more than 5% have survived, or
any is stale or broken.
"""

import argparse
import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue

from tests.mutations import Mutation, mutations

PROJECT = Path(__file__).resolve().parents[1]
LIBRARY, TESTS = "tutorial_lib", "tests"
MOST_SURVIVORS = 0.05
TIMEOUT = 600.0
"""Seconds after which tests are stopped; a change by which they never end is killed."""
KILLED, SURVIVED, STALE, BROKEN = "killed", "survived", "stale", "BROKEN"
PYTEST = ["-m", "pytest", "-x", "-q", "-p", "no:cacheprovider"]
SEEDED = ("--full", "-p", "hypothesispytest", "--hypothesis-seed=0")


def copy_project(project, folder):
    """Copy the files that git knows, or would add, as they are now."""
    names = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=project,
        check=True,
        capture_output=True,
        text=True,
    ).stdout
    for name in filter(None, names.split("\0")):
        if (project / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(project / name, folder / name)


def run_tests(folder, tests, cache, options=SEEDED):
    """Pytest's exit code for some tests of a copy; 1 if they take too long."""
    # No bytecode: it is known by second and size, which a change may leave as they are.
    env = os.environ | {
        "PYTHONPATH": str(folder),
        "PYTHONDONTWRITEBYTECODE": "1",
        # Plugins take longer to load than most tests to fail.
        "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
        "NUMBA_CACHE_DIR": str(cache),
    }
    command = [sys.executable, *PYTEST, *options, *shlex.split(f"{TESTS}/{tests}")]
    with tempfile.TemporaryFile() as output:
        process = subprocess.Popen(
            command, cwd=folder, env=env, stdout=output, stderr=output, start_new_session=True
        )
        try:
            code = process.wait(TIMEOUT)
        except subprocess.TimeoutExpired:
            code = 1
        finally:
            if process.poll() is None:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
        output.seek(0)
        text = output.read().decode(errors="replace")
    # Examples that failed are not to be tried on the next change.
    shutil.rmtree(folder / ".hypothesis", ignore_errors=True)
    return code, text


def try_out(folder, mutation, cache, **options):
    """What becomes of a change in a copy of the project, which is as before in the end."""
    path = folder / LIBRARY / mutation.file
    text = path.read_text(encoding="utf-8") if path.is_file() else ""
    if text.count(mutation.old) != 1:
        return STALE
    times = path.stat().st_atime_ns, path.stat().st_mtime_ns
    # Numba knows a function by its own file, not by those of the functions that it calls.
    own = tempfile.mkdtemp(dir=folder.parent) if "njit" in text else None
    try:
        path.write_text(text.replace(mutation.old, mutation.new), encoding="utf-8")
        code, _ = run_tests(folder, mutation.tests, own or cache, **options)
    finally:
        path.write_text(text, encoding="utf-8")
        os.utime(path, ns=times)
        if own:
            shutil.rmtree(own, ignore_errors=True)
    return {0: SURVIVED, 1: KILLED}.get(code, BROKEN)


def check_baseline(folder, chosen, cache, **options):
    """Run every test that is needed on unchanged code.

    Raises:
        SystemExit: when one fails, since then it would "kill" every change.
    """
    for tests in dict.fromkeys(mutation.tests for mutation in chosen):
        code, text = run_tests(folder, tests, cache, **options)
        if code:
            raise SystemExit(f"{tests}: does not pass before anything is changed\n{text}")


def run(project, chosen, jobs=1, **options):
    """Try all changes on copies of a project; the verdict of each, in the order given."""
    with tempfile.TemporaryDirectory(prefix="mutate-") as temporary:
        folders, verdicts = SimpleQueue(), {}
        for job in range(jobs):
            folder = Path(temporary) / f"copy{job}" / "project"
            copy_project(project, folder)
            folders.put(folder)

        def work(number):
            folder, begun = folders.get(), time.perf_counter()
            try:
                verdict = try_out(folder, chosen[number], folder.parent / "numba", **options)
            finally:
                folders.put(folder)
            took = time.perf_counter() - begun
            mutation = chosen[number]
            print(f"{verdict:8}  {took:5.1f} s  {mutation.file}: {mutation.what}", flush=True)
            verdicts[number] = verdict

        first = folders.get()
        check_baseline(first, chosen, first.parent / "numba", **options)
        folders.put(first)
        with ThreadPoolExecutor(jobs) as pool:
            list(pool.map(work, range(len(chosen))))
    return [verdicts[number] for number in range(len(chosen))]


def summary(verdicts):
    """The result in a line, and the exit code."""
    count = {verdict: verdicts.count(verdict) for verdict in (KILLED, SURVIVED, STALE, BROKEN)}
    line = ", ".join(f"{number} {verdict}" for verdict, number in count.items())
    faulty = count[STALE] or count[BROKEN] or count[SURVIVED] > MOST_SURVIVORS * len(verdicts)
    return f"{len(verdicts)} changes: {line}", int(bool(faulty))


def main(arguments=None):
    parser = argparse.ArgumentParser(prog="python -m tests.mutate", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--only", default="", help="part of the file's name, or of what is changed")
    parser.add_argument("--jobs", type=int, default=1, help="copies that are worked on at once")
    parser.add_argument("--list", action="store_true", help="print the changes and do nothing")
    options = parser.parse_args(arguments)
    chosen: list[Mutation] = [
        mutation for mutation in mutations() if options.only in f"{mutation.file}: {mutation.what}"
    ]
    if not chosen:
        parser.error(f"--only {options.only}: there is no such change; see --list")
    if options.list:
        for mutation in chosen:
            print(f"{mutation.file}: {mutation.what}  [{mutation.tests}]")
        return 0
    begun = time.perf_counter()
    line, code = summary(run(PROJECT, chosen, max(options.jobs, 1)))
    print(f"{line}, in {(time.perf_counter() - begun) / 60:.0f} min")
    return code


if __name__ == "__main__":
    sys.exit(main())
