"""JupyterLab and its kernels end with start.py, in whichever way that is told to."""

import json
import os
import signal
import urllib.request
from pathlib import Path

import psutil
import pytest

from tests.project.browser import Lab, listens

FILE = Path(__file__).resolve().parents[2] / "start.py"
START = f"""import importlib.util, os, sys
spec = importlib.util.spec_from_file_location("start", {str(FILE)!r})
start = importlib.util.module_from_spec(spec)
spec.loader.exec_module(start)
start.setup = lambda *_: None
start.python_of = lambda _: start.Path(sys.executable)
start.environment = lambda: {{**os.environ, "PYTHONPATH": {str(FILE.parent)!r}}}
sys.exit(start.main(["lab", *sys.argv[1:]]))"""


def ask(lab, path, **options):
    """What JupyterLab answers, from JSON."""
    headers = {"Authorization": f"token {lab.token}"}
    request = urllib.request.Request(f"{lab.address}/api/{path}", headers=headers, **options)
    with urllib.request.urlopen(request, timeout=30) as answer:
        return json.loads(answer.read())


@pytest.mark.skipif(os.name == "nt", reason="POSIX signals")
@pytest.mark.parametrize("name", ["SIGTERM", pytest.param("SIGHUP", marks=pytest.mark.full)])
def test_jupyterlab_and_its_kernels_end_with_start(tmp_path, name):
    number = getattr(signal, name)
    with Lab(tmp_path, START) as lab:
        ask(lab, "kernels", method="POST", data=b"{}")
        family = psutil.Process(lab.server.pid).children(recursive=True)
        assert len(family) >= 2  # JupyterLab and the kernel
        lab.server.send_signal(number)
        assert lab.server.wait(timeout=30) == 128 + number
        _, alive = psutil.wait_procs(family, timeout=10)
        assert alive == []
        assert not listens(lab.address)
