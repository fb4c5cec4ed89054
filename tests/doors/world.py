"""Doors of the world."""

import tempfile
from functools import cache
from pathlib import Path

import numpy as np

from tests.conftest import make_box
from tests.doors.arguments import (
    a,
    choice,
    flag,
    floats,
    images,
    integers,
    number,
    path,
    several,
    text,
    tuples,
    whole,
)
from tests.doors.walk import anything, call, numbers
from tutorial_lib import world
from tutorial_lib.world import (
    bodies,
    floorplan,
    materials,
    noise,
    occupancy,
    placing,
    plan_json,
    simulation,
    worlds,
)
from tutorial_lib.world.generators import area_limits
from tutorial_lib.world.importers import import_houseexpo, import_ros_map, parse_region

POSES = np.array([[2.0, 2.0, 0.5], [6.0, 3.0, -0.5]])
POINTS = POSES[:, :2]
BOX = (0.5, 0.5, 2.0, 2.0)
CIRCLES = np.array([[4.0, 4.0, 0.3], [8.0, 8.0, 0.3]])


@cache
def plan():
    return make_box(pillars=[(5.0, 5.0, 0.5)])


@cache
def scene():
    return world.Scene(plan())


def discs():
    return world.Discs(CIRCLES, np.full(2, -1, np.int32), np.full((2, 3), 99.0, np.float32))


def robots(**options):
    return world.Simulation(scene(), POSES, **options)


def rng():
    return np.random.default_rng(0)


def poses(**changes):
    return floats(POSES, ("N", 3), **changes)


def sights(function, right=anything):
    """A call of a sensor."""
    return call(
        function,
        right,
        scene=a(scene()),
        poses=poses(),
        discs=a(discs(), optional=True),
        viewers=integers(np.arange(2, dtype=np.int32), ("N",), optional=True),
    )


def saved(function):
    """A call that reads the file of a plan."""

    def run(path, **rest):
        with tempfile.TemporaryDirectory() as folder:
            if isinstance(path, str) and path == "plan.json":
                path = Path(folder) / path
                world.save_plan(plan(), path)
            return function(path, **rest)

    return run


GRID = {
    "map.yaml": b"{image: map.pgm, resolution: 0.1, origin: [0, 0, 0], negate: 0, "
    b"occupied_thresh: 0.65, free_thresh: 0.196}",
    "map.pgm": b"P5 40 40 255 " + bytes([254]) * 1600,
}
HOUSE = {"house.json": b'{"verts": [[0, 0], [5, 0], [5, 5], [0, 5]]}'}


def beside(files, function):
    """A call that reads one of some files in a folder."""

    def run(path, **rest):
        with tempfile.TemporaryDirectory() as folder:
            for name, content in files.items():
                (Path(folder) / name).write_bytes(content)
            return function(Path(folder) / path if isinstance(path, str) else path, **rest)

    return run


def written(plan, path):
    """The plan, written into a folder of its own."""
    with tempfile.TemporaryDirectory() as folder:
        world.save_plan(plan, Path(folder) / path if isinstance(path, str) else path)


def names(**more):
    """Arguments that name a world."""
    return {
        "seed": whole(1, least=0, takes="huge"),
        "palette": choice("standard"),
    } | more


def grid():
    return scene().clearance


CAR = ("wheelbase", "length", "width", "max_steering", "steering_rate", "max_speed", "acceleration")
DRIVE = ("radius", "max_speed", "max_turn", "acceleration", "turn_acceleration")
DOORS = {
    # bodies
    "BicycleCar": lambda: call(
        world.BicycleCar,
        **{name: number(getattr(world.BicycleCar, name), above=0) for name in CAR},
        max_reverse=number(0.3, least=0),
    ),
    "DifferentialDrive": lambda: call(
        world.DifferentialDrive,
        **{name: number(getattr(world.DifferentialDrive, name), above=0) for name in DRIVE},
    ),
    "advance": lambda: call(
        bodies.advance,
        numbers,
        poses=floats(POSES, (..., 3)),
        twists=floats(POINTS, (..., 2)),
        seconds=number(0.1, either="negative, several, none"),
    ),
    # floor plans
    "Room.contains": lambda: call(plan().rooms[0].contains, points=floats(POINTS, (..., 2))),
    "FloorPlan": lambda: call(
        floorplan.FloorPlan,
        family=text("box"),
        seed=whole(0, least=0),
        walls=floats(plan().walls, ("W", 4), empty=False),
        wall_materials=several(plan().wall_materials, empty=False),
        wall_offsets=floats(plan().wall_offsets, ("W",)),
        materials=several(plan().materials, empty=False),
        rooms=several(plan().rooms, empty=False),
        doors=several((floorplan.Door((0.0, 1.0), (0.0, 2.0), (0, 0)),)),
        furniture=several(
            (floorplan.Furniture("table", ((1, 1), (2, 1), (2, 2)), "paint"),),
        ),
        look=a(materials.Look()),
    ),
    "Material": lambda: call(
        materials.Material,
        name=text("paint"),
        colour=tuples(integers((1, 2, 3), (3,), least=0, most=255)),
        stripes=several((materials.Stripe(0.0, 1.0, (1, 2, 3)),)),
    ),
    "Look": lambda: call(
        materials.Look,
        palette=choice("standard"),
        floor=tuples(integers((1, 2, 3), (3,), least=0, most=255)),
        ceiling=tuples(integers((1, 2, 3), (3,), least=0, most=255)),
        gamma=number(1.0, least=0.2, most=5.0),
        noise=number(0.0, least=0.0, most=64.0),
    ),
    "Look.tone": lambda: call(materials.Look().tone, colours=floats(np.full((2, 3), 9.0))),
    "texture_atlas": lambda: call(
        materials.texture_atlas,
        materials=several(list(plan().materials), empty=False),
        look=a(materials.Look()),
        seed=whole(0, least=0),
    ),
    "save_plan": lambda: call(written, plan=a(plan()), path=path("plan.json")),
    "load_plan": lambda: call(saved(world.load_plan), anything, path=path("plan.json")),
    "plan_to_json": lambda: call(plan_json.plan_to_json, plan=a(plan())),
    "plan_from_json": lambda: call(
        plan_json.plan_from_json,
        anything,
        text=text(plan_json.plan_to_json(plan()), refuses="text"),
        where=text("JSON text"),
    ),
    "import_map": lambda: call(
        saved(world.import_map),
        anything,
        path=path("plan.json"),
        seed=whole(0, least=0),
        palette=choice("standard"),
    ),
    "parse_region": lambda: call(parse_region, region=text("0,0,1.5,1", refuses="text")),
    "import_ros_map": lambda: call(
        beside(GRID, import_ros_map),
        anything,
        path=path("map.yaml"),
        seed=whole(0, least=0),
        palette=choice("standard"),
        region=floats(BOX, (4,), optional=True, refuses="negative, shorter axis 0"),
    ),
    "import_houseexpo": lambda: call(
        beside(HOUSE, import_houseexpo),
        anything,
        path=path("house.json"),
        seed=whole(0, least=0),
        palette=choice("standard"),
    ),
    # worlds by name
    "generate": lambda: call(
        world.generate,
        anything,
        family=choice("loop_corridor"),
        **names(size=choice("any"), signs=choice("plain")),
    ),
    "area_limits": lambda: call(area_limits, family=choice("maze"), size=choice("any")),
    "world_name": lambda: call(
        world.world_name,
        family=choice("maze"),
        **names(size=choice("any"), signs=choice("plain")),
    ),
    "parse_world": lambda: call(worlds.parse_world, name=choice("maze/1/standard")),
    "scene_of": lambda: call(
        lambda name: world.scene_of(name).plan.seed, name=choice("loop_corridor/1/standard")
    ),
    "families_of": lambda: call(
        worlds.families_of,
        family=choice("maze", takes="empty"),
        usual=("maze",),
    ),
    "local_world": lambda: call(world.local_world, **names(family=choice("maze", takes="empty"))),
    "map_world": lambda: call(world.map_world, **names(family=choice("maze", takes="empty"))),
    "training_world": lambda: call(
        world.training_world,
        seed=whole(1, least=0, most=9_999),
        palette=choice("standard"),
    ),
    "validation_world": lambda: call(worlds.validation_world, seed=whole(1, least=0)),
    "Scene": lambda: call(world.Scene, anything, plan=a(plan())),
    # rays and sensors
    "Fan": lambda: call(
        world.Fan,
        anything,
        angles=floats([-1.0, 0.5], ("R",), empty=False, refuses="huge, bool", takes="bool"),
    ),
    "Discs": lambda: call(
        world.Discs,
        circles=floats(CIRCLES, ("K", 3)),
        owners=integers(np.zeros(2, np.int32), ("K",), refuses="huge", either="negative"),
        colours=floats(np.full((2, 3), 9.0, np.float32), ("K", 3), dtype=np.float32),
    ),
    "Discs.joined": lambda: call(
        world.Discs.joined, anything, parts=several([discs(), discs()], empty=False)
    ),
    "Raycaster": lambda: call(
        world.Raycaster,
        anything,
        segments=floats(plan().segments, ("S", 4), empty=False),
        grid=flag(True, optional=True),
    ),
    "Raycaster.cast": lambda: call(
        scene().caster.cast,
        numbers,
        poses=poses(),
        fan=a(world.Fan([-1.0, 1.0])),
        discs=a(discs(), optional=True),
        viewers=integers(np.arange(2, dtype=np.int32), ("N",), optional=True),
    ),
    "Raycaster.sees": lambda: call(
        scene().caster.sees,
        origins=floats(POINTS, ("N", 2), takes="shorter N"),
        points=floats(POINTS + 1, ("N", 2), takes="shorter N"),
        slack=number(1e-9, least=0),
    ),
    "Camera": lambda: call(
        world.Camera,
        rows=whole(16, least=1),
        columns=whole(64, least=2),
        field_of_view=number(2.0, above=0, most=np.pi),
        slope=number(0.5, above=0),
    ),
    "Camera.look": lambda: sights(world.Camera().look),
    "PanoramicCamera": lambda: call(
        world.PanoramicCamera,
        rows=whole(16, least=1),
        columns=whole(192, least=2),
        patches=whole(12, least=1),
        patch_columns=whole(48, least=1),
        slope=number(0.5, above=0),
    ),
    "PanoramicCamera.look": lambda: sights(world.PanoramicCamera().look),
    "PanoramicCamera.split": lambda: call(
        world.PanoramicCamera().split, image=images(np.zeros((2, 16, 192, 3)), ("N", "H", 192, 3))
    ),
    "Laser": lambda: call(
        world.Laser,
        numbers,
        beams=whole(96, least=1),
        field_of_view=number(2.0, above=0, most=2 * np.pi),
        range=number(10.0, above=0, infinite=True),
    ),
    "Laser.scan": lambda: sights(world.Laser().scan),
    "full_circle": lambda: call(world.full_circle, count=whole(8, least=1)),
    "mutual_overlap": lambda: call(
        world.mutual_overlap,
        caster=a(scene().caster),
        first=floats(POSES, ("N", 3)),
        second=floats(POSES, ("N", 3)),
        field_of_view=number(2.0, above=0, most=2 * np.pi),
        rays=whole(100, least=1),
    ),
    # free space
    "clearance_grid": lambda: call(
        occupancy.clearance_grid, plan=a(plan()), resolution=number(0.05, above=0)
    ),
    "check_closed": lambda: call(
        occupancy.check_closed, plan=a(plan()), resolution=number(0.05, above=0)
    ),
    "ClearanceGrid": lambda: call(
        occupancy.ClearanceGrid,
        clearance=floats(np.ones((3, 4), np.float32), ("H", "W"), dtype=np.float32),
        origin=floats((0.0, 0.0), (2,)),
        resolution=number(0.05, above=0),
    ),
    "ClearanceGrid.cells": lambda: call(grid().cells, points=floats(POINTS, (..., 2))),
    "ClearanceGrid.centres": lambda: call(
        grid().centres, cells=integers([[1, 2], [2, 3]], (..., 2))
    ),
    "ClearanceGrid.at": lambda: call(grid().at, points=floats(POINTS, (..., 2))),
    "cells_to_blocked": lambda: call(
        occupancy.cells_to_blocked, open_cells=images(np.eye(4), ("H", "W"), refuses="empty")
    ),
    "is_free": lambda: call(
        world.is_free, scene=a(scene()), body=a(world.BicycleCar()), poses=poses()
    ),
    "check_free": lambda: call(
        placing.check_free,
        scene=a(scene()),
        body=a(world.BicycleCar()),
        poses=poses(refuses="negative"),
        name="poses",
    ),
    "check_apart": lambda: call(
        placing.check_apart, body=a(world.BicycleCar()), poses=poses(), discs=a(discs())
    ),
    "random_free_poses": lambda: call(
        world.random_free_poses,
        scene=a(scene()),
        body=a(world.BicycleCar()),
        places=floats(POINTS, ("P", 2), empty=False, either="huge", refuses="negative"),
        count=whole(3, least=0, refuses="huge"),
        rng=a(rng()),
    ),
    # motion
    "Person": lambda: call(
        world.Person,
        route=floats(POINTS, ("K", 2), empty=False),
        speed=number(0.5, least=0),
        radius=number(0.2, above=0),
        owner=whole(-1, least=-1),
        colour=tuples(integers((1, 2, 3), (3,), least=0, most=255)),
        distance=number(0.0),
        keep_off=number(1.3, least=0),
    ),
    "WheelOdometry": lambda: call(
        world.WheelOdometry,
        distance=number(0.05, least=0),
        turn=number(0.05, least=0),
        drift=number(0.05, least=0),
    ),
    "WheelOdometry.measure": lambda: call(
        world.WheelOdometry().measure,
        numbers,
        motions=poses(),
        rng=a(rng()),
    ),
    "DriftingOdometry": lambda: call(
        lambda seed, wheels: noise.DriftingOdometry(seed, wheels=wheels),
        anything,
        seed=whole(0, least=0),
        wheels=a(world.WheelOdometry(), optional=True),
    ),
    "scale_controls": lambda: call(
        noise.scale_controls,
        numbers,
        actions=floats(POINTS, ("N", 2)),
        sigma=number(0.1, least=0),
        rng=a(rng()),
    ),
    "Mixture": lambda: call(
        noise.Mixture,
        weights=floats((0.5, 0.5), ("M",), least=0),
        means=floats(POSES, ("M", 3)),
        deviations=floats(np.abs(POSES), ("M", 3), least=0),
    ),
    "DiscreteNoise": lambda: call(
        noise.DiscreteNoise, anything, robots=whole(2, least=0, refuses="huge"), rng=a(rng())
    ),
    "Sensors": lambda: call(
        world.Sensors,
        anything,
        camera=a(world.Camera(), optional=True),
        laser=a(world.Laser()),
        with_depth=flag(False),
    ),
    "Simulation": lambda: call(
        world.Simulation,
        anything,
        scene=a(scene()),
        poses=poses(refuses="negative", takes="fewer axes"),
        body=a(world.BicycleCar(), optional=True),
        people=several([world.Person(CIRCLES[:, :2])]),
        control_noise=number(0.1, least=0),
        odometry_noise=a(world.WheelOdometry(), optional=True),
        sensors=a(world.Sensors(), optional=True),
        rng=a(rng()),
    ),
    "Simulation.step": lambda: call(robots().step, actions=floats(POINTS * 0.1, (2, 2))),
    "Simulation.place": lambda: call(
        robots().place,
        robots=integers([0, 1], ("M",), least=0, most=1, refuses="more axes"),
        poses=floats(POSES[::-1], ("M", 3), refuses="negative"),
    ),
    "Simulation.observe": lambda: call(
        robots().observe,
        robots=integers([0, 1], ("M",), least=0, most=1, optional=True),
    ),
    "checked_actions": lambda: call(
        simulation.checked_actions,
        actions=floats(POINTS, (2, 2)),
        robots=whole(2, least=0, refuses="huge"),
    ),
}
WITHOUT = {
    **dict.fromkeys(
        ("Room", "Door", "Furniture", "Stripe"),
        "parts of a plan or a material, which checks them and says where they are in it",
    ),
    **dict.fromkeys(
        (
            "BicycleCar.respond",
            "BicycleCar.twist",
            "DifferentialDrive.respond",
            "DifferentialDrive.twist",
        ),
        "a simulation calls it in its innermost loop, with what `Simulation.step` checked",
    ),
    "WheelOdometry.read": "what is behind the door `measure`",
}
