"""Drawing: on the floor plan, as figures and films, and in notebooks."""

from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.anchors import draw_anchors, draw_states
from tutorial_lib.viz.canvas.field_of_view import draw_field_of_view
from tutorial_lib.viz.canvas.labels import label, write_beside
from tutorial_lib.viz.canvas.living_maps import draw_living_map
from tutorial_lib.viz.canvas.motion_policies import draw_arrows, draw_metrics
from tutorial_lib.viz.canvas.outcomes import draw_outcome, outcome_legend
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView
from tutorial_lib.viz.canvas.probabilities import draw_cells
from tutorial_lib.viz.canvas.topomaps import draw_edges, draw_plan, draw_topomap, hue
from tutorial_lib.viz.figures.anchors import (
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
from tutorial_lib.viz.notebook.display import play, show
from tutorial_lib.viz.notebook.tables import table
from tutorial_lib.viz.notebook.teleoperation import TeleopController
from tutorial_lib.viz.notebook.widgets import presses, sliders, teleop

__all__ = [
    "Picture",
    "PlanView",
    "TeleopController",
    "aligned_sequences",
    "along_trajectory",
    "camera_picture",
    "chart",
    "closeup",
    "colours",
    "cover_chart",
    "draw_anchors",
    "draw_arrows",
    "draw_cells",
    "draw_edges",
    "draw_field_of_view",
    "draw_living_map",
    "draw_metrics",
    "draw_outcome",
    "draw_plan",
    "draw_reliability",
    "draw_states",
    "draw_topomap",
    "drive_picture",
    "edge_table",
    "faded",
    "film_strip",
    "follower_machine",
    "follower_strip",
    "frames_kept",
    "from_figure",
    "graph_picture",
    "hue",
    "label",
    "map_view",
    "matches_picture",
    "numbered_views",
    "outcome_legend",
    "pictured_pair",
    "play",
    "presses",
    "probability_bar",
    "reach_table",
    "show",
    "side_by_side",
    "sliders",
    "stacked",
    "state_legend",
    "state_ribbon",
    "table",
    "teleop",
    "write_beside",
]
