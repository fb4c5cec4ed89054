# %% [markdown]
# # 01 · The world and the car
#
# **Facing the wrong way.** Yesterday your robot drove to the photo, by magic. This morning the magic's gone, and somebody has left the robot in the hallway, its back to the photo. With its wheels turned fully left, its rear axle traces a half circle 1.24 m across. *How wide must the hallway be for a U-turn?*
#
# Today you program how your robot moves, how it tracks its own motion, and how it sees. At the end, your code paints what the robot's camera sees in the living room.

# %% hidden=true
# A car beside a wall
import numpy as np
from IPython.display import display

from tutorial_lib.checks.nb01 import (
    check_bicycle_step,
    check_compose,
    check_ray_segment,
    check_to_local,
    check_wall_share,
)
from tutorial_lib.checks.predictions import Prediction
from tutorial_lib.driving import GridPaths, OraclePolicy
from tutorial_lib.geometry import arc_length, relative, to_world
from tutorial_lib.viz import (
    PlanView,
    camera_picture,
    chart,
    colours,
    from_figure,
    show,
    side_by_side,
    sliders,
    stacked,
    table,
)
from tutorial_lib.viz.canvas.labels import draw_badge
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

home = Scene(generate("apartment", seed=2))
paths = GridPaths(home.clearance)
view = PlanView(home, 320, 400)
car = BicycleCar()
hallway, living = (np.array(room.outline) for room in home.plan.rooms[:2])
WIDE = np.ptp(hallway[:, 0])  # metres from wall to wall
SIDE = 0.13  # metres from the lower wall to the middle of the car
radius = car.wheelbase / np.tan(car.max_steering)
turns = np.linspace(0, np.pi, 60)
half_circle = np.stack([radius * np.sin(turns), radius - radius * np.cos(turns), turns], axis=1)
swung = to_world(half_circle, car.footprint[1])  # the track of the outer front corner
needed = SIDE + swung[:, 1].max()


def draw_turn(told):
    """A half circle of the rear axle; with the outer front corner and the other wall if `told`."""
    figure, (axis,) = chart(7.0, 4.4)
    axis.axhline(-SIDE, color="0.3", linewidth=1.5, label="wall")
    axis.plot(*half_circle[:, :2].T, color=colours.unit(colours.TRACK), label="rear axle")
    for pose in half_circle[:: len(half_circle) - 1]:
        axis.fill(*to_world(pose, car.footprint).T, color=colours.unit(colours.ROBOT))
    spot = {"arrowprops": {"arrowstyle": "<->"}, "va": "center"}
    axis.annotate("", (-0.6, 0.0), (-0.6, 2 * radius), **spot)
    axis.text(-0.65, radius, f"{2 * radius:.2f} m", ha="right", va="center")
    if told:
        axis.plot(*swung.T, ":", color=colours.unit(colours.PATH), label="outer front corner")
        axis.axhline(WIDE - SIDE, color="0.3", linewidth=1.5)
        axis.set_title(f"The corner needs {needed:.2f} m, the hallway has {WIDE:.2f} m")
    axis.set(xlim=(-1.8, 2.2), ylim=(-0.25, 1.6), aspect="equal", xlabel="x / m", ylabel="y / m")
    figure.legend(loc="outside lower center", ncols=3, fontsize=10)
    return from_figure(figure)


turn = Prediction(
    "01",
    "turn",
    "How wide must a hallway be for the car to turn round in one go?",
    {"A": "about 1.25 m", "B": "about 1.6 m", "C": "about 2 m"},
    right="B",
    robot=f"it needs {needed:.2f} m, and your hallway has {WIDE:.2f} m. It stops, backs up, and "
    "goes again.",
    tempting="A",
    because="that's how wide the circle is. But the rear axle follows it, and the outer front "
    "corner swings wider.",
    before=draw_turn(False),
    after=draw_turn(True),
)
display(turn)

# %% [markdown]
# **100 minutes.** You need Python, numpy, sines and cosines. Until your function passes its check, the cells below use the library's; from then on **they use yours**. Where a function returns `(N, 2)`, return a numpy array, not a list. You can skip folded code. Units are metres, radians and seconds; headings are measured counter-clockwise from +x. A [[pose]] is `[x, y, heading]`.
#
# **Three old questions first.**
#
# <details><summary>Notebook 00: two images are identical, pixel by pixel. Were they taken at the same place?</summary>
# Not necessarily: twin rooms give the same image.
# </details>
# <details><summary>Notebook 00: why does the odometry's error shrink for a while after the car turns back?</summary>
# A heading error pushes the estimate to one side on the way out, and to the other on the way back.
# </details>
# <details><summary>Notebook 00: what does an edge of a topological map say?</summary>
# That the robot can drive from here to there by camera, and how likely that is. It says nothing about metres.
# </details>
#
# ## 1 · Where is it in the robot's frame?
#
# Your robot needn't know that the door is at (7.1, 2.4). It needs *two metres ahead and a little to the left*: the door's position in the robot's own [[frame]], x ahead, y to the left. First shift: subtract the robot's position. Then rotate: undo its heading. With the robot at $(x, y, \theta)$ and a point $p$,
#
# $$ p_\text{local} = R(\theta)^{\top}\,\bigl(p - (x, y)\bigr), \qquad R(\theta) = \begin{pmatrix}\cos\theta & -\sin\theta\\ \sin\theta & \cos\theta\end{pmatrix}. $$
#
# In the code, a point is a *row*. For rows, $R^{\top} v$ is written `v @ R`.
#
# ### Exercise 1 · `to_local` (easy, 10 minutes)
#
# <details><summary>Hint 1: concept</summary>A point straight ahead of the robot has local coordinates (distance, 0), whatever the heading.</details>
# <details><summary>Hint 2: approach</summary>Subtract first. Then the new x is the component of the offset along the robot's heading, and the new y its component to the left: two dot products.</details>
# <details><summary>Hint 3: one line</summary>At heading 0 the local point is (dx, dy); at 90 degrees it is (dy, −dx). Which two sums of dx and dy, weighted by cosine and sine, fit both cases?</details>


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

# %% hidden=true
# Five points in the world, and in the robot's frame
pose = np.array([1.0, 1.0, 2.2])
places = np.array([[0.0, 2.4], [2.0, 3.0], [3.0, 1.0], [-1.0, 0.0], [1.0, -0.5]])
local = to_local(pose, places)


def draw_points(*panels):
    """Panels, each of a robot's pose, five points and a title."""
    figure, axes = chart(4.5 * len(panels), 4.0, len(panels))
    for axis, (robot, points, name) in zip(axes, panels, strict=True):
        tip = to_world(robot, [0.8, 0.0])
        arrow = {"width": 3, "color": colours.unit(colours.ROBOT)}
        axis.annotate("", tip, robot[:2], arrowprops=arrow)
        axis.scatter(*points.T, s=70, color=colours.unit(colours.GOAL), zorder=3)
        for i, point in enumerate(points):
            axis.annotate(f" {i}", point, fontsize=13)
        axis.set(title=name, xlim=(-4, 4), ylim=(-3.5, 4), aspect="equal", xlabel="x / m")
    axes[0].set_ylabel("y / m")
    return from_figure(figure)


world = pose, places, "in the world"
frame = Prediction(
    "01",
    "frame",
    "In the robot's frame, which point has a negative x and a positive y?",
    {"A": "point 2", "B": "point 3", "C": "point 4"},
    right="C",
    robot=f"it has point 4 at ({local[4, 0]:.1f}, {local[4, 1]:.1f}): behind it, on its left.",
    tempting="B",
    because="on the page it lies to the left, and lower. But the robot faces the upper left: point "
    f"3 is at ({local[3, 0]:.1f}, {local[3, 1]:.1f}), nearly straight to its left.",
    before=draw_points(world),
    after=draw_points(world, (np.zeros(3), local, "in the robot's frame")),
)
display(frame)

# %% [markdown]
# ## 2 · One motion after another
#
# Your robot makes a motion A, then a motion B, given *in the robot's frame after A*. Rotate B's translation by A's heading, and add it to A's translation; the headings simply add up. This is **composition**, $A \oplus B$, and [[odometry]] is a long chain of compositions:
#
# $$ (x_1, y_1, \theta_1) \oplus (x_2, y_2, \theta_2) = \bigl((x_1, y_1) + R(\theta_1)\,(x_2, y_2),\;\; \theta_1 + \theta_2\bigr). $$
#
# Keep the heading between $-\pi$ and $\pi$: *wrap* it.
#
# ### Exercise 2 · `compose` (easy, 10 minutes)
#
# <details><summary>Hint 1: concept</summary>Drive 1 m, turn left, drive 1 m. The second metre goes along +y. Adding the coordinates would put it along +x.</details>
# <details><summary>Hint 2: approach</summary>This time the matrix is R itself, not its transpose: you go from the robot's frame to the world's.</details>
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
# Your robot repeats one motion: *one metre ahead, then a turn of 45 degrees to the left*. But its odometry overestimates each turn by one degree.


# %%
def repeated_motion(degrees):
    """Poses (25, 3) after 0 to 24 motions: one metre ahead, then a turn to the left."""
    poses = [np.zeros(3)]
    for _ in range(24):
        poses.append(compose(poses[-1], np.array([1.0, 0.0, np.deg2rad(degrees)])))
    return np.array(poses)


# %% hidden=true
# Three laps, and what odometry makes of them
true, thought = repeated_motion(45.0), repeated_motion(46.0)
off = np.linalg.norm(true[:, :2] - thought[:, :2], axis=1)


def draw_laps(told):
    """Three laps, and the odometry's if `told`."""
    figure, (axis,) = chart(5.0, 4.4)
    axis.plot(*true[:, :2].T, "o-", color=colours.unit(colours.TRACK), label="where it is")
    if told:
        tone = colours.unit(colours.BELIEVED)
        axis.plot(*thought[:, :2].T, ".:", color=tone, label="where its odometry puts it")
        for lap in (1, 2, 3):
            spot = {"textcoords": "offset points", "xytext": (-4, -18), "fontsize": 13}
            axis.annotate(str(lap), thought[8 * lap][:2], **spot)
    axis.set(ylim=(-0.5, 2.7), aspect="equal", xlabel="x / m", ylabel="y / m")
    figure.legend(loc="outside lower center", ncols=2, fontsize=10)
    return from_figure(figure)


laps = Prediction(
    "01",
    "laps",
    "After three laps, 24 m, the robot is back where it started. How far off is its odometry?",
    {"A": "about 5 cm", "B": "about half a metre", "C": "about 4 m"},
    right="B",
    robot=f"its odometry is {off[8]:.2f} m off after one lap, {off[16]:.2f} m after two and "
    f"{off[24]:.2f} m after three.",
    tempting="C",
    because="the heading is 24 degrees wrong by then, and on a straight road that would be metres. "
    "But on a circle, errors to one side and to the other nearly cancel.",
    before=draw_laps(False),
    after=draw_laps(True),
)
display(laps)

# %% [markdown]
# Each step inherits the heading errors before it. In section 4, the cars leave the circle.
#
# ## 3 · A car can't turn in place
#
# The front wheels turn by the steering angle $\delta$; the rear wheels only roll. The car's pose is taken at the middle of its rear axle, and $v$ is the speed there. The [[wheelbase]] $L$ is the distance between the axles. A dot denotes the time derivative:
#
# $$ \dot x = v\cos\theta, \qquad \dot y = v\sin\theta, \qquad \dot\theta = \frac{v}{L}\tan\delta . $$
#
# At a fixed steering angle the car drives in a circle of radius $r = L / \tan\delta$, at any speed. These equations are the [[kinematic bicycle model]]. Your car is 0.42 m long and 0.24 m wide, its wheelbase is 0.30 m, and its front wheels turn by at most 0.45 rad.
#
# ### Exercise 3 · `bicycle_step` (easy, 5 minutes)
#
# <details><summary>Hint 1: concept</summary>For a short time the car moves straight along its heading, and its heading changes by the turn rate times the time.</details>
# <details><summary>Hint 2: approach</summary>Write three lines, one for each equation above: add each rate times <code>seconds</code>. A negative speed needs no special case, and the heading need not be wrapped.</details>
# <details><summary>Hint 3: one line</summary>A tank that fills at <code>rate</code> litres a second will hold <code>level + rate * seconds</code> litres. What are the three levels here, and what are their rates?</details>


# %% exercise="bicycle_step"
def bicycle_step(pose, speed, steering, wheelbase, seconds):
    """The car's pose a short time later.

    pose: (3,) x, y, heading. speed: m/s, negative in reverse. steering: rad,
    positive to the left.
    wheelbase: m. seconds: s. Returns an array (3,): x, y, heading. The car
    moves along the heading that it has before the step.
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
# Back in the hallway, your function is at the wheel. Watch the corner's dotted track: does any angle get the car round?


# %%
def eight_seconds(steering_angle, speed):
    """The car's poses (400, 3) over eight seconds, with fixed controls."""
    pose, track = np.array([0.0, 0.0, 0.0]), []
    for _ in range(400):
        track.append(pose)
        pose = bicycle_step(pose, speed, steering_angle, car.wheelbase, 0.02)
    return np.array(track)


# %% hidden=true
# The car's turning circle in the hallway, with sliders
def turning_circle(steering_angle, speed):
    """The car's track over eight seconds, in the hallway."""
    track = eight_seconds(steering_angle, speed)
    outer = car.footprint[1 if steering_angle >= 0 else 2]  # the front corner that swings wide
    side = 1.0 if steering_angle >= 0 else -1.0  # the wall that the car starts along
    figure, (axis,) = chart(8.0, 4.0)
    for wall in (-SIDE * side, (WIDE - SIDE) * side):
        name = f"hallway, {WIDE:.2f} m" if wall > 0 else None
        axis.axhline(wall, color="0.3", linewidth=4, label=name)
    axis.plot(*track[:, :2].T, color=colours.unit(colours.TRACK), label="rear axle, 8 seconds")
    corner = to_world(track, outer)
    axis.plot(*corner.T, ":", color=colours.unit(colours.PATH), label="outer front corner")
    for end in (track[0], track[-1]):
        outline = to_world(end, car.footprint)
        axis.fill(*outline.T, color=colours.unit(colours.ROBOT))
    axis.set(xlim=(-2.2, 4.2), ylim=(-2.0, 2.0), aspect="equal", xlabel="x / m", ylabel="y / m")
    figure.legend(loc="outside lower center", ncols=3, fontsize=10)
    if not steering_angle:
        return from_figure(figure), "straight on"
    circle = car.wheelbase / np.tan(abs(steering_angle))
    need = SIDE + circle + np.hypot(outer[0], circle + abs(outer[1]))  # half a circle
    text = f"radius {circle:.2f} m; to turn round it needs {need:.3f} m, and has {WIDE:.3f} m"
    return from_figure(figure), text


sliders(
    turning_circle,
    {"steering_angle": "steering angle, rad (+ is left)", "speed": "speed, m/s"},
    steering_angle=(-0.45, 0.45, 0.05, 0.45),
    speed=(-0.3, 0.8, 0.1, 0.3),
)

# %% [markdown]
# Parked along the wall, none does, at any speed. So *near* isn't *reachable*: a place half a metre to the car's left is harder to reach than one three metres ahead. That's why the network of notebook 03 learns reachability, not distance.
#
# ### When it touches something
#
# The bicycle equations don't know about walls. A physics library, [pymunk](https://www.pymunk.org), does: to it, the car is a **rigid body**, which moves and turns but never bends. At a **contact**, the part of the car's velocity that points into the wall is taken away. The rest moves the car.
#
# One car drives straight at a wall, another at 40° to it, and their motors run for five seconds. The third stands still, and a person walks into it.

# %% hidden=true
# Three contacts: a wall ahead, a wall at an angle, and a person
WALL = living[:, 1].min()  # y of the living room's lower wall, m
passer = Person([[-4.0, WALL + 1.53], [-4.0, WALL + 0.63]], speed=0.3, keep_off=0.0)
rounds = np.linspace(0, 2 * np.pi, 40)
disc = passer.radius * np.stack([np.cos(rounds), np.sin(rounds)], axis=1)
trials = {
    "a wall ahead": ([-3.6, WALL + 0.83, -np.pi / 2], 0.5, []),
    "a wall at an angle": ([-4.5, WALL + 0.68, np.deg2rad(-40)], 0.5, []),
    "a person": ([-4.1, WALL + 1.03, 0.0], 0.0, [passer]),
}
rows, films = [], {}
for name, (start, speed, people) in trials.items():
    trial = Simulation(home, start, people=people, sensors=Sensors(camera=None))
    track, walked, touched = [trial.poses[0]], [trial.crowd.positions], [False]
    for _ in range(29 if people else 50):
        trial.step([[speed, 0.0]])
        track.append(trial.poses[0])
        walked.append(trial.crowd.positions)
        touched.append(trial.touching[0])
    track, walked, first = np.array(track), np.array(walked), int(np.argmax(touched))
    after, asked = track[first:], speed * 0.1 * (len(track) - first - 1)
    degrees = np.rad2deg(after[-1, 2] - after[0, 2])
    rows.append([name, 0.1 * first, asked, arc_length(after)[-1], degrees])
    films[name] = track, walked, first


def draw_contacts(told):
    """The three contacts: start and first contact, and the end if `told`."""
    figure, axes = chart(10.5, 3.4, 3)
    for axis, (name, (track, walked, first)) in zip(axes, films.items(), strict=True):
        moving = [(track, car.footprint, colours.ROBOT)]
        if walked.size:
            passing = np.column_stack([walked[:, 0], np.zeros(len(walked))])
            moving.append((passing, disc, colours.PERSON))
            spot = walked[first, 0] - [0.0, passer.radius]
        else:
            corners = to_world(track[first], car.footprint)
            spot = corners[corners[:, 1] < corners[:, 1].min() + 0.01].mean(axis=0)
        for poses, outline, tone in moving:
            for k, strength in ((0, 0.25), (first, 0.5), *([(-1, 1.0)] if told else [])):
                shape = to_world(poses[k], outline) - [0.0, WALL]
                axis.fill(*shape.T, color=colours.unit(tone), alpha=strength, linewidth=0)
        if told:
            axis.plot(track[:, 0], track[:, 1] - WALL, color=colours.unit(colours.TRACK))
        tone = colours.unit(colours.LASER)
        axis.plot(spot[0], spot[1] - WALL, "x", color=tone, ms=11, mew=3, label="first contact")
        axis.axhspan(-0.15, 0, color=colours.unit(colours.SOLID), linewidth=0, label="wall")
        middle = track[[0, -1], 0].mean() + 0.1
        axis.set(xlim=(middle - 1.5, middle + 1.5), ylim=(-0.15, 1.8), aspect="equal")
        axis.set(title=name, xlabel="x / m")
    axes[0].set_ylabel("from the wall / m")
    handles = axes[0].get_legend_handles_labels()
    figure.legend(*handles, loc="outside lower center", ncols=2, fontsize=10)
    return from_figure(figure)


contact = Prediction(
    "01",
    "contact",
    "Paler is earlier. Which car moves farthest after the first contact?",
    {"A": "the one with a wall ahead", "B": "the one at an angle", "C": "the one standing still"},
    right="B",
    robot=f"at an angle, the car scrapes along for {rows[1][3]:.2f} m. The person pushes the third "
    f"{rows[2][3]:.2f} m, and the car with a wall ahead moves {rows[0][3]:.2f} m.",
    tempting="C",
    because="it's the one without a wall in its way. But it goes only as far as the person walks, "
    "and a wall never takes away the part of a velocity that runs along it.",
    before=draw_contacts(False),
    after=draw_contacts(True),
)
display(contact)

# %% hidden=true
# The three contacts in numbers
head = {"the car meets": "", "first contact, s": ".1f", "its wheels then ask for, m": ".2f"}
table(head | {"it then moves, m": ".2f", "it turns, °": "+.0f"}, rows)

# %% [markdown]
# The wall pushes the second car's front corner, and so turns the car. There's no **friction** here; a real wall would slow and scratch the car.
#
# <details><summary>How far is the person moved?</summary>
# Not at all. A person follows a route, whatever touches them; pymunk calls such a body <i>kinematic</i>. This person ignores robots. People in later notebooks stop 1.3 m from a robot, wait two seconds, and walk back. <code>simulation.touching</code> says whether a robot touches something now, and <code>simulation.collided</code> whether it ever has.
# </details>
#
# ## 4 · Two hundred cars, the same commands
#
# Motors aren't precise. Ten times a second, we multiply both controls by random numbers with mean 1 and standard deviation 0.33, as X. Meng, N. Ratliff, Y. Xiang and D. Fox do in [*Scaling Local Control to Large-Scale Topological Navigation*](https://arxiv.org/abs/1909.12329) (ICRA 2020, section IV-B). Odometry errs, too: by about 5% of each distance and turn, and its heading drifts.
#
# Two hundred cars start at the same place and get the same commands for 20 s. Your `compose` computes where they are, and where their odometry puts them.

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
along, across = error[:, 0].std(), error[:, 1].std()
spread = np.hypot(*true[-1, :, :2].std(axis=0))
half, most = np.quantile(np.linalg.norm(error[:, :2], axis=1), (0.5, 0.9))


def draw_cloud(told):
    """The tracks of the cars, and the errors of their odometry if `told`."""
    figure, axes = chart(9.5 if told else 4.8, 4.2, 1 + told)
    for i in range(0, 200, 4):
        tone = colours.unit(colours.TRACK)
        axes[0].plot(*true[:, i, :2].T, color=tone, alpha=0.15, linewidth=1)
    axes[0].scatter(*true[-1, :, :2].T, s=8, color=colours.unit(colours.TRACK))
    axes[0].set(title="true positions of 200 cars", aspect="equal", xlabel="x / m", ylabel="y / m")
    if told:
        axes[1].scatter(*error[:, :2].T, s=8, color=colours.unit(colours.BELIEVED))
        axes[1].set(title="odometry error, in the frame of each car", aspect="equal")
        axes[1].set(xlim=(-3, 3), xlabel="error ahead / m")
        axes[1].set(ylim=(-3.4, 3.4), ylabel="error to the left / m")
    return from_figure(figure)


cloud = Prediction(
    "01",
    "cloud",
    "Next we plot each car's odometry error at the end, seen from that car. What will the cloud "
    "of errors look like?",
    {
        "A": "as large as this cloud",
        "B": "smaller, and longer lengthwise than across",
        "C": "smaller, and longer across than lengthwise",
    },
    right="C",
    robot=f"its odometry is {along:.2f} m off lengthwise and {across:.2f} m across (standard "
    f"deviations); the cars themselves are spread over {spread:.2f} m. For half of the cars it's less "
    f"than {half:.2f} m off, for nine tenths less than {most:.2f} m.",
    tempting="B",
    because="5% of a distance is an error ahead. But the errors of a hundred steps nearly cancel; "
    "a heading that drifts doesn't, and over metres it becomes an error across.",
    before=draw_cloud(False),
    after=draw_cloud(True),
)
display(cloud)

# %% [markdown]
# Commands alone say little about where a car is. Odometry says more, but can't correct its own errors. Only a look at the world can.
#
# ### Find the bug
#
# A colleague's odometry is right on straights and wrong after every bend. Where's the bug? Decide before you unfold the answer.
#
# ```python
# def update(pose, ahead, turn):
#     x, y, heading = pose
#     heading = heading + turn
#     return np.array([x + ahead, y, heading])
# ```
#
# <details><summary>Answer</summary>The step is added along the world's x axis and never rotated by the heading: return
# <code>compose(pose, [ahead, 0, turn])</code> instead. A test that drives straight along +x wouldn't catch this; good tests turn first.</details>
#
# ## 5 · A ray hits a wall
#
# Your robot opens its eyes. A beam of its [[laser scanner]] and a column of its image ask the same question: how far is the nearest wall in this direction? A wall is a segment from $a$ to $b$; a ray starts at $o$ and runs along the unit vector $d$. They intersect where
#
# $$ o + t\,d = a + u\,(b - a), \qquad t \ge 0, \quad 0 \le u \le 1. $$
#
# Take the cross product of both sides with $b - a$, and $u$ drops out; take it with $d$, and $t$ does. With $p \times q = p_x q_y - p_y q_x$,
#
# $$ t = \frac{(a - o)\times(b - a)}{d\times(b - a)}, \qquad u = \frac{(a - o)\times d}{d\times(b - a)} . $$
#
# Where ray and wall are parallel, the denominator is zero, up to rounding. So an absolute value below $10^{-12}$ counts as parallel.
#
# ### Exercise 4 · `ray_segment` (medium, 10 minutes)
#
# <details><summary>Hint 1: concept</summary>The ray misses in three cases: the wall is behind it (t), it passes beyond the wall's ends (u), or the two are parallel (zero denominator).</details>
# <details><summary>Hint 2: approach</summary>Write a small function for the cross product. Handle the parallel case first and return np.inf.</details>
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
# Now your function scans the living room: 60 rays, each against every nearby wall. The library's compiled [`world/raycast.py`](../tutorial_lib/world/raycast.py) is some ten thousand times faster.

# %%
eye = np.array([-4.5, -11.6, 0.2])
angles = np.linspace(-np.pi, np.pi, 60, endpoint=False)
near = np.linalg.norm(home.plan.segments.reshape(-1, 2, 2) - eye[:2], axis=2).min(axis=1) < 8.0
walls = home.plan.segments[near]
yours = []
for angle in eye[2] + angles:
    direction = np.array([np.cos(angle), np.sin(angle)])
    yours.append(min(ray_segment(eye[:2], direction, wall[:2], wall[2:]) for wall in walls))
yours = np.minimum(yours, 6.0)

# %% hidden=true
# Your scan of the living room, from above
picture = view.plain.copy()
ends = to_world(eye, yours[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1))
for end in ends:
    view.polyline(picture, [eye[:2], end], colours.LASER, 1)
view.points(picture, ends, colours.LASER, 3)
view.robot(picture, eye, car.footprint)
show(stacked([picture], ["Your scan: 60 rays, cut off at 6 m"]))

# %% [markdown]
# ## 6 · From a ray to a column of pixels
#
# The camera sits 0.25 m above the floor (`EYE`), and the walls are 1 m high (`WALL_HEIGHT`). The [[depth]] $z$ of a wall is its distance along the viewing direction, not along the ray. A slope is a height relative to the eye, divided by $z$: the wall reaches from $0.75 / z$ down to $-0.25 / z$. The image reaches from $s = \tan 30°$ (`slope`) down to $-s$, and its rows divide that range evenly.
#
# A row that the wall's edge crosses is covered *in part*, and its colour is mixed in that proportion. So even 16-row images show distances well: the colour says how much.
#
# ### Exercise 5 · `wall_share` (medium, 15 minutes)
#
# <details><summary>Hint 1: concept</summary>Each row is an interval of slopes, and so is the wall. How long is the part they have in common?</details>
# <details><summary>Hint 2: approach</summary>Row i reaches from s − i·h down to s − (i+1)·h, with h = 2s / rows. The overlap of two intervals is the smaller of the upper ends minus the larger of the lower ends.</details>
# <details><summary>Hint 3: one line</summary>For rows the wall does not reach, the overlap is negative. Which numpy function replaces all negative numbers with 0? And what turns an overlap in slopes into a share of a row?</details>

# %%
slope = Camera().slope
print(f"eye {EYE} m, wall {WALL_HEIGHT} m, the image ends at slopes ±{slope:.5f}")


# %% exercise="wall_share"
def wall_share(depth, rows):
    """How much of each pixel of a column a wall covers.

    depth: m, greater than 0. rows: pixels of the column, 1 or more.
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
# Rays and columns make a camera. Here's notebook 00's living room, painted by your code: the library's rays give each column's depth and colour, and your `wall_share` mixes in floor and ceiling. Compare it with the library's image.

# %%
camera = Camera(rows=64)
image, distance = camera.look(home, eye[None])
column_angles = camera.fan.angles[::-1]  # column 0 is the leftmost
depth = distance[0] * np.cos(column_angles)
ceiling, floor = home.backdrop
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
# They differ by less than one grey level, only because the library rounds to whole numbers.
#
# <details><summary>Why the depth and not the distance?</summary>A pinhole camera shows straight walls as straight. Columns at the sides see the wall along rays longer by a factor of
# 1 / cos(angle); without the cosine, straight walls would bulge. Try it: replace <code>depth</code> with <code>distance[0]</code>.</details>
#
# ## 7 · The way to the photo
#
# An oracle drives your robot to the photo and records a [[trajectory]]: poses, images and actions. Orange dots are the robot's laser scans at the numbered places. The figure is the twin of the paper's Fig. 6, **in an easier world**: the paper's world is a scanned building with real textures.

# %% hidden=true
# A trajectory through the flat, with numbered images along it
start, goal = np.array([-5.07, -12.85, 0.72]), np.array([3.23, -0.55])
simulation = Simulation(home, start, sensors=Sensors(camera=Camera(rows=64)))
oracle = OraclePolicy(simulation, paths, goal)
track, recorded = [start], [simulation.observe()]
while np.linalg.norm(track[-1][:2] - goal) > 0.3 and len(track) < 1000:
    simulation.step(oracle.act(recorded[-1], np.array([0])))
    track.append(simulation.poses[0])
    recorded.append(simulation.observe())
kept = [*range(0, len(track) - 20, 40), len(track) - 1]  # every 4 s, and the last one
picture = view.plain.copy()
view.polyline(picture, np.array(track)[:, :2], colours.TRACK, 3)
frames, names = [], []
for number, k in enumerate(kept, 1):
    beams = recorded[k].laser[0]
    angles = (np.arange(96) + 0.5) * 2 * np.pi / 96 - np.pi
    local = beams[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    view.points(picture, to_world(track[k], local[beams < 4.0]), colours.LASER, 1.5)
    view.robot(picture, track[k], 1.4 * car.footprint)
    near = track[k - 9] if k else track[11]  # on its way, where nothing else is
    draw_badge(picture, str(number), view.pixels(near[:2]), 0.45)
    frames.append(camera_picture(recorded[k].image[0], 220))
    names.append(f"image {number}")
images = np.array([recorded[k].image[0] for k in kept], dtype=float)
unlike = np.abs(images[:, None] - images).mean(axis=(2, 3, 4))  # mean difference of two images
columns = [stacked(frames[i::2], names[i::2], gap=4) for i in (0, 1)]
alike = Prediction(
    "01",
    "alike",
    "Compare the images pixel by pixel. Which two differ least?",
    {"A": "6 and 7", "B": "2 and 4", "C": "3 and 4"},
    right="B",
    robot=f"it subtracts. 2 and 4 differ by {unlike[1, 3]:.0f} grey levels on average, 3 and 4 by "
    f"{unlike[2, 3]:.0f}, 6 and 7 by {unlike[5, 6]:.0f}.",
    tempting="C",
    because="3 and 4 look along the same hallway. But from one to the other, each pixel sees "
    "another piece of the painted walls, and pixels are all that's compared.",
    before=side_by_side([picture, *columns], gap=8),
)
print(f"a trajectory of {arc_length(np.array(track))[-1]:.1f} m")
display(alike)

# %% [markdown]
# Pixels are a poor measure of how close two places are. So you'll teach a network what the car can *reach*. The laser has its limits, too: at 2 m its 96 beams are 13 cm apart, and a thin post fits between two.
#
# **Close the notebook and draw the pipeline**, with your function names: from a command to the image that follows it.
#
# After this notebook you can
#
# - say where an object is in the robot's frame, and where the robot is after two motions;
# - predict what a car that steers with its front wheels can and can't do;
# - explain why a robot that relies on wheel odometry gets lost;
# - turn a floor plan into a camera image, column by column.
#
# <details><summary>Extras, if you like</summary>
# Drive in a circle using <code>bicycle_step</code>, with <code>seconds=0.5</code> and <code>seconds=0.01</code>: which circle is larger, and how far apart are the cars after 20 s? A function that moves the car along the exact arc passes the check, too.
#
# In <code>many_cars</code>, write <code>WheelOdometry(drift=...)</code>: how large may the drift be for 90% of the errors to stay below 0.3 m after 20 s?
#
# Call <code>wall_share</code> with 8 rows and with 4, for depths from 1 m to 8 m: up to what depth do two depths 10 cm apart still differ, in shares rounded to hundredths?
# </details>
#
# Tonight your robot can see and move, but an oracle turned its wheels. Hold up the photo, and it stays put. In [notebook 02](02_local_control.ipynb) you'll write code that turns an image into steering. Sections I to III-A of the paper are good reading until then.
