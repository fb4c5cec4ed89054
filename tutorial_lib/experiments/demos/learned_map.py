"""Learned maps that are kept, so that a demo need not learn them first.

The name of a map's file ends in a digest of all that the map depends on: it is found for exactly
what it was learned from, and never takes another's place. One map comes with the library, and is
only read; what is learned is kept in the user's cache.
"""

import hashlib
import re
from pathlib import Path

import numpy as np

from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.course import cache_folder
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.protocols.navigation_tasks import Building
from tutorial_lib.files import make_folder
from tutorial_lib.learning.networks import LocalNetwork
from tutorial_lib.learning.weights import digest_of
from tutorial_lib.topology.mapping.storage import load_map, save_map
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.validation import instance
from tutorial_lib.world.plan_json import plan_to_json

SHIPPED = Path(__file__).resolve().parent / "maps"
"""The folder of the map that comes with the library."""
_DIGITS = 12
_GRAIN, _SHIFT = 0.01, 0.37
"""Metres and rad to which poses are compared: another processor rounds their last bits differently.
Steps lie off the round numbers at which many poses are."""


def load_learned(
    building: Building, agent: MengAgent, *folders: Path
) -> tuple[TopoMap, Path] | None:
    """The map that this agent learned of this building, and its file; None if none was kept.

    None is kept of a reachability estimator of the user's own: nothing tells what it depends on.

    Args:
        building: with the drives that are learned.
        agent: with its networks and settings.
        folders: to look in; the user's cache and `SHIPPED` unless given.
    """
    if not isinstance(getattr(agent.reachability, "network", None), LocalNetwork):
        return None
    for folder in folders or (learned_maps(), SHIPPED):
        file = folder / _name(building, agent)
        try:
            return load_map(file, agent.reachability), file
        except InputError:
            continue  # it is learned again
    return None


def keep_learned(building: Building, agent: MengAgent, folder: Path | None = None) -> Path:
    """Keep the map that an agent learned of a building; returns its file.

    Raises:
        InputError: when it cannot be written.
    """
    folder = learned_maps() if folder is None else folder
    try:
        make_folder(folder)
    except OSError as error:
        advice = "set TUTORIAL_CACHE to a folder that you may write to"
        raise InputError(f"{folder}: cannot be made ({error.strerror}); {advice}") from error
    file = folder / _name(building, agent)
    save_map(file, agent.topomap)
    return file


def learned_maps() -> Path:
    """The folder of the user's learned maps."""
    return cache_folder() / "learned_maps"


def _name(building: Building, agent: MengAgent) -> str:
    """Names the building, and in a digest the networks, the settings, and what was recorded."""
    rules = agent.settings, agent.turns, agent.p_sparsify, agent.predictor.k
    network = instance(
        "reachability.network", getattr(agent.reachability, "network", None), LocalNetwork
    )
    digest = hashlib.sha256(repr((digest_of(network), *rules)).encode())
    digest.update(plan_to_json(building.scene.plan).encode())
    for drive in building.recorded.trajectories:
        for seen in (drive.poses, drive.odometry):
            cells = np.floor(seen / _GRAIN + _SHIFT).astype("<i8")
            digest.update(f"{cells.shape}".encode() + cells.tobytes())
    stem = re.sub(r"[^\w-]+", "-", building.name)
    return f"{stem}-{digest.hexdigest()[:_DIGITS]}.npz"
