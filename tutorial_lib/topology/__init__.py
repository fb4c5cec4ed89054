"""From recorded trajectories to a topological map, plans over it, and following them."""

from tutorial_lib.topology.following.anchor_paths import AnchorPaths
from tutorial_lib.topology.following.follower import Follower
from tutorial_lib.topology.following.heading_search import ASIDE
from tutorial_lib.topology.following.transitions import FollowerSettings, State
from tutorial_lib.topology.localization import BayesFilter, FilterSettings
from tutorial_lib.topology.maintenance import (
    Maintenance,
    MaintenanceRules,
    Traversal,
    bayes,
    gaussian,
    shared_bayes,
    undone,
)
from tutorial_lib.topology.mapping.anchors import Anchors, anchors_of
from tutorial_lib.topology.mapping.edge_rules import MapSettings
from tutorial_lib.topology.mapping.export import export_geojson, export_graphml
from tutorial_lib.topology.mapping.image_pool import ImagePool, length
from tutorial_lib.topology.mapping.insertion import add_trajectory
from tutorial_lib.topology.mapping.retrieval import likeness, most_alike
from tutorial_lib.topology.mapping.sampling_map import (
    SampledMap,
    SamplingRules,
    build,
    joined_map,
)
from tutorial_lib.topology.mapping.storage import load_map, save_map
from tutorial_lib.topology.mapping.topomap import TopoMap
from tutorial_lib.topology.motion_model import MotionModel, motion_model, moved
from tutorial_lib.topology.planner import DijkstraPlanner
from tutorial_lib.topology.view_sensor import ViewSensor

__all__ = [
    "ASIDE",
    "AnchorPaths",
    "Anchors",
    "BayesFilter",
    "DijkstraPlanner",
    "FilterSettings",
    "Follower",
    "FollowerSettings",
    "ImagePool",
    "Maintenance",
    "MaintenanceRules",
    "MapSettings",
    "MotionModel",
    "SampledMap",
    "SamplingRules",
    "State",
    "TopoMap",
    "Traversal",
    "ViewSensor",
    "add_trajectory",
    "anchors_of",
    "bayes",
    "build",
    "export_geojson",
    "export_graphml",
    "gaussian",
    "joined_map",
    "length",
    "likeness",
    "load_map",
    "most_alike",
    "motion_model",
    "moved",
    "save_map",
    "shared_bayes",
    "undone",
]
