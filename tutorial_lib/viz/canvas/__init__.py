"""Drawing on the floor plan."""

from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.anchors import draw_anchors, draw_frames, draw_states
from tutorial_lib.viz.canvas.field_of_view import draw_field_of_view
from tutorial_lib.viz.canvas.labels import label, write_beside
from tutorial_lib.viz.canvas.living_maps import draw_living_map
from tutorial_lib.viz.canvas.motion_policies import draw_arrows, draw_metrics
from tutorial_lib.viz.canvas.outcomes import draw_outcome, outcome_legend
from tutorial_lib.viz.canvas.plan_view import Picture, PlanView
from tutorial_lib.viz.canvas.probabilities import draw_cells
from tutorial_lib.viz.canvas.topomaps import draw_edges, draw_plan, draw_topomap, hue

__all__ = [
    "Picture",
    "PlanView",
    "colours",
    "draw_anchors",
    "draw_arrows",
    "draw_cells",
    "draw_edges",
    "draw_field_of_view",
    "draw_frames",
    "draw_living_map",
    "draw_metrics",
    "draw_outcome",
    "draw_plan",
    "draw_states",
    "draw_topomap",
    "hue",
    "label",
    "outcome_legend",
    "write_beside",
]
