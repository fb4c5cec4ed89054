"""Every long job at its smallest, to be killed or given a full disk; and what is whole of a folder.

Each job is a function of the folder in which it works. A process that was forked where everything
is imported runs it, so that a hundred of them take minutes.
"""

import contextlib
import io
import json
import multiprocessing
import os
import signal
import sys
import time
from dataclasses import replace
from functools import partial
from pathlib import Path
from unittest import mock

import cv2
import joblib
import nbformat
import numpy as np

from tests.builder.test_notebooks import RUNNABLE, WRONG
from tests.topology.mapping.test_storage import grown
from tutorial_lib.cli import main
from tutorial_lib.commands import build as build_command
from tutorial_lib.commands import train as train_command
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.demos import navigation_demo
from tutorial_lib.experiments.demos.outcome import Outcome
from tutorial_lib.experiments.registry import EXPERIMENTS
from tutorial_lib.experiments.robustness import plans
from tutorial_lib.learning import recipes
from tutorial_lib.learning.batches import Source
from tutorial_lib.learning.networks import Architecture
from tutorial_lib.learning.training import Settings
from tutorial_lib.learning.weights import load_network, save_network
from tutorial_lib.reading.checksums import unsealed
from tutorial_lib.topology.mapping.storage import save_map
from tutorial_lib.viz.figures.film import _frames_in

TINY = recipes.Recipe(
    "tiny",
    "train waypoint --k 0",
    Architecture(0, "pair", outputs="action"),
    Settings(max_steps=24, targets=2, eval_interval=2, patience=99),
    worlds=2,
    validation_worlds=1,
    cars=3,
)
TEMPORARY = ".*.tmp*"


def train(folder):
    """Demonstrations, checkpoints and weights of a tiny network."""
    save = partial(save_network, folder=folder / "weights")
    with (
        mock.patch.dict(recipes.WAYPOINT, {"0": TINY}),
        mock.patch.object(recipes, "Source", partial(Source, worlds=2, targets=4)),
        mock.patch.object(recipes, "WORK", folder / "work"),
        mock.patch.object(train_command, "PROJECT", folder),
        mock.patch.object(train_command, "save_network", save),
    ):
        return main(["train", "waypoint", "--k", "0"])


def demo(folder):
    """A demo whose drive is made up, since only its film, its strip and its figures are written."""
    del folder  # it is the current one
    parts = {"choose_task": None, "learn_map": None, "drive_by_sight": made_up_drive}
    with contextlib.ExitStack() as stack:
        for name, part in parts.items():
            made = part or mock.MagicMock()
            stack.enter_context(mock.patch.object(navigation_demo, name, made))
        stack.enter_context(mock.patch.object(navigation_demo.agents, "meng", mock.MagicMock()))
        return main(["demo", "--seed", "3"])


def made_up_drive(task, agent, seed, say, beside, write, file):
    """Sixty frames that a film can hardly make smaller."""
    del task, agent, beside, file
    frames = np.random.default_rng(seed).integers(0, 256, (60, 120, 160, 3), np.uint8)
    for frame in frames:
        say("driving")
        write(frame)
    counts = ("rooms_away", "people", "plans", "drives", "composed_of", "vertices", "edges")
    numbers = dict.fromkeys(counts, 1)
    drive = {
        "reached": True,
        "ending": "reached the goal",
        "collided": False,
        "seconds": 1.0,
        "driven": 1.0,
    }
    words = {"name": "demo", "plan": "apartment 3", "rooms": ("hallway", "kitchen"), "map": None}
    words |= {"body": "BicycleCar()", "camera": "Camera()"}
    words |= {"start": (0.0, 0.0, 0.0), "goal": (1.0, 0.0, 0.0)}
    return frames, Outcome(**drive, **words, **numbers, seed=seed, geodesic=1.0, probability=0.9)


def experiment(folder):
    """The cheapest experiment, with its rows."""
    few = replace(plans.EXPERIMENT, quick_settings=plans.Settings(goals=2, driven=1))
    worlds = ["--worlds", "10500:10501", "--family", "maze"]
    with mock.patch.dict(EXPERIMENTS, {"plans": few}):
        return main(
            ["experiment", "plans", "--quick", *worlds, "--json", str(folder / "rows.json")]
        )


def build(folder):
    """A notebook for students, and the solved one, executed."""
    for place in ("notebooks", "solutions", "tests/wrong_answers"):
        (folder / place).mkdir(parents=True, exist_ok=True)
    (folder / "tests/wrong_answers/09_double.py").write_text(WRONG)
    text = f"{RUNNABLE}\n# %%\n# {time.time()}\nprint('x' * 100_000)\n"  # so it is executed again
    (folder / "solutions/09_double.py").write_text(text)
    guides = mock.patch.object(build_command, "write_guides", return_value=[])
    with guides, mock.patch.object(build_command, "PROJECT", folder):
        return main(["build"])


def save(folder):
    """Maps of several sizes, one over the other."""
    maps = [grown(1), grown(2), grown(3)]
    try:
        for number in range(60):
            save_map(folder / "flat.npz", maps[number % 3])
    except InputError as error:
        print(f"error: {error}", file=sys.stderr)  # as the command line does
        return 2
    return 0


JOBS = {job.__name__: job for job in (train, demo, experiment, build, save)}


def check_whole(folder):
    """Read every file but temporary ones to its end; returns their names."""
    found = []
    for path in sorted(p for p in folder.rglob("*") if p.is_file() and not p.match(TEMPORARY)):
        found.append(path.relative_to(folder).as_posix())
        if path.suffix == ".json":
            json.loads(path.read_text())
        elif path.suffix == ".npz":
            with np.load(path) as arrays:
                assert all(arrays[name] is not None for name in arrays)
        elif path.suffix == ".webm":
            film = cv2.VideoCapture(str(path))
            assert 20 < sum(iter(film.grab, False)) == _frames_in(path)
        elif path.suffix == ".png":
            assert cv2.imread(str(path)) is not None
        elif path.suffix == ".ipynb":
            nbformat.validate(nbformat.read(path, as_version=4))
        elif path.suffix == ".safetensors":
            load_network(path.stem, path.parent)
        elif path.suffix == ".pt":
            import torch

            state = io.BytesIO(unsealed(path.read_bytes()))
            assert torch.load(state, weights_only=True)["step"] > 0
    return found


def temporaries(folder):
    """The temporary files in a folder and all below it."""
    return [path for path in folder.rglob(TEMPORARY) if path.is_file()]


def quietly(name, folder):
    """Run a job in this process without its words; its exit code, and what it said of errors."""
    os.chdir(folder)
    said = io.StringIO()
    with (
        contextlib.redirect_stdout(io.StringIO()),
        contextlib.redirect_stderr(said),
        joblib.parallel_config(backend="sequential"),
    ):
        return JOBS[name](Path(folder)), said.getvalue()


def child(name, folder):
    """What a process of its own does, whose children are killed with it."""
    os.setpgrp()
    sys.exit(quietly(name, folder)[0])


def forks():
    """Starts processes in which everything is imported."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["tests.jobs"])
    return context


def started(context, name, folder):
    """A job under way."""
    process = context.Process(target=child, args=(name, folder), daemon=False)
    process.start()
    return process


def killed(process, after):
    """Kill a job and what it has started, after some seconds; whether it was still at work."""
    process.join(after)
    running = process.is_alive()
    for kill in (lambda: os.killpg(process.pid, signal.SIGKILL), process.kill):
        with contextlib.suppress(ProcessLookupError):
            kill()
    process.join()
    return running
