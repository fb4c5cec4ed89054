"""Maps on disk: what was saved is read again, whatever happens while it is written."""

import json
import multiprocessing
import os
import pathlib
import signal
import sys
import time

import networkx as nx
import numpy as np
import pytest

from tests.made_up_maps import (
    Streets,
    StreetsAlike,
    anchors_at,
    edges_of,
    sensed,
    street,
    table_map,
)
from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import Goals
from tutorial_lib.reading.checksums import with_checksum
from tutorial_lib.topology.mapping import storage
from tutorial_lib.topology.mapping.edge_rules import MapSettings
from tutorial_lib.topology.mapping.insertion import add_trajectory
from tutorial_lib.topology.mapping.storage import export_graphml, load_map, save_map
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.topology.planner import DijkstraPlanner

SEEN = ("image", "laser", "odometry", "speed", "steering")
PATHS = [
    street((0, 0), (6, 0), (6, 4)),
    street((6, 4), (6, 0), (0, 0)),
    street((0, 0), (6, 0), (6, 4), aside=0.1),
    street((3, -3), (3, 3)),
]


def grown(trajectories=2, reachability=None, hidden=(), settings=None):
    """A map of some trajectories; `hidden` poses look different from the third on."""
    reachability = Streets() if reachability is None else reachability
    topomap = TopoMap(reachability, settings)
    for number, poses in enumerate(PATHS[:trajectories]):
        reachability.hidden = [PATHS[0][place] for place in hidden] if number >= 2 else []
        add_trajectory(topomap, anchors_at(poses, 100.0 * number))
    return topomap


def same(one, other):
    """Whether two maps are equal in everything."""
    assert edges_of(one) == edges_of(other)
    assert list(one.graph) == list(other.graph)
    assert one.paths == other.paths
    assert one.settings == other.settings
    for v in one.alive:
        assert one.path_of(v) == other.path_of(v)
    assert (one.vertices.timestamps == other.vertices.timestamps).all()
    assert (one.trajectory == other.trajectory).all()
    seen = one.vertices.observations[one.alive], other.vertices.observations[one.alive]
    for name in SEEN:
        mine, theirs = (getattr(some, name) for some in seen)
        assert mine.dtype == theirs.dtype
        assert (mine == theirs).all()
    mine, theirs = one.vertices.contexts[one.alive], other.vertices.contexts[one.alive]
    assert mine.dtype == theirs.dtype
    assert (mine == theirs).all()
    return True


@pytest.fixture
def path(tmp_path):
    return tmp_path / "flat.json"


@pytest.mark.parametrize("kind", [Streets, StreetsAlike])
def test_a_map_is_read_as_it_was_saved_and_grows_alike(path, kind):
    settings = MapSettings(p_edge=0.99, sequence=1, candidates=7)
    topomap = grown(2, kind(), settings=settings)
    save_map(path, topomap)
    again = load_map(path, kind())
    assert same(topomap, again)
    for poses in PATHS[2:]:
        one, other = (add_trajectory(m, anchors_at(poses, 500.0)) for m in (topomap, again))
        assert one.path.tolist() == other.path.tolist()
        assert one.queries == other.queries
    assert same(topomap, again)
    assert len(again.paths) == 4


def test_a_removed_vertex_leaves_no_gap(path):
    topomap = grown(3, hidden=[3])
    assert 3 not in topomap.graph
    save_map(path, topomap)
    again = load_map(path, Streets())
    assert list(again.graph) == list(range(len(topomap)))
    number = {int(old): new for new, old in enumerate(topomap.alive)}
    wanted = {(number[a], number[b]): p for (a, b), p in edges_of(topomap).items()}
    assert edges_of(again) == wanted
    assert again.paths == [[number[v] for v in vertices] for vertices in topomap.paths]
    for old, new in number.items():
        assert again.vertices.observations[[new]].odometry.tolist() == (
            topomap.vertices.observations[[old]].odometry.tolist()
        )
        vertices, place = again.path_of(new)
        assert vertices[place] == new
    here = sensed(PATHS[0][:1])
    goals = Goals(sensed(PATHS[0][-1:]), PATHS[0][-1:, None])
    plans = [DijkstraPlanner().plan(here, goals, some) for some in (topomap, again)]
    assert tuple(number[v] for v in plans[0].vertices) == plans[1].vertices != ()
    assert plans[0].probability == plans[1].probability
    for some in (topomap, again):
        some.vertices.reachability.hidden = []
        add_trajectory(some, anchors_at(PATHS[3], 500.0))
    number |= {int(old): new for new, old in enumerate(topomap.alive)}
    wanted = {(number[a], number[b]): p for (a, b), p in edges_of(topomap).items()}
    assert edges_of(again) == wanted


def test_saving_again_leaves_two_files(path, tmp_path):
    other = tmp_path / "flat-2.json"
    save_map(other, grown(1))
    for trajectories in (1, 2, 2, 3):
        topomap = grown(trajectories)
        save_map(path, topomap)
        assert same(load_map(path, Streets()), topomap)
    assert same(load_map(other, Streets()), grown(1))
    files = sorted(file.name for file in tmp_path.iterdir())
    assert len(files) == 4
    assert json.loads(path.read_text())["arrays"] in files


def test_saving_leaves_the_map_as_it_was(path):
    topomap, fresh = grown(3, hidden=[3]), grown(3, hidden=[3])
    save_map(path, topomap)
    export_graphml(path.with_suffix(".graphml"), topomap)
    assert same(topomap, fresh)


def test_a_map_that_was_saved_can_be_moved_together_with_its_arrays(path, tmp_path):
    topomap = grown(1)
    save_map(path, topomap)
    there = tmp_path / "there"
    there.mkdir()
    for file in list(tmp_path.glob("flat*")):
        file.rename(there / file.name)
    assert same(load_map(there / "flat.json", Streets()), topomap)


@pytest.mark.parametrize("name", ["flat.npz", "flat", "flat.JSON.bak"])
def test_a_map_s_name_ends_in_json(tmp_path, name):
    for act in (lambda p: save_map(p, grown(1)), lambda p: load_map(p, Streets())):
        with pytest.raises(InputError, match=f"{name}: the name of a map ends in .json"):
            act(tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_an_empty_map_is_not_saved(path):
    with pytest.raises(InputError, match=r"flat\.json: an empty map; add a trajectory"):
        save_map(path, TopoMap(Streets()))
    assert not path.exists()


# Damage.


def saved(path):
    """A saved map, and its two files."""
    save_map(path, grown(2))
    (arrays,) = path.parent.glob("flat-*.npz")
    return json.loads(path.read_text()), arrays


def rewrite(path, graph, **changes):
    """Write a graph's file with changes, as somebody who means them: its checksum is right."""
    content = {key: value for key, value in {**graph, **changes}.items() if key != "checksum"}
    path.write_text(json.dumps(with_checksum(content)))


def outcome(path):
    """The map that is read, or why none is."""
    try:
        return load_map(path, Streets())
    except InputError as error:
        return str(error)


def refused(path, words):
    with pytest.raises(InputError) as error:
        load_map(path, Streets())
    message = str(error.value)
    assert message.startswith(f"{path}: ")
    assert message.endswith("; build the map again and save it")
    assert words in message
    return True


def test_a_map_that_is_not_there_is_named(path):
    assert refused(path, "there is no such file")


@pytest.mark.parametrize("share", [0.0, 0.3, 0.999])
def test_a_graph_that_was_cut_short_is_named(path, share):
    saved(path)
    text = path.read_text()
    path.write_text(text[: int(share * len(text))])
    assert refused(path, "damaged, or not JSON")


def test_garbage_is_named(path):
    saved(path)
    path.write_bytes(bytes(range(256)))
    assert refused(path, "no UTF-8 text")
    for text in ("[1, 2]", "7", "{}", '"map"', "null"):
        path.write_text(text)
        assert refused(path, "not a map of version 2")


@pytest.mark.parametrize("version", [0, 3, "1", None, True, 1.5])
def test_another_version_is_named(path, version):
    graph, _ = saved(path)
    path.write_text(json.dumps({**graph, "version": version}))
    assert refused(path, "not a map of version 2")


@pytest.mark.parametrize("name", ["arrays", "digest", "settings", "edges", "trails"])
def test_what_is_missing_is_named(path, name):
    graph, _ = saved(path)
    del graph[name]
    path.write_text(json.dumps(graph))
    assert refused(path, f"{name}: missing")


def test_a_graph_in_which_anything_was_altered_is_named(path):
    graph, _ = saved(path)
    whole = path.read_bytes()
    for place in range(0, len(whole), 7):
        for bit in (1, 2, 16):
            changed = bytearray(whole)
            changed[place] ^= bit
            path.write_bytes(changed)
            found = outcome(path)
            # Or it was a space that became another.
            assert same(found, grown(2)) if isinstance(found, TopoMap) else "flat.json" in found
    path.write_text(json.dumps({**graph, "edges": graph["edges"][1:]}))
    assert refused(path, "its checksum differs")


def test_a_map_of_version_1_is_read_if_it_makes_sense(path):
    graph, _ = saved(path)
    del graph["checksum"]
    path.write_text(json.dumps({**graph, "version": 1}))
    assert same(load_map(path, Streets()), grown(2))
    edges = [[*graph["edges"][0][:3], -5], *graph["edges"][1:]]
    path.write_text(json.dumps({**graph, "version": 1, "edges": edges}))
    assert refused(path, "driven -5 times")
    path.write_text(json.dumps({**graph, "version": 1, "checksum": "0"}))
    assert refused(path, "its checksum differs")
    path.write_text(json.dumps(graph))
    assert refused(path, "its checksum differs")


@pytest.mark.parametrize("name", ["image", "contexts", "laser", "timestamps", "place", "speed"])
@pytest.mark.parametrize("change", ["short", "none", "axis", "text", "number"])
def test_arrays_that_are_not_a_map_s_are_named(path, name, change):
    graph, arrays = saved(path)
    values = dict(np.load(arrays))
    found = values.pop(name)
    if change != "none":
        values[name] = {
            "short": found[:-1],
            "axis": found[None],
            "text": found.astype(str),
            "number": np.array(1.0),
        }[change]
    np.savez_compressed(arrays, **values)
    rewrite(path, graph, digest=storage._digest(values))
    # All others have another length than the times.
    assert refused(path, name if name != "timestamps" or change in ("none", "text") else "image")


@pytest.mark.parametrize("name", ["timestamps", "odometry", "contexts"])
def test_numbers_of_a_map_are_finite(path, name):
    graph, arrays = saved(path)
    values = dict(np.load(arrays))
    values[name].reshape(-1)[2] = np.nan
    np.savez_compressed(arrays, **values)
    rewrite(path, graph, digest=storage._digest(values))
    assert refused(path, f"{name}: holds numbers that are not finite")


@pytest.mark.parametrize("share", [0.0, 0.5, 0.99])
def test_arrays_that_were_cut_short_are_named(path, share):
    _, arrays = saved(path)
    whole = arrays.read_bytes()
    arrays.write_bytes(whole[: int(share * len(whole))])
    assert refused(path, f"{arrays.name}: missing or damaged")


def test_arrays_in_which_a_bit_fell_over_are_named(path):
    _, arrays = saved(path)
    whole = bytearray(arrays.read_bytes())
    for place in range(40, len(whole), len(whole) // 23):
        whole[place] ^= 16
        arrays.write_bytes(whole)
        found = outcome(path)
        # Or it was in a part of the archive that is not read.
        assert same(found, grown(2)) if isinstance(found, TopoMap) else arrays.name in found
        whole[place] ^= 16


def test_arrays_that_are_missing_are_named(path):
    _, arrays = saved(path)
    arrays.unlink()
    assert refused(path, f"{arrays.name}: missing or damaged")


def test_arrays_with_one_other_value_are_named(path):
    _, arrays = saved(path)
    values = dict(np.load(arrays))
    values["timestamps"] = values["timestamps"].copy()
    values["timestamps"][1] += 1.0
    np.savez_compressed(arrays, **values)
    assert refused(path, f"{arrays.name}: does not belong to this map")


def test_arrays_of_another_save_are_named(path, tmp_path):
    _, arrays = saved(path)
    save_map(tmp_path / "other.json", grown(3))
    (others,) = tmp_path.glob("other-*.npz")
    os.replace(others, arrays)
    assert refused(path, f"{arrays.name}: does not belong to this map")


def test_arrays_that_would_run_something_are_not_read(path):
    _, arrays = saved(path)
    np.savez(arrays, image=np.array([{"a": 1}], dtype=object))
    assert refused(path, f"{arrays.name}: missing or damaged")


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("edges", [[0, 99, 0.9, 0]], "edge 0 to 99; the map has"),
        ("edges", [[-1, 0, 0.9, 0]], "edge -1 to 0; the map has"),
        ("edges", [[0, 1, 0.9]], "damaged"),
        ("edges", [[0, 1, "likely", 1]], "probability 'likely'"),
        ("edges", [[[0], 1, 0.9, 1]], "damaged"),
        ("edges", [[0, True, 0.9, 1]], "damaged"),
        ("edges", [[0, 1, True, 1]], "probability True"),
        ("edges", [[0, 1, 0.9, -5]], "edge 0 to 1: driven -5 times"),
        ("edges", [[0, 1, 0.9, float("nan")]], "edge 0 to 1: driven nan times"),
        ("edges", [[0, 1, 0.9, 1.5]], "edge 0 to 1: driven 1.5 times"),
        ("edges", [[0, 1, 0.9, "often"]], "edge 0 to 1: driven 'often' times"),
        ("edges", [[0, 1, 0.9, 10**30]], "edge 0 to 1: driven 1"),
        ("edges", [[2, 2, 0.9, 1]], "edge 2 to 2: from a vertex to itself"),
        ("edges", [[0, 1, 0.9, 1], [0, 1, 0.8, 1]], "edge 0 to 1: from a vertex to itself, or tw"),
        ("trails", ["01", "23"], "damaged"),
        ("trails", [[0, 1.0]], "damaged"),
        ("trails", "0123", "damaged"),
        ("edges", 5, "damaged"),
        ("trails", 5, "damaged"),
        ("trails", [["a"]], "damaged"),
        ("settings", [], "damaged"),
        ("settings", {"p_hope": 0.5}, "damaged"),
        ("settings", {"p_edge": 7}, "p_edge = 7"),
        ("settings", {"p_edge": "0.9"}, "damaged"),
        ("digest", None, "does not belong to this map"),
    ],
)
def test_a_graph_that_makes_no_sense_is_named(path, name, value, words):
    graph, _ = saved(path)
    rewrite(path, graph, **{name: value})
    assert refused(path, words)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("trails", [], "damaged"),
        ("trails", [[0, 1, 99]], "[99], which are not there"),
        ("trails", [[0, 1, 2]], "vertex 3 is not where its trajectory has it"),
        ("edges", [[0, 1, 7.5, 1]], "edge 0 to 1: probability 7.5"),
        ("edges", [[0, 1, -0.1, 1]], "edge 0 to 1: probability -0.1"),
        ("edges", [[0, 1, float("nan"), 1]], "edge 0 to 1: probability nan"),
    ],
)
def test_a_graph_that_does_not_fit_its_arrays_is_named(path, name, value, words):
    graph, _ = saved(path)
    rewrite(path, graph, **{name: value})
    assert refused(path, words)


@pytest.mark.parametrize("turned", [0, 1])
def test_a_path_in_another_order_is_named(path, turned):
    graph, _ = saved(path)
    graph["trails"][turned].reverse()
    rewrite(path, graph)
    assert refused(path, "is not where its trajectory has it")


def test_a_path_of_reused_vertices_only_is_checked_too(path):
    graph, _ = saved(path)
    rewrite(path, graph | {"trails": [*graph["trails"], [99]]})
    assert refused(path, "99")


@pytest.mark.parametrize("name", [5, "", None, [], ".", "../flat.npz", "/flat.npz"])
def test_arrays_with_an_impossible_name_are_named(path, name):
    graph, _ = saved(path)
    rewrite(path, graph, arrays=name)
    assert refused(path, f"arrays: {name!r} is not the name of a file beside it")


@pytest.mark.parametrize("name", ["..", "flat.json", "a\0b", "elsewhere.npz"])
def test_a_name_of_no_arrays_is_named(path, name):
    graph, _ = saved(path)
    rewrite(path, graph, arrays=name)
    assert refused(path, "missing or damaged")


def test_a_reachability_that_cannot_prepare_the_images_is_no_damage(path):
    class Broken(Streets):
        def prepare(self, contexts):
            raise RuntimeError("no such network")

    saved(path)
    with pytest.raises(RuntimeError, match="no such network"):
        load_map(path, Broken())


# Interruptions.


class Interrupted(BaseException):
    """As Control-C is."""


def interrupt(monkeypatch, owner, name, call):
    """Let the `call`-th call of a function be interrupted, before or in the middle of it."""
    whole, calls = getattr(owner, name), []

    def part(*arguments, **named):
        calls.append(name)
        if len(calls) == call:
            if name == "write_text":
                whole(arguments[0], arguments[1][: len(arguments[1]) // 2], **named)
            if name == "savez_compressed":
                arguments[0].write(b"PK\x03\x04 half an archive")
            raise Interrupted
        return whole(*arguments, **named)

    monkeypatch.setattr(owner, name, part)
    return calls


@pytest.mark.parametrize(
    ("owner", "name", "call"),
    [
        (np, "savez_compressed", 1),
        (os, "replace", 1),
        (pathlib.Path, "write_text", 1),
        (os, "replace", 2),
        (json, "dumps", 1),
    ],
)
def test_an_interrupted_save_keeps_the_old_map(path, monkeypatch, owner, name, call):
    old = grown(1)
    save_map(path, old)
    with monkeypatch.context() as patch:
        calls = interrupt(patch, owner, name, call)
        with pytest.raises(Interrupted):
            save_map(path, grown(2))
    assert len(calls) == call
    assert same(load_map(path, Streets()), old)
    # Nothing half written is left, and the next save puts everything in order.
    assert not list(path.parent.glob(".*"))
    save_map(path, grown(2))
    assert same(load_map(path, Streets()), grown(2))
    assert len(list(path.parent.iterdir())) == 2


def test_an_interruption_while_tidying_up_leaves_the_new_map(path, monkeypatch):
    save_map(path, grown(1))
    with monkeypatch.context() as patch:
        # Once for each temporary file, and then for what is stale.
        interrupt(patch, pathlib.Path, "unlink", 3)
        with pytest.raises(Interrupted):
            save_map(path, grown(2))
    assert same(load_map(path, Streets()), grown(2))


def save_for_ever(path, maps, saved):
    """Save one map after the other, and send the number of each that is saved."""
    while True:
        for number, topomap in enumerate(maps):
            save_map(path, topomap)
            saved.send(number)


@pytest.mark.skipif(sys.platform == "win32", reason="nothing is forked there")
def test_a_process_killed_while_saving_leaves_a_map_that_can_be_read(path):
    maps, found = [grown(1), grown(2), grown(3)], []
    fork = multiprocessing.get_context("fork")
    for kill in range(15):
        saved, send = fork.Pipe(duplex=False)
        saver = fork.Process(target=save_for_ever, args=(path, maps, send), daemon=True)
        saver.start()
        for _ in range(1 + kill % 3):
            assert saved.poll(60)
            saved.recv()
        time.sleep(0.0004 * kill)  # somewhere in the next save
        saver.kill()
        saver.join()
        assert saver.exitcode == -signal.SIGKILL
        again = load_map(path, Streets())
        (number,) = [n for n, topomap in enumerate(maps) if len(again) == len(topomap)]
        assert same(again, maps[number])
        found.append(number)
    assert len(set(found)) > 1
    save_map(path, maps[0])
    assert same(load_map(path, Streets()), maps[0])
    assert len([file for file in path.parent.iterdir() if file.name[0] != "."]) == 2


# GraphML.


def test_graphml_is_read_by_networkx(tmp_path):
    topomap = grown(3, hidden=[3])
    export_graphml(tmp_path / "flat.graphml", topomap)
    graph = nx.read_graphml(tmp_path / "flat.graphml", node_type=int)
    assert list(graph) == topomap.alive.tolist()
    assert graph.is_directed()
    found = {(a, b): (e["probability"], e["driven"]) for a, b, e in graph.edges(data=True)}
    assert found == edges_of(topomap)
    for a, b, edge in graph.edges(data=True):
        assert edge["weight"] == topomap.graph.edges[a, b]["weight"]
        assert isinstance(edge["driven"], int)
    for vertex, data in graph.nodes(data=True):
        assert data["trajectory"] == topomap.trajectory[vertex]
        assert data["place"] == topomap.place[vertex]
        assert data["timestamp"] == topomap.vertices.timestamps[vertex]


def test_a_map_without_edges_is_graphml_too(tmp_path):
    export_graphml(tmp_path / "flat.graphml", table_map(np.eye(3), 3))
    graph = nx.read_graphml(tmp_path / "flat.graphml", node_type=int)
    assert (list(graph), graph.number_of_edges()) == ([0, 1, 2], 0)
