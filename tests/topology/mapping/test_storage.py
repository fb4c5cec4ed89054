"""Maps on disk: what was saved is read again, whatever happens while it is written."""

import json
import multiprocessing
import os
import pathlib
import signal
import sys
import time

import numpy as np
import pytest

from tests.made_up_maps import (
    Streets,
    StreetsAlike,
    anchors_at,
    edges_of,
    sensed,
    street,
)
from tutorial_lib.errors import InputError
from tutorial_lib.interfaces import Goals
from tutorial_lib.topology.mapping import storage
from tutorial_lib.topology.mapping.edge_rules import MapSettings
from tutorial_lib.topology.mapping.export import export_graphml
from tutorial_lib.topology.mapping.insertion import add_trajectory
from tutorial_lib.topology.mapping.storage import load_map, save_map
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
    assert (one.alive == other.alive).all()
    assert (one.place[one.alive] == other.place[one.alive]).all()
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
    return tmp_path / "flat.npz"


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
        assert again.paths[again.trajectory[new]][again.place[new]] == new
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


def test_saving_again_leaves_one_file(path, tmp_path):
    for trajectories in (1, 2, 2, 3):
        topomap = grown(trajectories)
        save_map(path, topomap)
        assert same(load_map(path, Streets()), topomap)
    assert list(tmp_path.iterdir()) == [path]


def test_saving_twice_gives_the_same_bytes(path):
    save_map(path, grown(2))
    first = path.read_bytes()
    save_map(path, grown(2))
    assert path.read_bytes() == first


def test_saving_leaves_the_map_as_it_was(path):
    topomap, fresh = grown(3, hidden=[3]), grown(3, hidden=[3])
    save_map(path, topomap)
    export_graphml(path.with_suffix(".graphml"), topomap)
    assert same(topomap, fresh)


@pytest.mark.parametrize("name", ["flat.JSON", "flat", "flat.npz.bak"])
def test_a_map_s_name_ends_in_npz(tmp_path, name):
    for act in (lambda p: save_map(p, grown(1)), lambda p: load_map(p, Streets())):
        with pytest.raises(InputError, match=f"{name}: the name of a map ends in .npz"):
            act(tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_a_map_of_the_first_version_is_named(tmp_path):
    (tmp_path / "flat.json").write_text('{"version": 1, "arrays": "flat-0123456789ab.npz"}')
    with pytest.raises(InputError, match=r"flat\.json: maps of the first version .* build the map"):
        load_map(tmp_path / "flat.json", Streets())


def test_an_empty_map_is_not_saved(path):
    with pytest.raises(InputError, match=r"flat\.npz: an empty map; add a trajectory"):
        save_map(path, TopoMap(Streets()))
    assert not path.exists()


# Damage.


def saved(path):
    """The arrays of a saved map; its graph is among them."""
    save_map(path, grown(2))
    with np.load(path) as file:
        return dict(file)


def resave(path, said=None, /, **changed):
    """Save a map whose graph says something else, or with other arrays; those of None are left out.

    Its digest is right, as if it had been made so.
    """
    arrays = {**saved(path), **changed}
    if said is not None:
        text = json.dumps({**json.loads(arrays["graph"].tobytes()), **said})
        arrays["graph"] = np.frombuffer(text.encode(), np.uint8)
    arrays = {name: array for name, array in arrays.items() if array is not None}
    kept = {name: array for name, array in arrays.items() if name not in ("version", "digest")}
    if "digest" in arrays and "digest" not in changed:
        arrays["digest"] = storage._digest(kept)
    np.savez_compressed(path, **arrays)


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
def test_a_map_that_was_cut_short_is_named(path, share):
    saved(path)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    assert refused(path, "damaged, or not an .npz file")


def test_garbage_is_named(path):
    path.write_bytes(bytes(range(256)))
    assert refused(path, "damaged, or not an .npz file")
    for text in (b"[1, 2]", b"7", b'"map"', b"null", b"{}", b"\xff", b"[" * 100_000):
        resave(path, graph=np.frombuffer(text, np.uint8))
        with pytest.raises(InputError, match=r"missing|not JSON|no UTF-8|within each other"):
            load_map(path, Streets())


@pytest.mark.parametrize("version", [1, 3, 0])
def test_another_version_is_named(path, version):
    resave(path, version=np.array(version))
    assert refused(path, f"of version {version}; this program reads version 2")


@pytest.mark.parametrize("name", [*SEEN, "contexts", "timestamps", "place", "graph", "digest"])
def test_an_array_that_is_missing_is_named(path, name):
    resave(path, **{name: None})
    assert refused(path, f"damaged ({name!r} is missing)")


@pytest.mark.parametrize("name", ["settings", "edges", "trails"])
def test_what_the_graph_lacks_is_named(path, name):
    graph = json.loads(saved(path)["graph"].tobytes())
    del graph[name]
    resave(path, graph=np.frombuffer(json.dumps(graph).encode(), np.uint8))
    assert refused(path, f"{name}: missing")


def test_a_map_in_which_a_bit_fell_over_is_named(path):
    saved(path)
    whole = bytearray(path.read_bytes())
    for place in range(0, len(whole), len(whole) // 97):
        whole[place] ^= 16
        path.write_bytes(whole)
        found = outcome(path)
        # Or it was in a part of the archive that is not read.
        assert same(found, grown(2)) if isinstance(found, TopoMap) else str(path) in found
        whole[place] ^= 16


@pytest.mark.parametrize("name", ["timestamps", "graph", "digest"])
def test_one_other_value_is_named(path, name):
    arrays = saved(path)
    arrays[name] = arrays[name].copy()
    arrays[name][1] += 1
    np.savez_compressed(path, **arrays)
    assert refused(path, "damaged (its digest is that of another map)")


@pytest.mark.parametrize("name", ["image", "contexts", "laser", "timestamps", "place", "speed"])
@pytest.mark.parametrize("change", ["short", "axis", "text", "number"])
def test_arrays_that_are_not_a_map_s_are_named(path, name, change):
    found = saved(path)[name]
    other = {
        "short": found[:-1],
        "axis": found[None],
        "text": found.astype(str),
        "number": np.array(1.0),
    }[change]
    resave(path, **{name: other})
    # All others have another length than the times.
    assert refused(path, name if name != "timestamps" or change == "text" else "image")


@pytest.mark.parametrize("name", ["timestamps", "odometry", "contexts"])
def test_numbers_of_a_map_are_finite(path, name):
    values = saved(path)[name]
    values.reshape(-1)[2] = np.nan
    resave(path, **{name: values})
    assert refused(path, f"{name}: holds numbers that are not finite")


def test_the_graph_of_another_map_is_named(path, tmp_path):
    arrays = saved(path)
    save_map(tmp_path / "other.npz", grown(3))
    with np.load(tmp_path / "other.npz") as file:
        np.savez_compressed(path, **{**arrays, "graph": file["graph"]})
    assert refused(path, "damaged (its digest is that of another map)")


def test_arrays_that_would_run_something_are_not_read(path):
    saved(path)
    np.savez(path, image=np.array([{"a": 1}], dtype=object))
    assert refused(path, "damaged, or not an .npz file")


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
        ("settings", {"p_edge": 7}, "p_edge: 7"),
        ("settings", {"p_edge": "0.9"}, "p_edge: '0.9'"),
    ],
)
def test_a_graph_that_makes_no_sense_is_named(path, name, value, words):
    resave(path, {name: value})
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
    resave(path, {name: value})
    assert refused(path, words)


@pytest.mark.parametrize("turned", [0, 1])
def test_a_path_in_another_order_is_named(path, turned):
    paths = json.loads(saved(path)["graph"].tobytes())["trails"]
    paths[turned].reverse()
    resave(path, {"trails": paths})
    assert refused(path, "is not where its trajectory has it")


def test_a_path_of_reused_vertices_only_is_checked_too(path):
    paths = json.loads(saved(path)["graph"].tobytes())["trails"]
    resave(path, {"trails": [*paths, [99]]})
    assert refused(path, "99")


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


@pytest.mark.parametrize(
    ("owner", "name"),
    [
        (np, "savez_compressed"),
        (json, "dumps"),
        (pathlib.Path, "write_bytes"),
        (os, "fsync"),
        (os, "replace"),
    ],
)
def test_an_interrupted_save_keeps_the_old_map(path, monkeypatch, owner, name):
    old = grown(1)
    save_map(path, old)
    calls = []

    def part(*arguments, **_):
        calls.append(name)
        if name == "write_bytes":
            with open(arguments[0], "wb") as file:
                file.write(arguments[1][: len(arguments[1]) // 2])
        raise Interrupted

    with monkeypatch.context() as patch:
        patch.setattr(owner, name, part)
        with pytest.raises(Interrupted):
            save_map(path, grown(2))
    assert len(calls) == 1
    assert same(load_map(path, Streets()), old)
    assert list(path.parent.iterdir()) == [path]  # nothing half written is left
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
    left = [file for file in path.parent.iterdir() if file != path]
    assert all(file.name.startswith(".flat-") for file in left)
    for file in left:
        os.utime(file, (0, 0))
    save_map(path, maps[1])
    assert list(path.parent.iterdir()) == [path]
