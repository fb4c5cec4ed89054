"""The notebooks in JupyterLab in a real browser, as a student sees them.

BROWSER_SCREENSHOTS=FOLDER leaves pictures of them there, one for each screenful.
"""

import os
import shutil
from pathlib import Path

import nbformat
import pytest

from tests.project.browser import FLAGS, RUN, START, Lab, NotebookPage, find_browser, is_foreign

PROJECT = Path(__file__).resolve().parents[2]
ALWAYS = ("01_world_and_car",)
NOTEBOOKS = sorted({*ALWAYS, *(file.stem for file in (PROJECT / "notebooks").glob("*.ipynb"))})

DRIVES = r"""
import cv2
import ipywidgets as widgets
import numpy as np
from IPython.display import HTML, display

def draw(level):
    return cv2.imencode(".png", np.full((40, 60), level, np.uint8))[1].tobytes()

image = widgets.Image(value=draw(0), format="png")
speed = widgets.FloatSlider(description="speed", value=0.0, max=1.0, step=0.1)
speed.observe(lambda change: setattr(image, "value", draw(int(200 * change.new))), "value")
steps, label = [], widgets.HTML("step 0")
button = widgets.Button(description="Drive")

def drive(_):
    steps.append(1)
    label.value = f"step {len(steps)}"

button.on_click(drive)
display(widgets.VBox([image, speed, widgets.HBox([button, label])]))
""", r"""
@widgets.interact(
    full=widgets.IntSlider(value=9, max=9, description="full"),
    span=widgets.IntRangeSlider(value=(2, 5), max=9, description="span"),
    height=widgets.IntSlider(value=2, max=9, orientation="vertical", description="height"),
    kind=widgets.ToggleButtons(options=["flat", "office"], description="kind"),
    family=["one", "two"],
)
def show(full, span, height, kind, family):
    print(full, span, height, kind, family)
""", r"""
frame = widgets.Play(max=50, interval=100)
number = widgets.HTML("0")
frame.observe(lambda change: setattr(number, "value", str(change.new)), "value")
widgets.HBox([frame, number])
""", r"""
display(HTML("<b>Exercise 1: not attempted.</b>"))
"""  # fmt: skip

FAULTS = r"""
import ipywidgets as widgets
from IPython.display import HTML, Javascript, display

output = widgets.Output()
same = widgets.IntSlider(description="same again")

@output.capture(clear_output=True)
def repeat(_):
    print("the same text")

repeat(None)
same.observe(repeat, "value")
dead = [widgets.IntSlider(description="dead"), widgets.Button(description="Dead")]
display(widgets.VBox([widgets.HTML("numbers"), *dead, same, output]))
""", r"""
half = widgets.Button(description="Half")
text = widgets.HTML("before")

def press(_):
    text.value = "after"
    raise KeyError("half way")

half.on_click(press)
display(half, text)
""", r"""
HTML('<img src="http://example.invalid/x.png">')
""", r"""
Javascript('''
console.error("a loud complaint");
setTimeout(() => { throw new Error("thrown later"); });
new WebSocket("ws://example.invalid/socket");
window.jupyterapp.commands.execute(
    "apputils:notify", {message: "Read the news?", type: "info", options: {autoClose: false}}
);
''')
""", r"""
off = widgets.Button(description="Off", disabled=True)
off
""", r"""
raise ValueError("boom")
""", r"""
print("never")
"""  # fmt: skip


SAVED = r"""
import numpy as np
from tutorial_lib.viz import sliders

sliders(lambda grey: (np.full((60, 90, 3), grey, np.uint8), f"{grey}"), grey=(0, 200, 10, 100))
""", r"""
from tqdm.auto import tqdm

list(tqdm(range(3), leave=False))
"""  # fmt: skip


@pytest.fixture(scope="module")  # not session: while it lives, no other test can run an event loop
def lab(tmp_path_factory):
    """JupyterLab on copies of the notebooks, and a browser."""
    api = pytest.importorskip(
        "playwright.sync_api", reason="no playwright: pip install -e .[test] (start.py test does)"
    )
    path = find_browser()
    if not path:
        pytest.skip("no chromium or google-chrome on the PATH: sudo apt install chromium")
    with Lab(tmp_path_factory.mktemp("lab")) as server, api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=list(FLAGS))
        server.context = browser.new_context(
            viewport={"width": 1280, "height": 900}, service_workers="block"
        )
        yield server
        browser.close()


def check(lab, notebook, screenshots=None, **options):
    page = NotebookPage(lab.context, lab, notebook, **options)
    try:
        return page.check(screenshots)
    finally:
        page.close()


def write(lab, name, sources):
    """A notebook of these cells."""
    cells = [nbformat.v4.new_code_cell(source.strip()) for source in sources]
    kernel = {"name": "python3", "display_name": "Python 3 (ipykernel)", "language": "python"}
    notebook = nbformat.v4.new_notebook(cells=cells, metadata={"kernelspec": kernel})
    nbformat.write(notebook, lab.root / name)
    return lab.root / name


@pytest.fixture(scope="module")
def faults(lab):
    """The report on a notebook in which everything is wrong that the test looks for."""
    return check(lab, write(lab, "self_test_faults.ipynb", FAULTS), change=2)


@pytest.mark.full
def test_it_drives_a_notebook_that_is_right(lab):
    report = check(lab, write(lab, "self_test_drives.ipynb", DRIVES))
    assert report.problems == []
    assert report.moved == ["speed", "full", "span", "span", "height", "family"]
    assert report.pressed == ["Drive", "office", "flat", "Play"]


@pytest.mark.full
@pytest.mark.parametrize(
    "problem",
    [
        "cell 1: slider 'dead' changes neither picture nor text",
        "cell 1: slider 'same again' changes neither picture nor text",
        "cell 1: button 'Dead' changes neither picture nor text",
        "a control raises KeyError: 'half way'",
        "another host is asked: http://example.invalid/x.png",
        "another host is asked: ws://example.invalid/socket",
        "the console shows an error: a loud complaint",
        "the console shows an error: thrown later",
        "cell 5: button 'Off' is hidden or disabled",
        "cell 6 raises ValueError: boom",
        "JupyterLab shows a notification: Read the news?",
        "cell 7 was not run",
    ],
)
def test_it_finds(faults, problem):
    assert any(found.startswith(problem) for found in faults.problems), faults.problems


@pytest.mark.full
def test_a_question_of_jupyterlab_is_reported_at_once(lab):
    notebook = write(lab, "self_test_kernel.ipynb", ["1"])
    notebook.write_text(notebook.read_text().replace('"python3"', '"no_such_kernel"'))
    with pytest.raises(AssertionError, match=r"self_test_kernel: JupyterLab asks: .*Kernel"):
        check(lab, notebook)


@pytest.mark.full
def test_it_finds_nothing_else(faults):
    failed = [found for found in faults.problems if "example.invalid" not in found]
    assert len(failed) == 10, failed


def opened(lab, server, notebook):
    """A page whose kernel has started."""
    page = NotebookPage(lab.context, server, notebook)
    page._wait("course.idle()", START, "the kernel does not start")
    page.page.wait_for_timeout(2000)  # JupyterLab writes what it knows of the kernel
    return page


@pytest.mark.full
@pytest.mark.parametrize("folder", ["notebooks", "solutions"])
def test_what_was_only_opened_is_not_to_be_saved(lab, folder):
    copy = lab.root / f"opened {folder}"
    shutil.copytree(PROJECT / folder, copy, ignore=shutil.ignore_patterns("*.py", ".*"))
    page = opened(lab, lab, copy / f"{ALWAYS[0]}.ipynb")
    dirty = page.page.evaluate("course.panel().context.model.dirty")
    page.close()
    assert not dirty


@pytest.mark.full
def test_a_saved_notebook_shows_its_sliders_and_without_its_kernel_their_picture(lab, tmp_path):
    server = Lab(tmp_path)
    notebook = write(server, "saved.ipynb", SAVED)
    sliders, picture = ".jp-Cell .noUi-handle", ".jp-Cell .jp-RenderedImage img"
    with server:
        page = opened(lab, server, notebook)
        page.page.evaluate("course.run()")
        page._wait("course.finished && course.idle()", RUN, "not at its end")
        page.page.evaluate("course.panel().context.save()")
        page.page.reload()
        page.page.wait_for_selector(sliders)
        assert page.page.locator(picture).count() == 0
        page.page.close()  # its kernel goes on
    with server:  # the next day
        page = opened(lab, server, notebook)
        page.page.wait_for_selector(picture)
        assert page.page.locator(sliders).count() == 0
        assert "widget" not in page.page.locator(".jp-Notebook").inner_text()
        assert not page.page.evaluate("course.panel().context.model.dirty")
        page.close()


@pytest.mark.parametrize(
    ("url", "foreign"),
    [
        ("http://127.0.0.1:8888/lab", False),
        ("ws://localhost:8888/api", False),
        ("data:image/png;base64,AA", False),
        ("blob:http://127.0.0.1:8888/1", False),
        ("https://cdn.example.org/font.css", True),
        ("http://127.0.0.1.example.org/", True),
    ],
)
def test_foreign_addresses(url, foreign):
    assert is_foreign(url) == foreign


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=[] if n in ALWAYS else pytest.mark.full) for n in NOTEBOOKS],
)
def test_notebook(lab, name):
    if not (PROJECT / "solutions" / f"{name}.py").exists():
        pytest.skip(f"there is no solutions/{name}.py")
    copy = lab.root / name  # a folder each: one notebook must not live on what another leaves
    shutil.copytree(
        PROJECT / "notebooks", copy, ignore=shutil.ignore_patterns(".ipynb_checkpoints")
    )
    assert (copy / f"{name}.ipynb").exists(), "not built: python -m tutorial_lib build"
    report = check(lab, copy / f"{name}.ipynb", os.environ.get("BROWSER_SCREENSHOTS"))
    assert report.problems == []
    assert report.moved or report.pressed, "no control to move or to press"
