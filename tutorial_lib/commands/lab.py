"""Opens JupyterLab on the first notebook."""

import os
from pathlib import Path

from tutorial_lib.commands.constants import INTERRUPTED
from tutorial_lib.course import course_folder, find_course, is_checkout

_CONFIG = Path(__file__).with_name("jupyter")
"""Defaults of JupyterLab's settings: it does not ask whether to fetch news."""


def lab_arguments(folder: Path, arguments: list[str]) -> list[str]:
    """JupyterLab's arguments to open the first notebook of a folder; those given go before."""
    ours = [
        f"--ServerApp.root_dir={folder}",
        "--LabApp.default_url=/lab/tree/notebooks/00_start_here.ipynb",
        "--ServerApp.contents_manager_class=tutorial_lib.commands.lab_files.CourseFiles",
        "--LabApp.news_url=None",  # works offline: no news, no check for updates
        "--LabApp.check_for_updates_class=jupyterlab.NeverCheckForUpdate",
        *(["--allow-root"] if hasattr(os, "geteuid") and os.geteuid() == 0 else []),
    ]
    given = {argument.partition("=")[0] for argument in arguments}
    return [option for option in ours if option.partition("=")[0] not in given] + arguments


def open_lab(arguments: list[str]) -> int:
    """Open JupyterLab in this process, so that it hears each signal, until it is closed.

    Of an installed course the pages that are missing are copied before, to where one is.

    Returns:
        The exit code.
    """
    if not is_checkout():
        from tutorial_lib.commands.copy import copy_here

        copy_here(find_course() or Path.cwd())
    paths = [os.environ.get("JUPYTER_CONFIG_PATH"), str(_CONFIG)]
    os.environ["JUPYTER_CONFIG_PATH"] = os.pathsep.join(filter(None, paths))
    from jupyterlab.labapp import main

    try:
        main(lab_arguments(course_folder(), arguments))
    except KeyboardInterrupt:
        return INTERRUPTED
    return 0
