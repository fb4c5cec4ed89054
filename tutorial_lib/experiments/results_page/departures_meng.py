"""What the course has and Meng 2020 has not, or has otherwise."""

from __future__ import annotations

import math

from tutorial_lib.agents.blockades import WAIT
from tutorial_lib.driving.metrics import GRACE, REACHED, STRAYED
from tutorial_lib.experiments.protocols.navigation import FACING, NEAR
from tutorial_lib.experiments.results_page import paper
from tutorial_lib.experiments.results_page.departures import Departure
from tutorial_lib.topology.following.transitions import FollowerSettings
from tutorial_lib.topology.mapping.edge_rules import MapSettings
from tutorial_lib.topology.planner import DijkstraPlanner

_MAP, _PLANNER = MapSettings(), DijkstraPlanner()
_FOLLOWING, _MAPPING = "topology/following", "topology/mapping"
MENG = (
    Departure(
        "III-B",
        "the networks match the columns of two images; the paper's pair encoder is there in small",
        ("learning/encoders.py", "02"),
        "Table I: ablations",
    ),
    Departure(
        "III-B",
        "they also learn where each image of the context was taken, and an error of a waypoint "
        "costs less where the target is far (a pseudo-Huber loss)",
        ("learning/losses.py",),
    ),
    Departure(
        "III-B",
        "a waypoint's label is the farthest point of the trajectory in clear sight, as in the "
        "authors' code but on the trajectory that was driven; in the paper it is A*'s",
        ("learning/labels.py", "02"),
    ),
    Departure(
        "III-B",
        "C averages its waypoints, in Table I only",
        ("driving/control/smoothed.py", "02"),
        "Table I: smoothed waypoints",
    ),
    Departure(
        "III-B",
        "direct control predicts speed and steering with k = 2; the paper's predicts acceleration "
        "and steering velocity with k = 0",
        ("learning/losses.py", "02"),
    ),
    Departure(
        "III-B",
        "C_RMP chooses among arcs, in reverse too, and limits its speed by the room ahead",
        ("driving/control/rmp.py", "02"),
    ),
    Departure(
        "III-C",
        "RE also learns the two overlaps, begins with C's encoder, is trained again on pairs about "
        "which it was sure and wrong, and is calibrated on validation worlds",
        ("learning/reach_recipes.py", "learning/losses.py", "03"),
    ),
    Departure(
        "III-C",
        f"a target is reached within {REACHED:g} m, where the paper names no distance; a rollout "
        f"that touches something counts as not reached; pairs far apart without overlap do so "
        f"without a rollout; {GRACE:g} s are added to the time limit, as in the authors' code",
        ("driving/data/rollout_outcomes.py", "03"),
    ),
    Departure(
        "III-C, IV",
        "of the pairs that RE learns from, most of one trajectory lie a few metres apart, and half "
        "of those of two trajectories are near each other",
        ("driving/data/reachability_pairs.py",),
    ),
    Departure(
        "III-D",
        "the first and the last image are always kept, and the next one where not even that is "
        "above p_sparsify",
        (f"{_MAPPING}/sparsify.py", "04"),
    ),
    Departure(
        "III-E",
        "edges that were driven are kept whatever RE says of them; the paper prunes all below "
        "p_edge",
        (f"{_MAPPING}/insertion.py", "05"),
    ),
    Departure(
        "III-E, IV-C.1",
        f"p_reuse is {_MAP.p_reuse:g}, not {paper.P_REUSE:g}, and where no vertex can replace an "
        f"anchor an edge may",
        (f"{_MAPPING}/edge_rules.py", "05"),
        "Fig. 13: rules of reuse",
    ),
    Departure(
        "III-E",
        "of several vertices the one with the largest product of RE is reused, and never backwards "
        "along a trajectory, as in the authors' code; at either end of a trajectory an anchor is "
        "its own neighbour",
        (f"{_MAPPING}/edge_rules.py", f"{_MAPPING}/reuse.py", "05"),
    ),
    Departure(
        "III-E",
        f"RE compares an anchor with the {_MAP.candidates} vertices most alike and, where it is "
        f"high, their neighbours, not with all",
        (f"{_MAPPING}/retrieval.py", f"{_MAPPING}/edge_search.py", "05"),
        "Cost of a growing map",
    ),
    Departure(
        "III-E",
        "edges by turning join drives that meet and look different ways, by scans and colours",
        (f"{_MAPPING}/turn_edges.py", "05"),
    ),
    Departure(
        "III-E",
        "a rule says which vertices are outdated, which the paper leaves to future work",
        (f"{_MAPPING}/edge_rules.py", "05"),
    ),
    Departure(
        "III-F",
        "one image of the goal is repeated in place of its context",
        ("driving/data/recorded_world.py", "06"),
        "Table II: one image, or a clip",
    ),
    Departure(
        "III-F",
        f"RE is asked about the {_PLANNER.candidates} vertices most alike at either end, not about "
        f"all; an edge from here needs more than {_PLANNER.p_query:g}, one to the goal more than "
        f"{_PLANNER.p_goal:g}, and a plan below {_PLANNER.least:g} is refused: the paper names no "
        f"thresholds",
        ("topology/planner.py", "06"),
        "Table II: one image, or a clip",
    ),
    Departure(
        "III-G",
        "an edge needs RE above p_edge for the two anchors before and after as well, and has the "
        "least of the five as its probability, as in the authors' code; the paper leaves open how "
        "sequences are matched",
        (f"{_MAPPING}/edge_search.py", "05"),
        "Fig. 12: starts that look alike",
    ),
    Departure(
        "III-G",
        "where a plan begins, a single view decides; sequences of views, or the filter, do so only "
        "as remedies, which are off unless asked for",
        ("topology/planner.py", "agents/place_guess.py", "07"),
        "Fig. 12: starts that look alike",
    ),
    Departure(
        "III-G",
        f"a robot that replans excludes the stretch that it could not pass, waits {WAIT:g} s for "
        f"what is in its way, plans from around the vertex that it visited last, takes an "
        f"improbable plan rather than none, and turns in place while it has none; the paper "
        f"excludes nothing",
        ("agents/navigator.py", "agents/blockades.py", "06"),
        "Blocked paths and foreign goals",
    ),
    Departure(
        "III-G",
        "visits are counted and cycles broken, which the paper leaves to future work",
        ("agents/remedies.py", "07"),
        "Fig. 12: starts that look alike",
    ),
    Departure(
        "III-G",
        "a Bayes filter over the vertices, which the paper declines; the wheels' odometry moves it",
        ("topology/localization.py", "07"),
        "A belief over vertices",
    ),
    Departure(
        "III-H",
        f"the states Turn, Lost and Done; Follow ends below p_lose = "
        f"{FollowerSettings().p_lose:g}, not below p_follow",
        (f"{_FOLLOWING}/transitions.py", "04"),
        "Disturbances",
    ),
    Departure(
        "III-H",
        "the active anchor stays where the paper falls back to the one after the last visited, and "
        "the last visited one never moves back; an overlap above a threshold, or the waypoint's "
        "distance, says what was visited",
        (f"{_FOLLOWING}/transitions.py", "04"),
    ),
    Departure(
        "III-H",
        "a search for an anchor's heading; in dead reckoning the anchors around are looked for, "
        "five steps in a row, and a new waypoint is asked for at its end",
        (f"{_FOLLOWING}/follower.py", f"{_FOLLOWING}/heading_search.py", "04"),
    ),
    Departure(
        "III-H",
        "doubts: a robot is lost where RE of its anchor falls at once and does not recover",
        (f"{_FOLLOWING}/state.py", "04"),
        "Disturbances",
    ),
    Departure(
        "IV",
        "images have 16 rows, not 64, and come from a raycaster in two dimensions",
        ("learning/views.py", "02"),
        "Table I: ablations",
    ),
    Departure(
        "IV",
        "generated floor plans, 120 to train C and 80 others to train RE, where the paper has 12 "
        "scanned buildings",
        ("learning/recipes.py", "learning/reach_recipes.py"),
        "Table I: ablations",
    ),
    Departure(
        "IV",
        "C learns from targets 1 m behind to 3 m ahead, the paper's from any with certain visual "
        "overlap; training images have changed colours, some of C's show obstacles that no "
        "recording has, and starts are turned by more than in the authors' code",
        ("learning/waypoint_pairs.py", "learning/batches.py", "driving/data/perturbation.py"),
    ),
    Departure(
        "IV-B, IV-C",
        f"a robot leaves its path when it is more than {STRAYED:g} m from it, and arrives within "
        f"{NEAR:g} m and {math.degrees(FACING):.0f}° of the goal's pose; the paper names no "
        f"distances",
        ("driving/metrics.py", "experiments/protocols/navigation.py"),
    ),
    Departure(
        "V",
        "with the filter a robot that is off the map turns and backs up until it knows a vertex; "
        "the paper does not handle this",
        ("agents/remedy_navigation.py", "07"),
    ),
)
