"""Every loader, files that it reads, and what it makes of them as plain data."""

import json
import types
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields, is_dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import torch

from tests.conftest import make_box, make_trajectory
from tests.fuzz.sources import agent_sources
from tutorial_lib.builder.page import read_glossary
from tutorial_lib.checks.progress import progress
from tutorial_lib.driving.data.reachability_pairs import ReachabilityPairs
from tutorial_lib.driving.data.rollout_outcomes import (
    RolloutOutcomes,
    load_outcomes,
    save_outcomes,
)
from tutorial_lib.driving.data.trajectories import load_trajectories, save_trajectories
from tutorial_lib.experiments.common.agents import custom, guarded
from tutorial_lib.experiments.common.report import Report
from tutorial_lib.experiments.common.results import load_result
from tutorial_lib.experiments.demos.learned_map import keep_learned, load_learned
from tutorial_lib.interfaces import Observation
from tutorial_lib.learning.networks import Architecture, LocalNetwork
from tutorial_lib.learning.training import Settings, _State
from tutorial_lib.learning.weights import Card, load_card, load_network, save_network
from tutorial_lib.topology.following.log import FollowerLog
from tutorial_lib.topology.mapping.storage import load_map, save_map
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.world.importers import import_map
from tutorial_lib.world.plan_json import save_plan
from tutorial_lib.world.simulation import checked_actions

TINY = Architecture(0, "pair", outputs="action")


@dataclass(frozen=True)
class Target:
    """A loader.

    Attributes:
        name: of it.
        make: writes files that it reads into a folder.
        load: reads them again.
        sealed: what the names of files end in of which every altered byte must be noticed.
    """

    name: str
    make: Callable[[Path], object]
    load: Callable[[Path], Any]
    sealed: tuple[str, ...] = ()


def plain(value: Any) -> Any:
    """Any value as dictionaries, lists, arrays and what compares by itself."""
    if is_dataclass(value):
        found = {field.name: plain(getattr(value, field.name)) for field in fields(value)}
        return {"class": type(value).__name__, **found}
    if isinstance(value, torch.Tensor):
        return value.detach().numpy()
    if isinstance(value, dict):
        return {key: plain(part) for key, part in value.items()}
    return [plain(part) for part in value] if isinstance(value, list | tuple) else value


def same(one: Any, other: Any) -> bool:
    """Whether plain data is equal, to the last bit and in its types."""
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        alike = one.dtype == other.dtype and one.shape == other.shape
        return alike and one.tobytes() == other.tobytes()
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if isinstance(one, list):
        return len(one) == len(other) and all(map(same, one, other))
    return repr(one) == repr(other) if isinstance(one, float) else one == other


# Floor plans and imported maps.


def _draw(suffix: str, **keys: Any) -> Callable[[Path], None]:
    """Writes a ROS map with a picture of this suffix."""

    def make(folder: Path) -> None:
        cells = np.full((40, 48), 205, np.uint8)
        cells[4:36, 4:44] = 254
        cells[14:20, 20:30] = 0
        path = folder / f"map{suffix}"
        if suffix == ".txt.pgm":
            rows = "\n".join(" ".join(map(str, row)) for row in cells.tolist())
            path.write_text(f"P2\n# plain\n48 40\n255\n{rows}\n", encoding="ascii")
        elif suffix == ".pgm":
            path.write_bytes(b"P5\n48 40\n255\n" + cells.tobytes())
        elif suffix == ".rgba.png":
            opaque = np.full_like(cells, 255)
            assert cv2.imwrite(str(path), np.dstack([cells, cells, cells, opaque]))
        else:
            assert cv2.imwrite(str(path), cells)
        content = {
            "image": path.name,
            "resolution": 0.1,
            "origin": [-1.0, -2.0, 0.0],
            "negate": 0,
            "occupied_thresh": 0.65,
            "free_thresh": 0.196,
            **keys,
        }
        lines = [f"{key}: {value}" for key, value in content.items()]
        (folder / "map.yaml").write_text("\n".join(lines) + "\n", encoding="utf-8")

    return make


def _house(folder: Path) -> None:
    verts = [[0, 0], [8, 0], [8, 3.5], [6, 3.5], [6, 7], [0, 7]]
    rooms = {"Kitchen": [[0, 0, 4, 3.5]], "Bedroom": [0, 3.5, 6, 7], "Hall": [[4, 0, 8, 3.5]]}
    content = {"id": "a1", "room_num": 3, "verts": verts, "room_category": rooms}
    (folder / "house.json").write_text(json.dumps(content), encoding="utf-8")


def _plan(folder: Path) -> None:
    save_plan(make_box(4.0, 3.0, pillars=[(2.0, 1.5, 0.3)]), folder / "plan.json")


# Recorded drives, outcomes, logs.


def _drives(folder: Path) -> None:
    lines = [[(0, 0), (1, 0)], [(0, 0), (0, 1), (0.5, 1.0)]]
    save_trajectories(folder / "drives.npz", [make_trajectory(line) for line in lines])


def _outcomes(folder: Path) -> None:
    count, rng = 12, np.random.default_rng(0)
    pairs = ReachabilityPairs(
        rng.normal(size=(count, 3)), np.arange(count), rng.random((count, 2)), rng.random(count)
    )
    driven, reached = np.arange(count) % 3 > 0, np.arange(count) % 3 == 1
    outcomes = RolloutOutcomes(pairs, driven, reached, driven & ~reached, driven * 2.5)
    save_outcomes(folder / "outcomes.npz", outcomes, "recipe 1")


def _log(folder: Path) -> None:
    rng = np.random.default_rng(0)
    whole = rng.integers(0, 5, (3, 6, 2))
    FollowerLog(
        whole[0].astype(np.int8),
        whole[1].astype(np.int32),
        whole[2].astype(np.int32),
        rng.random((6, 2)),
        rng.random((6, 2)),
        rng.random((6, 2, 2)),
    ).save(folder / "log.npz")


# Maps.


class Indifferent:
    """RE of any images, so that what is wrong with a map is for its loader to find."""

    network = LocalNetwork(TINY)

    def prepare(self, contexts: Any) -> Any:
        return np.asarray(contexts)

    def probability(self, observations: Any, prepared: Any) -> Any:
        return np.full(len(prepared), 0.5)


def _topomap() -> TopoMap:
    rng, count = np.random.default_rng(0), 9
    found = TopoMap(Indifferent())
    image = rng.integers(0, 255, (count, 4, 6, 3)).astype(np.uint8)
    laser, nothing = rng.random((count, 5)).astype(np.float32), np.zeros(count)
    seen = Observation(image, None, laser, rng.normal(size=(count, 3)), nothing, nothing + 0.1)
    contexts = rng.integers(0, 255, (count, 3, 4, 6, 3)).astype(np.uint8)
    owner, place = np.repeat([0, 1], [5, 4]), np.array([0, 1, 2, 3, 4, 0, 1, 2, 3])
    found.make_vertices(seen, contexts, np.arange(count) * 1.5, owner, place)
    found.paths = [[0, 1, 2, 3, 4], [5, 6, 7, 8, 0]]
    for source, target in ((0, 1), (1, 2), (2, 3), (3, 4), (5, 6), (6, 7), (7, 8), (8, 0), (2, 6)):
        found.connect(source, target, 0.9 + source / 100, driven=target % 3)
    return found


def _told(topomap: TopoMap | None) -> Any:
    """A map as plain data; it must make sense, however it was altered."""
    if topomap is None:
        return None
    edges = sorted((a, b, *edge.values()) for a, b, edge in topomap.graph.edges(data=True))
    for source, target, probability, _, driven in edges:
        assert source != target
        assert 0 <= probability <= 1
        assert type(driven) is int
        assert driven >= 0
    for vertex in topomap.alive:
        path, place = topomap.path_of(vertex)
        assert path[place] == vertex
    alive = topomap.alive
    assert len(topomap.vertices) == len(alive)
    seen = plain(topomap.vertices.observations[alive]) if len(alive) else None
    contexts = topomap.vertices.contexts[alive] if len(alive) else None
    times = topomap.vertices.timestamps
    return [plain(edges), topomap.paths, plain(topomap.settings), seen, contexts, times]


def _map_1(folder: Path) -> None:
    """As version 1 wrote it, without a checksum."""
    path = folder / "flat.json"
    save_map(path, _topomap())
    content = json.loads(path.read_text(encoding="utf-8"))
    del content["checksum"]
    path.write_text(json.dumps({**content, "version": 1}), encoding="utf-8")


_FRAMES = types.SimpleNamespace(trajectories=[[1, 2, 3]])
_BUILDING = types.SimpleNamespace(name="a building", recorded=_FRAMES)


def _agent() -> Any:
    topomap = _topomap()
    return types.SimpleNamespace(
        reachability=topomap.vertices.reachability,
        topomap=topomap,
        settings=topomap.settings,
        p_sparsify=0.99,
    )


# Networks.


def _network() -> LocalNetwork:
    torch.manual_seed(0)
    return LocalNetwork(TINY)


def _weights(folder: Path) -> None:
    card = Card("some", "train waypoint --k 0", TINY, {"a": [1, 2]}, {"validation": 0.5})
    save_network(_network(), card, folder)


class _Trained:
    """A training that a checkpoint belongs to."""

    def __init__(self) -> None:
        self.state = _State(
            _network(), Settings(max_steps=4), types.SimpleNamespace(recipe={"worlds": 2}), ""
        )
        self.state.progress.step = 3
        self.state.progress.history.append({"step": 2, "training": 0.5, "validation": 0.25})
        self.whole = self._copy()

    def save(self, folder: Path) -> None:
        self.state.save(folder / "tiny.pt")

    def load(self, folder: Path) -> Any:
        state = self.state
        state.network.load_state_dict({k: v * 0 for k, v in state.network.state_dict().items()})
        state.load(folder / "tiny.pt")
        return self._copy()

    def _copy(self) -> Any:
        state = self.state
        weights = {name: value.clone() for name, value in state.network.state_dict().items()}
        optimizer = {k: v for k, v in state.optimizer.state_dict().items() if k != "param_groups"}
        return plain([weights, optimizer, state.best, asdict(state.progress)])


# Results, notebooks, pages, agents.


def _result(folder: Path) -> None:
    rows = [{"method": name, "trials": 40, "success": 0.5, "low": None} for name in ("a", "b")]
    report = Report("table", 0, (1, 2), False, 1.5, rows, ("a note",)).as_dict()
    (folder / "table.json").write_text(json.dumps(report, indent=1), encoding="utf-8")


def _notebook(folder: Path) -> None:
    cells = [{"metadata": {"exercise": name}, "source": [], "outputs": []} for name in ("a", "b")]
    content = {"cells": [*cells, {"metadata": {}, "source": ["x"]}], "nbformat": 4}
    (folder / "01_some.ipynb").write_text(json.dumps(content), encoding="utf-8")


def _glossary(folder: Path) -> None:
    content = {"pose": {"meaning": "where", "symbol": "x"}, "anchor": {"meaning": "a frame"}}
    (folder / "glossary.json").write_text(json.dumps(content), encoding="utf-8")


def _run_agent(folder: Path) -> Any:
    """Import an agent, and do with it what experiments do."""
    where = f"{folder / 'agent.py'}:Agent"
    component = custom(where)

    def use() -> list[Any]:
        return checked_actions(component.learn([]), 3).tolist()

    return guarded(where, use)


def _own_agent(folder: Path) -> None:
    (folder / "agent.py").write_text(agent_sources()[0], encoding="utf-8")


def targets() -> list[Target]:
    """All of them."""
    trained = _Trained()
    ros = {
        "ros_png": (".png", {}),
        "ros_rgba": (".rgba.png", {"mode": "scale"}),
        "ros_pgm": (".pgm", {}),
        "ros_plain": (".txt.pgm", {}),
        "ros_bmp": (".bmp", {}),
    }
    return [
        Target("plan", _plan, lambda folder: plain(import_map(folder / "plan.json"))),
        Target("houseexpo", _house, lambda folder: plain(import_map(folder / "house.json"))),
        *(
            Target(
                name,
                _draw(suffix, **keys),
                lambda folder: plain(import_map(folder / "map.yaml")),
                (".png",),
            )
            for name, (suffix, keys) in ros.items()
        ),
        Target(
            "trajectories",
            _drives,
            lambda folder: plain(load_trajectories(folder / "drives.npz")),
            (".npz",),
        ),
        Target(
            "outcomes",
            _outcomes,
            lambda folder: plain(load_outcomes(folder / "outcomes.npz", "recipe 1")),
            (".npz",),
        ),
        Target("log", _log, lambda folder: plain(FollowerLog.load(folder / "log.npz")), (".npz",)),
        Target(
            "map",
            lambda folder: save_map(folder / "flat.json", _topomap()),
            lambda folder: _told(load_map(folder / "flat.json", Indifferent())),
            (".npz", ".json"),
        ),
        Target(
            "map_version_1",
            _map_1,
            lambda folder: _told(load_map(folder / "flat.json", Indifferent())),
            (".npz",),
        ),
        Target(
            "learned_map",
            lambda folder: keep_learned(_BUILDING, _agent(), folder),
            lambda folder: _told(load_learned(_BUILDING, _agent(), folder)),
            (".npz", ".json"),
        ),
        Target(
            "weights",
            _weights,
            lambda folder: plain(
                [dict(load_network("some", folder).state_dict()), load_card("some", folder)]
            ),
            (".safetensors", ".json"),
        ),
        Target("checkpoint", trained.save, trained.load, (".pt",)),
        Target("results", _result, lambda folder: plain(load_result("table", folder))),
        Target("notebook", _notebook, lambda folder: plain(progress(folder))),
        Target("glossary", _glossary, lambda folder: plain(read_glossary(folder))),
        Target("agent", _own_agent, _run_agent),
    ]
