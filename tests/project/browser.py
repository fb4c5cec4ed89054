"""JupyterLab in a real browser: starts both, runs a notebook, moves and presses what it shows."""

import contextlib
import json
import os
import secrets
import shutil
import signal
import socket
import subprocess
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import quote, urlsplit

import psutil

from tests.conftest import LIMITS

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FLAGS = (
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--no-proxy-server",
    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",  # as on a machine without network
)
# On Linux the server dies with the tests (1: PR_SET_PDEATHSIG, 9: SIGKILL); its kernels follow it.
LAUNCH = """import ctypes, sys
if sys.platform == "linux":
    ctypes.CDLL(None).prctl(1, 9)
from tutorial_lib.cli import main
sys.exit(main(["lab", *sys.argv[1:]]))"""
START, RUN, CHANGE = 90, 180, 15  # seconds: JupyterLab and kernel, a whole notebook, one control

# What the tests ask the page for. `signature` holds the pictures and the text of one cell's
# outputs but not what a control shows of itself: a slider's readout moves also if nothing else does
SCRIPT = r"""() => {
  const own = '.widget-slider, .jupyter-button, .widget-play, .widget-dropdown, style, script';
  const panel = () => window.jupyterapp.shell.currentWidget;
  const cells = () => panel().content.widgets;
  const hash = text => {
    let h = 0;
    for (let i = 0; i < text.length; i++) h = (Math.imul(h, 31) + text.charCodeAt(i)) | 0;
    return h + ':' + text.length;
  };
  const course = {
    errors: [], finished: false, panel,
    idle: () => panel().sessionContext.session?.kernel?.status === 'idle',
    notices: () => [...document.querySelectorAll('.Toastify__toast')].map(n => n.innerText),
    dialog: () => document.querySelector('.jp-Dialog')?.innerText ?? '',
    listen: () => panel().sessionContext.iopubMessage.connect((_, message) => {
      const {ename, evalue, name, text} = message.content;
      if (message.header.msg_type === 'error') course.errors.push(`${ename}: ${evalue}`);
      else if (name === 'stderr' && text?.includes('Traceback (most')) course.errors.push(text);
    }),
    run: () => {
      window.jupyterapp.commands.execute('notebook:run-all-cells')
        .finally(() => { course.finished = true; });
    },
    cells: () => cells().map((cell, index) => {
      cell.node.dataset.course = index;
      const json = cell.model.sharedModel.toJSON();
      return {
        code: cell.model.type === 'code', source: cell.model.sharedModel.source,
        count: json.execution_count ?? null,
        errors: (json.outputs ?? []).filter(o => o.output_type === 'error')
          .map(o => `${o.ename}: ${o.evalue}`),
      };
    }),
    show: index => panel().content.scrollToItem(index, 'center'),
    signature: index => {
      const parts = [];
      for (const area of cells()[index].node.querySelectorAll('.jp-Cell-outputArea')) {
        const texts = document.createTreeWalker(area, NodeFilter.SHOW_TEXT);
        while (texts.nextNode())
          if (!texts.currentNode.parentElement.closest(own)) parts.push(texts.currentNode.data);
        for (const node of area.querySelectorAll('img, video, source, canvas, svg, .progress-bar'))
          if (!node.closest(own))
            parts.push(node.toDataURL?.() ?? node.getAttribute('src') ?? node.outerHTML);
      }
      return hash(parts.join('\n'));
    },
  };
  window.course = course;
}"""

LABEL = """n => n.closest('.widget-slider, .widget-dropdown')
  ?.querySelector('.widget-label')?.textContent ?? ''"""


def find_browser():
    """Path of a Chromium or Chrome; None if there is none."""
    return next(filter(None, map(shutil.which, BROWSERS)), None)


def is_foreign(url):
    """Whether asking for this address would leave the machine."""
    parts = urlsplit(url)
    return parts.scheme not in ("data", "blob", "about") and parts.hostname not in (
        "127.0.0.1",
        "localhost",
    )


class Lab:
    """JupyterLab as the course starts it for a new user: no settings, nothing left behind."""

    def __init__(self, folder, launch=LAUNCH):
        self.launch = launch
        self.root = folder / "root"
        self.log = folder / "server.log"
        self.token = secrets.token_hex(16)
        self.runtime = folder / "runtime"
        names = {
            "JUPYTER_CONFIG_DIR": "config",
            "JUPYTER_DATA_DIR": "data",
            "JUPYTER_RUNTIME_DIR": "runtime",
            "JUPYTERLAB_SETTINGS_DIR": "settings",
            "JUPYTERLAB_WORKSPACES_DIR": "workspaces",
            "IPYTHONDIR": "ipython",
        }
        for name in ("root", *names.values()):
            (folder / name).mkdir(parents=True)
        kernel = folder / "data" / "kernels" / "python3" / "kernel.json"
        arguments = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
        write_json(
            kernel,
            {"argv": arguments, "display_name": "Python 3 (ipykernel)", "language": "python"},
        )
        self.environment = {
            **{k: v for k, v in os.environ.items() if k not in LIMITS and k[:7] != "JUPYTER"},
            **{name: str(folder / value) for name, value in names.items()},
            "JUPYTER_TOKEN": self.token,
            "JUPYTER_PREFER_ENV_PATH": "0",  # this kernel before one of the same name in .venv
        }

    def __enter__(self):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        command = [
            *(sys.executable, "-c", self.launch, "--no-browser", "--ip=127.0.0.1"),
            *(f"--port={port}", "--expose-app-in-browser", f"--ServerApp.root_dir={self.root}"),
        ]
        with self.log.open("w") as log:
            self.server = subprocess.Popen(
                command,
                cwd=self.root,
                env=self.environment,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        try:
            self.address = self._wait_for_address()
        except BaseException:
            self.__exit__()
            raise
        return self

    def _wait_for_address(self):
        """Where it listens: another port than asked for if that was taken meanwhile."""
        end = time.monotonic() + START
        while time.monotonic() < end and self.server.poll() is None:
            for file in self.runtime.glob("jpserver-*.json"):
                with contextlib.suppress(ValueError):  # half written
                    address = json.loads(file.read_text())["url"].rstrip("/")
                    if listens(address):
                        return address
            time.sleep(0.1)
        raise RuntimeError(f"JupyterLab does not start:\n{self.log.read_text()[-3000:]}")

    def __exit__(self, *_):
        """End the server's process group and its kernels, which have groups of their own."""
        try:
            parent = psutil.Process(self.server.pid)
            family = [*parent.children(recursive=True), parent]
        except psutil.NoSuchProcess:
            family = []
        if hasattr(os, "killpg"):
            with contextlib.suppress(ProcessLookupError):
                os.killpg(self.server.pid, signal.SIGTERM)  # it then ends its kernels
        else:
            self.server.terminate()
        _, alive = psutil.wait_procs(family, timeout=15)
        for process in alive:
            with contextlib.suppress(psutil.NoSuchProcess):
                process.kill()
        self.server.wait(timeout=15)

    def address_of(self, notebook):
        """The page with nothing but this notebook."""
        path = quote(notebook.relative_to(self.root).as_posix())
        return f"{self.address}/doc/tree/{path}?token={self.token}"


def listens(address):
    """Whether something answers at an address of this machine."""
    where = urlsplit(address)
    with socket.socket() as probe:
        return probe.connect_ex((where.hostname, where.port)) == 0


def write_json(file, content):
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(json.dumps(content), encoding="utf-8")


@dataclass
class Report:
    """What is wrong with a notebook, in words, and which controls were tried."""

    problems: list = field(default_factory=list)
    moved: list = field(default_factory=list)
    pressed: list = field(default_factory=list)
    screenshots: list = field(default_factory=list)


class NotebookPage:
    """One notebook, opened in the browser."""

    def __init__(self, context, lab, notebook, change=CHANGE):
        self.name, self.change, self.report = notebook.stem, change, Report()
        self.page = page = context.new_page()
        page.set_default_timeout(START * 1000)
        page.on("console", self._on_console)
        page.on("pageerror", lambda error: self._complain(f"the console shows an error: {error}"))
        page.on("crash", lambda: self._complain("the page crashed"))
        page.on("request", lambda request: self._on_address(request.url))
        page.on("websocket", lambda websocket: self._on_address(websocket.url))
        page.goto(lab.address_of(notebook))
        page.wait_for_function(
            "window.jupyterapp?.shell.currentWidget?.content?.widgets?.length > 0"
        )
        page.evaluate(SCRIPT)

    def _complain(self, problem):
        if problem not in self.report.problems:
            self.report.problems.append(problem)

    def _on_console(self, message):
        if message.type == "error":  # JupyterLab 4.6 itself writes none, so none is let through
            where = message.location.get("url", "").partition("?")[0]
            self._complain(f"the console shows an error: {message.text} ({where})")

    def _on_address(self, url):
        if is_foreign(url):
            self._complain(f"another host is asked: {url}")

    def check(self, screenshots=None):
        """Run the notebook and try every control; the report lists all that is wrong."""
        self._wait("course.idle()", START, "the kernel does not start")
        self.page.evaluate("course.listen(); course.run()")
        self._wait("course.finished && course.idle()", RUN, f"not at its end after {RUN} s")
        cells = self.page.evaluate("course.cells()")
        for number, cell in enumerate(cells, 1):
            for error in cell["errors"]:
                self._complain(f"cell {number} raises {error}")
            if cell["code"] and cell["source"].strip() and cell["count"] is None:
                self._complain(f"cell {number} was not run")
        if screenshots:
            self._take_screenshots(Path(screenshots))
        for index, cell in enumerate(cells):
            if cell["code"]:
                self._try_controls(index)
        for notice in self.page.evaluate("course.notices()"):
            self._complain(f"JupyterLab shows a notification: {notice}")
        for error in self.page.evaluate("course.errors"):
            if not any(error in problem for problem in self.report.problems):
                self._complain(f"a control raises {error}")
        return self.report

    def close(self):
        with contextlib.suppress(Exception):
            self.page.evaluate("course.panel().sessionContext.shutdown()")
        self.page.close()

    def _wait(self, condition, seconds, problem):
        """Wait for it, unless JupyterLab asks something: no such kernel, the kernel died."""
        from playwright.sync_api import TimeoutError as TooLate

        try:
            self.page.wait_for_function(
                f"course.dialog() || ({condition})", polling=50, timeout=seconds * 1000
            )
        except TooLate:
            raise AssertionError(f"{self.name}: {problem}; {self.report.problems}") from None
        if dialog := self.page.evaluate("course.dialog()"):
            raise AssertionError(f"{self.name}: JupyterLab asks: {dialog}; {self.report.problems}")

    def _try_controls(self, index):
        """Move every slider and list, press every button that this cell shows."""
        self.page.evaluate("index => course.show(index)", index)
        output = self.page.locator(f'[data-course="{index}"] .jp-Cell-outputArea')
        for act, selector in (
            (self._move, ".widget-slider .noUi-handle"),
            (self._choose, ".widget-dropdown select"),
            (self._press, ":not(.widget-play) > .jupyter-button"),
            (self._press, ".widget-play > .jupyter-button:first-child"),  # the others only stop it
        ):
            controls, k, chosen = output.locator(selector), 0, []
            while k < controls.count():  # a press can show more of them, or fewer
                if controls.nth(k).evaluate("n => n.matches('.widget-toggle-buttons .mod-active')"):
                    chosen.append(k)  # of several choices the one that holds: later
                else:
                    act(index, controls.nth(k))
                k += 1
            for k in chosen:
                act(index, controls.nth(k))

    def _move(self, index, handle):
        label = handle.evaluate(LABEL)
        name = f"slider {label!r}"
        if not self._is_usable(index, handle, name):
            return
        vertical = handle.get_attribute("aria-orientation") == "vertical"
        at, most = (float(handle.get_attribute(f"aria-value{x}")) for x in ("now", "max"))
        more, less = ("ArrowUp", "ArrowDown") if vertical else ("ArrowRight", "ArrowLeft")

        def action():
            handle.focus()
            self.page.keyboard.press(more if at < most else less)

        self._expect_change(index, name, action)
        self.report.moved.append(label)

    def _choose(self, index, select):
        label = select.evaluate(LABEL)
        name = f"list {label!r}"
        if not self._is_usable(index, select, name):
            return
        other = select.evaluate("n => (n.selectedIndex + 1) % n.length")
        self._expect_change(index, name, lambda: select.select_option(index=other))
        self.report.moved.append(label)

    def _press(self, index, button):
        plays = button.evaluate("n => !!n.closest('.widget-play')")
        shown = "Play" if plays else button.inner_text().strip()
        label = shown or button.get_attribute("title") or button.inner_html()
        name = f"button {label!r}"
        if not self._is_usable(index, button, name):
            return
        self._expect_change(index, name, button.click)
        if plays:
            button.click()  # pause, or the picture goes on changing by itself
        self.report.pressed.append(label)

    def _is_usable(self, index, control, name):
        usable = control.is_visible() and control.is_enabled()
        if not usable:
            self._complain(f"cell {index + 1}: {name} is hidden or disabled")
        return usable

    def _signature(self, index):
        return self.page.evaluate("index => [course.signature(index), course.idle()]", index)

    def _at_rest(self, index):
        """Signature once the kernel is idle and nothing has changed for 0.3 s; None if never."""
        end, before, since = time.monotonic() + max(self.change, 5), None, 0.0
        while time.monotonic() < end:
            now, idle = self._signature(index)
            if now != before or not idle:
                before, since = now, time.monotonic()
            elif time.monotonic() - since > 0.3:
                return now
            self.page.wait_for_timeout(50)
        return None

    def _expect_change(self, index, name, action):
        """Act; then picture or text must differ, twice in a row and with the work done."""
        before, seen = self._at_rest(index), 0
        if before is None:
            self._complain(f"cell {index + 1}: the output does not come to rest before {name}")
            return
        action()
        end = time.monotonic() + self.change
        while time.monotonic() < end:
            self.page.wait_for_timeout(50)
            now, idle = self._signature(index)
            seen = seen + 1 if now != before else 0
            if seen > 1 and idle:
                return
        if not seen:
            self._complain(f"cell {index + 1}: {name} changes neither picture nor text")

    def _take_screenshots(self, folder):
        """One picture for each screenful, numbered from the top."""
        folder.mkdir(parents=True, exist_ok=True)
        view = self.page.locator(".jp-WindowedPanel-outer").first
        view.evaluate("n => n.scrollTo(0, 0)")
        for number in range(1, 100):
            self.page.wait_for_timeout(300)
            file = folder / f"{self.name}_{number:02d}.png"
            view.screenshot(path=file)
            self.report.screenshots.append(file)
            moved = "n => { const t = n.scrollTop; n.scrollBy(0, n.clientHeight - 60);"
            if view.evaluate(moved + " return n.scrollTop - t; }") < 1:
                break
