"""Opens JupyterLab on the first notebook."""

from __future__ import annotations

import os
import subprocess
import sys

from tutorial_lib.commands.constants import INTERRUPTED, PROJECT


def lab_command(arguments: list[str]) -> list[str]:
    """The command line that opens JupyterLab on the first notebook."""
    return [
        sys.executable,
        "-m",
        "jupyterlab",
        f"--ServerApp.root_dir={PROJECT}",
        "--LabApp.default_url=/lab/tree/notebooks/00_start_here.ipynb",
        "--LabApp.news_url=None",  # works offline: no news, no check for updates
        "--LabApp.check_for_updates_class=jupyterlab.NeverCheckForUpdate",
        *(["--allow-root"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []),
        *arguments,
    ]


def open_lab(arguments: list[str]) -> int:
    """Open JupyterLab, wait until it is closed, and return its exit code."""
    try:
        return subprocess.call(lab_command(arguments))
    except KeyboardInterrupt:
        return INTERRUPTED
