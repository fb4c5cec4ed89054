"""A wheel is a course: it is built, installed into a clean environment, and used there."""

import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import venv
import zipfile
from email import message_from_bytes
from importlib.util import find_spec
from pathlib import Path

import pytest

import tutorial_lib
from tests.project.test_style import git

PROJECT = Path(__file__).resolve().parents[2]
LARGEST = 20e6  # bytes
BIN = "Scripts" if os.name == "nt" else "bin"
BUILD = "import sys; from setuptools import build_meta; build_meta.build_wheel(sys.argv[1])"
ANSWER = """
import numpy as np
from tutorial_lib.checks.nb01 import check_to_local

def to_local(pose, points):
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    dx, dy = points[:, 0] - pose[0], points[:, 1] - pose[1]
    return np.stack([cos * dx + sin * dy, cos * dy - sin * dx], axis=1)

check_to_local.use(to_local)
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel of what the checkout holds, built in a copy."""
    if not all(find_spec(name) for name in ("pip", "setuptools")):  # as in an environment of uv
        pytest.skip("pip or setuptools is missing: pip install -e .[test] (start.py test does)")
    folder = tmp_path_factory.mktemp("wheel")
    names = git("ls-files", "-z", "--cached", "--others", "--exclude-standard")[0].split("\0")
    for name in names:
        if name and not name.startswith("tests/") and (PROJECT / name).is_file():
            copy = folder / "source" / name
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(PROJECT / name, copy)
    command = [sys.executable, "-c", BUILD, str(folder)]
    subprocess.run(command, cwd=folder / "source", check=True, capture_output=True)
    (file,) = folder.glob("*.whl")
    return file


class Course:
    """The course as somebody has it who installed the wheel, in a folder that was empty."""

    def __init__(self, folder, wheel):
        self.environment, self.folder = folder / "environment", folder / "my course"
        self.folder.mkdir()
        venv.create(self.environment, with_pip=False)
        pip = [sys.executable, "-m", "pip", "--python", self.python()[0]]
        subprocess.run([*pip, "install", "-q", "--no-deps", "--no-index", wheel], check=True)
        # All but the course comes from the environment of the tests.
        (packages,) = self.environment.glob("[Ll]ib/**/site-packages")
        paths = {sysconfig.get_path(name) for name in ("purelib", "platlib")}
        (packages / "others.pth").write_text("\n".join(paths))

    def python(self, *arguments):
        return [str(self.environment / BIN / "python"), *arguments]

    def do(self, *arguments):
        """What the course's command says when it is called in its folder."""
        return self.run(self.environment / BIN / "topological-navigation", *arguments)

    def run(self, *command, folder="."):
        named = ("PYTHONPATH", "TUTORIAL_ANSWERS", "NUMBA_CACHE_DIR")
        environment = {name: value for name, value in os.environ.items() if name not in named}
        environment["XDG_CACHE_HOME"] = environment["LOCALAPPDATA"] = str(self.folder.parent)
        done = subprocess.run(
            command, cwd=self.folder / folder, env=environment, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    def state(self):
        """Sizes and times of all that is installed."""
        files = [path for path in self.environment.rglob("*") if path.is_file()]
        return {path: (path.stat().st_size, path.stat().st_mtime_ns) for path in files}


@pytest.fixture(scope="module")
def course(tmp_path_factory, wheel):
    made = Course(tmp_path_factory.mktemp("course"), wheel)
    made.installed = made.state()
    made.do("copy")
    return made


def test_the_wheel_holds_the_course_and_says_what_it_is(wheel):
    assert wheel.stat().st_size < LARGEST
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        (meta,) = [name for name in names if name.endswith(".dist-info/METADATA")]
        metadata = message_from_bytes(archive.read(meta))
    assert "tutorial_lib/py.typed" in names
    for folder, pattern in (("results/page", "*.j2"), ("templates", "*.py")):
        files = list((PROJECT / "tutorial_lib" / folder).glob(pattern))
        assert len(files) > 5
        assert {f"tutorial_lib/{folder}/{file.name}" for file in files} <= set(names)
    assert not any(name.startswith(("tests", "notebooks", "solutions", "build")) for name in names)
    assert metadata["Version"] == tutorial_lib.__version__
    assert metadata["License-Expression"] == "MIT"
    assert "authors" in metadata["Author"]
    assert "topological map" in metadata["Keywords"]
    assert "Typing :: Typed" in metadata.get_all("Classifier")
    assert all("https://" in url for url in metadata.get_all("Project-URL"))
    extras = {"student", "test", "dev", "scale", "export", "docs", "rl"}
    assert set(metadata.get_all("Provides-Extra")) == extras
    required = [line for line in metadata.get_all("Requires-Dist") if "extra" not in line]
    assert any(line.startswith("jupyterlab") for line in required)
    assert not any(line.startswith(("playwright", "ruff", "pytest")) for line in required)


def test_the_version_stands_in_the_changes_and_the_citation():
    for name in ("CHANGELOG.md", "CITATION.cff"):
        text = (PROJECT / ".github" / name).read_text(encoding="utf-8")
        assert re.search(rf"^(?:## |version: ){tutorial_lib.__version__}$", text, re.M), name


@pytest.mark.full
def test_all_pages_are_copied_with_what_they_link_to(course):
    for folder in ("notebooks", "solutions"):
        for page in (PROJECT / folder).glob("*.ipynb"):
            assert (course.folder / folder / page.name).read_bytes() == page.read_bytes()
    pages = [*course.folder.glob("*.md"), *course.folder.glob("[ns]o*/*.[mi]*")]
    assert len(pages) > 20
    for page in pages:
        text = page.read_text(encoding="utf-8")
        if page.suffix == ".ipynb":
            cells = [cell for cell in json.loads(text)["cells"] if cell["cell_type"] == "markdown"]
            text = "\n".join("".join(cell["source"]) for cell in cells)
        for link in re.findall(r'(?:\]\(|href="|src=")([\w./][^)#"\s]*)', text):
            assert "://" in link or (page.parent / link).exists(), f"{page.name}: {link}"


def test_a_second_copy_keeps_what_the_student_wrote(course):
    notebook = course.folder / "notebooks" / "01_world_and_car.ipynb"
    before = notebook.read_bytes()
    notebook.write_bytes(before + b"\n")
    try:
        assert "kept" not in course.do("copy")
        assert notebook.read_bytes() == before + b"\n"
    finally:
        notebook.write_bytes(before)


@pytest.mark.full
def test_answers_are_saved_counted_and_marked_in_the_course_s_folder(course):
    (course.folder / "notebooks" / "cell.py").write_text(ANSWER)
    said = course.run(*course.python("cell.py"), folder="notebooks")
    assert "to_local" in said or said == ""
    assert (course.folder / "my_answers" / "01_to_local.py").is_file()
    assert re.search(r"^  x to_local ", course.do("progress"), re.M)
    assert "to_local: passed" in course.do("mark", "my_answers")


@pytest.mark.full
def test_results_are_written_into_the_course_s_folder(course):
    page = course.folder / "tutorial_lib" / "results" / "README.md"
    page.write_text("old")
    assert "wrote tutorial_lib/results/README.md" in course.do("results").replace("\\", "/")
    assert page.read_bytes() == (PROJECT / "tutorial_lib" / "results" / "README.md").read_bytes()


@pytest.mark.full
def test_the_demo_runs_in_it(course):
    course.do("demo")
    assert (course.folder / "demo.webm").stat().st_size > 10_000


def test_nothing_was_written_where_it_is_installed(course):
    assert course.state() == course.installed
