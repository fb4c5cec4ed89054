"""Exploring a place never seen, for a goal that is known by its picture (Chaplot et al. 2020)."""

from tutorial_lib.exploration.episodes import Episodes, draw_episodes, exploration_world
from tutorial_lib.exploration.ghost_graph import Ghost, GhostGraph
from tutorial_lib.exploration.labels import PanoramaLabels
from tutorial_lib.exploration.local_map import LocalMaps
from tutorial_lib.exploration.task import ExplorationTask, explore, explore_on
from tutorial_lib.exploration.true_geometry import TrueGeometry

__all__ = [
    "Episodes",
    "ExplorationTask",
    "Ghost",
    "GhostGraph",
    "LocalMaps",
    "PanoramaLabels",
    "TrueGeometry",
    "draw_episodes",
    "exploration_world",
    "explore",
    "explore_on",
]
