"""Notebooks as the course's JupyterLab opens them.

A saved notebook holds a widget by the name that its kernel gave it. Without that kernel JupyterLab
shows "model not found" in its place, though a picture stands beside it. JupyterLab's own setting
for this, `saveState`, helps once: what is opened and saved again has lost its widgets.
"""

from typing import Any

from ipykernel.ipkernel import IPythonKernel
from jupyter_server.services.contents.largefilemanager import AsyncLargeFileManager

from tutorial_lib.commands.outputs import without_bars, without_widgets


class CourseFiles(AsyncLargeFileManager):
    """JupyterLab's files, of which a notebook is opened as its kernel would leave it."""

    async def get(self, path: str, *options: Any, **named: Any) -> dict[str, Any]:  # noqa: ANN401 - Jupyter's
        """The model of a file or folder."""
        model = await super().get(path, *options, **named)
        if model["type"] == "notebook" and model["content"]:
            server: Any = self.parent
            sessions = await server.session_manager.list_sessions()
            runs = any(session["path"] == model["path"] for session in sessions)
            settle(model["content"], runs=runs)
        return model


def settle(notebook: dict[str, Any], *, runs: bool) -> None:
    """Change a notebook to what can be shown of it, and needs not be saved.

    Args:
        notebook: as its file holds it.
        runs: whether it has a kernel, which has its widgets.
    """
    shown = without_bars if runs else without_widgets  # a bar that was closed is gone in any case
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            cell["outputs"] = shown(cell["outputs"])
    if notebook["metadata"].get("kernelspec", {}).get("name") == "python3":
        # JupyterLab would write it once the kernel has started, and then ask whether to save.
        notebook["metadata"]["language_info"] = dict(IPythonKernel.language_info)
