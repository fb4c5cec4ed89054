"""The learned map that comes with the demo, so that it need not be learned first.

The name of a map's file ends in a digest of all that the map depends on: another map never takes
its place, whichever process learns it.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.protocols.navigation_tasks import Building
from tutorial_lib.files import make_folder
from tutorial_lib.learning.weights import digest_of
from tutorial_lib.topology.mapping.storage import load_map, save_map
from tutorial_lib.topology.mapping.topomap import TopoMap

FOLDER = Path(__file__).resolve().parent / "maps"
_DIGITS = 12


def load_learned(building: Building, agent: MengAgent, folder: Path = FOLDER) -> TopoMap | None:
    """The map that this agent learned of this building; None if none was kept."""
    try:
        return load_map(_file(building, agent, folder), agent.reachability)
    except InputError:
        return None  # it is learned again


def keep_learned(building: Building, agent: MengAgent, folder: Path = FOLDER) -> Path:
    """Keep the map that an agent learned of a building, in place of others; returns its file."""
    file = _file(building, agent, folder)
    make_folder(folder)
    save_map(file, agent.topomap)
    for other in folder.glob(f"{_stem(building)}-{'[0-9a-f]' * _DIGITS}.npz"):
        if other != file:
            other.unlink(missing_ok=True)
    return file


def _stem(building: Building) -> str:
    return building.name.replace(" ", "-")


def _file(building: Building, agent: MengAgent, folder: Path) -> Path:
    """Named by the networks, the settings, and what was recorded."""
    origin = (
        digest_of(agent.reachability.network),
        agent.settings,
        agent.turns,
        agent.p_sparsify,
        [len(trajectory) for trajectory in building.recorded.trajectories],
    )
    digest = hashlib.sha256(repr(origin).encode()).hexdigest()
    return folder / f"{_stem(building)}-{digest[:_DIGITS]}.npz"
