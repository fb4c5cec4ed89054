"""Doors of the modules without a package."""

import tempfile
from pathlib import Path

import gymnasium
import numpy as np

from tests.doors.arguments import (
    a,
    flag,
    floats,
    function,
    images,
    path,
    several,
    text,
    whole,
)
from tests.doors.walk import anything, call, numbers
from tutorial_lib import environments, files, geometry, interfaces, observation, parallel

POSES = np.array([[1.0, 2.0, 0.5], [2.0, 1.0, -0.5]])
POINTS = np.array([[1.0, 1.0], [3.0, 2.0]])


def seen(count=2):
    """What robots observe."""
    return observation.Observation(**{n: g.value for n, g in senses(count).items()})


def senses(count=2):
    """The fields of an observation: NaN and infinite where a sensor says nothing."""
    sensed = {"nan": True, "infinite": True, "either": "huge, all huge"}
    return {
        "image": images(
            np.zeros((count, 16, 64, 3)), ("N", "H", "W", "C"), takes="float, int64", either="bool"
        ),
        "depth": floats(np.ones((count, 64)), ("N", "D"), optional=True, **sensed),
        "laser": floats(np.ones((count, 96)), ("N", "B"), **sensed),
        "odometry": floats(np.zeros((count, 3)), ("N", 3), **sensed),
        "speed": floats(np.zeros(count), ("N",), **sensed),
        "steering": floats(np.zeros(count), ("N",), **sensed),
    }


class Sees(gymnasium.Env):
    """Observes a view and the goal's, and nothing else."""

    observation_space = gymnasium.spaces.Dict(
        {
            name: gymnasium.spaces.Box(0, 255, (16, 192, 3), np.uint8)
            for name in ("image", "goal_image")
        }
    )


def pose_pair(function, first, second):
    """A call with two arrays of poses that go together."""
    names = {first: floats(POSES, (..., 3)), second: floats(POSES[::-1], (..., 3))}
    return call(function, **names)


def in_folder(function, name="file.txt", **arguments):
    """A call that writes a file into a folder of its own."""

    def run(path, **rest):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / path if isinstance(path, str) else path
            return function(path, **rest)

    return call(run, anything, path=path(name), **arguments)


def enter(manager):
    """A function that opens and closes what it gets."""

    def run(path):
        with manager(path):
            pass

    return run


DOORS = {
    "FlatViews": lambda: call(
        environments.FlatViews,
        anything,
        env=a(Sees()),
        rows=whole(4, least=1, most=16),
        columns=whole(32, least=1, most=192),
    ),
    "OneImage": lambda: call(
        environments.OneImage, anything, env=a(Sees()), least_rows=whole(36, least=1, most=4096)
    ),
    "wrap": lambda: call(geometry.wrap, angle=floats([1.0, 2.0])),
    "to_local": lambda: call(
        geometry.to_local, pose=floats(POSES, (..., 3)), points=floats(POINTS, (..., 2))
    ),
    "to_world": lambda: call(
        geometry.to_world, pose=floats(POSES, (..., 3)), points=floats(POINTS, (..., 2))
    ),
    "compose": lambda: pose_pair(geometry.compose, "first", "second"),
    "relative": lambda: pose_pair(geometry.relative, "origin", "pose"),
    "inverse": lambda: call(geometry.inverse, pose=floats(POSES, (..., 3))),
    "arc_length": lambda: call(
        geometry.arc_length,
        numbers,
        points=floats(POINTS, ("P", 2), empty=False, takes="longer axis 1"),
    ),
    "distance_to_segments": lambda: call(
        geometry.distance_to_segments,
        numbers,
        points=floats(POINTS, ("N", 2)),
        segments=floats([[0.0, 0.0, 1.0, 0.0]], ("S", 4)),
    ),
    "Observation": lambda: call(observation.Observation, anything, **senses()),
    "Observation.joined": lambda: call(
        observation.Observation.joined, anything, parts=several([seen(), seen()], empty=False)
    ),
    "Goals": lambda: call(
        observation.Goals,
        anything,
        observations=a(seen()),
        contexts=images(
            np.zeros((2, 5, 16, 64, 3)),
            (2, "K", "H", "W", "C"),
            takes="float, int64",
            either="bool",
        ),
    ),
    "Experience": lambda: call(
        observation.Experience,
        anything,
        observations=a(seen()),
        timestamps=floats([0.0, 0.1], (2,), refuses="negative"),
    ),
    "Plan": lambda: call(
        interfaces.Plan,
        vertices=several((1, 2), either="of numbers, empty"),
        goal=whole(0, least=0),
        probabilities=floats((0.5, 1.0, 1.0), (3,), least=0, most=1),
        refusal=text(""),
    ),
    "atomic_path": lambda: in_folder(enter(files.atomic_path)),
    "check_writable": lambda: in_folder(files.check_writable),
    "write_text": lambda: in_folder(files.write_text, text=text("words")),
    "save_arrays": lambda: in_folder(
        files.save_arrays,
        arrays=a({"x": np.zeros(3)}),
        version=whole(1, optional=True),
        compressed=flag(False),
    ),
    "for_each": lambda: call(
        parallel.for_each,
        work=function(str),
        items=a([1, 2], takes="list", either="text, no truth"),
        label=text("squares"),
        jobs=whole(1, refuses="huge"),
    ),
}
WITHOUT = {
    "FlatViews.observation": "gymnasium gives it what the environment observed",
    "OneImage.observation": "as FlatViews.observation",
    "for_baselines": "needs an extra; tests/test_environments.py gives it wrong arguments",
    "in_lock_step": "as for_baselines",
    "progress": "shows how far `for_each` is",
    "lines_of_progress": "as progress",
    "resumable": "of a folder that an experiment names",
    "atomic_paths": "as atomic_path",
    "sweep": "of folders that the library made",
    "make_folder": "of folders whose options the command line checks",
    "write_files": "as write_text",
    **dict.fromkeys(
        (
            "alike",
            "batch",
            "flag",
            "flags",
            "floats",
            "images",
            "instance",
            "instances",
            "listed",
            "integers",
            "match",
            "number",
            "one_of",
            "path_of",
            "whole",
            "fit_together",
            "with_methods",
        ),
        "a check itself: tests/test_validation.py",
    ),
}
