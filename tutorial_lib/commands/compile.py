"""Compiles the numerical kernels, which otherwise the first drive has to wait for."""

import argparse

import numpy as np

from tutorial_lib.driving import RecordedWorld, demonstrate
from tutorial_lib.topology.mapping.scan_matching import match_scans
from tutorial_lib.world import scene_of

_WORLD = "apartment/0/standard"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """There are no options."""


def run(options: argparse.Namespace) -> int:
    """Record a few drives, and match their scans: numba keeps what it compiles for that."""
    del options
    scene = scene_of(_WORLD)
    recorded = RecordedWorld(scene, demonstrate(_WORLD, scene, count=4, seed=0))
    scans = recorded.observe(np.arange(4)).laser.astype(float)
    match_scans(scans, scans, np.zeros((4, 1, 3)))
    return 0
