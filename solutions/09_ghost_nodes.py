# %% [markdown]
# # 09 · Ghost nodes
#
# **110 minutes.** You need notebooks 01, 03 and 05: frames, a network whose probabilities are calibrated, and a map whose vertices are images; section 11 also uses the planner of notebook 06. Nothing here needs notebook 08.
#
# After this notebook you can
#
# - say what a robot must be able to predict that looks for a place in a building where it has never been;
# - find the directions in which a place leads on, and keep the [[ghost node]]s of a graph in order;
# - choose where to explore, and write the loop of an exploring robot;
# - measure exploration by success and [[SPL]], between a random walk and an oracle;
# - say when a semantic score is worth something, when it is worth nothing, and how to tell the two apart.
#
# There are five exercises with hints behind folds, one of them large. When your function passes its check, **the cells below use it**; until then they use the library's. Cells that only draw are folded; unfold one to see its code. Seconds in brackets are those of an idle laptop; while other programs compute, cells take several times as long.
#
# We follow D. S. Chaplot, R. Salakhutdinov, A. Gupta and S. Gupta, [*Neural Topological SLAM for Visual Navigation*](https://arxiv.org/abs/2005.12256) (CVPR 2020), from here on "the paper".

# %%
import networkx as nx
import numpy as np

from tutorial_lib.checks.nb09 import (
    CELL,
    check_add_ghosts,
    check_explorable,
    check_explore,
    check_global_policy,
    check_spl,
    path_lengths,
)
from tutorial_lib.geometry import compose, inverse, relative
from tutorial_lib.learning import use_threads
from tutorial_lib.viz import show, sliders, table

use_threads(1)  # the network is small: a second thread would mostly wait

# %% hidden=true
# Imports for the worlds, the agents and the figures
from IPython.display import display
from scipy.ndimage import distance_transform_edt
from tqdm.auto import tqdm

from tutorial_lib.agents.frontier import FrontierAgent
from tutorial_lib.agents.nts import NTSAgent
from tutorial_lib.agents.oracle_explorer import OracleExplorer
from tutorial_lib.agents.random_walk import RandomWalkAgent
from tutorial_lib.agents.returning import ReturningAgent
from tutorial_lib.experiments import load_result
from tutorial_lib.experiments.nts.figs_pictures import pictures as paper_figures
from tutorial_lib.experiments.nts.table1 import PAPER
from tutorial_lib.experiments.nts.table2 import PAPER as PAPER_2
from tutorial_lib.experiments.nts.table2 import PAPER_STANDARD
from tutorial_lib.experiments.protocols.called_robot import CalledRobot
from tutorial_lib.experiments.protocols.visits import Recorder, draw_return, learned_from
from tutorial_lib.experiments.protocols.watching import watch
from tutorial_lib.exploration.episodes import (
    Episodes,
    draw_episodes,
    draw_sequence,
    exploration_world,
)
from tutorial_lib.exploration.labels import PanoramaLabels
from tutorial_lib.exploration.local_map import LocalMaps
from tutorial_lib.exploration.task import ExplorationTask, explore_on
from tutorial_lib.exploration.task import explore as run_agent
from tutorial_lib.learning.exploration_model import LearnedExploration
from tutorial_lib.viz import PlanView, chart, colours, faded, from_figure, side_by_side, stacked
from tutorial_lib.viz.canvas.ghost_graphs import draw_ghost_graph
from tutorial_lib.viz.figures.directions import map_picture, panorama_picture, scored_panorama
from tutorial_lib.world import PanoramicCamera, scene_of

# %% [markdown]
# ## 1 · A place never seen
#
# In notebooks 04 to 06 the car had driven through the building before: it had recordings, and made a map of them. Now there is **no map and no recording**. A robot is put down somewhere, is shown one picture, and has to go where that was taken. This is [[image-goal navigation]] in its hardest form (the paper, sections 3 and 5):
#
# - it sees a [[panorama]], all around, with the depth of each column; the goal is a panorama as well, from an unknown place with an unknown heading;
# - it can go ahead (0.25 m), turn left or right (10°), and stop; each motion is a little off, and so is its odometry, by noise that was measured on a real robot;
# - after 500 actions its time is up. It succeeds if it says *stop* within 1 m of the goal's place.
#
# Episodes are *easy*, *medium* or *hard*: 1.5–3 m, 3–5 m or 5–10 m from start to goal, along the shortest path. (The paper doesn't say which distance it means.)
#
# **Predict:** the goal's picture is all that the robot knows of the goal. In which of the three can it hope to see the goal's place at once? What can it do in the others, except look everywhere?

# %% hidden=true
# An apartment, an episode of each difficulty, and what the robot sees
WORLD = 10_004
home_name = exploration_world(WORLD, "wayfinding")
home = scene_of(home_name)
view = PlanView(home, 460, 380)
drawn = draw_episodes(
    home_name, home, {"easy": 1, "medium": 1, "hard": 1}, np.random.default_rng(5)
)
task = ExplorationTask({home_name: home}, drawn, np.random.default_rng(0))


def plan_picture(episode, path=None, pale=0.35):
    """The plan with the start and the goal of an episode, and perhaps a path."""
    picture = faded(view.base, pale)
    if path is not None:
        view.polyline(picture, path[:, :2], colours.TRACK, 4.0)
    view.goal(picture, episode.goals[0, :2])
    view.arrow(picture, episode.starts[0], colours.ROBOT, 11.0)
    return picture


plans = [plan_picture(drawn[[i]]) for i in range(3)]
titles = [f"{d}: {m:.1f} m" for d, m in zip(drawn.difficulty, drawn.shortest, strict=True)]
display(show(side_by_side(plans, titles, height=300)))
seen, goals = task.observe(), task.goals()
pictures = [panorama_picture(seen.image[2]), panorama_picture(goals.image[2])]
show(stacked(pictures, ["hard: what the robot sees at its start", "hard: the goal's picture"]))

# %% [markdown]
# <details><summary>Answer</summary>
# Where start and goal are in one room, the robot may see the goal's place at once: in most easy episodes, in few hard ones. In the others it has to <i>explore</i>. It can do better than look everywhere if it notices which doors lead to places that it has not seen, remembers those that it has passed, and guesses which of them leads to the goal.
# </details>
#
# ## 2 · Four functions
#
# The paper asks for four predictions, and builds everything else from them (section 4). Each is made from panoramas alone.
#
# **$\mathcal F_L$: am I in this node?** A [[node]] of the graph is a panorama. A picture belongs to the node if it was taken within $r = 3$ m of it, and its place is visible from there:
#
# $$ \mathcal F_L(I_N, I) = P\big(\lVert x_I - x_N \rVert \le r \ \text{and}\ x_I\ \text{is visible from}\ x_N\big). $$
#
# The same function says whether the *goal* belongs to what the robot sees. Its answers must be [[calibrated]], since the robot compares them with a threshold and acts on it.
#
# **$\mathcal F_G$: where does it go on?** For each of 12 directions, 30° apart: is there explorable area? That is a point at $r$ to which a short path leads (exercise 1). It looks at one panorama only: a door is a door, whatever the goal.
#
# **$\mathcal F_S$: where is the goal?** For each of the 12 directions a score: with $e_k$ the farthest point in direction $k$ to which the robot could drive straight within 3 m, and $d$ the length of the shortest path (appendix),
#
# $$ s_k = \max\!\Big(1 - \frac{d(e_k, \text{goal})}{20\ \text{m}},\ 0\Big). $$
#
# Where the goal is out of sight, nobody can *see* this. A network can only *guess* it, from what usually leads where: this is the **semantic score**.
#
# **$\mathcal F_R$: where exactly?** If the goal is in the same node: its bearing and distance. It decides where to stop.
#
# One network predicts all four: it has one encoder for both panoramas, and a head for each function (section 4.2). Directions are counted from where the robot looks: bin 0 is ahead, bin 1 is 30° to the left, and bin 12 would be bin 0 again.


# %%
model = LearnedExploration("nts_rgbd")  # `train nts --sensor rgbd` took half an hour to make it

# %% hidden=true
# The four functions and the truth for the hard episode and for a place near its goal
around = np.arange(12) * np.pi / 6
beside = drawn.goals[2, :2] + 1.2 * np.stack([np.cos(around), np.sin(around)], axis=1)
roomy = beside[home.clearance.at(beside).argmax()]
places = np.array([drawn.starts[2], [*roomy, 1.0]])
labels = PanoramaLabels(home, np.concatenate([places, drawn.goals[2:]]))
looks = ExplorationTask(
    {home_name: home},
    Episodes((home_name,) * 2, places, drawn.goals[[2, 2]], drawn.shortest[[2, 2]], ("hard",) * 2),
    np.random.default_rng(0),
)
views, wanted = looks.observe(), looks.goals()
source, goal = model.embed(views), model.embed(wanted)
sources, targets = np.array([0, 1]), np.array([2, 2])
near, right = model.relative(source, goal), labels.relative(sources, targets)
same, is_same = model.same_node(source, goal), labels.connected(sources, targets)
open_to = model.explorable(source) >= 0.5
rows = [
    [place, words, got, want]
    for i, place in enumerate(("at the start", "near the goal"))
    for words, got, want in (
        ("F_L: the goal is visible within 3 m, probability", same[i], float(is_same[i])),
        ("F_G: directions that agree, of 12", (open_to[i] == labels.explorable[i]).sum(), 12),
        (
            "F_S: mean error of the scores",
            np.abs(model.scores(source, goal)[i] - labels.scores(sources, targets)[i]).mean(),
            0.0,
        ),
        *(
            [
                ("F_R: bearing of the goal, °", np.rad2deg(near[i, 0]), np.rad2deg(right[i, 0])),
                ("F_R: distance of the goal, m", near[i, 1], right[i, 1]),
            ]
            if is_same[i]
            else []
        ),
    )
]
display(table({"place": "", "function": "", "predicted": ".2f", "true": ".2f"}, rows))
panels = [
    scored_panorama(
        views.image[i],
        model.scores(source, goal)[i],
        open_to[i],
        truth=labels.scores(sources, targets)[i],
    )
    for i in range(2)
]
show(stacked(panels, ["at the start", "near the goal"]))

# %% [markdown]
# Under each panorama: the 12 directions. A bar is the score $s_k$ (the scale reaches from the lowest to the highest of the picture); it is blue where $\mathcal F_G$ sees explorable area, and pale elsewhere. The orange line is the true score. Near the goal the best direction need not be that of the goal: the ends $e_k$ are 3 m away, beyond it. There $\mathcal F_R$ decides, not $\mathcal F_S$.
#
# **Predict:** $\mathcal F_S$ need not be right about metres. What must it get right, so that the robot goes the best way?
#
# <details><summary>Answer</summary>
# The <i>order</i> of the directions, and of those only the best one counts: the robot goes where the score is highest. A score that is 0.1 too high everywhere does no harm. That is why our network is also trained on the order, beside the numbers (the paper's is not), and why section 8 counts how often the best direction is found.
# </details>
#
# ## 3 · An episode, step by step
#
# Here is the agent of the library on a hard episode. On white is **what it remembers**: nodes (dark, numbered), the edges between them, and [[ghost node]]s at the rim (purple, the darker the higher their score). The green ring is where it is going, the blue arrowhead where it takes itself to be. Below: the goal's picture, what it sees now, and the panorama of its node with scores; the direction of the ghost that it goes to is green, if it hangs on this node.
#
# **Predict, before you ask for the truth:** at the first step, which direction would *you* take? Where in the building is the goal? Then move the slider, and at last choose *shown*: the plan, the goal (green ring with a dot), the true path, and the true scores (orange lines). (About 5 s.)

# %% hidden=true
# One hard episode of the library's agent, with a slider
EPISODES = 8
hard = draw_episodes(home_name, home, {"hard": EPISODES}, np.random.default_rng(11))


def fresh(episodes, scenes=None):
    """A task at the beginning of its episodes; the same ones in the same order have the same noise."""
    return ExplorationTask(scenes or {home_name: home}, episodes, np.random.default_rng(3))


def watched(number):
    """The agent on one episode, step by step, and whether it succeeds."""
    one = fresh(hard[[number]])
    agent = NTSAgent(model, np.random.default_rng(0))
    return watch(one, agent), one


stories = [watched(number) for number in range(EPISODES)]
good = [i for i in range(EPISODES) if stories[i][1].success[0]] or [0]
chosen = min(good, key=lambda i: abs(len(stories[i][0].panoramas) - 5))
story, done = stories[chosen]
blank = np.full_like(view.base, 255)


def graph_at(moment, known):
    """What the robot remembers, on white or on the plan."""
    picture = faded(view.base, 0.5) if known else blank.copy()
    if known:
        true = np.array([m.pose for m in story.moments[: story.moments.index(moment) + 1]])
        view.polyline(picture, true[:, :2], colours.TRACK, 4.0)
        view.goal(picture, done.goal_poses[0, :2])
    ghosts = [(node, place, score) for node, _, place, score in moment.ghosts]
    draw_ghost_graph(view, picture, moment.nodes, moment.edges, ghosts, moment.place)
    view.arrow(picture, moment.believed, colours.ROBOT, 10.0)
    return picture


def episode_at(step, truth):
    """The picture of a step, and words."""
    moment, known = story.moments[min(step, len(story.moments) - 1)], truth == "shown"
    node = moment.node
    has = np.isin(np.arange(12), [k for v, k, _, _ in moment.ghosts if v == node])
    to = moment.target[1] if moment.target and moment.target[0] == node else None
    panels = [
        panorama_picture(story.goal, 460, 56),
        panorama_picture(moment.image, 460, 56),
        scored_panorama(
            story.panoramas[node],
            story.scores[node],
            has,
            to,
            story.truth[node] if known else None,
            width=460,
        ),
    ]
    titles = ["the goal", "what it sees now", f"its node, {node}: directions and scores"]
    picture = stacked([graph_at(moment, known), stacked(panels, titles, gap=4)], gap=4)
    aim = "it knows where the goal is" if moment.found else f"it goes to {moment.target}"
    words = f"{len(moment.nodes)} nodes, {len(moment.ghosts)} ghosts; {aim}"
    return picture, words


last = len(story.moments) - 1
sliders(
    episode_at,
    {"step": "step", "truth": "the truth"},
    step=(0, last, 1, last // 2),
    truth=["hidden", "shown"],
)

# %% [markdown]
# Decide where the goal is before you run the next cell: it shows the truth half-way and at the end.

# %% hidden=true
# The truth about this episode
shots = [episode_at(step, "shown")[0] for step in (last // 2, last)]
display(show(side_by_side(shots, [f"step {last // 2}", f"step {last}"])))
print(f"success: {bool(done.success[0])}, SPL {done.spl[0]:.2f}, {int(done.steps[0])} actions")

# %% [markdown]
# <details><summary>What do you see?</summary>
# The robot does not go to the goal, it goes to <i>ghosts</i>: places 3 m from a node that might lead on. Whenever it leaves the sight of its node, it makes a new one, with ghosts of its own, and the ghost that it came to is gone. Ghosts that it did not choose stay where they are: that is the memory of doors passed by. And the graph on white is a little off: the arrowhead is where the wheels say that the robot is, and the plan above shows by how much they are wrong.
# </details>
#
# ## 4 · Where does it go on?
#
# The label that $\mathcal F_G$ learns comes from geometry. Take the map of the obstacles that one panorama shows. In direction $k$ there is explorable area if the point $p_k$ at $r$ metres is reached by a path that is hardly longer than the straight line:
#
# $$ g_k = \big[\, \ell(p_k) \le 1.05\, r \,\big], \qquad p_k = r\,(\cos 30° k,\ \sin 30° k), $$
#
# with $\ell$ the length of the shortest path from the robot to a point on that map, infinite if there is none.
#
# **Predict:** why not simply ask whether the point is visible? And why not whether any path leads there?
#
# <details><summary>Answer</summary>
# A robot has a width: it may see a point through a gap in which it gets stuck; and a door post that covers the line by a hand's breadth does no harm, since a small detour leads around it. But a path that leads out of another door and around the house says nothing about <i>this</i> direction.
# </details>
#
# ### Exercise 1 · `explorable` (easy, 10 minutes)
#
# `path_lengths(free)` is given: an array (S, S) of $\ell$ in metres for each cell, `inf` where no path leads. The robot is in the middle cell, `(S // 2, S // 2)`, and S is odd; a cell is `CELL` (0.1) metres wide; columns go with x (ahead), rows with y (to the left).
#
# <details><summary>Hint 1: concept</summary>Twelve points on a circle, the cell of each, and a comparison of twelve lengths with one number.</details>
# <details><summary>Hint 2: approach</summary>np.arange(12) * np.pi / 6 are the bearings. Their cosines, times the radius, divided by CELL, and rounded, are columns counted from the middle; sines give rows. An array of rows and one of columns index twelve cells at once.</details>
# <details><summary>Hint 3: one line</summary>np.rint(...).astype(int) makes whole numbers of an array; table[rows, columns] looks up as many entries as rows has.</details>


# %% exercise="explorable"
def explorable(free, radius):
    """Whether each of 12 directions leads to explorable area (F_G's label).

    free: array (S, S) of True and False, where a robot can be; the robot is in
    the middle, looking along the columns; rows grow to its left.
    radius: metres, r; the map reaches farther than that.
    Returns an array (12,) of True and False; direction k is centred 30 k
    degrees to the left of straight ahead.
    """
    ### BEGIN SOLUTION
    lengths, middle = path_lengths(free), len(free) // 2
    bearings = np.arange(12) * np.pi / 6
    columns = middle + np.rint(radius * np.cos(bearings) / CELL).astype(int)
    rows = middle + np.rint(radius * np.sin(bearings) / CELL).astype(int)
    return lengths[rows, columns] <= 1.05 * radius
    ### END SOLUTION


# %%
explorable = check_explorable.use(explorable)

# %% [markdown]
# Your function on real panoramas: the depth of each column makes a local map (dark: where the robot's middle cannot be), and dots in the 12 directions: green where your function finds explorable area, orange where it finds none. Beside it the answer of $\mathcal F_G$, which sees the picture.
#
# **Predict:** at which kinds of places will no direction at all be explorable?

# %% hidden=true
# Explorable directions by geometry and by F_G at four places
spots = draw_episodes(home_name, home, {"easy": 60}, np.random.default_rng(2))
there = fresh(spots)
all_seen = there.observe()
by_network = model.explorable(model.embed(all_seen)) >= 0.5


def local_map(ranges):
    """Where the robot's middle can be, from one panorama's depth."""
    maps = LocalMaps(1, side=7.1, reach=3.5)
    maps.observe(np.array([0]), np.zeros((1, 3)), ranges[None])
    return distance_transform_edt(maps.grids[0] != 2) * CELL > 0.2


free_maps = [local_map(ranges) for ranges in all_seen.depth]
by_geometry = np.array([explorable(free, 3.0) for free in free_maps])
order = np.argsort(by_geometry.sum(axis=1), kind="stable")
rows = []
for i in order[[0, 20, 40, 59]]:
    both = [map_picture(free_maps[i], chosen, 30) for chosen in (by_geometry[i], by_network[i])]
    rows.append(side_by_side(both, ["your function", "F_G"], height=250, gap=8))
counts = by_geometry.sum(axis=1)
print(
    f"{len(counts)} places: {counts.mean():.1f} directions on average, none at "
    f"{(counts == 0).sum()}; F_G agrees in {(by_geometry == by_network).mean():.0%} of all"
)
show(stacked([side_by_side(rows[:2]), side_by_side(rows[2:])]))

# %% [markdown]
# <details><summary>What do you see?</summary>
# In a small room no point at 3 m is inside, and where the door does not happen to lie in one of the 12 directions, the room has <i>no</i> ghost: the radius that suits the paper's homes is large for small rooms. The library keeps all other directions in which a robot could drive a metre on a <b>reserve list</b> (ours), and turns to it when there are no ghosts left. Your loop in exercise 5 does without one; the gallery at the end shows what that costs.
# </details>
#
# ## 5 · The bookkeeping of ghosts
#
# A ghost is a pair: the node on which it hangs, and a direction. When a node is added, three things happen (section 4.1, Graph Update):
#
# 1. the new node gets a ghost in each explorable direction;
# 2. in a direction in which another node stands, the *new node* gets none: that way is known;
# 3. and the *other node* loses its ghost in the direction in which the new node now stands.
#
# So a ghost hangs on exactly one node, and always stands for something unexplored. An edge stores the relative pose of its ends by odometry (the paper's rule; the library takes it from $\mathcal F_R$ where a robot comes to a node that it knows), over a few metres only, so that drift does not add up over the building (compare notebook 01).
#
# **Predict:** the new node sees the other one in its direction 3. In which direction does the other one see the new node? What else must you know?
#
# <details><summary>Answer</summary>
# It depends on how the other node is turned: each node counts its directions from its own heading. With the pose of the other node in the frame of the new one, <code>inverse(pose)</code> is the pose of the new one in the frame of the other, and its bearing is the answer.
# </details>
#
# ### Exercise 2 · `add_ghosts` (medium, 12 minutes)
#
# A node stands in the direction whose bin is nearest to its bearing, `np.arctan2(y, x)`. Bins are 30° wide and centred on multiples of 30°; a bearing of 350° is in bin 0, and so is one of −10°.
#
# <details><summary>Hint 1: concept</summary>Begin with a copy of the ghosts, add, then take away: for every node beside the new one two ghosts may have to go, one on either side.</details>
# <details><summary>Hint 2: approach</summary>For each other node and pose: the new node sees it at pose, and it sees the new node at inverse(pose). In both cases the first two numbers are a place, the bearing of which is rounded to a bin. A set's method discard does nothing where the ghost is not there.</details>
# <details><summary>Hint 3: one line</summary>Bins from a bearing b in radians: round(b * 6 / np.pi) goes from -6 to 6; what makes 11 of -1 and 0 of 12?</details>


# %% exercise="add_ghosts"
def add_ghosts(ghosts, node, explorable, beside):
    """The ghosts after a node was added (Graph Update, section 4.1).

    ghosts: set of pairs (node, direction); it stays as it is.
    node: number of the new node.
    explorable: array (12,) of True and False, of the new node's directions.
    beside: dictionary, for each node beside the new one its pose (3,), x, y
    and heading, in the frame of the new node.
    Returns a new set of pairs.
    """
    ### BEGIN SOLUTION
    grown = set(ghosts) | {(node, k) for k in range(12) if explorable[k]}
    for other, pose in beside.items():
        for viewer, (x, y, _) in ((node, pose), (other, inverse(pose))):
            grown.discard((viewer, round(np.arctan2(y, x) * 6 / np.pi) % 12))
    return grown
    ### END SOLUTION


# %%
add_ghosts = check_add_ghosts.use(add_ghosts)

# %% [markdown]
# ### Find the bug
#
# A colleague has written the removal on both sides of an edge. Her robot explores, but it keeps going back to places where it has been. Her test passed: a robot in a long corridor. What is wrong?


# %%
def remove_between(ghosts, first, second, pose):
    """The colleague's ghosts after an edge; pose (3,) is second in first's frame."""
    there = round(np.arctan2(pose[1], pose[0]) * 6 / np.pi) % 12
    back = (there + 6) % 12
    return ghosts - {(first, there), (second, back)}


# %% hidden=true
# Her removal and yours on the edges of the episodes above
edges, fair, turned = 0, {"the first node": 0, "the second node": 0}, []
for story_of, _ in stories:
    nodes = story_of.moments[-1].nodes
    for v, w in story_of.moments[-1].edges:
        full = {(node, k) for node in (v, w) for k in range(12)}
        pose = relative(nodes[v], nodes[w])
        hers = full - remove_between(full, v, w, pose)
        yours = full - add_ghosts(full, v, np.zeros(12, bool), {w: pose})
        edges += 1
        turned.append(abs(pose[2]))
        for name, node in zip(fair, (v, w), strict=True):
            fair[name] += {g for g in hers if g[0] == node} == {g for g in yours if g[0] == node}
head = {"removed on the side of": "", "right": "d", "of edges": "d"}
display(table(head, [[name, right, edges] for name, right in fair.items()]))
print(f"the two nodes of an edge are turned by {np.rad2deg(np.mean(turned)):.0f}° on average")

# %% [markdown]
# <details><summary>Answer</summary>
# <code>there + 6</code> is the opposite direction <i>in the frame of the first node</i>. The second node counts from its own heading: it sees the first one in the direction of <code>inverse(pose)</code>. In a straight corridor both look the same way, and so her test passed. Elsewhere a wrong ghost goes, that is, a door that nobody has looked behind; and one stays that stands for the place from which the robot came, to which it faithfully returns. Nothing crashes. What finds such bugs is an invariant that is tested after every step: <i>in the direction of a neighbour there is no ghost</i>.
# </details>
#
# ## 6 · Where to go
#
# The **[[global policy]]** (section 4.1) is short. With $G$ the graph and $X$ the ghosts:
#
# $$ \text{long-term goal} = \begin{cases} \text{the node of the goal} & \text{if } \mathcal F_L \text{ finds it,}\\ \arg\max_{x \in X} s(x) & \text{otherwise.} \end{cases} $$
#
# Then Dijkstra's algorithm finds the shortest path over the graph, and the next node on it is where the local policy drives. At the end of the path, from the node on which the ghost hangs, it drives to the ghost itself.
#
# The best score alone does not count what it costs to get there: a ghost at the other end of the building with 0.71 wins against one ahead with 0.70. Later work, [*No RL, No Simulation*](https://arxiv.org/abs/2110.09470) (M. Hahn et al., NeurIPS 2021), adds the cost of the path. With $\ell$ the metres along the graph to the node of the ghost,
#
# $$ \arg\max_{x \in X}\; s(x) - w\, \frac{\ell(x)}{20\ \text{m}} , $$
#
# and $w = 0$ is the paper's rule.
#
# **Predict:** if the scores were *exact*, which $w$ would make the robot take the shortest path over a ghost to the goal? If they were noise, which one?
#
# <details><summary>Answer</summary>
# Exact scores: the whole path is the metres to the ghost and 20 m (1 − s) from there on, so both count the same: w = 1 (but for the 3 m from node to ghost). Noise: then nothing but the cost is known, and a large w, which goes to the nearest ghost, at least does not drive to and fro. In between it has to be chosen on worlds that are not the test worlds.
# </details>
#
# ### Exercise 3 · `global_policy` (medium, 10 minutes)
#
# `graph` is an undirected graph of networkx; `graph[v][w]["metres"]` is the length of an edge. You may use its algorithms: `nx.shortest_path(graph, v, w, weight="metres")` and `nx.single_source_dijkstra_path_length(graph, v, weight="metres")`.
#
# <details><summary>Hint 1: concept</summary>First the end of the path (the node of the goal, or that of the best ghost), then the path, then its next node.</details>
# <details><summary>Hint 2: approach</summary>max(ghosts, key=value) finds the best ghost, with a function value(ghost) of its score and the metres to its node. Two cases need care: no ghost and no goal; and a path of one node, where the robot is at the end already.</details>
# <details><summary>Hint 3: one line</summary>path[:2] has one or two nodes; which of them is the next one in both cases? And: 0 is a node, so ask "goal is None".</details>


# %% exercise="global_policy"
def global_policy(graph, here, ghosts, scores, goal=None, weight=0.0):
    """Where a robot goes next (Global Policy, section 4.1).

    graph: networkx graph whose edges have "metres".
    here: the node in which the robot is.
    ghosts: set of pairs (node, direction).
    scores: dictionary, a score for each pair (node, direction), also for
    pairs that are no ghosts.
    goal: the node in which the goal was localised, or None.
    weight: of the metres over the graph to a ghost's node, divided by 20,
    against its score.
    Returns the next node on the shortest path, which is `here` at its end, and
    the ghost at its end; None for the ghost if the path leads to the goal's
    node. With neither goal nor ghosts: `here` and None.
    """
    ### BEGIN SOLUTION
    ghost, end = None, goal
    if goal is None:
        if not ghosts:
            return here, None
        metres = nx.single_source_dijkstra_path_length(graph, here, weight="metres")
        ghost = max(ghosts, key=lambda g: scores[g] - weight * metres[g[0]] / 20)
        end = ghost[0]
    path = nx.shortest_path(graph, here, end, weight="metres")
    return path[:2][-1], ghost
    ### END SOLUTION


# %%
global_policy = check_global_policy.use(global_policy)

# %% [markdown]
# ## 7 · The whole robot
#
# ### How exploration is measured
#
# *Success* alone does not say whether a robot searched or knew. **[[SPL]]**, success weighted by path length ([P. Anderson et al. 2018](https://arxiv.org/abs/1807.06757)), does: with $S_i$ whether episode $i$ succeeded, $\ell_i$ the shortest path and $p_i$ what was travelled,
#
# $$ \text{SPL} = \frac1N \sum_i S_i\, \frac{\ell_i}{\max(p_i, \ell_i)} . $$
#
# **Predict:** a robot that may stop 1 m before the goal can travel *less* than $\ell_i$. What would SPL be without the max? And can a robot that searches at random have a high success and a low SPL?
#
# <details><summary>Answer</summary>
# Above 1, so that one lucky episode would pay for another one. And yes: in a small building a robot that searches long enough comes past the goal; success says nothing about the detour, and that is why exploration is compared by SPL.
# </details>
#
# ### Exercise 4 · `spl` (easy, 4 minutes)
#
# <details><summary>Hint 1: concept</summary>A ratio for each episode, zero where it failed, and the mean of all.</details>
# <details><summary>Hint 2: approach</summary>np.maximum compares two arrays, number by number. True counts as 1 and False as 0 in a product.</details>
# <details><summary>Hint 3: one line</summary>np.mean(a * b) is the mean of products; what are a and b here?</details>


# %% exercise="spl"
def spl(success, shortest, travelled):
    """Mean success weighted by path length.

    success: array (N,) of True and False.
    shortest: array (N,), metres from start to goal; above 0.
    travelled: array (N,), metres that the robot has driven.
    Returns a number.
    """
    ### BEGIN SOLUTION
    return np.mean(success * shortest / np.maximum(shortest, travelled))
    ### END SOLUTION


# %%
spl = check_spl.use(spl)

# %% [markdown]
# ### The loop
#
# Now all of it together. A `robot` answers what the four functions predict where it stands, and drives where you say; each drive takes as many of its 500 steps as it needs.
#
# | call | what it does |
# |---|---|
# | `robot.steps` | a number: actions left; 0 when it has stopped, too |
# | `robot.sees_goal()` | $\mathcal F_L$: whether it sees the goal's place |
# | `robot.to_goal()` | drives there by $\mathcal F_R$ and stops; True then, and False where something was mistaken for the goal |
# | `robot.node()` | $\mathcal F_L$: the number of the node in which it is, or None |
# | `robot.beside()` | poses of the nodes beside it, in its frame, as `add_ghosts` takes them |
# | `robot.explorable()`, `robot.scores()` | $\mathcal F_G$ and $\mathcal F_S$: arrays (12,) |
# | `robot.remember(node)` | keeps what it sees here as the panorama of a new node; number them 0, 1, 2, … |
# | `robot.to_node(node)` | drives to a node next to the one where it is |
# | `robot.to_ghost(ghost)` | drives to a ghost of the node where it is; True if it has arrived, False if it cannot |
#
# ### Exercise 5 · `explore` (large, 35 minutes)
#
# Round by round, until no steps are left:
#
# 1. If it sees the goal: drive there; if that returns True, you are done. Otherwise go on below.
# 2. In which node is it? If in none, **or if it has just arrived at a ghost**, it makes a new one: a node of the graph, an edge to each node beside it with the `metres` to that, the ghosts by `add_ghosts`, and a score for each of its directions; then `remember`. (Two rules here are ours, not the paper's: edges to *each* node beside it, and a node at a ghost also where $\mathcal F_L$ still has the robot in the old one. 3 m may be visible from there, but what lies behind is not.)
# 3. Ask `global_policy`, without a goal, for the next node. Without any ghost left, you are done. If the next node is another one, drive there, and begin the next round.
# 4. Otherwise the ghost hangs on this node: drive to it. Whether it has arrived or not, the ghost is gone: it was explored, or cannot be reached.
#
# <details><summary>Hint 1: concept</summary>Four things are remembered from round to round: the graph, the ghosts, the scores, and whether the robot has just arrived at a ghost.</details>
# <details><summary>Hint 2: approach</summary>The number of a new node is the number of nodes so far. Call robot.beside() before robot.remember(node), and add_node before the edges: the first node has none beside it. scores is a dictionary with the key (node, direction) for all 12 directions of every node. After to_node it has not arrived at a ghost.</details>
# <details><summary>Hint 3: one line</summary>graph.add_edge(v, w, metres=...) makes an edge; np.hypot(x, y) is the length of a pose's place; ghosts - {one} is a set without one of them.</details>


# %% exercise="explore"
def explore(robot):
    """Explore until the robot has stopped at the goal, or cannot go on.

    robot: see the table above.
    Returns True if to_goal() returned True, else False; the graph, an
    nx.Graph whose edges have "metres"; and the set of ghosts that are left.
    """
    ### BEGIN SOLUTION
    graph, ghosts, scores, arrived = nx.Graph(), set(), {}, False
    while robot.steps > 0:
        if robot.sees_goal() and robot.to_goal():
            return True, graph, ghosts
        here = robot.node()
        if here is None or arrived:
            here, beside = len(graph), robot.beside()
            graph.add_node(here)
            for other, pose in beside.items():
                graph.add_edge(here, other, metres=np.hypot(pose[0], pose[1]))
            ghosts = add_ghosts(ghosts, here, robot.explorable(), beside)
            for k, score in enumerate(robot.scores()):
                scores[here, k] = score
            robot.remember(here)
        node, ghost = global_policy(graph, here, ghosts, scores)
        if ghost is None:
            break
        if node != here:
            robot.to_node(node)
            arrived = False
            continue
        arrived = robot.to_ghost(ghost)
        ghosts = ghosts - {ghost}
    return False, graph, ghosts
    ### END SOLUTION


# %%
explore = check_explore.use(explore)

# %% [markdown]
# The same loop drives a real robot: the episodes of section 3, with noise, walls and a network that is sometimes wrong. Beside it, on the same episodes: a **random walk**, which drives to random places in sight until it sees the goal; **frontier exploration**, which enters what the depth camera sees into a metric map and goes to the nearest place where the known part ends, whatever the goal; the **library's agent**; and an **oracle**, which knows the building. All but the oracle notice the goal and drive to it in the same manner.
#
# **Predict:** order the five by SPL. (About 10 s.)


# %% hidden=true
# Four agents on the same hard episodes
def all_at_once(agent_of, episodes=hard, scenes=None):
    """Success and metres of an agent, all its episodes in lock-step; and the task."""
    many = fresh(episodes, scenes)
    run_agent(many, agent_of(many))
    return many


others = {
    "random walk": lambda many: RandomWalkAgent(model, np.random.default_rng(0)),
    "frontier exploration": lambda many: FrontierAgent(model),
    "the library's agent": lambda many: NTSAgent(model, np.random.default_rng(0)),
    "oracle": OracleExplorer,
}
tasks = {name: all_at_once(agent_of) for name, agent_of in others.items()}

# %% hidden=true
# Your loop beside them
results, runs = {}, []
for number in tqdm(range(EPISODES), "episodes", leave=False):
    one = fresh(hard[[number]])
    robot = CalledRobot(one, model)
    _, graph, ghosts = explore(robot)
    runs.append((one, robot, graph, ghosts))
results["your loop"] = tuple(
    np.array([getattr(one, what)[0] for one, *_ in runs]) for what in ("success", "travelled")
)
results |= {name: (many.success, many.travelled) for name, many in tasks.items()}
names = ("random walk", "frontier exploration", "your loop", "the library's agent", "oracle")
rows = [
    [name, results[name][0].sum(), spl(results[name][0], hard.shortest, results[name][1])]
    for name in names
]
head = {"agent": "", f"success, of {EPISODES} hard episodes": "d", "SPL": ".2f"}
table(head, rows, {"SPL": lambda values: max(values[:-1])})  # the oracle is a bound

# %% hidden=true
# One of your episodes: its graph on the plan, and its path
solved = [i for i in range(EPISODES) if runs[i][0].success[0]] or [0]
number = min(solved, key=lambda i: abs(len(runs[i][2]) - 6))
one, robot, graph, ghosts = runs[number]
picture = plan_picture(hard[[number]], np.array(one.path)[:, 0], 0.5)
poses = np.array([compose(hard.starts[number], robot.nodes[node]) for node in graph.nodes])
bearings = {(node, k): poses[node, 2] + k * np.pi / 6 for node, k in ghosts}
left = [
    (g[0], poses[g[0], :2] + 3 * np.array([np.cos(b), np.sin(b)]), 0.0) for g, b in bearings.items()
]
draw_ghost_graph(view, picture, poses, graph.edges, left)
show(picture)

# %% [markdown]
# (A ghost may be close to another node than its own: only the bin in which a node stands has none.)
#
# The library's agent has what your loop has, and more, all of it ours: it asks $\mathcal F_L$ on the way, every half metre, and so makes nodes between ghosts, too; it keeps all poses on the edges, and knows where a ghost is from any node; a new node also removes the ghosts within a metre of it; and it has the reserve list, and drives to random nodes once that is used up.
#
# Eight episodes in one building are few: the order of the middle three may differ in the next building. The command `python -m tutorial_lib experiment nts_table1` runs all agents in twenty test worlds (section 9).
#
# ## 8 · What is a semantic score worth?
#
# $\mathcal F_S$ is the heart of the paper: it makes the choice among ghosts depend on the goal. But can it know? Here is a test without any network. In every building, at many places, a *decision*: several directions, of which one is nearest to the goal. Two models of the same kind (trees with gradient boosting), fitted in other buildings, rank the directions. **Blind** gets of each direction how far it is free, and the kind of room and the space to the walls, here and at its end, and how far these are from their means over the directions. **Goal** also gets the kind of room of the goal, compared in the same way. Nobody has to perceive anything: all these are true. What *goal* gains over *blind* is what it is worth to know that much of the goal.
#
# And two kinds of buildings: **plain** ones, where rooms have colours by what they are for; and **wayfinding** ones, as hospitals and car parks have them: accents on the walls change their hue with the distance from one end of the building. There both models read how far along the scale each direction leads, and *goal* reads it in the goal's picture, too. (For a network the hues are different in every building, so that it cannot learn a palette: it has to compare.)
#
# **Predict, and write it down:** for easy, medium and hard, in plain and in wayfinding buildings: how much does it help to know the goal? Where least?

# %% hidden=true
# A plain building and the same with wayfinding accents; and the stored result
plain = scene_of(exploration_world(WORLD, "plain"))
both = [PlanView(plain, 460, 380).base, view.base]
display(show(side_by_side(both, ["plain", "wayfinding"], height=300)))
spot = drawn.starts[[2]]
camera = PanoramicCamera()
looks = [panorama_picture(camera.look(one, spot)[0][0], 700, 70) for one in (plain, home)]
titles = ["plain: from the start of section 1", "wayfinding: from the same place"]
display(show(stacked(looks, titles, gap=4)))
report = load_result("nts_wayfinding")
levels, found = ("easy", "medium", "hard"), {}
for row in report.rows:
    found[row["signs"], row["difficulty"], row["model"]] = row
figure, axes = chart(8.5, 3.4, 2)
for axis, signs in zip(axes, ("plain", "wayfinding"), strict=True):
    for by, (shift, tone) in {
        "blind": (-0.2, colours.FAINT),
        "goal": (0.2, colours.ROBOT),
    }.items():
        picked = [found[signs, level, by] for level in levels]
        top = np.array([row["top1"] for row in picked])
        bars = np.array([[row["top1"] - row["low"], row["high"] - row["top1"]] for row in picked])
        axis.bar(np.arange(3) + shift, top, 0.38, yerr=bars.T, color=colours.unit(tone), label=by)
    axis.set_xticks(range(3), levels)
    axis.set(ylim=(0, 1), title=signs)
axes[0].set(ylabel="finds the best direction")
axes[1].legend(loc="upper left", ncols=2)
display(show(from_figure(figure)))
head = {"buildings": "", "difficulty": "", "decisions": ",d", "blind": ".2f", "goal": ".2f"}
head |= {"gain": "+.2f", "from": "+.2f", "to": "+.2f"}
rows = []
for signs in ("plain", "wayfinding"):
    for level in levels:
        blind, knows = (found[signs, level, by] for by in ("blind", "goal"))
        numbers = [blind["top1"], knows["top1"], knows["gain"]]
        numbers += [knows["gain_low"], knows["gain_high"]]
        rows.append([signs, level, knows["decisions"], *numbers])
table(head, rows)

# %% [markdown]
# *Finds the best direction* means that the end of the chosen one is at most half a metre farther from the goal than that of the best. Lines and *from*, *to* are 95 % intervals over buildings; `python -m tutorial_lib experiment nts_wayfinding` makes the table.
#
# <details><summary>What does the table say?</summary>
# In <b>plain</b> buildings knowing the goal gains 8 points on easy, 8 on medium, and 2 on hard decisions: next to nothing. Up to a few metres the goal's room, or what is seen of it through a door, is often at the end of some direction, and can be recognised. Farther away it is not: the goal's room lies behind several doors, most of them to hallways, and which rooms lie behind the next corner hardly depends on what they are for. Little in the picture says where the goal is, and no network can learn what is not there.
#
# In <b>wayfinding</b> buildings the gain is 25 points, 29 and 16: the colour of a wall, compared with that of the goal's picture, says which direction is nearer, also from far away. On hard ones the goal model finds the best direction in 70 % of all decisions, and in 51 % in plain buildings.
# </details>
# <details><summary>Then why does F_S help in the paper, whose homes have no accents?</summary>
# A likely reason: homes are not drawn at random. A bathroom is beside bedrooms, a kitchen beside the dining room, and wherever the places of rooms depend on their kinds, kinds say something about places. In its Table 1 the advantage over the next best agent is largest on hard episodes, and its Fig. 10 shows a robot that takes another ghost for another goal. It is the <i>buildings</i> that carry the semantics; a network can only find them there.
# </details>
#
# **How would you find out** whether a score that *you* have trained knows anything about the goal?
#
# <details><summary>Answer</summary>
# Not by its loss, nor by comparing it with chance: a network that never looks at the goal can learn that hallways lead on and closets do not, and beats chance by far. Train the same network <i>blind</i>, without the goal, and compare the two on the same decisions: only the difference is knowledge of the goal. This is what <code>train nts --blind</code> and <code>experiment nts_scores</code> are for: the next cell shows what they found.
# </details>

# %% hidden=true
# The trained network and the same without the goal, on the same decisions in twenty test worlds,
# where the goal is in another node: elsewhere the robot asks F_R, and not F_S
head = {"buildings": "", "difficulty": "", "decisions": ",d", "blind": ".2f", "F_S": ".2f"}
head |= {"gain": "+.2f", "from": "+.2f", "to": "+.2f"}
found = {
    (row["signs"], row["difficulty"], row["score"]): row
    for row in load_result("nts_scores").rows
    if row["sensor"] == "rgbd" and row["pairs"] == "unconnected"
}
rows = []
for signs in ("plain", "wayfinding"):
    for level in levels:
        blind, knows = (found[signs, level, by] for by in ("blind", "semantic"))
        numbers = [
            blind["top1"],
            knows["top1"],
            *(blind[f"gain{end}"] for end in ("", "_low", "_high")),
        ]
        rows.append([signs, level, knows["decisions"], *numbers])
table(head, rows)

# %% [markdown]
# <details><summary>What does this table say?</summary>
# It counts decisions whose goal is in another node, since F_S is asked only there (section 4.2). On <b>easy</b> ones the goal is worth 33 to 39 points and on medium ones 22 to 27: much of what its picture shows is in sight, and a network can compare the two pictures, which the models above could not. On <b>hard</b> ones in plain buildings it is worth nothing to the network, and next to nothing to the models; with wayfinding accents it is worth 8 points. On hard decisions <i>blind</i> and <i>F_S</i> are above both models: a network sees the shape of every door, a model knew only a length, a kind of room and a clearance. So the gains of the two tables are not shares of one another, and the decisions are not the same either: here, the directions are those that are free for a metre. Note how good <i>blind</i> is where the goal is far: which direction leads out of a room is the same for most goals.
# </details>
#
# ### Fig. 10, and ours: one place, two goals
#
# The paper shows the first step of two episodes with one start. For a living room the robot picks the ghost down the hallway; for a bedroom it picks another one of the same ghosts.
#
# Here are two such starts, in test worlds with wayfinding accents. Geometry chose them, not the network: the goals are 5 to 10 m away, in different kinds of rooms and in different directions. The number at a ghost is its score, amber leads to the ghost that is picked first, and light blue is what the robot then drove. Titles count directions as section 2 does.
#
# **Predict:** at how many of the two starts does the robot pick two ghosts?

# %% hidden=true
# The twin of Fig. 10, from a stored run
fig10 = [row for row in load_result("nts_figs").rows if row["figure"] == 10]
show(paper_figures(fig10)["fig10"])

# %% [markdown]
# <details><summary>What does it show?</summary>
# At one of the two. In the office it picks the directions 11 and 6: the first is the best, and the second is next to the best. In the apartment it picks 4 for both goals, where 0 and 3 are best. For the hallway that's the wrong way, and it drives 43 m. One pair of pictures shows what a score <i>can</i> do. How often it does so is in the table above.
# </details>
#
# ## 9 · Table 1
#
# The paper's main table: success and SPL in scanned homes, with an RGBD camera, 1,000 episodes of each difficulty. Beside it ours: the same task and protocol in simpler buildings, seen in two dimensions; 300 episodes of each difficulty in twenty test worlds. The two agents trained by reinforcement (RL) have only the paper's rows: they're part of the course's last notebook.
#
# **Predict:** in two dimensions, with a depth camera all around, which of the agents has it much easier than in the paper?

# %% hidden=true
# The paper's Table 1, and ours
NAMES = {"il": "imitation", "fbe": "frontier exploration", "ans_like": "metric map, learned goal"}
NAMES |= {"nts": "ghost nodes (NTS)", "random": "random walk", "oracle": "oracle"}
NAMES |= {"target_rl": "target-driven RL", "map_rl": "metric map and RL"}
ours = {}
for row in load_result("nts_table1").rows:
    ours.setdefault((row["agent"], row["sensor"], row["signs"]), []).append(row)
head = {"agent": "", "by": ""}
for level in levels:
    head |= {f"{level}: success": ".2f", f"SPL ({level})": ".2f"}
rows = []
for agent in ("random", "il", "target_rl", "map_rl", "fbe", "ans_like", "nts", "oracle"):
    if (agent, "rgbd") in PAPER:
        values = [number for pair in PAPER[agent, "rgbd"] for number in pair]
        rows.append([NAMES[agent], "the paper", *values])
    for signs in ("plain", "wayfinding"):
        mine = {row["difficulty"]: row for row in ours.get((agent, "rgbd", signs), [])}
        if mine:
            values = [mine[level][what] for level in levels for what in ("success", "spl")]
            rows.append([NAMES[agent], f"ours, {signs}", *values])
table(head, rows)

# %% [markdown]
# <details><summary>Answer</summary>
# Frontier exploration: a depth camera that sees all around in a plane maps a room from its door. In the paper's homes metric maps lose much as the goal gets farther, and the authors name errors of the pose, which add up in the map, as the likely cause. So read the table by <i>differences between rows</i> of one kind, not across: what an agent gains over frontier exploration is what its memory and its scores are worth. And the best rows of ours are not those of the ghosts: a <i>metric map with a learned goal</i> chooses among the frontiers of a map that, in two dimensions, is nearly complete and whose pose drifts little, and it was trained on the true distances to the goal. Imitation, which the paper's homes defeat, learns much of it too. An advantage that depends on the world is no law.
# </details>
#
# ### The paper's robot, and the course's car
#
# The robot of this notebook is the paper's: it's round, and it turns in place. The course's car explores, too, with the same panorama. It doesn't go ahead, left or right by an action: an agent gives it a waypoint, and the motion policy of notebook 02 drives there for half a second, with three-point turns.
#
# **Predict:** does the car find fewer goals than the round robot? And what becomes of SPL?

# %% hidden=true
# Both robots on the same goals in the plain ones of twenty test worlds
cars = load_result("nts_table1_car")
both = {"round": load_result("nts_table1").rows, "car": cars.rows}
rows = []
for agent in ("random", "nts", "oracle"):
    for robot, found in both.items():
        mine = {
            row["difficulty"]: row
            for row in found
            if (row["agent"], row["sensor"], row["signs"]) == (agent, "rgbd", "plain")
        }
        values = [mine[level][what] for level in levels for what in ("success", "spl")]
        actions = np.mean([mine[level]["steps"] for level in levels])
        rows.append([NAMES[agent], robot, *values, actions])
scores_by_level = {
    name: ".2f" for level in levels for name in (f"{level}: success", f"SPL ({level})")
}
display(table({"agent": "", "robot": ""} | scores_by_level | {"actions": ".0f"}, rows))
print(cars.notes[-1])  # where they did not fit as the round robot stands

# %% [markdown]
# <details><summary>Answer</summary>
# The car finds as many. On medium goals NTS succeeds in 93 % with the car and in 91 % with the round robot. SPL falls from 0.73 to 0.63: the metres of a car's turns count, and a robot that turns in place drives none. The oracle shows what the turns alone cost, 1.00 and 0.87 on medium goals. The car needs fewer actions, since the round robot spends one on each 10° of a turn; that may be why the car finds a few more of the hard goals in time.
# </details>
#
# ### Table 2, and ours: what stopping and noise cost
#
# The paper takes away one hardship at a time. *Without stop*, an episode ends by itself once the robot is near its goal. *Without noise*, motion and odometry are exact.
#
# **Predict:** without noise, who gains in the paper: agents with a metric map, or the one with a graph? And who gains here?

# %% hidden=true
# The twin of Table 2, from a stored run: success over all difficulties
found = {
    (row["agent"], row["signs"], row["condition"]): row["success"]
    for row in load_result("nts_table2").rows
    if row["difficulty"] == "overall"
}
changed, rows = ("no_stop", "no_noise"), []
for agent in ("il", "target_rl", "map_rl", "fbe", "ans_like", "nts"):
    runs_of = {"the paper": [PAPER_STANDARD[agent], *(PAPER_2[agent, c][-1] for c in changed)]}
    for signs in ("plain", "wayfinding"):
        if (agent, signs, "standard") in found:
            shares = [found[agent, signs, c] for c in ("standard", *changed)]
            runs_of[f"ours, {signs}"] = shares
    for by, (usual, no_stop, no_noise) in runs_of.items():
        gains = [100 * (share - usual) for share in (no_stop, no_noise)]
        rows.append([NAMES[agent], by, usual, no_stop, gains[0], no_noise, gains[1]])
head = {"agent": "", "by": "", "success": ".2f"}
for what in ("without stop", "without noise"):
    head |= {what: ".2f", f"gain {what}, points": "+.1f"}
table(head, rows)

# %% [markdown]
# <details><summary>Answer</summary>
# Both outcomes differ from the paper's. <b>Stopping</b> costs NTS 12 points there and 0 here: none of our episodes fails because a robot at its goal doesn't stop. F<sub>L</sub> and F<sub>R</sub> recognise a goal and its distance too well for that.
#
# <b>Noise</b> costs frontier exploration 7 points in the paper and the learned metric map 10, since errors of the pose add up (section 6), and NTS 1. Here it costs nobody more than about one point. Without it NTS even loses 3 points in plain buildings; why, we don't know.
# </details>
#
# ### Fig. 8, and ours: goals one after another
#
# Whether it reached its goal or not, the robot gets another one, 1.5 to 5 m from the last, with 500 more actions, and keeps its graph: ten in a row. Two other robots lack a part. *No graph* takes the best score of the panorama that it sees, and remembers nothing. *No score* picks a ghost at random.
#
# In the paper all three fall with the number of goals. The gap to *no graph* grows, because the graph knows more and more; the gap to *no score* shrinks, because even random exploration fills the graph (section 6.1).
#
# **Predict:** does either gap do the same here, in plain and in wayfinding buildings?

# %% hidden=true
# The twin of Fig. 8, from a stored run
fig8 = load_result("nts_fig8")
ABLATIONS = {
    "nts": ("NTS", colours.ROBOT, "o-"),
    "nts_no_graph": ("no graph", colours.INK, "s--"),
    "nts_no_score": ("no score", colours.PERSON, "^:"),
}
figure, axes = chart(9.0, 3.6, 2)
rows = []
for axis, signs in zip(axes, ("plain", "wayfinding"), strict=True):
    for agent, (name, tone, style) in ABLATIONS.items():
        mine = [row for row in fig8.rows if (row["agent"], row["signs"]) == (agent, signs)]
        count, success, low, high = (
            np.array([row[key] for row in mine]) for key in ("goals", "success", "low", "high")
        )
        axis.plot(count, success, style, color=colours.unit(tone), label=name)
        axis.fill_between(count, low, high, color=colours.unit(tone), alpha=0.12, linewidth=0)
        if agent != "nts":
            ends = (mine[0], mine[-1])
            gaps = [100 * end["success_gap"] for end in ends]
            span = [100 * ends[1][f"success_gap_{side}"] for side in ("low", "high")]
            rows.append([name, signs, *gaps, *span, *(end["spl_gap"] for end in ends)])
    axis.set(title=signs, xlabel="goals so far", ylim=(0.7, 1.0), xticks=range(1, 11))
axes[0].set_ylabel("success")
axes[0].legend(loc="lower left", fontsize=11)
head = {"NTS less": "", "buildings": "", "success, one goal: points": "+.1f", "ten goals": "+.1f"}
head |= {"from": "+.1f", "to": "+.1f", "SPL, one goal": "+.3f", "SPL, ten goals": "+.3f"}
display(show(from_figure(figure)))
table(head, rows)

# %% [markdown]
# <details><summary>Answer</summary>
# In the end all fall, as in the paper. Bands, and <i>from</i> and <i>to</i>, are 95 % intervals over buildings.
#
# The gap to <b>no graph</b> grows in plain buildings. With wayfinding accents it doesn't: after ten goals <i>no graph</i> leads by one point of success, which its interval allows to be nothing. A likely reason: where signs lead the way, the best score in sight is enough, and there's little to remember.
#
# The gap to <b>no score</b> grows in both kinds of buildings, where the paper's shrinks: from 1.2 points of success to 9.5, and from 5.6 to 14.5. We haven't measured why.
# </details>
#
# ## 10 · The failures that remain
#
# **Predict:** which of these can happen to a robot that explores with ghosts? (a) It passes the goal and does not see it. (b) It stops at a wrong place. (c) It runs out of ghosts while half of the building is unexplored. (d) It runs out of steps. (About 10 s.)

# %% hidden=true
# The library's agent on hard episodes of two more buildings
elsewhere = []
for seed, signs in tqdm(((10_003, "plain"), (10_005, "wayfinding")), "buildings", leave=False):
    name = exploration_world(seed, signs)
    scene = scene_of(name)
    some = draw_episodes(name, scene, {"hard": 8}, np.random.default_rng(seed))
    many = all_at_once(others["the library's agent"], some, {name: scene})
    elsewhere.append((name, scene, some, many))

# %% hidden=true
# A gallery: your loop and the library's agent
gallery, tried, kinds = [], {"your loop": 0, "the library's": 0}, []
for name, scene, some, many in tqdm(elsewhere, "buildings", leave=False):
    ends = [("the library's", many, i) for i in range(len(some))]
    for i in range(len(some)):
        one = fresh(some[[i]], {name: scene})
        explore(CalledRobot(one, model))
        ends.append(("your loop", one, 0))
    plan = PlanView(scene, 420, 300, margin=4)
    for by, done_task, i in ends:
        tried[by] += 1
        if done_task.success[i]:
            continue
        off = np.linalg.norm(done_task.poses[i, :2] - done_task.goal_poses[i, :2])
        why = "out of steps" if done_task.steps[i] >= 500 else f"stopped {off:.1f} m off"
        why = why if done_task.done[i] else "no ghost left"
        picture = faded(plan.base, 0.5)
        plan.polyline(picture, np.array(done_task.path)[:, i, :2], colours.TRACK, 3.0)
        plan.disc(picture, done_task.goal_poses[i, :2], 0.7, colours.PAPER)
        plan.disc(picture, done_task.goal_poses[i, :2], 0.5, colours.GOAL)
        plan.arrow(picture, done_task.episodes.starts[i], colours.ROBOT, 9.0)
        gallery.append((picture, f"{by}: {why}"))
        kinds.append((by, why.split()[0]))
words = {"out": "out of steps", "stopped": "stopped elsewhere", "no": "no ghost left"}
head = {"agent": "", "hard episodes": "d"} | dict.fromkeys(words.values(), "d")
rows = [[by, tried[by], *(kinds.count((by, kind)) for kind in words)] for by in tried]
display(table(head, rows))
shown = gallery[:: max(-(-len(gallery) // 6), 1)]
pairs = [shown[i : i + 2] for i in range(0, len(shown), 2)]
rows = [side_by_side(*zip(*pair, strict=True), gap=8) for pair in pairs]
show(stacked(rows)) if rows else print("None failed; draw more episodes.")

# %% [markdown]
# Each picture: the start (blue arrowhead), the goal (green dot), and where the robot drove (light blue).
#
# <details><summary>What causes them?</summary>
# <b>(d)</b> is the most frequent end, <b>out of steps</b>: scores of far places are guesses, and a robot that follows the best guess goes to and fro between ghosts with similar scores; or the score is wrong for good, and the robot is thorough in the wrong wing. <b>(c) No ghost left</b> happens to your loop, not to the library's: where no direction is explorable by the paper's definition (section 4), the loop ends, while the library goes on with its reserve list. <b>(b) Stopped elsewhere</b> can happen, if the network takes another place for the goal's (F_L) or its distance is off (F_R), but it did not in these episodes: wrong beliefs are corrected on the way, from nearer by. <b>(a)</b> shows as out of steps: a goal behind furniture is not visible from every place within 3 m. Ask of each: was it the <i>score</i>, the <i>graph</i>, or the <i>recognition of the goal</i>?
# </details>
#
# ## 11 · Coming back
#
# The robot forgets the building when the episode ends. But its run is a trajectory like those of notebook 05, and the agent of notebook 06 can learn it. A panorama even shows more than a car's camera: a picture ahead can be cut out of it, and one **over the shoulder**, so that the robot also knows the way back. On a second visit that agent plans over its map; and what notebook 06 could not do, to go where no path is probable enough, the explorer of this notebook does.
#
# **Predict:** how much of the second visit is driven from memory if the goal was passed on the first one? And if it was not? (About 5 s.)

# %% hidden=true
# A first visit with six goals; then goals that it passed, and one that it did not
rng = np.random.default_rng(6)
first = draw_episodes(home_name, home, {"medium": 1}, rng)
visited = ExplorationTask({home_name: home}, first, rng)
recorder = Recorder(NTSAgent(model, rng))
list(explore_on(visited, recorder, draw_sequence(home, first.goals, 6, rng)))
path = np.array(visited.path)[:, 0]
memory = learned_from(recorder.run)
again, kinds = draw_return(home_name, home, path, {"passed": 4, "elsewhere": 1}, rng)
back = fresh(again)
returning = ReturningAgent(memory, NTSAgent(model, rng))
run_agent(back, returning)
rows = [
    [i, kind, bool(back.success[i]), int(back.steps[i]), int(returning.recalled[i]), back.spl[i]]
    for i, kind in enumerate(kinds)
]
head = {
    "trial": "",
    "its goal was": "",
    "reached": "",
    "actions": "d",
    "along a path of the map": "d",
}
display(table(head | {"SPL": ".2f"}, rows))
whole = plan_picture(first, path)
shots = [plan_picture(again[[i]], np.array(back.path)[:, i]) for i in range(len(again))]
titles = [f"{i}: {kind}" for i, kind in enumerate(kinds)]
begun = f"first visit: {len(recorder.run)} actions, {len(memory.topomap)} vertices"
rows = [[whole, *shots[:2]], shots[2:]]
words = [[begun, *titles[:2]], titles[2:]]
pairs = zip(rows, words, strict=True)
show(stacked([side_by_side(row, said, height=230) for row, said in pairs]))

# %% hidden=true
# The map with the explorer behind it and either alone, in twenty test worlds
head = {"buildings": "", "goals": "", "method": "", "trials": ",d", "success": ".2f", "SPL": ".2f"}
words = {"both": "map and explorer", "memory": "map alone", "explorer": "explorer alone"}
rows = [
    [row["signs"], row["goals"], words[row["method"]], row["trials"], row["success"], row["spl"]]
    for row in load_result("nts_second_visit").rows
    if row["signs"] == "plain"
]
table(head, rows)

# %% [markdown]
# <details><summary>What does it show?</summary>
# Goals that the robot passed: the map alone leads to 94 % of them, the explorer alone finds 84 %, and both together 99 %, with the shortest paths, since seven of ten actions are on paths of the map; the rest is getting to the map and from it to the goal. Goals elsewhere, at least 2 m from the first path and often many rooms away: the map alone is lost, and the robot with both explores as the explorer does. Both together are as good as the better of the two, within a percent, or better: the planner refuses where no path is probable, and that is when the explorer is called.
# </details>
#
# ## Optional extras
#
# - **Extra 1.** In `explore`, call `global_policy` with `weight=0.3`, and with 1. Run the cell of the five agents again. Do detours get shorter? (Run no check meanwhile: it demands the paper's rule.)
# - **Extra 2.** Let `explore` ignore the scores: `scores[here, k] = 0`, and then as random numbers. What is lost on hard episodes, and what on easy ones? (Draw easy ones in the cell of section 3.)
# - **Extra 3.** Give `explore` a reserve list: the directions in which `robot.explorable()` is False become ghosts once there are no others left. How many episodes does it save, and what does it cost where no path leads to the goal?
#
# ## What is ours
#
# Ghosts, the four functions and the global policy are the paper's. But a paper leaves gaps, and some of its rules we've changed:
#
# - **Am I here?** The robot asks $\mathcal F_L$ about its own node first, then about at most four nearby. The paper asks about every node (4.1). In validation buildings there was no difference.
# - **Edges to a known node** get their pose from $\mathcal F_R$; the paper takes odometry (4.1). No difference either.
# - **A ghost that is reached becomes a node**, even if $\mathcal F_L$ says that the robot never left the old one. In the paper a new node needs a robot that's in none (4.1). This one matters: without it, hard goals fall from 71 to 39 % in plain buildings, and from 88 to 37 % in wayfinding ones.
# - **Where ghosts go:** a node within a metre removes them, and so does one in sight that has no edge. When none are left, there's the reserve list.
# - **The goal:** several guesses of its place are averaged, a place where it isn't seen is refused, and the robot stops at 0.6 m by its own estimate.
# - **$\mathcal F_S$ learns from all pairs.** The paper's learns only where the goal is in another node (appendix B). Ours does no better for it.
# - **The network** matches the columns of two panoramas and learns more than the paper's five losses. The paper's is a ResNet18 (appendix A).
# - **The world** is flat and generated, Active Neural SLAM is supervised here, and a car explores, too.
#
# The [page of results](../tutorial_lib/results/README.md#what-is-ours-in-nts) has the whole list, with its numbers. Beside it stands every table and figure of the paper.
#
# ## What to remember
#
# - A place never seen can be explored with a graph of panoramas and ghosts: what was seen, and what was passed by.
# - Four predictions from panoramas are enough: am I here, where does it go on, where is the goal likely, where is it exactly.
# - A ghost hangs on one node and stands for what is unexplored. Directions belong to a frame: half a turn is the way back only where both look the same way.
# - SPL measures detours; give success *and* SPL, between a random walk and an oracle.
# - A semantic score is worth what the buildings are worth: measure it against the same network without the goal.
#
# **Read next:** the paper, and its supplement on labels. On exploring by frontiers: B. Yamauchi, [*A Frontier-Based Approach for Autonomous Exploration*](https://doi.org/10.1109/CIRA.1997.613851) (CIRA 1997). On metric maps with a learned goal: D. S. Chaplot et al., [*Learning to Explore using Active Neural SLAM*](https://arxiv.org/abs/2004.05155) (ICLR 2020).
