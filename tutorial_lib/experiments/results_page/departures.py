"""What is ours: where the course departs from the papers, and where in it that is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from tutorial_lib.agents.blockades import WAIT
from tutorial_lib.driving.metrics import GRACE, STRAYED
from tutorial_lib.experiments.protocols.navigation import FACING, NEAR
from tutorial_lib.experiments.results_page import paper
from tutorial_lib.experiments.results_page.markdown import link, listed
from tutorial_lib.exploration.ghost_graph import BESIDE, EXPLORED
from tutorial_lib.exploration.goal_search import SearchSettings
from tutorial_lib.learning.exploration_data import FARTHEST, PANORAMAS
from tutorial_lib.learning.exploration_recipes import NTS as NTS_RECIPES
from tutorial_lib.learning.panorama_encoder import PIXELS, ROWS
from tutorial_lib.topology.following.transitions import FollowerSettings
from tutorial_lib.topology.mapping.edge_rules import MapSettings
from tutorial_lib.topology.planner import DijkstraPlanner

NOTEBOOKS = {
    "02": "02_local_control",
    "03": "03_reachability",
    "04": "04_sparsification",
    "05": "05_map_building",
    "06": "06_probabilistic_planning",
    "07": "07_aliasing",
    "09": "09_ghost_nodes",
}


@dataclass(frozen=True)
class Departure:
    """Something that a paper has not, or has otherwise.

    Attributes:
        section: of the paper.
        what: the course has instead.
        where: files of the library, and numbers of notebooks.
        measured: section of the page that shows what it changes; none if empty.
    """

    section: str
    what: str
    where: tuple[str, ...]
    measured: str = ""


def departures(found: Sequence[Departure]) -> str:
    """A list in Markdown."""
    lines = []
    for one in found:
        places = listed([_place(where) for where in one.where])
        measured = f"; {link(one.measured)}" if one.measured else ""
        lines.append(f"- {one.section}: {one.what} ({places}{measured}).")
    return "\n".join(lines)


def _place(where: str) -> str:
    """A link to a notebook or a file, seen from the page.

    >>> _place("09"), _place("topology/planner.py")
    ('[09](../../notebooks/09_ghost_nodes.ipynb)', '[planner.py](../topology/planner.py)')
    """
    if where in NOTEBOOKS:
        return f"[{where}](../../notebooks/{NOTEBOOKS[where]}.ipynb)"
    return f"[{where.rpartition('/')[2]}](../{where})"


_MAP, _PLANNER, _SEARCH = MapSettings(), DijkstraPlanner(), SearchSettings()
_FOLLOWING, _MAPPING = "topology/following", "topology/mapping"
MENG = (
    Departure(
        "III-A",
        "images have 16 rows, not 64, and come from a raycaster in two dimensions",
        ("learning/views.py", "02"),
        "Table I: ablations",
    ),
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
        f"a rollout that touches something counts as not reached; pairs far apart without overlap "
        f"do so without a rollout; {GRACE:g} s are added to the time limit, as in the authors' "
        f"code",
        ("driving/data/rollout_outcomes.py", "03"),
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
        "III-E",
        f"p_reuse is {_MAP.p_reuse:g}, not {paper.P_REUSE:g}, and where no vertex can replace an "
        f"anchor an edge may",
        (f"{_MAPPING}/edge_rules.py", "05"),
        "Fig. 13: rules of reuse",
    ),
    Departure(
        "III-E",
        "of several vertices the one with the largest product of RE is reused, and never backwards "
        "along a trajectory, as in the authors' code",
        (f"{_MAPPING}/edge_rules.py", "05"),
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
        "an edge needs RE above p_edge for the two anchors before and after as well, as in the "
        "authors' code; the paper leaves open how sequences are matched",
        (f"{_MAPPING}/edge_search.py", "05"),
        "Fig. 12: starts that look alike",
    ),
    Departure(
        "III-G",
        f"a robot that replans excludes the stretch that it could not pass, waits {WAIT:g} s for "
        f"what is in its way, plans from around the vertex that it visited last, and turns in "
        f"place while it has no plan; the paper excludes nothing",
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
        "the active anchor stays where the paper falls back to the one after the last visited; an "
        "overlap, or the waypoint's distance, says what was visited",
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
        "generated floor plans, 120 to train C and 80 others to train RE, where the paper has 12 "
        "scanned buildings",
        ("learning/recipes.py", "learning/reach_recipes.py"),
        "Table I: ablations",
    ),
    Departure(
        "IV-B, IV-C",
        f"a robot leaves its path when it is more than {STRAYED:g} m from it, and arrives within "
        f"{NEAR:g} m and {math.degrees(FACING):.0f}° of the goal's pose; the paper names no "
        f"distances",
        ("driving/metrics.py", "experiments/protocols/navigation.py"),
    ),
)
NTS = (
    Departure(
        "Sec. 4",
        f"panoramas of {ROWS} × {PIXELS} pixels in two dimensions, with 12 patches as in the "
        f"paper, whose images have 128 × 512",
        ("world/sensors.py", "09"),
    ),
    Departure(
        "Sec. 4.1",
        f"F_L asks about the robot's own node first, then about at most four within {BESIDE:g} m "
        "by odometry, not about all",
        ("exploration/graph_update.py",),
        "Rules of the paper",
    ),
    Departure(
        "Sec. 4.1",
        f"a robot compares what it sees every {_SEARCH.look_every:g} m, not at each step",
        ("exploration/goal_search.py", "09"),
    ),
    Departure(
        "Sec. 4.1",
        "a new edge to a known node has its pose from F_R, not from odometry",
        ("exploration/graph_update.py",),
        "Rules of the paper",
    ),
    Departure(
        "Sec. 4.1",
        "a ghost that is reached becomes a node even where F_L has the robot in the old one",
        ("agents/nts.py", "09"),
        "Rules of the paper",
    ),
    Departure(
        "Sec. 4.1",
        "a robot that passes a node on its path within 0.8 m is in that node, whatever F_L says",
        ("exploration/global_policy.py",),
    ),
    Departure(
        "Sec. 4.1",
        f"a ghost also goes where a node is within {EXPLORED:g} m of it, where one in sight stands "
        f"in its direction without an edge, and where a robot has come no nearer for 50 steps",
        ("exploration/ghost_graph.py", "exploration/exploring_robot.py", "09"),
    ),
    Departure(
        "Sec. 4.1",
        "a reserve of other free directions takes over when there are no ghosts left, and then "
        "random nodes",
        ("exploration/ghost_graph.py", "agents/nts.py", "09"),
    ),
    Departure(
        "Sec. 4.1",
        "several estimates of the goal's place are averaged, a place where it is not seen is "
        f"refused, and the robot stops at an estimated {_SEARCH.stop_within:g} m",
        ("exploration/goal_search.py",),
    ),
    Departure(
        "Sec. 4.2, appendix A",
        "the network: circular convolutions over columns, columns matched between panoramas, "
        "attention between directions; no ResNet18, and no weights from other images",
        ("learning/panorama_encoder.py", "learning/panorama_network.py"),
    ),
    Departure(
        "Sec. 4.2, appendix A",
        "more losses: the order of the directions, kinds of rooms, the bearing within a direction, "
        "the goal's place, and depth where it is not measured",
        ("learning/exploration_losses.py", "09"),
    ),
    Departure(
        "Appendix B",
        f"F_S learns from all pairs up to {FARTHEST:g} m apart and directions free for a metre, "
        f"not from unconnected pairs only",
        ("learning/exploration_data.py", "learning/exploration_recipes.py"),
        "Scores of directions",
    ),
    Departure(
        "Appendix B",
        "the farthest traversable point of a direction is that of the true map, not of the "
        "panorama's",
        ("exploration/labels.py",),
    ),
    Departure(
        "Sec. 5",
        f"tests in generated apartments and offices, plain and with signs; {PANORAMAS} panoramas "
        f"of each plan as in the paper, but of {NTS_RECIPES['rgbd', ''].worlds} plans",
        ("learning/exploration_recipes.py", "09"),
        "Signs that lead",
    ),
    Departure(
        "Sec. 5",
        "an episode's distance is that of the shortest path; the paper does not say which",
        ("exploration/episodes.py", "09"),
    ),
    Departure(
        "Sec. 5.1",
        "a supervised choice of frontier stands for Active Neural SLAM; imitation begins with "
        "NTS's encoder",
        ("learning/exploration_policies.py", "learning/imitation_recipes.py"),
        "Table 1: image-goal navigation",
    ),
    Departure(
        "Sec. 6.1",
        "without a graph, explorable directions come first and then free ones, and the robot goes "
        "to the end of one before it chooses again",
        ("agents/nts.py",),
    ),
    Departure(
        "Not in the paper",
        "the car that explores",
        ("exploration/car_task.py",),
        "Table 1 with a car",
    ),
    Departure(
        "Not in the paper",
        "the second visit with a map of Meng's agent",
        ("agents/returning.py", "09"),
        "A second visit",
    ),
)
