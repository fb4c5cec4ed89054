"""Options and small worlds that several tests share."""

import numpy as np
import pytest

from tutorial_lib.world.floorplan import FloorPlan, Room
from tutorial_lib.world.materials import Material, Stripe
from tutorial_lib.world.scene import Scene


def pytest_addoption(parser):
    parser.addoption("--full", action="store_true", help="also what is slow: see the marker 'full'")


def pytest_configure(config):
    config.addinivalue_line("markers", "full: runs only with --full")


def pytest_collection_modifyitems(config, items):
    if not config.getoption("--full"):
        for item in items:
            if item.get_closest_marker("full"):
                item.add_marker(pytest.mark.skip(reason="slow: start.py test --full runs it"))


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


@pytest.fixture
def box():
    """A scene of an empty 10 m x 10 m room."""
    return Scene(make_box())


@pytest.fixture
def pillars():
    """A scene of a room with three pillars."""
    return Scene(make_box(pillars=[(3.0, 3.0, 0.5), (6.5, 4.0, 0.3), (5.0, 7.5, 0.8)]))


def random_walls(count, side, rng):
    """Walls (count, 4) of 0.5 to 3 m, anywhere in a square."""
    middle, angle = rng.uniform(0, side, (count, 2)), rng.uniform(0, 2 * np.pi, count)
    half = np.stack([np.cos(angle), np.sin(angle)], axis=1) * rng.uniform(0.25, 1.5, (count, 1))
    return np.concatenate([middle - half, middle + half], axis=1)
