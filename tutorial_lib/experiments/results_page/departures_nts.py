"""What the course has and Chaplot et al. 2020 have not, or have otherwise."""

from __future__ import annotations

from tutorial_lib.experiments.results_page.departures import Departure
from tutorial_lib.exploration.explorable import CLEARANCE
from tutorial_lib.exploration.ghost_graph import BESIDE, EXPLORED
from tutorial_lib.exploration.goal_search import SearchSettings
from tutorial_lib.learning.exploration_data import FARTHEST, PANORAMAS
from tutorial_lib.learning.exploration_recipes import NTS as NTS_RECIPES
from tutorial_lib.learning.panorama_encoder import PIXELS, ROWS

_SEARCH = SearchSettings()
NTS = (
    Departure(
        "Sec. 4.1",
        f"F_L asks about the robot's own node first, then about at most four within {BESIDE:g} m "
        "by odometry, not about all",
        ("exploration/graph_update.py",),
        "Rules of the paper",
    ),
    Departure(
        "Sec. 4.1",
        f"a robot compares what it sees with its nodes and with the goal every "
        f"{_SEARCH.look_every:g} m, not at each step, and its nodes with the goal only when it is "
        f"given another one; the paper compares all nodes with the goal",
        ("exploration/goal_search.py", "agents/nts.py", "09"),
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
        "Sec. 4.1",
        "the local map is kept as the robot drives; paths keep off its walls, and what it has not "
        "seen costs more; the paper gives no such details",
        ("exploration/local_map.py", "exploration/local_policy.py"),
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
        "the goal's place, and depth where it is not measured; F_L is calibrated on validation "
        "worlds",
        ("learning/exploration_losses.py", "learning/exploration_recipes.py", "09"),
    ),
    Departure(
        "Appendix B",
        f"an explorable point is one that a robot gets to: obstacles block {CLEARANCE:g} m around "
        f"them; F_G learns from every panorama, not from sources of unconnected pairs only",
        ("exploration/explorable.py",),
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
        "Sec. 5, appendix A",
        f"panoramas of {ROWS} × {PIXELS} pixels in two dimensions, with 12 patches as in the "
        f"paper, whose images have 128 × 512",
        ("world/sensors.py", "09"),
    ),
    Departure(
        "Sec. 5",
        f"tests in generated apartments and offices, plain and with signs; {PANORAMAS} panoramas "
        f"of each plan as in the paper, but of {NTS_RECIPES['rgbd', ''].worlds} plans, "
        f"not 68, mirrored and in changed colours",
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
        "NTS's encoder, and its expert takes some actions at random; frontier exploration goes to "
        "random places that it has seen once no frontier is left",
        (
            "learning/exploration_policies.py",
            "learning/imitation_recipes.py",
            "learning/imitation_data.py",
            "agents/frontier.py",
        ),
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
