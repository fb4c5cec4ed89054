"""What the course has and Lifelong Topological Visual Navigation has not, or has otherwise."""

from __future__ import annotations

from tutorial_lib.experiments.results_page.departures import Departure
from tutorial_lib.topology.maintenance import CERTAIN, MaintenanceRules
from tutorial_lib.topology.mapping.image_pool import CANDIDATES
from tutorial_lib.topology.mapping.sampling_map import SamplingRules

_RULES, _MENDING = SamplingRules(), MaintenanceRules()
LTVN = (
    Departure(
        "Reachability",
        "all thresholds: the paper publishes none; those of the label, D_m, D_c, R_p and the "
        "likelihoods are chosen on validation worlds",
        ("learning/analytic_label.py", "topology/mapping/sampling_map.py"),
        "LTVN's label",
    ),
    Departure(
        "Reachability",
        "a target must be ahead of the car, within 60 degrees, and closer than 0.3 m any is; the "
        "paper asks that it is visible and in front",
        ("learning/analytic_label.py",),
        "LTVN's label",
    ),
    Departure(
        "Model",
        "the target is seen in its context, k = 5, and false pairs are mined in the same "
        "buildings; the paper compares two images",
        ("learning/relative_recipes.py",),
        "LTVN's model",
    ),
    Departure(
        "Graph Building",
        f"each image is compared with the {CANDIDATES} most like it, not with all; an edge needs "
        f"the support of the images between its ends; less is asked of images close together on "
        f"one drive",
        ("topology/mapping/image_pool.py", "topology/mapping/sampling_map.py"),
        "LTVN's model",
    ),
    Departure(
        "Graph Building",
        "the first image is drawn from the largest group of images that are joined",
        ("topology/mapping/sampling_map.py",),
    ),
    Departure(
        "Graph Building",
        f"an edge in reverse is an edge of its own and counts {_RULES.reverse:g} times as long",
        ("topology/mapping/sampling_map.py", "08"),
    ),
    Departure(
        "Graph Building",
        "vertices at one place that look different ways are joined by an edge along which the "
        "robot turns where it stands: their scans match, and the walls have the same colours",
        ("topology/mapping/turn_edges.py", "topology/mapping/sampling_map.py"),
    ),
    Departure(
        "Navigation",
        "a robot looks before it drives: an edge whose target is surely not to be seen from its "
        "source is avoided, and believed less",
        ("agents/ltvn_navigation.py", "topology/maintenance.py"),
        "Spurious and missing edges",
    ),
    Departure(
        "Navigation",
        "a robot that drove to a waypoint and sees the target trusts its arrival; one that drove "
        "there and does not see it presumes for one edge to be there; it is also where a vertex "
        "sees it",
        ("agents/ltvn_navigation.py", "08"),
    ),
    Departure(
        "Navigation",
        "a goal is no vertex: edges lead to it from where it is seen, and a robot that sees it "
        "drives there",
        ("agents/ltvn_navigation.py",),
    ),
    Departure(
        "Navigation",
        "an edge that failed is avoided for a minute; robots turn in place to find out where they "
        "are; a fleet shares one map",
        ("agents/ltvn_navigation.py", "experiments/protocols/lifelong.py"),
    ),
    Departure(
        "Graph Maintenance",
        "success is strict: the robot has driven to the waypoint and sees the target within 0.8 m; "
        "the paper asks whether the target is connectable from where the robot is",
        ("agents/ltvn_navigation.py", "08"),
    ),
    Departure(
        "Graph Maintenance",
        f"p(s | r) depends on how the robot was localized, blame is shared with the edge before, "
        f"and no belief is above {CERTAIN:g} or below {1 - CERTAIN:.2f}",
        ("topology/maintenance.py", "08"),
    ),
    Departure(
        "Graph Maintenance",
        f"pruned edges that had worked before return after {_MENDING.returns} queries, twice as "
        f"many each time; what the laser shows to be blocked is left out at once and returns after "
        f"{_MENDING.returns_blocked}; any returns where no path is left",
        ("topology/maintenance.py", "08"),
    ),
    Departure(
        "Graph Maintenance",
        "where no path is left all unused images are tried at once, those that were redundant, "
        "too; the paper samples them until there is a path",
        ("topology/mapping/expansion.py", "08"),
    ),
    Departure(
        "Graph Maintenance",
        "an observation that cannot be localized does not become a vertex; novel places come from "
        "the unused images only",
        ("topology/mapping/expansion.py",),
    ),
)
