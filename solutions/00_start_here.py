# %% [markdown]
# # 00 · Start here
#
# **The photo on the fridge.** You've moved into a flat, and a robot car with a camera lives there. On the fridge hangs a photo, with a note: *take me here*. You have the floor plan. The robot has the photo. *Where was it taken?*
#
# In a minute the robot will drive there, once, by magic. After that the magic's gone: over ten notebooks you'll build it yourself.
#
# **20 minutes.** No code to write: click the first cell, and press *Shift + Enter* repeatedly. Short of time? Skip *Other worlds*. Most code is folded; click the three dots to read it.

# %%
from tutorial_lib.checks.nb00 import check_environment

ready = check_environment()

# %% hidden=true
# The flat, and the photo on the fridge
import tempfile
from pathlib import Path

import cv2
import numpy as np
from IPython.display import display

from tutorial_lib.checks.predictions import Prediction
from tutorial_lib.checks.robot import name_robot
from tutorial_lib.driving import GridPaths, OraclePolicy
from tutorial_lib.experiments.demos import navigate_once, place_people
from tutorial_lib.geometry import arc_length, compose
from tutorial_lib.learning import use_threads
from tutorial_lib.viz import (
    PlanView,
    TeleopController,
    camera_picture,
    chart,
    closeup,
    colours,
    draw_field_of_view,
    faded,
    from_figure,
    label,
    play,
    show,
    side_by_side,
    sliders,
    stacked,
    teleop,
)
from tutorial_lib.world import (
    FAMILIES,
    Camera,
    Scene,
    Simulation,
    WheelOdometry,
    generate,
    import_ros_map,
)

use_threads(1)  # the networks are small: a second thread would mostly wait
home = Scene(generate("apartment", seed=2))
camera = Camera(rows=64, columns=192)
fridge = np.array([2.97, -0.73, 0.48])  # of the photo: x and y in metres, and the heading
corner = np.array([-5.07, -12.85, 0.72])  # where the robot stands at first
PLACES = {"A": [-4.79, -12.66, -2.55], "B": fridge, "C": [-4.87, -7.85, -2.8]}


def photo(scene, pose, width=400):
    """What a camera sees at a pose."""
    images, _ = camera.look(scene, np.array(pose)[None])  # one pose in, one image out
    return camera_picture(images[0], width, smooth=True)


def plan_with(scene, poses, names=None, size=(330, 400), tones=(colours.ROBOT,) * 3):
    """A plan with cameras at poses, what they see in yellow, and perhaps their names."""
    view = PlanView(scene, *size)
    plan = view.base.copy()
    for pose in poses:
        draw_field_of_view(view, plan, scene, np.array(pose))
    for pose, name, tone in zip(poses, names or " " * len(poses), tones, strict=False):
        view.arrow(plan, np.array(pose), tone)
        x, y = view.pixels(pose[:2]).round().astype(int)
        label(plan, name, x + 15 if x < size[0] / 2 else x - 32, y + 6)
    return plan


told = ["from A", "from B: the photo on the fridge", "from C"]
above, near_view = plan_with(home, PLACES.values(), PLACES), PlanView(home, 720, 1000)
near = near_view.base.copy()
for pose in PLACES.values():
    near_view.arrow(near, np.array(pose), colours.ROBOT, 7)
corners = [
    closeup(near_view, near, np.array([pose[:2]]), 1.0, square=True) for pose in PLACES.values()
]
where = Prediction(
    "00",
    "where",
    "Where was the photo taken?",
    {"A": "at A, in the living room", "B": "at B, in the bathroom", "C": "at C, in the bedroom"},
    right="B",
    robot="it has no plan to look at. All it can do is compare photos.",
    tempting="A",
    because="it has a blue wall, too. But at A the blue wall is on the left, and a plant on the right.",
    before=side_by_side(
        [above, stacked([photo(home, fridge), side_by_side(corners, list(PLACES))])],
        ["the plan, and three cameras", "the photo on the fridge, and three corners of the plan"],
    ),
    after=side_by_side(
        [above, stacked([photo(home, pose, 330) for pose in PLACES.values()], told, gap=6)]
    ),
)
display(where)

# %% [markdown]
# ## Give it a name
#
# It's your robot, so call it what you like. It keeps that name throughout.

# %%
robot = name_robot("Rover")
print(f"Hello, {robot}!")

# %% [markdown]
# ## It drives there, once
#
# Somebody has driven your robot through the flat. From its images the robot made a map: coloured arrowheads mark the images it kept, and thin lines connect them. Now you hold up the photo. Your robot has a camera and a laser, but **no floor plan and no coordinates**.
#
# It plans a path through its images, and predicts how likely the plan is to work. Then it sets off, past two people who appear in none of its images. Watch how it gets past them. The cell takes about 20 s.

# %% hidden=true
# It learns a map of the flat, and drives to the photo
film, outcome = navigate_once(home, seed=2, places=4, goal=[3.23, -0.55, 0.2])
print(f"a map of {outcome.vertices} images, joined by {outcome.edges} lines")
print(f"{outcome.geodesic:.0f} m, {outcome.rooms_away} doors: from {' to '.join(outcome.rooms)}")
print(f"predicted probability of success: {outcome.probability:.0%}")
print(f"{robot} {outcome.ending}, after {outcome.seconds:.0f} s")
drive = np.linspace(0, len(film) - 24, 13).round().astype(int)  # the last picture stays for two s
frames = [cv2.resize(film[i], (756, 456), interpolation=cv2.INTER_AREA) for i in drive]
maps = [frame[:444, :444] for frame in frames]
play(frames, 3, times=np.linspace(0.0, outcome.seconds, len(frames)), count=3, strip=maps)

# %% [markdown]
# That's the whole course in a minute. How does it work?
#
# ## Through its eyes
#
# Your robot is in the living room. Its camera covers 120 degrees; the floor in view is yellow.

# %% hidden=true
# The robot on the plan, and three images
living, turned = np.array([[-4.5, -11.6, 0.2], [-4.5, -11.6, 0.2 + np.pi / 2]])
mirrored = photo(home, living, 360)[:, ::-1]
eyes = Prediction(
    "00",
    "eyes",
    "Which image does the robot see?",
    {"A": "the upper one", "B": "the middle one", "C": "the lower one"},
    right="C",
    robot="it gets this image, and nothing else: neither the plan nor the arrow on it.",
    tempting="A",
    because="the colours are the same. But left and right are swapped: the green and blue thing on "
    "the plan is to the robot's left.",
    before=side_by_side(
        [
            plan_with(home, [living]),
            stacked(
                [mirrored, photo(home, turned, 360), photo(home, living, 360)],
                ["A", "B", "C"],
                gap=6,
            ),
        ]
    ),
)
display(eyes)

# %% [markdown]
# The image says: *something green and blue is close on your left, and you can drive past it.* It doesn't say: *you're in the living room, at (-4.5, -11.6)*. Reaching the place shown in an image, using such images alone, is [[image-goal navigation]].
#
# ## A field trip
#
# The office next door repeats one stretch of corridor, with its rooms, as real offices often do. Two robots stand in two of its rooms.

# %% hidden=true
# Two rooms of an office, and what a robot sees in each
office = Scene(generate("symmetric_office", seed=3))
rooms = [room for room in office.plan.rooms if room.kind == "office"]
middles = [np.mean(rooms[i].outline, axis=0) for i in (0, 6)]
pose_a, pose_b = (np.array([*middle, 2.0]) for middle in middles)
(image_a, image_b), _ = camera.look(office, np.array([pose_a, pose_b]))
differ = (image_a != image_b).any(axis=-1)
plan = plan_with(office, [pose_a, pose_b], None, (400, 400), (colours.ROBOT, colours.LASER))
plan = stacked([plan], ["room A: blue; room B: orange"])
print(f"{np.linalg.norm(pose_a - pose_b):.1f} metres apart")
twins = Prediction(
    "00",
    "twins",
    f"Each robot takes an image of {differ.size:,} pixels. In how many do the two images differ?",
    {"A": "in none", "B": "in about a hundred", "C": "in nearly all"},
    right="A",
    robot=f"{differ.sum()} pixels differ. From one image, it can't tell which room it's in.",
    tempting="C",
    because="the robots are far apart. But a camera sees no coordinates, only a room, and the two "
    "rooms are furnished alike.",
    before=plan,
    after=side_by_side(
        [plan, stacked([photo(office, pose_a), photo(office, pose_b)], ["room A", "room B"])]
    ),
)
display(twins)

# %% [markdown]
# **From one image, no method, however clever, can tell these two places apart.** This is [[perceptual aliasing]]. A map made of images may join two places that only look alike, and a robot that trusts such a map may plan a path through a wall. What helps is memory: the robot came from *somewhere*, and the paths to the two rooms differ.
#
# ## Why not count the turns of the wheels?
#
# A car can measure how far its wheels have turned. Add up the small motions, and you get an estimate of where it is: [[odometry]]. Back home, 30 cars drive the same path: from the living room to the bathroom, back, and there again. Ten times a second each car's odometry makes a new error, of about 5% of the distance and turn just driven; and, which weighs more in the end, its heading drifts a little.

# %% hidden=true
# 30 cars drive the same path, each with its own odometry (about 5 s)
paths = GridPaths(home.clearance)  # shortest paths through the free space
start, goal = corner, fridge[:2]
leader, actions = Simulation(home, start), []
for stop in (goal, start[:2], goal):  # one car drives there, back and there again, recorded
    oracle = OraclePolicy(leader, paths, [stop])
    while np.linalg.norm(leader.poses[0, :2] - stop) > 0.3:
        actions.append(oracle.act(leader.observe(), np.array([0])))
        leader.step(actions[-1])

cars = Simulation(
    home, np.tile(start, (30, 1)), odometry_noise=WheelOdometry(), rng=np.random.default_rng(0)
)
driven, estimated = [], []
for action in actions:  # 30 cars repeat the actions
    cars.step(np.tile(action, (30, 1)))
    driven.append(cars.poses[0, :2])
    estimated.append(cars.odometry)
driven, estimated = np.array(driven), compose(start, np.array(estimated))[..., :2]
metres, errors = arc_length(driven), np.linalg.norm(estimated - driven[:, None], axis=-1)

view = PlanView(home, 320, 400)
path = faded(view.base)
view.polyline(path, driven, colours.TRACK, 3)
view.points(path, driven[-1:], colours.ROBOT, 7)
thought = faded(view.base)
for i in range(30):
    view.polyline(thought, estimated[:, i], colours.BELIEVED, 1)
view.polyline(thought, driven, colours.TRACK, 3)
view.points(thought, estimated[-1], colours.BELIEVED, 4)
view.points(thought, driven[-1:], colours.ROBOT, 7)
figure, (axes,) = chart(5, 4.4)
axes.plot(metres, errors, color=colours.unit(colours.BELIEVED), linewidth=1, alpha=0.35)
axes.plot(
    metres, np.median(errors, axis=1), color=colours.unit(colours.INK), label="median of 30 cars"
)
axes.set(xlabel="metres driven", ylabel="position error of the odometry, metres")
axes.legend(frameon=False)
wheels = Prediction(
    "00",
    "wheels",
    f"After {metres[-1]:.0f} m, how far off is the odometry of a typical car?",
    {"A": "about 10 cm", "B": "about 1 m", "C": "about 3 m"},
    right="B",
    robot=f"half of the cars are less than {np.median(errors[-1]):.2f} m off, and the worst is "
    f"{errors[-1].max():.1f} m off.",
    tempting="C",
    because=f"5% of {metres[-1]:.0f} m is {0.05 * metres[-1]:.1f} m. But each step's error is "
    "another one, and most of them cancel. What's left comes from the heading's drift.",
    before=stacked([path], ["There, back, and there again"]),
    after=side_by_side(
        [thought, from_figure(figure)], ["blue: path driven; black: odometry", "the error grows"]
    ),
)
display(wheels)

# %% [markdown]
# Some black tracks pass through walls, and a door is only a metre wide. The error shrinks for a while after the car turns back, but in the end it grows, and nothing the wheels measure can correct it. **Odometry is good for a few metres, not for a building.**
#
# ## A map without coordinates
#
# So the map in the film holds no coordinates. It's a [[topological map]]:
#
# - a **[[vertex]]** is a place, stored as the images taken there;
# - an **[[edge]]** says that *the robot can drive from here to there by camera*, and how likely that is.
#
# Planning finds the path most likely to succeed; following it means driving from image to image.
#
# ## You drive
#
# Now you look through the camera. Each button press drives the car for half a second; arrow keys work, too, with the pointer on the picture. The car steers like a real one: it **can't turn in place**. Leave the room. Then press *start again* and *hide the map*. Can you still find the bathroom?

# %% hidden=true
# Drive the car
car = TeleopController(home, start)
teleop(car, rehearsal=["forward"] * 4 + ["left"] * 5)

# %% [markdown]
# Did you get lost? So will your robot. What did you go by? Colours, door frames, and *what you saw a moment ago*.
#
# ## A policy that cheats
#
# A **policy** decides what a robot does next. The one in this film knows the floor plan and where the robot is. Such a policy is an **[[oracle]]**: it shows what's possible, and you'll compare yours with it. The people are pink.

# %% hidden=true
# Film a policy that knows the map (about 5 s)
people = place_people(paths.fields(goal).path(start[:2]), home)
simulation = Simulation(home, start, people=people)
oracle = OraclePolicy(simulation, paths, [goal])
frames, times, track = [], [], [start[:2]]
while np.linalg.norm(simulation.poses[0, :2] - goal) > 0.3 and simulation.seconds < 60:
    simulation.step(oracle.act(simulation.observe(), np.array([0])))
    track.append(simulation.poses[0, :2])
    if len(track) % 10 == 0:  # a frame every second
        pose, discs = simulation.poses[0], simulation.discs
        above = faded(view.base, 0.65)
        draw_field_of_view(view, above, home, pose, discs=discs)
        view.polyline(above, track, colours.TRACK, 2)
        view.goal(above, goal)
        for x, y, radius in discs.circles:
            view.disc(above, [x, y], radius, colours.PERSON)
        view.robot(above, pose, simulation.body.footprint)
        images, _ = camera.look(home, pose[None], discs)
        frames.append(side_by_side([above, camera_picture(images[0], 330, smooth=True)]))
        times.append(simulation.seconds)

print(f"arrived after {simulation.seconds:.0f} s; collided: {simulation.collided[0]}")
print("the film runs at four times real speed")
play(frames, 4, times)

# %% [markdown]
# ## Other worlds
#
# Every world is generated at random from a *family* and a *seed*. The same pair gives the same world, so a robot can be trained on some seeds and tested on others. In which family would you hate to navigate by camera?


# %% hidden=true
# Choose a world
def draw_world(family, seed):
    """A map of a world, and its size."""
    plan = generate(family, seed)
    text = f"{plan.area:.0f} square metres, {len(plan.rooms)} rooms, {len(plan.doors)} doors"
    return PlanView(Scene(plan), 480, 480).base, text


sliders(
    draw_world, {"family": "family of worlds", "seed": "seed"}, family=FAMILIES, seed=(0, 30, 1, 5)
)

# %% [markdown]
# Has a real robot mapped your lab? The Robot Operating System (ROS) saves a map as an image, in which dark means *wall*, and a small text file. The next cell makes such a map, of three rooms and a corridor, and imports it. The walls' colours are random.

# %% hidden=true
# Make a ROS map, import it, and look around in it
drawing = np.full((160, 240), 254, np.uint8)  # 254: free floor
cv2.rectangle(drawing, (4, 4), (235, 155), 0, 5)  # 0: walls around
cv2.line(drawing, (4, 90), (235, 90), 0, 5)  # above it rooms, below it a corridor
for x in (80, 160):
    cv2.line(drawing, (x, 4), (x, 90), 0, 5)
for x in (40, 120, 200):
    cv2.line(drawing, (x - 10, 90), (x + 10, 90), 254, 5)  # doors, one metre wide
cv2.circle(drawing, (120, 122), 7, 0, -1)  # a pillar

with tempfile.TemporaryDirectory() as folder:
    cv2.imwrite(str(Path(folder) / "lab.png"), drawing)
    (Path(folder) / "lab.yaml").write_text(
        "image: lab.png\n"
        "resolution: 0.05\n"  # metres per pixel
        "origin: [0.0, 0.0, 0.0]\n"
        "negate: 0\n"
        "occupied_thresh: 0.65\n"
        "free_thresh: 0.196\n"
    )
    lab = Scene(import_ros_map(Path(folder) / "lab.yaml"))

pose = np.array([2.0, 1.6, 0.25])
show(
    side_by_side(
        [
            cv2.resize(cv2.cvtColor(drawing, cv2.COLOR_GRAY2RGB), (300, 200)),
            plan_with(lab, [pose], size=(300, 200)),
            photo(lab, pose, 300),
        ],
        ["the image that ROS saved", "as a world", "what a camera sees in it"],
    )
)

# %% [markdown]
# `python3 start.py demo --map my_map.yaml` drives in your map, and `python3 start.py demo --seed 7` in another flat.
#
# ## What you'll build
#
# | | what your robot can't do yet | what you write |
# |---|---|---|
# | 01 world_and_car | see and move | frames, the car's motion, a ray, a column of the image |
# | 02 local_control | reach a target in sight | a controller that drives to an image |
# | 03 reachability | say "I won't make that" | a network that predicts whether the robot arrives |
# | 04 sparsification | follow a recorded drive | the choice of the images worth keeping |
# | 05 map_building | go where nobody has driven it | the graph built from many drives |
# | 06 probabilistic_planning | get home | the most probable path, and when to refuse |
# | 07 aliasing | tell twin rooms apart | a belief over the places of the map |
# | 08 lifelong_maps | cope with a closed door | a map that mends itself |
# | 09 ghost_nodes | search a flat that's new to it | nodes where nobody has been |
# | 10 ten_visits | keep its map while its odometry drifts | the match between two laser scans |
#
# **After this notebook you can**
#
# - say what a camera tells a robot about its position, and what it doesn't;
# - say why one image may not be enough, and why odometry helps only for a few metres;
# - say what a topological map stores.
#
# And your robot? The magic's gone. It stands in its corner with a camera, four wheels and not one line of your code. In [notebook 01](01_world_and_car.ipynb) you'll find out what it sees and how it moves. The course's main idea comes from X. Meng, N. Ratliff, Y. Xiang and D. Fox, [*Scaling Local Control to Large-Scale Topological Navigation*](https://arxiv.org/abs/1909.12329), ICRA 2020.
