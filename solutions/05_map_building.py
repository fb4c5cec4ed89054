# %% [markdown]
# # 05 · Map building
#
# **120 minutes.** You need notebooks 03 and 04: the estimator $\mathcal{RE}$, which predicts the probability that the local controller gets from one image to another, and the anchors, the few images of a trajectory that are kept.
#
# After this notebook you can
#
# - turn the anchors of many trajectories into one graph without coordinates, and explain its edges and weights;
# - insert a trajectory into a map: reuse what is there, add what is new, connect both;
# - explain what perceptual aliasing does to a map, and why sequences of anchors help;
# - say why a map need not evaluate all pairs, and how fast it grows;
# - make a map forget what has changed, and store it on disk.
#
# There are six exercises with hints behind folds, one of them large. When your function passes its check, **the cells below use it**; until then they use the library's. Cells that only draw are folded; unfold one to see its code.
#
# We follow X. Meng, N. Ratliff, Y. Xiang and D. Fox, [*Scaling Local Control to Large-Scale Topological Navigation*](https://arxiv.org/abs/1909.12329) (ICRA 2020), from here on "the paper".

# %%
from itertools import pairwise

import networkx as nx
import numpy as np

from tutorial_lib.checks.nb05 import (
    BY_HAND,
    DRIVEN,
    SmallMap,
    check_ahead_of,
    check_ask_next,
    check_edge_weights,
    check_insert,
    check_reusable,
    check_weakest_aligned,
)
from tutorial_lib.learning import use_threads
from tutorial_lib.topology import Anchors, MapSettings, TopoMap, add_trajectory
from tutorial_lib.viz import edge_table, show, sliders, table

use_threads(1)  # the networks are small: a second thread would mostly wait

# %% hidden=true
# Imports for the buildings and the figures
import tempfile
import time
from dataclasses import dataclass
from functools import partial
from itertools import permutations
from pathlib import Path

from IPython.display import display
from tqdm.auto import tqdm

from tutorial_lib.driving import GridPaths, RecordedWorld, demonstrate_between
from tutorial_lib.errors import InputError
from tutorial_lib.experiments import (
    WORMHOLE,
    Building,
    experiences,
    facing,
    load_result,
    make_building,
    spread_places,
    vertex_poses,
)
from tutorial_lib.geometry import wrap
from tutorial_lib.learning import ReachabilityNetwork, WaypointNetwork
from tutorial_lib.topology import anchors_of, likeness, load_map, most_alike, save_map
from tutorial_lib.viz import (
    PlanView,
    aligned_sequences,
    camera_picture,
    chart,
    closeup,
    colours,
    draw_edges,
    draw_topomap,
    from_figure,
    hue,
    side_by_side,
    stacked,
    write_beside,
)
from tutorial_lib.world import Camera, scene_of, world_name

# %% [markdown]
# ## 1 · From trajectories to one graph
#
# A robot that follows the anchors of one trajectory gets to the end of that trajectory, and nowhere else. Two trajectories that cross offer more: begin on the first, change at the crossing, and end where the second one ends. What is missing is where a robot can change. $\mathcal{RE}$ predicts it: it can be evaluated on *any* two anchors, of the same trajectory or not.
#
# So all [[anchor]]s of all trajectories become one **directed graph**, a [[topological map]] (paper, III-E):
#
# - a **[[vertex]]** is an anchor $\hat o_i$ with its context, and nothing else: no position, no heading;
# - an **[[edge]]** leads from $\hat o_i$ to $\hat o_j$ if the controller gets from the one to the other;
# - its **weight** is $w(\hat o_i, \hat o_j) = -\log \mathcal{RE}(\hat o_i, \hat o_j)$.
#
# Here are two trajectories of three anchors each, $0 \to 1 \to 2$ and $3 \to 4 \to 5$, and $\mathcal{RE}$ from each anchor (row) to each (column). Framed cells are steps of a trajectory.
#
# An edge needs $\mathcal{RE} > p_\text{edge}$; the others are **pruned**, since they would hardly ever be used with success. Edges along a trajectory are always kept: the car did drive there. (That exemption is ours; the paper prunes whatever lies below $p_\text{edge}$, III-E.) **Take a pencil:** how many edges are there at $p_\text{edge} = 0.9$? There are three traps.

# %%
show(edge_table(BY_HAND, np.zeros_like(BY_HAND), DRIVEN, blank=True))

# %% [markdown]
# <details><summary>Answer</summary>
# Ten. From 0 to 1 and 4; from 1 to 2, 4 and 5; from 3 to 1 and 4; from 4 to 1, 2 and 5. The 1.00 on the diagonal are no edges, since no robot needs to drive to where it is. (First trap.) From 2 to 5 it is 0.90, which is not greater than 0.9. (Second trap.) From 3 to 4 it is only 0.62, but a trajectory goes there. (Third trap.)
# </details>
#
# **Why directed?** Look at 0 and 1: from 0 to 1 it is 0.97, from 1 to 0 only 0.30. Driving forwards, the robot sees the next anchor ahead. To go back it has to turn first, and does not see the target. For a car that cannot turn on the spot, one-way streets are everywhere.
#
# **Why a logarithm?** On the path from 3 over 1 to 5 two steps must succeed, and if they are independent, their probabilities are multiplied: $0.91 \cdot 0.93$. Shortest-path algorithms *add* weights. The logarithm turns one into the other,
#
# $$ \sum_{\text{edges}} -\log \mathcal{RE} \;=\; -\log \prod_{\text{edges}} \mathcal{RE}, $$
#
# and the minus sign makes the most probable path the shortest one. Since $\mathcal{RE} \le 1$, no weight is negative, as Dijkstra's algorithm requires (notebook 06).
#
# ### Exercise 1 · `edge_weights` (easy, 8 minutes)
#
# There is an edge where $\mathcal{RE}$ is *greater* than `p_edge`, or where a trajectory goes; never from a vertex to itself, even if `driven` says so. Where there is no edge, the weight is $\infty$: `np.inf`. $\log 0$ is $-\infty$; to keep a driven edge finite even there, any $\mathcal{RE}$ below $10^{-12}$ counts as $10^{-12}$.
#
# <details><summary>Hint 1: concept</summary>Two steps: which pairs are edges, and what does each one weigh? The first is a Boolean table.</details>
# <details><summary>Hint 2: approach</summary>An edge is where reach is above p_edge, or where driven is True, but never on the diagonal: np.fill_diagonal(table, value) changes a table in place. np.maximum(x, 0.5) lets no number be below 0.5.</details>
# <details><summary>Hint 3: one line</summary>np.where(mask, one, other) takes one where mask is True, and other elsewhere. Which of the two is np.inf here?</details>


# %% exercise="edge_weights"
def edge_weights(reach, driven, p_edge):
    """The weights of a map's edges.

    reach: (V, V) array; reach[i, j] is RE from vertex i to vertex j, 0 to 1.
    driven: (V, V) Boolean array, True where a trajectory goes from i to j.
    p_edge: there is an edge where RE is greater, or where driven is True; none
    from i to i.
    Returns a new (V, V) array: -log RE where there is an edge (natural
    logarithm; RE below 1e-12 counts as 1e-12), np.inf where there is none.
    """
    ### BEGIN SOLUTION
    kept = (reach > p_edge) | driven
    np.fill_diagonal(kept, False)
    return np.where(kept, -np.log(np.maximum(reach, 1e-12)), np.inf)
    ### END SOLUTION


# %%
edge_weights = check_edge_weights.use(edge_weights)

# %% [markdown]
# **Predict:** which path leads from 3 to 5 by the fewest edges, and which is the most probable one?


# %% hidden=true
# Paths from 3 to 5, by networkx
def graph_of(weights, vertices=None):
    """A networkx graph of weights (V, V); those of `vertices` only, if given."""
    graph = nx.DiGraph()
    graph.add_nodes_from(range(len(weights)) if vertices is None else map(int, vertices))
    there = np.argwhere(np.isfinite(weights))
    graph.add_weighted_edges_from((int(i), int(j), float(weights[i, j])) for i, j in there)
    return graph


graph = graph_of(edge_weights(BY_HAND, DRIVEN, 0.9))
rows = []
for name, weight in (("fewest edges", None), ("most probable", "weight")):
    path = nx.shortest_path(graph, 3, 5, weight)
    factors = [BY_HAND[i, j] for i, j in pairwise(path)]
    product = " · ".join(f"{p:.2f}" for p in factors)
    rows.append([name, " to ".join(map(str, path)), product, np.prod(factors)])
head = {"path": "", "vertices": "", "RE of its edges": "", "product": ".2f"}
table(head, rows, {"product": max}, f"the graph above: {graph.number_of_edges()} edges")

# %% [markdown]
# <details><summary>What is odd about the answer?</summary>
# The most probable path has one edge <i>more</i>. Its last two steps, 0.96 · 0.99 = 0.95, are surer together than the single 0.93 of the path over 1 alone; going over 4 at once, 0.62 spoils everything. (And a path is weaker than its weakest link, since every link may fail: that is what the product says.)
# </details>
#
# ## 2 · A building
#
# Now for real: an apartment that no network has seen, four places in it, and a trajectory from each place to each other one. From now on everything comes from these twelve trajectories. Each has its colour. (About 7 s.)

# %% hidden=true
# The apartment, four places and twelve trajectories
apartment = make_building(10_020, seed=0, count=4)
view = PlanView(apartment.scene, 700, 530)
people_camera = Camera(rows=64)  # the network's view, with 64 rows in place of 16

picture = view.base.copy()
for index, trajectory in enumerate(apartment.recorded.trajectories):
    view.polyline(picture, trajectory.poses[:, :2], hue(index), 2)
for index, place in enumerate(apartment.places):
    view.goal(picture, place)
    write_beside(view, picture, "ABCD"[index], [*place, 0.0], off=22)
metres = sum(trajectory.arc_length[-1] for trajectory in apartment.recorded.trajectories)
frames = [len(trajectory) for trajectory in apartment.recorded.trajectories]
print(f"{len(frames)} trajectories, {metres:.0f} m, {sum(frames)} images")
show(picture)

# %% [markdown]
# Notebook 04 chose the anchors of trajectories; here with $k = 5$ at $p_\text{sparsify} = 0.99$, the value of the paper's Fig. 5 (IV-A). Then $\mathcal{RE}$ is evaluated on **all** pairs of anchors, once, and kept in a table. (About 14 s, the slowest cell of this notebook. Section 6 shows why a real map must not do this.)

# %% hidden=true
# Anchors of all trajectories, and RE between all of them
reachability, predictor = ReachabilityNetwork("reach_k5"), WaypointNetwork("waypoint_k5")


@dataclass
class AllPairs:
    """A building, the anchors of its trajectories, and RE between all pairs of them.

    The anchors of all trajectories share one numbering; `trajectories` holds
    those of each.
    """

    building: Building
    anchors: list[Anchors]
    trajectories: list[np.ndarray]
    reach: np.ndarray
    poses: np.ndarray
    seen: np.ndarray  # embeddings as observations, for section 6
    shown: np.ndarray  # embeddings as targets


def query_all_pairs(building):
    """Anchors of all trajectories, and RE between all of them."""
    view, k = predictor.view, predictor.architecture.k
    kept, everything = [], TopoMap(reachability)
    seen = tqdm(list(experiences(building)), desc="trajectories", leave=False)
    for index, experience in enumerate(seen):
        seen = experience.observations
        anchors = anchors_of(reachability, seen, view.of(seen), k, 0.99, experience.timestamps)
        places = np.arange(len(anchors))
        everything.make_vertices(*anchors.subset(places), 0 * places + index, places)
        kept.append(anchors)
    count = len(everything)
    every = np.arange(count)
    rows = [
        everything.vertices.between(np.full(count, source), every)
        for source in tqdm(every, desc="pairs of anchors", leave=False)
    ]
    reach = np.array(rows)
    trajectories = np.split(np.arange(count), np.cumsum([len(anchors) for anchors in kept])[:-1])
    index, poses = everything.index, vertex_poses(building, everything)
    return AllPairs(building, kept, trajectories, reach, poses, index.seen, index.shown)


home = query_all_pairs(apartment)
count = len(home.reach)
print(f"{count} anchors, {count / sum(frames):.1%} of the images; {home.reach.size} pairs")
print(f"RE from {home.reach.min():.3f} to {home.reach.max():.4f}")

# %% [markdown]
# The poses are only for *our* figures and counts. The map never gets them.
#
# **Predict:** of the pairs with $\mathcal{RE} > 0.99$, how many have $\mathcal{RE} > 0.99$ in the *reverse* direction, and how many less than 0.5? What do those look like?

# %% hidden=true
# Pairs that are sure in one direction, and the least sure way back
sure = (home.reach > 0.99) & ~np.eye(count, dtype=bool)
back = home.reach.T[sure]
print(f"{sure.sum()} pairs above 0.99; back: {(back > 0.99).sum()} above 0.99, ", end="")
print(f"{(back < 0.5).sum()} below 0.5")


def views_of(data, anchors, width=300):
    """The views at anchors, one below the other."""
    images = people_camera.look(data.building.scene, data.poses[list(anchors)])[0]
    return stacked([camera_picture(image, width) for image in images], gap=4)


def edge_picture(view, data, source, target, margin=1.2):
    """Two anchors on the plan, and the view at each: blue the source, green the target."""
    picture = view.base.copy()
    draw_edges(view, picture, data.poses, [(source, target)], colours.INK, 2, heads=True)
    view.arrow(picture, data.poses[target], colours.GOAL, 9)
    view.arrow(picture, data.poses[source], colours.ROBOT, 9)
    ends = data.poses[[source, target], :2]
    cut = closeup(view, picture, ends, margin, square=True)
    return side_by_side([side_by_side([cut], height=204), views_of(data, (source, target))], gap=6)


close = np.linalg.norm(home.poses[:, None, :2] - home.poses[:, :2], axis=2) < 3.0
one_way = np.where(sure & close, home.reach.T, 1.0)
for trajectory in home.trajectories:  # pairs within one trajectory are no surprise
    one_way[np.ix_(trajectory, trajectory)] = 1.0
source, target = np.unravel_index(one_way.argmin(), one_way.shape)
there, back = home.reach[source, target], home.reach[target, source]
title = f"blue to green (the lower image): RE = {there:.3f}; green to blue: {back:.3f}"
show(stacked([edge_picture(view, home, source, target)], [title]))

# %% [markdown]
# <details><summary>What do they look like?</summary>
# The blue anchor faces the place of the green one; the green one faces onward, away from the blue. What lies behind is not in the image. Pairs that are reachable both ways are mostly close to each other with the same heading: the car may go forward a little, or back a little.
# </details>
#
# ### Two trajectories
#
# Two of the trajectories begin at the same place and part later. First the graph with **all** edges, then pruned at $p_\text{edge} = 0.99$, both by your `edge_weights`. **Predict:** what share of the edges remains?

# %% hidden=true
# All edges of two trajectories, and those that are left
first, second = home.trajectories[0], home.trajectories[1]
both = np.concatenate([first, second])


def driven_by(paths, count):
    """(V, V) True where a trajectory goes from vertex to vertex."""
    driven = np.zeros((count, count), dtype=bool)
    for path in paths:
        driven[path[:-1], path[1:]] = path[:-1] != path[1:]
    return driven


def map_picture(view, data, vertices, weights, trajectory_of, size=5.0):
    """Vertices in the colours of their trajectories, and the edges between them."""
    picture = view.base.copy()
    draw_edges(view, picture, data.poses, np.argwhere(np.isfinite(weights)), colours.FAINT)
    for vertex in vertices:
        view.arrow(picture, data.poses[vertex], hue(int(trajectory_of[vertex])), size)
    return picture


trajectory_of = np.repeat(
    np.arange(len(home.trajectories)), [len(trajectory) for trajectory in home.trajectories]
)
among = np.isin(np.arange(count), both)
ours = among[:, None] & among
driven = driven_by([first, second], count)
half = PlanView(apartment.scene, 440, 340)
panels, titles = [], []
for name, p_edge in (("dense", 0.0), ("pruned", 0.99)):
    weights = np.where(ours, edge_weights(home.reach, driven, p_edge), np.inf)
    panels.append(map_picture(half, home, both, weights, trajectory_of))
    titles.append(f"{name}: {len(both)} vertices, {np.isfinite(weights).sum()} edges")
show(side_by_side(panels, titles))

# %% [markdown]
# <details><summary>What was pruned, and what is left?</summary>
# Nearly everything: an edge through three walls has an RE of about 0.3, far below 0.99, and is never part of a good path. What is left connects neighbours. Where the two trajectories run side by side there are edges from one to the other; these are the places where a robot can change. But there each place is also in the map twice: at the beginning the arrows of the second trajectory hide those of the first. That is next.
# </details>
#
# ## 3 · Reuse
#
# Trajectories overlap. It is enough to store the common part once. The paper's rule (III-E): anchor $\hat o_i$ of a new trajectory is not needed if there is a vertex $\hat o$ that can take its place,
#
# $$ \mathcal{RE}(\hat o_{i-1}, \hat o) > p_\text{reuse} \quad\text{and}\quad \mathcal{RE}(\hat o, \hat o_{i+1}) > p_\text{reuse}. $$
#
# Then $\hat o_i$ is dropped, and the trajectory is led over $\hat o$: $\hat o_{i-1} \to \hat o \to \hat o_{i+1}$. Note what the rule does *not* check: whether $\hat o$ **looks like** $\hat o_i$, or is at the same place. It only has to do the same job.
#
# If several vertices qualify, we take the one for which both steps together are the most probable: the largest $r_1 \cdot r_2$. (The paper does not say which; its authors' code does so.) The first anchor is its own predecessor, and the last its own successor: at the first, the vertex must be reachable from the anchor; at the last, the anchor must be reachable from the vertex.
#
# ### Exercise 2 · `reusable` (easy, 8 minutes)
#
# If two vertices have the same product, either may be taken.
#
# <details><summary>Hint 1: concept</summary>First find those that qualify, then the best of them. Check whether there is one at all before you look for the best.</details>
# <details><summary>Hint 2: approach</summary>Three Boolean arrays, joined by &, say which vertices qualify; their .any() is whether there is one. To leave the indices as they are, do not select those that qualify: give the others a score that cannot win.</details>
# <details><summary>Hint 3: one line</summary>(heights * tall).argmax() is the highest of those that are tall, since False counts as 0. What stands for heights here?</details>


# %% exercise="reusable"
def reusable(into, onward, allowed, p_reuse):
    """The vertex that takes the place of an anchor.

    into: (V,) array, RE from the anchor before to each vertex.
    onward: (V,) array, RE from each vertex to the anchor after.
    allowed: (V,) Boolean array, which vertices may be taken. V may be 0.
    p_reuse: into and onward must both be greater than this, 0 to 1.
    Returns the index (a whole number) of the vertex with the greatest into *
    onward of those that qualify, or -1 if there is none.
    """
    ### BEGIN SOLUTION
    fits = (into > p_reuse) & (onward > p_reuse) & allowed
    if not fits.any():
        return -1
    return (into * onward * fits).argmax()
    ### END SOLUTION


# %%
reusable = check_reusable.use(reusable)

# %% [markdown]
# ### Never backwards
#
# What is `allowed`? Consider a trajectory that follows an older one along a corridor. Anchor 5 is replaced by vertex 9 of the older one. For anchor 6 vertex 9 qualifies once more, since it is still close enough to both neighbours. Or even vertex 8 does, since the car may go back a little (section 2). The new trajectory would stand still or go backwards in the map, although the car drove forwards.
#
# So of each trajectory that was already reused only vertices **ahead** of all reused ones may be taken; of trajectories of which nothing was reused, all may. The map stores for each vertex the `trajectory` that it was made for, and its `place` there: 0, 1, 2 and so on.
#
# ### Exercise 3 · `ahead_of` (easy, 7 minutes)
#
# <details><summary>Hint 1: concept</summary>At first all are allowed. Each vertex that was reused excludes some: those of its own trajectory that are not ahead of it.</details>
# <details><summary>Hint 2: approach</summary>Begin with a Boolean array that is True for every vertex. In a loop over reused, allow with &= only those that are of another trajectory, or (|) whose place is greater.</details>
# <details><summary>Hint 3: one line</summary>books &= (author != author[mine]) | (year > year[mine]) leaves out what my author wrote until then. In a loop, mine is each of several books.</details>


# %% exercise="ahead_of"
def ahead_of(trajectory, place, reused):
    """Which vertices may be reused after others.

    trajectory: (V,) array, the index of the trajectory that each vertex was
    made for.
    place: (V,) array, its place along that trajectory: 0, 1, 2 and so on.
    reused: a list of the indices (0 to V - 1) of the vertices reused so far;
    it may be empty.
    Returns a (V,) Boolean array, True where a vertex may be taken.
    """
    ### BEGIN SOLUTION
    allowed = np.ones(len(place), dtype=bool)
    for vertex in reused:
        allowed &= (trajectory != trajectory[vertex]) | (place > place[vertex])
    return allowed
    ### END SOLUTION


# %%
ahead_of = check_ahead_of.use(ahead_of)

# %% [markdown]
# ### The whole insertion
#
# Now put the pieces together. A `SmallMap` (its class is in [`small_map.py`](../tutorial_lib/checks/nb05/small_map.py)) names each vertex by the index of its anchor, since one table `reach` holds $\mathcal{RE}$ of all anchors of this building. It consists of
#
# | | |
# |---|---|
# | `vertices` | a list of the anchors that are vertices |
# | `paths` | a list: for each trajectory the list of vertices that it leads over |
# | `reach` | (N, N), the table; only to look into |
# | `edge_reach` | (N, N), $\mathcal{RE}$ of the pairs that may be edges; 0 elsewhere |
# | `driven` | (N, N), True where a trajectory goes from vertex to vertex |
# | `trajectory`, `place` | (N,), for which trajectory a vertex was made, and its place there; -1 for anchors that are no vertices |
# | `before`, `after` | (N,), the vertex next to a vertex along its own trajectory; -1 for none |
#
# ### Exercise 4 · `insert` (large, 35 minutes)
#
# `own` holds the anchors of the new trajectory, in order. Four steps:
#
# 1. **Reuse.** Go through the anchors in order and build the new path, a list with one vertex for each anchor. *Into* is $\mathcal{RE}$ from the vertex that stands on the new path for the anchor before: if that anchor was replaced, the robot stands on its replacement. (For the first anchor take the anchor itself.) *Onward* is $\mathcal{RE}$ to the anchor after, `own[i + 1]`, whatever becomes of it. (For the last one take the anchor itself.) Your `ahead_of` says which vertices are allowed after those that were reused, and your `reusable` chooses. An anchor without a replacement stays on the path itself. Candidates are the vertices that were on the map before this trajectory.
# 2. **Add** each anchor that stays as a vertex, with its `trajectory` (the number of paths until now), its `place` (its index along `own`), and the vertices `before` and `after` it on the new path.
# 3. **Join.** Each new vertex with every other vertex, old or new, in both directions: `edge_reach` is what `scores` has for the pair. (Until section 5 `scores` is `reach`.) Pruning comes later, by your `edge_weights`.
# 4. **Follow.** Each step from vertex to vertex of the new path is `driven`, and its `edge_reach` is at least the `reach` of the step. Append the path to `paths`.
#
# The check looks at the whole map after every insertion: trajectories that pass the same places, part, or turn back.
#
# <details><summary>Hint 1: concept</summary>One loop for step 1, which never looks at edges. When the path is complete you know which anchors stay: those that stand on it themselves. Steps 2 to 4 need nothing else.</details>
# <details><summary>Hint 2: approach</summary>In step 1 two lists grow: the path, and the vertices reused so far. grown.reach[a, grown.vertices] is a row of RE, from a to each vertex; grown.reach[grown.vertices, b] a column. ahead_of(grown.trajectory, grown.place, reused) answers for all N anchors: select the vertices from it. reusable returns a position in grown.vertices, not an anchor. For before and after put a -1 on either end of the path.</details>
# <details><summary>Hint 3: one line</summary>What is min(i + 1, last) at the last anchor? In step 3: does your loop join two new vertices with each other, and in both directions? In step 4: is it the anchors that were driven, or the vertices of the path?</details>


# %% exercise="insert"
def insert(grown, own, scores, p_reuse):
    """Insert a trajectory into a map, which changes.

    grown: a SmallMap, see above. own: (A,) array, the anchors of the
    trajectory in order, A > 1.
    scores: (N, N) array, RE of each pair of anchors as an edge. p_reuse: as
    for reusable.
    Returns nothing: vertices, paths, edge_reach, driven, trajectory, place,
    before and after of grown change; grown.reach, own and scores stay as they
    are.
    """
    ### BEGIN SOLUTION
    path, reused, last = [], [], len(own) - 1
    for i in range(len(own)):
        before, after = path[i - 1] if i else own[0], own[min(i + 1, last)]
        into, onward = grown.reach[before, grown.vertices], grown.reach[grown.vertices, after]
        allowed = ahead_of(grown.trajectory, grown.place, reused)[grown.vertices]
        found = reusable(into, onward, allowed, p_reuse)
        if found < 0:
            path.append(own[i])
        else:
            path.append(grown.vertices[found])
            reused.append(path[i])
    new = [vertex for vertex in path if vertex in own]
    beside = [-1, *path, -1]
    for i, vertex in enumerate(path):
        if vertex in new:
            grown.vertices.append(vertex)
            grown.trajectory[vertex], grown.place[vertex] = len(grown.paths), i
            grown.before[vertex], grown.after[vertex] = beside[i], beside[i + 2]
    for vertex in new:
        for other in set(grown.vertices) - {vertex}:
            grown.edge_reach[vertex, other] = scores[vertex, other]
            grown.edge_reach[other, vertex] = scores[other, vertex]
    for step in pairwise(path):
        grown.driven[step] = True
        grown.edge_reach[step] = max(grown.edge_reach[step], grown.reach[step])
    grown.paths.append(path)
    ### END SOLUTION


# %%
insert = check_insert.use(insert)


# %% hidden=true
# A map of several trajectories, by your functions; `sequence` is for section 5
def scores_of(grown, own, sequence):
    """(N, N) RE as edges between a trajectory and the map: the least one of aligned sequences."""
    if not sequence:
        return grown.reach
    columns = np.concatenate([np.array(grown.vertices, dtype=int), own])
    local = np.full(len(grown.reach) + 1, -1)  # the last one is for -1
    local[columns] = np.arange(len(columns))
    before, after = grown.before.copy(), grown.after.copy()
    before[own[1:]], after[own[:-1]] = own[:-1], own[1:]
    beside, scores = (local[before[columns]], local[after[columns]]), grown.reach.copy()
    back = weakest_aligned(grown.reach[np.ix_(columns, own)].T, *beside, sequence).T
    scores[np.ix_(columns, own)] = back
    out = weakest_aligned(grown.reach[np.ix_(own, columns)], *beside, sequence)
    scores[np.ix_(own, columns)] = out
    return scores


def grow(reach, trajectories, p_reuse, sequence=0, by=None):
    """A map of several trajectories, by your `insert` or another one."""
    grown = SmallMap.empty(reach)
    for own in trajectories:
        (by or insert)(grown, own, scores_of(grown, own, sequence), p_reuse)
    return grown


def weights_of(grown, p_edge):
    """(N, N) weights of a map's edges, by your `edge_weights`."""
    return edge_weights(grown.edge_reach, grown.driven, p_edge)


# %% [markdown]
# ### The paper's Fig. 4, and ours
#
# Two trajectories, as above: all edges, after pruning, after reuse. **Predict:** which of the second one's anchors are replaced, and does the map lose a path by it?

# %% hidden=true
# The three stages of the paper's Fig. 4
panels, titles = [], []
for name, p_edge, p_reuse in (("dense", 0.0, 1.0), ("pruned", 0.99, 1.0), ("reused", 0.99, 0.99)):
    grown = grow(home.reach, [first, second], p_reuse)
    weights = weights_of(grown, p_edge)
    picture = map_picture(half, home, grown.vertices, weights, trajectory_of)
    panels.append(closeup(half, picture, home.poses[both, :2], 0.8))
    titles.append(f"{name}: {len(grown.vertices)} vertices, {np.isfinite(weights).sum()} edges")
figure_4 = load_result("meng_fig4")
rows = [[row["stage"], row["vertices"], row["edges"]] for row in figure_4.rows]
caption = f"two trajectories in another building, stored (seed {figure_4.worlds[0]})"
display(table({"stage": "", "vertices": ",.0f", "edges": ",.0f"}, rows, caption=caption))
show(side_by_side(panels, titles, gap=10))

# %% [markdown]
# (To run it again: `.venv/bin/python -m tutorial_lib experiment meng_fig4`. The paper's figure shows the three stages without counting them.)
#
# <details><summary>What happened to the second trajectory?</summary>
# On the common part its anchors are gone, replaced by the first one's vertices; it has vertices of its own only from where the two part. No path is lost: a robot that could follow the second trajectory still can, by other images. With the vertices many edges disappear, since each pair of duplicates had edges between them and to each other's neighbours.
# </details>
#
# ### Step by step
#
# The first slider steps through the insertion of the second trajectory into the map of the first. In each step one anchor looks for a replacement. Green dots are vertices that qualify; a thick line is the new path so far. The images are the anchor's and that of the vertex that was taken.
#
# **Predict:** what does $p_\text{reuse} = 0.9$ do to the step in which the trajectories part? And 0.998?

# %% hidden=true
# The insertion of the second trajectory, step by step
step_view = PlanView(apartment.scene, 560, 430)
last = len(second) - 1


def insertion(step, p_reuse, p_edge):
    """The map of the first trajectory while the second one is inserted."""
    grown, after = (grow(home.reach, some, p_reuse) for some in ([first], [first, second]))
    path, vertices = np.array(after.paths[-1]), np.array(grown.vertices)
    before, onward = path[step - 1] if step else second[0], second[min(step + 1, last)]
    earlier = [int(v) for v, a in zip(path[:step], second[:step], strict=True) if v != a]
    fits = ahead_of(grown.trajectory, grown.place, earlier)[vertices]
    fits &= (home.reach[before, vertices] > p_reuse) & (home.reach[vertices, onward] > p_reuse)
    candidates, weights = vertices[fits], weights_of(grown, p_edge)
    picture = map_picture(step_view, home, vertices, weights, trajectory_of, 4)
    step_view.points(picture, home.poses[candidates, :2], colours.GOAL, 9)
    for vertex in candidates:
        step_view.arrow(picture, home.poses[vertex], hue(0), 4)
    line = home.poses[path[: step + 1], :2]
    step_view.polyline(picture, line, hue(1), 3)
    for vertex in path[: step + 1][path[: step + 1] == second[: step + 1]]:
        step_view.arrow(picture, home.poses[vertex], hue(1), 5)
    step_view.arrow(picture, home.poses[second[step]], colours.LASER, 7)
    taken = path[step] != second[step]
    shown = views_of(home, [second[step], path[step]] if taken else [second[step]], 270)
    end = " is replaced" if taken else " becomes a vertex"
    caption = (
        f"anchor {step} of {last}: {len(candidates)} vertices qualify above {p_reuse:.3f}; it{end}"
    )
    caption += f"; {np.isfinite(weights).sum()} edges, those above {p_edge:.2f}"
    cut = closeup(step_view, picture, home.poses[both, :2], 0.6)
    return side_by_side([cut, shown], gap=8), caption


sliders(
    insertion,
    {"step": "anchor", "p_reuse": "p_reuse, probability", "p_edge": "p_edge, probability"},
    step=(0, last, 1, 3),
    p_reuse=(0.9, 0.998, 0.002, 0.99),
    p_edge=(0.5, 0.99, 0.01, 0.99),
)

# %% [markdown]
# <details><summary>What do you see?</summary>
# Both trajectories begin alike, and at 0.99 the first few anchors find one or two vertices each that qualify. Where they part, the anchor after is on the new branch, and no old vertex reaches it: reuse ends by itself, shortly before the fork. With a lower threshold it ends later, and the map trusts longer jumps. With one near 1 even near-identical vertices are refused, and the common part is stored twice: the estimator never returns 1.
# </details>
#
# ### Yours and the library's
#
# The library's `TopoMap` takes any object that has `prepare` and `probability`. So we can give it our table in place of the network: the "images" are indices of anchors, and RE is looked up. Then both maps must be the same, vertex by vertex and edge by edge.


# %% hidden=true
# The library's map from our table, and what it has in common with yours
class Table:
    """RE from a table; observations and targets are indices of anchors."""

    def __init__(self, reach):
        self.reach = reach

    def prepare(self, targets):
        """Nothing is to be prepared."""
        return targets

    def probability(self, observations, prepared):
        """(N,) from the table."""
        return self.reach[observations, prepared]


def library_map(reach, trajectories, **settings):
    """The library's map, and the record of each insertion."""
    # Evaluate all pairs, forget nothing, and reuse vertices alone.
    usual = {"p_reuse": 0.99, "p_between": 1.0, "candidates": 10**6, "p_outdated": 0.0}
    estimator = Table(reach) if isinstance(reach, np.ndarray) else reach
    topomap = TopoMap(estimator, MapSettings(**{**usual, **settings}))
    added = [
        add_trajectory(topomap, Anchors(own, own, np.arange(len(own)) + 1000.0 * index))
        for index, own in enumerate(trajectories)
    ]
    return topomap, added


def edges_of(topomap):
    """Edges of a map from a table, as pairs of anchors."""
    names = topomap.vertices.contexts[np.arange(len(topomap.vertices))]
    return {(int(names[i]), int(names[j])) for i, j in topomap.graph.edges if i != j}


def compare(sequence):
    """Count what a small map and the library's have in common."""
    grown = grow(home.reach, home.trajectories, 0.99, sequence)
    topomap, _ = library_map(home.reach, home.trajectories, sequence=sequence)
    mine, theirs = (
        set(map(tuple, np.argwhere(np.isfinite(weights_of(grown, 0.99))))),
        edges_of(topomap),
    )
    sizes = f"{len(grown.vertices)} and {len(topomap)} vertices"
    print(f"sequence {sequence}: {sizes}; {len(mine & theirs)} edges in both, ", end="")
    print(f"{len(mine - theirs)} only in yours, {len(theirs - mine)} only in the library's")


compare(sequence=0)

# %% [markdown]
# ### Find the bug
#
# A colleague has written an `insert` of her own. Nothing crashes, every step of her trajectories has an RE of 0.95 or more, and all paths of her map can be driven. Only: "Reuse does not help much." Step 1 of hers chooses by the two arrays that `through` returns; the rest is the library's. Here is her `through`, and her map beside yours. What is wrong?


# %%
def through(grown, own, path, i):
    """The colleague's RE into the vertices and onward from them, for anchor i."""
    before, after = path[i - 1] if i else own[0], own[min(i + 1, len(own) - 1)]
    return grown.reach[before, grown.vertices], grown.reach[after, grown.vertices]


# %% hidden=true
# Her map beside yours
hers = partial(check_insert.reference, through=through)
rows = []
for name, by in (("yours", insert), ("hers", hers)):
    grown = grow(home.reach, home.trajectories, 0.99, by=by)
    replaced = count - len(grown.vertices)
    rows.append([name, len(grown.vertices), replaced, home.reach[grown.driven].min()])
head = {"map": "", "vertices": "d", f"of {count} anchors replaced": "d", "least RE driven": ".3f"}
table(head, rows)

# %% [markdown]
# <details><summary>Answer</summary>
# <code>reach[after, vertices]</code> is the RE from the anchor after <i>to</i> the vertex: the reverse direction. From ahead of a vertex a car seldom gets back to it, and so few vertices qualify: those so close to the next anchor that both directions are reachable. The map is larger than necessary. One number reveals it: with $p_\text{sparsify} = p_\text{reuse} = 0.99$ every driven step of your map has 0.99 (a step between two neighbouring frames could have less, since the next frame is kept whatever RE predicts; here none has), and one of hers has 0.96, since the step from the vertex onward was never checked. In a table of RE the row is always where the robot stands.
# </details>
#
# ## 4 · The map of a building
#
# All twelve trajectories. A map offers more than the twelve paths that it was shown. How many more? Each trajectory has a start and an end; from each start to each end at another place there could be a path: 108 in all. The graph says which exist.
#
# **Predict:** how many of the 108 does a map contain that only knows the driven edges, before anything is joined? How many after joining, and how many after reuse?


# %% hidden=true
# Which of the 108 paths a map contains
def path_probabilities(grown, p_edge, building):
    """Probabilities of the best paths from trajectories' starts to ends elsewhere, 0 for none."""
    graph, found = graph_of(weights_of(grown, p_edge), grown.vertices), []
    for (place, _), path in zip(building.pairs, grown.paths, strict=True):
        far = nx.single_source_dijkstra_path_length(graph, int(path[0]))
        for (_, goal), other in zip(building.pairs, grown.paths, strict=True):
            if goal != place:
                found.append(np.exp(-far.get(int(other[-1]), np.inf)))
    return np.array(found)


rows = []
for name, p_edge, p_reuse in (
    ("driven steps only", 1.0, 1.0),
    ("all pairs, none pruned", 0.0, 1.0),
    ("pruned", 0.99, 1.0),
    ("pruned, with reuse", 0.99, 0.99),
    ("driven, with reuse", 1.0, 0.99),
):
    grown = grow(home.reach, home.trajectories, p_reuse)
    found = path_probabilities(grown, p_edge, apartment)
    edges, there = np.isfinite(weights_of(grown, p_edge)).sum(), found > 0
    rows.append([name, len(grown.vertices), edges, there.sum(), np.median(found[there])])
paths_head = f"paths, of {len(found)}"
head = {"map": "", "vertices": "d", "edges": ",d", paths_head: "d", "median probability": ".2f"}
table(head, rows, {paths_head: max, "vertices": min, "edges": min})

# %% [markdown]
# <details><summary>What does the map know that it was never shown?</summary>
# Driven edges alone contain the twelve trajectories. With edges between them a robot may begin on one trajectory and end on another, and all 108 paths exist, though most of them were never driven as a whole. Reuse merges the trajectories: it nearly halves the vertices, keeps a fraction of the edges, and has the same paths; 96 of them are left even if only driven steps are edges. The dense graph has them too, at an edge count that grows with the square of the anchors. (The paper finds the same in IV-C.3: trajectories are combined to solve new tasks.)
# </details>
#
# <details><summary>A robot has arrived at A. Why can it not continue to B on this map?</summary>
# It can from A's <i>starts</i>, which face out of the room. But a trajectory that ends at A ends facing into the room, and none begins there with that heading: no trajectory shows how to turn round. That is why paths are counted from starts to ends, and only between different places. A map cannot contain what was never driven; one trajectory that turns round in each room would be enough.
# </details>
#
# Here is the map, each trajectory's vertices in its colour: the twin of the paper's Fig. 8. With the sliders, **predict** first: which of the two thresholds changes the number of vertices, and what happens to the paths at $p_\text{edge} = 0.999$?

# %% hidden=true
# The map at two thresholds
map_view = PlanView(apartment.scene, 620, 460)


kept_maps = {}


def whole_map(p_edge, p_reuse):
    """The map of all twelve trajectories at two thresholds; each is built once."""
    if p_reuse not in kept_maps:
        kept_maps[p_reuse] = grow(home.reach, home.trajectories, p_reuse)
    grown = kept_maps[p_reuse]
    weights = weights_of(grown, p_edge)
    picture = map_picture(map_view, home, grown.vertices, weights, trajectory_of, 4.5)
    found = path_probabilities(grown, p_edge, apartment)
    size = f"{len(grown.vertices)} vertices, {np.isfinite(weights).sum()} edges; "
    return picture, f"{size}{(found > 0).sum()} of {len(found)} paths"


sliders(
    whole_map,
    {"p_edge": "p_edge, probability", "p_reuse": "p_reuse, probability"},
    p_edge=(0.8, 0.999, 0.001, 0.99),
    p_reuse=(0.8, 1.0, 0.01, 0.99),
)

# %% [markdown]
# <details><summary>What do they do?</summary>
# Only p_reuse changes the vertices. p_edge controls the short cuts between trajectories: at 0.999 none is left, since the estimator never returns as much (section 2), and only the driven steps remain. Thanks to reuse even those contain 96 of the 108 paths; at p_reuse = 1 they contain twelve. At 0.8 long edges appear, and some lead through walls. The next section is about those.
# </details>
#
# ### Turning where drives meet
#
# With a trajectory for every pair of places that hardly matters: one of them leads from A to B. After a *tour*, each place to the next and back, it does. To get from A to C a car comes to B by one trajectory, and should leave by another, which passed here looking the other way; the two images have nothing in common, and no $\mathcal{RE}$ joins them. The paper's ninety trajectories never ask for it.
#
# But the car has a laser that sees all around. Where its scan, turned by some angle, lies on the scan of a vertex, and the walls had the same colours on both trajectories, the places are the same. The library's agent then adds a **[[turn edge]]** each way (ours; the paper has none), with a fixed probability of 0.95, and the angle by which to turn; a robot drives it as a three-point turn. (Scans alone are not enough: two offices have the same walls. See [`turn_edges.py`](../tutorial_lib/topology/mapping/turn_edges.py). The map that you build here has none.)
#
# <details><summary>Why may the laser find such places, but not all others?</summary>
# It could, in a building whose rooms differ in shape. But a scan knows no posters and no stripes: rooms of the same shape would all be one. And that two places are 3 m apart does not say that a car gets from the one to the other. RE answers just that question. A turn where one stands is the one case in which being there is enough.
# </details>
#
# ## 5 · Places that look alike
#
# A **[[wormhole]]** is an edge between places that are far apart: more than 5 m on the shortest path. $\mathcal{RE}$ compares images, and two corners of an office may give the same image: **[[perceptual aliasing]]**. On a map a wrong edge is worse than a missing one. A planner *prefers* wormholes, since they are the best short cuts, and a single one can spoil all paths.
#
# Below is an office with symmetric corridors, three places and six trajectories. The pair shown is the wormhole whose images are most alike. **Predict:** what share of the edges are wormholes? (About 6 s.)


# %% hidden=true
# An office with symmetric corridors, and its most convincing wormhole
def building_of(name, count, seed=0):
    """A building like those of the experiments, for a world by its name."""
    scene = scene_of(name)
    paths = GridPaths(scene.clearance)
    places = spread_places(paths, count, np.random.default_rng(seed))
    pairs = np.array(list(permutations(range(count), 2)))
    starts = facing(scene, paths, places, pairs)
    driven = demonstrate_between(name, scene, paths, starts, places[pairs[:, 1]], seed)
    kept = [index for index, rollout in enumerate(driven) if rollout is not None]
    recorded = RecordedWorld(scene, [driven[index] for index in kept])
    return Building(name, scene, paths, places, recorded, pairs[kept])


def lengths_of(data, weights):
    """Edges (E, 2), and the geodesic length of each, m."""
    edges = np.argwhere(np.isfinite(weights))
    ends = data.poses[edges, :2]
    return edges, data.building.paths.between(ends[:, 0], ends[:, 1])


office = query_all_pairs(building_of(world_name("symmetric_office", 10_004), 3))
office_view = PlanView(office.building.scene, 900, 600)
office_grown = grow(office.reach, office.trajectories, p_reuse=1.0)
edges, far = lengths_of(office, weights_of(office_grown, 0.99))
images = np.concatenate([anchors.observations.image for anchors in office.anchors]).astype(float)
differ = np.abs(images[edges[:, 0]] - images[edges[:, 1]]).mean(axis=(1, 2, 3))
chosen = np.where(far > WORMHOLE, differ, np.inf).argmin()
(source, target), probability = edges[chosen], office.reach[tuple(edges[chosen])]
print(f"{len(office.reach)} anchors, {len(edges)} edges, {(far > WORMHOLE).sum()} wormholes")
title = f"RE = {probability:.3f}, and {far[chosen]:.0f} m from blue to green"
show(stacked([edge_picture(office_view, office, source, target)], [title]))

# %% [markdown]
# ### One place may look like another; a whole sequence hardly does
#
# Two corridors may share one image. That the images *before* and the images *after* agree, too, is much less likely. So match a sequence (paper, III-G): anchor $i$ may be joined with vertex $v$ only if the anchors around $i$ can also be joined with the vertices around $v$,
#
# $$ \mathcal{RE}_\text{seq}(\hat o_i, v) \;=\; \min_{-2 \le s \le 2} \; \mathcal{RE}(\hat o_{i+s},\, v_{+s}), $$
#
# where $v_{+s}$ is the vertex $s$ steps after $v$ along $v$'s own trajectory. (The paper says to match sequences, and leaves open how. The minimum of five is that of its authors' code.) Where a trajectory ends, the sequence is shorter. Here are five pairs of the wormhole above:

# %% hidden=true
# The pairs around the wormhole
around_source = [source + s for s in range(-2, 3)]
around_target = [target + s for s in range(-2, 3)]
same = [
    (a, v)
    for a, v in zip(around_source, around_target, strict=True)
    if {a, v} <= set(range(len(office.reach)))
    and any({a, source} <= set(trajectory) for trajectory in office.trajectories)
    and any({v, target} <= set(trajectory) for trajectory in office.trajectories)
]
values = [office.reach[pair] for pair in same]
show(aligned_sequences([str(a) for a, _ in same], [str(v) for _, v in same], values))

# %% [markdown]
# The pair in the middle is sure, but the images before and after it fit less and less: the minimum of the five is 0.20, far below $p_\text{edge} = 0.99$.
#
# ### Exercise 5 · `weakest_aligned` (hard, 15 minutes)
#
# Rows are the anchors of a new trajectory, in order. Columns are vertices, in arbitrary order: `before[v]` and `after[v]` are the columns next to column `v` on its trajectory, and -1 where there is none. A sequence ends, on its side, as soon as there is no next anchor or no next vertex. **Beware:** to numpy, -1 is the last one.
#
# <details><summary>Hint 1: concept</summary>For one pair (i, v): put one finger on row i and one on column v. Move both ahead together, up to <code>steps</code> times, as long as there is a next one for both, and keep the least RE that you see. Then the same backwards.</details>
# <details><summary>Hint 2: approach</summary>Three loops: over all pairs, over the two directions ((-1, before), (1, after)), and over the steps. In the innermost move both fingers; break if the row is above or below the table, or the column is -1; otherwise take the minimum.</details>
# <details><summary>Hint 3: one line</summary>Do you compare with reach, which stays as it was, or with values that have been lowered already? Do both fingers start again from the pair itself for the second direction?</details>


# %% exercise="weakest_aligned"
def weakest_aligned(reach, before, after, steps):
    """The least RE over aligned sequences around each pair.

    reach: (A, V) array, RE from each anchor of a trajectory, in order, to each
    vertex.
    before, after: (V,) arrays, the vertex next to each on its own trajectory,
    -1 for none.
    steps: how many anchors count on either side, 0 or more.
    Returns a new (A, V) array: the least RE of the pair itself and of the
    aligned pairs around it.
    """
    ### BEGIN SOLUTION
    least = reach.copy()
    for i, v in np.ndindex(*reach.shape):
        for direction, beside in ((-1, before), (1, after)):
            row, column = i, v
            for _ in range(steps):
                row, column = row + direction, beside[column]
                if not 0 <= row < len(reach) or column < 0:
                    break
                least[i, v] = min(least[i, v], reach[row, column])
    return least
    ### END SOLUTION


# %%
weakest_aligned = check_weakest_aligned.use(weakest_aligned)

# %% [markdown]
# From here on `sequence` is active in your map builder. Both buildings, with sequences of 0, 1 and 2 anchors on either side, without reuse. **Predict:** how many wormholes are left, and what does it cost? (About 5 s.)

# %% hidden=true
# Wormholes and good edges by the length of sequences
rows, progress = [], tqdm(total=6, desc="maps", leave=False)
for name, data in (("apartment", home), ("symmetric office", office)):
    by_sequence = []
    for sequence in (0, 1, 2):
        by_sequence.append(grow(data.reach, data.trajectories, 1.0, sequence))
        progress.update()
    for p_edge in (0.9, 0.99):
        far = [lengths_of(data, weights_of(grown, p_edge))[1] for grown in by_sequence]
        good = [(metres <= WORMHOLE).sum() for metres in far]
        for sequence, metres in enumerate(far):
            holes, share = (metres > WORMHOLE).sum(), good[sequence] / good[0]
            rows.append([name, p_edge, sequence, holes, share])
progress.close()
head = {"building": "", "p_edge": ".2f", "anchors on either side": "d", "wormholes": "d"}
display(table({**head, "good edges kept": ".0%"}, rows))
compare(sequence=2)

# %% [markdown]
# <details><summary>What do sequences cost?</summary>
# Good edges. Near a fork the anchors before agree and those after do not; and where two trajectories space their anchors differently, aligned sequences drift apart. The longer the sequence, the more true edges are lost. That is a good bargain, since good edges are many and redundant, while a single wormhole does harm. The apartment has hardly any wormholes at 0.99: its rooms have different colours. It is the symmetric office that needs sequences, and at a low threshold both do.
# </details>
#
# Now the same with reuse. **Predict:** does reuse add wormholes, or take some away?

# %% hidden=true
# The office's map with sequences and reuse
office_grown = grow(office.reach, office.trajectories, 0.99, sequence=2)
edges, far = lengths_of(office, weights_of(office_grown, 0.99))
along = office_grown.driven[tuple(edges.T)]
print(f"{len(office_grown.vertices)} vertices, {len(edges)} edges")
print(
    f"{(far > WORMHOLE).sum()} wormholes, {(far[along] > WORMHOLE).sum()} of them on driven steps"
)
swapped = [
    (int(anchor), int(vertex))
    for own, path in zip(office.trajectories, office_grown.paths, strict=True)
    for anchor, vertex in zip(own, path, strict=True)
    if anchor != vertex
]
apart = office.building.paths.between(*office.poses[np.array(swapped).T, :2])
print(f"{len(swapped)} anchors replaced, {(apart > WORMHOLE).sum()} by a vertex more than 5 m away")

# %% [markdown]
# <details><summary>Why does a car "drive" through a wormhole?</summary>
# It did not. (Without reuse one was left, a long step that was driven; with reuse there are five.) Reuse replaced an anchor by a vertex far away, which according to RE can be reached from the anchor before and reaches the anchor after; and then the trajectory's own links lead there and back. Sequences do not help, because the rule of reuse checks only two values of RE, and driven edges are never pruned. This is a weak spot of the method, and of our library, which follows it. How a robot copes with such a map (it notices, and replans) is the topic of notebook 06.
# </details>
#
# ## 6 · Not all pairs
#
# Inserting a trajectory of $A$ anchors into a map of $V$ vertices gives $2AV$ pairs to evaluate, and the next trajectory finds a larger map: in all, the queries grow with the **square** of the map. But nearly all answers are no. The paper asks about every pair (III-E); two ideas of ours save most of them:
#
# 1. **Retrieval.** $\mathcal{RE}$ runs a network on each *pair*. An embedding is computed from each image *alone*, once, and comparing two of them is a dot product. So evaluate only the 12 vertices that are most similar.
# 2. **Search along trajectories.** Where one pair is sure, its neighbours are worth a query, too: the next anchor and the vertex after, the anchor before and the vertex before, and for the same anchor the vertices next to this one. From these again the neighbours, and so on, until nothing new is sure.
#
# ### Exercise 6 · `ask_next` (medium, 10 minutes)
#
# `reach` holds what is known; `np.nan` marks pairs that were not evaluated yet. Comparisons with it are False, and `np.isnan` finds it. The four neighbours of a pair (i, v) are (i + 1, after[v]), (i - 1, before[v]), (i, after[v]) and (i, before[v]); those beyond an end do not exist.
#
# <details><summary>Hint 1: concept</summary>Go through the pairs that are sure. Each one votes for its four neighbours. Known pairs need no vote.</details>
# <details><summary>Hint 2: approach</summary>np.argwhere(table > 0) goes through the places of a table that are positive. Mark the four neighbours of each sure pair in a table of False, if there is such a row and the column is not -1.</details>
# <details><summary>Hint 3: one line</summary>Your table of votes may contain pairs that are known already. Which Boolean table do you combine it with, by & or by |?</details>


# %% exercise="ask_next"
def ask_next(reach, before, after, p_edge):
    """Which pairs are worth a query, after some answers.

    reach: (A, V) array, RE from each anchor of a trajectory, in order, to each
    vertex; np.nan where it was not evaluated. before, after: (V,) arrays, as
    for weakest_aligned.
    p_edge: a pair whose RE is greater is sure.
    Returns an (A, V) Boolean array, True where to query next: not evaluated
    yet, and one of the four neighbours of a sure pair.
    """
    ### BEGIN SOLUTION
    found = np.zeros(reach.shape, dtype=bool)
    for i, v in np.argwhere(reach > p_edge):
        for row, column in (
            (i + 1, after[v]),
            (i - 1, before[v]),
            (i, after[v]),
            (i, before[v]),
        ):
            if 0 <= row < len(reach) and column >= 0:
                found[row, column] = True
    return found & np.isnan(reach)
    ### END SOLUTION


# %%
ask_next = check_ask_next.use(ask_next)

# %% [markdown]
# For each of the twelve trajectories: which vertices of the *other eleven* can be reached from its anchors? We begin with the few most similar ones, with your search and without it, and count how many of the pairs above 0.99 were found, and how many queries it took. For comparison, *random* begins with as many vertices drawn at random, and the *oracle* knows the poses and begins with the nearest ones.
#
# **Predict** the order of the four curves.


# %% hidden=true
# How many sure pairs are found by how many queries
def neighbours(trajectories, own):
    """Anchors of all trajectories but one, and the columns before and after each of them."""
    others = [trajectory for trajectory in trajectories if trajectory is not own]
    columns = np.concatenate(others)
    local = np.full(count + 1, -1)
    local[columns] = np.arange(len(columns))
    before, after = np.full((2, count), -1)
    for trajectory in others:
        before[trajectory[1:]], after[trajectory[:-1]] = trajectory[:-1], trajectory[1:]
    return columns, local[before[columns]], local[after[columns]]


def found_by(own, similarity, starts, search):
    """Pairs queried, sure pairs among them, sure pairs in all, and all pairs."""
    columns, before, after = neighbours(home.trajectories, own)
    reach, similarity = home.reach[np.ix_(own, columns)], similarity[np.ix_(own, columns)]
    fresh, known = np.zeros(reach.shape, dtype=bool), np.full(reach.shape, np.nan)
    fresh[np.arange(len(own))[:, None], most_alike(similarity, starts)] = True
    while fresh.any():
        known[fresh] = reach[fresh]
        fresh = ask_next(known, before, after, 0.99) & search
    return (~np.isnan(known)).sum(), (known > 0.99).sum(), (reach > 0.99).sum(), reach.size


similarity = likeness(home.seen, home.shown)
random_scores = np.random.default_rng(0).random(similarity.shape)
proximity = -np.linalg.norm(home.poses[:, None] - home.poses, axis=2)  # metres and radians alike
figure, (axis,) = chart(8.0, 4.0)
for name, scores, search, tone in (
    ("oracle, search", proximity, True, colours.FAINT),
    ("similar, search", similarity, True, colours.ROBOT),
    ("similar alone", similarity, False, colours.TRACK),
    ("random, search", random_scores, True, colours.PERSON),
):
    points = []
    for starts in (1, 2, 4, 8, 12, 20, 40):
        totals = sum(np.array(found_by(own, scores, starts, search)) for own in home.trajectories)
        points.append((totals[0] / totals[3], totals[1] / totals[2]))
        if starts == 12:
            print(f"{name:15s} 12 each: {points[-1][0]:5.1%} of the queries", end="")
            print(f" find {points[-1][1]:4.0%} of the sure pairs")
    axis.plot(*np.array(points).T, "o-", markersize=5, color=colours.unit(tone), label=name)
axis.set(xlabel="share of all pairs queried", ylabel="share of sure pairs found", xlim=(0, 0.4))
axis.legend(loc="lower right")
show(from_figure(figure))

# %% [markdown]
# <details><summary>What does each idea contribute?</summary>
# Similarity finds the right neighbourhood with a handful of queries; the search then walks along both trajectories and collects the rest of it. Random starts show that the search alone helps as well, as soon as one of them hits, but they waste the queries that do not. The oracle is no better than the embedding where images are alike because places are.
# </details>
#
# The share is this large only because the map is small: the 12 most similar vertices are a tenth of it. What counts is the *number* of queries, since it hardly grows with the map. Here are the library's queries per trajectory: with the table, once for all pairs and once by embeddings, which the table has, too.


# %% hidden=true
# Queries for each trajectory, for all pairs and by retrieval
class EmbeddingTable(Table):
    """A table with embeddings of the anchors."""

    def embed(self, observations):
        """(N, R, D) embeddings of anchors as observations."""
        return home.seen[observations]

    def embed_targets(self, prepared):
        """(N, P, R, D) embeddings of anchors as targets."""
        return home.shown[prepared]


exhaustive, all_added = library_map(home.reach, home.trajectories)
indexed, added = library_map(EmbeddingTable(home.reach), home.trajectories, candidates=12)
rows = [
    [name, *(one.queries for one in some)]
    for name, some in (("all pairs", all_added), ("by retrieval", added))
]
head = {"queries, trajectory": "", **{str(index): "d" for index in range(len(added))}}
display(table(head, rows))
all_edges, indexed_edges = edges_of(exhaustive), edges_of(indexed)
print(f"all pairs: {len(exhaustive)} vertices, {len(all_edges)} edges; ", end="")
print(f"by retrieval: {len(indexed)} vertices, {len(indexed_edges)} edges", end="")
print(f", {len(indexed_edges & all_edges)} of them the same")

# %% [markdown]
# And on a large map, where it matters (`.venv/bin/python -m tutorial_lib bench map`):

# %% hidden=true
# The stored run of `bench map`
bench = load_result("map")
head = {"map": "", "method": "", "vertices": ",d", "trajectories": ",d", "queries": ",d"}
head |= {"": "", "s each": ".2f", "edges found": ".1%", "ms to plan": ".0f"}
rows = []
for row in bench.rows:
    total = "each" if row["map"].startswith("many") else "in all"
    method = "by retrieval" if row["method"] == "indexed" else "all pairs"
    parts = [row["map"], method, row["vertices"], row["trajectories"], row["queries"], total]
    rows.append([*parts, row["seconds_per_trajectory"], row["recall"], row["plan_ms"]])
display(table(head, rows))
print("\n".join(bench.notes))

# %% [markdown]
# <details><summary>What does the table say?</summary>
# The first two parts build the map of one building by either method; "edges found" is the share of the edges that all pairs give which retrieval finds, too: each trajectory is compared with the same map both ways, and the edges that were driven do not count. Without reuse retrieval evaluates 5 % of the pairs and misses one edge in 500. With reuse it saves less (15 %), since the map is small: the 12 vertices to begin with are 8 % of 152, and the search comes on top. In the last part a map grows without reuse over one building after the other: nearly seventyfold. The queries for all pairs grow two hundredfold, those by retrieval twofold. (At each size other trajectories are timed, hence the jumps.) "ms to plan" is one plan from an image to an image, including its queries to the network (notebook 06).
# </details>
#
# ## 7 · How maps grow
#
# Anchors of a place that is already on the map are replaced. So a robot that keeps driving in the same building adds less and less: "the size of the graph converges" (III-E). **Predict:** draw the number of vertices against the number of frames, for the twelve trajectories, with reuse and without it. How straight is either?

# %% hidden=true
# Vertices against frames, in six orders of the trajectories
rng = np.random.default_rng(0)
orders = [rng.permutation(len(home.trajectories)) for _ in range(6)]
figure, (axis,) = chart(7.0, 3.6)
for name, p_reuse, tone in (("no reuse", 1.0, colours.FAINT), ("reuse", 0.99, colours.ROBOT)):
    for order in orders:
        grown, sizes = SmallMap.empty(home.reach), [0]
        for index in order:
            insert(grown, home.trajectories[index], home.reach, p_reuse)
            sizes.append(len(grown.vertices))
        taken = np.cumsum([0, *np.array(frames)[order]])
        label = name if order is orders[0] else None
        axis.plot(taken, sizes, color=colours.unit(tone), linewidth=1.4, label=label)
axis.set(xlabel="frames", ylabel="vertices", xlim=(0, None), ylim=(0, None))
axis.legend()
show(from_figure(figure))

# %% [markdown]
# (A line for each of six orders of the trajectories.) Most of the twelve trajectories still find something new. The paper's Fig. 13 goes on to tens of thousands of images; so does this one, in unseen buildings. Dotted and dashed: every 10th and every 20th frame, as SPTM would keep them.
#
# **The paper's Fig. 13, and ours.** The paper's maps end with 900 to 1,454 vertices and 1,348 to 2,275 edges, from 28,679 to 39,788 images (Table II).

# %% hidden=true
# The twin of Fig. 13, from a stored run
growth = load_result("meng_fig13")
figure, (axis,) = chart(8.0, 4.4)
worlds = list(dict.fromkeys(row["world"] for row in growth.rows))
for index, world in enumerate(worlds):
    rows = sorted((r for r in growth.rows if r["world"] == world), key=lambda r: r["frames"])
    taken = [0, *(row["frames"] for row in rows)]
    sizes = [0, *(row["vertices"] for row in rows)]
    axis.plot(taken, sizes, color=colours.unit(hue(index)), label=str(world))
rows = sorted((r for r in growth.rows if r["world"] == worlds[0]), key=lambda r: r["frames"])
for key, name, dots in (("every_10th", "every 10th", ":"), ("every_20th", "every 20th", "--")):
    line = [0, *(row["frames"] for row in rows)], [0, *(row[key] for row in rows)]
    axis.plot(*line, dots, color=colours.unit(colours.INK), label=name)
most = max(row["vertices"] for row in growth.rows)
axis.set(xlabel="frames", ylabel="vertices", xlim=(0, None), ylim=(0, 2.5 * most))
axis.legend(fontsize=10, ncols=2)
rows = []
for world in worlds:
    end = max((r for r in growth.rows if r["world"] == world), key=lambda r: r["frames"])
    rows.append([str(world), *(end[key] for key in ("frames", "vertices", "edges"))])
head = {"world": "", "frames": ",d", "vertices": ",d", "edges": ",d"}
display(table(head, rows, caption="at the end"))
print("\n".join(growth.notes))
show(from_figure(figure))

# %% [markdown]
# (To run it again: `.venv/bin/python -m tutorial_lib experiment meng_fig13`. **Same protocol, easier world.**)
#
# <details><summary>Why do our numbers differ from the paper's?</summary>
# Our cars follow a planner along the same few hundred paths, so they soon have seen everything there is; the paper's buildings are scans of real ones. In the one with the most rendering artefacts "denser samples are kept to stay conservative" (IV-C.5). The shape is the same: steep, then flat. Sub-sampling has no such bend: it does not know what it has seen already.
# </details>
# <details><summary>Why do the maps not stop growing altogether?</summary>
# Anchors are as far apart as the sparsification allows. A replacement must be reachable from the anchor before <i>and</i> reach the anchor after, and has hardly any slack: some decimetres ahead or back, and one of the two is a little too far. In one building that we examined, half of the vertices added late were less than 0.3 m from an older one, with the same heading, whose RE was just below p_reuse.
#
# The library therefore lets an <b>edge</b> replace an anchor where no vertex does (the paper does not). The anchor lies on an edge from $v$ to $w$ if $\mathcal{RE}$ from $v$ to the anchor, and from the anchor to $w$, are both above p_between; then the trajectory goes from the anchor before over $v$ and $w$ to the anchor after, and each step of it must be above p_reuse. Two vertices have slack: one of them is near, whatever the spacing. A lower p_reuse makes maps smaller, too, but then places merge that only look alike: on validation worlds all goals were reached with 0.94, and 92 % with 0.8. (<code>experiment meng_fig13 --ablation reuse</code> compares the rules, with the success on each map.)
# </details>
#
# ## 8 · How it fails
#
# Back to the apartment's map, with sequences. Three kinds of defects, counted on it and on the office's map:
#
# - **wormholes**, edges of more than 5 m;
# - **distant replacements**: anchors replaced by a vertex more than 1 m away, or turned by more than 30°;
# - **duplicates**: vertices less than 0.6 m apart and turned by less than 20°, which reuse should have merged.
#
# **Predict** which of them is the most frequent. (In the figures below, blue is the anchor that was dropped, or the source of an edge, and green its replacement, or the target of the edge.)


# %% hidden=true
# Count the defects
def faults(data, grown):
    """Defects of a map: pairs of anchors by kind, the worst first."""
    weights = weights_of(grown, 0.99)
    edges, far = lengths_of(data, weights)
    found = {"wormhole": sorted(zip(-far, *edges.T, strict=True))}
    found["wormhole"] = [(i, j) for f, i, j in found["wormhole"] if -f > WORMHOLE]
    swaps = []
    for own, path in zip(data.trajectories, grown.paths, strict=True):
        for anchor, vertex in zip(own, path, strict=True):
            off = np.linalg.norm(data.poses[anchor, :2] - data.poses[vertex, :2])
            turned = abs(np.rad2deg(wrap(data.poses[anchor, 2] - data.poses[vertex, 2])))
            if off > 1.0 or turned > 30.0:
                swaps.append((-off, int(anchor), int(vertex)))
    found["distant replacement"] = [pair for _, *pair in sorted(swaps)]
    poses, vertices = data.poses[grown.vertices], grown.vertices
    close = np.linalg.norm(poses[:, None, :2] - poses[:, :2], axis=2) < 0.6
    close &= np.abs(wrap(poses[:, None, 2] - poses[:, 2])) < np.deg2rad(20.0)
    duplicates = [(vertices[i], vertices[j]) for i, j in np.argwhere(close) if i < j]
    found["duplicate"] = sorted(duplicates, key=lambda pair: data.reach[pair])
    return found


maps = {
    "apartment": (home, grow(home.reach, home.trajectories, 0.99, sequence=2)),
    "symmetric office": (office, office_grown),
}
counted = {name: faults(*parts) for name, parts in maps.items()}
rows = [[kind, *(len(found[kind]) for found in counted.values())] for kind in counted["apartment"]]
table({"defect": "", **dict.fromkeys(counted, "d")}, rows)

# %% hidden=true
# The worst of each kind
panels, titles = [], []
for name, kind in (
    ("symmetric office", "wormhole"),
    ("symmetric office", "distant replacement"),
    ("apartment", "distant replacement"),
    ("apartment", "duplicate"),
):
    data, found = maps[name][0], counted[name][kind]
    if not found:
        continue
    a, b = map(int, found[0])
    plan = view if data is home else office_view
    panels.append(edge_picture(plan, data, a, b))
    titles.append(f"{name}, {kind}: RE {data.reach[a, b]:.3f}, back {data.reach[b, a]:.3f}")
rows = [side_by_side(panels[i : i + 2], titles[i : i + 2]) for i in range(0, len(panels), 2)]
show(stacked(rows, gap=14))

# %% [markdown]
# <details><summary>What are the causes?</summary>
# <i>Wormholes</i>: two places with the same image, and a rule of reuse that checks no sequence (section 5). <i>Distant replacements</i>: in the office all three have the same cause; those of the apartment are mostly no defect at all. A vertex some metres on does the job of the anchor as well, which is all that the rule requires. It is a defect only if one believes that a vertex is a <i>place</i>. <i>Duplicates</i>: their RE to each other is high, and yet neither replaced the other. Reuse checks from the anchor <i>before</i> to the anchor <i>after</i>, and those lie elsewhere on each
# trajectory: where one of the two RE is only just too low, the duplicate stays. A lower p_reuse removes it, at the price of less certain steps. Some are the last two anchors of one trajectory: the end of a trajectory is always kept.
# </details>
#
# ## 9 · What has changed
#
# A painting is replaced, or a cupboard is moved. From then on no robot gets to the vertex that shows the old view, and a plan over it fails. The paper's advice is to give every observation a timestamp, and to "discard outdated observations using $\mathcal{RE}$" (III-E); it leaves the rest as future work. This is our library's rule: a vertex is outdated if a new trajectory
#
# - reaches, above $p_\text{edge}$, the vertex *before* it and the vertex *after* it on its trajectory, in this order and close together,
# - and on the whole stretch the vertex itself is below $p_\text{outdated} = 0.1$: *surely* not there.
#
# A made-up change: the first trajectory is driven again a week later, and one of its vertices looks different by now. Everything else is as $\mathcal{RE}$ predicts it. **Predict:** which of the vertices are removed, and what takes their place? And what would happen if only the second condition were checked?

# %% hidden=true
# The first trajectory, driven again a week later
length, changed = len(first), 6
twice = np.concatenate([first, first])
week_later = home.reach[np.ix_(twice, twice)].copy()
week_later[length:, changed] = 0.02  # no later view leads to the old one
week_later[changed, length:] = 0.02
passes = [np.arange(length), np.arange(length, 2 * length)]
for p_outdated in (0.0, 0.1):
    aged, (_, again) = library_map(week_later, passes, p_outdated=p_outdated)
    print(f"p_outdated = {p_outdated}: {len(aged)} vertices; removed: {again.outdated.tolist()}")
    print("    the second trajectory is now " + " ".join(map(str, again.path)))
    print("    the first trajectory is now  " + " ".join(map(str, aged.paths[0])))

# %% [markdown]
# <details><summary>What happened?</summary>
# (Indices up to 16 are vertices of the first trajectory, higher ones are new.) The anchor at the changed place, now 17, could not be replaced, and became a vertex of its own; that happens without any forgetting, since reuse fails there by itself. What forgetting adds is that the old vertex is removed, and that no plan leads over it any more. In this example the second condition alone would do the same, since our $\mathcal{RE}$ is seldom as low as 0.1, even far away (around 0.3). With an estimator that returns 0 for everything out of sight, nearly the whole map would be removed. Only a robot that <i>passes</i> the place may say that something is gone. And 0.1 is strict: most vertices that look different by now will stay.
# </details>
# <details><summary>A person stood there once, and is in a vertex's image. Does that do harm?</summary>
# If the person hides much, RE to the vertex is low from then on, and the next trajectory that passes removes it. If the person hides little, RE stays high, and the vertex does its job. What if a person stands in front of the <i>new</i> car? Then it may not see a vertex that is still good, and removes it: one trajectory is a single witness. Therefore the bound is as low as 0.1, and the whole stretch must agree. A careful map would wait for a second witness (extra 4).
# </details>
#
# ## 10 · The complete map, and on disk
#
# So far $\mathcal{RE}$ came from a table. Here is the library's map as a robot builds it: with the network inside, by retrieval, with sequences, reuse and forgetting, at the library's own thresholds. (The paper uses 0.99 for $p_\text{edge}$ and $p_\text{reuse}$, and so did we until now. The library reuses from 0.94 on, and it reuses edges, as section 7 says; `p_reuse=0.99, p_between=1.0` would be the paper's rule, and yours. Together that leaves three quarters of the vertices.) Its insertion is in [`insertion.py`](../tutorial_lib/topology/mapping/insertion.py): compare it with yours. (About 3 s.)

# %% hidden=true
# The library's map, with the network inside
begun = time.perf_counter()
topomap = TopoMap(reachability)
queries = sum(add_trajectory(topomap, anchors).queries for anchors in home.anchors)
seconds = time.perf_counter() - begun
links = sum(i != j for i, j in topomap.graph.edges)
print(topomap.settings)
print(f"{len(topomap)} vertices, {links} edges; {queries} queries, {seconds:.1f} s")
picture = view.base.copy()
draw_topomap(view, picture, topomap, vertex_poses(apartment, topomap), size=5.0)
show(picture)

# %% [markdown]
# A map outlives a robot's battery. It is saved as one `.npz` file, with the observations and the graph. Embeddings and prepared targets are not saved: they belong to a network, and are computed again on loading.

# %% hidden=true
# Save the map, load it, and damage it
with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "apartment.npz"
    save_map(path, topomap)
    kilobytes = path.stat().st_size / 1000
    print(f"{path.name}: {kilobytes:.0f} kB")
    loaded = load_map(path, reachability)
    same = sorted(loaded.graph.edges) == sorted(topomap.graph.edges)
    print(f"{kilobytes / len(topomap):.1f} kB per vertex; loaded with the same edges: {same}")
    path.write_bytes(path.read_bytes()[:1000])
    try:
        load_map(path, reachability)
    except InputError as error:
        print(str(error).replace(folder, "..."))

# %% [markdown]
# <details><summary>May a map be loaded with another estimator?</summary>
# The edges stay as the first one predicted them; all further queries go to the second. So yes, if it takes the same images (the same k and the same camera). But the first one's probabilities refer to the first one's controller. With another controller, build the map anew: what is reachable is a property of the robot as much as of the building.
# </details>
#
# ## Optional extras
#
# - **Extra 1.** Leave `ahead_of` out of your `insert`: all vertices may be taken at any time. How many trajectories stand still or go back on the map?
# - **Extra 2.** Let your `insert` accept a replacement only if its score, with sequences, is above $p_\text{reuse}$ as well. How many wormholes has the office then, and how many vertices?
# - **Extra 3.** Prune more: remove every edge for which there is a path over other edges that is as probable, up to one percent. How many edges remain, and are all paths still there?
# - **Extra 4.** Remove a vertex only when two trajectories did not see it. What must the map remember for that?
#
# Here is the answer to the first.

# %% hidden=true
# The answer to extra 1
rows = []
for name, options in (
    ("never backwards", {}),
    ("anything goes", {"ahead_of": lambda trajectory, *_: np.ones(len(trajectory), dtype=bool)}),
):
    by = partial(check_insert.reference, **options)
    grown = grow(home.reach, home.trajectories, 0.99, by=by)
    repeats = [len(path) - len(set(path)) for path in grown.paths]
    rows.append([name, len(grown.vertices), sum(count > 0 for count in repeats)])
table({"rule": "", "vertices": "d", "trajectories that pass a vertex twice": "d"}, rows)

# %% [markdown]
# ## What to remember
#
# - A map without coordinates: vertices are images, edges are what the controller can do, and $-\log \mathcal{RE}$ makes the most probable path the shortest.
# - Edges are directed, because cars are.
# - Reuse checks whether a vertex does the anchor's *job*. It makes the map smaller **and** better connected.
# - One image may deceive, a sequence hardly does. A rule that checks single images is open to wormholes, reuse included.
# - Retrieve by similarity, then search along trajectories: the queries no longer grow with the square of the map.
# - Growth ends when there is nothing new to see. Forgetting needs a robot that passed by.
#
# **Read next:** the paper, III-F and III-G, and then notebook 06: planning on this map, refusing, and replanning. On the baseline: N. Savinov, A. Dosovitskiy and V. Koltun, [*Semi-Parametric Topological Memory for Navigation*](https://arxiv.org/abs/1803.00653) (ICLR 2018). On recognising places at scale: M. Cummins and P. Newman, [*Appearance-only SLAM at large scale with FAB-MAP 2.0*](https://doi.org/10.1177/0278364910385483) (IJRR 2011).
