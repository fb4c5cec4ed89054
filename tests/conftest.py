"""Options and small worlds that several tests share, and how tests run side by side."""

import os
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

from tutorial_lib.driving.data.demonstrations import demonstrate
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.data.trajectories import Trajectory
from tutorial_lib.world.floorplan import FloorPlan, Room
from tutorial_lib.world.materials import Material, Stripe
from tutorial_lib.world.scene import Scene
from tutorial_lib.world.worlds import scene_of

# A busy machine is no defect.
settings.register_profile(
    "patient", deadline=None, max_examples=25, suppress_health_check=[HealthCheck.too_slow]
)
settings.register_profile("thorough", settings.get_profile("patient"), max_examples=100)
settings.load_profile("patient")


MOST_WORKERS = 4
"""Of the default run: each takes most of a gigabyte, and the longest tests take as long anyway."""
LIMITS = {"OMP_NUM_THREADS": "1", "LOKY_MAX_CPU_COUNT": "2"}
"""Of a worker: threads for numpy and torch, and processes, that it may start beside the others."""
ALONE = ("tests/checks/test_mutants.py", "tests/project/test_notebooks.py", "tests/test_cli.py")
"""Files whose tests share nothing slow: these are spread over the workers."""
LONGEST = (
    "tests/checks/test_mutants.py",
    "tests/project/test_notebooks.py",
    "tests/test_cli.py",
    "tests/experiments/",
    "tests/project/test_browser.py",
    "tests/project/test_fuzz.py",
    "tests/learning/",
)
"""What workers begin with: started last, one would still be at it when the others are done."""


def pytest_addoption(parser):
    parser.addoption("--full", action="store_true", help="also what is slow: see the marker 'full'")


@pytest.hookimpl(tryfirst=True)  # before xdist looks at the options
def pytest_cmdline_main(config):
    """Run folders side by side, and files in this process, unless given (-n)."""
    option = config.option
    if hasattr(config, "workerinput") or not hasattr(option, "numprocesses"):
        return  # a worker, or no xdist
    folders = all(Path(argument.partition("::")[0]).is_dir() for argument in config.args)
    if option.numprocesses is None and option.tx == [] and folders and option.capture != "no":
        option.numprocesses = "auto"
        option.maxprocesses = option.maxprocesses or MOST_WORKERS
    if option.numprocesses and option.dist == "no":
        option.dist = "loadfile"
        option.maxworkerrestart = option.maxworkerrestart or "0"  # a crash ends the run


def pytest_configure(config):
    os.environ.setdefault("TUTORIAL_ANSWERS", "")  # answers that pass in a test are not kept
    config.addinivalue_line("markers", "full: runs only with --full")
    config.addinivalue_line("markers", "few(n): without --full only its first n cases run")
    if config.getoption("--full"):
        settings.load_profile("thorough")
    if getattr(config.option, "tx", []):  # the workers inherit it
        for name, value in LIMITS.items():
            os.environ.setdefault(name, value)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Keep the tests of a file together, since they share fixtures; some are spread."""
    if config.option.dist != "loadfile":
        return None
    from xdist.scheduler import LoadFileScheduling

    class Files(LoadFileScheduling):
        def _split_scope(self, nodeid):
            return nodeid if nodeid.startswith(ALONE) else super()._split_scope(nodeid)

    config.option.loadscopereorder = False  # as collected, not by the number of tests
    return Files(config, log)


def pytest_collection_modifyitems(config, items):
    if not config.getoption("--full"):
        cases = Counter()
        for item in items:
            test = item.nodeid.partition("[")[0]
            few = item.get_closest_marker("few")
            if item.get_closest_marker("full") or (few and cases[test] >= few.args[0]):
                item.add_marker(pytest.mark.skip(reason="slow: start.py test --full runs it"))
            cases[test] += 1
    if hasattr(config, "workerinput"):
        items.sort(key=lambda item: rank(item.nodeid))


def rank(nodeid):
    """The place of a test's file in `LONGEST`; after them for all others."""
    found = (n for n, name in enumerate(LONGEST) if nodeid.startswith(name))
    return next(found, len(LONGEST))


@pytest.fixture(scope="session", autouse=True)
def _one_thread():
    """Beside other workers a network has one thread: two would wait for each other's core."""
    if "PYTEST_XDIST_WORKER" not in os.environ:
        yield
        return
    import torch

    torch.set_num_threads(1)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(torch, "set_num_threads", lambda count: None)
        yield


def make_box(width=10.0, height=10.0, pillars=()):
    """A room from (0, 0) to (width, height), with square pillars (x, y, half)."""
    outlines = [[(0, 0), (width, 0), (width, height), (0, height)]]
    outlines += [
        [(x - h, y - h), (x - h, y + h), (x + h, y + h), (x + h, y - h)] for x, y, h in pillars
    ]
    walls = np.array(
        [(*a, *b) for o in outlines for a, b in zip(o, o[1:] + o[:1], strict=True)], dtype=float
    )
    stripes = tuple(Stripe(float(k), k + 0.4, (k * 9, 255 - k * 9, 80)) for k in range(25))
    lengths = np.hypot(walls[:, 2] - walls[:, 0], walls[:, 3] - walls[:, 1])
    return FloorPlan(
        family="box",
        seed=0,
        walls=walls,
        wall_materials=("paint",) * len(walls),
        wall_offsets=np.cumsum(lengths) - lengths,
        materials=(Material("paint", (200, 190, 160), stripes),),
        rooms=(Room("living", tuple(outlines[0])),),
    )


def in_turn(work, places, *arguments, label):
    """`for_each` without other processes, in which a test would have changed nothing."""
    assert label
    return [work(place, *arguments) for place in places]


@pytest.fixture
def box():
    """A scene of an empty 10 m x 10 m room."""
    return Scene(make_box())


@pytest.fixture(scope="session")
def pillars():
    """A scene of a room with three pillars."""
    return Scene(make_box(pillars=[(3.0, 3.0, 0.5), (6.5, 4.0, 0.3), (5.0, 7.5, 0.8)]))


def random_walls(count, side, rng):
    """Walls (count, 4) of 0.5 to 3 m, anywhere in a square."""
    middle, angle = rng.uniform(0, side, (count, 2)), rng.uniform(0, 2 * np.pi, count)
    half = np.stack([np.cos(angle), np.sin(angle)], axis=1) * rng.uniform(0.25, 1.5, (count, 1))
    return np.concatenate([middle - half, middle + half], axis=1)


@pytest.fixture(scope="session")
def recorded():
    """Five or six trajectories in an office."""
    world = "office/1/standard"
    scene = scene_of(world)
    return RecordedWorld(scene, demonstrate(world, scene, 6, 3))


def make_trajectory(points, step=0.05):
    """A trajectory along a broken line (K, 2), a frame every `step` metres."""
    points = np.asarray(points, dtype=float)
    miles = np.concatenate([[0.0], np.hypot(*np.diff(points, axis=0).T).cumsum()])
    at = np.arange(0.0, miles[-1] + 1e-9, step)
    places = np.stack([np.interp(at, miles, column) for column in points.T], axis=1)
    leg = np.clip(np.searchsorted(miles, at, side="right") - 1, 0, len(points) - 2)
    along = np.diff(points, axis=0)[leg]
    return trajectory_of(np.column_stack([places, np.arctan2(along[:, 1], along[:, 0])]))


def trajectory_of(poses):
    """A trajectory that consists of nothing but its poses (T, 3)."""
    poses = np.asarray(poses, dtype=float)
    count = len(poses)
    laser, nothing = np.zeros((count, 96), np.float32), np.zeros(count)
    actions, time = np.zeros((count, 2)), np.arange(count) * 0.1
    return Trajectory("box", 0, poses, poses, laser, nothing, nothing, actions, time)


def needs(*weights):
    """Skips a test where these weights were not trained yet."""
    from tutorial_lib.learning.weights import FOLDER  # not all tests need torch

    missing = [name for name in weights if not (FOLDER / f"{name}.safetensors").is_file()]
    return pytest.mark.skipif(bool(missing), reason=f"not trained yet: {', '.join(missing)}")
