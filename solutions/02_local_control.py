# %% [markdown]
# # 02 · Local control
#
# **At the door.** Yesterday your robot learnt to see and to move, but an oracle turned its wheels. Now it's parked in the living room, near the hallway door, and you hold up a photo taken beyond that door. All the robot has is two images. *Which way should it steer?*
#
# In two sittings, you'll write code that turns images into steering. First comes a driver, pulled to its target and pushed off the walls. Then comes a network that looks. Your own training loop trains a small network in ten seconds; with a network trained for most of an hour, your robot nearly always reaches the place in the photo.

# %% hidden=true
# What the robot sees, and the photo (about 10 s)
from copy import deepcopy
from dataclasses import replace
from functools import partial

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
from tutorial_lib.checks.predictions import Prediction
from tutorial_lib.checks.robot import robot_name
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
from tutorial_lib.geometry import arc_length, compose, relative, to_local, to_world
from tutorial_lib.learning import (
    Architecture,
    LocalNetwork,
    PairEncoder,
    Source,
    WaypointNetwork,
    use_threads,
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
    world_name,
)

use_threads(1)  # the networks are small: a second thread would mostly wait
HOME = world_name("apartment", 2)  # no network was trained in it
scene = scene_of(HOME)
paths = GridPaths(scene.clearance)
recorded = RecordedWorld(scene, demonstrate(HOME, scene, 24, seed=0, controller=RMPController()))
episodes = draw_episodes(recorded, paths, 120, np.random.default_rng(0))
view = PlanView(scene, 1430, 2015)  # 130 pixels per metre: close-ups are cut out of it
car = BicycleCar()
people_camera = Camera(rows=64)  # the network's view, with 64 rows in place of 16


def images_from(*poses):
    """What the camera sees at poses, for people."""
    return people_camera.look(scene, np.array(poses))[0]


def now_and_photo(now, photo, width):
    """What the robot sees at a pose, above a photo taken at another."""
    pictures = [camera_picture(image, width) for image in images_from(now, photo)]
    return stacked(pictures, ["what it sees now", "the photo"], gap=4)


def map_with(start, goal, track=(), picture=None):
    """The plan with a target, its heading, a car and perhaps its track."""
    picture = view.base.copy() if picture is None else picture
    view.goal(picture, goal[:2])
    tip = to_world(goal, [0.7, 0.0])
    view.polyline(picture, [goal[:2], tip], colours.GOAL, 4)
    view.arrow(picture, [*tip, goal[2]], colours.GOAL, 9)
    view.polyline(picture, track, colours.TRACK, 4)
    view.robot(picture, start, car.footprint)
    return picture


def plan_of_pair():
    """The robot, the photo's place, and the recorded drive through it."""
    target = episodes.targets[example]
    whole = slice(recorded.first[target], recorded.last[target] + 1)
    picture = view.base.copy()
    view.polyline(picture, recorded.poses[whole, :2], colours.PATH, 3)
    map_with(start, goal, picture=picture)
    cut = closeup(view, picture, np.array([start[:2], goal[:2]]), 1.0, square=True)
    return side_by_side([cut], height=400)


hallway, living = scene.plan.rooms[:2]
through = living.contains(episodes.starts[:, :2]) & hallway.contains(episodes.goals[:, :2])
example = int(np.where(through, episodes.ahead, 0.0).argmax())
start, goal = episodes.starts[example], episodes.goals[example]
ahead, left, turn = relative(start, goal)
pair = now_and_photo(start, goal, 450)
steer = Prediction(
    "02",
    "steer",
    "Which way should the robot steer?",
    {"A": "to the left", "B": "straight ahead", "C": "to the right"},
    right="A",
    robot=f"it doesn't move. It has both images, but no code that compares them. The photo was "
    f"taken {ahead:.1f} m ahead and {abs(left):.1f} m to the {'left' if left > 0 else 'right'}.",
    tempting="C",
    because="there's orange on the photo's left, so you'd pass the orange ahead on its right. "
    "But they're two different walls. Find the hallway's dark far end: it's on the robot's left.",
    before=pair,
    after=side_by_side([pair, plan_of_pair()], gap=10),
)
display(steer)

# %% [markdown]
# **55 minutes, then 80.** The second sitting begins with section 6. You need notebook 01: frames, the car, the camera. A little linear algebra helps: a matrix times a vector, and a transpose. You need no experience with neural networks. Until your function passes its check, the cells below use the library's; from then on **they use yours**. You can skip folded code. We follow X. Meng, N. Ratliff, Y. Xiang and D. Fox, [*Scaling Local Control to Large-Scale Topological Navigation*](https://arxiv.org/abs/1909.12329), ICRA 2020.
#
# **Three old questions first.**
#
# <details><summary>Notebook 01: a door is 2 m ahead of the robot and 1 m to its left. The robot turns left by 90° in place. Where's the door now, in the robot's frame?</summary>
# At (1, −2): 1 m ahead, and 2 m to the right.
# </details>
# <details><summary>Notebook 01: half a metre to the car's left, or three metres ahead: which place is harder to reach?</summary>
# The one to the left. A car can't drive sideways; it must drive away and come back.
# </details>
# <details><summary>Notebook 00: what's an oracle good for?</summary>
# It knows the floor plan and the robot's position, so it shows what's possible. You compare your robot with it.
# </details>
#
# # First sitting · a driver (55 minutes)
#
# ## 1 · Two halves
#
# A [[local controller]] $\mathcal C$ takes two images: what the robot sees now, and a photo of its target. Ten times a second it gives a command, until the two images match. It has no map and no coordinates. It needn't cross a building, but it must cover a few metres reliably. It has two halves:
#
# $$ \mathcal C(o_\text{current}, o_\text{target}) \;=\; \mathcal C_{RMP}\bigl(\mathcal C_{WP}(o_\text{current}, o_\text{target})\bigr). $$
#
# $\mathcal C_{WP}$ is a network: two images in, a [[waypoint]] $(x, y)$ in the robot's frame out. It knows nothing of wheels. $\mathcal C_{RMP}$ drives to the waypoint by laser. It knows nothing of images. The waypoint is only a hint, and a new one comes ten times a second.
#
# You build the driver first. So in this sitting somebody *tells* the robot where its target is: an [[oracle]] gives the waypoint.
#
# ## 2 · The wheels towards it, and go
#
# The simplest driver turns its wheels towards the waypoint, and drives.

# %% hidden=true
# The simplest driver, at the door
door_start, door_goal = np.array([-2.03, -10.44, 1.23]), np.array([-0.6, -7.89])
near_door = np.array([[-2.6, -11.0], [0.0, -7.5]])


def drive(controls_of, start, goal):
    """A car's poses (T, 3) by given controls, and how the rollout ended."""
    simulation = Simulation(scene, start, sensors=Sensors(camera=None))
    track, ending = [simulation.poses[0]], "out of time"
    for _ in range(120):
        waypoint = to_local(simulation.poses[0], goal)
        simulation.step(controls_of(simulation.observe(), waypoint)[None])
        track.append(simulation.poses[0])
        if simulation.collided[0]:
            ending = "collided"
            break
        if np.linalg.norm(simulation.poses[0, :2] - goal) < 0.4:
            ending = "arrived"
            break
    return np.array(track), f"{ending} after {simulation.seconds:.1f} s"


def track_picture(picture, track, goal):
    """A track on a picture, with the car wherever none is near, and at the end."""
    view.goal(picture, goal)
    view.polyline(picture, track[:, :2], colours.TRACK, 4)
    shown = [track[0]]
    for pose in track:
        if np.linalg.norm(np.array(shown)[:, :2] - pose[:2], axis=1).min() > 0.55:
            shown.append(pose)
    for pose in [*shown, track[-1]]:
        view.robot(picture, pose, car.footprint)
    return picture


def simplest(_, waypoint):
    """Full speed ahead, and the wheels towards the waypoint."""
    return np.array([0.5, np.clip(2 * np.arctan2(waypoint[1], waypoint[0]), -0.45, 0.45)])


track, ending = drive(simplest, door_start, door_goal)
picture = track_picture(view.base.copy(), track, door_goal)
show(side_by_side([closeup(view, picture, near_door, 0.35)], [ending], height=430))

# %% [markdown]
# So something must push the car off the wall. The classic recipe adds up forces, and it has two flaws. A distant wall still skews the sum. And the push that stops a car *in front of* a wall disturbs it *next to* one. So each wish should also say how much it matters. A [[Riemannian motion policy]] (RMP; N. Ratliff et al., [*Riemannian Motion Policies*](https://arxiv.org/abs/1801.02854), 2018) has two parts:
#
# - an acceleration $a$: *what it wants*;
# - a [[metric]] $M$, a symmetric matrix: *how much that matters, and in which directions*.
#
# The **goal policy** pulls a point $x$ towards its goal $g$, damps its velocity, and weights all directions equally:
#
# $$ a = \gamma\,\frac{g - x}{\max(|g - x|,\ \varepsilon)} - \beta\,\dot x, \qquad M = I . $$
#
# The pull $\gamma$ is as strong at 3 m as at 1 m; only within $\varepsilon$ does it fade.
#
# ### Exercise 1 · `goal_policy` (easy, 8 minutes)
#
# <details><summary>Hint 1: concept</summary>The offset divided by its length is a unit vector: direction without distance. Near the goal, dividing by a tiny length would make the pull jump, hence the max.</details>
# <details><summary>Hint 2: approach</summary>np.linalg.norm(offsets, axis=-1, keepdims=True) gives each row its own length and keeps an axis to divide by. The metric is the identity for each row: np.broadcast_to(np.eye(2), shape).</details>
# <details><summary>Hint 3: one line</summary>With <code>lengths</code> of shape (N, 1), <code>rows / lengths</code> divides every row by its own length. Which two numbers must you compare before dividing, and what is subtracted at the end? The shape of the metrics is <code>(*offsets.shape, 2)</code>.</details>


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
# An **obstacle policy** knows one laser point: its distance $d$, and how fast that shrinks ($c$, in m/s). It pushes the car away, harder when the point is near or approaching fast. Its metric is large only nearby:
#
# $$ \ddot d = \frac{p + b\,\max(c, 0)}{d}, \qquad m = w\,e^{-d/\ell} . $$
#
# $p$ is the push, $b$ the brake, $w$ the weight at contact, and $\ell$ the length over which the weight fades. In both formulas, distances below 0.01 m count as 0.01 m. The brake acts only while the distance shrinks: nothing should pull the car back towards a wall it's leaving.
#
# ### Exercise 2 · `obstacle_policy` (easy, 8 minutes)
#
# <details><summary>Hint 1: concept</summary>Acceleration and metric do different jobs. The acceleration grows as the wall gets nearer; the metric decides how much it counts.</details>
# <details><summary>Hint 2: approach</summary>First limit the distances from below, np.maximum(distances, 0.01), and use the result in both formulas: at contact you would otherwise divide by zero.</details>
# <details><summary>Hint 3: one line</summary><code>np.maximum(speeds, 0)</code> keeps the positive speeds and sets the others to 0. Where does that belong, and what is the whole sum divided by? The metric takes one np.exp.</details>


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
# Each policy acts on its own quantity, such as the position of a point on the car, or a distance. But the robot can change only its two *controls*. The derivative of a quantity with respect to the controls is its [[Jacobian]] $J$: accelerate the controls by $u$, and the quantity accelerates by $J u$. Which $u$ suits all policies best? The one with the smallest squared error, weighted by the metrics:
#
# $$ u = \arg\min_u \sum_i (J_i u - a_i)^{\top} M_i\, (J_i u - a_i) \;=\; \Bigl(\sum_i J_i^{\top} M_i J_i\Bigr)^{-1} \sum_i J_i^{\top} M_i\, a_i . $$
#
# $J^{\top} M a$ is a policy's *force* on the controls, and $J^{\top} M J$ its metric on them. Computing both is the **pullback**; summing and solving is the **resolve** step. Where no policy weights a direction, the summed metric is singular. So you add $10^{-6}$ to its diagonal, and nothing moves in that direction.
#
# ### Exercise 3 · `resolve` (medium, 12 minutes)
#
# <details><summary>Hint 1: concept</summary>This is weighted least squares. Where two policies disagree, the result is their average, weighted by their metrics.</details>
# <details><summary>Hint 2: approach</summary>Begin with force = np.zeros(2) and metric = 1e-6 * np.eye(2). Loop over the policies and add J.T @ M @ a to the force and J.T @ M @ J to the metric. Solve once, at the end.</details>
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
# ## 3 · What the walls say
#
# First take the simplest robot, a disc that you can push in any direction: the Jacobian of its position is the identity. Your functions are called at every point of a grid. Arrows show accelerations, and ellipses show summed metrics, *long in the directions that matter*. Watch what the ellipses do next to a wall.

# %%
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


def field(places, scans, goal, push=0.12, weight=0.3, gain=2.4):
    """Resolved accelerations (P, 2) and metrics (P, 2, 2) of a disc at rest at `places` (P, 2)."""
    still = np.zeros(2)
    accelerations, metrics = [], []
    for place, beams in zip(places, scans, strict=True):
        near = beams < 1.0
        policies = [(np.eye(2), *goal_policy(goal - place, still, gain, 3.0, 0.35))]
        points = beams[near, None] * beam_rays[near]
        policies += keep_off(points, still, 0.15, np.eye(2), still, push, weight)
        accelerations.append(resolve(policies))
        metrics.append(sum(j.T @ m @ j for j, _, m in policies))
    return np.array(accelerations), np.array(metrics)


# %% hidden=true
# The resolved field near the door: accelerations as arrows, metrics as ellipses
def field_picture(corners, goal, **parameters):
    """The field on the part of the plan between two corners."""
    (x0, y0), (x1, y1) = corners
    grid = np.meshgrid(np.arange(x0 - 0.3, x1 + 0.4, 0.3), np.arange(y0 - 0.3, y1 + 0.4, 0.3))
    grid = np.stack(grid, axis=-1).reshape(-1, 2)
    grid = grid[scene.clearance.at(grid) > 0.12]
    scans = Laser().scan(scene, np.column_stack([grid, np.zeros(len(grid))]))
    picture = view.plain.copy()
    accelerations, metrics = field(grid, scans, goal, **parameters)
    draw_metrics(view, picture, grid, metrics)
    strength = np.linalg.norm(accelerations, axis=1, keepdims=True)
    draw_arrows(view, picture, grid, 0.24 * accelerations / np.maximum(strength, 2.4))
    view.goal(picture, goal)
    return picture


show(
    side_by_side([closeup(view, field_picture(near_door, door_goal), near_door, 0.35)], height=480)
)

# %% [markdown]
# In the open the ellipses are circles: only the goal has a say. Next to a wall they stretch *perpendicular* to it. Motion towards the wall matters and motion along it doesn't, so arrows may run freely along it.
#
# Now the car. Nobody can push it sideways: its controls are speed $v$ and steering $\delta$, and a point on the car at $(p_x, p_y)$ has the velocity
#
# $$ \begin{pmatrix}\dot x\\ \dot y\end{pmatrix} = \begin{pmatrix}1 & -p_y\\ 0 & p_x\end{pmatrix}\begin{pmatrix}v\\ \omega\end{pmatrix}, \qquad \omega = \frac{v}{L}\tan\delta . $$
#
# The point's Jacobian is this matrix (`point_jacobian`) times the Jacobian of $(v, \omega)$ (`control_jacobian`). The goal policy pulls the car's *nose*, and each laser point pushes four discs that cover the car.

# %%
nose = np.array([0.36, 0.0])
discs = cover(car)


def drive_by_policies(observation, waypoint, push=0.12, weight=0.3, gain=2.4):
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
# The door again: push and weight
def by_policies(corners, start, goal, **parameters):
    """The field, the car's track and how the rollout ended."""
    act = partial(drive_by_policies, **parameters)
    track, ending = drive(act, start, goal)
    picture = track_picture(field_picture(corners, goal, **parameters), track, goal)
    return side_by_side([closeup(view, picture, corners, 0.35)], height=430), ending


waiting = view.plain.copy()
view.goal(waiting, door_goal)
view.robot(waiting, door_start, car.footprint)
usual, strong = (
    by_policies(near_door, door_start, door_goal, push=push, weight=weight)
    for push, weight in ((0.12, 0.3), (0.6, 0.0))
)
post = Prediction(
    "02",
    "post",
    "The obstacles push five times as hard as usual, but with a weight of zero. What happens?",
    {
        "A": "the car keeps well clear of the doorpost",
        "B": "the car hits the doorpost",
        "C": "the car stops before the door",
    },
    right="B",
    robot=f"it {strong[1]}. With the usual push and weight it {usual[1]}.",
    tempting="A",
    because="the push is strong. But an acceleration counts only as much as its metric, and here "
    "that's zero: nobody hears it.",
    before=side_by_side([closeup(view, waiting, near_door, 0.35)], height=430),
    after=side_by_side([strong[0], usual[0]], ["a weight of zero", "the usual push and weight"]),
)
display(post)

# %% [markdown]
# Now you: does the car ever get through without a push? And what does the gain change, the path or the time?

# %% hidden=true
# The car drives through the door by your functions, with sliders
sliders(
    partial(by_policies, near_door, door_start, door_goal),
    {"push": "push p, m²/s²", "weight": "weight w at contact", "gain": "gain γ, m/s²"},
    push=(0.0, 0.6, 0.06, 0.12),
    weight=(0.0, 3.0, 0.3, 0.3),
    gain=(0.6, 3.6, 0.6, 2.4),
)

# %% [markdown]
# <details><summary>What did you find?</summary>
# Without a push, the car gets through from a weight of 0.6 up: the brake alone keeps it off the post. Otherwise push and weight hardly matter, as long as neither is zero: the metric fades with distance, so the car passes the post on much the same path. The gain changes the time: pull and damping balance at gain / 3.0, which is 0.8 m/s at a gain of 2.4. At 0.6 it's only 0.2 m/s, and time runs out.
# </details>
#
# ## 4 · Half a metre back
#
# Your policies only drive forwards. The library's `RMPController` ([`control/rmp.py`](../tutorial_lib/driving/control/rmp.py)) blends the same policies, but first it chooses an *arc* to the waypoint, forwards or in reverse. Where one arc is too tight, the car turns in several moves.
#
# Is reversing worth it? An [[episode]] has a start and a target. One drive of a controller through an episode is a [[rollout]]. Here two cars drive to targets up to a metre *behind* them: one never reverses, the other may. An oracle tells them where each target is.


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


def track_of(rollouts, robot):
    """The poses (T, 3) of one rollout."""
    return rollouts.poses[: round(rollouts.seconds[robot] / STEP) + 1, robot]


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
differ = results["may reverse"].reached & ~results["never reverses"].reached
one = int(np.where(differ, -relative(behind.starts, behind.goals)[:, 0], 0).argmax())
corners = np.concatenate([track_of(rollouts, one)[:, :2] for rollouts in results.values()])
panels, titles = [], []
for name, rollouts in results.items():
    track = track_of(rollouts, one)
    picture = map_with(track[0], behind.goals[one], track[:, :2])
    for pose in track[[len(track) // 3, 2 * len(track) // 3, -1]]:
        view.robot(picture, pose, car.footprint)
    panels.append(closeup(view, picture, corners, 0.6, square=True))
    titles.append(f"{name}: {rollouts.reached.sum()} of {len(behind)} targets")
show(side_by_side(panels, titles, height=400))

# %% [markdown]
# A car that never reverses must turn round first. A U-turn takes 1.6 m of width, and few places in a flat are that wide. Sometimes a loop through the next room would do, but a driver that only reacts doesn't look for one. A better network won't help; a car that may reverse does.
#
# ## 5 · Round the corner
#
# Your driver gets through a door. Now the target is in another room, round the corner. It isn't in sight, but the oracle says where it is. Your own functions draw the arrows.

# %% hidden=true
# A target round the corner
corner_start, corner_goal = np.array([-1.0, -10.3, np.pi / 2]), np.array([-2.4, -6.4])
near_corner = np.array([[-3.2, -10.6], [0.0, -4.8]])
waiting = field_picture(near_corner, corner_goal)
track, _ = drive(drive_by_policies, corner_start, corner_goal)
stuck = track_picture(waiting.copy(), track, corner_goal)
view.robot(waiting, corner_start, car.footprint)
short = np.linalg.norm(track[-1, :2] - corner_goal)
corner = Prediction(
    "02",
    "corner",
    "Where will the car be after twelve seconds?",
    {
        "A": "at the target: it finds the door",
        "B": "in the hallway, beside the wall",
        "C": "against the first doorpost: it collides",
    },
    right="B",
    robot=f"its time is up. It stands {short:.1f} m from the target, with a wall in between.",
    tempting="A",
    because="you see the door. But the policies look at the target and at the nearest walls, and "
    "nothing in them looks for a way round.",
    before=side_by_side([closeup(view, waiting, near_corner, 0.3)], height=520),
    after=side_by_side([closeup(view, stuck, near_corner, 0.3)], height=520),
)
display(corner)

# %% [markdown]
# The pull points through the wall, the wall pushes back, and the two balance: a **local minimum**. A driver that only reacts doesn't search. So a clear *straight line* must lead to the waypoint.
#
# ---
#
# **Stop here.** That's the first sitting: three functions, and a car that drives to a point in sight. Who tells it which point? When you come back, it'll look for itself.
#
# # Second sitting · learning to look (80 minutes)
#
# ## 6 · Which point?
#
# The network learns from examples, and each example needs a [[label]]: the right waypoint. You have a recorded drive and, in simulation, a map. The authors' code uses this rule:
#
# - the waypoint is **the farthest point of the trajectory, up to the target, that's in clear sight**: a straight line leads there and stays at least 6 cm from every wall;
# - a target at or before the start (`target <= source`) is its own waypoint, in sight or not;
# - if no candidate is in sight, there's no label: `None`.
#
# So the car needn't drive round a corner in one go. It drives to the corner, looks again, and gets a new waypoint.
#
# ### Exercise 4 · `waypoint_label` (medium, 12 minutes)
#
# <details><summary>Hint 1: concept</summary>"Farthest" means farthest along the trajectory: the point with the largest index. A point may be hidden by a post while a later one is in sight again.</details>
# <details><summary>Hint 2: approach</summary>First handle a target that is not after the source. Otherwise take the points track[source + 1 : target + 1, :2], use sees(start[:2], points) to find those in clear sight, and take the last. If there is none, return None.</details>
# <details><summary>Hint 3: one line</summary><code>np.flatnonzero(flags)</code> gives the indices of the True entries; the last is at index −1, if there is one. <code>to_local(start, point)</code> from the library gives a point as seen from the start.</details>


# %% exercise="waypoint_label"
def waypoint_label(start, track, source, target, sees):
    """The farthest point of a trajectory in clear sight, in the start's frame.

    start: (3,) pose beside track[source]. track: (T, 3) poses of the
    trajectory.
    source, target: indices into track; candidates are source + 1 to target,
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
# Here are five starts next to a recorded drive. They're shifted at random, by 0.3 m or so, and turned by a few degrees, so the network also learns from views *off* the trajectory. The target is round the corner.

# %% hidden=true
# Waypoint labels of five starts before a corner
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
stretch = recorded.poses[source : target + 1, :2]
labelled = []  # a start, its waypoint, and how far that is along the drive
for pose in beside[found]:
    waypoint = waypoint_label(pose, recorded.poses, source, target, sees)
    if waypoint is not None:
        place = to_world(pose, waypoint)
        nearest = np.linalg.norm(stretch - place, axis=1).argmin()
        labelled.append((pose, place, arc_length(stretch)[nearest]))
along = [metres for *_, metres in labelled]


def draw_starts(told):
    """The drive and the starts beside it; with their waypoints if `told`."""
    picture = view.plain.copy()
    view.polyline(picture, stretch, colours.PATH, 3)
    view.goal(picture, stretch[-1])
    for pose, place, _ in labelled:
        view.robot(picture, pose, car.footprint)
        if told:
            view.polyline(picture, [pose[:2], place], colours.GOAL, 1)
            view.points(picture, place, colours.GOAL, 5)
    return closeup(view, picture, np.concatenate([stretch, beside[found, :2]]), 0.7)


labels = Prediction(
    "02",
    "labels",
    "Orange is the drive. Where do the labels of the five starts lie?",
    {
        "A": "all at the target",
        "B": "all at one point, where the corner hides the rest",
        "C": "the farther a car stands from the doorpost, the farther along the drive",
    },
    right="C",
    robot=f"it gets points {min(along):.1f} m to {max(along):.1f} m along the drive, and the target is "
    f"at {arc_length(stretch)[-1]:.1f} m.",
    tempting="B",
    because="the doorpost is the same for all. But from farther off, you see farther round it.",
    before=draw_starts(False),
    after=draw_starts(True),
)
display(labels)

# %% [markdown]
# Some lines pass 6 cm from the corner, and the car is 24 cm wide. That's no mistake: keeping off the wall is the driver's job.
#
# ### How much do two images share?
#
# The network also learns the [[mutual overlap]]: how much of each camera's view the other camera sees. Cast 100 rays from one camera; count the points on walls that lie in the other camera's view, with nothing in between. Here one camera stands 1.5 m behind the other. Orange rays end where the other camera looks, too; grey ones don't.

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


front = np.array([-0.83, -6.5, np.pi / 2])
rear = compose(front, [-1.5, 0.0, 0.0])
panels, titles = [], []
for name, viewer, other in (("rear", rear, front), ("front", front, rear)):
    points, both = points_in_view(viewer, other)
    picture = view.plain.copy()
    view.rays(picture, viewer, points[~both], colours.FAINT)
    view.rays(picture, viewer, points[both], colours.LASER)
    for pose in (rear, front):
        view.robot(picture, pose, car.footprint)
    panels.append(closeup(view, picture, np.array([[-1.9, -8.2], [0.3, -2.8]]), 0.2))
    titles.append(f"{name} view: {both.mean():.0%} shared")
by_library = mutual_overlap(scene.caster, rear[None], front[None])[0]
print(f"the library returns {by_library[0]:.0%} and {by_library[1]:.0%}")
show(side_by_side(panels, titles, height=420))

# %% [markdown]
# Most of what the front camera sees lies ahead of both; the rear one also sees walls the front one has passed. So *two* numbers tell which camera is ahead. One couldn't.
#
# ## 7 · Two images, column by column
#
# A recorded drive holds more than the photo of the target: it also has the images from shortly before and after. They show more of the room, and where the drive went. The target *with its [[context]]* is
#
# $$ \hat o_i = \bigl(o_{i-k\Delta T},\; \dots,\; o_i,\; \dots,\; o_{i+k\Delta T}\bigr), \qquad \Delta T = 3 \text{ images} = 0.3\ \text{s}, $$
#
# $2k+1$ images; with $k = 0$ it's just the photo. Here's the photo you held up, with $k = 2$.

# %% hidden=true
# The photo, and its context
frames = recorded.context(episodes.targets[[example]], 2)[0]
names = [f"{0.3 * j:+.1f} s" if j else "the photo" for j in range(-2, 3)]
images = [camera_picture(image, 180) for image in images_from(*recorded.poses[frames])]
show(side_by_side(images, names, gap=6))

# %% [markdown]
# ### Do half of the work once
#
# Four terms first. A *layer* multiplies its inputs by weights and adds them up. A *convolution* is a layer with the same weights at every position of an image. An [[encoder]] is a few layers that turn an image into a list of numbers. The [[loss]] is the error that training reduces.
#
# The paper stacks *nine* colour channels, three each for the current image, the target and their difference, and feeds them to convolutions. The first layer is *linear*: with $A$, $B$ and $D$ the weights of the three parts, it computes
#
# $$ A\,\text{cur} + B\,\text{tgt} + D\,(\text{cur} - \text{tgt}) . $$
#
# Collect terms by image, and the sum splits into a part that sees only cur and one that sees only tgt. The first part is then computed once for all $2k+1$ images of the target. The second doesn't change while the car drives, so it's **cached** with the target.

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
    caption="Millions of multiplications in the first layer, for one waypoint",
)

# %% [markdown]
# ### Where is it in the other image?
#
# Stacking compares what lies at the *same position* in both images. But when the car turns, everything shifts sideways by many columns. So our networks use a different encoder ([`learning/encoders.py`](../tutorial_lib/learning/encoders.py)). Both images become 32 columns of numbers, and **every column of one is compared with every column of the other**. The table of 32 × 32 similarities is the [[correlation volume]]. A *softmax* turns each of its rows into shares that add up to 1, which show where a column reappears.
#
# Nobody gives the network labels for columns. It learns to predict waypoints, headings and overlaps, and matches columns because that helps.
#
# Below, a table's rows are the current image's columns, the leftmost on top; its columns are the target's. Dark blue is the network's match, and orange dots are the truth. The first pair is the same image twice.

# %% hidden=true
# The network's matches (blue) and the true ones (orange) for four pairs of images
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


def turned(degrees):
    """The front camera, turned to the left."""
    return compose(front, [0.0, 0.0, np.deg2rad(degrees)])


panels = []
for pose in (front, rear, turned(-25), turned(25)):
    tables = matches(pose, front), seen_again(pose, front)
    panels.append(matches_picture(*images_from(pose, front), *tables, side=156))
columns = Prediction(
    "02",
    "columns",
    "In which table has the car turned 25° to the left?",
    {"A": "table A", "B": "table B", "C": "table C"},
    right="C",
    robot="when the car turns, the line of dots moves sideways. In A it's flatter: from farther "
    "back, the target's image is squeezed into the middle of the car's own.",
    tempting="B",
    because="what the car sees moves to the right, and that line lies to the right. But the car's "
    "own image runs down the side of the table: its right edge is at the bottom.",
    before=side_by_side(panels, ["the same image", "A", "B", "C"], gap=10),
    after=side_by_side(
        panels,
        ["the same image", "A: 1.5 m behind", "B: 25° to the right", "C: 25° to the left"],
        gap=10,
    ),
)
display(columns)

# %% [markdown]
# Rows without a dot show what isn't in the other image; a softmax matches them all the same. A plain wall gives a pale smear, since one piece of it looks like the next. Repeated furniture gives a second line, and a chance of a wrong match.
#
# Is matching worth it? We trained four encoders the same way, for a few minutes each: this one, a small copy of the paper's, and the two that the paper found worse. This one reaches [far more targets](../tutorial_lib/results/README.md#table-i-ablations); nobody has measured whether the paper's would catch up at full size.
#
# ## 8 · Ten seconds of school
#
# For each pair of images the network learns the waypoint, the cosine and sine of the difference in heading, and the two overlaps. The loss is the sum of their three errors; training adds a fourth, in the pose that the network predicts for the photo ([`learning/losses.py`](../tutorial_lib/learning/losses.py)). Our pretrained networks each took less than an hour to train, in 120 worlds. You write a small version of their training loop, for an easier task: $k = 0$, and pairs from 24 drives in *one* world, your flat.
#
# The test is 40 episodes: the car starts up to 1 m to the side of a drive, turned a little, and its target is more than a metre away. *Reached* means within 0.3 m, in time and without a collision. Before training, the network drives like this:


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


small_view = PlanView(scene, 300, 420)


def ten_tracks(rollouts):
    """Ten of forty rollouts on the plan: their tracks, and whether they reached their targets."""
    picture = small_view.plain.copy()
    for robot in range(0, 40, 4):
        track = track_of(rollouts, robot)
        small_view.polyline(picture, track[:, :2], colours.TRACK, 2)
        small_view.robot(picture, track[0], 1.4 * car.footprint)
        draw_outcome(small_view, picture, forty.goals[robot, :2], rollouts.reached[robot])
    return picture


forty = forty_of(episodes)
small_network = Architecture(k=0)
torch.manual_seed(0)
outcomes = {}
untrained = WaypointNetwork(LocalNetwork(small_network).eval())
outcomes["before"] = run(visual_policy(untrained, forty, RMPController()), forty)
panel = ten_tracks(outcomes["before"])
title = f"before: {outcomes['before'].reached.sum()} of 40 reached (ten are drawn)"
show(stacked([stacked([panel], [title]), outcome_legend()], gap=4))

# %% [markdown]
# ### Exercise 5 · `train_network` (large, 35 minutes)
#
# A *batch* is a few pairs with their labels. A *step* computes the loss of one batch, and moves all weights a little against its [[gradient]]. The *optimizer* and its [[learning rate]] $\eta$ decide how far. The loop follows seven rules:
#
# 1. **Every step draws one batch**, `draw_batch(step)`, with steps counted $t = 0, 1, \dots, T - 1$ (`max_steps` is $T$), and computes its loss once, with `loss_of(network, batch)`.
# 2. **The learning rate is set before every step.** It decays along half a cosine. Over the first $W$ steps (`warmup_steps`, at least 1) it's kept smaller, since the first gradients of a random network are wild:
#    $$ \eta_t = \eta\,\min\Bigl(1, \frac{t + 1}{W}\Bigr)\cdot\tfrac12\Bigl(1 + \cos\frac{\pi t}{T}\Bigr). $$
# 3. **Gradients don't accumulate**: `optimizer.zero_grad()`, `loss.backward()`, `optimizer.step()`. Before the step, a gradient (of all weights together) that's longer than `max_norm` is shortened to that length; others stay as they are. This is called *clipping*.
# 4. **Evaluate** after every `eval_interval` steps, and always after the last step: `validate(network)` returns the loss on pairs that the network doesn't learn from. During an evaluation the network is in evaluation mode, `network.eval()`, and no gradients are tracked, `with torch.no_grad():`. While it learns it's in training mode, `network.train()`.
# 5. **Keep the best**: whenever the validation loss is the smallest so far, keep a *copy* of the weights, `deepcopy(network.state_dict())` (imported above). At the end the network gets the best weights back, `network.load_state_dict(...)`, and is in evaluation mode.
# 6. **Stop early**: when `patience` evaluations in a row have been no better than the best before them, training ends.
# 7. **Return the history**: for each evaluation, the number of steps made, the mean training loss since the last evaluation, and the validation loss.
#
# <details><summary>Hint 1: concept</summary>Write one loop over the steps. Most of its lines run in every step (rules 1 to 3); an <code>if</code> at its end holds the evaluation (rules 4 to 7). Write the first half, run the check, and continue from what it says.</details>
# <details><summary>Hint 2: approach</summary>Set the rate with <code>for group in optimizer.param_groups: group["lr"] = ...</code>. Clipping is one call, <code>torch.nn.utils.clip_grad_norm_(parameters, largest)</code>, between backward and step. <code>loss.item()</code> is the loss as a number; collect it in a list that you empty at every evaluation. For rules 5 and 6, remember the smallest validation loss and how many evaluations there have been since.</details>
# <details><summary>Hint 3: one line</summary>When do you evaluate? A runner who drinks after every 4 km and at the finish drinks when <code>kilometre % 4 == 0 or kilometre == length</code>. <code>step</code> counts from 0, while the history counts the steps made.</details>


# %% exercise="train_network"
def train_network(network, optimizer, draw_batch, loss_of, validate, plan):
    """Train a network, and leave it with the weights of its best evaluation.

    network, optimizer: of torch; both are changed in place.
    draw_batch: draw_batch(step) returns the batch of a step, counted from 0.
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
# Now your loop trains the network for about 10 s: 400 steps of 64 pairs. Watch the validation loss. It doesn't fall far in so few steps, and never to 0: even a perfect network's is about 1, since the error of an overlap between 0 and 1 never gets to 0, however good the prediction. The training loss, printed afterwards, is larger: it includes the fourth error.

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
# Train it (about 10 s)
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
outcomes["your 400 steps"] = run(visual_policy(learnt, forty, RMPController()), forty)
outcomes["pretrained, k = 2"] = run(visual_policy(pretrained, forty, RMPController()), forty)
panels = [ten_tracks(rollouts) for rollouts in outcomes.values()]
titles = [f"{name}: {rollouts.reached.sum()} of 40" for name, rollouts in outcomes.items()]
for name, rollouts in outcomes.items():
    near = np.median(closest(rollouts, forty))
    print(f"{name}: closest approach {near:.2f} m (median)")
show(stacked([side_by_side(panels, titles), outcome_legend()]))

# %% [markdown]
# Has your network memorised *your flat*, or learnt to *compare images*? A field trip will tell: another flat, new to both networks.

# %% hidden=true
# The same networks in another flat (about 5 s)
elsewhere = scene_of(local_world(10_008))
other_trajectories = demonstrate("another", elsewhere, 24, seed=0, controller=RMPController())
other_world = RecordedWorld(elsewhere, other_trajectories)
other_paths = GridPaths(elsewhere.clearance)
others = forty_of(draw_episodes(other_world, other_paths, 120, np.random.default_rng(0)))
for name, network in (("your 400 steps", learnt), ("pretrained, k = 2", pretrained)):
    rollouts = run(visual_policy(network, others, RMPController()), others)
    print(f"elsewhere, {name}: {rollouts.reached.sum()} of {len(others)} targets reached")

# %% [markdown]
# <details><summary>What has it learnt?</summary>
# Some of it is useless elsewhere: what these rooms look like. But a column that reappears farther left means the same in every building, and to find it the network only compares colours. That's why so little data goes so far, and why the number of training worlds matters little. The pretrained network has a context, and trained for much longer.
# </details>
#
# ## 9 · The photo at the door
#
# Here's that photo again, and the pretrained network with $k = 2$. The plan is for us; the robot gets its camera, its laser and the photo with its context. The green line leads to the predicted waypoint. Watch the waypoint: there's a new one ten times a second.

# %% hidden=true
# Film: the robot drives to the photo, from above and as it sees
this_one, predictions = episodes.subset(np.array([example])), []
its_target = targets_of(pretrained, this_one)


def keep_waypoint(simulation, robots, observations, actions):
    waypoint, _ = pretrained.predict(observations, its_target)
    predictions.append(to_world(simulation.poses[robots], waypoint))


policy = visual_policy(pretrained, this_one, RMPController())
rollouts = run(policy, this_one, record=keep_waypoint)
track = track_of(rollouts, 0)
images = images_from(*track, goal)
film = []
for step in range(0, len(predictions), 2):
    waypoint = predictions[step]
    picture = view.plain.copy()
    view.goal(picture, goal[:2])
    view.polyline(picture, track[: step + 1, :2], colours.TRACK, 3)
    view.polyline(picture, [track[step, :2], waypoint[0]], colours.GOAL, 2)
    view.points(picture, waypoint, colours.GOAL, 5)
    view.robot(picture, track[step], car.footprint)
    above = closeup(view, picture, np.array([start[:2], goal[:2]]), 1.2, square=True)
    views = [camera_picture(images[step], 320), camera_picture(images[-1], 320)]
    film.append(side_by_side([above, stacked(views, ["now", "the photo"])], height=340))
ending = "arrives" if rollouts.reached[0] else "doesn't arrive"
print(f"{robot_name()} {ending}, after {rollouts.seconds[0]:.1f} s")
play(film, 5, 2 * STEP * np.arange(len(film)), count=3)

# %% [markdown]
# **Your robot drives to a photo.** No map, no coordinates, no oracle: a network that looks, and a driver that keeps off the walls.
#
# The two know nothing of each other. Give the same network to a round robot that can turn in place; only $\mathcal C_{RMP}$ is swapped, and nothing is retrained. For comparison, an oracle drives both.

# %% hidden=true
# A car and a round robot, driven by the same network
round_robot = DifferentialDrive()
fits = episodes.subset(np.flatnonzero(is_free(scene, round_robot, episodes.starts)))
rows = []
for name, body in (("car", car), ("round robot", round_robot)):
    by_camera = run(visual_policy(pretrained, fits, RMPController(body=body)), fits, body)
    by_oracle = run(oracle_policy(fits.goals, RMPController(body=body)), fits, body)
    rows.append([name, by_camera.reached.sum(), by_oracle.reached.sum()])
caption = f"Targets reached, of {len(fits)}"
table({"body": "", "by camera": "d", "by the oracle": "d"}, rows, caption=caption)

# %% [markdown]
# <details><summary>Why isn't the round robot better, when it can turn in place?</summary>
# With the oracle, either body reaches every target, so the body isn't the cause. The misses are due to waypoints, and turning in place doesn't mend a wrong waypoint. The network was trained on starts next to drives of a <i>car</i>. A robot that turns in place soon faces directions that no training image shows.
# </details>
#
# ### Find the bug
#
# A colleague computes the context of targets for the whole recording at once, "which is simpler". The code runs without errors, and training goes well; only the success rate near the ends of drives is strangely low. Look at the five images of one target. What's wrong? Decide before you unfold the answer.


# %%
def context_frames(world, frames, k):
    """The 2k + 1 frames around each of `frames` (N,)."""
    around_it = frames[:, None] + 3 * np.arange(-k, k + 1)
    return np.clip(around_it, 0, len(world.poses) - 1)


# %% hidden=true
# The context of a target near the end of a drive, by the colleague's function
near_the_end = np.array([recorded.last[0] - 2])
images = images_from(*recorded.poses[context_frames(recorded, near_the_end, 2)[0]])
show(side_by_side([camera_picture(image, 180) for image in images], names, gap=6))

# %% [markdown]
# <details><summary>Answer</summary>
# The recording is many drives laid end to end. Near the end of one, the images "after" the target belong to the <i>next</i> drive, somewhere else in the flat: the last images show another room. The indices must be clipped to the target's own trajectory, whose last image is repeated: <code>np.clip(around_it, world.first[frames, None], world.last[frames, None])</code>, as in <code>RecordedWorld.context</code> (<a href="../tutorial_lib/driving/data/recorded_world.py">recorded_world.py</a>). Data bugs don't crash. Look at a few of the network's inputs, and you'll find most of them.
# </details>
#
# ## 10 · What it doesn't know
#
# With context your robot misses few targets. So we make it harder, with single images, $k = 0$: 100 episodes at home and, on a field trip, 100 in a maze. Here are three from home.

# %% hidden=true
# 200 episodes with single images, and three of them (about 5 s)
maze_world = local_world(10_006)
maze = scene_of(maze_world)
maze_drives = demonstrate(maze_world, maze, 24, seed=0, controller=RMPController())
places = [
    (scene, recorded, paths),
    (maze, RecordedWorld(maze, maze_drives), GridPaths(maze.clearance)),
]
single_image = WaypointNetwork("waypoint_k0")
cases = []
for where, world, geodesics in places:
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
                "home": where is scene,
                "traits": traits,
                "failed": not rollouts.reached[i],
                "collided": rollouts.collided[i],
                "near": near[i],
                "track": track_of(rollouts, i),
                "goal": hundred.goals[i],
            }
        )


def one_case(failed, *traits):
    """An episode at home that has exactly these traits, the longest one of them."""
    fitting = [
        case
        for case in cases
        if case["home"]
        and case["failed"] == failed
        and {trait for trait, has in case["traits"].items() if has} == set(traits)
    ]
    return max(fitting, key=lambda case: np.linalg.norm(case["goal"] - case["track"][0]))


three = [
    one_case(False, "target behind"),
    one_case(True, "little overlap (< 0.1)"),
    one_case(False, "tight place (< 0.3 m to a wall)"),
]


def case_picture(case, drawn):
    """The images of an episode; with its track on the plan if `drawn`."""
    pair = now_and_photo(case["track"][0], case["goal"], 290)
    if not drawn:
        return pair
    track, goal = case["track"], case["goal"]
    picture = track_picture(view.plain.copy(), track, goal[:2])
    corners = np.concatenate([track[:, :2], goal[None, :2]])
    above = closeup(view, picture, corners, 0.6, square=True)
    return stacked([side_by_side([above], height=290), pair], gap=6)


wont = Prediction(
    "02",
    "wont",
    "In two of these the robot arrives. In which one does it fail?",
    {"A": "pair A", "B": "pair B", "C": "pair C"},
    right="B",
    robot=f"it sets off all three times, as sure as ever. In B it comes no closer than "
    f"{three[1]['near']:.1f} m, and drives until its time is up.",
    tempting="A",
    because="that photo was taken behind the car. But the two images have walls in common, and so "
    "it knows to back up. In B they share a strip at the very edge, at most.",
    before=side_by_side([case_picture(case, False) for case in three], ["A", "B", "C"], gap=10),
    after=side_by_side([case_picture(case, True) for case in three], ["A", "B", "C"], gap=10),
)
display(wont)

# %% [markdown]
# Now look at all 200, grouped by four conditions that could matter. Note the second row.

# %% hidden=true
# What the failures have in common
failed = [case for case in cases if case["failed"]]
collided = sum(case["collided"] for case in failed)
print(f"{len(failed)} of 200 failed: {collided} collided, {len(failed) - collided} out of time")
rows = []
for trait in cases[0]["traits"]:
    groups = [
        [case["failed"] for case in cases if bool(case["traits"][trait]) == has]
        for has in (True, False)
    ]
    shares = [f"{np.mean(group):.0%} of {len(group)}" for group in groups]
    rows.append([trait, *shares])
table({"condition": "", "failed with it": "", "failed without it": ""}, rows)

# %% [markdown]
# <details><summary>What are the causes?</summary>
# Where the images hardly overlap there's little to match, and the network guesses from what rooms usually look like. A target behind the car does no harm: the driver can reverse. Most of the other failures are in tight places: the laser keeps the car off the walls there, but the car may run out of time. Hidden targets are too rare here to judge. The conditions seldom occur alone, and 200 episodes are few.
# </details>
#
# ## 11 · Beside the paper
#
# The paper's Table I compares such controllers on targets from 1 m behind to 3 m ahead, in four unseen buildings. *Direct* maps the images straight to the controls, without a waypoint; *waypoint* is $\mathcal C$ with more and more context. Below is the table's twin, **in an easier world**: straight walls with painted stripes, and uniform light. *Random* drives to random waypoints, *laser* gets distances instead of images, and the *oracle* shows what the car's body and the time limit cost. Compare the order of the bars, not their heights: more context helps, in both worlds.

# %% hidden=true
# Success rates beside the paper's, with 95% intervals
result = load_result("meng_table1")
ours = {line["controller"]: line for line in result.rows if line["condition"] == "clean"}
names = {
    "random": "random",
    "direct": "direct,\nk = 2",
    "k0": "waypoint,\nk = 0",
    "k2": "waypoint,\nk = 2",
    "k5": "waypoint,\nk = 5",
    "laser": "laser,\nk = 2",
    "oracle": "oracle",
}
figure, (axis,) = chart(9.0, 3.8)
for place, name in enumerate(names):
    line = ours[name]
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
    ylabel="success rate, %",
    title="Waypoints beat direct control. Blue, grey: ours; orange: the paper",
)
axis.set_xticks(range(len(names)), list(names.values()))
axis.set_yticks(np.linspace(0, 1, 6), range(0, 101, 20))
show(from_figure(figure))

# %% [markdown]
# The results page also shows these controllers [on real maps](../tutorial_lib/results/README.md#table-i-on-maps-from-nav2), and [with noisy controls, obstacles and other colours](../tutorial_lib/results/README.md#table-i-local-control): among obstacles, context helps most.
#
# <details><summary>Why does noise on the controls hardly matter?</summary>
# The loop is closed ten times a second: the effect of an error shows in the next image, and the next waypoint corrects it. In open loop, errors would add up, as the odometry's did in notebook 01.
# </details>
# <details><summary>Why do our numbers differ from the paper's?</summary>
# Our images are simpler than those of scanned buildings, which helps. But they have 16 rows, not 64, the networks are small, and our car is larger relative to its world: its tightest circle is 1.24 m wide, and 0.9 m in the authors' code. Their direct controller imitates acceleration and steering velocity and has k = 0; ours imitates speed and steering, and has k = 2. Our $\mathcal C$ averages its waypoints; theirs doesn't, and neither does the one you drove with here.
# </details>
#
# **Close the notebook and draw the pipeline**, with your function names: from two images to the wheels.
#
# After this notebook you can
#
# - build a reactive driver from small *motion policies*, each with an acceleration and a weight;
# - say which labels train a network to guide a car to a photo, and compute them from a recorded drive;
# - explain how a network compares two images, and why half of that work is done only once;
# - write the loop that trains a network, and watch that network drive a car.
#
# <details><summary>Extras, if you like</summary>
# Draw the blocks of section 8 with <code>vary=True</code>, which changes the colours at random, and train again: what do you gain elsewhere, and what does it cost?
#
# <code>DirectNetwork("direct_k2")</code> from <code>tutorial_lib.learning</code> predicts speed and steering directly; <code>run(lambda simulation: TargetPolicy(direct, targets_of(direct, forty)), forty)</code> drives with it. In which episodes does it fail, though waypoints get the car there?
#
# Give the car of section 3 a damping of 1.0 instead of 3.0. What does it do at the door? How would a policy keep a car from driving faster than it can see?
#
# In <code>waypoint_label</code>, take the <i>nearest</i> point in sight that's at least 1 m away. Which rollouts would become smoother, and which worse?
# </details>
#
# Tonight your robot drives to the place in a photo, and usually arrives. But hold up a photo from the far end of the flat, or of a wall it can't see, and it sets off just the same. It can't say *I won't make that*. In [notebook 03](03_reachability.ipynb) you'll teach it to. The paper's III-C is good reading until then.
