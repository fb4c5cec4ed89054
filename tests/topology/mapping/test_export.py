"""Maps as other programs read them: GraphML, and GeoJSON as Nav2's route server parses it."""

import json

import networkx as nx
import numpy as np
import pytest

from tests.made_up_maps import Streets, anchors_at, edges_of, places_in, street, table_map
from tutorial_lib.errors import InputError
from tutorial_lib.topology.mapping.export import export_geojson, export_graphml
from tutorial_lib.topology.mapping.insertion import add_trajectory
from tutorial_lib.topology.mapping.topomap import TopoMap

PATHS = [
    street((0, 0), (6, 0), (6, 4)),
    street((6, 4), (6, 0), (0, 0)),
    street((0, 0), (6, 0), (6, 4), aside=0.1),
]


@pytest.fixture
def topomap():
    """A map from which vertices were removed."""
    reachability = Streets()
    found = TopoMap(reachability)
    for number, poses in enumerate(PATHS):
        reachability.hidden = [PATHS[0][3]] if number == 2 else []
        add_trajectory(found, anchors_at(poses, 100.0 * number))
    assert len(found.vertices) > len(found)
    return found


def poses_of(topomap):
    return places_in(topomap.vertices.observations[np.arange(len(topomap.vertices))])


def test_graphml_is_read_by_networkx(topomap, tmp_path):
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


def test_graphml_has_the_poses_of_its_vertices(topomap, tmp_path):
    poses = poses_of(topomap)
    export_graphml(tmp_path / "flat.graphml", topomap, poses)
    graph = nx.read_graphml(tmp_path / "flat.graphml", node_type=int)
    assert list(graph) == topomap.alive.tolist()
    for vertex, data in graph.nodes(data=True):
        assert [data["x"], data["y"], data["heading"]] == poses[vertex].tolist()


# The route server of Nav2.


def route_graph(path):
    """Nodes and edges as `GeoJsonGraphFileLoader` of nav2_route reads them, with its checks."""
    features = json.loads(path.read_text())["features"]
    points = [f for f in features if f["geometry"]["type"] == "Point"]
    lines = [f for f in features if f["geometry"]["type"] in ("MultiLineString", "LineString")]
    assert points
    assert lines
    nodes, edges = {}, {}
    for point in points:
        known = point["properties"]
        assert type(known["id"]) is int
        assert known["id"] >= 0
        assert known["id"] not in nodes
        nodes[known["id"]] = (*point["geometry"]["coordinates"], known["frame"], known["metadata"])
    for line in lines:
        known = line["properties"]
        assert type(known["id"]) is int
        assert known["id"] not in nodes.keys() | edges.keys()
        assert {known["startid"], known["endid"]} <= nodes.keys()
        assert type(known["overridable"]) is bool
        # A cost that is not overridable must be above 0, as the server's numbers have it.
        assert np.float32(known["cost"]) > 0
        for value in known["metadata"].values():
            assert isinstance(value, int | float | str | bool)
        edges[known["id"]] = known | {"line": line["geometry"]["coordinates"]}
    return nodes, edges


def test_geojson_is_what_the_route_server_loads(topomap, tmp_path):
    poses = poses_of(topomap)
    export_geojson(tmp_path / "flat.geojson", topomap, poses)
    nodes, edges = route_graph(tmp_path / "flat.geojson")
    assert list(nodes) == topomap.alive.tolist()
    for vertex, (x, y, frame, metadata) in nodes.items():
        assert [x, y, metadata["heading"]] == poses[vertex].tolist()
        assert frame == "map"
        assert metadata["trajectory"] == topomap.trajectory[vertex]
        assert metadata["place"] == topomap.place[vertex]
        assert metadata["timestamp"] == topomap.vertices.timestamps[vertex]
    assert len(edges) == topomap.graph.number_of_edges()
    for edge in edges.values():
        pair = edge["startid"], edge["endid"]
        known = topomap.graph.edges[pair]
        assert edge["cost"] == pytest.approx(-np.log(known["probability"]))
        assert not edge["overridable"]
        assert edge["metadata"] == {name: known[name] for name in ("probability", "driven")}
        (line,) = edge["line"]
        assert line == poses[list(pair), :2].tolist()
    assert len({(edge["startid"], edge["endid"]) for edge in edges.values()}) == len(edges)


def test_the_cheapest_route_is_the_most_probable_path(topomap, tmp_path):
    export_geojson(tmp_path / "flat.geojson", topomap, poses_of(topomap))
    _, edges = route_graph(tmp_path / "flat.geojson")
    routes = nx.DiGraph()
    routes.add_weighted_edges_from((e["startid"], e["endid"], e["cost"]) for e in edges.values())
    start, end = int(topomap.alive[0]), int(topomap.alive[-1])
    wanted = nx.dijkstra_path(topomap.graph, start, end, weight="weight")
    assert nx.dijkstra_path(routes, start, end) == wanted


def test_a_sure_edge_a_turn_and_another_frame(tmp_path):
    topomap = table_map(np.zeros((3, 3)), 3)
    topomap.connect(0, 1, 1.0, driven=2)
    topomap.connect_by_turn(1, 2, 0.9, 1.5)
    export_geojson(tmp_path / "sure.geojson", topomap, np.zeros((3, 3)), frame="odom")
    nodes, edges = route_graph(tmp_path / "sure.geojson")
    assert {node[2] for node in nodes.values()} == {"odom"}
    sure, turn = edges.values()
    assert sure["metadata"] == {"probability": 1.0, "driven": 2}
    assert turn["metadata"] == {"probability": 0.9, "driven": 0, "turn": 1.5}


def test_what_cannot_be_a_route_graph_is_refused(topomap, tmp_path):
    path = tmp_path / "flat.geojson"
    with pytest.raises(InputError, match="a map without an edge"):
        export_geojson(path, table_map(np.eye(3), 3), np.zeros((3, 3)))
    few = poses_of(topomap)[topomap.alive]
    wrong = poses_of(topomap)
    wrong[0, 0] = np.nan
    for poses in (few, wrong, "here"):
        for export in (export_geojson, export_graphml):
            with pytest.raises(InputError, match="poses: "):
                export(path, topomap, poses)
    with pytest.raises(InputError, match="cannot be written"):
        export_geojson(tmp_path / "none" / "flat.geojson", topomap, poses_of(topomap))
    assert list(tmp_path.iterdir()) == []
