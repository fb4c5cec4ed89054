# %% [markdown]
# # 03 · Reachability
#
# **120 minutes.** You need notebook 02: the [[controller]] $\mathcal C$ that drives to the place shown in an image. A little probability helps: what it means that something happens seven times out of ten. Nothing else is required.
#
# After this notebook you can
#
# - say what *reachable* means, and why it is a property of the controller and not of the distance;
# - turn rollouts into labels, and write the loss that makes a network predict probabilities;
# - measure whether predicted probabilities are right, and recalibrate them if they are not;
# - explain why an estimator that is nearly always right is still not good enough to build a map with.
#
# There are five exercises with hints behind folds, the last of them larger than the others. When your function passes its check, **the cells below use it**; until then they use the library's.
#
# We follow X. Meng, N. Ratliff, Y. Xiang and D. Fox, [*Scaling Local Control to Large-Scale Topological Navigation*](https://arxiv.org/abs/1909.12329) (ICRA 2020), from here on "the paper".

# %%
import numpy as np
import torch
from IPython.display import display
from torch import nn
from torch.nn import functional
from tqdm.auto import tqdm

from tutorial_lib.checks.nb03 import (
    check_fit_temperature,
    check_mine_pairs,
    check_reach_loss,
    check_reliability_diagram,
    check_rollout_labels,
)
from tutorial_lib.driving import (
    ComposedController,
    GridPaths,
    ReachGoals,
    RecordedWorld,
    RMPController,
    TargetPolicy,
    demonstrate,
    draw_reachability_pairs,
    reachability_pairs,
    rollout,
)
from tutorial_lib.experiments import load_result
from tutorial_lib.geometry import compose, relative, to_local, to_world
from tutorial_lib.learning import (
    ReachabilityNetwork,
    WaypointNetwork,
    all_logits,
    auc,
    brier,
    by_waypoints,
    encoded,
    load_card,
    sigmoid,
)
from tutorial_lib.viz import (
    PlanView,
    along_trajectory,
    camera_picture,
    chart,
    closeup,
    colours,
    draw_cells,
    draw_reliability,
    from_figure,
    pictured_pair,
    probability_bar,
    show,
    side_by_side,
    sliders,
    stacked,
    table,
)
from tutorial_lib.world import STEP, BicycleCar, Camera, Simulation, is_free, local_world, scene_of

torch.set_num_threads(1)  # the networks are small: a second thread would mostly wait

# %% [markdown]
# ## 1 · What will the controller reach?
#
# The controller of notebook 02 is given an image and drives to the place shown in it. It usually succeeds, but it cannot tell in advance when it will fail. The planner that chooses its next target has to know.
#
# Which targets can it reach? Those nearby, one might say. But a place one metre away may be behind a wall, and a place six metres away at the other end of an empty corridor. The paper defines reachability without distances (III-A, III-C):
#
# $$ \mathrm{RE}(o_\text{current},\, \hat o_\text{target}) \;=\; P\bigl(\text{reach} \mid o_\text{current},\, \hat o_\text{target},\, \mathcal C\bigr) . $$
#
# RE is the **[[reachability estimator]]**, and it belongs to *this controller*: put $\mathcal C$ at the pose where it sees $o_\text{current}$, give it the target $\hat o_\text{target}$ with its context, and let it drive. RE predicts the probability that it arrives.
#
# In simulation we can simply try. Below is an apartment in which no network was trained, with 24 recorded trajectories, and two frames of those trajectories as targets. We start a [[rollout]] from each point of a grid around each target: *all with the same heading as the target*, so that they differ only in where they start. (Starts whose shortest path is 6 m or longer are left out, so that no rollout takes long.)

# %% hidden=true
# Draw two targets, from above and as the camera sees them
HOME = local_world(10_036)
scene = scene_of(HOME)
paths = GridPaths(scene.clearance)
recorded = RecordedWorld(scene, demonstrate(HOME, scene, 24, seed=0))
view = PlanView(scene, 1620, 1060)  # 68 pixels per metre: close-ups are cut out of it
car = BicycleCar()
people_camera = Camera(rows=64)  # the same view as the network's 16 rows, for people
waypoints = WaypointNetwork("waypoint_k2")  # C_WP, with k = 2
reachability = ReachabilityNetwork("reach_k2")  # RE of the C that uses it


def frame_near(pose):
    """The recorded frame closest to a pose, away from the ends of its trajectory."""
    frames = np.arange(len(recorded.poses))
    gap = np.linalg.norm(recorded.poses[:, :2] - pose[:2], axis=1)
    turn = np.abs(relative(np.array([0, 0, pose[2]]), recorded.poses)[:, 2])
    inside = (frames - recorded.first > 8) & (recorded.last - frames > 8)
    return int(np.where(inside, gap + 0.5 * turn, np.inf).argmin())


CELL = 0.42  # metres from one start to the next
LONGEST = 6.0  # metres of the shortest path, to keep the rollouts short


def starts_around(target, reach=2.1, step=CELL):
    """Pairs to a frame from all free points of a grid around it, with the frame's heading."""
    goal, aside = recorded.poses[target], np.arange(-reach, reach + step / 2, step)
    places = goal[:2] + np.stack(np.meshgrid(aside, aside), axis=-1).reshape(-1, 2)
    poses = np.column_stack([places, np.full(len(places), goal[2])])
    poses = poses[is_free(scene, car, poses)]
    pairs = reachability_pairs(recorded, paths, poses, np.full(len(poses), target))
    return pairs.subset(pairs.geodesic < LONGEST)


def draw_target(view, picture, goal):
    """Draw position and heading of a target."""
    tip = to_world(goal, [0.7, 0.0])
    view.polyline(picture, [goal[:2], tip], colours.GOAL, 4)
    view.goal(picture, goal[:2])
    view.arrow(picture, [*tip, goal[2]], colours.GOAL, 8)


def map_around(target, pairs=None, probability=None):
    """The map around a target with circles of 1 m and 2 m; cells are coloured by probability."""
    goal, picture = recorded.poses[target], view.base.copy()
    if pairs is not None:
        draw_cells(view, picture, pairs.starts, probability, CELL)
    angles = np.linspace(0, 2 * np.pi, 73)
    for radius in (1.0, 2.0):
        circle = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        view.polyline(picture, goal[:2] + circle, colours.INK, 1)
    draw_target(view, picture, goal)
    return closeup(view, picture, np.array([goal[:2] - 2.1, goal[:2] + 2.1]), 0.25)


TARGETS = {
    "in a corridor": frame_near([-8.0, 6.0, 0.0]),
    "beyond a doorway": frame_near([-4.2, -1.0, -1.6]),
}
grids = {name: starts_around(target) for name, target in TARGETS.items()}
panels = []
for target in TARGETS.values():
    image = people_camera.look(scene, recorded.poses[[target]])[0][0]
    above = map_around(target)
    panels.append(stacked([above, camera_picture(image, above.shape[1])], gap=6))
show(side_by_side(panels, [f"target {name}" for name in TARGETS]))

# %% [markdown]
# The green arrow is the heading, of the target and of every start; the circles have radii of 1 m and 2 m. **Predict** for both targets: from which starts will the car arrive? From all starts within one metre? From starts *ahead* of the target, so that it has to come back? From starts *beside* it? From the other side of a wall?
#
# Then run the cells (about 5 s): a car drives from every start, with $\mathcal C$. The first is worth reading, since it makes all rollouts of this notebook. To arrive means to come within 0.30 m, in time and without a collision. On the right is what RE predicts beforehand, from the two images alone.


# %%
def roll_out(recorded, pairs, make_policy):
    """Roll out every pair: the rollouts, and which car is in contact at each step, (T, N)."""
    simulation, touched = Simulation(recorded.scene, pairs.starts), []
    rollouts = rollout(
        simulation,
        make_policy(simulation, recorded, pairs.targets),
        ReachGoals(recorded.poses[pairs.targets, :2], pairs.limit, settle=True),
        record=lambda world, *_: touched.append(world.touching),
    )
    return rollouts, np.array([*touched, simulation.touching])


visual_policy = by_waypoints(waypoints)  # C, as a policy factory

# %% hidden=true
# Drive from every start of both grids, and draw where the car arrives
both = list(grids.values())
pairs = reachability_pairs(
    recorded,
    paths,
    np.concatenate([grid.starts for grid in both]),
    np.concatenate([grid.targets for grid in both]),
)
reached = roll_out(recorded, pairs, visual_policy)[0].reached
predicted = reachability.calibration(
    all_logits(reachability, recorded, pairs.starts, pairs.targets)
)
cuts = [len(both[0])]
arrived = dict(zip(grids, np.split(reached, cuts), strict=True))
probabilities = dict(zip(grids, np.split(predicted, cuts), strict=True))
rows = []
for name, target in TARGETS.items():
    grid = grids[name]
    maps = [map_around(target, grid, values) for values in (arrived[name], probabilities[name])]
    rows.append(side_by_side(maps, [f"{name}: outcome", "RE's prediction"]))
show(stacked([*rows, probability_bar("does not arrive", "arrives")]))

# %% hidden=true
# Count by distance and direction
goals = np.concatenate([recorded.poses[grid.targets] for grid in grids.values()])
starts = np.concatenate([grid.starts for grid in grids.values()])
success = np.concatenate(list(arrived.values()))
predicted = np.concatenate(list(probabilities.values()))
offset = to_local(starts, goals[:, :2])
distance = np.linalg.norm(offset, axis=1)
angle = np.abs(np.rad2deg(np.arctan2(offset[:, 1], offset[:, 0])))
in_sight = scene.caster.sees(starts[:, :2], goals[:, :2])
groups = {
    "target ahead": in_sight & (angle < 45),
    "target behind": in_sight & (angle > 135),
    "target beside": in_sight & (angle >= 45) & (angle <= 135),
    "a wall between": ~in_sight,
}
rings = [(0.3, 1.0), (1.0, 1.6), (1.6, 2.2)]
lines = []
for name, chosen in groups.items():
    cells = []
    for low, high in rings:
        ring = chosen & (distance >= low) & (distance < high)
        cells.append(None)
        if ring.any():
            cells[-1] = f"{success[ring].mean():.0%} of {ring.sum()} ({predicted[ring].mean():.2f})"
    lines.append([name, *cells])
caption = "Share of the cars that arrive, by distance to the target (and RE's mean prediction)"
headings = {"": "", **{f"{low} to {high} m": "" for low, high in rings}}
table(headings, lines, caption=caption)

# %% [markdown]
# <details><summary>What do you see?</summary>
# Read the table down a column: the distance is the same, and the outcome is not. A target <i>ahead</i> is reached from every distance shown. One <i>behind</i> is reached in reverse, but not from as far. A target <i>beside</i> the car is the hardest of those in sight, however near it is. A wall between makes a target unreachable, unless there is a door nearby: through the doorway the car arrives
# from a fan of starts that see into the room.
#
# RE has the shape right: walls, doors, ahead and behind. But it is far too optimistic for targets <i>beside</i> the car, and for those two metres behind it. Keep that in mind, we will come back to it.
# </details>
#
# ### A property of the controller
#
# Now the same starts, the same target beyond the doorway, and two other controllers. One uses the same waypoint network, but never reverses. The other is an oracle: it drives like $\mathcal C$, but knows the position of the target, so that only the body and the time limit can stop it. **Predict** how the blue area changes.


# %% hidden=true
# Drive with three controllers from the same starts
class ToTargets:
    """An oracle policy: it knows the positions of its targets."""

    def __init__(self, simulation, recorded, frames):
        self.simulation, self.goals = simulation, recorded.poses[frames, :2]

    def act(self, observations, robots):
        positions = to_local(self.simulation.poses[robots], self.goals[robots])
        return RMPController().act(observations, positions)


def forwards_only(simulation, recorded, frames):
    """C without reversing."""
    never = 1e6  # cost of reversing, and the room it needs
    rmp = RMPController(reverse_cost=never, go_on=never, begin=never)
    return TargetPolicy(ComposedController(waypoints, rmp), encoded(waypoints, recorded, frames))


name = "beyond a doorway"
grid = grids[name]
outcomes = {
    "never reverses": roll_out(recorded, grid, forwards_only)[0].reached,
    "C": arrived[name],
    "oracle": roll_out(recorded, grid, ToTargets)[0].reached,
}
for controller, reached in outcomes.items():
    print(f"{controller}: arrives from {reached.sum()} of {len(grid)} starts")
panels = [map_around(TARGETS[name], grid, reached) for reached in outcomes.values()]
show(side_by_side(panels, list(outcomes), height=300))

# %% [markdown]
# <details><summary>What follows?</summary>
# Three controllers, three different areas, and nothing about the places has changed. "Is it reachable?" has no answer until we say <i>by which controller</i>. An estimator that was trained for one controller is wrong for another; the paper trains one for each, and so do we. This is also why image similarity, or time between frames, is only a
# proxy for reachability: neither depends on the controller.
# </details>
# <details><summary>A target beside the car lies inside its turning circle. Is that why it is not reached?</summary>
# One would think so; but the oracle reaches targets beside the car as well, with the same body and in the same time. So the cause is not the body but the predicted waypoint. The next cell shows its error.
# </details>

# %% hidden=true
# Compare targets to the side with the waypoints that are predicted for them
shift, waypoint_shift = [], []
for grid in grids.values():
    seen, targets = Simulation(scene, grid.starts).observe(), grid.targets
    waypoint_shift.append(waypoints.predict(seen, encoded(waypoints, recorded, targets))[0][:, 1])
    shift.append(to_local(grid.starts, recorded.poses[targets, :2])[:, 1])
shift, waypoint_shift = np.abs(np.concatenate(shift)), np.abs(np.concatenate(waypoint_shift))
beside = groups["target beside"]
lines = []
for low, high in [(0.3, 0.6), (0.6, 1.0), (1.0, 1.4), (1.4, 1.8), (1.8, 2.4)]:
    band = beside & (shift >= low) & (shift < high)
    if band.any():
        means = shift[band].mean(), waypoint_shift[band].mean(), success[band].mean()
        lines.append([*means, int(band.sum())])
headings = {"target, m to the side": ".2f", "its first waypoint, m to the side": ".2f"}
table({**headings, "arrive": ".0%", "starts": "d"}, lines)

# %% [markdown]
# <details><summary>What happens there?</summary>
# $\mathcal C_{WP}$ underestimates targets far to the side. It learnt from starts beside a trajectory, most of them less than half a metre aside, and it predicts about the same waypoint for everything beyond. The car drives there, the images look nearly alike, it takes the place for the target and stops. RE has seldom seen such starts either and does not predict
# better. Both are good on their training distribution, and this is outside it.
# </details>
#
# ## 2 · Labels from rollouts
#
# RE is learnt from outcomes. Draw a **pair** of a start and a target from the recorded trajectories at random (the paper: on the same trajectory with probability 0.6, on two trajectories otherwise; we move most starts a little aside), drive with $\mathcal C$ from the start to the target, and record whether it arrives. No rule has to say what makes a target hard.
#
# A car that circles for ten minutes and then hits upon the target by chance has not shown that it can reach it. So there is a time limit, from the length of the shortest path and the slowest speed that is tolerated (III-C; the 5 s and the 0.3 m/s come from the authors' code):
#
# $$ t_\text{max} = \frac{A^*(o_\text{current}, o_\text{target})}{v_\text{min}} + 5\ \text{s}, \qquad v_\text{min} = 0.3\ \text{m/s}. $$
#
# The label is 1 if there is a moment, at $t_\text{max}$ at the latest, at which the car is at most 0.30 m from the target and has not touched anything until then, that moment included. What a car does *after* it has arrived does not count. Otherwise the label is 0.
#
# And a rollout with a collision? The authors' code leaves such rollouts out of the data. Then RE gets no data about the places where the controller crashes. A robot that queries RE there should get a low probability. We keep them: label 0.
#
# ### Exercise 1 · `rollout_labels` (medium, 10 minutes)
#
# <details><summary>Hint 1: concept</summary>Three things must hold at the same moment: near, in time, and clean so far. The label asks whether there is any such moment.</details>
# <details><summary>Hint 2: approach</summary>Make three tables (T, N) of true and false and join them with &. Time against limit: times[:, None] &lt;= limits makes a table of a column and a row. "Clean so far" is a running or: np.logical_or.accumulate(touched, axis=0) is true from the first contact on.</details>
# <details><summary>Hint 3: one line</summary>For one car with the moments near, in time, and touched it would be <code>any(n and t and not any(c[:i + 1]) for i, (n, t, c) in …)</code>. Which axis of the tables plays the role of this any, and which function the role of the inner one?</details>


# %% exercise="rollout_labels"
def rollout_labels(times, gaps, touched, geodesic):
    """Which rollouts count as reached.

    times: (T,) seconds since the start, rising; T >= 1. gaps: (T, N) metres
    from each car to its target. touched: (T, N) whether a car touches
    something at that moment. geodesic: (N,) metres of the shortest path. Near
    is at most 0.30 m; in time is at most geodesic / 0.3 + 5 seconds; a touch
    in the very moment of arrival counts.
    Returns an array of labels (N,), 1 or 0.
    """
    ### BEGIN SOLUTION
    near = gaps <= 0.30
    in_time = times[:, None] <= geodesic / 0.3 + 5.0
    touched_so_far = np.logical_or.accumulate(touched)
    return (near & in_time & ~touched_so_far).any(axis=0).astype(float)
    ### END SOLUTION


# %%
rollout_labels = check_rollout_labels.use(rollout_labels)

# %% [markdown]
# Now we collect labels (about 10 s): in four buildings in which neither network was trained, up to 150 pairs each. We keep only pairs whose two images overlap by at least a tenth, both ways, since only for these do the images contain information about the outcome, and whose shortest path is less than 6 m, so that no rollout takes long. (Those that do not overlap are the subject of section 5.) **Predict:** what share arrives? And of those that do not, how
# many collide?

# %% hidden=true
# Draw pairs in four buildings, and drive
SEEDS = {"apartment": 10_036, "office": 10_037, "maze": 10_038, "ring of corridors": 10_039}
TRAIN, CALIBRATE, TEST = ["apartment", "maze"], ["ring of corridors"], ["office"]
driven = {}
for i, (name, seed) in enumerate(tqdm(SEEDS.items(), "buildings")):
    world = recorded
    if local_world(seed) != HOME:
        place = scene_of(local_world(seed))
        world = RecordedWorld(place, demonstrate(local_world(seed), place, 8, seed=0))
    geodesics = paths if world is recorded else GridPaths(world.scene.clearance)
    drawn = draw_reachability_pairs(world, geodesics, 90, np.random.default_rng(i))
    drawn = drawn.subset(np.flatnonzero(drawn.seen & (drawn.geodesic < LONGEST))[:150])
    rollouts, touched = roll_out(world, drawn, visual_policy)
    goals = world.poses[drawn.targets]
    gaps = np.linalg.norm(rollouts.poses[:, :, :2] - goals[:, :2], axis=2)
    driven[name] = {
        "recorded": world,
        "paths": geodesics,
        "pairs": drawn,
        "rollouts": rollouts,
        "touched": touched,
        "goals": goals,
        "gaps": gaps,
        "logits": all_logits(reachability, world, drawn.starts, drawn.targets),
    }

# %% hidden=true
# Label the rollouts
buildings, lines = {}, []
for name, building in driven.items():
    gaps, touched, drawn = building["gaps"], building["touched"], building["pairs"]
    labels = rollout_labels(STEP * np.arange(len(gaps)), gaps, touched, drawn.geodesic)
    buildings[name] = building | {"labels": labels}
    crashed = (labels == 0) & touched.any(axis=0)
    late = 1 - labels.mean() - crashed.mean()
    agree = np.mean(labels == building["rollouts"].reached)
    lines.append([name, len(labels), labels.mean(), late, crashed.mean(), agree])
headings = {"building": "", "pairs": "d", "arrive": ".0%", "do not in time": ".0%"}
table({**headings, "collide": ".0%", "the library agrees on": ".0%"}, lines)

# %% [markdown]
# <details><summary>Then does it matter how collisions are counted?</summary>
# For this controller hardly at all: $\mathcal C_{RMP}$ measures walls with the laser and avoids them, here as in the training worlds. That is worth knowing, and only the count shows it. With a controller that cuts corners, or with people around, it would decide what RE learns, as the next section shows.
# </details>
#
# ## 3 · A loss that makes a network predict probabilities
#
# The network of RE is that of $\mathcal C_{WP}$ (III-C: "almost identical"), and it is initialised with the encoder that $\mathcal C_{WP}$ has learnt: both need to find correspondences between two images. In place of a waypoint it returns a **logit** $z$, any real number, and $p = \sigma(z) = 1 / (1 + e^{-z})$ turns it into a probability. The label is $y$: 1 reached, 0 not. The paper trains
# "with a binary classification loss" (III-C), the cross-entropy
#
# $$ \ell(z, y) \;=\; -\,y \log \sigma(z) \;-\; (1-y) \log\bigl(1 - \sigma(z)\bigr) \;=\; \log\bigl(1 + e^{z}\bigr) - y\,z . $$
#
# The first form explains it: the cost is $-\log$ of the probability that was predicted for what then happened. The second is how to compute it. For $z = 1000$ the first takes the logarithm of 0. In the second `np.logaddexp(0, z)`, which is $\log(e^0 + e^z)$ for any $z$, is numerically stable.
#
# The same loss works for labels *between* 0 and 1. Our network, unlike the paper's, also predicts the two overlaps of the pair: they are shares, known for every pair, and how much of a target is visible decides more than anything else whether it is reached. And pairs may have **weights** $w$; then the total loss is $\sum w\,\ell / \sum w$.
#
# ### Exercise 2 · `reach_loss` (easy, 8 minutes)
#
# <details><summary>Hint 1: concept</summary>Stay with the logit. Converting it to a probability first loses it for large z: 1 − σ(40) is 0 in floating point.</details>
# <details><summary>Hint 2: approach</summary>One loss for each pair by the second form, and then their weighted mean: np.average has an argument weights.</details>
# <details><summary>Hint 3: one line</summary>Squared errors with weights would be <code>np.average((z - y) ** 2, weights=w)</code>. Which expression belongs in place of the square?</details>


# %% exercise="reach_loss"
def reach_loss(logits, labels, weights):
    """The weighted mean of the cross-entropy.

    logits: (N,) any numbers, 1000 too. labels: (N,) from 0 to 1. weights: (N,)
    0 or greater, not all 0. Returns one number: the sum of weight times loss
    over the sum of the weights.
    """
    ### BEGIN SOLUTION
    each = np.logaddexp(0.0, logits) - labels * logits
    return np.average(each, weights=weights)
    ### END SOLUTION


# %%
reach_loss = check_reach_loss.use(reach_loss)

# %% [markdown]
# Why should this loss lead to a *probability*, when the labels are only ones and zeros? A thought experiment: ten rollouts from the very same start to the very same target. Seven arrive, two run out of time, one hits the wall. The network sees the same two images ten times, so it must predict the same $p$ for all ten.
#
# **Predict:** for which $p$ is the mean cross-entropy smallest? For which one, if the rollout that hit the wall is dropped (weight 0)? And for which one if the loss were simply $|p - y|$?

# %% hidden=true
# Draw the mean loss of ten rollouts for every prediction
ten = np.array([1.0] * 7 + [0.0] * 3)
predicted = np.linspace(0.005, 0.995, 199)
logits = np.log(predicted / (1 - predicted))
equal, dropped = np.ones(10), np.array([1.0] * 9 + [0.0])
curves = {
    "cross-entropy": [reach_loss(np.full(10, z), ten, equal) for z in logits],
    "cross-entropy, one dropped": [reach_loss(np.full(10, z), ten, dropped) for z in logits],
    "absolute error": [np.abs(p - ten).mean() for p in predicted],
}
figure, (axis,) = chart(8.0, 3.6)
tones = (colours.ROBOT, colours.TRACK, colours.LASER)
for (name, losses), tone in zip(curves.items(), tones, strict=True):
    best = int(np.argmin(losses))
    legend = f"{name}: best at {predicted[best]:.3f}"
    axis.plot(predicted, losses, color=colours.unit(tone), label=legend)
    axis.plot(predicted[best], losses[best], "o", color=colours.unit(tone), markersize=9)
axis.set(xlabel="prediction p", ylabel="mean loss of ten rollouts", xlim=(0, 1), ylim=(0.2, 1.6))
axis.legend(loc="upper center")
show(from_figure(figure))

# %% [markdown]
# <details><summary>What follows?</summary>
# The cross-entropy is smallest at 0.7, the share that arrives: a network that minimises it predicts the <i>frequency</i> of success. A loss with this property is called <i>proper</i> (a proper scoring rule). With the crash dropped the best prediction is 7 of 9, 0.78: RE would be too optimistic exactly where the controller is dangerous. And with the absolute error the best
# prediction is 1: this loss teaches over-confidence. (The squared error is proper too. It is called the Brier score, and we will meet it below.)
#
# So much for theory. It holds for the rollouts on which the network was trained, and for a network that can represent any function. Whether a real network's probabilities are right <i>in a new building</i> has to be measured.
# </details>
#
# ## 4 · Is it right?
#
# A weather forecast of "70 %" cannot be checked on one day. Of all the days with a forecast of 70 %, it should rain on seven of ten. The same for RE: sort its predictions, put those of about the same size into a [[bin]], and compare the *mean prediction* of each bin with the *share that arrived*. The plot of one against the other is the **[[reliability diagram]]**; an estimator whose points
# lie on the diagonal is **[[calibrated]]**.
#
# Most predictions are near 1, so bins of equal width would be nearly empty in the middle and the last one would hold almost everything. We use bins of equal **mass**: each has as many predictions as the next, or one more where $N$ is not a multiple of the number of bins $B$. (Which bins have one more is up to you.) The **expected calibration error** (ECE) is the mean gap, each bin weighted with its number of predictions $n_b$:
#
# $$ \mathrm{ECE} = \sum_b \frac{n_b}{N}\,\bigl|\,\overline{p}_b - \overline{y}_b\,\bigr| . $$
#
# ### Exercise 3 · `reliability_diagram` (medium, 10 minutes)
#
# <details><summary>Hint 1: concept</summary>Sort by the prediction, cut into pieces of equal length, take two means of each piece. Prediction and outcome must stay together when you sort.</details>
# <details><summary>Hint 2: approach</summary>np.argsort(predicted) gives the indices of the pairs from the lowest prediction to the highest, and np.array_split cuts them into `bins` groups, whose lengths differ by one at most.</details>
# <details><summary>Hint 3: one line</summary>The largest value of each of 7 groups of x would be <code>[x[g].max() for g in np.array_split(np.argsort(x), 7)]</code>. What do you need of each group, and which weight has its gap?</details>


# %% exercise="reliability_diagram"
def reliability_diagram(predicted, came_true, bins):
    """Compare predictions with outcomes in bins of equal mass.

    predicted: (N,) probabilities. came_true: (N,) 0 or 1. bins: B, how many,
    from 1 to N; their sizes differ by one at most.
    Returns two arrays and a number: the mean prediction of each bin (B,), from
    the lowest to the highest, the share of each bin that came true (B,), and
    the ECE.
    """
    ### BEGIN SOLUTION
    groups = np.array_split(np.argsort(predicted), bins)
    expected = np.array([predicted[group].mean() for group in groups])
    measured = np.array([came_true[group].mean() for group in groups])
    share = np.array([len(group) for group in groups]) / len(predicted)
    return expected, measured, (share * np.abs(expected - measured)).sum()
    ### END SOLUTION


# %%
reliability_diagram = check_reliability_diagram.use(reliability_diagram)

# %% [markdown]
# First a quickly trained network. It uses the frozen encoder of $\mathcal C_{WP}$: its features of the five image comparisons of each pair. On top of them two small layers are trained, on nothing but the 300 rollouts in the *apartment* and the *maze*, until they fit them well. The *ring of corridors* and the *office* are held out.
#
# **Predict:** how will its reliability diagram look for the rollouts on which it was trained? And in the ring of corridors: will the points lie above the diagonal (the car arrives more often than predicted) or below (it arrives less often)?


# %% hidden=true
# Train the quick network, and draw its reliability diagrams
def pooled(names, key):
    """The values of several buildings."""
    return np.concatenate([buildings[name][key] for name in names])


def frozen_features(name):
    """The features of the encoder of C_WP for every pair of a building, (N, features)."""
    world, drawn = driven[name]["recorded"], driven[name]["pairs"]
    current = waypoints.encode(Simulation(world.scene, drawn.starts).observe())
    targets = encoded(waypoints, world, drawn.targets).encoded
    with torch.no_grad():
        return waypoints.network.encoder.compare(current, targets).flatten(1)


features = {name: frozen_features(name) for name in SEEDS}
x = torch.cat([features[name] for name in TRAIN])
y = torch.from_numpy(pooled(TRAIN, "labels")).float()
torch.manual_seed(0)
quick = nn.Sequential(nn.Linear(x.shape[1], 64), nn.ReLU(), nn.Linear(64, 1))
optimizer = torch.optim.Adam(quick.parameters(), 1e-3)
for step in range(301):
    z = quick(x)[:, 0]
    loss = functional.binary_cross_entropy_with_logits(z, y)
    if step % 100 == 0:
        mine = reach_loss(z.detach().double().numpy(), y.double().numpy(), np.ones(len(y)))
        print(
            f"step {step:3d}: the loss is {loss.item():.4f} by torch and {mine:.4f} by exercise 2"
        )
    optimizer.zero_grad()
    loss.backward()
    optimizer.step()
with torch.no_grad():
    for name in SEEDS:
        buildings[name]["quick"] = quick(features[name])[:, 0].double().numpy()

figure, axes = chart(9.0, 4.4, columns=2)
for axis, names, title in zip(
    axes, (TRAIN, CALIBRATE), ("training buildings", "a new building"), strict=True
):
    predicted, reached = sigmoid(pooled(names, "quick")), pooled(names, "labels")
    means, shares, ece = reliability_diagram(predicted, reached, 10)
    draw_reliability(axis, means, shares, len(reached) / 10, color=colours.unit(colours.LASER))
    axis.set_title(f"{title}: ECE {ece:.3f}")
    sure = predicted > 0.99
    print(
        f"{title}: it predicts more than 0.99 for {sure.mean():.0%} of the pairs; {reached[sure].mean():.1%} of those arrive"
    )
show(from_figure(figure))

# %% [markdown]
# <details><summary>What do you see?</summary>
# On its training buildings it is nearly perfect: it has memorised the rollouts. In a new building it is nearly as <i>confident</i> as before but no longer as accurate: most of its predictions are near 0 or 1, and the points lie below the diagonal at its upper end and above it at its lower end. This is <b>over-confidence</b>, which is typical of neural networks: to reduce the loss further on rollouts whose outcome it already
# gets right, training can only make the logits larger. (The vertical lines are 95 % intervals: that much could be chance.)
# </details>
#
# ### Recalibration
#
# The ranking of its predictions may be good although the *values* are off. So keep the ranking and change the scale: apply to the logit an increasing function that is fitted on rollouts on which the network was not trained. The simplest one divides by a **[[temperature]]** $T$ (C. Guo, G. Pleiss, Y. Sun and K. Weinberger, [*On Calibration of Modern Neural Networks*](https://arxiv.org/abs/1706.04599), ICML 2017):
#
# $$ p = \sigma(z / T), \qquad T = \arg\min_T \; \sum_i \ell\bigl(z_i / T,\; y_i\bigr) . $$
#
# $T > 1$ pulls all predictions towards one half, for an over-confident network; $T < 1$ pushes them outwards. A network that is always right would get $T \to 0$, one that is always wrong $T \to \infty$, so we only look from 0.05 to 20.
#
# ### Exercise 4 · `fit_temperature` (easy, 8 minutes)
#
# <details><summary>Hint 1: concept</summary>There is one unknown, and you have a function that scores each value of it. You can just try many.</details>
# <details><summary>Hint 2: approach</summary>A temperature of 0.5 is as far from 1 as one of 2: try values that grow by a factor, np.geomspace(0.05, 20, 600). Compute reach_loss(logits / t, labels, weights) for each, with weights of one. (Or scipy.optimize.minimize_scalar over log T.)</details>
# <details><summary>Hint 3: one line</summary>The angle below 3 at which the sine is smallest would be <code>angles[np.argmin([np.sin(a) for a in angles])]</code>. What takes the place of the sine?</details>


# %% exercise="fit_temperature"
def fit_temperature(logits, labels):
    """The temperature T with the least mean loss of logits / T, to about 1 %.

    logits: (N,). labels: (N,) from 0 to 1. T is sought from 0.05 to 20; where
    the loss falls up to an end of this range, T is that end. Returns one
    number.
    """
    ### BEGIN SOLUTION
    temperatures, ones = np.geomspace(0.05, 20.0, 600), np.ones(len(logits))
    losses = [reach_loss(logits / t, labels, ones) for t in temperatures]
    return temperatures[np.argmin(losses)]
    ### END SOLUTION


# %%
fit_temperature = check_fit_temperature.use(fit_temperature)

# %% [markdown]
# Now both networks, the quick one and the library's. The temperature of each is fitted in the ring of corridors, and everything is evaluated in the office, which neither has seen.
#
# A temperature is a single number and cannot bend a curve. The library's RE uses an increasing piecewise linear function through twenty points instead, fitted to outcomes in 24 validation worlds, of pairs like those of exercise 1 (*isotonic regression*, `learning/calibration.py`); that is what `reachability.calibration` does, and what section 1 showed.
#
# For comparison there are two more: a *constant* prediction, the share that arrived in the ring of corridors, and the library's predictions rounded to *0 or 1*, "since a car either arrives or it does not". Four measures: **AUC**, the probability that of two pairs, one of which arrives, that one has the higher prediction; **ECE**; **Brier**, the mean squared error; and the log loss of exercise 2.
#
# **Predict:** which of the four will the temperature change, and which one can it not change? Which line will have the best ECE?

# %% hidden=true
# Fit temperatures, evaluate in the office, and draw
reached = pooled(TEST, "labels")
lines = []  # name, predictions, index of the panel, colour
for panel, (network, key) in enumerate((("quick", "quick"), ("library", "logits"))):
    logits = pooled(TEST, key)
    temperature = fit_temperature(pooled(CALIBRATE, key), pooled(CALIBRATE, "labels"))
    scaled = sigmoid(logits / temperature)
    lines.append((f"{network}, raw", sigmoid(logits), panel, colours.LASER))
    lines.append((f"{network}, T = {temperature:.2f}", scaled, panel, colours.PATH))
isotonic = reachability.calibration(pooled(TEST, "logits"))
constant = np.full(len(reached), pooled(CALIBRATE, "labels").mean())
lines.append(("library, isotonic", isotonic, 1, colours.ROBOT))
lines.append(("constant", constant, None, None))
lines.append(("0 or 1", (pooled(TEST, "logits") > 0).astype(float), None, None))
rows = []
figure, axes = chart(9.0, 4.6, columns=2)
for name, predicted, panel, tone in lines:
    means, shares, ece = reliability_diagram(predicted, reached, 10)
    clipped = np.clip(predicted, 1e-6, 1 - 1e-6)  # predictions of 0 and 1 can cost infinitely much
    loss = reach_loss(np.log(clipped / (1 - clipped)), reached, np.ones(len(clipped)))
    values = (predicted.mean(), auc(predicted, reached), ece, brier(predicted, reached))
    rows.append([name, *values, loss])
    if panel is not None:
        axis = axes[panel]
        draw_reliability(axis, means, shares, color=colours.unit(tone), label=name)
for axis in axes:
    axis.legend(loc="upper left")
rng = np.random.default_rng(0)
perfect = [
    reliability_diagram(isotonic, (rng.random(len(isotonic)) < isotonic).astype(float), 10)[2]
    for _ in range(200)
]
columns = ("mean prediction", "AUC", "ECE", "Brier", "log loss")
best = {"AUC": max, "ECE": min, "Brier": min, "log loss": min}
words = f"{len(reached)} rollouts in the {TEST[0]}, of which {reached.mean():.1%} arrived"
display(table({"": "", **dict.fromkeys(columns, ".3f")}, rows, best, words))
print(f"exact probabilities would have an ECE of about {np.mean(perfect):.3f} here, by chance")
show(from_figure(figure))

# %% [markdown]
# <details><summary>What changed, and what did not?</summary>
# The AUC does not change: an increasing function keeps the ranking, and the AUC depends on nothing but the ranking. (The constant has no ranking at all, 0.5; 0 or 1 has thrown most of it away.) Calibration adds no information to a network. It makes its probabilities honest.
#
# The ECE alone says little. A constant prediction of the share that arrives is calibrated by definition, and useless, since it does not distinguish any two targets. (The one in the table is the share of another building, so it is off by the difference of the two, and by what is chance in its bins.) Look at ECE <i>and</i> AUC, or at Brier and log loss, which reward both. The log loss penalises confident errors most: it is very high for "0 or 1", though its AUC is good.
#
# And note the last line: with so few rollouts, even exactly right probabilities would not lie on the diagonal. Smaller differences mean nothing here. The results page at the end has many more.
# </details>
# <details><summary>Is the library's raw network wrong, too?</summary>
# A little: it is too modest. Where it is unsure, its points lie above the diagonal, and its mean prediction is below the share that arrived. That is no wonder. In the last part of its training about every tenth target was one on which it had been wrong before (section 5 explains why that is needed), and there many more rollouts fail. A temperature does not help: T is close to 1, and the two lines coincide. It can only move predictions away from one half or towards it, and here those near one half have to move up, too (extra 3). The isotonic function can do that, and was fitted on far more rollouts than we have here.
# But 150 rollouts are few: how much better it is cannot be decided with this page's data. The results page at the end has more. Diagnose before you recalibrate: look at the diagram first, and at how much could be chance.
# </details>
# <details><summary>Why must a calibration be fitted on rollouts on which the network was not trained?</summary>
# Look at the quick network on its training buildings: it is right there, however sure it is, so the best temperature would be far below 1 and make it even surer. Its confidence is justified on what it has memorised, and not elsewhere; rollouts that it has memorised cannot show that.
# </details>
# <details><summary>In section 1 the calibrated RE was too optimistic for targets beside the car. Is it calibrated or not?</summary>
# It is, <i>for pairs like those on which it was fitted</i>: starts on trajectories or a little aside, and images that overlap. Calibration is a statement about an average over a distribution of pairs. The grid of section 1 is another distribution, and there it need not hold. Before you trust a probability, ask on which pairs it was measured, and whether yours are like them. The next section is about the pairs that a map queries.
# </details>
#
# ## 5 · Far look-alikes
#
# A topological map (notebook 05) is built by querying RE for **all pairs** of its vertices, most of which are far apart. For how many of those will it be sure by mistake?
#
# Here are 120 frames of the apartment, all paired with each other. We take the **far, occluded pairs**, which are certainly unreachable: more than 5 m of geodesic distance (shortest path) apart, and with less than a tenth of either view in the other. **Predict:** among thousands of them, how many will get an RE above 0.5, above 0.9, above 0.99? And what will the worst ones look like?

# %% hidden=true
# Query RE for all pairs of 120 frames, and show the worst
frames = np.linspace(0, len(recorded.poses) - 1, 120).round().astype(int)
rows, columns = (pairs.ravel() for pairs in np.meshgrid(frames, frames, indexing="ij"))
rows, columns = rows[rows != columns], columns[rows != columns]
queries = reachability_pairs(recorded, paths, recorded.poses[rows], columns)
probability = reachability.calibration(
    all_logits(reachability, recorded, queries.starts, queries.targets)
)
occluded = np.flatnonzero(queries.far_and_occluded)
print(f"{len(queries):,} pairs, {len(occluded):,} of them far and occluded")
lines = [
    [level, (probability > level).sum(), (probability[occluded] > level).sum()]
    for level in (0.5, 0.9, 0.99)
]
display(table({"RE above": "g", "all pairs": ",d", "far and occluded": ",d"}, lines))
worst, taken = [], np.zeros((0, 2))
for i in occluded[np.argsort(-probability[occluded])]:  # each from another place
    place = queries.starts[i, :2]
    if len(worst) < 3 and (np.linalg.norm(taken - place, axis=1) > 2.0).all():
        worst.append(i)
        taken = np.vstack([taken, place])
panels, titles = [], []
for i in worst:
    pair = np.array([queries.starts[i], recorded.poses[queries.targets[i]]])
    panels.append(pictured_pair(*people_camera.look(scene, pair)[0], 306))
    titles.append(f"RE {probability[i]:.2f}, {queries.geodesic[i]:.0f} m apart")
show(side_by_side(panels, titles))

# %% [markdown]
# <details><summary>Why these?</summary>
# Their geometry is alike: a view along a corridor or through a room, a wall on either side, something at the end. Only the colours distinguish the places, strip by strip, and some of those recur in every room. This is <b>perceptual aliasing</b>; a later part of the course is about it. Context should help, since five images of a target are less likely to be alike than one; the results page
# shows whether it does.
# </details>
#
# An edge of the map between two such places is a **[[wormhole]]**: the planner assumes that the robot can drive from one to the other, and since planners look for short paths, it will use it.
#
# <details><summary>Interpret this: an estimator is right about 999 of 1,000 unreachable pairs. A building has 1,000 vertices, and each can really reach two others. What share of the map's edges are wormholes?</summary>
# There are 1,000 × 999, about a million ordered pairs. 2,000 of them are real edges. Of the other 998,000, one in a thousand is accepted: 998 wormholes. <b>One edge in three is false</b>, with an estimator that is right 99.9 % of the time. What counts is not the error rate, but the error rate among the pairs that it <i>accepts</i> (one minus its precision), and that depends on the base rate. Doctors
# know this from tests for rare diseases. A map of 1,000 vertices needs an error rate of one in 100,000 to have fewer than ten wormholes.
# </details>
# <details><summary>Then how can a network ever learn it? In a random draw of pairs, mistakes of this kind hardly occur.</summary>
# By searching for them, <b>hard negative mining</b>. After most of its training, the network predicted all pairs of 160 frames in 80 training worlds. Among those with a high prediction, the far, occluded pairs are its worst mistakes, <b>hard negatives</b>: up to 400 in each world, those with the highest predictions, and they are labelled 0 without a rollout. In each world up to 100 other pairs were rolled out. (Many of these did arrive: such pairs are
# kept too, or the network would learn to distrust all its confident predictions.) In the rest of the training about every tenth target came from these two sets.
# </details>

# %% hidden=true
# Read the library's training from its card
card = load_card("reach_k2")
recipe = card.recipe
print(f"trained on {recipe['errands']:,} pairs, {recipe['reached']:,} of which arrived,")
print(f"and on {recipe['mined'][0]:,} mined pairs; {card.minutes:.0f} minutes")

# %% [markdown]
# ### Mine the hard pairs yourself
#
# The quick network of section 4 has seen no hard pair at all: its 300 pairs overlap. Now you mine some for it. The pool holds the pairs that have been rolled out already, and the pairs of 45 frames of each training building, for which there is only the network's prediction. From the pool a training set is made, in four steps:
#
# 1. **Easy pairs**: every pair that has a label already. Weight 1 each.
# 2. **[[Hard negative]]s**: of the pairs without a label that are far and occluded (`occluded`), those with a prediction above `sure`, the highest first: at most `most` of them, and at most `each` with the same start frame, or a single odd place would fill the list. A pair that is left out because its start has enough already does not count. The label is 0, without a rollout.
# 3. **Confident pairs**: of those without a label that are *not* occluded, with a prediction above `sure`, as many as there are hard negatives (all, if there are fewer), drawn at random with `rng`, each at most once. They are rolled out: `roll_out(pairs)` takes an array of indices and returns their labels. Rollouts are what takes time, so no other pair is rolled out, and none twice.
# 4. **Weights**: all mined pairs, hard negatives and confident ones, weigh the same, such that together they have the share `share` of the whole weight, that of the easy ones included.
#
# Why step 3, if occluded pairs are the problem? **Think first**, what would the network learn if every pair that it is sure of came with the label 0?
#
# ### Exercise 5 · `mine_pairs` (large, 35 minutes)
#
# <details><summary>Hint 1: concept</summary>Four groups of pairs: known; occluded and sure; not occluded and sure; all others. Make a mask of each, then shorten the second and the third one. Keep pairs, labels and weights in the same order until the end.</details>
# <details><summary>Hint 2: approach</summary>Whether a label is known: np.isnan. For the hard negatives go through np.argsort(-probability) with a loop, a list of the chosen, and a dictionary that counts how often each start was taken. For the others rng.permutation of their indices, cut off after as many as you need. With E easy pairs of weight 1 and M mined ones of weight w, the share is M w / (E + M w): solve it for w, and mind M = 0.</details>
# <details><summary>Hint 3: one line</summary>At most two words with the same first letter: <code>for word in words: if count.get(word[0], 0) &lt; 2: …</code> What are the words here, what the letter, and which other two conditions join this one?</details>


# %% exercise="mine_pairs"
def mine_pairs(probability, starts, occluded, labels, roll_out, sure, most, each, share, rng):
    """A training set of the pairs whose labels are known, and of mined ones.

    probability: (P,) the network's predictions, all different. starts: (P,)
    index of the frame at which each pair begins. occluded: (P,) True where a
    pair is far and occluded. labels: (P,) 1, 0, or nan where a pair has not
    been rolled out. roll_out: function that takes indices (M,) of pairs and
    returns labels (M,). sure: only pairs with a greater probability are mined.
    most, each: hard negatives at most, in all and of one start. share: of the
    mined pairs in the weight of all, less than 1. rng: np.random.Generator. At
    least one label is known.
    Returns three arrays (M,): the indices of the pairs, each once and in any
    order, their labels and their weights.
    """
    ### BEGIN SOLUTION
    known = ~np.isnan(labels)
    new = ~known & (probability > sure)
    negatives, taken = [], {}
    for pair in np.argsort(-probability):
        count = taken.get(starts[pair], 0)
        if new[pair] and occluded[pair] and count < each and len(negatives) < most:
            negatives.append(pair)
            taken[starts[pair]] = count + 1
    drawn = rng.permutation(np.flatnonzero(new & ~occluded))[: len(negatives)]
    easy, mined = np.flatnonzero(known), np.array([*negatives, *drawn], dtype=int)
    found = labels.copy()
    found[negatives] = 0.0
    found[drawn] = roll_out(drawn)
    weight = share / (1 - share) * len(easy) / max(len(mined), 1)
    pairs = np.concatenate([easy, mined])
    return pairs, found[pairs], np.where(known[pairs], 1.0, weight)
    ### END SOLUTION


# %%
mine_pairs = check_mine_pairs.use(mine_pairs)

# %% [markdown]
# Now the pool of the apartment and the maze, your training set of it, and a second quick network, trained on it from the same initial weights (about 6 s). Both networks are then queried for all pairs of 45 frames of the *office*, which neither has seen. **Predict:** how many far, occluded pairs of the office will each be sure of? And will the second be worse on the 150 ordinary pairs of the office?


# %% hidden=true
# Take all pairs of 45 frames in three buildings, and their features
def all_pairs(name, count=45):
    """All pairs of some frames of a building, with their features."""
    world, paths_there = driven[name]["recorded"], driven[name]["paths"]
    chosen = np.linspace(0, len(world.poses) - 1, count).round().astype(int)
    here, there = (grid.ravel() for grid in np.meshgrid(chosen, chosen, indexing="ij"))
    here, there = here[here != there], there[here != there]
    pairs = reachability_pairs(world, paths_there, world.poses[here], there)
    kept = pairs.far_and_occluded | (pairs.geodesic < LONGEST)  # the others take long to roll out
    pairs, here, there = pairs.subset(kept), here[kept], there[kept]
    seen = waypoints.encode(Simulation(world.scene, world.poses[chosen]).observe())
    targets = encoded(waypoints, world, chosen).encoded
    rows, columns = np.searchsorted(chosen, here), np.searchsorted(chosen, there)
    with torch.no_grad():
        features = waypoints.network.encoder.compare(seen[rows], targets[columns]).flatten(1)
    return pairs, features, here


queried = {name: all_pairs(name) for name in tqdm((*TRAIN, *TEST), "buildings")}


# %% hidden=true
# Query the quick network for these pairs, mine, and train again
def quick_logits(network, features):
    """The logits of a quick network, (N,)."""
    with torch.no_grad():
        return network(features)[:, 0].double().numpy()


pool = torch.cat([x, *(queried[name][1] for name in TRAIN)])
easy = len(x)
sizes = [easy, *(len(queried[name][0]) for name in TRAIN)]
building_of = np.repeat([-1, 0, 1], sizes)
within = np.concatenate([np.arange(size) for size in sizes])
labels = np.where(building_of < 0, np.pad(y.double().numpy(), (0, len(pool) - easy)), np.nan)
occluded = np.concatenate(
    [np.zeros(easy, dtype=bool), *(queried[name][0].far_and_occluded for name in TRAIN)]
)
begins = np.concatenate(
    [-1 - np.arange(easy), *(1e6 * i + queried[n][2] for i, n in enumerate(TRAIN))]
)


def roll_out_pool(pairs):
    """Labels of pairs of the pool that are rolled out."""
    found = np.zeros(len(pairs))
    for i, name in enumerate(TRAIN):
        mine = building_of[pairs] == i
        if mine.any():
            chosen = queried[name][0].subset(within[pairs[mine]])
            rollouts, _ = roll_out(driven[name]["recorded"], chosen, visual_policy)
            found[mine] = rollouts.reached
    if len(pairs):
        print(f"{len(pairs)} confident pairs rolled out, {found.mean():.0%} arrive")
    return found


chosen, chosen_labels, chosen_weights = mine_pairs(
    sigmoid(quick_logits(quick, pool)),
    begins.astype(int),
    occluded,
    labels,
    roll_out_pool,
    sure=0.5,
    most=60,
    each=3,
    share=0.4,
    rng=np.random.default_rng(0),
)
added = np.isnan(labels[chosen])
print(f"{(~added).sum()} easy pairs, {(added & occluded[chosen]).sum()} hard negatives")
torch.manual_seed(0)
mined = nn.Sequential(nn.Linear(x.shape[1], 64), nn.ReLU(), nn.Linear(64, 1))
optimizer = torch.optim.Adam(mined.parameters(), 1e-3)
targets, weights = torch.from_numpy(chosen_labels).float(), torch.from_numpy(chosen_weights).float()
for _ in range(301):
    z = mined(pool[chosen])[:, 0]
    loss = functional.binary_cross_entropy_with_logits(z, targets, weight=weights)
    optimizer.zero_grad()
    loss.backward()
    optimizer.step()

lines = []
office, office_features, _ = queried["office"]
reached = buildings["office"]["labels"]
for name, network in (("300 easy pairs", quick), ("easy and mined pairs", mined)):
    far = sigmoid(quick_logits(network, office_features))[office.far_and_occluded]
    ordinary = quick_logits(network, features["office"])
    loss = reach_loss(ordinary, reached, np.ones(len(reached)))
    lines.append([name, (far > 0.5).sum(), (far > 0.9).sum(), auc(ordinary, reached), loss])
headings = {"trained on": "", "above 0.5": ",d", "above 0.9": ",d", "AUC": ".3f", "log loss": ".3f"}
best = {"above 0.5": min, "above 0.9": min, "AUC": max, "log loss": min}
words = f"the office: {office.far_and_occluded.sum():,} far, occluded pairs, and {len(reached)} rollouts"
table(headings, lines, best, words)

# %% [markdown]
# <details><summary>What did mining change?</summary>
# The second network is sure of far fewer look-alikes in a building that it has never seen, above 0.5 as well as above 0.9: less than half as many. On the ordinary pairs both are about as good; differences of two hundredths in the AUC mean nothing with 150 rollouts. Sixty hard negatives from two buildings do not make it immune: with about a million pairs to query, one look-alike in thirty above 0.9 is still a disaster, and the library's network was trained on tens of thousands of mined pairs. The confident pairs keep it from
# learning that whatever looks good is a trap: about one in three of them does arrive.
# </details>
#
# So the question "is it calibrated?" has at least two answers: for pairs like those of exercise 1, and for *the pairs that a map would choose*. We can measure the second too: of all the pairs above that are not simply neighbours on one trajectory, take those with RE > 0.9, roll out up to 40 of them, and count. **Predict** what share arrives; RE's mean is the share that it expects.

# %% hidden=true
# Roll out confident pairs that are not neighbours
same = recorded.first[rows] == recorded.first[columns]
neighbours = same & (np.abs(recorded.arc[rows] - recorded.arc[columns]) < 3.0)
chosen = np.flatnonzero((probability > 0.9) & ~neighbours)
chosen = np.sort(np.random.default_rng(0).permutation(chosen)[:40])
edges = queries.subset(chosen)
arrivals = roll_out(recorded, edges, visual_policy)[0].reached
print(
    f"{len(edges)} pairs with RE > 0.9, not neighbours: RE expects {probability[chosen].mean():.1%}, {arrivals.mean():.1%} arrive"
)
sure = probability[chosen] > 0.99
if sure.any():
    print(f"{sure.sum()} of them with RE > 0.99: {arrivals[sure].mean():.1%} arrive")

# %% [markdown]
# <details><summary>Fewer arrive than RE expects, although it is calibrated. Why?</summary>
# It was calibrated on pairs whose views overlap, most of which succeed. Here it was queried for thousands of pairs, nearly all of them unreachable, and we selected those with high predictions: good pairs, and the few unreachable ones that happen to look good. The more unreachable pairs are queried, the larger their share among the selected. Near 0.99 there are hardly any left. The
# paper builds its maps with that threshold (IV-C.1; it gives no reason), and here you see why we will not read RE = 0.9 as "nine of ten" when a map has chosen the pair.
# </details>
#
# ## 6 · Slide the target along a trajectory
#
# This is the longest trajectory of the apartment. The car starts on it, and you slide the target along it, from 1 m behind to 6 m ahead; with the second slider you turn the car at its start. The curve is RE for every target; the square is the actual outcome: every position of the sliders was rolled out beforehand (about 4 s).
#
# **Predict, then move the sliders.** Where will RE fall: gradually with the distance, or at certain places? Which ones? And what happens to the curve when the car is turned by 60°, or by 120°?

# %% hidden=true
# Drive to every target from every start heading, then connect the sliders
lengths = recorded.arc[recorded.last] - recorded.arc[recorded.first]
longest = int(lengths.argmax())
begin = recorded.frame_at(np.array([recorded.first[longest]]), np.array([3.0]))
metres_ahead = np.arange(-1.0, 6.01, 0.25)
along = recorded.frame_at(np.repeat(begin, len(metres_ahead)), metres_ahead)
prepared = encoded(reachability, recorded, along)


TURNS = np.arange(-120, 121, 60)
driven = np.arange(0, len(along), 2)  # every half metre
headed = {
    turned: compose(recorded.poses[begin[0]], [0.0, 0.0, np.deg2rad(turned)])
    for turned in TURNS.tolist()
}
predictions = {
    turned: reachability.probability(
        Simulation(scene, np.repeat(pose[None], len(along), axis=0)).observe(), prepared
    )
    for turned, pose in headed.items()
}
pairs = reachability_pairs(
    recorded,
    paths,
    np.repeat(np.array(list(headed.values())), len(driven), axis=0),
    np.tile(along[driven], len(TURNS)),
)
rollouts, _ = roll_out(recorded, pairs, visual_policy)


def slide(metres_to_the_target, turned_by_degrees):
    """Map, images and curve for one target."""
    target = int(np.abs(metres_ahead - metres_to_the_target).argmin())
    pose, probability = headed[turned_by_degrees], predictions[turned_by_degrees]
    row = list(headed).index(turned_by_degrees) * len(driven) + target // 2
    track = rollouts.poses[: round(rollouts.seconds[row] / STEP) + 1, row]
    reached = bool(rollouts.reached[row])
    picture, goal = view.base.copy(), recorded.poses[along[target]]
    view.polyline(picture, recorded.poses[along[0] : along[-1] + 1, :2], colours.PATH, 2)
    draw_cells(view, picture, recorded.poses[along], probability, 0.16, 1.0)
    draw_target(view, picture, goal)
    view.polyline(picture, track[:, :2], colours.TRACK, 3)
    view.robot(picture, pose, car.footprint)
    map_part = closeup(view, picture, recorded.poses[along, :2], 1.1)
    images = pictured_pair(*people_camera.look(scene, np.array([pose, goal]))[0], 300)
    side = stacked(
        [images, along_trajectory(metres_ahead, probability, target, reached)], width=330
    )
    gap = np.linalg.norm(track[:, :2] - goal[:2], axis=1).min()
    joint = "and" if reached == (probability[target] >= 0.5) else "but"
    ending = "the car arrived" if reached else f"the car came no nearer than {gap:.2f} m"
    return side_by_side([map_part, side]), f"RE {probability[target]:.2f}, {joint} {ending}"


sliders(
    slide,
    {"metres_to_the_target": "path to the target, m", "turned_by_degrees": "turned by, degrees"},
    metres_to_the_target=(-1.0, 6.0, 0.5, 3.0),
    turned_by_degrees=(-120, 120, 60, 0),
)

# %% [markdown]
# <details><summary>What did you find?</summary>
# RE stays high as long as the target, or the path to it, can be seen; it falls where the trajectory turns a corner or passes through a door, and not at a certain number of metres. Turned to the side, the car sees something else, and many targets that were certain become doubtful: reachability belongs to a <i>pose</i>, not to a position. Where RE is near one half, some rollouts arrive and others do not.
# Notebook 04 uses exactly this curve: as long as RE stays high for <i>all</i> targets up to a frame, the frames between can be discarded.
# </details>
#
# ## 7 · How it fails
#
# RE fails in two ways: it is confident about a target that is then not reached, or it predicts failure for one that is. From the four buildings, these are the three worst of each kind. **Before you unfold the causes:** look at the two images of each and say why *you* would have predicted the same.


# %% hidden=true
# Find the worst mistakes, and draw them
def traits_of(building):
    """What could mislead RE, for each pair of a building."""
    drawn, goals = building["pairs"], building["goals"]
    offset, caster = to_local(drawn.starts, goals[:, :2]), building["recorded"].scene.caster
    angle = np.abs(np.rad2deg(np.arctan2(offset[:, 1], offset[:, 0])))
    room = building["recorded"].scene.clearance
    room = np.minimum(room.at(drawn.starts[:, :2]), room.at(goals[:, :2]))
    return {
        "behind a wall": ~caster.sees(drawn.starts[:, :2], goals[:, :2]),
        "little overlap": drawn.overlap.min(axis=1) < 0.2,
        "behind the car": angle > 135,
        "beside the car": (angle > 45) & (angle <= 135) & (np.abs(offset[:, 1]) > 0.6),
        "turned away": np.abs(relative(drawn.starts, goals)[:, 2]) > np.pi / 2,
        "tight place": room < 0.3,
    }


cases = []
for name, building in buildings.items():
    predicted, traits = reachability.calibration(building["logits"]), traits_of(building)
    for i, (p, label) in enumerate(zip(predicted, building["labels"], strict=True)):
        case = {"predicted": p, "label": label, "closest": building["gaps"][:, i].min()}
        case |= {"name": name, "i": i, "traits": {key: has[i] for key, has in traits.items()}}
        cases.append(case)
too_high = sorted((c for c in cases if c["label"] == 0), key=lambda c: -c["predicted"])[:3]
too_low = sorted((c for c in cases if c["label"] == 1), key=lambda c: c["predicted"])[:3]
worst_in = {case["name"] for case in (*too_high, *too_low)}
plans = {name: PlanView(buildings[name]["recorded"].scene, 1600, 1600) for name in worst_in}


def case_picture(case):
    """The map with the track, both images, and what is special about the pair."""
    building, plan = buildings[case["name"]], plans[case["name"]]
    rollouts, start = building["rollouts"], building["pairs"].starts[case["i"]]
    goal = building["goals"][case["i"]]
    track = rollouts.poses[: round(rollouts.seconds[case["i"]] / STEP) + 1, case["i"]]
    picture = plan.base.copy()
    draw_target(plan, picture, goal)
    plan.polyline(picture, track[:, :2], colours.TRACK, 3)
    plan.robot(picture, start, car.footprint)
    middle = (start[:2] + goal[:2]) / 2
    corners = np.concatenate([track[:, :2], [middle - 0.7, middle + 0.7]])
    above = side_by_side([closeup(plan, picture, corners, 0.8, square=True)], height=300)
    images = people_camera.look(building["recorded"].scene, np.array([start, goal]))[0]
    ending = "arrived" if case["label"] else f"no nearer than {case['closest']:.2f} m"
    special = [key for key, has in case["traits"].items() if has] or ["nothing special"]
    titles = [f"RE {case['predicted']:.2f}: {ending}", ", ".join(special)]
    return stacked([above, pictured_pair(*images, 300)], titles, gap=4)


for group in (too_high, too_low):
    display(show(side_by_side([case_picture(case) for case in group])))

# %% [markdown]
# Three cases are anecdotes. What do the mistakes have in common? The labels above the images name six conditions that could mislead RE. For all 600 pairs we compare its mean prediction with the share that arrived, with and without each of them. **Predict:** where will the two differ most?

# %% hidden=true
# Compare prediction and outcome with and without each condition
predicted = np.array([case["predicted"] for case in cases])
reached = np.array([case["label"] for case in cases])
lines = []
for trait in cases[0]["traits"]:
    has = np.array([case["traits"][trait] for case in cases])
    values = [v for s in (has, ~has) for v in (predicted[s].mean(), reached[s].mean(), s.sum())]
    lines.append([trait, *values])
headings = {"": ""}
for group in ("with it", "without"):
    headings |= {f"{group}: RE": ".2f", f"{group}: arrive": ".2f", f"{group}: pairs": "d"}
display(table(headings, lines))
closest = np.array([case["closest"] for case in cases])[reached == 0]
print(
    f"{len(closest)} did not arrive; {np.mean(closest < 0.5):.0%} of them came within half a metre"
)

# %% [markdown]
# <details><summary>What are the causes?</summary>
# Of the three where RE was too confident, look first at the maps. The target is less than a metre away, behind the car beside a wall in the first two, and beside the car in the third, as in section 1. The car moves only a little and never comes near. A large part of the two images is nearly the same; what tells the places apart is at the edges, or a small shift. In the three where RE was too low the target lies beside the car or behind it, or is turned away: the table below shows that such pairs are harder than others. But here the path was easy all the same.
#
# In the table RE's mean prediction follows the share that arrives from line to line: it has learnt that targets behind or beside the car, with little overlap or turned away are harder. (Differences of five points, or ten where there are few pairs, mean nothing.) A tight place causes failures too seldom to show in the mean. For targets beside the car it is too optimistic, and where a wall stands between by far: the two views share something around a corner, the path is longer than it seems, and such pairs are rare in its training data.
# </details>
# <details><summary>Which of these could a better network fix, and which not?</summary>
# The wall between could be learnt from more examples of it. What neither image shows could not. (The laser's field of view is twice as wide, and our car has one. RE for the laser is one of the lines of the results page.) And the last centimetres are chance: at the edge of the circle one of them decides, and the right prediction there is a number between 0 and 1.
# </details>
#
# ### Find the bug
#
# A colleague needs RE between all pairs of frames of a trajectory, "and a distance is the same in both directions, so half of the table is enough". It runs twice as fast and without an error. Look at the two tables, and decide what is wrong before you unfold the answer. Rows are the car's position, columns the target's, both along the trajectory.

# %% hidden=true
# Query RE between all pairs of 36 frames, and draw both tables
stretch = recorded.frame_at(np.repeat(begin, 36), np.linspace(-1.0, 8.0, 36))
pairs = np.stack(np.meshgrid(stretch, stretch, indexing="ij"), axis=-1).reshape(-1, 2)
all_to_all = reachability.calibration(
    all_logits(reachability, recorded, recorded.poses[pairs[:, 0]], pairs[:, 1])
).reshape(36, 36)


def colleagues(values):
    """Only the upper half is queried; the lower half mirrors it."""
    upper = np.triu(values)
    return upper + np.triu(values, 1).T


figure, axes = chart(9.0, 4.4, columns=2)
for axis, values, name in zip(
    axes, (colleagues(all_to_all), all_to_all), ("the colleague's", "all queried"), strict=True
):
    axis.imshow(values, vmin=0, vmax=1, cmap="cividis", extent=(-1, 8, 8, -1))
    axis.set(xlabel="target, m along the trajectory", ylabel="car, m along the trajectory")
    axis.set(title=name)
    axis.grid(visible=False)
gap = np.subtract.outer(-np.arange(36), -np.arange(36)) * 9 / 35  # metres to the target
lines = []
for low, high in ((0.5, 1.5), (1.5, 3.0), (3.0, 5.0)):
    means = [all_to_all[(g >= low) & (g < high)].mean() for g in (gap, -gap)]
    lines.append([f"{low} to {high} m", *means])
display(table({"distance": "", "mean RE, ahead": ".2f", "mean RE, behind": ".2f"}, lines))
show(from_figure(figure))

# %% [markdown]
# <details><summary>Answer</summary>
# RE is not a distance. From A to B the car drives forwards and sees where it is going; from B to A the same images lie behind it, and it would have to reverse towards what it does not see. So $\mathrm{RE}(a, b) \ne \mathrm{RE}(b, a)$, and the edges of the map are <i>directed</i>. In the colleague's table every edge works in both directions. Nothing crashes; the robot just plans paths on which it must
# reverse for metres. It is a typical mistake: reachability is not proximity.
# </details>
#
# ## 8 · Calibration on unseen worlds
#
# The results page. Every estimator predicts the same pairs in unseen worlds, and all of them are rolled out. **k0, k2, k5** and **laser** are RE for controllers with that context, each evaluated on the outcomes of its own controller. They are bracketed by three that are not RE: **image** only compares the two images, **sptm** was trained to classify whether two images were taken at about the same *time* (N. Savinov, A. Dosovitskiy and V. Koltun, [*Semi-Parametric Topological Memory for Navigation*](https://arxiv.org/abs/1803.00653), ICLR 2018: reachability by proxy), and **geometry** is an oracle that gets no image
# but distance, bearing, overlaps, line of sight and clearance from the map, and was fitted to the outcomes of k2 in training worlds. The paper has no such figure for RE; its Fig. 9 compares the probability of whole *paths* with their success rate, and notebook 06 reproduces it. The diagram below is its counterpart for single edges.
#
# **Predict:** will more context make RE more accurate? Can any RE be better than geometry? And which estimators are sure of far look-alikes?

# %% hidden=true
# Draw the reliability diagrams of the results page
report = load_result("calibration")
estimators = {line["estimator"]: line for line in report.rows}
shown = [name for name in ("k2", "k5", "sptm", "image", "geometry") if name in estimators]
figure, (axis,) = chart(6.4, 4.8)
palette = (colours.ROBOT, colours.TRACK, colours.LASER, colours.PATH, colours.GOAL)
for name, tone in zip(shown, palette, strict=False):
    line = estimators[name]
    draw_reliability(
        axis, line["predicted"], line["measured"], color=colours.unit(tone), label=name
    )
axis.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
show(from_figure(figure))

# %% hidden=true
# Show the results page as a table
columns = {
    "AUC": ("auc", ".3f", max),
    "Brier": ("brier", ".3f", min),
    "ECE": ("ece", ".3f", min),
    "precision, mix": ("precision_mix", ".3f", max),
    "consecutive": ("precision_consecutive", ".3f", max),
    "map": ("precision_map", ".3f", max),
    "far above 0.9": ("far_above_09", ".3%", None),
}
lines = []
for name, line in estimators.items():
    values = [line[key] for key, _, _ in columns.values()]
    wormholes = None if values[-1] is None else 1e6 * values[-1]
    lines.append([name, *values, wormholes])
pairs = f"{estimators['k2']['pairs']:,} pairs whose views overlap"
headings = {"estimator": "", **{name: form for name, (_, form, _) in columns.items()}}
headings["wormholes in a million pairs"] = ",.0f"
best = {name: choose for name, (_, _, choose) in columns.items() if choose}
display(table(headings, lines, best, f"{len(report.worlds)} unseen worlds; {pairs}"))
print(*report.notes, sep="\n")

# %% [markdown]
# *Precision* is the share that arrives of the pairs with RE > 0.99, the threshold that the paper uses for its maps. It is measured among the random pairs (*mix*), from one **anchor**, a frame that sparsification keeps (notebook 04), to the next (*consecutive*), and among all pairs of frames of a world, as a map would choose them (*map*). The last column is what a map of 1,000 vertices gets: it queries a million pairs, and far look-alikes above a threshold of 0.9 become [[wormhole]]s. (To run it again: `.venv/bin/python -m tutorial_lib experiment calibration --family all`.)
#
# <details><summary>Why is there no number from the paper beside ours?</summary>
# It gives none for RE itself: it shows that maps built with RE work (its Table II), and that path probabilities agree with success rates (Fig. 9). We can measure RE alone because our rollouts cost milliseconds, and because in simulation a car can be reset to the same pose a thousand times. Same idea, easier world: what is hard for RE in real buildings, such as glass, changing light and people, does not occur in ours.
# </details>
# <details><summary>Systems have been built on image similarity and on time between images. What do these two lack?</summary>
# Both answer another question. Two images can be alike, or close in time, and yet the second be unreachable from the first for this car: behind it, beside it, around a corner. And two images can be quite different although the path is easy: along a corridor. Neither score is a probability, either; calibration could fix the values, but not the ranking.
# </details>
# <details><summary>What does context change?</summary>
# It makes RE more accurate: the more context, the higher the AUC, and no RE has a higher one than geometry. It hardly matters for far look-alikes here: the share above 0.9 is about as small with any context. The laser sees no colours, and is sure of far more of them.
# </details>
# <details><summary>The three precisions of one estimator differ. Which one is its precision?</summary>
# All of them. Precision is a property of the estimator <i>and of the distribution of pairs</i>. Consecutive anchors are easy pairs. Among all pairs of a building nearly all are unreachable, and of most estimators those above 0.99 contain more mistakes there. Notebook 05 looks at the last one, since it decides how many wormholes a map has.
# </details>
#
# ## Optional extras
#
# - **Extra 1.** Draw the maps of section 1 for starts that are turned by 45°. Where does the blue area go?
# - **Extra 2.** `ReachabilityNetwork("reach_k5")` belongs to `WaypointNetwork("waypoint_k5")`. Evaluate it on the outcomes of k = 2: how large is its ECE, and in which direction is it wrong?
# - **Extra 3.** Fit temperature *and* offset, $\sigma(z/T + b)$. What does the offset correct that the temperature cannot?
# - **Extra 4.** Recalibrate RE for the grid of section 1: fit a temperature on one target's grid, and test it on the other one's. Does it work? What training data would both networks need?
#
# ## What to remember
#
# - $\mathrm{RE} = P(\mathcal C \text{ reaches the target})$. It depends on a controller, a pose and an image, and it is not a distance: it has a direction, and it stops at walls.
# - It is learnt from outcomes alone. What counts as an outcome, time limit and collisions included, decides what is learnt.
# - A proper loss is minimised by the frequency. Whether the prediction is right in a new building has to be measured: sort, bin, compare.
# - Calibration changes the values and never the ranking. It holds for pairs like those on which it was fitted.
# - A map queries a million pairs. Rare mistakes become wormholes, and have to be mined: hard negatives.
#
# **Read next:** the paper, III-D (*Sparsifying a Trajectory*), and then notebook 04, which discards every frame that RE does not need. On calibration: the paper of C. Guo et al. that section 4 links to.
