# %% [markdown]
# # 03 · Reachability
#
# **80 minutes.** You need notebook 02: the controller $\mathcal C$ that drives to a picture. A little probability helps: what it means that something happens seven times out of ten. Nothing else is required.
#
# After this notebook you can
#
# - say what *reachable* means, and why it is a property of the controller and not of the distance;
# - turn drives into labels, and write the loss that makes a network say probabilities;
# - find out whether a probability is right, and mend it if it is not;
# - explain why an estimator that is nearly always right is still not good enough to build a map with.
#
# There are four exercises with hints behind folds. When your function passes its check, **the cells below use it**; until then they use the library's.
#
# We follow X. Meng, N. Ratliff, Y. Xiang and D. Fox, *Scaling Local Control to Large-Scale Topological Navigation* (ICRA 2020), from here on "the paper".

# %%
from functools import lru_cache

import numpy as np
import torch
from IPython.display import display
from torch import nn
from torch.nn import functional

from tutorial_lib.checks.nb03 import (
    check_fit_temperature,
    check_reach_loss,
    check_reliability_diagram,
    check_rollout_labels,
)
from tutorial_lib.driving.control.composed import ComposedController
from tutorial_lib.driving.control.rmp import RMPController
from tutorial_lib.driving.data.demonstrations import demonstrate
from tutorial_lib.driving.data.reachability_pairs import draw_reachability_pairs, reachability_pairs
from tutorial_lib.driving.data.recorded_world import RecordedWorld
from tutorial_lib.driving.geodesics import GridPaths
from tutorial_lib.driving.rollouts import drive
from tutorial_lib.experiments.common.results import load_result
from tutorial_lib.geometry import compose, relative, to_local, to_world
from tutorial_lib.learning.calibration import auc, brier, sigmoid
from tutorial_lib.learning.estimators import ReachabilityNetwork, WaypointNetwork
from tutorial_lib.learning.mining import all_logits
from tutorial_lib.learning.policies import by_waypoints, encoded
from tutorial_lib.learning.weights import load_card
from tutorial_lib.viz.canvas import colours
from tutorial_lib.viz.canvas.plan_view import PlanView
from tutorial_lib.viz.canvas.probabilities import draw_cells
from tutorial_lib.viz.figures.charts import chart, from_figure
from tutorial_lib.viz.figures.closeups import closeup
from tutorial_lib.viz.figures.panels import camera_picture, side_by_side, stacked
from tutorial_lib.viz.figures.reachability import (
    along_trajectory,
    draw_reliability,
    pictured_pair,
    probability_bar,
)
from tutorial_lib.viz.notebook.display import show
from tutorial_lib.viz.notebook.widgets import sliders
from tutorial_lib.world.bodies import BicycleCar
from tutorial_lib.world.placing import is_free
from tutorial_lib.world.sensors import Camera
from tutorial_lib.world.simulation import STEP, Simulation
from tutorial_lib.world.worlds import local_world, scene_of

torch.set_num_threads(1)  # the networks are small: a second thread would mostly wait

# %% [markdown]
# ## 1 · What will the controller reach?
#
# The controller of notebook 02 is shown a picture and drives there. It does that well, and it never knows when it will not. Somebody has to know: whoever chooses its next picture.
#
# Which pictures can it reach? Those nearby, one might say. But a place one metre away may be behind a wall, and a place six metres away at the other end of an empty corridor. The paper says it without distances (III-C):
#
# $$ \mathrm{RE}(o_\text{current},\, \hat o_\text{target}) \;=\; P\bigl(\text{reach} \mid o_\text{current},\, \hat o_\text{target},\, \mathcal C\bigr) . $$
#
# RE is the **reachability estimator**, and it is asked about *this controller*: put $\mathcal C$ at the place where it sees $o_\text{current}$, show it the target $\hat o_\text{target}$ with its context, and let it drive. RE says how probable it is that it arrives.
#
# In simulation we can simply try. Below is an apartment in which no network was trained, with 24 drives recorded in it, and two frames of those drives as targets. From a grid of places around each target we will send a car: *all with the same heading as the target*, so that the only difference is where they start.

# %%
HOME = local_world(10_036)
scene = scene_of(HOME)
paths = GridPaths(scene.clearance)
recorded = RecordedWorld(scene, demonstrate(HOME, scene, 24, seed=0))
view = PlanView(scene, 1620, 1060)  # 68 pixels a metre: closer looks are cut out of it
car = BicycleCar()
people_camera = Camera(rows=64)  # the same picture as the network's 16 rows, for people
waypoints = WaypointNetwork("waypoint_k2")  # C_WP, with k = 2
reachability = ReachabilityNetwork("reach_k2")  # RE of the C that this one leads


def frame_near(pose):
    """The recorded frame, away from the ends of its drive, that is most like a pose."""
    frames = np.arange(len(recorded.poses))
    gap = np.linalg.norm(recorded.poses[:, :2] - pose[:2], axis=1)
    turn = np.abs(relative(np.array([0, 0, pose[2]]), recorded.poses)[:, 2])
    inside = (frames - recorded.first > 8) & (recorded.last - frames > 8)
    return int(np.where(inside, gap + 0.5 * turn, np.inf).argmin())


def starts_around(target, reach=2.1, step=0.3):
    """ReachabilityPairs to a frame from all free places of a grid around it, with the frame's heading."""
    goal, aside = recorded.poses[target], np.arange(-reach, reach + step / 2, step)
    places = goal[:2] + np.stack(np.meshgrid(aside, aside), axis=-1).reshape(-1, 2)
    poses = np.column_stack([places, np.full(len(places), goal[2])])
    poses = poses[is_free(scene, car, poses)]
    return reachability_pairs(recorded, paths, poses, np.full(len(poses), target))


def draw_target(view, picture, goal):
    """Place and heading of a target."""
    tip = to_world(goal, [0.7, 0.0])
    view.polyline(picture, [goal[:2], tip], colours.GOAL, 4)
    view.goal(picture, goal[:2])
    view.arrow(picture, [*tip, goal[2]], colours.GOAL, 8)


def map_around(target, errands=None, probability=None):
    """The map around a target with circles of 1 m and 2 m; cells are coloured by a probability."""
    goal, picture = recorded.poses[target], view.base.copy()
    if errands is not None:
        draw_cells(view, picture, errands.starts, probability, 0.3)
    turn = np.linspace(0, 2 * np.pi, 73)
    for radius in (1.0, 2.0):
        circle = radius * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        view.polyline(picture, goal[:2] + circle, colours.INK, 1)
    draw_target(view, picture, goal)
    return closeup(view, picture, np.array([goal[:2] - 2.1, goal[:2] + 2.1]), 0.25)


TARGETS = {
    "in a corridor": frame_near([-8.0, 6.0, 0.0]),
    "beyond a doorway": frame_near([-4.2, -1.0, -1.6]),
}
errands = {name: starts_around(target) for name, target in TARGETS.items()}
panels = []
for target in TARGETS.values():
    picture = people_camera.look(scene, recorded.poses[[target]])[0][0]
    near = map_around(target)
    panels.append(stacked([near, camera_picture(picture, near.shape[1])], gap=6))
show(side_by_side(panels, [f"target {name}" for name in TARGETS]))

# %% [markdown]
# The green arrow is the heading, of the target and of every start; the circles are 1 m and 2 m away. **Predict** for both targets: from which places will the car arrive? From all places within one metre? From places *ahead* of the target, so that it has to come back? From places *beside* it? From the other side of a wall?
#
# Then run the cell: a car is sent from every place, led by what it sees. To arrive means to come within 0.30 m, in time and without touching anything. On the right is what RE said beforehand, from the two pictures alone.


# %%
def send(recorded, errands, pilot):
    """Send a car on every errand: the drives, and which car touched something when, (T, N)."""
    simulation, touched = Simulation(recorded.scene, errands.starts), []
    drives = drive(
        simulation,
        pilot(recorded, errands.targets),
        recorded.poses[errands.targets, :2],
        errands.limit,
        record=lambda world, robots, actions: touched.append(world.touching),
        settle=True,
    )
    return drives, np.array([*touched, simulation.touching])


by_sight = by_waypoints(waypoints)
arrived, claimed, rows = {}, {}, []
for name, target in TARGETS.items():
    trip = errands[name]
    arrived[name] = send(recorded, trip, by_sight)[0].reached
    claimed[name] = reachability.calibration(
        all_logits(reachability, recorded, trip.starts, trip.targets)
    )
    maps = [map_around(target, trip, values) for values in (arrived[name], claimed[name])]
    rows.append(side_by_side(maps, [f"{name}: what happened", "what RE said"]))
show(stacked([*rows, probability_bar("does not arrive", "arrives")]))

# %%
there = np.concatenate([recorded.poses[trip.targets] for trip in errands.values()])
starts = np.concatenate([trip.starts for trip in errands.values()])
came, said = np.concatenate(list(arrived.values())), np.concatenate(list(claimed.values()))
offset = to_local(starts, there[:, :2])
far = np.linalg.norm(offset, axis=1)
angle = np.abs(np.rad2deg(np.arctan2(offset[:, 1], offset[:, 0])))
in_sight = scene.caster.sees(starts[:, :2], there[:, :2])
where = {
    "target ahead": in_sight & (angle < 45),
    "target behind": in_sight & (angle > 135),
    "target beside": in_sight & (angle >= 45) & (angle <= 135),
    "a wall between": ~in_sight,
}
print("share of the cars that arrive, by metres to the target (and RE's mean)")
rings = [(0.3, 1.0), (1.0, 1.6), (1.6, 2.2)]
print(f"{'':16s}" + "".join(f"{f'{low} to {high} m':>22s}" for low, high in rings))
for name, chosen in where.items():
    cells = []
    for low, high in rings:
        some = chosen & (far >= low) & (far < high)
        cells.append("-")
        if some.any():
            cells[-1] = f"{came[some].mean():.0%} of {some.sum()} ({said[some].mean():.2f})"
    print(f"{name:16s}" + "".join(f"{cell:>22s}" for cell in cells))

# %% [markdown]
# <details><summary>What do you see?</summary>
# Read the table along a column: the distance is the same, and the outcome is not. A target <i>ahead</i> is reached from every distance shown. One <i>behind</i> is reached in reverse, but not from as far. A target <i>beside</i> the car is the hardest of those in sight, however near it is. And a wall decides by itself, unless there is a door near by: through the doorway the car arrives
# from a fan of places that see into the room.
#
# RE has the shape right: walls, doors, ahead and behind. But it is far too hopeful <i>beside</i> the target. Keep that in mind, we will come back to it.
# </details>
#
# ### A property of the controller
#
# Now the same starts, the same target beyond the doorway, and two other controllers. One is led by the same network, but its driver never reverses. The other one drives like $\mathcal C$, but is *told* where the target is: an oracle, which only the body and the clock can stop. **Predict** how the blue area changes.


# %%
def told_where(recorded, frames):
    """A pilot that knows the place of its target: an oracle."""
    goals, driver = recorded.poses[frames, :2], RMPController()

    def act(simulation, robots):
        places = to_local(simulation.poses[robots], goals[robots])
        return driver.act(simulation.observe(robots), places)

    return act


def only_forwards(recorded, frames):
    """C with a driver that never reverses."""
    never = 1e6  # what reversing costs, and the room it needs
    driver = RMPController(reverse_cost=never, go_on=never, begin=never)
    controller, targets = (
        ComposedController(waypoints, driver),
        encoded(waypoints, recorded, frames),
    )
    return lambda simulation, robots: controller.act(simulation.observe(robots), targets[robots])


name = "beyond a doorway"
trip = errands[name]
outcomes = {
    "never reverses": send(recorded, trip, only_forwards)[0].reached,
    "C": arrived[name],
    "told where it is": send(recorded, trip, told_where)[0].reached,
}
for who, reached in outcomes.items():
    print(f"{who}: arrives from {reached.sum()} of {len(trip)} places")
panels = [map_around(TARGETS[name], trip, reached) for reached in outcomes.values()]
show(side_by_side(panels, list(outcomes), height=300))

# %% [markdown]
# <details><summary>What follows?</summary>
# Three controllers, three different areas, and nothing about the places has changed. "Is it reachable?" has no answer until somebody says <i>by whom</i>. An estimator that was trained for one controller is wrong for another one; the paper trains one for each, and so do we. This is also why similarity of pictures, or time between frames, is only a
# stand-in for reachability: neither asks who is driving.
# </details>
# <details><summary>A target beside the car lies inside its turning circle. Is that why it is not reached?</summary>
# One would think so; but whoever is <i>told</i> where the target is gets there from beside as well, with the same body and in the same time. So it is not the body, it is the eyes. The next cell shows how they err.
# </details>

# %%
shift, told = [], []
for trip in errands.values():
    seen = Simulation(scene, trip.starts).observe()
    told.append(waypoints.predict(seen, encoded(waypoints, recorded, trip.targets))[0][:, 1])
    shift.append(to_local(trip.starts, recorded.poses[trip.targets, :2])[:, 1])
shift, told = np.abs(np.concatenate(shift)), np.abs(np.concatenate(told))
beside = where["target beside"]
for low, high in [(0.3, 0.6), (0.6, 1.0), (1.0, 1.4), (1.4, 1.8), (1.8, 2.4)]:
    some = beside & (shift >= low) & (shift < high)
    print(
        f"target beside, {shift[some].mean():.2f} m to the side: the first waypoint lies {told[some].mean():.2f} m "
        f"to the side; {came[some].mean():.0%} of {some.sum()} arrive"
    )

# %% [markdown]
# <details><summary>What happens there?</summary>
# $\mathcal C_{WP}$ does not believe that a target can be so far to the side. It learnt from starts beside a recorded drive, most of them less than half a metre aside, and so it says about the same of everything beyond. The car goes there, the pictures look nearly alike, it takes the place for the target and stops. RE has seldom met such starts either and does not know
# better. Both are good at the questions they were trained on, and this is another question.
# </details>
#
# ## 2 · Labels from drives
#
# RE is learnt from outcomes. Draw two places of the recorded drives at random (the paper: on the same drive with probability 0.6, on two drives otherwise; we move most starts a little aside), send $\mathcal C$ on the **errand** from the one to the other, and write down whether it arrives. Nobody has to say what makes a target hard.
#
# A car that circles for ten minutes and then stumbles over the target has not shown that it can reach it. So there is a time limit, from the length of the shortest way and the slowest speed that is tolerated (III-C; the 5 s are the authors' code's):
#
# $$ t_\text{max} = \frac{A^*(o_\text{current}, o_\text{target})}{v_\text{min}} + 5\ \text{s}, \qquad v_\text{min} = 0.3\ \text{m/s}. $$
#
# The label is 1 if there is a moment, at $t_\text{max}$ at the latest, at which the car is within 0.30 m of the target and has not touched anything up to then. What a car does *after* it has arrived does not count. Otherwise the label is 0.
#
# And a drive that touched something? The authors' code leaves such drives out of the data. Then RE never hears of them, and the places where the controller crashes are those of which it knows nothing. A robot that asks "will I get there?" wants to hear *no*. We count them: label 0.
#
# ### Exercise 1 · `rollout_labels` (medium, 10 minutes)
#
# <details><summary>Hint 1: concept</summary>Three things must hold at the same moment: near, in time, and clean so far. The label asks whether there is any such moment.</details>
# <details><summary>Hint 2: approach</summary>Make three tables (T, N) of true and false and join them with &. Time against limit: times[:, None] &lt;= limits makes a table of a column and a row. "Clean so far" is a running or: np.logical_or.accumulate(touched, axis=0) is true from the first touch on.</details>
# <details><summary>Hint 3: one line</summary>return (near &amp; in_time &amp; ~touched_so_far).any(axis=0).astype(float)</details>


# %% exercise="rollout_labels"
def rollout_labels(times, gaps, touched, geodesic):
    """Which drives count as reached.

    times: (T,) seconds since the start. gaps: (T, N) metres from each car to its target. touched: (T, N) whether a car
    touches something at that moment. geodesic: (N,) metres of the shortest way. Returns labels (N,), 1.0 or 0.0.
    """
    ### BEGIN SOLUTION
    near = gaps <= 0.30
    in_time = times[:, None] <= geodesic / 0.3 + 5.0
    touched_so_far = np.logical_or.accumulate(touched, axis=0)
    return (near & in_time & ~touched_so_far).any(axis=0).astype(float)
    ### END SOLUTION


# %%
rollout_labels = check_rollout_labels.use(rollout_labels)

# %% [markdown]
# Now we collect labels: in four buildings in which neither network was trained, up to 250 errands each. Only errands are drawn whose two pictures have at least a tenth in common, both ways, since about these one can learn something from the pictures. (What happens with the others is the subject of section 5.) **Predict:** what share arrives? And of those that do not, how
# many touch something?

# %%
SEEDS = {"apartment": 10_036, "office": 10_037, "maze": 10_038, "ring of corridors": 10_039}
lessons = {}
for number, (name, seed) in enumerate(SEEDS.items()):
    world = recorded
    if local_world(seed) != HOME:
        place = scene_of(local_world(seed))
        world = RecordedWorld(place, demonstrate(local_world(seed), place, 16, seed=0))
    ways = paths if world is recorded else GridPaths(world.scene.clearance)
    drawn = draw_reachability_pairs(world, ways, 120, np.random.default_rng(number))
    drawn = drawn.some(np.flatnonzero(drawn.seen)[:250])
    drives, touched = send(world, drawn, by_sight)
    goals = world.poses[drawn.targets]
    gaps = np.linalg.norm(drives.poses[:, :, :2] - goals[:, :2], axis=2)
    labels = rollout_labels(STEP * np.arange(len(gaps)), gaps, touched, drawn.geodesic)
    logits = all_logits(reachability, world, drawn.starts, drawn.targets)
    lessons[name] = {
        "recorded": world,
        "errands": drawn,
        "drives": drives,
        "goals": goals,
        "gaps": gaps,
        "labels": labels,
        "logits": logits,
    }
    crashed = (labels == 0) & touched.any(axis=0)
    print(
        f"{name:18s}{len(labels)} errands: {labels.mean():.0%} arrive, {1 - labels.mean() - crashed.mean():.0%} do not "
        f"in time, {crashed.mean():.0%} touch something; the library agrees on {np.mean(labels == drives.reached):.0%}"
    )

# %% [markdown]
# <details><summary>And what does it matter, then, how collisions are counted?</summary>
# For this controller nearly nothing: its driver feels walls by the laser and holds the car off, here as in the training worlds. That is worth knowing, and one can only know it by counting. With a driver that cuts corners, or with people about, it would decide what RE learns, as the next section shows.
# </details>
#
# ## 3 · The loss that makes a network say probabilities
#
# The network of RE is that of $\mathcal C_{WP}$ (III-C: "almost identical"), and it begins with the encoder that $\mathcal C_{WP}$ has learnt: finding things again in two pictures is what both need. In place of a waypoint it tells a **logit** $z$, any number, and $p = \sigma(z) = 1 / (1 + e^{-z})$ makes a probability of it. What is to be learnt is $y$: 1 reached, 0 not. The paper trains
# "with a binary classification loss", the cross-entropy
#
# $$ \ell(z, y) \;=\; -\,y \log \sigma(z) \;-\; (1-y) \log\bigl(1 - \sigma(z)\bigr) \;=\; \log\bigl(1 + e^{z}\bigr) - y\,z . $$
#
# The first form is how one thinks of it: pay $-\log$ of what you claimed for what then happened. The second is how to compute it. For $z = 1000$ the first takes the logarithm of 0. In the second `np.logaddexp(0, z)`, which is $\log(e^0 + e^z)$ for any $z$, does all that is delicate.
#
# The same loss serves for labels *between* 0 and 1. Our network, unlike the paper's, is also asked for the two overlaps of the pair: they are shares, known for every pair, and what can be seen of a target decides more than anything else whether it is reached. And pairs may have **weights** $w$; then the loss of many is $\sum w\,\ell / \sum w$.
#
# ### Exercise 2 · `reach_loss` (easy, 8 minutes)
#
# <details><summary>Hint 1: concept</summary>Stay with the logit. Whoever makes a probability of it first has lost it for large z: 1 − σ(40) is 0 in floating point.</details>
# <details><summary>Hint 2: approach</summary>One loss for each pair by the second form, and then their weighted mean: np.average has an argument weights.</details>
# <details><summary>Hint 3: one line</summary>np.logaddexp(0.0, logits) - labels * logits are the losses of all pairs.</details>


# %% exercise="reach_loss"
def reach_loss(logits, labels, weights):
    """The weighted mean of the cross-entropy.

    logits: (N,) any numbers. labels: (N,) from 0 to 1. weights: (N,) 0 or greater. Returns one number.
    """
    ### BEGIN SOLUTION
    each = np.logaddexp(0.0, logits) - labels * logits
    return np.average(each, weights=weights)
    ### END SOLUTION


# %%
reach_loss = check_reach_loss.use(reach_loss)

# %% [markdown]
# Why should this loss lead to a *probability*, when all that it ever sees are ones and zeros? A thought experiment: ten drives from the very same place to the very same target. Seven arrive, two run out of time, one touches the wall. The network sees the same two pictures ten times, so it must say the same $p$ for all ten.
#
# **Predict:** for which claim $p$ is the mean cross-entropy smallest? For which one, if the drive that touched the wall is dropped (weight 0)? And for which one if the loss were simply $|p - y|$?

# %%
ten = np.array([1.0] * 7 + [0.0] * 3)
claims = np.linspace(0.005, 0.995, 199)
claims_as_logits = np.log(claims / (1 - claims))
all_count, dropped = np.ones(10), np.array([1.0] * 9 + [0.0])
curves = {
    "cross-entropy": [reach_loss(np.full(10, z), ten, all_count) for z in claims_as_logits],
    "cross-entropy, one dropped": [
        reach_loss(np.full(10, z), ten, dropped) for z in claims_as_logits
    ],
    "absolute error": [np.abs(p - ten).mean() for p in claims],
}
figure, (axis,) = chart(8.0, 3.6)
tones = (colours.ROBOT, colours.TRACK, colours.LASER)
for (name, losses), tone in zip(curves.items(), tones, strict=True):
    best = int(np.argmin(losses))
    axis.plot(claims, losses, color=colours.unit(tone), label=f"{name}: best at {claims[best]:.3f}")
    axis.plot(claims[best], losses[best], "o", color=colours.unit(tone), markersize=9)
axis.set(xlabel="claim p", ylabel="mean loss of ten drives", xlim=(0, 1), ylim=(0.2, 1.6))
axis.legend(loc="upper center")
show(from_figure(figure))

# %% [markdown]
# <details><summary>What follows?</summary>
# The cross-entropy is smallest at 0.7, the share that arrives: a network that makes it as small as possible says how <i>often</i> it goes well. A loss with this property is called <i>proper</i>. With the crash dropped the best claim is 7 of 9, 0.78: RE would be too hopeful exactly where the controller is dangerous. And with the absolute error the best
# claim is 1: whoever is paid that way learns to exaggerate. (The squared error is proper too. It is called the Brier score, and we will meet it below.)
#
# So far the theory. It is about the drives that the network was trained on, and about a network that could say anything it likes. Whether a real network's probabilities are right <i>in a new building</i> is a question to be measured.
# </details>
#
# ## 4 · Is it right?
#
# A weather forecast that says "70 %" cannot be checked on one day. On all the days on which it said 70 %, it should have rained on seven of ten. The same for RE: sort its claims, put those of about the same size into a **bin**, and compare the *mean claim* of each bin with the *share that arrived*. Drawn against each other, that is the **reliability diagram**; an estimator whose points
# lie on the diagonal is **calibrated**.
#
# Most claims are near 1, so bins of equal width would be nearly empty in the middle and the last one would hold almost everything. We use bins of equal **mass**: each has as many claims as the next. The **expected calibration error** is the mean gap, each bin weighted with its number of claims $n_b$:
#
# $$ \mathrm{ECE} = \sum_b \frac{n_b}{N}\,\bigl|\,\overline{p}_b - \overline{y}_b\,\bigr| . $$
#
# ### Exercise 3 · `reliability_diagram` (medium, 10 minutes)
#
# <details><summary>Hint 1: concept</summary>Sort by the claim, cut into pieces of equal length, take two means of each piece. Claim and outcome must stay together when you sort.</details>
# <details><summary>Hint 2: approach</summary>np.argsort(predicted) gives the numbers of the pairs from the lowest claim to the highest, and np.array_split cuts them into `bins` groups, whose lengths differ by one at most.</details>
# <details><summary>Hint 3: one line</summary>groups = np.array_split(np.argsort(predicted), bins); then predicted[group].mean() and came_true[group].mean() for each. What is the weight of a group's gap?</details>


# %% exercise="reliability_diagram"
def reliability_diagram(predicted, came_true, bins):
    """Compare claims with outcomes in bins of equal mass.

    predicted: (N,) probabilities. came_true: (N,) 0 or 1. bins: B, how many.
    Returns the mean claim of each bin (B,), from the lowest to the highest, the share that came true (B,), and the ECE.
    """
    ### BEGIN SOLUTION
    groups = np.array_split(np.argsort(predicted), bins)
    claimed = np.array([predicted[group].mean() for group in groups])
    measured = np.array([came_true[group].mean() for group in groups])
    share = np.array([len(group) for group in groups]) / len(predicted)
    return claimed, measured, (share * np.abs(claimed - measured)).sum()
    ### END SOLUTION


# %%
reliability_diagram = check_reliability_diagram.use(reliability_diagram)

# %% [markdown]
# First a network in a hurry. It has the eyes of $\mathcal C$: for each pair, what the encoder of $\mathcal C_{WP}$ makes of the five comparisons, with nothing learnt anew. On top of them two small layers are trained, on nothing but the 500 drives in the *apartment* and the *maze*, until they know them well. The *ring of corridors* and the *office* are held back.
#
# **Predict:** how will its reliability diagram look for the drives that it learnt from? And in the ring of corridors: will the points lie above the diagonal (it arrives more often than it says) or below (it promises too much)?


# %%
def of(names, key):
    """A column of several buildings."""
    return np.concatenate([lessons[name][key] for name in names])


def seen_by_c(name):
    """What the encoder of C_WP makes of every pair of a building, (N, features)."""
    world, drawn = lessons[name]["recorded"], lessons[name]["errands"]
    current = waypoints.encode(Simulation(world.scene, drawn.starts).observe())
    targets = encoded(waypoints, world, drawn.targets).encoded
    with torch.no_grad():
        return waypoints.network.encoder.compare(current, targets).flatten(1)


LEARN, MEND, TEST = ["apartment", "maze"], ["ring of corridors"], ["office"]
features = {name: seen_by_c(name) for name in SEEDS}
x = torch.cat([features[name] for name in LEARN])
y = torch.from_numpy(of(LEARN, "labels")).float()
torch.manual_seed(0)
hurried = nn.Sequential(nn.Linear(x.shape[1], 64), nn.ReLU(), nn.Linear(64, 1))
optimizer = torch.optim.Adam(hurried.parameters(), 1e-3)
for step in range(301):
    z = hurried(x)[:, 0]
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
        lessons[name]["hurried"] = hurried(features[name])[:, 0].double().numpy()

figure, axes = chart(9.0, 4.4, columns=2)
for axis, names, title in zip(axes, (LEARN, MEND), ("where it learnt", "elsewhere"), strict=True):
    claims, came = sigmoid(of(names, "hurried")), of(names, "labels")
    predicted, measured, ece = reliability_diagram(claims, came, 10)
    draw_reliability(axis, predicted, measured, len(came) / 10, color=colours.unit(colours.LASER))
    axis.set_title(f"{title}: ECE {ece:.3f}")
    sure = claims > 0.99
    print(
        f"{title}: above 0.99 it claims {sure.mean():.0%} of the pairs; {came[sure].mean():.1%} of those arrive"
    )
show(from_figure(figure))

# %% [markdown]
# <details><summary>What do you see?</summary>
# Where it learnt, it is nearly perfect: it remembers the drives. Elsewhere it is nearly as <i>sure</i> as before and no longer as right: most of its claims are near 0 or 1, and the points are drawn out to the sides, below the diagonal at its upper end and above it at its lower end. This is <b>over-confidence</b>, the usual disease of networks: to make the loss still smaller on drives whose outcome it already
# gets right, training can only make the logits larger. (The vertical lines are 95 % intervals: so much could be chance.)
# </details>
#
# ### How to mend it
#
# The order of its claims may be good although the *numbers* are off. So leave the order alone and re-label the scale: put the logit through a rising function that is fitted on drives from which the network did not learn. The simplest one divides by a **temperature** $T$ (C. Guo et al., *On Calibration of Modern Neural Networks*, 2017):
#
# $$ p = \sigma(z / T), \qquad T = \arg\min_T \; \sum_i \ell\bigl(z_i / T,\; y_i\bigr) . $$
#
# $T > 1$ draws all claims towards one half, for a network that is too sure; $T < 1$ pushes them outwards.
#
# ### Exercise 4 · `fit_temperature` (easy, 8 minutes)
#
# <details><summary>Hint 1: concept</summary>One unknown number, and you have a function that says how good each value is. You can just try many.</details>
# <details><summary>Hint 2: approach</summary>A temperature of 0.5 is as far from 1 as one of 2: try values that grow by a factor, np.geomspace(0.05, 20, 600). Ask reach_loss(logits / t, labels, weights) for each, with weights of one. (Or scipy.optimize.minimize_scalar over log T.)</details>
# <details><summary>Hint 3: one line</summary>return temperatures[np.argmin([reach_loss(logits / t, labels, ones) for t in temperatures])]</details>


# %% exercise="fit_temperature"
def fit_temperature(logits, labels):
    """The temperature T > 0 for which the mean loss of logits / T is smallest, to about one percent.

    logits: (N,). labels: (N,) from 0 to 1. Returns one number.
    """
    ### BEGIN SOLUTION
    temperatures, ones = np.geomspace(0.05, 20.0, 600), np.ones(len(logits))
    losses = [reach_loss(logits / t, labels, ones) for t in temperatures]
    return temperatures[np.argmin(losses)]
    ### END SOLUTION


# %%
fit_temperature = check_fit_temperature.use(fit_temperature)

# %% [markdown]
# Now both networks, the hurried one and the library's. The temperature of each is fitted in the ring of corridors, and everything is tried in the office, of which neither has seen anything.
#
# A temperature is one number and cannot bend a curve. The library's RE comes with a rising line through twenty points instead, fitted to outcomes in sixteen validation worlds, of errands like those of exercise 1 (*isotonic regression*, `learning/calibration.py`); that is what `reachability.calibration` does, and what section 1 showed.
#
# For comparison there are two more: one that *always says the same*, namely the share that arrived in the ring of corridors, and the library's claims turned into *0 or 1*, "since a car either arrives or it does not". Four measures: **AUC**, how often the one of two pairs that arrives has the higher claim; **ECE**; **Brier**, the mean squared error; and the log loss of exercise 2.
#
# **Predict:** which of the four will the temperature change, and which one can it not change? Which line will have the best ECE?

# %%
came = of(TEST, "labels")
lines = []  # name, claims, number of the panel they are drawn in, colour
for panel, (who, key) in enumerate((("in a hurry", "hurried"), ("library", "logits"))):
    logits = of(TEST, key)
    temperature = fit_temperature(of(MEND, key), of(MEND, "labels"))
    cooled = sigmoid(logits / temperature)
    lines.append((f"{who}, raw", sigmoid(logits), panel, colours.LASER))
    lines.append((f"{who}, T = {temperature:.2f}", cooled, panel, colours.PATH))
mended = reachability.calibration(of(TEST, "logits"))
lines.append(("library, isotonic", mended, 1, colours.ROBOT))
lines.append(("always the same", np.full(len(came), of(MEND, "labels").mean()), None, None))
lines.append(("0 or 1", (of(TEST, "logits") > 0).astype(float), None, None))
print(f"{len(came)} drives in the {TEST[0]}, of which {came.mean():.1%} arrived")
print(f"{'':22s}{'mean':>8s}{'AUC':>8s}{'ECE':>8s}{'Brier':>8s}{'log loss':>10s}")
figure, axes = chart(9.0, 4.6, columns=2)
for name, claims, panel, tone in lines:
    predicted, measured, ece = reliability_diagram(claims, came, 10)
    kept = np.clip(claims, 1e-6, 1 - 1e-6)  # or claims of 0 and 1 would cost infinitely much
    loss = reach_loss(np.log(kept / (1 - kept)), came, np.ones(len(kept)))
    numbers = (claims.mean(), auc(claims, came), ece, brier(claims, came))
    print(f"{name:22s}" + "".join(f"{value:8.3f}" for value in numbers) + f"{loss:10.3f}")
    if panel is not None:
        axis = axes[panel]
        draw_reliability(axis, predicted, measured, color=colours.unit(tone), label=name)
for axis in axes:
    axis.legend(loc="upper left")
rng = np.random.default_rng(0)
perfect = [
    reliability_diagram(mended, (rng.random(len(mended)) < mended).astype(float), 10)[2]
    for _ in range(200)
]
print(f"one who is exactly right would have an ECE of about {np.mean(perfect):.3f} here, by chance")
show(from_figure(figure))

# %% [markdown]
# <details><summary>What changed, and what did not?</summary>
# The AUC does not change: a rising function leaves the order as it is, and the AUC sees nothing but the order. (Always the same has no order at all, 0.5; 0 or 1 has thrown most of it away.) Calibration cannot make a network any wiser. It can make it honest.
#
# The ECE alone says little. Whoever always claims the share that arrives is calibrated by definition, and useless, since no two targets can be told apart. Look at ECE <i>and</i> AUC, or at Brier and log loss, which reward both. The log loss punishes those hardest who were sure and wrong: "0 or 1" is ruined by it, though its AUC is good.
#
# And mind the last line: even somebody whose probabilities are exactly right would not lie on the diagonal with so few drives. Smaller differences mean nothing here. The results page at the end has many more.
# </details>
# <details><summary>The library's raw network is wrong in another way. In which, and where does it come from?</summary>
# Compare its mean claim with the share that arrived: it says too little nearly everywhere. It is not too sure but too <i>gloomy</i>. Its school was harder than life: in the last part of its training about every seventh target was one where it had been fooled before (section 5 tells why that is needed), and there many more drives fail. A temperature does not help: it changes how far the claims are
# spread, and not their level. A shift of the logits would, and the isotonic line contains one. Diagnose before you mend: look at the diagram first.
# </details>
# <details><summary>Why must a calibration be fitted on drives that the network did not learn from?</summary>
# Look at the hurried network where it learnt: it is right there, so the best temperature would be about 1, and nothing would be mended. It is rightly sure of what it remembers, and wrongly sure elsewhere; drives that it remembers cannot show that.
# </details>
# <details><summary>In section 1 the calibrated RE was too hopeful for targets beside the car. Is it calibrated or not?</summary>
# It is, <i>for pairs like those on which it was fitted</i>: starts on recorded drives or a little aside, and pictures that have something in common. Calibration is a promise about an average over questions of a certain kind. The grid of section 1 asks other questions, and there it need not hold. Before you trust a probability, ask on which questions it was measured, and whether yours are like them. The next section is about the questions that a map asks.
# </details>
#
# ## 5 · Far look-alikes
#
# A topological map (notebook 05) is built by asking RE about **all pairs** of its vertices, most of which have nothing to do with each other. Of how many of those will it be sure by mistake?
#
# Here are 120 frames of the apartment, all paired with each other. We take those pairs that are hopeless for certain: more than 5 m of way apart, and with less than a tenth of either view in the other. **Predict:** among thousands of them, how many will get an RE above 0.5, above 0.9, above 0.99? And what will the worst ones look like?

# %%
frames = np.linspace(0, len(recorded.poses) - 1, 120).round().astype(int)
rows, columns = (pairs.ravel() for pairs in np.meshgrid(frames, frames, indexing="ij"))
rows, columns = rows[rows != columns], columns[rows != columns]
queries = reachability_pairs(recorded, paths, recorded.poses[rows], columns)
asked = reachability.calibration(
    all_logits(reachability, recorded, queries.starts, queries.targets)
)
hopeless = np.flatnonzero(queries.hopeless)
print(f"{len(queries):,} pairs, {len(hopeless):,} of them far apart with nothing in common")
for level in (0.5, 0.9, 0.99):
    print(
        f"RE above {level}: {(asked > level).sum():5,d} of all, {(asked[hopeless] > level).sum()} far"
    )
worst, taken = [], np.zeros((0, 2))
for number in hopeless[np.argsort(-asked[hopeless])]:  # each from another place
    place = queries.starts[number, :2]
    if len(worst) < 3 and (np.linalg.norm(taken - place, axis=1) > 2.0).all():
        worst.append(number)
        taken = np.vstack([taken, place])
panels, titles = [], []
for number in worst:
    pair = np.array([queries.starts[number], recorded.poses[queries.targets[number]]])
    panels.append(pictured_pair(*people_camera.look(scene, pair)[0], 306))
    titles.append(f"RE {asked[number]:.2f}, {queries.geodesic[number]:.0f} m apart")
show(side_by_side(panels, titles))

# %% [markdown]
# <details><summary>Why these?</summary>
# In shape they are alike: a view along a corridor or through a room, a wall on either side, something at the end. Only the colours tell the places apart, strip by strip, and some of those recur in every room. This is <b>perceptual aliasing</b>, and notebook 07 is devoted to it. Context should help, since five pictures of a target are less easily alike than one; the results page
# shows whether it does.
# </details>
#
# An edge of the map between two such places is a **wormhole**: the planner believes that the robot can step from the one to the other, and since a shortcut is what planners look for, it will use it.
#
# <details><summary>Interpret this: an estimator is right about 999 of 1,000 hopeless pairs. A building has 1,000 vertices, and each can really reach two others. What share of the map's edges are wormholes?</summary>
# There are 1,000 × 999, about a million ordered pairs. 2,000 of them are real edges. Of the other 998,000, one in a thousand is let in: 998 wormholes. <b>One edge in three is false</b>, with an estimator that is right 99.9 % of the time. What counts is not how often it errs, but how often it errs among what it <i>says yes</i> to, and that depends on how rare the truth is. Doctors
# know this from tests for rare diseases. A map of 1,000 vertices needs one mistake in 100,000 before it has fewer than ten wormholes.
# </details>
# <details><summary>Then how can a network ever learn it? In a random draw of pairs, mistakes of this kind hardly occur.</summary>
# By searching for them. After most of its training, the network was asked about all pairs of 160 frames in 48 training worlds. Of those of which it was sure, the hopeless ones are its own worst mistakes, <b>hard negatives</b>: up to 400 in each world, the surest, and nobody has to drive to know how they end. On 100 others cars were sent. (Many of these did arrive: such pairs are
# kept too, or the network would learn to distrust everything of which it was once sure.) In the rest of the training about every seventh target came from both.
# </details>

# %%
card = load_card("reach_k2")
taught = card.recipe
print(f"trained on {taught['errands']:,} errands, {taught['reached']:,} of which arrived,")
print(f"and on {taught['mined'][0]:,} that it had been too sure of; {card.minutes:.0f} minutes")

# %% [markdown]
# So the question "is it calibrated?" has at least two answers: for errands like those of exercise 1, and for *the pairs that a map would choose*. The second we can also measure: of all the pairs above that are not simply neighbours on one drive, take those with RE > 0.9, send cars on up to 100 of them, and count. **Predict** which share arrives; RE's own mean says how many it expects.

# %%
same = recorded.first[rows] == recorded.first[columns]
neighbours = same & (np.abs(recorded.arc[rows] - recorded.arc[columns]) < 3.0)
chosen = np.flatnonzero((asked > 0.9) & ~neighbours)
chosen = np.sort(np.random.default_rng(0).permutation(chosen)[:100])
edges = queries.some(chosen)
arrivals = send(recorded, edges, by_sight)[0].reached
print(
    f"{len(edges)} pairs with RE > 0.9 between drives: RE expects {asked[chosen].mean():.1%}, {arrivals.mean():.1%} arrive"
)
sure = asked[chosen] > 0.99
if sure.any():
    print(f"{sure.sum()} of them with RE > 0.99: {arrivals[sure].mean():.1%} arrive")

# %% [markdown]
# <details><summary>Fewer arrive than RE expects, although it is calibrated. Why?</summary>
# It was calibrated on errands between places that see something of each other, most of which go well. Here it was asked about thousands of pairs, nearly all of them hopeless, and we picked out those that scored high: good pairs, and the few hopeless ones that happen to look good. The more hopeless ones are asked about, the larger their part among the winners. Near 0.99 there are hardly any left; that is why the
# paper builds its maps with this threshold, and why we will not read RE = 0.9 as "nine of ten" when a map has chosen the pair.
# </details>
#
# ## 6 · Slide the target along a drive
#
# The longest drive of the apartment. The car starts on it, and you slide the target along the drive, from 1 m behind to 9 m ahead; with the second slider you turn the car at its start. The curve is RE for every target; the square is what really happened: a drive is made for each position of the sliders.
#
# **Predict, then move the sliders.** Where will RE fall: gradually with the distance, or at certain places? Which ones? And what happens to the curve when the car has turned by 60°, or looks backwards?

# %%
lengths = recorded.arc[recorded.last] - recorded.arc[recorded.first]
longest = int(lengths.argmax())
begin = recorded.frame_at(np.array([recorded.first[longest]]), np.array([3.0]))
metres_ahead = np.arange(-1.0, 9.01, 0.25)
along = recorded.frame_at(np.repeat(begin, len(metres_ahead)), metres_ahead)
prepared = encoded(reachability, recorded, along)


@lru_cache
def asked_from(turned):
    """The start, and RE of every target from there."""
    pose = compose(recorded.poses[begin[0]], [0.0, 0.0, np.deg2rad(turned)])
    seen = Simulation(scene, np.repeat(pose[None], len(along), axis=0)).observe()
    return pose, reachability.probability(seen, prepared)


@lru_cache
def driven_to(target, turned):
    """The track to a target, and whether it was reached."""
    pose, _ = asked_from(turned)
    drives, _ = send(
        recorded, reachability_pairs(recorded, paths, pose[None], along[[target]]), by_sight
    )
    return drives.poses[: round(drives.seconds[0] / STEP) + 1, 0], bool(drives.reached[0])


def slide(metres_to_the_target, turned_by):
    """Map, pictures and curve for one target."""
    target = int(np.abs(metres_ahead - metres_to_the_target).argmin())
    pose, probability = asked_from(turned_by)
    track, reached = driven_to(target, turned_by)
    picture, goal = view.base.copy(), recorded.poses[along[target]]
    view.polyline(picture, recorded.poses[along[0] : along[-1] + 1, :2], colours.PATH, 2)
    draw_cells(view, picture, recorded.poses[along], probability, 0.16, 1.0)
    draw_target(view, picture, goal)
    view.polyline(picture, track[:, :2], colours.TRACK, 3)
    view.robot(picture, pose, car.footprint)
    map_part = closeup(view, picture, recorded.poses[along, :2], 1.1)
    look = pictured_pair(*people_camera.look(scene, np.array([pose, goal]))[0], 300)
    side = stacked([look, along_trajectory(metres_ahead, probability, target, reached)], width=330)
    gap = np.linalg.norm(track[:, :2] - goal[:2], axis=1).min()
    joint = "and" if reached == (probability[target] >= 0.5) else "but"
    ending = "the car arrived" if reached else f"the car came no nearer than {gap:.2f} m"
    return side_by_side([map_part, side]), f"RE {probability[target]:.2f}, {joint} {ending}"


sliders(slide, metres_to_the_target=(-1.0, 9.0, 0.25, 3.0), turned_by=(-180, 180, 30, 0))

# %% [markdown]
# <details><summary>What did you find?</summary>
# RE stays high as long as the target, or the way to it, can be seen; it falls where the drive goes round a corner or through a door, and not at a certain number of metres. Turned to the side, the car sees something else, and many targets that were certain become doubtful: reachability belongs to a <i>pose</i>, and not to a place. Where RE is near one half, some drives arrive and others do not.
# Notebook 04 uses exactly this curve: as long as RE stays high for <i>all</i> targets up to a frame, the frames between can be thrown away.
# </details>
#
# ## 7 · How it fails
#
# RE fails in two ways: it is sure of a target that is then not reached, or it gives up one that is. From the four buildings, these are the three worst of each kind. **Before you unfold the causes:** look at the two pictures of each and say why *you* would have believed it.


# %%
def traits_of(lesson):
    """What could mislead RE, for each errand of a building."""
    drawn, goals = lesson["errands"], lesson["goals"]
    offset, caster = to_local(drawn.starts, goals[:, :2]), lesson["recorded"].scene.caster
    angle = np.abs(np.rad2deg(np.arctan2(offset[:, 1], offset[:, 0])))
    room = lesson["recorded"].scene.clearance
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
for name, lesson in lessons.items():
    claims, found = reachability.calibration(lesson["logits"]), traits_of(lesson)
    for i, (claim, label) in enumerate(zip(claims, lesson["labels"], strict=True)):
        case = {"claim": claim, "label": label, "closest": lesson["gaps"][:, i].min()}
        case |= {"name": name, "i": i, "traits": {key: has[i] for key, has in found.items()}}
        cases.append(case)
too_sure = sorted((c for c in cases if c["label"] == 0), key=lambda c: -c["claim"])[:3]
too_modest = sorted((c for c in cases if c["label"] == 1), key=lambda c: c["claim"])[:3]
plans = {name: PlanView(lesson["recorded"].scene, 1600, 1600) for name, lesson in lessons.items()}


def case_picture(case):
    """The map with the track, both pictures, and what is special about the errand."""
    lesson, plan = lessons[case["name"]], plans[case["name"]]
    drives, start = lesson["drives"], lesson["errands"].starts[case["i"]]
    goal = lesson["goals"][case["i"]]
    track = drives.poses[: round(drives.seconds[case["i"]] / STEP) + 1, case["i"]]
    picture = plan.base.copy()
    draw_target(plan, picture, goal)
    plan.polyline(picture, track[:, :2], colours.TRACK, 3)
    plan.robot(picture, start, car.footprint)
    middle = (start[:2] + goal[:2]) / 2
    corners = np.concatenate([track[:, :2], [middle - 0.7, middle + 0.7]])
    near = side_by_side([closeup(plan, picture, corners, 0.8, square=True)], height=300)
    look = people_camera.look(lesson["recorded"].scene, np.array([start, goal]))[0]
    ending = "arrived" if case["label"] else f"no nearer than {case['closest']:.2f} m"
    special = [key for key, has in case["traits"].items() if has] or ["nothing special"]
    titles = [f"RE {case['claim']:.2f}: {ending}", ", ".join(special)]
    return stacked([near, pictured_pair(*look, 300)], titles, gap=4)


for group in (too_sure, too_modest):
    display(show(side_by_side([case_picture(case) for case in group])))

# %% [markdown]
# Three cases are anecdotes. What do the mistakes have in common? The words above the pictures are six things that could mislead RE. For all 1,000 errands we compare its mean claim with the share that arrived, with and without each of them. **Predict:** where will the two differ most?

# %%
claims = np.array([case["claim"] for case in cases])
came = np.array([case["label"] for case in cases])
print(f"{'':16s}{'with it: claims, arrives':>30s}{'without it: claims, arrives':>32s}")
for trait in cases[0]["traits"]:
    has = np.array([case["traits"][trait] for case in cases])
    cells = [f"{claims[s].mean():.2f}  {came[s].mean():.2f}  ({s.sum()})" for s in (has, ~has)]
    print(f"{trait:16s}{cells[0]:>30s}{cells[1]:>32s}")
closest = np.array([case["closest"] for case in cases])[came == 0]
print(
    f"{len(closest)} did not arrive; {np.mean(closest < 0.5):.0%} of them came within half a metre"
)

# %% [markdown]
# <details><summary>What are the causes?</summary>
# Of the three where RE was too sure, look first at the maps. Where the car has not moved at all, its body touches a wall or nearly so at the side or behind, where no camera looks: what holds it fast is not in the pictures. The other one stops just outside the circle of 0.30 m, where the pictures are as good as the same. Those where RE was too modest have one thing in common: the car is to arrive with quite another heading than
# it starts with, so that the two pictures share little. The way was plain all the same, and the label asks for the place only.
#
# In the table RE's mean claim follows the share that arrives from line to line: it has understood that targets beside the car, with little overlap or turned away are harder. (Differences of five points, or ten where there are few errands, mean nothing.) A tight place is too seldom a trouble to show in the mean. Only where a wall stands between car and target it is far too hopeful: the two views share something round a corner, the way is longer than it seems, and such pairs are rare among those that it learnt from.
# </details>
# <details><summary>Which of these could a better network mend, and which not?</summary>
# The wall between could be learnt from more examples of it. The wall behind the car could not: RE sees what the camera sees. (The laser sees it, and our driver has one. RE for the laser is one of the lines of the results page.) And the last centimetres are chance: at the edge of the circle one of them decides, and the honest answer there is a number between 0 and 1.
# </details>
#
# ### Find the bug
#
# A colleague needs RE between all pairs of frames of a drive, "and a distance is the same in both directions, so half of the table is enough". It runs twice as fast and without an error. Look at the two tables, and decide what is wrong before you unfold the answer. Rows are where the car is, columns the target, both along the drive.

# %%
stretch = recorded.frame_at(np.repeat(begin, 36), np.linspace(-1.0, 8.0, 36))
pairs = np.stack(np.meshgrid(stretch, stretch, indexing="ij"), axis=-1).reshape(-1, 2)
table = reachability.calibration(
    all_logits(reachability, recorded, recorded.poses[pairs[:, 0]], pairs[:, 1])
).reshape(36, 36)


def colleagues(table):
    """Only the upper half is asked; the lower half is the same."""
    upper = np.triu(table)
    return upper + np.triu(table, 1).T


figure, axes = chart(9.0, 4.4, columns=2)
for axis, values, name in zip(
    axes, (colleagues(table), table), ("the colleague's", "all asked"), strict=True
):
    axis.imshow(values, vmin=0, vmax=1, cmap="cividis", extent=(-1, 8, 8, -1))
    axis.set(xlabel="target, m along the drive", ylabel="car, m along the drive", title=name)
    axis.grid(visible=False)
gap = np.subtract.outer(-np.arange(36), -np.arange(36)) * 9 / 35  # metres to the target
for low, high in ((0.5, 1.5), (1.5, 3.0), (3.0, 5.0)):
    ahead, behind = (table[(way >= low) & (way < high)].mean() for way in (gap, -gap))
    print(f"target {low} to {high} m ahead: mean RE {ahead:.2f}; as far behind: {behind:.2f}")
show(from_figure(figure))

# %% [markdown]
# <details><summary>Answer</summary>
# RE is no distance. From A to B the car drives forwards and looks to where it is going; from B to A the same pictures lie behind its back, and it would have to reverse by what it does not see. So $\mathrm{RE}(a, b) \ne \mathrm{RE}(b, a)$, and the edges of the map are <i>directed</i>. The colleague's table promises the way back wherever there is a way out. Nothing crashes; the robot just plans routes on which it must
# reverse for metres. It is a typical mistake of those who think of reachability as nearness.
# </details>
#
# ## 8 · Calibration on unseen worlds
#
# The results page. Every estimator is asked about the same errands in unseen worlds, and cars are sent on all of them. **k0, k2, k5** and **laser** are RE for controllers with that context, each judged by the outcomes of its own controller. They are bracketed by three that are not RE: **image** only compares the two pictures, **sptm** was trained to tell whether two pictures were taken at about the same *time* (Savinov et al. 2018: reachability by proxy), and **geometry** is an oracle that sees no picture
# but is told distance, bearing, overlaps, line of sight and room by the map, and was fitted to the outcomes of k2 in training worlds. The paper prints no such figure for RE; its Fig. 9 compares the probability of whole *paths* with their success, and gets its twin in notebook 06. The diagram below is its counterpart for single steps.
#
# **Predict:** will more context make RE more accurate? Can any RE be better than geometry? And who is sure of far look-alikes?

# %%
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

# %%
keys = ("auc", "brier", "ece", "precision_mix", "precision_consecutive", "precision_map")
print(
    f"{len(report.worlds)} unseen worlds; {estimators['k2']['pairs']:,} pairs that see something of each other"
)
print(
    f"{'':10s}"
    + "".join(f"{key.replace('precision', 'prec'):>18s}" for key in keys)
    + f"{'far above 0.9':>16s}"
)
for name, line in estimators.items():
    cells = ["-" if line[key] is None else f"{line[key]:.3f}" for key in keys]
    far_share = line["far_above_09"]
    cells.append("-" if far_share is None else f"{far_share:.2%}")
    widths = [18] * len(keys) + [16]
    print(f"{name:10s}" + "".join(f"{c:>{w}s}" for c, w in zip(cells, widths, strict=True)))
print("\na map of 1,000 vertices asks about a million pairs; wormholes if its threshold were 0.9:")
for name, line in estimators.items():
    if line["far_above_09"] is not None:
        print(f"{name:10s}{1e6 * line['far_above_09']:10,.0f}")
print(*report.notes, sep="\n")

# %% [markdown]
# *prec* is the share that arrives of the pairs with RE > 0.99, the threshold that the paper uses for its maps: among the errands (*mix*), from one anchor of a sparse drive to the next (*consecutive*), and among all pairs of frames of a world, as a map would choose them (*map*). (To run it again: `.venv/bin/python -m tutorial_lib experiment calibration`.)
#
# <details><summary>Why is there no number of the paper beside ours?</summary>
# It gives none for RE itself: it shows that maps built with RE work (its Table II), and that path probabilities agree with success (Fig. 9). We can measure RE alone because rollouts cost us milliseconds, and because in simulation a car can be put back to the same place a thousand times. Same idea, easier world: what is hard for RE in real buildings, such as glass, changing light and people, does not occur in ours.
# </details>
# <details><summary>Systems have been built on image similarity and on time between pictures. What do these two lack?</summary>
# Both answer another question. Two pictures can be alike, or close in time, and yet the way from the one to the other be impossible for this car: behind it, beside it, round a corner. And two pictures can be quite different and the way easy: along a corridor. Neither score is a probability, either; calibration could mend the numbers, but not the ranking.
# </details>
# <details><summary>The three precisions of one estimator differ. Which one is its precision?</summary>
# All of them. Precision is a property of the estimator <i>and of the questions</i>. Consecutive anchors are easy questions. Among all pairs of a building nearly everything is hopeless, and what is left above 0.99 holds more look-alikes. Notebook 05 looks at the last one, since it decides how many wormholes a map has.
# </details>
#
# ## Optional extras
#
# - **Extra 1.** Draw the maps of section 1 for starts that are turned by 45°. Where does the blue area go?
# - **Extra 2.** `ReachabilityNetwork("reach_k5")` belongs to `WaypointNetwork("waypoint_k5")`. Ask it about the outcomes of k = 2: how large is its ECE, and in which direction is it wrong?
# - **Extra 3.** Fit temperature *and* offset, $\sigma(z/T + b)$. What does the offset mend that the temperature cannot?
# - **Extra 4.** Mend RE for the grid of section 1: fit a temperature on one target's grid, and test it on the other one's. Does it work? What would both networks have to be taught?
#
# ## What to remember
#
# - $\mathrm{RE} = P(\mathcal C \text{ reaches the target})$. It is about a controller, a pose and a picture, and it is no distance: it has a direction, and it stops at walls.
# - It is learnt from outcomes alone. What counts as an outcome, time limit and collisions included, decides what is learnt.
# - A proper loss asks for the frequency. Whether the answer is right in a new building has to be measured: sort, bin, compare.
# - Calibration changes the numbers and never the order. It holds for questions like those on which it was fitted.
# - A map asks about a million pairs. Rare mistakes become wormholes, and must be hunted for: hard negatives.
#
# **Read next:** the paper, III-D (*Sparsifying a Trajectory*), and then notebook 04, which throws away every frame that RE does not need. On calibration: C. Guo et al., *On Calibration of Modern Neural Networks* (2017).
