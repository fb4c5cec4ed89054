"""Drawing: plans, maps, panels, what stands in notebooks."""

from tests.mutations import changes

MUTATIONS = changes("""
viz/figures/film.py | viz/figures/test_film.py
a film may lack frames
    != encoder.count -> > encoder.count

viz/figures/dashboard.py | viz/figures/test_dashboard.py
the laser's picture is mirrored
    middle - points[:, 1] * scale -> middle + points[:, 1] * scale

viz/canvas/plan_view.py | viz/canvas/test_plan_view.py
the floor ends a cell too late
    depth > grid.resolution / 2 -> depth > -grid.resolution
strokes have the colour of the strip's beginning
    (offset + (np.arange(count) + 0.5) * length / count) % PERIOD
        -> ((np.arange(count) + 0.5) * length / count) % PERIOD

viz/canvas/topomaps.py | viz/canvas/test_topomaps.py
edges are drawn to the left of their line
    np.array([along[1], -along[0]]) -> np.array([-along[1], along[0]])

viz/canvas/motion_policies.py | viz/canvas/test_motion_policies.py
an axis of an ellipse is as long as its weight, not its root
    np.sqrt(np.maximum(weights, 0.0)) -> np.maximum(weights, 0.0)

viz/canvas/probabilities.py | viz/canvas/test_probabilities.py
a certain target is as pale as a doubtful one
    [0.0, 0.5, 1.0], channel -> [0.0, 1.0, 2.0], channel

viz/canvas/field_of_view.py | viz/canvas/test_field_of_view.py
rays are drawn in the robot's frame
    turned = pose[2] + angles -> turned = angles

viz/figures/panels.py | viz/figures/test_panels.py
small frames of a film are blown up
    scale = min(1.0, (STRIP - _GAP * (len(chosen) - 1)) / (len(chosen) * wide))
        -> scale = (STRIP - _GAP * (len(chosen) - 1)) / (len(chosen) * wide)

viz/figures/closeups.py | viz/figures/test_closeups.py
where a column is seen again is drawn transposed
    round(16 * side * along), round(16 * side * across)
        -> round(16 * side * across), round(16 * side * along)

viz/figures/reachability.py | viz/figures/test_reachability.py
Wilson's interval is not as wide as it should be
    _Z**2 / (4 * count**2) -> _Z**2 / (4 * count**3)

viz/figures/planning_graphs.py | viz/figures/test_planning_graphs.py
the numbers of two edges between two vertices lie on each other
    0.11 if both else 0.0 -> 0.0

viz/notebook/widgets.py | viz/notebook/test_widgets.py
a static strip leaves out the present value
    sorted({control.min, control.value, control.max}) -> sorted({control.min, control.max})

viz/figures/directions.py | viz/figures/test_directions.py -k middle_of_its_patch
directions under a panorama go the other way round
    round(width * (0.5 - direction / count)) -> round(width * (0.5 + direction / count))

viz/figures/directions.py | viz/figures/test_directions.py -k y_up
a local map is drawn upside down
    free[::-1, :, None] -> free[:, :, None]

viz/canvas/ghost_graphs.py | viz/canvas/test_ghost_graphs.py
the ghost with the lowest score is the darkest
    share = (values - low) / span -> share = 1 - (values - low) / span
""")
