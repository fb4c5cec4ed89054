# %% [markdown]
# # 01 · The world and the car
#
# **90 minutes.** You need: Python with numpy, sines and cosines. Notebook 00 is a good start, but not required.
#
# After this notebook you can
#
# - say where an object is in the robot's frame, and where the robot is after two motions;
# - predict what a car that steers with its front wheels can and cannot do;
# - explain why a robot that relies on wheel odometry gets lost;
# - turn a floor plan into a camera image, column by column.
#
# There are five exercises. Each has hints behind folds. When your function passes its check, **the cells below use it**; until then they use the
# library's, so you can read on at any time. Arrays are numpy arrays throughout: where a function returns `(N, 2)`, return an array, not a list.
#
# Metres, radians, seconds. x points right, y up, headings turn counter-clockwise from +x. A [[pose]] is `[x, y, heading]`.

# %%
import numpy as np
from IPython.display import display

from tutorial_lib.checks.nb01 import (
    check_bicycle_step,
    check_compose,
    check_ray_segment,
    check_to_local,
    check_wall_share,
)
from tutorial_lib.driving import GridPaths, OraclePolicy
from tutorial_lib.geometry import arc_length, relative, to_world
from tutorial_lib.viz import (
    PlanView,
    camera_picture,
    chart,
    colours,
    draw_field_of_view,
    from_figure,
    label,
    show,
    side_by_side,
    sliders,
    stacked,
    table,
)
from tutorial_lib.world import (
    EYE,
    WALL_HEIGHT,
    BicycleCar,
    Camera,
    Person,
    Scene,
    Sensors,
    Simulation,
    WheelOdometry,
    generate,
)

scene = Scene(generate("apartment", seed=4))
paths = GridPaths(scene.clearance)
view = PlanView(scene, 640, 480)

# %% [markdown]
# ## 1 · Where is it in the robot's frame?
#
# A robot does not need to know that the door is at (7.1, 2.4). It needs to know that the door is *two metres ahead and a little to the left*. Those are the door's
# coordinates in the robot's own [[frame]]: x ahead, y to the left.
#
# The transform has two steps. Shift: subtract the robot's position. Rotate: undo its heading. With the robot at $(x, y, \theta)$ and a point $p$,
#
# $$ p_\text{local} = R(\theta)^{\top}\,\bigl(p - (x, y)\bigr), \qquad R(\theta) = \begin{pmatrix}\cos\theta & -\sin\theta\\ \sin\theta & \cos\theta\end{pmatrix}. $$
#
# In the code a point is a *row*. For rows, $R^{\top} p$ is written `offset @ R`.
#
# ### Exercise 1 · `to_local` (easy, 10 minutes)
#
# <details><summary>Hint 1: concept</summary>A point straight ahead of the robot has the local coordinates (distance, 0), whatever the heading.</details>
# <details><summary>Hint 2: approach</summary>Subtract first. Then the new x is the component of the offset along the robot's heading, and the new y its component to the left: two dot products.</details>
# <details><summary>Hint 3: one line</summary>At heading 0 the local point is (dx, dy), at 90 degrees it is (dy, −dx). Which two sums of dx and dy, weighted with cosine and sine, give both?</details>


# %% exercise="to_local"
def to_local(pose, points):
    """World points in the frame of a pose.

    pose: (3,) x, y, heading. points: (N, 2), m, perhaps whole
    numbers. Returns an array (N, 2), a row for each point: metres ahead,
    metres to the left.
    """
    ### BEGIN SOLUTION
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    dx, dy = points[:, 0] - pose[0], points[:, 1] - pose[1]
    return np.stack([cos * dx + sin * dy, cos * dy - sin * dx], axis=1)
    ### END SOLUTION


# %%
to_local = check_to_local.use(to_local)

# %% [markdown]
# **Predict**, then run the cell: on the left are the robot and five points in the world. Where will the same five points lie in the robot's frame, where the
# robot stands at the origin and faces right?

# %% hidden=true
# Five points in the world, and in the robot's frame
robot = np.array([1.0, 1.0, 2.2])
places = np.array([[0.0, 2.4], [2.0, 3.0], [3.0, 1.0], [-1.0, 0.0], [1.0, -0.5]])
figure, axes = chart(9.0, 4.0, 2)
for axis, pose, points, name in (
    (axes[0], robot, places, "in the world"),
    (axes[1], np.zeros(3), to_local(robot, places), "in the robot's frame"),
):
    tip = to_world(pose, [0.8, 0.0])
    axis.annotate("", tip, pose[:2], arrowprops={"width": 3, "color": colours.unit(colours.ROBOT)})
    axis.scatter(*points.T, s=70, color=colours.unit(colours.GOAL), zorder=3)
    for i, point in enumerate(points):
        axis.annotate(f" {i}", point, fontsize=13)
    axis.set(title=name, xlim=(-4, 4), ylim=(-3.5, 4), aspect="equal", xlabel="x / m")
axes[0].set_ylabel("y / m")
show(from_figure(figure))

# %% [markdown]
# ## 2 · One motion after another
#
# The robot drives from A to B, and then makes a motion that is given *in the frame of B*. Where is it now? The second translation has to be rotated by the first
# heading before it can be added; the headings simply add up. This is called **composition**, $A \oplus B$. [[Odometry]] is a long chain of compositions:
#
# $$ (x_1, y_1, \theta_1) \oplus (x_2, y_2, \theta_2) = \bigl((x_1, y_1) + R(\theta_1)\,(x_2, y_2),\;\; \theta_1 + \theta_2\bigr). $$
#
# The heading is kept between $-\pi$ and $\pi$ (*wrapped*), so that two headings can be compared.
#
# ### Exercise 2 · `compose` (easy, 10 minutes)
#
# <details><summary>Hint 1: concept</summary>Drive 1 m, turn left, drive 1 m. The second metre went along +y. Adding the numbers would put it along +x.</details>
# <details><summary>Hint 2: approach</summary>This time the matrix is R itself, not its transpose: you go from the robot's frame to the world.</details>
# <details><summary>Hint 3: one line</summary>degrees % 360 lies between 0 and 360, and (degrees + 180) % 360 − 180 between −180 and 180. What is that in radians?</details>


# %% exercise="compose"
def compose(first, second):
    """The pose after a motion `first`, then a motion `second` in its frame.

    first, second: (3,) x, y, heading, the headings in -pi to pi.
    Returns an array (3,), with the heading in -pi to pi.
    """
    ### BEGIN SOLUTION
    cos, sin = np.cos(first[2]), np.sin(first[2])
    x = first[0] + cos * second[0] - sin * second[1]
    y = first[1] + sin * second[0] + cos * second[1]
    heading = (first[2] + second[2] + np.pi) % (2 * np.pi) - np.pi
    return np.array([x, y, heading])
    ### END SOLUTION


# %%
compose = check_compose.use(compose)

# %% [markdown]
# **Predict:** the robot repeats one motion, *one metre ahead, then a turn of 45 degrees to the left*. After how many motions is it back? And what happens
# when it measures each turn one degree too large?


# %%
def repeated_motion(degrees):
    """Poses (25, 3) after 0 to 24 motions: one metre ahead, then a turn to the left."""
    poses = [np.zeros(3)]
    for _ in range(24):
        poses.append(compose(poses[-1], np.array([1.0, 0.0, np.deg2rad(degrees)])))
    return np.array(poses)


# %% hidden=true
# Three laps with exact turns, and with turns measured 1 degree too large
figure, axes = chart(9.0, 4.0, 2)
for axis, error, name in (
    (axes[0], 0.0, "exact turns"),
    (axes[1], 1.0, "each turn measured 1 degree too large"),
):
    for turn, colour, style, meaning in (
        (45.0, colours.TRACK, "o-", "where it is"),
        (45.0 + error, colours.BELIEVED, ".:", "where its odometry puts it"),
    ):
        track = repeated_motion(turn)
        axis.plot(*track[:, :2].T, style, color=colours.unit(colour), label=meaning)
    for lap in (1, 2, 3):
        spot = {"textcoords": "offset points", "xytext": (-4, -18), "fontsize": 13}
        axis.annotate(str(lap) if error else "", track[8 * lap][:2], **spot)
    axis.set(title=name, ylim=(-0.5, 2.7), aspect="equal", xlabel="x / m", ylabel="y / m")
figure.legend(
    *axes[1].get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=10
)
show(from_figure(figure))

# %% [markdown]
# After eight motions it is back. With the wrong turns its odometry ends 0.18 m, 0.36 m and 0.53 m away from the start after one, two and three laps
# (the numbers in the figure). One degree is hardly visible at first, but every later step is rotated by all the errors before it. Keep this figure in mind for section 4.
#
# ## 3 · A car cannot turn in place
#
# The front wheels are turned by the steering angle $\delta$, the rear wheels only roll. The car's pose is that of the middle of its rear axle, and $v$ is
# the speed there. $L$ is the distance between the axles, the [[wheelbase]]. A dot is the time derivative:
#
# $$ \dot x = v\cos\theta, \qquad \dot y = v\sin\theta, \qquad \dot\theta = \frac{v}{L}\tan\delta . $$
#
# At a fixed angle the car drives a circle of radius $r = L / \tan\delta$ at any speed. This is the [[kinematic bicycle model]]. Our car is 0.42 m long and 0.24 m
# wide, its wheelbase is 0.30 m, and its front wheels turn by at most 0.45 rad (26 degrees).
#
# ### Exercise 3 · `bicycle_step` (easy, 5 minutes)
#
# <details><summary>Hint 1: concept</summary>For a short time the car moves straight along its heading, and its heading changes by the turning rate times the time.</details>
# <details><summary>Hint 2: approach</summary>Three lines, one for each equation above, each times <code>seconds</code>. A negative speed needs no special case, and the heading need not be wrapped.</details>
# <details><summary>Hint 3: one line</summary>A tank that fills at <code>rate</code> litres a second holds <code>level + rate * seconds</code> litres later. What are the three levels here, and what are their rates?</details>


# %% exercise="bicycle_step"
def bicycle_step(pose, speed, steering, wheelbase, seconds):
    """The car's pose a short time later.

    pose: (3,) x, y, heading. speed: m/s, negative in reverse. steering: rad,
    positive to the left.
    wheelbase: m. seconds: s. Returns an array (3,): x, y, heading. The step
    runs along the heading that the car has before it.
    """
    ### BEGIN SOLUTION
    x, y, heading = pose
    x = x + speed * np.cos(heading) * seconds
    y = y + speed * np.sin(heading) * seconds
    heading = heading + speed * np.tan(steering) / wheelbase * seconds
    return np.array([x, y, heading])
    ### END SOLUTION


# %%
bicycle_step = check_bicycle_step.use(bicycle_step)

# %% [markdown]
# **Predict, then move the slider:** a corridor is 1.4 m wide. The car starts along its lower wall. Can it turn around in a single half circle? At which steering
# angle, if at any?

# %%
car = BicycleCar()


def eight_seconds(steering_angle, speed):
    """The car's poses (400, 3) over eight seconds, with fixed controls."""
    pose, track = np.array([0.0, 0.0, 0.0]), []
    for _ in range(400):
        track.append(pose)
        pose = bicycle_step(pose, speed, steering_angle, car.wheelbase, 0.02)
    return np.array(track)


# %% hidden=true
# The car's turning circle in a corridor, with sliders
def turning_circle(steering_angle, speed):
    """The car's track over eight seconds, in the corridor."""
    track = eight_seconds(steering_angle, speed)
    outer = car.footprint[1 if steering_angle >= 0 else 2]  # the front corner that swings wide
    side = 1.0 if steering_angle >= 0 else -1.0  # the wall that the car starts along
    figure, (axis,) = chart(8.0, 4.0)
    for wall in (-0.17 * side, 1.23 * side):
        axis.axhline(wall, color="0.3", linewidth=4, label="corridor, 1.4 m" if wall > 0 else None)
    axis.plot(*track[:, :2].T, color=colours.unit(colours.TRACK), label="rear axle, 8 seconds")
    corner = to_world(track, outer)
    axis.plot(*corner.T, ":", color=colours.unit(colours.PATH), label="outer front corner")
    for end in (track[0], track[-1]):
        outline = to_world(end, car.footprint)
        axis.fill(*outline.T, color=colours.unit(colours.ROBOT))
    axis.set(xlim=(-2.2, 4.2), ylim=(-2.0, 2.0), aspect="equal", xlabel="x / m", ylabel="y / m")
    figure.legend(loc="outside lower center", ncols=3, fontsize=10)
    radius = car.wheelbase / np.tan(abs(steering_angle)) if steering_angle else np.inf
    width = np.ptp(corner[:, 1]) if steering_angle else 0.24
    text = f"radius {radius:.2f} m; the outer corner sweeps over {width:.2f} m across the corridor"
    return from_figure(figure), text


sliders(
    turning_circle,
    {"steering_angle": "steering angle, rad (+ is left)", "speed": "speed, m/s"},
    steering_angle=(-0.45, 0.45, 0.05, 0.45),
    speed=(-0.3, 0.8, 0.1, 0.3),
)

# %% [markdown]
# <details><summary>What did you find?</summary>
# The tightest circle has a radius of 0.62 m and a diameter of 1.24 m, measured at the middle of the rear axle. The car's outer front corner swings wider, so the whole car
# needs 1.6 m for a half circle, and the corridor is too narrow at every steering angle: the car has to stop, reverse and go again. What it can reach <i>in one motion</i> is therefore not a question of
# distance. A place half a metre to its left is much harder to reach than one three metres ahead. This is why notebook 03 learns reachability instead of
# measuring distance. The speed does not change the circle at all.
# </details>
#
# ### When it touches something
#
# These equations know nothing of walls. Contact is the work of [pymunk](https://www.pymunk.org), a physics library. The car is a **rigid body** there: it moves and turns, but never bends.
#
# Five times in each tenth of a second, the car's model sets the velocity that its wheels ask for. Where the car touches something there's a **contact**: pymunk takes away the part of the velocity that points into the wall, and the rest moves the car.
#
# **Predict:** three cars for five seconds. One drives straight at a wall, one meets it at 40°; both want 0.5 m/s and never stop their motors. The third stands still, and a person walks into it. Which of them moves how far after the contact? And how far does the person move aside?

# %% hidden=true
# Three contacts: a wall ahead, a wall at an angle, and a person
WALL = 0.07  # y of a wall of the hallway, m
passer = Person([[-8.9, 1.6], [-8.9, 0.7]], speed=0.3, keep_off=0.0)  # heeds no robot
turns = np.linspace(0, 2 * np.pi, 40)
disc = passer.radius * np.stack([np.cos(turns), np.sin(turns)], axis=1)
trials = {
    "a wall ahead": ([-8.5, 0.9, -np.pi / 2], 0.5, []),
    "a wall at an angle": ([-9.4, 0.75, np.deg2rad(-40)], 0.5, []),
    "a person": ([-9.0, 1.1, 0.0], 0.0, [passer]),
}
figure, axes = chart(10.5, 3.4, 3)
rows = []
for axis, (name, (start, speed, people)) in zip(axes, trials.items(), strict=True):
    trial = Simulation(scene, start, people=people, sensors=Sensors(camera=None))
    track, walked, touched = [trial.poses[0]], [trial.crowd.positions], [False]
    for _ in range(29 if people else 50):
        trial.step([[speed, 0.0]])
        track.append(trial.poses[0])
        walked.append(trial.crowd.positions)
        touched.append(trial.touching[0])
    track, walked, first = np.array(track), np.array(walked), int(np.argmax(touched))
    moving = [(track, car.footprint, colours.ROBOT)]
    if people:
        passing = np.column_stack([walked[:, 0], np.zeros(len(walked))])
        moving.append((passing, disc, colours.PERSON))
        spot = walked[first, 0] - [0.0, passer.radius]
    else:
        corners = to_world(track[first], car.footprint)
        spot = corners[corners[:, 1] < corners[:, 1].min() + 0.01].mean(axis=0)
    for poses, outline, tone in moving:
        for k, strength in ((0, 0.25), (first, 0.5), (-1, 1.0)):
            shape = to_world(poses[k], outline)
            axis.fill(*shape.T, color=colours.unit(tone), alpha=strength, linewidth=0)
    axis.plot(*track[:, :2].T, color=colours.unit(colours.TRACK), label="rear axle of the car")
    axis.plot(*spot, "x", color=colours.unit(colours.LASER), ms=11, mew=3, label="first contact")
    axis.axhspan(WALL - 0.15, WALL, color=colours.unit(colours.SOLID), linewidth=0, label="wall")
    middle = track[[0, -1], 0].mean() + 0.1
    axis.set(xlim=(middle - 1.5, middle + 1.5), ylim=(WALL - 0.15, 1.85), aspect="equal")
    axis.set(title=name, xlabel="x / m")
    after = track[first:]
    angle = None if people else -np.rad2deg(track[first, 2])
    asked, moved = speed * 0.1 * (len(after) - 1), arc_length(after)[-1]
    aside = np.ptp(walked[:, 0, 0]) if people else None
    turn = np.rad2deg(after[-1, 2] - after[0, 2])
    rows.append([name, angle, 0.1 * first, asked, moved, turn, aside])
axes[0].set_ylabel("y / m")
figure.legend(
    *axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=10
)
head = {"the car meets": "", "at an angle of, °": ".0f", "first contact, s": ".1f"}
head |= {"its wheels then ask for, m": ".2f", "it then moves, m": ".2f"}
head |= {"it turns, °": "+.0f", "the person is moved aside, m": ".2f"}
display(table(head, rows))
show(from_figure(figure))

# %% [markdown]
# Paler is earlier: the start, the first contact, and the end; the person is pink.
#
# <details><summary>What do you see?</summary>
# Head-on the whole velocity points into the wall, so nothing is left: the car stands, and its motor goes on. At 40° the part along the wall is left. The car scrapes along for 1.54 m, while its wheels ask for 1.85 m. The wall pushes at its front corner and turns it along the wall, by 13°. Walls have no <b>friction</b> here; a real one would slow the car down and scratch it.
#
# The person isn't moved aside at all, and the car gives way. A person follows a route, whatever touches it; pymunk calls such a body <i>kinematic</i>. So the person pushes the car 0.66 m, and a car that drives at a person stops as if at a wall. This one pays no attention to robots. The people of the later notebooks do: each stops 1.3 m before a robot, waits two seconds, and walks back.
#
# <code>simulation.touching</code> says whether a robot touches something now, and <code>simulation.collided</code> whether it ever did.
# </details>
#
# ## 4 · Two hundred cars, the same commands
#
# Motors are not exact. We follow X. Meng, N. Ratliff, Y. Xiang and D. Fox, [*Scaling Local Control to Large-Scale Topological Navigation*](https://arxiv.org/abs/1909.12329)
# (ICRA 2020, from here on Meng 2020; section IV-B), and multiply both controls, ten times a second, by a random number drawn from
# $\mathcal N(1, 0.33)$ (mean 1, standard deviation 0.33). The wheel odometry has errors too: about 5 % of each distance and of each turn, and the heading
# drifts at random, by 0.02 rad over one metre and by 0.04 rad over four (standard deviations).
#
# **Predict:** 200 cars start at the same place and get the same commands. Which will have the larger spread after 20 seconds, the true positions
# or the errors of the odometry? In which direction is the error largest, along the path or across it?

# %%
commands = np.array([[0.5, 0.0]] * 60 + [[0.5, 0.25]] * 60 + [[0.5, 0.0]] * 80)


def many_cars(count, control_noise, seed=0):
    """Drive `count` cars by the same commands on open ground; true and estimated poses (T, N, 3)."""
    rng = np.random.default_rng(seed)
    true, estimated = [np.zeros((count, 3))], [np.zeros((count, 3))]
    odometry = WheelOdometry()
    for speed, steering in commands:  # as bicycle_step, for all cars at once
        noise = rng.normal(1.0, control_noise, (count, 2))
        controls = np.clip(noise * [speed, steering], [-0.3, -0.45], [0.8, 0.45])
        motion = np.zeros((count, 3))
        twist = car.twist(controls)
        motion[:, 0], motion[:, 2] = twist[:, 0] * 0.1, twist[:, 1] * 0.1
        measured = odometry.measure(motion, rng)
        true.append(np.array([compose(*pair) for pair in zip(true[-1], motion, strict=True)]))
        steps = zip(estimated[-1], measured, strict=True)
        estimated.append(np.array([compose(*pair) for pair in steps]))
    return np.array(true), np.array(estimated)


true, estimated = many_cars(200, 0.33)

# %% hidden=true
# True positions of 200 cars, and the errors of their odometry
error = relative(true[-1], estimated[-1])
figure, axes = chart(9.5, 4.2, 2)
for i in range(0, 200, 4):
    axes[0].plot(*true[:, i, :2].T, color=colours.unit(colours.TRACK), alpha=0.15, linewidth=1)
axes[0].scatter(*true[-1, :, :2].T, s=8, color=colours.unit(colours.TRACK))
axes[0].set(title="true positions of 200 cars", aspect="equal", xlabel="x / m", ylabel="y / m")
axes[1].scatter(*error[:, :2].T, s=8, color=colours.unit(colours.BELIEVED))
axes[1].set(title="odometry error, in the frame of each car", aspect="equal")
axes[1].set(
    xlim=(-3, 3), ylim=(-3.4, 3.4), xlabel="error ahead / m", ylabel="error to the left / m"
)
along, across = error[:, 0].std(), error[:, 1].std()
spread = np.hypot(*true[-1, :, :2].std(axis=0))
print(f"spread of the true positions: {spread:.2f} m")
print(f"spread of the odometry error: {along:.2f} m along the path, {across:.2f} m across it")
show(from_figure(figure))

# %% hidden=true
# The odometry error over the time, half and nine tenths of the cars
error = np.linalg.norm(relative(true, estimated)[..., :2], axis=2)
figure, (axis,) = chart(7.0, 3.6)
seconds = 0.1 * np.arange(len(error))
for share, style in ((0.9, ":"), (0.5, "-")):
    meaning = f"{share:.0%} of the cars are below"
    axis.plot(seconds, np.quantile(error, share, axis=1), style, color="0.2", label=meaning)
axis.set(
    xlabel="time / s", ylabel="odometry error / m", title="The error grows, and nothing corrects it"
)
axis.legend()
show(from_figure(figure))

# %% [markdown]
# <details><summary>What did you see?</summary>
# The cars themselves are spread over metres: the commands alone say little about where a car is. The odometry is three times better (both plots have the
# same scale), but look at the shape of its error. A heading error, integrated over metres, becomes an error <i>across</i> the path. It grows with the distance driven, and nothing ever corrects
# it. Only observing the world can.
# </details>
#
# ### Find the bug
#
# A colleague's odometry is right on straights and wrong after every bend. Where is the bug? Decide before you unfold the answer.
#
# ```python
# def update(pose, ahead, turn):
#     x, y, heading = pose
#     heading = heading + turn
#     return np.array([x + ahead, y, heading])
# ```
#
# <details><summary>Answer</summary>The step is added along the world's x axis and never rotated by the heading: it should be
# <code>compose(pose, [ahead, 0, turn])</code>. A test that drives straight along +x would not have found it, which is why good tests turn first.</details>
#
# ## 5 · A ray hits a wall
#
# A beam of the [[laser scanner]] and a column of a camera image ask the same question: how far is the nearest wall in this direction? A wall is a segment from $a$ to $b$.
# The ray starts at $o$ and runs along the unit vector $d$. They intersect where
#
# $$ o + t\,d = a + u\,(b - a), \qquad t \ge 0, \quad 0 \le u \le 1. $$
#
# Two equations, two unknowns. Take the cross product of both sides with $b - a$, and $u$ drops out; with $d$, and $t$ does. With $p \times q = p_x q_y - p_y q_x$ the answer is
#
# $$ t = \frac{(a - o)\times(b - a)}{d\times(b - a)}, \qquad u = \frac{(a - o)\times d}{d\times(b - a)} . $$
#
# Where ray and wall are parallel, the denominator is zero. Rounding can make it $10^{-16}$ instead, and both fractions can then come out as anything. So a size of $10^{-12}$ or less counts as parallel, whatever its sign.
#
# ### Exercise 4 · `ray_segment` (medium, 10 minutes)
#
# <details><summary>Hint 1: concept</summary>The ray misses in three cases: the wall is behind it (t), it passes beyond the wall's ends (u), or the two are parallel (the denominator is zero but for rounding).</details>
# <details><summary>Hint 2: approach</summary>Write a small function for the cross product. Treat the parallel case first and return np.inf.</details>
# <details><summary>Hint 3: one line</summary>Python can test both ends of a range at once: <code>low &lt;= value &lt;= high</code>. Which conditions on t and u decide between t and np.inf?</details>


# %% exercise="ray_segment"
def ray_segment(origin, direction, start, end):
    """Metres from `origin` along the unit vector `direction` to a wall.

    The wall runs from `start` to `end`; all are (2,), m. Returns one number,
    np.inf when the ray misses the wall: when the wall is behind the origin,
    when the ray passes beyond an end of it, and when the two are parallel,
    even if the wall lies along the ray. A ray that starts on any other wall
    (t = 0) or meets exactly an end of it (u = 0, u = 1) hits it.
    """

    ### BEGIN SOLUTION
    def cross(p, q):
        return p[0] * q[1] - p[1] * q[0]

    wall = end - start
    across = cross(direction, wall)
    if abs(across) < 1e-12:
        return np.inf
    t = cross(start - origin, wall) / across
    u = cross(start - origin, direction) / across
    return t if t >= 0 and 0 <= u <= 1 else np.inf
    ### END SOLUTION


# %%
ray_segment = check_ray_segment.use(ray_segment)

# %% [markdown]
# Now your function scans an apartment: 60 rays, each against every wall nearby, and the nearest hit counts. Walls are painted in stretches of
# colour, so that images of different places differ. The library does the same some ten thousand times faster: its code is compiled, and a grid index finds the
# walls nearby (`.venv/bin/python -m tutorial_lib bench raycast` measures it; the code is in [`world/raycast.py`](../tutorial_lib/world/raycast.py)).

# %%
eye = np.array([*paths.points[paths.clearance.argmax()], 0.6])
angles = np.linspace(-np.pi, np.pi, 60, endpoint=False)
near = np.linalg.norm(scene.plan.segments.reshape(-1, 2, 2) - eye[:2], axis=2).min(axis=1) < 8.0
walls = scene.plan.segments[near]
yours = []
for angle in eye[2] + angles:
    direction = np.array([np.cos(angle), np.sin(angle)])
    yours.append(min(ray_segment(eye[:2], direction, wall[:2], wall[2:]) for wall in walls))
yours = np.minimum(yours, 6.0)

# %% hidden=true
# Your scan of the apartment, from above
picture = view.base.copy()
ends = to_world(eye, yours[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1))
for end in ends:
    view.polyline(picture, [eye[:2], end], colours.LASER, 1)
view.points(picture, ends, colours.LASER, 3)
view.robot(picture, eye, car.footprint)
show(picture)

# %% [markdown]
# ## 6 · From a ray to a column of pixels
#
# The camera sits 0.25 m above the floor (`EYE`) and the walls are 1 m high (`WALL_HEIGHT`). The [[depth]] $z$ of a wall is its distance along the viewing
# direction, not along the ray. The wall ends at the slopes $0.75 / z$ above and $-0.25 / z$ below the horizon. The camera's vertical field of view is 60 degrees, so the
# image reaches from the slope $s = \tan 30°$ (`slope`) at its upper edge down to $-s$, and its rows divide that range evenly. A row
# that the wall's edge cuts is covered *in part*, and its colour is mixed in that proportion. This is why the small images of 16 rows from which the networks
# learn still show distances well: the exact share is in the colour.
#
# ### Exercise 5 · `wall_share` (medium, 15 minutes)
#
# <details><summary>Hint 1: concept</summary>Each row is an interval of slopes, and so is the wall. How long is the part they have in common?</details>
# <details><summary>Hint 2: approach</summary>Row i reaches from s − i·h down to s − (i+1)·h, with h = 2s / rows. The overlap of two intervals is the smaller of the upper ends minus the larger of the lower ends.</details>
# <details><summary>Hint 3: one line</summary>For rows that the wall does not reach, the overlap comes out negative. Which numpy function replaces all negative numbers by 0? And what turns an overlap in slopes into a share of a row?</details>

# %%
slope = Camera().slope
print(f"eye {EYE} m, wall {WALL_HEIGHT} m, the image ends at slopes ±{slope:.3f}")


# %% exercise="wall_share"
def wall_share(depth, rows):
    """How much of each pixel of a column a wall covers.

    depth: m, greater than 0. rows: pixels of the column, any number from 1 on.
    Returns an array (rows,) in 0 to 1; row 0 is the top.
    """
    ### BEGIN SOLUTION
    height = 2 * slope / rows
    upper = slope - height * np.arange(rows)
    lower = upper - height
    top, bottom = (WALL_HEIGHT - EYE) / depth, -EYE / depth
    overlap = np.minimum(top, upper) - np.maximum(bottom, lower)
    return np.maximum(overlap, 0.0) / height
    ### END SOLUTION


# %%
wall_share = check_wall_share.use(wall_share)

# %% [markdown]
# Rays and columns together make a camera. Below, the library's rays give the depth and the colour of each of 64 columns, and `wall_share` mixes that colour with
# floor and ceiling. **Predict:** will this image and the library's differ, and where?

# %%
camera = Camera(rows=64)
image, distance = camera.look(scene, eye[None])
column_angles = camera.fan.angles[::-1]  # column 0 is the leftmost
depth = distance[0] * np.cos(column_angles)
ceiling, floor = scene.backdrop
middle = image[0, 30].astype(float)  # just above the horizon every pixel is wall
mine = np.zeros((64, 64, 3))
for column in range(64):
    share = wall_share(depth[column], 64)[:, None]
    behind = np.where(np.arange(64)[:, None] < 32, ceiling, floor)
    mine[:, column] = share * middle[column] + (1 - share) * behind
apart = np.abs(mine - image[0]).max()

# %% hidden=true
# The image made of rays and wall_share, and the library's
pictures = [camera_picture(mine.round().astype(np.uint8), 420), camera_picture(image[0], 420)]
print(f"largest difference: {apart:.1f} of 255 grey levels")
show(side_by_side(pictures, ["with wall_share", "by the library"]))

# %% [markdown]
# <details><summary>Do they differ?</summary>By less than one grey level: the library rounds to whole numbers, and nothing else.</details>
# <details><summary>Why the depth and not the distance?</summary>A pinhole camera shows straight walls straight. Columns at the side see the wall along a ray that is longer by
# 1 / cos(angle); without the cosine straight walls would bulge. Try it: replace <code>depth</code> by <code>distance[0]</code>.</details>
#
# ## 7 · Two places, one image
#
# This office has rooms that are furnished exactly alike; some are rotated by half a turn. **Predict:** how much do the images taken from the same spot in two of
# them differ, *the same relative to the furniture*?

# %% hidden=true
# Two offices that are furnished alike, and what a camera sees in them
office = Scene(generate("symmetric_office", seed=1))
rooms = [room for room in office.plan.rooms if room.kind == "office"]
middles = np.array([np.mean(room.outline, axis=0) for room in rooms])
headings = np.arange(8) * np.pi / 4
poses = np.array([[*place, heading] for place in middles for heading in headings])
images, depths = Camera(rows=64).look(office, poses)
inside = depths.max(axis=1) < 6.0  # no ray leaves through the door
alike = [
    (i, j)
    for i in np.flatnonzero(inside)
    for j in np.flatnonzero(inside)
    if i // 8 < j // 8 and (images[i] == images[j]).all()
]
first, second = alike[0]
office_view = PlanView(office, 460, 380)
plan = office_view.base.copy()
for pose in poses[[first, second]]:
    draw_field_of_view(office_view, plan, office, pose)
    office_view.robot(plan, pose, 1.6 * car.footprint)
shown = [camera_picture(images[k], 400) for k in (first, second)]
difference = np.abs(images[first].astype(int) - images[second]).max()
print(
    f"{len(alike)} identical pairs among {inside.sum()} views; the largest difference between these two is {difference}"
)
show(side_by_side([plan, stacked(shown, ["from the first room", "from the second"])]))

# %% [markdown]
# They are equal to the last bit. No camera, however good, can tell these two places apart from one image. This is [[perceptual aliasing]]. (A step
# aside, and the images differ: only exactly the same spot gives exactly the same image.) What helps is what came *before* the image, and notebooks 04 to 06 will use it.
#
# ## 8 · What a robot records
#
# Meng 2020 shows in its Fig. 6 a robot that follows a trajectory of 23 m, with numbered images along the path and the laser scans from above. Below is its
# counterpart. **Same protocol, easier world:** theirs is a scanned building with real textures, 64 × 64 pixels; ours has straight walls, even light and no floor
# texture, and here an oracle that knows the map drives the car. A recording of poses, images and actions is a [[trajectory]]. The orange dots are the laser scans at the
# numbered places: 96 beams all around, drawn up to 4 m. **Predict:** which two of the images will be most alike?

# %% hidden=true
# A trajectory through the apartment, with numbered images along it
distances = paths.fields(paths.points[paths.clearance.argmax()][None])
far = paths.points[np.where(np.isfinite(distances.cost[0]), distances.cost[0], 0).argmax()]
path = distances.path(far)
start = np.array([*path[0], np.arctan2(*(path[4] - path[0])[::-1])])
simulation = Simulation(scene, start, sensors=Sensors(camera=Camera(rows=64)))
oracle = OraclePolicy(simulation, paths, path[-1])
track, kept = [simulation.poses[0]], []
while np.linalg.norm(simulation.poses[0, :2] - path[-1]) > 0.3 and len(track) < 1000:
    if len(track) % 80 == 1:
        kept.append((simulation.poses[0], simulation.observe()))
    simulation.step(oracle.act(simulation.observe(), np.array([0])))
    track.append(simulation.poses[0])
picture = view.base.copy()
view.polyline(picture, np.array(track)[:, :2], colours.TRACK, 3)
frames, names = [], []
for number, (pose, observation) in enumerate(kept[:6], 1):
    beams = observation.laser[0]
    angles = (np.arange(96) + 0.5) * 2 * np.pi / 96 - np.pi
    local = beams[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    view.points(picture, to_world(pose, local[beams < 4.0]), colours.LASER, 1.5)
    view.robot(picture, pose, 1.4 * car.footprint)
    x, y = view.pixels(pose[:2]).round().astype(int)
    label(picture, str(number), x + 8, y - 8, 0.7)
    frames.append(camera_picture(observation.image[0], 230))
    names.append(f"image {number}")
length = arc_length(track)[-1]
print(f"a trajectory of {length:.1f} m")
images = np.array([observation.image[0] for _, observation in kept[:6]], dtype=float)
unlike = np.abs(images[:, None] - images).mean(axis=(2, 3, 4))  # mean difference of two images
first, second = np.triu_indices(len(images), k=1)
for pair in np.argsort(unlike[first, second])[:2]:
    i, j = first[pair], second[pair]
    print(f"images {i + 1} and {j + 1} differ by {unlike[i, j]:.0f} grey levels on average")
show(side_by_side([picture, stacked(frames, names, gap=4)], height=620))

# %% [markdown]
# <details><summary>Which two are most alike?</summary>
# Pixel by pixel, images 2 and 5, which were taken 15 m apart and show different walls; only then 3 and 4, which look along the same corridor. Pixel similarity is a poor measure of how close two
# places are. This is why the course learns what the car can <i>reach</i>, and does not simply compare images.
# </details>
#
# ## How it fails
#
# | what happens | cause | what helps |
# |---|---|---|
# | the estimated track leaves the building | odometry accumulates every small error | images of known places (notebook 04) |
# | a thin post is detected late | the laser's 96 beams are 13 cm apart at a distance of 2 m; the post stood between two | slower driving, the beams of the next scan |
# | the robot is sure of the wrong room | two rooms look alike, to the last bit | sequences of images, and a belief (notebook 07) |
# | the car cannot reach a place 50 cm to its left | its turning circle is wider than that | reversing (notebook 02), knowing what is reachable (notebook 03) |
#
# ## Optional extras
#
# - **Extra 1.** Drive a circle with `bicycle_step`, with `seconds=0.5` and with `seconds=0.01`. Which circle is larger, and how far apart are the cars after 20 s?
#   Write a version that moves along the exact arc; the check accepts it.
# - **Extra 2.** In `many_cars`, write `WheelOdometry(drift=...)`. How large may the drift be so that 90 % of the cars stay below 0.3 m after 20 seconds?
# - **Extra 3.** Call `wall_share` with 8 rows and with 4, for depths from 1 m to 8 m. From how far away can you still tell two depths apart?
#
# ## What to remember
#
# - A point changes frames by *shift, then rotate*, and motions add up by composition, not by addition.
# - A car drives circles no tighter than $r = L/\tan\delta$. Near is not the same as reachable.
# - Odometry is good for metres, not for minutes. Heading errors hurt most.
# - Laser and camera both come down to intersecting a ray with a segment. Partial pixel coverage shows distances more finely than whole pixels could.
# - Many places can give the same image.
#
# **Read next:** Meng 2020, [sections I to III-A](https://arxiv.org/abs/1909.12329), and then [notebook 02](02_local_control.ipynb), where the car learns to drive to the place shown in an image.
