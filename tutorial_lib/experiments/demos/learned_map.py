"""The learned map that comes with the demo, so that it need not be learned first."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from tutorial_lib.agents.meng import MengAgent
from tutorial_lib.errors import InputError
from tutorial_lib.experiments.protocols.navigation_tasks import Building
from tutorial_lib.files import write_text
from tutorial_lib.learning.weights import digest_of
from tutorial_lib.reading.documents import read_json
from tutorial_lib.topology.mapping.storage import load_map, save_map
from tutorial_lib.topology.mapping.topomap import TopoMap

FOLDER = Path(__file__).resolve().parent / "maps"


def load_learned(building: Building, agent: MengAgent, folder: Path = FOLDER) -> TopoMap | None:
    """The map that this agent learned of this building; None if none was kept, or of others."""
    map_file, origin_file = _files(building, folder)
    try:
        if read_json(origin_file) != _origin(building, agent):
            return None
        return load_map(map_file, agent.reachability)
    except InputError:
        return None  # it is learned again


def keep_learned(building: Building, agent: MengAgent, folder: Path = FOLDER) -> Path:
    """Keep the map that an agent learned of a building; returns its file."""
    map_file, origin_file = _files(building, folder)
    folder.mkdir(parents=True, exist_ok=True)
    save_map(map_file, agent.topomap)
    write_text(origin_file, json.dumps(_origin(building, agent), indent=1) + "\n")
    return map_file


def _files(building: Building, folder: Path) -> Iterator[Path]:
    stem = building.name.replace(" ", "-")
    return (folder / f"{stem}{suffix}" for suffix in (".json", ".origin.json"))


def _origin(building: Building, agent: MengAgent) -> dict[str, Any]:
    """What a map depends on: networks, settings, and what was recorded."""
    return {
        "reachability": digest_of(agent.reachability.network),
        "settings": repr(agent.settings),
        "p_sparsify": agent.p_sparsify,
        "frames": [len(trajectory) for trajectory in building.recorded.trajectories],
    }
