# %% [markdown]
# # 02 · Local control
#
# **120 minutes.** You need [notebook 01](01_world_and_car.ipynb): frames, the car, the camera. A little linear algebra helps: what a matrix times a vector is, and what its
# transpose is. No experience with neural networks is required.
#
# After this notebook you can
#
# - build a reactive controller from small *motion policies*, each with a desired acceleration and a weight;
# - say which labels train a network to guide a car to the place shown in an image, and compute them from a recorded trajectory;
# - explain how a network compares two images, and why half of that work needs to be done only once;
# - write the loop that trains a network, watch a car drive by yours, and read the table that compares such controllers.
#
# There are five exercises with hints behind folds; the last one is longer. When your function passes its check, **the cells below use it**; until then they use the library's.
#
# We follow X. Meng, N. Ratliff, Y. Xiang and D. Fox, [*Scaling Local Control to Large-Scale Topological Navigation*](https://arxiv.org/abs/1909.12329) (ICRA 2020), from here on "the paper".

# %%
from copy import deepcopy
from dataclasses import replace

import numpy as np
import torch
from IPython.display import display
from torch.nn import functional

from tutorial_lib.checks.nb02 import (
    check_goal_policy,
    check_obstacle_policy,
    check_resolve,
    check_train_network,
    check_waypoint_label,
    clear_sight,
)
from tutorial_lib.driving import (
    PAPER_PERTURBATION,
    ComposedController,
    GridPaths,
    ReachGoals,
    RecordedWorld,
    RMPController,
    TargetPolicy,
    control_jacobian,
    cover,
    demonstrate,
    draw_episodes,
    perturbed,
    point_jacobian,
    rollout,
)
from tutorial_lib.experiments import load_result
from tutorial_lib.geometry import compose, relative, to_local, to_world
from tutorial_lib.learning import (
    Architecture,
    DirectNetwork,
    LocalNetwork,
    PairEncoder,
    Source,
    WaypointNetwork,
)
from tutorial_lib.learning.small_training import TrainingPlan
from tutorial_lib.learning.training import total_loss, validate
from tutorial_lib.viz import (
    PlanView,
    camera_picture,
    chart,
    closeup,
    colours,
    draw_arrows,
    draw_metrics,
    draw_outcome,
    from_figure,
    matches_picture,
    outcome_legend,
    play,
    show,
    side_by_side,
    sliders,
    stacked,
    table,
)
from tutorial_lib.world import (
    STEP,
    BicycleCar,
    Camera,
    DifferentialDrive,
    Fan,
    Laser,
    Sensors,
    Simulation,
    full_circle,
    is_free,
    local_world,
    mutual_overlap,
    scene_of,
)

torch.set_num_threads(1)  # the networks are small: a second thread would mostly wait

# %% [markdown]
# ## 1 · Drive to the place shown in an image
#
# A [[local controller]] $\mathcal C$ takes the robot's current image, $o_\text{current}$, and an image taken at the target, $o_\text{target}$. Ten times a second it returns a
# command, until the two images agree. It has no map and no coordinates, only images. It does not have to cross a building. It has to cover a few metres, reliably.
#
# One image of the target would do, but a recorded trajectory holds more: the frames shortly before and after. These neighbours show more of the room, and they
# show in which direction the trajectory continues. The target *with its [[context]]* is (paper, III-B)
#
# $$ \hat o_i = \bigl(o_{i-k\Delta T},\; \dots,\; o_i,\; \dots,\; o_{i+k\Delta T}\bigr), \qquad \Delta T = 3 \text{ frames} = 0.3\ \text{s}, $$
#
# that is $2k+1$ images; $k = 0$ is the single image.
#
# Below, an oracle that knows the map has driven 24 cars through an apartment. Their recordings are the **trajectories**. An [[episode]] has a start and a target: the start lies beside a trajectory (up
# to 1 m aside, turned a little), and the target is a frame of that trajectory, from 1 m behind the start to 3 m ahead of it.

# %% hidden=true
# What the car sees at its start, and what it should see at its target
WORLD = local_world(10_004)  # no network was trained on it
scene = scene_of(WORLD)
paths = GridPaths(scene.clearance)
recorded = RecordedWorld(scene, demonstrate(WORLD, scene, 24, seed=0, controller=RMPController()))
episodes = draw_episodes(recorded, paths, 120, np.random.default_rng(0))
view = PlanView(scene, 1430, 2015)  # 130 pixels per metre: close-ups are cut out of it
car = BicycleCar()
people_camera = Camera(rows=64)  # the same view as the network's 16 rows, for people

shared = mutual_overlap(scene.caster, episodes.starts, episodes.goals)
goals_seen = relative(episodes.starts, episodes.goals)
# An instructive episode: a target ahead and aside, whose image overlaps much with the start's.
score = shared.min(axis=1) + 0.4 * np.minimum(np.abs(goals_seen[:, 1]), 1.0)
example = int(np.where(episodes.ahead > 1.8, score, 0.0).argmax())
start, goal = episodes.starts[example], episodes.goals[example]
frames = recorded.context(episodes.targets[[example]], 2)[0]
now = people_camera.look(scene, start[None])[0]
context = people_camera.look(scene, recorded.poses[frames])[0]
names = [f"{3 * j:+d} frames" if j else "target" for j in range(-2, 3)]
large = [camera_picture(image, 465) for image in (now[0], context[2])]
row = side_by_side([camera_picture(image, 184) for image in context], names, gap=6)
pair = side_by_side(large, ["what the car sees now", "what it should see"])
show(stacked([pair, row], gap=8))

# %% [markdown]
# **Predict** from these images alone: does the target lie to the left or to the right of the car's heading? Will the car have turned left or right when it arrives?
# Then run the next cell.


# %% hidden=true
# The episode from above: start, target, its context and the trajectory
def map_with(start, goal, track=(), picture=None):
    """The map with a target, a car and perhaps its track."""
    picture = view.base.copy() if picture is None else picture
    view.goal(picture, goal[:2])
    tip = to_world(goal, [0.7, 0.0])
    view.polyline(picture, [goal[:2], tip], colours.GOAL, 4)
    view.arrow(picture, [*tip, goal[2]], colours.GOAL, 9)
    view.polyline(picture, track, colours.TRACK, 4)
    view.robot(picture, start, car.footprint)
    return picture


picture = view.base.copy()
target = episodes.targets[example]
whole = slice(recorded.first[target], recorded.last[target] + 1)
view.polyline(picture, recorded.poses[whole, :2], colours.PATH, 3)
map_with(start, goal, picture=picture)
view.points(picture, recorded.poses[frames, :2], colours.PATH, 5)
ahead, left, turn = goals_seen[example]
print(
    f"the target is {ahead:.2f} m ahead and {abs(left):.2f} m to the {'left' if left > 0 else 'right'}"
)
print(f"on arrival the car has turned by {np.rad2deg(turn):+.0f} degrees (+ is left)")
show(closeup(view, picture, np.array([start[:2], goal[:2]]), 1.6))

# %% [markdown]
# Orange is the recorded trajectory, green the target and the heading at which it was recorded, the dots are its context.
#
# The paper splits the controller in two:
#
# $$ \mathcal C(o_\text{current}, \hat o_\text{target}) \;=\; \mathcal C_{RMP}\bigl(\mathcal C_{WP}(o_\text{current}, \hat o_\text{target})\bigr). $$
#
# $\mathcal C_{WP}$ is a network: images in, a [[waypoint]] $(x, y)$ in the robot's frame out. It knows nothing about wheels. $\mathcal C_{RMP}$ drives to the waypoint with the laser, and knows nothing about
# images. The waypoint need not be exact: it is only a hint, and it is updated ten times a second. We build the second part first.
#
# ## 2 · Motion policies: what to do, and how much it matters
#
# A controller has several aims at once: to reach the waypoint, to keep off the wall on the left, and off the post on the right. Adding up forces (a potential field) is the classic recipe, and it has a classic flaw:
# a wall far away still contributes to the sum, and a push that is right beside a wall is wrong in front of it. A [[Riemannian motion policy]] (RMP; N. Ratliff et al., [*Riemannian Motion Policies*](https://arxiv.org/abs/1801.02854), 2018) has two parts:
#
# - an acceleration $a$: *what it wants*;
# - a [[metric]] $M$, a symmetric matrix: *how much it matters, and in which directions*.
#
# A policy with $M \approx 0$ has no influence on the result, whatever its $a$ is.
#
# The **goal policy** pulls a point $x$ to its goal $g$ and damps its velocity. It weights all directions equally (III-B names the framework only; the form is that of its authors' code):
#
# $$ a = \gamma\,\frac{g - x}{\max(|g - x|,\ \varepsilon)} - \beta\,\dot x, \qquad M = I . $$
#
# The pull $\gamma$ has the same strength at 3 m and at 1 m; only within $\varepsilon$ does it fade.
#
# ### Exercise 1 · `goal_policy` (easy, 8 minutes)
#
# <details><summary>Hint 1: concept</summary>The offset divided by its length is a unit vector: direction without distance. Near the goal, division by a tiny length would make the pull jump about, hence the max.</details>
# <details><summary>Hint 2: approach</summary>np.linalg.norm(offsets, axis=-1, keepdims=True) gives each row its own length and keeps an axis to divide by. The metric is the identity for each of them: np.broadcast_to(np.eye(2), shape).</details>
# <details><summary>Hint 3: one line</summary>With <code>lengths</code> of shape (N, 1), <code>rows / lengths</code> divides every row by its own. Which two numbers must you compare before you divide, and what is subtracted in the end? The shape of the metrics is <code>(*offsets.shape, 2)</code>.</details>


# %% exercise="goal_policy"
def goal_policy(offsets, velocities, gain, damping, near):
    """Pull points to their goals, and damp them.

    offsets: (..., 2) from each point to its goal, m; (2,) for one point, (N,
    2) for several.
    velocities: (..., 2) m/s. gain: γ, m/s^2. damping: β, 1/s. near: ε, m.
    Returns two arrays, accelerations (..., 2) and metrics (..., 2, 2).
    """
    ### BEGIN SOLUTION
    distance = np.linalg.norm(offsets, axis=-1, keepdims=True)
    accelerations = gain * offsets / np.maximum(distance, near) - damping * velocities
    return accelerations, np.broadcast_to(np.eye(2), (*np.shape(offsets), 2))
    ### END SOLUTION


# %%
goal_policy = check_goal_policy.use(goal_policy)

# %% [markdown]
# An **obstacle policy** acts on one number, the distance $d$ to one laser point. It accelerates away from the point, more strongly the nearer the point is and the faster the distance
# shrinks (at $c$ m/s), and its metric is large only nearby:
#
# $$ \ddot d = \frac{p + b\,\max(c, 0)}{d}, \qquad m = w\,e^{-d/\ell} . $$
#
# $p$ is the push, $b$ the brake, $w$ the weight at contact, and $\ell$ the length over which the weight fades. Distances below 0.01 m count as 0.01 m, in both formulas. The brake acts only while the distance shrinks: no policy should pull the car back to a wall
# that it is leaving.
#
# ### Exercise 2 · `obstacle_policy` (easy, 8 minutes)
#
# <details><summary>Hint 1: concept</summary>Acceleration and metric do two different jobs. The first grows when the wall is near; the second decides how much it counts.</details>
# <details><summary>Hint 2: approach</summary>First limit the distances from below, np.maximum(distances, 0.01), and use that in both formulas: at contact you would otherwise divide by zero.</details>
# <details><summary>Hint 3: one line</summary><code>np.maximum(speeds, 0)</code> keeps the positive speeds and sets the others to 0. Where does that belong, and what is all of it divided by? The metric is one np.exp.</details>


# %% exercise="obstacle_policy"
def obstacle_policy(distances, closing, push, brake, weight, fade):
    """Accelerate away from obstacles.

    distances: (N,) m; below 0.01 m, or negative, they count as 0.01 m.
    closing: (N,) m/s, positive when the distances shrink. push: p, m^2/s^2.
    brake: b, m/s.
    weight: w. fade: l, m. Returns two arrays, accelerations (N,) and metrics
    (N,).
    """
    ### BEGIN SOLUTION
    distances = np.maximum(distances, 0.01)
    away = (push + brake * np.maximum(closing, 0.0)) / distances
    return away, weight * np.exp(-distances / fade)
    ### END SOLUTION


# %%
obstacle_policy = check_obstacle_policy.use(obstacle_policy)

# %% [markdown]
# Each policy acts on its own quantity: the goal policy on a point of the car, the obstacle policy on a distance. The controller can only change the car's *controls*. The derivative of a quantity with respect to the controls is its
# [[Jacobian]] $J$. If the controls are accelerated by $u$, the quantity is accelerated by $J u$. Which $u$ suits all policies best? The one with the least squared error, weighted with the metrics:
#
# $$ u = \arg\min_u \sum_i (J_i u - a_i)^{\top} M_i\, (J_i u - a_i) \;=\; \Bigl(\sum_i J_i^{\top} M_i J_i\Bigr)^{-1} \sum_i J_i^{\top} M_i\, a_i . $$
#
# $J^{\top} M a$ is the policy's *force* on the controls and $J^{\top} M J$ its metric there. Computing both is the **pullback**; summing and solving is called **resolve**.
# If no policy has a weight in some direction, the sum of the metrics is singular; adding $10^{-6}$ to its diagonal means *then do nothing*: a policy that weighs far less than that is not obeyed.
#
# ### Exercise 3 · `resolve` (medium, 12 minutes)
#
# <details><summary>Hint 1: concept</summary>It is weighted least squares. Where two policies disagree, the result is their average, weighted with their metrics.</details>
# <details><summary>Hint 2: approach</summary>Begin with force = np.zeros(2) and metric = 1e-6 * np.eye(2). Loop over the policies and add J.T @ M @ a to the first and J.T @ M @ J to the second. Solve once, at the end.</details>
# <details><summary>Hint 3: one line</summary><code>np.linalg.solve(A, b)</code> finds the x with A x = b. What are A and b here?</details>


# %% exercise="resolve"
def resolve(policies):
    """The accelerations of the two controls that suit all policies best.

    policies: a list of (jacobian (D, 2), acceleration (D,), metric (D, D)); D
    may differ. The list may be empty; then nothing is wanted.
    Returns an array (2,). 1e-6 is added to the diagonal of the summed metric.
    """
    ### BEGIN SOLUTION
    force, metric = np.zeros(2), 1e-6 * np.eye(2)
    for jacobian, acceleration, weight in policies:
        force = force + jacobian.T @ weight @ acceleration
        metric = metric + jacobian.T @ weight @ jacobian
    return np.linalg.solve(metric, force)
    ### END SOLUTION


# %%
resolve = check_resolve.use(resolve)

# %% [markdown]
# ### The resolved field
#
# First the simplest robot: a disc that can be pushed in any direction, so that $J$ of its position is the identity, and that of its distance to a laser point is the row $-h^{\top}$, with $h$ the unit vector
# towards the point. The policies are evaluated for a disc at rest at every point of a grid. The arrows are the resolved accelerations, the ellipses the sum of the metrics: *long in the directions that matter*.
#
# **Predict:** what shape do the ellipses have in the middle of a room, and beside a wall: long along the wall or across it? Where will the arrows be wrong, if anywhere? Then run the cell.

# %%
door_start = np.array([-0.25, -13.0, 1.1])
door_goal = np.array([1.0, -10.3])
beam_angles = full_circle(96)
beam_rays = np.stack([np.cos(beam_angles), np.sin(beam_angles)], axis=1)


def keep_off(points, centre, radius, jacobian, velocity, push, weight):
    """One policy for each laser point (P, 2): keep a disc of the body off it.

    centre: (2,) of the disc. velocity: (2,) of the centre. jacobian: (2, 2) of
    the centre by the controls.
    """
    offsets = points - centre
    far = np.linalg.norm(offsets, axis=1)
    towards = offsets / far[:, None]
    away, metrics = obstacle_policy(far - radius, towards @ velocity, push, 0.12, weight, 0.08)
    rows = -towards @ jacobian  # derivative of each distance by the controls
    return [
        (row[None], a[None], m[None, None]) for row, a, m in zip(rows, away, metrics, strict=True)
    ]


def field(places, scans, push=0.12, weight=0.3, gain=2.4):
    """Resolved accelerations (P, 2) and metrics (P, 2, 2) of a disc at rest at `places` (P, 2)."""
    still = np.zeros(2)
    accelerations, metrics = [], []
    for place, beams in zip(places, scans, strict=True):
        near = beams < 1.0
        policies = [(np.eye(2), *goal_policy(door_goal - place, still, gain, 3.0, 0.35))]
        points = beams[near, None] * beam_rays[near]
        policies += keep_off(points, still, 0.15, np.eye(2), still, push, weight)
        accelerations.append(resolve(policies))
        metrics.append(sum(j.T @ m @ j for j, _, m in policies))
    return np.array(accelerations), np.array(metrics)


# %% hidden=true
# The resolved field near a doorway: accelerations as arrows, metrics as ellipses
grid = np.stack(
    np.meshgrid(np.arange(-1.4, 2.8, 0.3), np.arange(-13.6, -9.7, 0.3)), axis=-1
).reshape(-1, 2)
grid = grid[scene.clearance.at(grid) > 0.12]
scans = Laser().scan(scene, np.column_stack([grid, np.zeros(len(grid))]))
near_door = np.array([[-1.0, -13.4], [2.0, -10.0]])


def field_picture(push, weight, gain):
    """The field near the doorway."""
    picture = view.base.copy()
    accelerations, metrics = field(grid, scans, push, weight, gain)
    draw_metrics(view, picture, grid, metrics)
    strength = np.linalg.norm(accelerations, axis=1, keepdims=True)
    draw_arrows(view, picture, grid, 0.24 * accelerations / np.maximum(strength, 2.4))
    view.goal(picture, door_goal)
    return picture


show(closeup(view, field_picture(0.12, 0.3, 2.4), near_door, 0.35))

# %% [markdown]
# <details><summary>What do you see?</summary>
# In the open the ellipses are circles: only the goal policy has a weight there, the same in all directions. Beside a wall they are long <i>across</i> the wall: motion towards it matters, motion along it does
# not. So the arrows beside a wall may run along it freely, and are turned away from it only where that matters. Behind the wall that has the door in it, the arrows point at the goal straight through the wall, and are deflected
# in front of it. There they can end in a <b>local minimum</b>: a reactive controller does not search for a path around the wall. That is why the waypoint must be chosen so that a straight line leads to it (section 3).
# </details>
#
# ### The car, driven by your three functions
#
# The car cannot be pushed sideways. Its controls are speed $v$ and steering $\delta$, and a point of the car at $(p_x, p_y)$ moves by
#
# $$ \begin{pmatrix}\dot x\\ \dot y\end{pmatrix} = \begin{pmatrix}1 & -p_y\\ 0 & p_x\end{pmatrix}\begin{pmatrix}v\\ \omega\end{pmatrix}, \qquad \omega = \frac{v}{L}\tan\delta . $$
#
# The Jacobian of the point is the first matrix (`point_jacobian`) times the derivative of $(v, \omega)$ by the controls (`control_jacobian`). The rest is as before: the goal policy pulls the car's *nose*, and each
# laser point pushes four discs that cover the car. **Predict, then move the sliders:** what will the car do at the doorpost when the weight is zero, and can a large push make up for it? And what does the gain change: the path, or only the time?

# %%
nose = np.array([0.36, 0.0])
discs = cover(car)


def drive_by_policies(observation, waypoint, push, weight, gain):
    """The action (2,) of one car from the three functions."""
    controls = np.array([observation.speed[0], observation.steering[0]])
    # At rest, steering does not turn the car; the policies must see what it will do.
    moving = np.array([max(controls[0], 0.25), controls[1]])
    by_controls, twist = control_jacobian(car, moving), car.twist(controls)
    beams = observation.laser[0]
    points = beams[beams < 0.75, None] * beam_rays[beams < 0.75]
    body = point_jacobian(nose)
    pull = goal_policy(waypoint - nose, body @ twist, gain, 3.0, 0.35)
    policies = [(body @ by_controls, *pull)]
    for along, radius in discs:
        centre = np.array([along, 0.0])
        body = point_jacobian(centre)
        policies += keep_off(points, centre, radius, body @ by_controls, body @ twist, push, weight)
    speed, steering = controls + STEP * resolve(policies)
    return np.array([np.clip(speed, -0.3, 0.8), np.clip(steering, -0.45, 0.45)])


# %% hidden=true
# The car drives through the door by your functions, with sliders
def drive_through_the_door(push, weight, gain):
    """The field, the car's track and how the rollout ended."""
    simulation = Simulation(scene, door_start, sensors=Sensors(camera=None))
    track, ending = [simulation.poses[0]], "out of time"
    for _ in range(120):
        waypoint = to_local(simulation.poses[0], door_goal)
        simulation.step(drive_by_policies(simulation.observe(), waypoint, push, weight, gain)[None])
        track.append(simulation.poses[0])
        if simulation.collided[0]:
            ending = "collided"
            break
        if np.linalg.norm(simulation.poses[0, :2] - door_goal) < 0.4:
            ending = "arrived"
            break
    picture = field_picture(push, weight, gain)
    view.polyline(picture, np.array(track)[:, :2], colours.TRACK, 4)
    for pose in track[:: max(1, len(track) // 5)]:
        view.robot(picture, pose, car.footprint)
    view.robot(picture, track[-1], car.footprint)
    corner = closeup(view, picture, near_door, 0.35)
    return corner, f"{ending} after {simulation.seconds:.1f} s"


sliders(
    drive_through_the_door,
    {"push": "push p, m²/s²", "weight": "weight w at contact", "gain": "gain γ, m/s²"},
    push=(0.0, 0.6, 0.06, 0.12),
    weight=(0.0, 3.0, 0.3, 0.3),
    gain=(0.6, 3.6, 0.6, 2.4),
)

# %% [markdown]
# <details><summary>What did you find?</summary>
# With a weight of zero the walls have no influence: the car heads straight for the goal and hits the doorpost, <i>whatever the push</i>. An acceleration counts for nothing without its metric. With a push of zero and a small weight it collides
# too; with a large weight it gets through even without a push, since the brake alone holds the car off. Between these, the car passes the post on much the same path over a wide range of push and weight: a metric that fades with distance makes the parameters uncritical. The gain
# hardly changes the path, but it changes the time: pull and damping balance at gain / 3.0, which is 0.8 m/s at a gain of 2.4 and only 0.2 m/s at 0.6. There the 12 seconds run out.
# </details>
#
# ### Why the car must be able to reverse
#
# Table I of the paper asks for targets up to **one metre behind** the car. The policies above only drive forwards to what lies ahead. The library's `RMPController` ([`control/rmp.py`](../tutorial_lib/driving/control/rmp.py)) blends the same policies, but first it
# chooses an *arc* to the waypoint, forwards or in reverse, and turns in several moves where one arc is too tight.
#
# **Predict:** a car that never reverses, and the library's car, both know exactly where the target is. Driving an episode with a controller is a [[rollout]]. Of all episodes whose target lies behind the car, in what share will each of them reach it?


# %% hidden=true
# An oracle policy, and how all episodes are driven at once
class ToTargets:
    """An oracle policy: it knows the positions of the targets."""

    def __init__(self, simulation, goals, controller):
        self.simulation, self.goals, self.controller = simulation, goals, controller

    def act(self, observations, robots):
        waypoints = to_local(self.simulation.poses[robots], self.goals[robots, :2])
        return self.controller.act(observations, waypoints)


def oracle_policy(goals, controller):
    return lambda simulation: ToTargets(simulation, goals, controller)


def run(make_policy, episodes, body=car, record=None):
    """Roll out all episodes at once."""
    simulation = Simulation(episodes.recorded.scene, episodes.starts, body=body)
    ends = ReachGoals(episodes.goals[:, :2], episodes.limit)
    return rollout(simulation, make_policy(simulation), ends, record)


# %% hidden=true
# Targets behind the car: a car that never reverses, and one that may
never = 1e6  # cost of reversing, and the room it needs
forwards = RMPController(reverse_cost=never, go_on=never, begin=never)
behind = draw_episodes(recorded, paths, 400, np.random.default_rng(5))
straight_behind = relative(behind.starts, behind.goals)[:, 0] < -0.3
behind = behind.subset(np.flatnonzero((behind.ahead < 0) & straight_behind))
results = {
    name: run(oracle_policy(behind.goals, controller), behind)
    for name, controller in (("never reverses", forwards), ("may reverse", RMPController()))
}
for name, rollouts in results.items():
    print(f"{name}: {rollouts.reached.sum()} of {len(behind)} targets behind the car reached")
differ = results["may reverse"].reached & ~results["never reverses"].reached
one = int(np.where(differ, -relative(behind.starts, behind.goals)[:, 0], 0).argmax())
panels = []
for rollouts in results.values():
    steps = round(rollouts.seconds[one] / STEP)
    track = rollouts.poses[: steps + 1, one]
    picture = map_with(track[0], behind.goals[one], track[:, :2])
    for pose in track[[steps // 3, 2 * steps // 3, steps]]:
        view.robot(picture, pose, car.footprint)
    corners = np.concatenate(
        [r.poses[: round(r.seconds[one] / STEP) + 1, one, :2] for r in results.values()]
    )
    panels.append(closeup(view, picture, corners, 0.6, square=True))
show(side_by_side(panels, list(results), height=420))

# %% [markdown]
# A car needs 1.6 m of width for a half circle (notebook 01; the rear axle drives a circle of 1.24 m, the corners sweep more). Few places of an apartment are that wide, so a car that only drives forwards must make a long detour to get 50 cm back. This is a property of the *body*, and no
# network can make up for it.
#
# ## 3 · Which waypoint should the network predict?
#
# The network learns from examples, and each example needs a [[label]]: the right waypoint. We have the recorded trajectory and, in simulation, the map. The paper takes waypoints from the planner that drove the trajectories (A*, section IV). Our rule is that of its authors' code, applied to the trajectory itself:
#
# - the waypoint is **the farthest point of the trajectory, up to the target, that is in clear sight**: a straight line leads there and keeps 6 cm from every wall;
# - a target that was recorded at or before the start's own frame (`target <= source`) is its own waypoint, in sight or not;
# - where no candidate is in sight there is no label: `None`.
#
# The car never has to drive around a corner in one step. It drives to the corner, takes a new image, and gets a new waypoint. And a car that has left the trajectory is led *back to it*, where the path was free of obstacles.
#
# ### Exercise 4 · `waypoint_label` (medium, 12 minutes)
#
# <details><summary>Hint 1: concept</summary>"Farthest" means farthest along the trajectory: the frame with the largest index. A point may be hidden by a post while a later one is in sight again.</details>
# <details><summary>Hint 2: approach</summary>First handle a target that is not after the source. Otherwise take the points track[source + 1 : target + 1, :2], find with sees(start[:2], points) which of them are in clear sight, and use the last one. If there is none, return None: such a pair is discarded.</details>
# <details><summary>Hint 3: one line</summary><code>np.flatnonzero(flags)</code> gives the indices of the True ones; the last of them is index −1, if there is any. <code>to_local(start, point)</code> from the library gives a point as seen from the start.</details>


# %% exercise="waypoint_label"
def waypoint_label(start, track, source, target, sees):
    """The farthest point of a trajectory in clear sight, in the start's frame.

    start: (3,) pose beside the trajectory's frame `source`. track: (T, 3)
    poses of the trajectory.
    source, target: indices of frames; candidates are source + 1 to target,
    both included.
    sees: sees(place (2,), points (C, 2)) returns which points are in clear
    sight, (C,) bool.
    Returns an array (2,) as seen from `start`, or None where no candidate is
    in sight.
    """
    ### BEGIN SOLUTION
    if target <= source:
        return to_local(start, track[target, :2])
    points = track[source + 1 : target + 1, :2]
    seen = np.flatnonzero(sees(start[:2], points))
    return to_local(start, points[seen[-1]]) if len(seen) else None
    ### END SOLUTION


# %%
waypoint_label = check_waypoint_label.use(waypoint_label)

# %% [markdown]
# Now on a recorded trajectory. Five starts are *perturbed*: moved aside by 0.3 m and turned by 9 degrees (standard deviations), as in the authors' code, so that the network also learns from views off the trajectory. **Predict:** the
# target is beyond a corner. Where will the green waypoints of the starts lie: all at the same point?

# %% hidden=true
# Waypoint labels of five perturbed starts before a corner
sees = clear_sight(scene.caster)
sources = recorded.frame_at(episodes.targets, np.full(len(episodes), -2.8))
hidden = ~scene.caster.sees(recorded.poses[sources, :2], episodes.goals[:, :2])
far_enough = recorded.arc[episodes.targets] - recorded.arc[sources] > 2.7


def short_of_target(i):
    """Distance from the waypoint of episode i to its target, m."""
    pose, target = recorded.poses[sources[i]], episodes.targets[i]
    waypoint = waypoint_label(pose, recorded.poses, sources[i], target, sees)
    if waypoint is None:
        return 0.0
    return np.linalg.norm(to_world(pose, waypoint) - recorded.poses[target, :2])


corner_case = max(np.flatnonzero(hidden & far_enough), key=short_of_target)
source, target = sources[corner_case], episodes.targets[corner_case]
beside, found = perturbed(
    scene,
    np.repeat(recorded.poses[[source]], 5, axis=0),
    PAPER_PERTURBATION,
    np.random.default_rng(2),
)
picture = view.base.copy()
view.polyline(picture, recorded.poses[source : target + 1, :2], colours.PATH, 3)
view.goal(picture, recorded.poses[target, :2])
for pose in beside[found]:
    waypoint = waypoint_label(pose, recorded.poses, source, target, sees)
    view.robot(picture, pose, car.footprint)
    if waypoint is not None:
        place = to_world(pose, waypoint)
        view.polyline(picture, [pose[:2], place], colours.GOAL, 1)
        view.points(picture, place, colours.GOAL, 4)
show(closeup(view, picture, recorded.poses[source : target + 1, :2], 1.2))

# %% [markdown]
# <details><summary>Are they all at the same point?</summary>
# No. A car farther out in the bend sees farther around it. The lines pass the corner at a distance of 6 cm. (The car is 24 cm wide and would collide there: obstacle avoidance is the job of the motion policies, not of the waypoint.)
# </details>
#
# ### How much do two images overlap?
#
# The network also learns the [[mutual overlap]] of the two images (paper, III-B): the share of one camera's view that the other camera sees too, in both directions. The robot needs it in notebook 04, to judge how close it is to a
# target. The computation: cast 100 rays from one camera; each ends at a point of a wall, which is pulled back by 6 cm; count the points that lie in the other's field of view, with nothing in between.
#
# **Predict:** one camera stands 1.5 m behind the other, and both look the same way. Which share is larger: that of the *rear* view that the front camera sees, or that of the *front* view that the rear camera sees?

# %% hidden=true
# What the rear and the front camera see of each other's view
half_view = np.deg2rad(60.0)
rays = Fan(2 * half_view * ((np.arange(100) + 0.5) / 100 - 0.5))


def points_in_view(viewer, other):
    """100 points (100, 2) that the viewer sees, and which of them the other sees too."""
    distance = scene.caster.cast(viewer[None], rays).distance[0]
    reach = np.maximum(distance - 0.06, distance / 2)
    angles = viewer[2] + rays.angles
    points = viewer[:2] + reach[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    x, y = to_local(other, points).T
    in_view = np.abs(np.arctan2(y, x)) <= half_view
    return points, in_view & scene.caster.sees(np.broadcast_to(other[:2], points.shape), points)


front = np.array([0.85, -6.0, np.pi / 2])
rear = compose(front, [-1.5, 0.0, 0.0])
panels, titles = [], []
for name, viewer, other in (("rear", rear, front), ("front", front, rear)):
    points, both = points_in_view(viewer, other)
    picture = view.base.copy()
    view.rays(picture, viewer, points[~both], colours.FAINT)
    view.rays(picture, viewer, points[both], colours.LASER)
    for pose in (rear, front):
        view.robot(picture, pose, car.footprint)
    panels.append(closeup(view, picture, np.array([[-0.4, -7.8], [2.0, -0.6]]), 0.2))
    titles.append(f"{name} view: {both.mean():.0%} shared")
by_library = mutual_overlap(scene.caster, rear[None], front[None])[0]
print(f"the library returns {by_library[0]:.0%} and {by_library[1]:.0%}")
show(side_by_side(panels, titles, height=600))

# %% [markdown]
# <details><summary>Which is larger, and why are there two numbers?</summary>
# The share of the <i>front</i> view that the rear camera sees: what lies before both of them is seen by both, and the front camera sees little else. The rear camera also sees the walls beside the front one, at its edges.
# So the two numbers show which camera is ahead: when the target is <i>ahead</i> of the car, the car sees a large share of the target's view, and the target a smaller share of the car's. One number could not show that.
# </details>
#
# ## 4 · Comparing two images
#
# ### The paper's design, and a saving in it
#
# Some terms first. A *layer* multiplies its input by weights and adds up; a *convolution* is a layer that uses the same weights at every position of an image; an [[encoder]] is a few layers that turn an image into a *feature vector*, a list of numbers that describe it; the [[loss]] is the error that training reduces, step by step.
#
# The images have 3 channels (red, green, blue). The paper stacks *nine*: the current image, the target, and their difference, $[\,\text{cur},\ \text{tgt},\ \text{cur} - \text{tgt}\,]$, and feeds them to convolutions (III-B). Its
# first layer multiplies by weights and adds up: it is *linear*. With $A$, $B$, $D$ the weights of the three parts
#
# $$ A\,\text{cur} + B\,\text{tgt} + D\,(\text{cur} - \text{tgt}) . $$
#
# Collect terms by image, and the layer splits into a part that sees only cur and one that sees only tgt. The results are exactly the same. Why do it? The current image is compared with $2k+1$ images of the target, and its part
# has to be computed only **once**. The target's part does not change while the car drives: it can be computed when the target is stored, and **cached**.
#
# **Predict:** with $k = 2$, by what factor do the multiplications of the first layer decrease when it is split? And when the target's part is cached as well?

# %%
torch.manual_seed(0)
layer = PairEncoder(channels=3, rows=16).stacked  # 48 filters, 16 rows by 5 columns
small = (
    torch.from_numpy(Camera().look(scene, np.array([start, goal]))[0]).movedim(-1, 1) / 127.5 - 1.0
)
cur, tgt = small[:1], small[1:]
with torch.no_grad():
    together = layer(torch.cat([cur, tgt, cur - tgt], dim=1))
    own, other, difference = layer.weight.split(3, dim=1)  # A, B and D
    for_cur = functional.conv2d(cur, own + difference, None, layer.stride, layer.padding)
    for_tgt = functional.conv2d(tgt, other - difference, layer.bias, layer.stride, layer.padding)
    apart = for_cur + for_tgt  # for_tgt can be cached
print(f"largest difference between stacked and split: {(together - apart).abs().max():.1e}")

# %% hidden=true
# Multiplications of the first layer, in millions per query
each = 48 * 16 * 5 * 32 / 1e6  # for one channel of one image
counts = [(k, 9 * (2 * k + 1), 3 * (2 * k + 2), 3) for k in (0, 2, 5)]
table(
    {"k": "d", "stacked": ".2f", "split": ".2f", "split and cached": ".2f", "times fewer": ".0f"},
    [[k, *(each * n for n in numbers), numbers[0] / numbers[2]] for k, *numbers in counts],
    caption="Million multiplications of the first layer for one query",
)

# %% [markdown]
# ### An encoder that matches columns
#
# Stacking compares what lies at the *same position* in both images. But when the car turns, everything shifts sideways by many columns. Our networks therefore use another encoder, which the paper does not have ([`learning/encoders.py`](../tutorial_lib/learning/encoders.py)). Both images are
# reduced to 32 columns with a feature vector each. Then **every column of one image is compared with every column of the other**: a table of 32 × 32 similarities, the [[correlation volume]]. Its *softmax* along a row, which turns similarities into shares that add up to 1, shows where a
# column reappears in the target; the features found there, and their position, are appended to the column's own features. (Both halves can still be computed separately; only the table depends on the pair.)
#
# The network gets no labels for matching columns. It is trained on waypoints, headings and overlaps.
#
# **Predict:** in the table, rows are the columns of the current image, from left to right, and columns those of the target. What do you expect when the two images are the *same*? When the car has turned 25° to the left? When it stands 1.5 m
# farther back, as the rear camera of section 3? Then run the cell: dark is the trained network's match, the orange dots are the ground truth from the map.

# %% hidden=true
# The network's matches (dark) and the true ones (orange) for four pairs of images
pretrained = WaypointNetwork("waypoint_k2")


def matches(first, second):
    """The network's table (32, 32) for the images from two poses."""
    images = pretrained.view.numbers(pretrained.view.render(scene, np.array([first, second])))
    with torch.no_grad():
        encoder = pretrained.network.encoder
        volume = encoder.volume(encoder.current(images[:1]), encoder.target(images[1:]))
    return volume.softmax(dim=-1)[0].numpy()


def seen_again(first, second):
    """Positions (T, 2) of the same points in the images from two poses, as shares of their widths."""
    fan = Camera(columns=32).fan
    distance = scene.caster.cast(first[None], fan).distance[0]
    angles = first[2] + fan.angles
    points = first[:2] + (distance - 0.01)[:, None] * np.stack(
        [np.cos(angles), np.sin(angles)], axis=1
    )
    x, y = to_local(second, points).T
    there = 0.5 - 0.5 * y / np.maximum(x, 1e-6) / np.tan(half_view)
    seen = (x > 0) & (there > 0) & (there < 1)
    seen &= scene.caster.sees(np.broadcast_to(second[:2], points.shape), points)
    here = 1 - (np.arange(32) + 0.5) / 32  # the fan runs from right to left
    return np.stack([here, there], axis=1)[seen]


panels = []
turned = compose(goal, [0.0, 0.0, np.deg2rad(25)])
for first, second in ((goal, goal), (turned, goal), (rear, front), (start, goal)):
    images = people_camera.look(scene, np.array([first, second]))[0]
    tables = matches(first, second), seen_again(first, second)
    panels.append(matches_picture(*images, *tables, side=320))
titles = ["the same image", "turned 25 degrees to the left"]
upper = side_by_side(panels[:2], titles, gap=40)
titles = ["1.5 m behind (section 3)", "the pair of section 1"]
show(stacked([upper, side_by_side(panels[2:], titles, gap=40)]))

# %% [markdown]
# <details><summary>How do you read it?</summary>
# The same image gives the diagonal: each column matches itself. A turn shifts the line to one side. (It is also slightly curved, since columns at the edge of a pinhole image cover smaller angles.) A car that stands farther back sees the target's content squeezed into the
# middle of its image: few rows, many columns, the line gets flatter. So the <i>shape</i> of the line encodes rotation and translation, and the layers that follow read them off. Plain walls give a pale smear: one piece of a plain wall looks like the next. Rows without an orange dot show something that is not in the other image; their shares must go somewhere, and mean nothing. Repeated
# furniture gives a second line, and a chance of a wrong match.
# </details>
#
# Is it worth it? The table below compares four encoders, trained in the same way, with $k = 2$, for the same number of steps: *pair* is the paper's in small (its Fig. 3 has about fifty times as many parameters), *separate* encodes each image into a feature vector of its own before they are compared, *stacked* puts all
# images into one stack. The paper found its design "much better" than the last two (III-B). (Three of them also learn where each image of the context was taken. The stack cannot, since it has no features of single images.) **Predict** the order before you look.

# %% hidden=true
# Four encoders, trained in the same way
ablation = load_result("ablation_encoder")
lines = sorted(ablation.rows, key=lambda line: -line["success"])
display(
    table(
        {
            "encoder": "",
            "parameters": ",d",
            "median error, m": ".2f",
            "mean error, m": ".2f",
            "success": ".1%",
            "95 % interval": "",
        },
        [
            [
                *(
                    line[name]
                    for name in ("variant", "parameters", "median_m", "mean_m", "success")
                ),
                f"{line['low']:.1%} to {line['high']:.1%}",
            ]
            for line in lines
        ],
        {"median error, m": min, "mean error, m": min, "success": max},
    )
)
print("paired differences on the same episodes:", *ablation.notes, sep="\n  ")

# %% [markdown]
# (Each was trained for a few minutes, less than the networks that you use. To train and evaluate them again takes a quarter of an hour: `.venv/bin/python -m tutorial_lib experiment meng_table1 --ablation encoder`.)
#
# ## 5 · Train a network
#
# For each pair of images the network learns three things: the waypoint; cosine and sine of the heading difference; the two overlaps. The loss is the weighted sum of the three errors ([`learning/losses.py`](../tutorial_lib/learning/losses.py) shows the weights, and where we differ from the paper's authors).
#
# The pretrained networks were trained for less than an hour each, in 120 worlds (homes, offices, halls, mazes and scanned maps), by [`learning/training.py`](../tutorial_lib/learning/training.py). You write that loop in small (with one rule more, the clipping of gradients), and train in some ten seconds. So we make it easy: $k = 0$, and *one* world, this apartment, in its own colours. The pairs are drawn from the 24 trajectories.
#
# The test is 40 episodes with targets more than a metre away. **Predict:** how will the car drive with a network that has *not* been trained yet?


# %% hidden=true
# The untrained network drives forty episodes
def targets_of(network, episodes):
    """The target images with their context, encoded once."""
    world = episodes.recorded
    frames = world.context(episodes.targets, network.architecture.k)
    return network.prepare(network.view.render(world.scene, world.poses[frames]))


def visual_policy(network, episodes, controller):
    """C: the network's waypoints, driven to by the controller."""
    targets = targets_of(network, episodes)
    return lambda simulation: TargetPolicy(ComposedController(network, controller), targets)


def closest(rollouts, episodes):
    """Smallest distance (N,) of each rollout to its target, m."""
    return np.linalg.norm(rollouts.poses[:, :, :2] - episodes.goals[:, :2], axis=2).min(axis=0)


def forty_of(episodes):
    """Forty episodes with targets more than a metre away."""
    gaps = np.linalg.norm(episodes.starts[:, :2] - episodes.goals[:, :2], axis=1)
    return episodes.subset(np.flatnonzero(gaps > 1.0)[:40])


forty = forty_of(episodes)
small_network = Architecture(k=0)
torch.manual_seed(0)
outcomes = {}
untrained = WaypointNetwork(LocalNetwork(small_network).eval())
outcomes["before"] = run(visual_policy(untrained, forty, RMPController()), forty)
print(f"before: {outcomes['before'].reached.sum()} of {len(forty)} targets reached")

# %% [markdown]
# ### Exercise 5 · `train_network` (large, 35 minutes)
#
# A *batch* is a few pairs with their labels. A *step* computes the loss of one batch, and moves all weights a little against its [[gradient]]. How far is decided by the *optimizer* and its [[learning rate]] $\eta$. The loop has seven rules:
#
# 1. **Every step draws one batch**, `draw_batch(step)`, with steps counted $t = 0, 1, \dots, T - 1$ (`max_steps` is $T$), and computes its loss once, with `loss_of(network, batch)`.
# 2. **The learning rate is set before every step.** It rises in $W$ steps (`warmup_steps`, at least 1), since the first gradients of a random network are wild, and then decays along half a cosine:
#    $$ \eta_t = \eta\,\min\Bigl(1, \frac{t + 1}{W}\Bigr)\cdot\tfrac12\Bigl(1 + \cos\frac{\pi t}{T}\Bigr). $$
# 3. **Gradients do not add up**: `optimizer.zero_grad()`, `loss.backward()`, `optimizer.step()`. Before the step, a gradient (of all weights together) that is longer than `max_norm` is shortened to it; others stay as they are. This is called *clipping*.
# 4. **Evaluate** after every `eval_interval` steps, and after the last step in any case: `validate(network)` returns the loss on pairs that the network does not learn from. During an evaluation the network is in evaluation mode, `network.eval()`, and no gradients are tracked, `with torch.no_grad():`. While it learns it is in training mode, `network.train()`.
# 5. **Keep the best**: whenever the validation loss is smaller than ever before, keep a *copy* of the weights, `deepcopy(network.state_dict())` (imported above). At the end the network gets the best weights back, `network.load_state_dict(...)`, and is in evaluation mode.
# 6. **End early**: when `patience` evaluations in a row were no better than the best before them, training ends.
# 7. **Return the history**: for each evaluation the steps made, the mean of the training losses since the last evaluation, and the validation loss.
#
# <details><summary>Hint 1: concept</summary>One loop over the steps. Most of its lines are the same in every step (rules 1 to 3); an <code>if</code> at its end holds the evaluation (rules 4 to 7). Write the first half, run the check, and go on from what it says.</details>
# <details><summary>Hint 2: approach</summary>The rate: <code>for group in optimizer.param_groups: group["lr"] = ...</code>. Clipping is one call, <code>torch.nn.utils.clip_grad_norm_(parameters, largest)</code>, between backward and step. <code>loss.item()</code> is the loss as a number; collect it in a list that you empty at every evaluation. For rules 5 and 6 remember the smallest validation loss and how many evaluations there have been since.</details>
# <details><summary>Hint 3: one line</summary>After how many steps? A runner who drinks after every 4 km and at the finish drinks when <code>kilometre % 4 == 0 or kilometre == length</code>. Mind that <code>step</code> counts from 0, and the history counts the steps made.</details>


# %% exercise="train_network"
def train_network(network, optimizer, draw_batch, loss_of, validate, plan):
    """Train a network, and leave it with the weights of its best evaluation.

    network, optimizer: of torch; both are changed in place.
    draw_batch: draw_batch(step) returns the batch of a step, from 0 on.
    loss_of: loss_of(network, batch) returns the loss, a tensor of one number.
    validate: validate(network) returns the validation loss, a float.
    plan: has max_steps, learning_rate (the highest), warmup_steps, max_norm,
    eval_interval and patience, as above.
    Returns a list with (steps made, training loss, validation loss) for each
    evaluation.
    """
    ### BEGIN SOLUTION
    history, losses = [], []
    lowest, weights, waited = np.inf, None, 0
    network.train()
    for step in range(plan.max_steps):
        warmup = min(1.0, (step + 1) / plan.warmup_steps)
        decay = 0.5 * (1 + np.cos(np.pi * step / plan.max_steps))
        for group in optimizer.param_groups:
            group["lr"] = plan.learning_rate * warmup * decay
        optimizer.zero_grad()
        loss = loss_of(network, draw_batch(step))
        loss.backward()
        torch.nn.utils.clip_grad_norm_(network.parameters(), plan.max_norm)
        optimizer.step()
        losses.append(loss.item())
        if (step + 1) % plan.eval_interval == 0 or step + 1 == plan.max_steps:
            network.eval()
            with torch.no_grad():
                validation = validate(network)
            network.train()
            history.append((step + 1, np.mean(losses), validation))
            losses = []
            waited += 1
            if validation < lowest:
                lowest, weights, waited = validation, deepcopy(network.state_dict()), 0
            if waited == plan.patience:
                break
    network.load_state_dict(weights)
    network.eval()
    return history
    ### END SOLUTION


# %%
train_network = check_train_network.use(train_network)

# %% [markdown]
# Now the loop trains the network: 400 steps of 64 pairs each, drawn from 7,680 pairs. The chart shows the validation loss while the network learns. (About 10 s. The training loss that is printed afterwards is larger, since it also counts how well the pose of the target's camera is predicted.) **Predict:** how many of the forty targets will the car reach afterwards? You saw above how few it reached untrained.

# %%
training_pairs = Source(
    [recorded],
    small_network,
    perturbation=PAPER_PERTURBATION,
    worlds=1,
    targets=240,
    close=0.0,
    vary=False,
)
blocks = [training_pairs.block([0, number]) for number in range(8)]
validation_pairs = [replace(training_pairs, targets=64, starts=2).block([1, 0])]


def draw_batch(step):
    """16 targets with 4 starts each; a block holds 15 batches."""
    part = 16 * (step % 15)
    return blocks[step // 15 % len(blocks)].targets(slice(part, part + 16))


plan = TrainingPlan(
    max_steps=400,
    learning_rate=4e-3,
    warmup_steps=40,
    max_norm=5.0,
    eval_interval=40,
    patience=5,
)

# %% hidden=true
# The validation loss while the network learns
measured = []


def loss_chart():
    """The validation loss over the steps."""
    figure, (axis,) = chart(7.0, 3.0)
    steps = plan.eval_interval * np.arange(1, len(measured) + 1)
    axis.plot(steps, measured, "o-", color="0.2", clip_on=False)
    axis.set(
        xlabel="steps, each with 64 pairs of images",
        ylabel="validation loss",
        xlim=(0, plan.max_steps),
        ylim=(0, None),
    )
    return show(from_figure(figure), "the validation loss over the steps of the training")


def validate_and_draw(network):
    """The validation loss, which is added to the chart."""
    measured.append(validate(network, validation_pairs)["validation"])
    handle.update(loss_chart())
    return measured[-1]


handle = display(loss_chart(), display_id=True)

# %%
torch.manual_seed(0)
trained = LocalNetwork(small_network)
optimizer = torch.optim.Adam(trained.parameters(), plan.learning_rate)
measured.clear()
history = train_network(trained, optimizer, draw_batch, total_loss, validate_and_draw, plan)
for step, training, validation in history[::3]:
    print(f"after {step} steps: training loss {training:.2f}, validation loss {validation:.2f}")

# %% hidden=true
# Forty episodes before training, after it, and with the pretrained network
learnt = WaypointNetwork(trained)
outcomes["after 400 steps"] = run(visual_policy(learnt, forty, RMPController()), forty)
outcomes["pretrained, k = 2"] = run(visual_policy(pretrained, forty, RMPController()), forty)
panels, titles = [], []
for name, rollouts in outcomes.items():
    picture = view.base.copy()
    for robot in range(0, 40, 4):
        track = rollouts.poses[: round(rollouts.seconds[robot] / STEP) + 1, robot]
        view.polyline(picture, track[:, :2], colours.TRACK, 8)
        view.robot(picture, track[0], 1.4 * car.footprint)
        draw_outcome(view, picture, forty.goals[robot, :2], rollouts.reached[robot])
    panels.append(picture)
    titles.append(f"{name}: {rollouts.reached.sum()} of 40")
    near = np.median(closest(rollouts, forty))
    print(
        f"{name}: {rollouts.reached.sum()} of {len(forty)} reached, closest approach {near:.2f} m (median)"
    )
show(stacked([side_by_side(panels, titles, height=460), outcome_legend()]))

# %% [markdown]
# Ten of the 40 rollouts are drawn; a disc is a target that was reached, a cross one that was not.
#
# Has the network learnt *this apartment*, or has it learnt to *compare images*? **Predict** how many of 40 targets it reaches in another apartment, in which neither network was trained.

# %% hidden=true
# The same networks in another apartment
elsewhere = scene_of(local_world(10_008))
other_trajectories = demonstrate("another", elsewhere, 24, seed=0, controller=RMPController())
other_world = RecordedWorld(elsewhere, other_trajectories)
other_paths = GridPaths(elsewhere.clearance)
others = forty_of(draw_episodes(other_world, other_paths, 120, np.random.default_rng(0)))
for name, network in (("trained for a few seconds", learnt), ("pretrained, k = 2", pretrained)):
    rollouts = run(visual_policy(network, others, RMPController()), others)
    print(f"elsewhere, {name}: {rollouts.reached.sum()} of {len(others)} targets reached")

# %% [markdown]
# <details><summary>What has it learnt?</summary>
# Before training, the network predicts nearly the same waypoint for every input, so every car drives much the same curve. After 400 steps many rollouts end at their target or close to it. Some of what it learnt is useless anywhere else: the appearance of these
# rooms. But much of it is not: in the other apartment it reaches about as many targets as here. A column that reappears further left means the same in every building, and to find it again the network only needs to compare colours. This is why the matching encoder learns from so little data. What the long training in
# 120 worlds adds is precision, and robustness to the colours, turns and hidden targets that one apartment does not have.
# </details>
#
# ## 6 · Drive by camera
#
# Now the pretrained network, in an apartment in which it was not trained. The two parts are combined as in the formula, and the same $\mathcal C_{WP}$ also drives another robot: a round one with differential drive that can turn in place. **Only $\mathcal C_{RMP}$ is exchanged**; the network is not retrained
# (paper, III-B: it is "agnostic to robot dynamics"). For comparison, an oracle that knows the position of the target also drives both robots, so that only the body counts. **Predict:** which of the two robots will be more successful?

# %% hidden=true
# A car and a round robot, driven by the same network
round_robot = DifferentialDrive()
fits = episodes.subset(np.flatnonzero(is_free(scene, round_robot, episodes.starts)))
tracks = {}
for name, body in (("car", car), ("round robot", round_robot)):
    tracks[name] = run(visual_policy(pretrained, fits, RMPController(body=body)), fits, body)
    by_oracle = run(oracle_policy(fits.goals, RMPController(body=body)), fits, body)
    print(
        f"{name}: {tracks[name].reached.sum()} of {len(fits)} targets reached by camera, "
        f"{by_oracle.reached.sum()} by the oracle"
    )
apart = np.abs(relative(fits.starts, fits.goals)[:, 1])
both = tracks["car"].reached & tracks["round robot"].reached
shown = int(np.where(both, apart, 0).argmax())
panels = []
for name, body in (("car", car), ("round robot", round_robot)):
    rollouts = tracks[name]
    track = rollouts.poses[: round(rollouts.seconds[shown] / STEP) + 1, shown]
    picture = view.base.copy()
    view.goal(picture, fits.goals[shown, :2])
    view.polyline(picture, track[:, :2], colours.TRACK, 3)
    for pose in track[:: max(1, len(track) // 4)]:
        view.robot(picture, pose, body.footprint)
    corners = np.concatenate([fits.starts[[shown], :2], fits.goals[[shown], :2]])
    panels.append(closeup(view, picture, corners, 1.2, square=True))
show(side_by_side(panels, list(tracks), height=420))

# %% [markdown]
# <details><summary>Is the round robot better, since it can turn in place?</summary>
# With the oracle, either body reaches nearly every target: the body is not the cause. What is missing with the camera is due to the waypoints, and turning in place does not fix a wrong waypoint. The network was trained on starts beside trajectories of a <i>car</i>, turned by some
# tens of degrees at most. A robot that turns in place soon looks in directions in which no training image was taken.
# </details>
#
# And a film: the map is only for us; the car gets its camera, its laser, and the target's images. The green line leads to the current waypoint. **Predict:** will the waypoint stay in place, or move?

# %% hidden=true
# Film: a car drives by camera, from above and as it sees
long_path = (fits.ahead > 2.0) & tracks["car"].reached
filmed = int(np.where(long_path, apart + fits.ahead, 0).argmax())
one_episode, predictions = fits.subset(np.array([filmed])), []
its_target = targets_of(pretrained, one_episode)


def keep_waypoint(simulation, robots, observations, actions):
    waypoint, _ = pretrained.predict(observations, its_target)
    predictions.append(to_world(simulation.poses[robots], waypoint))


policy = visual_policy(pretrained, one_episode, RMPController())
rollouts = run(policy, one_episode, record=keep_waypoint)
track, goal_pose = rollouts.poses[:, 0], one_episode.goals[0]
images = people_camera.look(scene, np.concatenate([track, goal_pose[None]]))[0]
film = []
for step in range(0, len(predictions), 2):
    waypoint = predictions[step]
    picture = view.base.copy()
    view.goal(picture, goal_pose[:2])
    view.polyline(picture, track[: step + 1, :2], colours.TRACK, 3)
    view.polyline(picture, [track[step, :2], waypoint[0]], colours.GOAL, 2)
    view.points(picture, waypoint, colours.GOAL, 5)
    view.robot(picture, track[step], car.footprint)
    above = closeup(view, picture, np.array([track[0, :2], goal_pose[:2]]), 1.2, square=True)
    views = [camera_picture(images[step], 320), camera_picture(images[-1], 320)]
    film.append(side_by_side([above, stacked(views, ["now", "target"])], height=340))
play(film, 5, count=3)

# %% [markdown]
# ## 7 · How it fails
#
# With context the car misses so few targets that there is little to study. So here it drives by single images, $k = 0$: 200 episodes, 100 here and 100 in a maze, most of which succeed. What do the failures have in common? For each episode we check four conditions that could matter, and compare the failure rates with and without each. **Predict** which of the four hurts most.

# %% hidden=true
# 200 episodes by single images, and what their failures have in common
places = [(scene, recorded, paths, view)]
maze_world = local_world(10_006)
maze = scene_of(maze_world)
maze_trajectories = demonstrate(maze_world, maze, 24, seed=0, controller=RMPController())
places.append(
    (
        maze,
        RecordedWorld(maze, maze_trajectories),
        GridPaths(maze.clearance),
        PlanView(maze, 1000, 1000),
    )
)
single_image = WaypointNetwork("waypoint_k0")
cases = []
for place, (where, world, geodesics, _) in enumerate(places):
    hundred = draw_episodes(world, geodesics, 100, np.random.default_rng(11))
    rollouts = run(visual_policy(single_image, hundred, RMPController()), hundred)
    overlap = mutual_overlap(where.caster, hundred.starts, hundred.goals).min(axis=1)
    room = np.minimum(
        where.clearance.at(hundred.starts[:, :2]), where.clearance.at(hundred.goals[:, :2])
    )
    near = closest(rollouts, hundred)
    for i in range(100):
        traits = {
            "target behind": hundred.ahead[i] < 0,
            "little overlap (< 0.1)": overlap[i] < 0.1,
            "tight place (< 0.3 m to a wall)": room[i] < 0.3,
            "target hidden from the start": not where.caster.sees(
                hundred.starts[[i], :2], hundred.goals[[i], :2]
            )[0],
        }
        cases.append(
            {
                "place": place,
                "robot": i,
                "traits": traits,
                "failed": not rollouts.reached[i],
                "collided": rollouts.collided[i],
                "near": near[i],
                "rollouts": rollouts,
                "episodes": hundred,
            }
        )
failed = [case for case in cases if case["failed"]]
collided = sum(case["collided"] for case in failed)
print(
    f"{len(failed)} of {len(cases)} failed: {collided} collided, {len(failed) - collided} ran out of time"
)
print(
    f"{sum(case['near'] < 0.5 for case in failed)} of them came within half a metre of the target"
)
rows = []
for trait in cases[0]["traits"]:
    groups = [
        [case["failed"] for case in cases if bool(case["traits"][trait]) == has]
        for has in (True, False)
    ]
    shares = [f"{np.mean(group):.0%} of {len(group)}" for group in groups]
    rows.append([trait, *shares])
table({"condition": "", "failed with it": "", "failed without it": ""}, rows)


# %% hidden=true
# Three failures, each at four moments, with the final image and the target's
def failure_strip(case):
    """Four moments of a failed rollout, and the final image beside the target image."""
    where, _, _, plan = places[case["place"]]
    rollouts, hundred, robot = case["rollouts"], case["episodes"], case["robot"]
    track = rollouts.poses[: round(rollouts.seconds[robot] / STEP) + 1, robot]
    moments = []
    for step in np.linspace(0, len(track) - 1, 4).round().astype(int):
        picture = plan.base.copy()
        plan.goal(picture, hundred.goals[robot, :2])
        plan.polyline(picture, track[: step + 1, :2], colours.TRACK, 3)
        plan.robot(picture, track[step], car.footprint)
        corners = np.concatenate([track[:, :2], hundred.goals[[robot], :2]])
        moments.append(closeup(plan, picture, corners, 0.6, square=True))
    images = people_camera.look(where, np.array([track[-1], hundred.goals[robot]]))[0]
    views = stacked([camera_picture(image, 220) for image in images], ["final", "target"], gap=4)
    maps = side_by_side(
        moments,
        [f"{0.1 * s:.1f} s" for s in np.linspace(0, len(track) - 1, 4).round()],
        height=170,
        gap=6,
    )
    return side_by_side([maps, views], gap=8)


chosen = []
for trait in (
    "target behind",
    "little overlap (< 0.1)",
    "tight place (< 0.3 m to a wall)",
    "target hidden from the start",
):
    chosen += [case for case in failed if case["traits"][trait] and case not in chosen][:1]
chosen = (chosen + [case for case in failed if case not in chosen])[:3]
titles = []
for case in chosen:
    causes = [trait for trait, has in case["traits"].items() if has] or ["none of the four"]
    ending = "collided" if case["collided"] else "out of time"
    titles.append(f"{ending}, {case['near']:.2f} m from the target at best: {', '.join(causes)}")
show(stacked([failure_strip(case) for case in chosen], titles, gap=10))

# %% [markdown]
# <details><summary>What are the causes?</summary>
# One condition stands out. Where the two images overlap by less than a tenth, about one episode in four fails; of the others hardly any. There is nothing to match: the network must guess from what rooms usually look like. Targets <i>hidden</i> from the start are too rare here to judge (7 episodes).
# A target behind the car and a tight place do no harm: $\mathcal C_{RMP}$ reverses and avoids obstacles, with the laser. For the same reason there are no collisions. Not every failure is a wrong guess. In the first of the pictures the target is close behind the car: it
# drives away, comes back in reverse, and is just outside the circle when its time is up. In the other two the overlap is small, and the car never gets near its target. (The conditions seldom occur alone, and 200 episodes are few: differences of a few points mean nothing here.)
#
# The controller itself notices none of this. That is the subject of notebook 03: to <i>predict</i> which targets it will reach.
# </details>
#
# ### Find the bug
#
# A colleague computes the context of targets for the whole recording at once, "which is simpler". It runs without an error, and training with it goes well; only the success rate near the ends of trajectories is strangely low. Look at the five images of a target in context, and decide what is wrong before you unfold the
# answer.


# %%
def context_frames(world, frames, k):
    """The 2k + 1 frames around each of `frames` (N,)."""
    around_it = frames[:, None] + 3 * np.arange(-k, k + 1)
    return np.clip(around_it, 0, len(world.poses) - 1)


# %% hidden=true
# The context of a target near the end of a trajectory, by the colleague's function
near_the_end = np.array([recorded.last[0] - 2])
images = people_camera.look(scene, recorded.poses[context_frames(recorded, near_the_end, 2)[0]])[0]
show(side_by_side([camera_picture(image, 185) for image in images], names, gap=6))

# %% [markdown]
# <details><summary>Answer</summary>
# The recording is many trajectories laid end to end. Near the end of one, the frames "after" the target belong to the <i>next</i> trajectory, somewhere else in the building: the last images show another room. The frames must be clipped to the target's own trajectory, whose last frame is
# repeated: <code>np.clip(around_it, world.first[frames, None], world.last[frames, None])</code>, as in <code>RecordedWorld.context</code> (<a href="../tutorial_lib/driving/data/recorded_world.py">recorded_world.py</a>). Bugs in data do not crash. Looking at a few examples of the network's actual inputs finds most of them.
# </details>
#
# ## 8 · Table I
#
# The paper compares its controllers on targets from 1 m behind to 3 m ahead in four unseen buildings: *direct* is a network that maps the images straight to the car's controls, without a waypoint; the others are $\mathcal C$ with more and more context. Below is our counterpart. **Same protocol, easier
# world:** straight walls with painted stripes and even light instead of scanned buildings. A target counts as reached when the car comes within 0.3 m in time and without a collision. *Random* drives to random waypoints, and the [[oracle]] knows the map: no controller can be expected to be much better. The best controller between the two is bold. *Laser* is the same network with 64 distances in place of
# the image, as in the paper's laser variant.
#
# The paper leaves some of the protocol open. Here a start has 5 cm of clearance all around, is at least 0.3 m from its target, and its view may have no overlap with the target image. The paper's *direct* controller has $k = 0$, ours $k = 2$. And here $\mathcal C$ drives to a moving average of its last waypoints, in which the newest one has a share of 0.3 and which the wheel odometry carries along. The paper's does not, nor does yours in section 6: each of its waypoints comes from one image, and errs a little differently.
#
# **Predict:** how much does context help, and how far below the oracle are the controllers?

# %% hidden=true
# Success rates beside the paper's, with 95 % intervals
result = load_result("meng_table1")
ours = {(line["controller"], line["condition"]): line for line in result.rows}
order = ["random", "direct", "k0", "k2", "k5", "laser", "oracle"]
figure, (axis,) = chart(9.0, 3.8)
for place, name in enumerate(order):
    line = ours[name, "clean"]
    aside = 0.2 if line["paper"] is not None else 0.0
    error = np.abs([[line["success"] - line["low"]], [line["high"] - line["success"]]])
    paint = colours.unit(colours.FAINT if name in ("random", "oracle") else colours.ROBOT)
    axis.bar(place - aside, line["success"], 0.38, color=paint, yerr=error, capsize=3)
    text = {"ha": "center", "fontsize": 11}
    axis.text(place - aside, line["high"] + 0.02, f"{100 * line['success']:.1f}", **text)
    if line["paper"] is not None:
        axis.bar(place + aside, line["paper"], 0.38, color=colours.unit(colours.PATH))
        axis.text(place + aside, line["paper"] + 0.02, f"{100 * line['paper']:.0f}", **text)
axis.set(
    ylim=(0, 1.08),
    ylabel="success rate",
    title="numbers in %; blue and grey: ours, with 95 % intervals; orange: the paper",
)
names = {
    "k0": "waypoint, k = 0",
    "k2": "waypoint, k = 2",
    "k5": "waypoint, k = 5",
    "laser": "laser, k = 2",
    "direct": "direct, k = 2",
}
axis.set_xticks(range(len(order)), [names.get(n, n).replace(", ", ",\n") for n in order])
show(from_figure(figure))


# %% hidden=true
# Table I under four conditions, and on maps from Nav2
def success_table(columns, caption):
    """A table of success rates; columns are (name, line of each controller)."""
    rows = []
    for name in order:
        row = [names.get(name, name)]
        for _, lines in columns:
            line = lines[name]
            row += [100 * line["success"], f"{100 * line['low']:.1f} to {100 * line['high']:.1f}"]
        rows.append(row)
    heads = {"controller": ""}
    for name, _ in columns:
        heads |= {f"{name}, %": ".1f", f"interval, {name}": ""}
    best = {f"{name}, %": lambda rates: max(rates[1:-1]) for name, _ in columns}
    return table(heads, rows, best, caption)


conditions = ("clean", "noise", "obstacles", "shifted")
by_condition = [(name, {c: ours[c, name] for c in order}) for name in conditions]
episodes_each = (
    f"{len(result.worlds)} unseen worlds, {ours['oracle', 'clean']['episodes']} episodes"
)
display(success_table(by_condition, f"Success rates with 95 % intervals: {episodes_each}"))
maps = {"depot": "depot", "tb3_sandbox": "TurtleBot3 sandbox", "warehouse": "warehouse"}
by_map = []
for name, title in maps.items():
    rows = load_result(f"meng_table1_{name}").rows
    by_map.append((title, {r["controller"]: r for r in rows if r["condition"] == "clean"}))
display(success_table(by_map, "On three maps from Nav2, which no network has seen"))

# %% [markdown]
# *noise*: both controls are multiplied by a random number from $\mathcal N(1, 0.33)$ ten times a second, as in the paper, which found "no noticeable difference" when its robots followed trajectories (IV-B). *obstacles*: two posts that are in no recording stand near the path; these are other episodes, at least 2 m long and with room to pass, so compare them within their own column. *shifted*: colours and light that no network has seen in
# training. The maps of the second table are occupancy grids that come with Nav2, the navigation software of ROS 2: their walls are crooked and have holes. (To run it again: `.venv/bin/python -m tutorial_lib experiment meng_table1`.)
#
# <details><summary>Why do our numbers differ from the paper's?</summary>
# In both, control through waypoints beats direct control. The paper's direct controller was trained to imitate forward acceleration and steering velocity; ours imitates speed and steering of the same demonstrator, and has k = 2. Our images are simpler than those of scanned buildings, which helps; but they have 16 rows in place of 64,
# the networks are small enough to train in less than an hour on a laptop, and the car is larger relative to its world: its rear axle needs 1.24 m for its tightest circle, the car in the authors' code 0.9 m. The oracle's row shows what the <i>body</i> and the time limit cost before any network is involved. Compare within one column; between
# the two simulators compare the order, not the numbers.
# </details>
# <details><summary>What does context do, and how far is the oracle?</summary>
# A single image is enough for nineteen targets in twenty. Context of k = 2 removes a third of the remaining failures, and k = 5 another quarter of those that are left; k = 5 is two points below the oracle. Context helps most where views are blocked: look at the obstacles column. Under <i>shifted</i> colours the random
# controller, the laser and the oracle perform exactly as before, since none of them uses colour. On the maps from Nav2 the laser loses eighteen points on one of the three, the camera's waypoints at most eight, with k = 5 at most two, and the oracle at most one: walls and rooms have other shapes there than in the training worlds, although halls and scanned plans are among these. <i>Direct</i> has little to lose: it stays within about fourteen points of its result here, to either side.
# </details>
# <details><summary>Why does noise hardly matter, and why would it matter for a robot that plans a whole path and executes it open loop?</summary>
# The loop is closed ten times a second: the effect of an error shows in the next image, and the next waypoint corrects it. Open loop, the errors would accumulate as those of the odometry did in notebook 01.
# </details>
# <details><summary>Two controllers differ by 2 points, and their intervals overlap. Is there a difference?</summary>
# The intervals show how much each number could vary in <i>other worlds</i>. Both controllers drove the <i>same</i> episodes, so what is hard for one is hard for both: look at the difference episode by episode. The notes below the table that the command prints do that, with an interval of the difference.
# </details>

# %% hidden=true
# Differences between controllers, episode by episode
print("\n".join(result.notes))

# %% [markdown]
# ## Optional extras
#
# - **Extra 1.** Let the network of section 5 drive in another apartment: `local_world(10_012)`. Then draw its blocks with `vary=True` and train it again, which changes the colours at random. What do you gain, and what does it cost?
# - **Extra 2.** Direct control: `DirectNetwork("direct_k2")` predicts speed and steering directly. Below it drives the forty episodes. Where does it fail where the waypoints do not?
# - **Extra 3.** Give the widget's car a `damping` of 1.0 in place of 3.0. What does it do at the door? What would a policy look like that keeps the car from driving faster than it can see?
# - **Extra 4.** In `waypoint_label`, let the label be the *nearest* point in sight that is at least 1 m away. Which rollouts would become smoother, and which worse?

# %% hidden=true
# Forty episodes by direct control and by three other networks
direct = DirectNetwork("direct_k2")
direct_targets = targets_of(direct, forty)
rollouts = run(lambda simulation: TargetPolicy(direct, direct_targets), forty)
print(
    f"direct control: {rollouts.reached.sum()} of {len(forty)} reached, {rollouts.collided.sum()} collided"
)
for name in ("waypoint_k0", "waypoint_k5", "laser_k2"):
    rollouts = run(visual_policy(WaypointNetwork(name), forty, RMPController()), forty)
    print(
        f"{name}: {rollouts.reached.sum()} of {len(forty)} reached, {rollouts.collided.sum()} collided"
    )

# %% [markdown]
# ## What to remember
#
# - $\mathcal C = \mathcal C_{RMP} \circ \mathcal C_{WP}$: images to a waypoint, a waypoint to the wheels. Either part can be exchanged without the other.
# - A motion policy is an acceleration *and how much it matters*. Pull back, sum, solve once.
# - The waypoint label is the farthest point of the trajectory in clear sight. A straight line leads to it.
# - The first layer of the comparison is linear, so the target's half can be computed once and cached. A map of hundreds of targets becomes affordable.
# - Control that closes the loop ten times a second is robust to noise. It is not robust to a wrong waypoint.
# - The controller does not know when it will fail.
#
# **Read next:** [the paper](https://arxiv.org/abs/1909.12329), III-C (*Learning the Reachability Estimator*), and then [notebook 03](03_reachability.ipynb), which addresses the last point. On motion policies: [Ratliff et al.](https://arxiv.org/abs/1801.02854)
