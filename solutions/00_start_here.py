# %% [markdown]
# # 00 · Start here
#
# **Ten minutes. There is no code to write.** Click into the first cell and press *Shift + Enter*,
# again and again, down to the end. The code is folded away; click the three dots to read it.
#
# **After this notebook you will**
#
# - know that your computer has what the course needs;
# - have driven a small robot car yourself;
# - be able to say what a camera alone tells a robot about its position, and what it does not;
# - know what you will build in the notebooks that follow.
#
# **You need** some Python: functions, loops, and a little `numpy`. You need no robot and no
# graphics card.

# %% [markdown]
# ## Check your installation
#
# The cell below checks your installation. If something is missing, it prints what to do.

# %%
from tutorial_lib.checks.nb00 import check_environment

ready = check_environment()
# %% hidden=true
# Import what the cells below need
import tempfile
from pathlib import Path

import cv2
import numpy as np

from tutorial_lib.driving import GridPaths, OraclePolicy
from tutorial_lib.experiments.demos import choose_places, navigate_once, place_people
from tutorial_lib.geometry import arc_length, compose
from tutorial_lib.learning import use_threads
from tutorial_lib.viz import (
    PlanView,
    TeleopController,
    camera_picture,
    chart,
    colours,
    draw_field_of_view,
    faded,
    from_figure,
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

# %% [markdown]
# ## One place, seen twice
#
# Here is an apartment from above, and a robot in it: the blue arrow. Its camera has a field of view
# of 120 degrees. The floor that the camera can see is yellow.
#
# **Before you run the cell:** the robot stands in the living room, at the lower left of the map,
# and looks to the right. What will be on the left of its image, and what on the right?

# %% hidden=true
# Draw an apartment from above, and what its robot sees
home = Scene(generate("apartment", seed=2))
pose = np.array([-4.5, -11.6, 0.2])  # x and y in metres, heading in radians: 0 is to the right
camera = Camera(rows=64, columns=192)


def map_with_camera(scene, pose, width=320, height=420):
    """The map with the robot and its field of view, and the robot's camera image."""
    view = PlanView(scene, width, height)
    above = view.base.copy()
    draw_field_of_view(view, above, scene, pose)
    view.arrow(above, pose)
    images, _ = camera.look(scene, pose[None])  # one pose in, one image out
    return above, camera_picture(images[0], 480, smooth=True)


above, seen = map_with_camera(home, pose)
show(side_by_side([above, seen], ["what we see: the map", "what the robot sees: an image"]))

# %% [markdown]
# The map shows where everything is, in metres. **The robot does not have it.** It gets only the
# image on the right.
#
# The image says: *something green and blue is close on my left, and I can drive past it.* It does
# not say *you are in the living room at (-4.5, -11.6)*. To navigate to the place shown in an image,
# with nothing but such images, is called **image-goal navigation**. It is the problem of this
# course.

# %% [markdown]
# ## Two places that look alike
#
# The next building is an office. It repeats one piece of corridor with its rooms, as real offices
# often do. Two robots stand in two of its rooms, more than twelve metres apart. The
# blue one is in room A, the orange one in room B.
#
# **Before you run the cell:** in how many of their 12,288 pixels will the two images differ?

# %% hidden=true
# Draw two rooms of an office, and what a robot sees in each
office = Scene(generate("symmetric_office", seed=3))
offices = [room for room in office.plan.rooms if room.kind == "office"]
middle_a, middle_b = (np.mean(offices[i].outline, axis=0) for i in (0, 6))
pose_a, pose_b = np.array([*middle_a, 2.0]), np.array([*middle_b, 2.0])

(image_a, image_b), _ = camera.look(office, np.array([pose_a, pose_b]))
view = PlanView(office, 420, 420)
above = view.base.copy()
for pose, colour in ((pose_a, colours.ROBOT), (pose_b, colours.LASER)):
    draw_field_of_view(view, above, office, pose)
    view.arrow(above, pose, colour)
pictures = stacked(
    [camera_picture(image, 420, smooth=True) for image in (image_a, image_b)],
    ["room A (blue)", "room B (orange)"],
)
differ = (image_a != image_b).any(axis=-1)
print(f"{np.linalg.norm(pose_a - pose_b):.1f} metres apart")
print(f"{differ.sum()} of {differ.size:,} pixels differ")
show(side_by_side([above, pictures], ["the office", "what the two robots see"]))

# %% [markdown]
# None. The two images are the same, pixel by pixel. **No method, however clever, can tell these two
# places apart from one image.** This is called **perceptual aliasing**.
#
# It is a danger to every map made of images: the map may connect two places that are not the same.
# A robot that trusts such a connection plans to drive through a wall. What helps is memory: the
# robot entered the room from *somewhere*, and the corridor outside may be different. Several
# notebooks return to this.

# %% [markdown]
# ## Why not just count the turns of the wheels?
#
# A car can measure how far its wheels have turned. Add up these small motions, and you get an
# estimate of where the car is. This is **odometry**.
#
# In the next cell 30 cars drive the **same** path through the apartment: there, back, and there
# again. Each has its own measurement errors: 5 % in distance, 5 % in turning, and a small drift of
# the heading.
#
# **Before you run the cell** (about 5 s): after forty metres, how large will a car's position error be?

# %% hidden=true
# Let 30 cars drive the same path, each with its own odometry
paths = GridPaths(home.clearance)  # shortest paths through the free space
start, goal, _, _ = choose_places(home, paths, np.random.default_rng(1))
stops = [goal, start[:2], goal]

leader, actions = Simulation(home, start), []
for stop in stops:  # one car drives there, back and there again; its actions are recorded
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
driven, estimated = np.array(driven), np.array(estimated)
metres = arc_length(driven)
print(f"{metres[-1]:.0f} m driven")

# %% hidden=true
# Draw where the cars are, where their odometry puts them, and how the error grows
view = PlanView(home, 320, 420)
above = faded(view.base)
for i in range(30):
    view.polyline(above, compose(start, estimated[:, i])[:, :2], colours.BELIEVED, 1)
view.polyline(above, driven, colours.TRACK, 4)
view.points(above, compose(start, estimated[-1])[:, :2], colours.BELIEVED, 4)
view.points(above, driven[-1:], colours.ROBOT, 7)

figure, (axes,) = chart(5, 4.4)
errors = np.linalg.norm(compose(start, estimated)[..., :2] - driven[:, None], axis=-1)
axes.plot(metres, errors, color=colours.unit(colours.BELIEVED), linewidth=1, alpha=0.35)
axes.plot(
    metres, np.median(errors, axis=1), color=colours.unit(colours.INK), label="median of 30 cars"
)
axes.set(xlabel="metres driven", ylabel="position error of the odometry, metres")
axes.legend(frameon=False)
show(
    side_by_side([above, from_figure(figure)], ["driven: blue; odometry: black", "the error grows"])
)

# %% [markdown]
# The blue dot is where all 30 cars are. The black dots are where their odometry puts them. Some of
# the estimated tracks pass through walls.
#
# Did you see the error shrink for a while after each turn, at about 14 and 28 metres? An error in
# the heading pushes the estimate to one side, and on the way back to the other, so some of it
# cancels. But overall the error grows, and nothing that the wheels measure can correct it.
#
# **Odometry is good for a few metres, and of little use for a whole building.** A robot that has to
# remember a building needs something else.

# %% [markdown]
# ## A map without coordinates
#
# The idea of this course is a map that holds no coordinates at all. It is a *graph*:
#
# - a **vertex** is a place, stored as the images that were taken there;
# - an **edge** says: *from here the robot can drive to there by its camera alone*. It carries a
#   probability, since the robot can fail.
#
# To plan is to find the path through this graph that is most likely to succeed. To follow the plan
# is to drive from image to image. Such a map is called a **topological map**.

# %% [markdown]
# ## Drive it yourself
#
# Now you have the camera. Each press of a button drives for half a second; the world waits in
# between. The car steers like a real one: it **cannot turn in place**. Its tightest circle is 1.2 m
# in diameter.
#
# **Try this:** leave the room through its door, with the buttons, or with the arrow keys while the
# pointer is on the picture. Then press *start again* and *hide the map*, and try it once more.

# %% hidden=true
# Drive the car
car = TeleopController(home, start)
teleop(car, rehearsal=["forward"] * 4 + ["left"] * 5)

# %% [markdown]
# Did you get lost without the map? That is the robot's problem. Did you notice what you used?
# Colours, door frames, and *what you saw a moment ago*.

# %% [markdown]
# ## Choose a world
#
# Every world in this course is generated at random, from a *family* and a *seed*. The same two
# always give the same world. That makes results reproducible: a robot can be trained on some seeds
# and tested on others that it has never seen.
#
# **Before you move anything:** which family will be hardest for a robot that navigates by
# camera? Look for places that are alike.


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
# ## Watch a policy that cheats
#
# Before we build a robot that navigates by camera, we need something to compare it with. A
# **policy** decides what a robot does next. The policy in the film **knows the map and the car's
# position**. Such a policy is called an **oracle**: it shows what is possible. It avoids walls and
# people with a laser scanner.
#
# **Before you run the cell** (about 5 s): two people (pink) walk to and fro beside the car's path.
# What will the car do when it meets one: stop, drive around, or back up?

# %% hidden=true
# Film a policy that knows the map
people = place_people(paths.fields(goal).path(start[:2]), home)
simulation = Simulation(home, start, people=people)
oracle, view = OraclePolicy(simulation, paths, [goal]), PlanView(home, 320, 420)
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
print("the film runs four times as fast")
play(frames, 4, times)

# %% [markdown]
# ## Bring your own map
#
# Perhaps you have a real robot that has mapped your laboratory. The Robot Operating System (ROS)
# saves such a map as two files: an image in which dark means *wall*, and a small text file with the
# size of a pixel. The course can read them.
#
# We have no laboratory here, so the cell makes both files itself: three rooms and a corridor, 5 cm
# per pixel. Then it imports them as it would import yours.

# %% hidden=true
# Make a ROS map, import it, and look into it
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

above, seen = map_with_camera(lab, np.array([2.0, 1.6, 0.25]), width=360, height=240)
show(
    side_by_side(
        [cv2.resize(cv2.cvtColor(drawing, cv2.COLOR_GRAY2RGB), (360, 240)), above, seen],
        ["the image that ROS saved", "as a world", "what a camera sees in it"],
    )
)

# %% [markdown]
# A ROS map has no colours, so the walls are painted at random. Everything that follows works in
# such a world too. From the command line: `python3 start.py demo --map my_map.yaml`.

# %% [markdown]
# ## What you will build
#
# | notebook | you write | so that |
# |---|---|---|
# | 00 start_here | nothing | you know what the course is about |
# | 01 world_and_car | frames, the car's motion, a ray, a column of the camera image | you know how the robot's world is simulated |
# | 02 local_control | a controller that drives to the place shown in an image | the robot reaches targets a few metres away |
# | 03 reachability | a network that predicts the probability of reaching a target | the robot knows what it can reach |
# | 04 sparsification | the selection of the few images worth keeping | the memory stays small |
# | 05 map_building | the graph: vertices, edges, pruning | many trajectories become one map |
# | 06 probabilistic_planning | the most likely path, and when to refuse | the robot navigates through a whole building |
# | 07 aliasing | a belief over the places of the map | the robot copes with rooms that look alike |
# | 08 lifelong_maps | a map by sampling, and beliefs about its edges | the map mends itself while the robot uses it |
# | 09 ghost_nodes | a graph with nodes where nobody has been | the robot finds a place in a building it has never seen |
#
# The cells that follow an exercise use what you wrote. Each piece also has a reference
# implementation, so you can go on wherever you get stuck.

# %% [markdown]
# ## Watch what you will build
#
# This is the whole system, with trained networks that come with the course. A car was driven from place to place in this apartment, and a topological map was
# built from its camera images: the coloured arrowheads are the images that were kept, the thin lines are the edges. Now the car is given **one image**, the goal,
# and has to navigate to the place shown in it. It has its camera and its laser, and **neither floor plan nor position**.
#
# Before it starts, it plans a path through the map and predicts the probability that the path succeeds. Then it drives from image to image, past two people who
# were not there when the map was built.
#
# **Before you run the cell** (about 15 s: it records trajectories, learns the map, then drives): what will it do when it meets a person, and its camera sees something that is in none of its images?

# %% hidden=true
# Learn a map of the apartment and navigate by sight
film, outcome = navigate_once(home, seed=2, places=4)
print(f"a map of {outcome.vertices} vertices and {outcome.edges} edges")
print(f"{outcome.geodesic:.0f} m, {outcome.rooms_away} doors: from {' to '.join(outcome.rooms)}")
print(f"predicted probability of success: {outcome.probability:.0%}")
print(f"reached: {outcome.reached}, after {outcome.seconds:.0f} s")
frames = [cv2.resize(film[i], (756, 456)) for i in range(0, len(film), 10)]
play(frames, 5, times=2.0 * np.arange(len(frames)), count=3)  # a frame every 2 s

# %% [markdown]
# To run another one from the command line: `python3 start.py demo --seed 7`. It writes a film, a film strip and the numbers.

# %% [markdown]
# ## In short
#
# - A camera shows what is around the robot, but not where that is.
# - Two places can look exactly alike (perceptual aliasing). One image is then not enough.
# - Odometry is good for metres, not for buildings.
# - A topological map stores images, and the probability of driving from one to the next.
#
# **What to read next:** open [notebook 01](01_world_and_car.ipynb). The main idea of the course comes from X.
# Meng, N. Ratliff, Y. Xiang and D. Fox, [*Scaling Local Control to Large-Scale Topological
# Navigation*](https://arxiv.org/abs/1909.12329), ICRA 2020; its first two pages are a good companion.
