"""Charts, panels and films."""

from tutorial_lib.viz.figures.anchors import (
    anchors_picture,
    cover_chart,
    follower_strip,
    numbered_views,
    state_legend,
    state_ribbon,
)
from tutorial_lib.viz.figures.charts import chart, from_figure
from tutorial_lib.viz.figures.closeups import closeup, matches_picture
from tutorial_lib.viz.figures.edge_tables import aligned_sequences, edge_table
from tutorial_lib.viz.figures.follower_states import follower_machine, frames_kept, reach_table
from tutorial_lib.viz.figures.maps import drive_picture, map_view
from tutorial_lib.viz.figures.panels import camera_picture, faded, film_strip, side_by_side, stacked
from tutorial_lib.viz.figures.planning_graphs import graph_picture
from tutorial_lib.viz.figures.reachability import (
    along_trajectory,
    draw_reliability,
    pictured_pair,
    probability_bar,
)

__all__ = [
    "aligned_sequences",
    "along_trajectory",
    "anchors_picture",
    "camera_picture",
    "chart",
    "closeup",
    "cover_chart",
    "draw_reliability",
    "drive_picture",
    "edge_table",
    "faded",
    "film_strip",
    "follower_machine",
    "follower_strip",
    "frames_kept",
    "from_figure",
    "graph_picture",
    "map_view",
    "matches_picture",
    "numbered_views",
    "pictured_pair",
    "probability_bar",
    "reach_table",
    "side_by_side",
    "stacked",
    "state_legend",
    "state_ribbon",
]
