"""Maps, networks and trainings that are saved and loaded again."""

import types
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import torch

from tests.fuzz.plain import plain
from tutorial_lib.interfaces import Observation
from tutorial_lib.learning.networks import Architecture, LocalNetwork
from tutorial_lib.learning.training import Settings, _State
from tutorial_lib.learning.weights import Card, load_card, load_network, save_network
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.world.generators import generate

TINY = Architecture(0, "pair", outputs="action")


class Indifferent:
    """RE of any images, so that what is wrong with a map is for its loader to find."""

    network = LocalNetwork(TINY)

    def prepare(self, contexts: Any) -> Any:
        return np.asarray(contexts)

    def probability(self, observations: Any, prepared: Any) -> Any:
        return np.full(len(prepared), 0.5)


def make_topomap() -> TopoMap:
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


def contents(topomap: TopoMap | None) -> Any:
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
        path = topomap.paths[topomap.trajectory[vertex]]
        assert path[topomap.place[vertex]] == vertex
    alive = topomap.alive
    assert len(topomap.vertices) == len(alive)
    seen = plain(topomap.vertices.observations[alive]) if len(alive) else None
    contexts = topomap.vertices.contexts[alive] if len(alive) else None
    times = topomap.vertices.timestamps
    return [plain(edges), topomap.paths, plain(topomap.settings), seen, contexts, times]


_DRIVE = types.SimpleNamespace(poses=np.zeros((3, 3)), odometry=np.zeros((3, 3)))
_DRIVES = types.SimpleNamespace(trajectories=[_DRIVE])
_SCENE = types.SimpleNamespace(plan=generate("apartment", 3))
BUILDING = types.SimpleNamespace(name="a building", scene=_SCENE, recorded=_DRIVES)


def make_agent() -> Any:
    topomap = make_topomap()
    return types.SimpleNamespace(
        reachability=topomap.vertices.reachability,
        topomap=topomap,
        settings=topomap.settings,
        turns=None,
        p_sparsify=0.99,
        predictor=types.SimpleNamespace(k=5),
    )


def make_network() -> LocalNetwork:
    torch.manual_seed(0)
    return LocalNetwork(TINY)


def write_weights(folder: Path) -> None:
    card = Card("some", "train waypoint --k 0", TINY, {"a": [1, 2]}, {"validation": 0.5})
    save_network(make_network(), card, folder)


def loaded_weights(folder: Path) -> Any:
    """Weights and their card as plain data; they must be numbers, however they were altered."""
    state = dict(load_network("some", folder).state_dict())
    assert all(value.isfinite().all() for value in state.values())
    return plain([state, load_card("some", folder)])


class Trained:
    """A training that a checkpoint belongs to."""

    def __init__(self) -> None:
        self.state = _State(
            make_network(), Settings(max_steps=4), types.SimpleNamespace(recipe={"worlds": 2}), ""
        )
        self.state.progress.step = 3
        for _ in range(3):  # Adam keeps what it saw of each parameter
            sum(value.square().sum() for value in self.state.network.parameters()).backward()
            self.state.optimizer.step()
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
