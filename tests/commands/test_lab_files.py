"""A notebook is opened without the widgets of a kernel that has ended, and is then as saved."""

import asyncio
from pathlib import Path

import nbformat
import pytest
from ipykernel.ipkernel import IPythonKernel
from nbformat.v4 import new_code_cell, new_markdown_cell, new_notebook, new_output
from traitlets.config import Configurable
from traitlets.utils.importstring import import_item

from tutorial_lib.commands.lab import lab_arguments
from tutorial_lib.commands.lab_files import CourseFiles
from tutorial_lib.commands.outputs import WIDGET

BAR = new_output(
    "display_data", {"text/plain": "0%| | 0/3 [00:00<?, ?it/s]", WIDGET: {"model_id": "2"}}
)
STILL = new_output("display_data", {"image/png": "AA==", WIDGET: {"model_id": "1"}})


class Server(Configurable):
    """A server on which some notebooks have a kernel."""

    def __init__(self, *paths):
        super().__init__()
        self.session_manager, self.paths = self, paths

    async def list_sessions(self):
        return [{"path": path} for path in self.paths]


@pytest.fixture(autouse=True)
def data(monkeypatch, tmp_path):
    monkeypatch.setenv("JUPYTER_DATA_DIR", str(tmp_path / "data"))  # where signatures are kept


def opened(folder, server, kernel="python3", path="notebooks/one.ipynb", **options):
    """What JupyterLab gets of a notebook that was run and saved."""
    cells = [new_markdown_cell("# One"), new_code_cell("x", outputs=[STILL, BAR])]
    spec = {"name": kernel, "display_name": "a kernel"}
    (folder / "notebooks").mkdir()
    nbformat.write(new_notebook(cells=cells, metadata={"kernelspec": spec}), folder / path)
    files = CourseFiles(parent=server, root_dir=str(folder))
    return asyncio.run(files.get(path, **options))


def test_jupyterlab_is_started_with_these_files():
    option = "--ServerApp.contents_manager_class"
    given = dict(argument.partition("=")[::2] for argument in lab_arguments(Path(), []))
    assert import_item(given[option]) is CourseFiles


def test_without_its_kernel_the_pictures_of_widgets_stand_alone(tmp_path):
    there = opened(tmp_path, Server("notebooks/two.ipynb", "one.ipynb"))["content"]
    (still,) = there["cells"][1]["outputs"]
    assert still["data"] == {"image/png": "AA=="}
    assert WIDGET in (tmp_path / "notebooks/one.ipynb").read_text()  # opening writes nothing


def test_with_its_kernel_all_widgets_but_bars_stay(tmp_path):
    there = opened(tmp_path, Server("notebooks/one.ipynb"))["content"]
    (still,) = there["cells"][1]["outputs"]
    assert still["data"] == STILL["data"]


@pytest.mark.parametrize(("kernel", "written"), [("python3", True), ("ir", False)])
def test_what_the_kernel_would_write_is_there(tmp_path, kernel, written):
    metadata = opened(tmp_path, Server(), kernel)["content"]["metadata"]
    assert metadata.get("language_info") == (IPythonKernel.language_info if written else None)


def test_files_folders_and_what_is_asked_without_content_are_as_ever(tmp_path):
    assert opened(tmp_path, Server(), content=False)["content"] is None
    (tmp_path / "notes.md").write_text("Notes.")
    files = CourseFiles(parent=Server(), root_dir=str(tmp_path))
    assert asyncio.run(files.get("notes.md"))["content"] == "Notes."
    names = [file["name"] for file in asyncio.run(files.get(""))["content"]]
    assert {"notebooks", "notes.md"} <= set(names)
