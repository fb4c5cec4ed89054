"""Doors of topology: maps, planner, follower and filter."""

import os
import tempfile
from pathlib import Path

import numpy as np

from tests.doors.arguments import (
    a,
    choice,
    flag,
    flags,
    floats,
    function,
    images,
    integers,
    number,
    path,
    several,
    text,
    whole,
)
from tests.doors.ground import in_folder
from tests.doors.walk import anything, call
from tests.made_up_maps import anchors, numbered
from tutorial_lib import topology
from tutorial_lib.interfaces import Goals
from tutorial_lib.topology import localization, similarity
from tutorial_lib.topology.following import transitions
from tutorial_lib.topology.mapping import edge_rules, sparsify, turn_edges
from tutorial_lib.topology.motion_model import neighbourhoods

FILE = Path(tempfile.gettempdir()) / f"doors-{os.getpid()}.npz"
SHARE = {"least": 0, "most": 1}


class Everywhere:
    """RE, C_WP and C_RMP in one: all is reachable, straight ahead."""

    def prepare(self, contexts):
        return np.asarray(contexts)[:, 0]

    def probability(self, observations, prepared):
        return np.full(len(observations), 0.999)

    def embed(self, observations):
        return observations.odometry[:, None, :2].astype(np.float32)

    def embed_targets(self, prepared):
        found = np.zeros((len(prepared), 1, 1, 2), dtype=np.float32)
        found[:, 0, 0, 0] = prepared
        return found

    def predict(self, observations, targets):
        return np.full((len(observations), 2), 1.0), np.full((len(observations), 2), 0.5)

    def act(self, observations, waypoints):
        return np.zeros((len(observations), 2))


ROBOT, SEEN = Everywhere(), numbered([0, 1, 2])
CONTEXTS = np.arange(3)[:, None]
PLACES = np.arange(15.0).reshape(5, 3)
MODEL = topology.MotionModel(np.array([1.0, 1.0, 1.0]), np.eye(3)[[1, 2, 0]])


def topomap():
    found = topology.TopoMap(ROBOT)
    five = np.arange(5)
    found.make_vertices(numbered(five), five[:, None], five * 1.0, 0 * five, five)
    found.paths = [five.tolist()]
    for v in range(4):
        found.connect(v, v + 1, 0.99, driven=1)
    return found


def paths():
    return topology.AnchorPaths(np.arange(4), np.arange(4), [[0, 1], [2, 3], [1, 2]])


def follower():
    return topology.Follower(paths(), ROBOT, ROBOT, ROBOT)


def filter_of_two():
    return topology.BayesFilter(2, MODEL, lambda seen: np.full((len(seen), 2), 0.5))


def anchor_paths():
    """Arguments that probabilities and waypoints have in common."""
    return {
        "observations": a(SEEN),
        "robots": integers([0, 1, 2], ("M",), least=0, most=2),
        "places": integers([[0, 1], [0, 1], [0, 1]], ("M", "W")),
        "queried": flags(np.ones((3, 2)), ("M", "W")),
    }


def planned():
    return {
        "observation": a(SEEN[0]),
        "goals": a(Goals(SEEN[2], CONTEXTS[2:])),
        "topomap": a(topomap()),
        "excluded": a([(0, 1)]),
    }


def share(value, **more):
    return number(value, **SHARE, **more)


def chances(values, shape=("V",), **more):
    return floats(values, shape, **SHARE, **more)


def weights(values, shape, **more):
    return floats(values, shape, least=0, **more)


def unit(value):
    """A number between 0 and 1, both excluded."""
    return number(value, least=0, most=1)


DOORS = {
    "AnchorPaths": lambda: call(
        topology.AnchorPaths,
        targets=a(np.arange(4)),
        prepared=a(np.arange(4)),
        paths=several([[0, 1], [2, 3]], empty=False, refuses="of numbers, of None"),
    ),
    "AnchorPaths.end_to_end": lambda: call(
        topology.AnchorPaths.end_to_end,
        targets=a(np.arange(4)),
        prepared=a(np.arange(4)),
        lengths=integers([2, 2], ("N",), least=1, refuses="longer N, shorter N", empty=False),
    ),
    "AnchorPaths.exist": lambda: call(
        paths().exist,
        robots=integers([0, 1, 2], ("M",), least=0, most=2),
        places=integers([[0], [1], [2]], ("M", "W")),
    ),
    "AnchorPaths.probabilities": lambda: call(
        paths().probabilities, anything, reachability=a(ROBOT), **anchor_paths()
    ),
    "AnchorPaths.waypoints": lambda: call(
        paths().waypoints, anything, predictor=a(ROBOT), **anchor_paths()
    ),
    "Anchors": lambda: call(
        topology.Anchors,
        anything,
        observations=a(SEEN),
        contexts=a(CONTEXTS),
        timestamps=floats([0.0, 1.0, 2.0], ("A",), refuses="longer A, shorter A, empty"),
        prepared=a(np.arange(3), optional=True),
    ),
    "Anchors.subset": lambda: call(
        anchors([0, 1, 2]).subset, anything, index=integers([0, 2], ("N",), least=0, most=2)
    ),
    "BayesFilter": lambda: call(
        topology.BayesFilter,
        anything,
        robots=whole(2, least=0, most=10**6),
        model=a(MODEL),
        sensor=function(lambda seen: np.ones((len(seen), 2))),
        settings=a(topology.FilterSettings(), optional=True),
    ),
    "BayesFilter.observe": lambda: call(
        filter_of_two().observe,
        observations=a(SEEN[:2]),
        robots=integers([0, 1], ("M",), least=0, most=1, refuses="longer M, shorter M, empty"),
    ),
    "DijkstraPlanner": lambda: call(
        topology.DijkstraPlanner,
        anything,
        least=share(0.2),
        p_query=share(0.5),
        p_goal=share(0.985),
        candidates=whole(64, least=1),
        localizer=a(None, optional=True),
    ),
    "DijkstraPlanner.plan": lambda: call(topology.DijkstraPlanner().plan, anything, **planned()),
    "FilterSettings": lambda: call(
        topology.FilterSettings,
        stride=number(0.3, above=0),
        interval=whole(10, least=1),
        unknown=unit(0.4),
        least=unit(0.02),
        sharpness=number(3.0, above=0),
        hysteresis=unit(0.5),
    ),
    "Follower": lambda: call(
        topology.Follower,
        anything,
        paths=a(paths()),
        predictor=a(ROBOT),
        controller=a(ROBOT),
        reachability=a(ROBOT),
        settings=a(topology.FollowerSettings(), optional=True),
        starts=integers(
            [-1, 0, 1], ("N",), most=1, optional=True, refuses="longer N, shorter N, empty"
        ),
    ),
    "Follower.act": lambda: call(
        follower().act,
        observations=a(SEEN),
        robots=integers([0, 1, 2], ("M",), least=0, most=2, refuses="longer M, shorter M, empty"),
    ),
    "Follower.assign": lambda: call(
        follower().assign,
        robot=whole(0, least=0, most=2),
        path=integers([1, 2], ("L",), least=0, most=3, empty=False),
        turns=a({1: 0.5}, optional=True),
    ),
    "FollowerSettings": lambda: call(
        topology.FollowerSettings,
        **{n: unit(v) for n, v in vars(topology.FollowerSettings()).items() if v < 1 and n != "at"},
        at=number(0.25, least=0),
        effort=number(5.0, least=0),
        timeout=number(4.0, least=0),
        calm=number(1.0, least=0),
        confirm=whole(5, least=1),
        widest=whole(4, least=1),
    ),
    "MapSettings": lambda: call(
        topology.MapSettings,
        p_edge=share(0.99),
        p_reuse=share(0.94),
        sequence=whole(2, least=0),
        candidates=whole(12, least=1),
        p_outdated=share(0.1),
        p_between=share(0.94),
        reuse_sequence=whole(0, least=0),
    ),
    "MotionModel": lambda: call(
        topology.MotionModel,
        lengths=floats([1.0, 1.0], ("V+1",), least=0, empty=False),
        onward=floats(np.eye(2), ("V+1", "V+1"), **SHARE, refuses="longer V+1, shorter V+1"),
    ),
    "TopoMap": lambda: call(
        topology.TopoMap,
        anything,
        reachability=a(ROBOT),
        settings=a(topology.MapSettings(), optional=True),
    ),
    "TopoMap.see": lambda: call(topomap().see, observations=a(SEEN)),
    "TopoMap.show": lambda: call(topomap().show, observations=a(SEEN), prepared=a(np.arange(3))),
    "TopoMap.nearby": lambda: call(topomap().nearby, observations=a(SEEN), count=whole(2, least=0)),
    "TopoMap.around": lambda: call(
        topomap().around, observations=a(SEEN), prepared=a(np.arange(3)), count=whole(2, least=0)
    ),
    "TopoMap.connect": lambda: call(
        topomap().connect,
        source=whole(0, least=0, most=4),
        target=whole(3, least=0, most=4),
        probability=share(0.9),
        driven=whole(1, least=0),
    ),
    "TopoMap.connect_by_turn": lambda: call(
        topomap().connect_by_turn,
        source=whole(0, least=0, most=4),
        target=whole(3, least=0, most=4),
        probability=share(0.9),
        angle=number(1.0),
    ),
    "TopoMap.make_vertices": lambda: call(
        topomap().make_vertices,
        observations=a(SEEN),
        contexts=a(CONTEXTS),
        timestamps=floats([1.0, 2.0, 3.0], ("N",)),
        trajectory=integers([1, 1, 1], ("N",), least=0),
        place=integers([0, 1, 2], ("N",), least=0),
        prepared=a(np.arange(3), optional=True),
    ),
    "TopoMap.remove": lambda: call(
        topomap().remove, vertices=integers([0, 1], ("N",), least=0, most=4)
    ),
    "TopoMap.turns_on": lambda: call(
        topomap().turns_on, vertices=integers([0, 1], ("L",), least=0)
    ),
    "ViewSensor": lambda: call(
        topology.ViewSensor,
        anything,
        topomap=a(topomap()),
        predictor=a(ROBOT),
        targets=a(np.arange(5)),
    ),
    "add_trajectory": lambda: call(
        topology.add_trajectory, topomap=a(topomap()), anchors=a(anchors([5, 6, 7]))
    ),
    "anchors_of": lambda: call(
        topology.anchors_of,
        anything,
        reachability=a(ROBOT),
        observations=a(SEEN),
        images=a(np.arange(3)),
        k=whole(1, least=0),
        threshold=unit(0.9),
        timestamps=floats([0.0, 1.0, 2.0], ("T",), refuses="longer T, shorter T, empty"),
    ),
    "contextified": lambda: call(
        sparsify.contextified, images=a(np.arange(3), either="list"), k=whole(1, least=0)
    ),
    "export_graphml": lambda: in_folder(
        topology.export_graphml, topomap=a(topomap()), poses=floats(PLACES, (5, 3), optional=True)
    ),
    "export_geojson": lambda: in_folder(
        topology.export_geojson,
        topomap=a(topomap()),
        poses=floats(PLACES, (5, 3)),
        frame=text("map"),
    ),
    "likeness": lambda: call(
        topology.likeness,
        seen=floats(np.ones((2, 3, 4)), ("N", "R", "D"), either="bool, huge"),
        shown=floats(
            np.ones((2, 2, 3, 4)), ("M", "P", "S", "D"), either="bool, huge", takes="empty"
        ),
    ),
    "load_map": lambda: call(saved_then_loaded, anything, path=path(FILE), reachability=a(ROBOT)),
    "most_alike": lambda: call(
        topology.most_alike,
        alike=floats([[0.1, 0.5, 0.3]], ("N", "M"), infinite=True),
        count=whole(2, least=0),
    ),
    "motion_model": lambda: call(topology.motion_model, topomap=a(topomap())),
    "moved": lambda: call(topology.moved, motion=floats([[1.0, 0.0, 0.5]], (..., 3))),
    "save_map": lambda: call(topology.save_map, path=path(FILE), topomap=a(topomap())),
    # What is public in its module.
    "normalize": lambda: call(
        localization.normalize,
        weights=floats([[1.0, 0.0], [0.5, 0.5]], ("N", "V+1"), least=0),
    ),
    "predict": lambda: call(
        localization.predict,
        belief=floats(
            [[1.0, 0, 0], [0, 0, 1]], ("N", "V+1"), least=0, refuses="longer V+1, shorter V+1"
        ),
        motion=floats([0.5, 0.1], ("N",), least=0),
        model=a(MODEL),
    ),
    "update": lambda: call(
        localization.update,
        prior=weights([[0.5, 0.5]], ("N", "V+1")),
        likelihood=weights([[0.5, 0.9]], ("N", "V+1")),
    ),
    "argmax": lambda: call(localization.argmax, likelihood=weights([[0.5, 0.9]], ("N", "V"))),
    "match_sequence": lambda: call(
        localization.match_sequence,
        likelihoods=weights([[0.5, 0.9], [0.2, 0.1]], ("T", "V"), empty=False),
        before=integers([-1, 0], ("V",), most=1),
    ),
    "localized": lambda: call(
        localization.localized,
        belief=weights([[0.5, 0.4, 0.1]], ("N", "V+1"), takes="longer V+1"),
        before=integers([0], ("N",), most=2),
        hysteresis=share(0.5),
    ),
    "neighbourhoods": lambda: call(neighbourhoods, topomap=a(topomap()), steps=whole(2, least=0)),
    "reusable": lambda: call(
        edge_rules.reusable,
        into=chances([0.9, 0.8]),
        onward=chances([0.9, 0.8]),
        allowed=flags([True, True], ("V",)),
        p_reuse=share(0.5),
    ),
    "reusable_edge": lambda: call(
        edge_rules.reusable_edge,
        into=chances([0.9, 0.8]),
        onward=chances([0.9, 0.8]),
        edges=integers([[0, 1]], ("E", 2), least=0, most=1),
        probabilities=chances([0.9], ("E",)),
        p_reuse=share(0.5),
    ),
    "ahead_of": lambda: call(
        edge_rules.ahead_of,
        trajectory=integers([0, 0, 1], ("V",), least=-1),
        place=integers([0, 1, 0], ("V",), least=-1),
        reused=integers([0], ("R",), least=0, most=2),
    ),
    "outdated": lambda: call(
        edge_rules.outdated,
        seen=flags([[True, False], [False, True]], ("A", "V")),
        unseen=flags([[False, True], [True, False]], ("A", "V")),
        before=integers([-1, 0], ("V",), most=1),
        after=integers([1, -1], ("V",), most=1),
        reach=whole(2, least=0),
    ),
    "bayes": lambda: call(
        topology.bayes,
        prior=share(0.5),
        succeeds=unit(0.9),
        deceives=unit(0.1),
        success=flag(True),
    ),
    "shared_bayes": lambda: call(
        topology.shared_bayes,
        at=share(0.5),
        prior=share(0.5),
        succeeds=unit(0.9),
        deceives=unit(0.1),
        success=flag(True),
    ),
    "gaussian": lambda: call(
        topology.gaussian,
        mean=number(1.0),
        variance=number(0.1, least=0),
        measured=number(1.2),
        noise=number(0.1, least=0),
    ),
    "length": lambda: call(topology.length, waypoints=floats(np.ones((4, 3)), (..., 3))),
    "SamplingRules": lambda: call(
        topology.SamplingRules,
        reachable=share(0.9),
        own_reachable=share(0.5),
        own=whole(4, least=0),
        merge=number(0.7, least=0, refuses="huge"),
        connect=number(2.5, least=0),
        most_turn=number(1.0, least=0),
        support=share(0.5),
        order=choice("uniform"),
        reverse=number(4.0, least=1, optional=True),
        spread=number(0.2, least=0),
    ),
    "MaintenanceRules": lambda: call(
        topology.MaintenanceRules,
        deceives=unit(0.05),
        prune=share(0.2),
        share_blame=flag(True),
        returns=whole(60, least=0),
        returns_blocked=whole(10, least=0),
        expand=flag(True),
        loosened=number(1.6, least=1),
    ),
    "weight": lambda: call(edge_rules.weight, probability=chances([0.5, 1.0], (...,))),
    "last_visited": lambda: call(
        transitions.last_visited,
        visited=integers([0, 1], ("M",)),
        active=integers([1, 2], ("M",)),
        overlaps=floats(np.full((2, 3), 0.5), ("M", 3), nan=True),
        at=flags([True, False], ("M",)),
        least=number(0.5),
    ),
    "next_active": lambda: call(
        transitions.next_active,
        active=integers([1, 2], ("M",)),
        visited=integers([0, 1], ("M",)),
        probability=floats([0.5, 0.9], ("M",), nan=True),
        overlap=floats([0.5, 0.9], ("M",), nan=True),
        settings=a(topology.FollowerSettings()),
    ),
    "found_again": lambda: call(
        transitions.found_again,
        active=integers([1, 2], ("M",)),
        probabilities=floats(
            np.full((2, 3), 0.5), ("M", "2W+1"), nan=True, refuses="longer 2W+1, shorter 2W+1"
        ),
        least=number(0.5),
    ),
    "sparsify": lambda: call(
        sparsify.sparsify,
        reachability=a(ROBOT),
        observations=a(SEEN),
        prepared=a(np.arange(3)),
        threshold=unit(0.9),
        window=whole(4, least=1),
    ),
    "every_nth": lambda: call(
        sparsify.every_nth, frames=whole(8, least=2, most=10**9), n=whole(3, least=1)
    ),
    "stored_frames": lambda: call(
        sparsify.stored_frames,
        anchors=integers([0, 3], ("A",), least=0, most=7),
        frames=whole(8, least=1, most=10**9),
        k=whole(1, least=0),
    ),
    "TurnSettings": lambda: call(
        turn_edges.TurnSettings,
        p_turn=unit(0.95),
        least=number(1.0, least=0),
        reach=number(1.0, least=0),
        candidates=whole(24, least=1),
        agreement=unit(0.95),
        colours=unit(0.35),
        most=whole(3, least=1),
    ),
    "ImageSimilarity.prepare": lambda: call(
        similarity.ImageSimilarity().prepare,
        images=images(np.ones((2, 3, 4, 6, 3)), ("M", "P", "H", "W", 3)),
    ),
}
LEARNED = "a part of LTVN's agent, which makes it of what its model predicts"
WITHOUT = dict.fromkeys(
    ("ImagePool", "Maintenance", "SampledMap", "Traversal", "build", "joined_map", "undone"),
    LEARNED,
)


def saved_then_loaded(path, reachability):
    topology.save_map(FILE, topomap())
    return topology.load_map(path, reachability)
